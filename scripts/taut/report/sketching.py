"""What drawings of the problems have in common: notes and dimensions."""

from matplotlib.axes import Axes

from taut import style
from taut.results import Array

_DIMENSION = {"arrowstyle": "<->", "color": style.GRAY, "linewidth": 0.7, "shrinkA": 0, "shrinkB": 0}


def note(
    axes: Axes,
    text: str,
    at: Array | tuple[float, float],
    offset: tuple[float, float],
    bold: bool = False,
    ha: str = "left",
) -> None:
    """Writes beside a point."""
    axes.annotate(
        text,
        tuple(at),
        xytext=offset,
        textcoords="offset points",
        fontsize=10 if bold else 9,
        fontweight="bold" if bold else "normal",
        color="black" if bold else style.GRAY,
        ha=ha,
        zorder=10,
    )


def dimension(
    axes: Axes, start: tuple[float, float], end: tuple[float, float], text: str, offset: tuple[float, float]
) -> None:
    """Draws a dimension between two points."""
    axes.annotate("", end, start, arrowprops=_DIMENSION)
    middle = (start[0] + end[0]) / 2, (start[1] + end[1]) / 2
    axes.annotate(
        text,
        middle,
        xytext=offset,
        textcoords="offset points",
        fontsize=9,
        color=style.GRAY,
        ha="center",
        va="center",
    )
