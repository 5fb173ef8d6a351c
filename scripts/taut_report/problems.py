"""The problems of the paper, in its order; a further one plugs in here with its figures and its chapter."""

from collections.abc import Callable

from taut_report import helicopter, helicopter_chapter, pendulum, pendulum_chapter
from taut_report.data import Results
from taut_report.document import Chapter
from taut_report.drawing import Spec

FIGURES: tuple[Spec, ...] = (*pendulum.FIGURES, *helicopter.FIGURES)
CHAPTERS: tuple[Callable[[Results], Chapter], ...] = (pendulum_chapter.build, helicopter_chapter.build)
