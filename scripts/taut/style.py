"""One look for all figures; colors, dashes and markers belong to methods and mean the same everywhere."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

# What double precision leaves of a length of 1 m: two units in the last place.
ROUND_OFF = 4.5e-16
FLOOR = 1e-16

GRAY = "#6b7280"
LIGHT = "#e5e7eb"
DARK = "#374151"
# The colors of Okabe and Ito and two more, for things that are not methods.
COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#7F3C8D", "#8C6D46")

RC: dict[str, Any] = {
    "figure.dpi": 100,
    "savefig.dpi": 200,
    "savefig.facecolor": "white",
    "figure.facecolor": "white",
    "font.family": "STIXGeneral",
    "mathtext.fontset": "stix",
    "font.size": 10,
    "axes.titlesize": 10.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": 10,
    "axes.linewidth": 0.6,
    "axes.edgecolor": "#374151",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": LIGHT,
    "grid.linewidth": 0.6,
    "xtick.labelsize": 9,
    "ytick.labelsize": 9,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "ytick.minor.width": 0.4,
    "legend.fontsize": 9.5,
    "legend.frameon": False,
    "lines.dash_capstyle": "round",
    "lines.solid_capstyle": "round",
    # Text stays text in the PDF, so that it can be searched and edited.
    "pdf.fonttype": 42,
}

# Without dates and versions the same results make the same files.
METADATA: dict[str, dict[str, str | None]] = {
    "pdf": {"CreationDate": None, "Creator": "taut", "Producer": None},
    "png": {"Software": None},
    "svg": {"Date": None, "Creator": "taut"},
}


@dataclass(frozen=True)
class MethodStyle:
    """How a method is drawn: the colors are Okabe and Ito's; dashes and markers tell them apart in gray."""

    label: str
    color: str
    dashes: Any
    marker: str
    width: float = 1.2
    # Later ones lie on top: a thick solid line goes below thin dashed ones, so that none hides another.
    layer: int = 3

    def line(self, points: int) -> dict[str, Any]:
        """Returns the keywords of a line of so many points, with some ten markers on it."""
        # Methods start their markers at different points, so that they do not hide one another.
        every = max(points // 9, 1)
        return {
            "color": self.color,
            "linestyle": self.dashes,
            "linewidth": self.width,
            "zorder": self.layer,
            "marker": self.marker,
            "markersize": 4.2,
            "markerfacecolor": "white",
            "markeredgewidth": 0.9,
            "markevery": (min(self.layer * every // 8, max(points - 1, 0)), every),
        }


METHODS: dict[str, MethodStyle] = {
    "baseline": MethodStyle("baseline", "#000000", (0, (5, 2)), "o", layer=4),
    "baumgarte": MethodStyle("Baumgarte (2, 2)", "#D55E00", (0, (6, 1.5, 1, 1.5)), "^", layer=5),
    "braun-goldfarb": MethodStyle("Braun–Goldfarb", "#009E73", (0, (1.2, 1.4)), "s", layer=6),
    "present-position": MethodStyle("present, position only", "#CC79A7", (0, (3, 1)), "v", 1.6, layer=3),
    "present": MethodStyle("present", "#0072B2", "solid", "D", 2.0, layer=2),
    "penalty": MethodStyle("penalty", "#E69F00", (0, (4, 1, 1, 1, 1, 1)), "P", layer=7),
    "yu-chen": MethodStyle("Yu–Chen", "#56B4E9", (0, (8, 2)), "X", layer=7),
    "coordinate-projection": MethodStyle(
        "coordinate projection", "#7F3C8D", (0, (2, 1, 6, 1)), "h", 1.4, layer=3
    ),
}


def method_style(method: str) -> MethodStyle:
    """Returns the style of a method; a label such as 'penalty-1e4' takes that of its method."""
    names = [name for name in METHODS if method == name or method.startswith(name + "-")]
    if not names:
        return MethodStyle(method, GRAY, (0, (2, 2)), "x")
    return METHODS[max(names, key=len)]


def use() -> None:
    """Makes this look matplotlib's."""
    mpl.use("Agg")
    mpl.rcParams.update(mpl.rcParamsDefault)
    mpl.use("Agg")
    mpl.rcParams.update(RC)


def save(figure: Figure, path: Path, **keywords: Any) -> None:
    """Writes a figure in the format of its file's name, or in a given one, and closes it."""
    kind = keywords.get("format", path.suffix[1:])
    figure.savefig(path, metadata=METADATA.get(kind), **keywords)
    plt.close(figure)


def round_off_band(axes: Axes, bottom: float) -> None:
    """Marks what is below round-off; values there, zero among them, are drawn on its floor."""
    axes.axhspan(bottom, ROUND_OFF, color="#f3f4f6", zorder=0, linewidth=0)
    axes.axhline(FLOOR, color=GRAY, linewidth=0.6, linestyle=(0, (1, 2)), zorder=1)
    axes.annotate(
        "round-off",
        (0.0, (bottom * FLOOR) ** 0.5),
        xycoords=("axes fraction", "data"),
        xytext=(6, 0),
        textcoords="offset points",
        ha="left",
        va="center",
        fontsize=8.5,
        color=GRAY,
        fontstyle="italic",
    )


def spread(values: list[float], gap: float, limits: tuple[float, float]) -> list[float]:
    """Returns heights near the values, at least a gap apart and inside the limits."""
    order = sorted(range(len(values)), key=values.__getitem__)
    heights = [min(max(values[i], limits[0]), limits[1]) for i in order]
    # Pushing neighbors apart by half of what is missing converges quickly for a handful of labels.
    for _ in range(200):
        for low, high in zip(range(len(heights) - 1), range(1, len(heights)), strict=True):
            missing = gap - (heights[high] - heights[low])
            if missing > 0:
                heights[low] -= missing / 2
                heights[high] += missing / 2
    placed = [0.0] * len(values)
    for rank, index in enumerate(order):
        placed[index] = heights[rank]
    return placed
