"""Shared by all claims: the rule of the verdicts, tolerances, error tests and what counts as 'about'.

A statement is held against runs at the paper's own settings and at strict ones (an honest error test, a
strict tolerance, no cap on the step). It is reproduced if it is met at all of them, and under a condition if
at some: the condition is computed, for it is the settings at which it is met. Processor times count as ratios
only.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from taut.report.document import Claim, Held
from taut.results import Results, recording

LOOSE, TIGHT = "figure1", "figure2"
SIGNED = "with the signed error test of 2009 (option `odepkg-2009`)"
HONEST = "with an honest error test"
# 'About 200' and 'nearly twice' leave room; a tenth is what two digits of the paper can mean.
ABOUT = 0.10
NEWTON_TOLERANCE = 1e-12
# An energy error that grows or shrinks by less than this factor is 'not significantly affected' ...
SIMILAR = 3.0
# ... and one that shrinks by more than this 'essentially vanishes'.
VANISHES = 1e-3


@dataclass(frozen=True)
class Row:
    """A statement to be judged: how, the figure it is read from, the cases and the examples that it needs."""

    judge: Callable[[Results], Claim]
    figure: str = ""
    cases: tuple[str, ...] = ()
    prints: tuple[str, ...] = ()


def judged(rows: Sequence[Row], results: Results) -> tuple[Claim, ...]:
    """Returns the statements whose cases have been run, each with the files that its numbers come from."""
    claims = []
    for row in rows:
        if all(map(results.has, row.cases)) and all(map(results.has_printed, row.prints)):
            with recording() as files:
                claim = row.judge(results)
            claims.append(replace(claim, figure=row.figure, files=tuple(sorted(files))))
    return tuple(claims)


def once(met: bool) -> tuple[Held, ...]:
    """A statement to which settings do not matter."""
    return (Held("", met),)


def signed_and_honest(signed: bool, honest: bool) -> dict[str, tuple[Held, ...]]:
    """A statement under the error test of the paper's program, and under an honest one."""
    return {"at_paper": (Held(SIGNED, signed),), "strict": (Held(HONEST, honest),)}


def paper_and_strict(paper: bool, strict: bool) -> dict[str, tuple[Held, ...]]:
    """A statement at the paper's tolerance, and at a strict one."""
    return {
        "at_paper": (Held("at the paper’s tolerance", paper),),
        "strict": (Held("at a strict tolerance", strict),),
    }
