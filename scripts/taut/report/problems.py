"""The problems of the paper, in its order; a further one plugs in here with its figures and its chapter."""

from collections.abc import Callable
from dataclasses import dataclass

from taut.errors import TautError
from taut.report.document import Chapter
from taut.report.drawing import Spec
from taut.report.formulation import chapter as formulation
from taut.report.helicopter import chapter as helicopter_chapter
from taut.report.helicopter import figures as helicopter
from taut.report.methods import chapter as methods_chapter
from taut.report.methods import figures as methods
from taut.report.pendulum import chapter as pendulum_chapter
from taut.report.pendulum import figures as pendulum
from taut.report.swing import chapter as swing_chapter
from taut.report.swing import figures as swing
from taut.results import Results


@dataclass(frozen=True)
class Problem:
    """A problem of the paper: its chapter is left out as long as cases that it needs have not been run."""

    title: str
    figures: tuple[Spec, ...]
    build: Callable[[Results], Chapter]
    cases: tuple[str, ...]
    # Whether the chapter can do with any of the cases.
    any_will_do: bool = False

    def missing(self, results: Results) -> tuple[str, ...]:
        """Returns the cases for want of which the chapter is left out."""
        lacking = tuple(case for case in self.cases if not results.has(case))
        return () if self.any_will_do and len(lacking) < len(self.cases) else lacking


PROBLEMS = (
    Problem("The formulation", (), formulation.build, formulation.CASES, any_will_do=True),
    Problem("Simple pendulum", pendulum.FIGURES, pendulum_chapter.build, pendulum_chapter.CASES),
    Problem("Swing", swing.FIGURES, swing_chapter.build, swing_chapter.CASES, any_will_do=True),
    Problem("Helicopter blade", helicopter.FIGURES, helicopter_chapter.build, helicopter_chapter.CASES),
    Problem("The methods side by side", methods.FIGURES, methods_chapter.build, methods_chapter.CASES),
)
FIGURES: tuple[Spec, ...] = tuple(figure for problem in PROBLEMS for figure in problem.figures)


def with_results(results: Results) -> tuple[Problem, ...]:
    """Returns the problems that have been run; there must be one."""
    found = tuple(problem for problem in PROBLEMS if not problem.missing(results))
    if not found:
        raise TautError(f"{results.root} has no complete set of results: run scripts/reproduce first")
    return found


def drawable(results: Results) -> tuple[Spec, ...]:
    """Returns the figures that can be drawn; there must be one."""
    problems = [problem for problem in PROBLEMS if any(map(results.has, problem.cases))]
    found = tuple(figure for problem in problems for figure in problem.figures if figure.can_draw(results))
    if not found:
        raise TautError(f"{results.root} has no results: run scripts/reproduce first")
    return found
