"""Shared by all claims: the tolerances, the error tests and what counts as 'about'."""

from taut.report.document import Verdict

LOOSE, TIGHT = "figure1", "figure2"
SIGNED = "with the signed error test of 2009 (option `odepkg-2009`)"
# 'About 200' and 'nearly twice' leave room; a tenth is what two digits of the paper can mean.
ABOUT = 0.10
NEWTON_TOLERANCE = 1e-12
# An energy error that grows or shrinks by less than this factor is 'not significantly affected' ...
SIMILAR = 3.0
# ... and one that shrinks by more than this 'essentially vanishes'.
VANISHES = 1e-3


def either(signed: bool, honest: bool) -> tuple[Verdict, str]:
    """Returns the verdict on a claim that is met or not under either error test, with the condition."""
    if signed and honest:
        return Verdict.YES, ""
    if signed:
        return Verdict.CONDITION, SIGNED
    if honest:
        return Verdict.CONDITION, "with an honest error test only"
    return Verdict.NO, ""


def verdict(met: bool, because: str) -> tuple[Verdict, str]:
    """Returns the verdict on a claim that is met or not, with the reason if not."""
    return (Verdict.YES, "") if met else (Verdict.NO, because)
