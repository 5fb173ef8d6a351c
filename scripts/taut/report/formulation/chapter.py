"""The chapter of the formulation itself: statements that hold for any problem, on the shipped ones."""

from taut.report.document import Chapter
from taut.report.formulation.claims import CLAIMS, DRIVEN, REDUNDANT, ROLLING
from taut.report.judgment import judged
from taut.results import Results

CASES = (REDUNDANT, ROLLING, DRIVEN)


def build(results: Results) -> Chapter:
    """Returns the chapter."""
    return Chapter("The formulation", "Sects 2 and 3", judged(CLAIMS, results), ())
