"""A figure as data: what it is drawn from, how, and where its files are."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import matplotlib.pyplot as plt
from matplotlib.figure import Figure

from taut_report import style
from taut_report.data import Results

# Without dates and versions the same results make the same files.
_METADATA = {"pdf": {"CreationDate": None, "Creator": "taut", "Producer": None}, "png": {"Software": None}}


@dataclass(frozen=True)
class FigureSpec:
    """A figure, the cases that it is drawn from and the function that draws it."""

    name: str
    title: str
    cases: tuple[str, ...]
    draw: Callable[[Results], Figure]

    def path(self, results: Results, kind: str = "png") -> Path:
        """Returns the file of the figure, kind 'png' or 'pdf'."""
        return results.root / "figures" / f"{self.name}.{kind}"

    def save(self, results: Results) -> list[Path]:
        """Draws the figure and writes its files."""
        style.use()
        figure = self.draw(results)
        paths = [self.path(results, kind) for kind in _METADATA]
        for path in paths:
            path.parent.mkdir(parents=True, exist_ok=True)
            figure.savefig(path, metadata=_METADATA[path.suffix[1:]])
        plt.close(figure)
        return paths

    def save_if_stale(self, results: Results) -> None:
        """Draws the figure when a file is missing or older than what it is drawn from."""
        sources = [path for case in self.cases for path in results.case(case).folder.glob("*.csv")]
        newest = max(path.stat().st_mtime for path in sources)
        paths = [self.path(results, kind) for kind in _METADATA]
        if not all(path.exists() and path.stat().st_mtime >= newest for path in paths):
            self.save(results)
