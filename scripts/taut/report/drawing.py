"""A figure or an animation as data: what it is drawn from, how, and where its files are."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar

from matplotlib.figure import Figure

from taut import style
from taut.gif import write_gif
from taut.results import Results


@dataclass(frozen=True)
class Spec:
    """What figures and animations have in common."""

    name: str
    title: str
    cases: tuple[str, ...]
    # Files that are not results.
    files: tuple[Path, ...] = field(default=(), kw_only=True)
    kinds: ClassVar[tuple[str, ...]]

    def can_draw(self, results: Results) -> bool:
        """Returns whether the cases have been run."""
        return all(results.has(case) for case in self.cases)

    def path(self, results: Results, kind: str = "") -> Path:
        """Returns the file of a kind, that for the report if none is given."""
        return results.root / "figures" / f"{self.name}.{kind or self.kinds[-1]}"

    def save(self, results: Results) -> list[Path]:
        """Draws and writes the files."""
        style.use()
        paths = [self.path(results, kind) for kind in self.kinds]
        paths[0].parent.mkdir(parents=True, exist_ok=True)
        self.write(results, paths)
        return paths

    def write(self, results: Results, paths: list[Path]) -> None:
        """Writes the files, one for each kind."""
        raise NotImplementedError

    def save_if_stale(self, results: Results) -> None:
        """Draws when a file is missing or older than what it is drawn from."""
        sources = [path for case in self.cases for path in results.case(case).folder.glob("*.csv")]
        newest = max((path.stat().st_mtime for path in (*sources, *self.files)), default=0.0)
        paths = [self.path(results, kind) for kind in self.kinds]
        if not all(path.exists() and path.stat().st_mtime >= newest for path in paths):
            self.save(results)


@dataclass(frozen=True)
class FigureSpec(Spec):
    """A figure, the cases that it is drawn from and the function that draws it."""

    draw: Callable[[Results], Figure]
    kinds: ClassVar[tuple[str, ...]] = ("pdf", "png")

    def write(self, results: Results, paths: list[Path]) -> None:
        """Writes the figure in every format."""
        figure = self.draw(results)
        for path in paths:
            style.save(figure, path)


@dataclass(frozen=True)
class AnimationSpec(Spec):
    """An animation, its cases and the function that yields its frames, which are one figure for all."""

    frames: Callable[[Results], Iterator[Figure]]
    milliseconds: int = 60
    kinds: ClassVar[tuple[str, ...]] = ("gif",)

    def write(self, results: Results, paths: list[Path]) -> None:
        """Writes the frames as a GIF that starts over at its end."""
        write_gif(self.frames(results), paths[0], self.milliseconds)
