"""The paper's Figure 3: the swing, drawn from its dimensions, with its load; and how a swing is drawn."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Polygon

from taut import style
from taut.report.sketching import dimension, note
from taut.report.swing.measures import (
    BEAM,
    FORCE,
    LINKS,
    MARKERS,
    PULSE,
    RISE,
    START,
    SUPPORTS,
    links,
)
from taut.results import Array, Results

BODY, LINK, LOAD, DARK = "#0072B2", "#6b7280", "#D55E00", "#374151"
# One color a marker; their shapes tell them apart in gray.
COLORS = dict(zip(MARKERS, ("#D55E00", "#E69F00", "#000000", "#009E73", "#CC79A7"), strict=True))
SHAPES = dict(zip(MARKERS, "osDv^", strict=True))


class Swing:
    """A swing in a panel; `move` puts it where it is at a time."""

    def __init__(self, axes: Axes, alpha: float = 1.0, markers: bool = True) -> None:
        """Draws what moves and what does not."""
        keywords = {"solid_capstyle": "round", "alpha": alpha}
        self.links = [axes.plot([], [], color=LINK, linewidth=1.6, zorder=5, **keywords)[0] for _ in range(2)]
        (self.beam,) = axes.plot([], [], color=BODY, linewidth=2.4, zorder=6, **keywords)
        self.markers = [
            axes.plot(
                [],
                [],
                color=COLORS[m],
                marker=SHAPES[m],
                markersize=10 if m == "C" else 6,
                markeredgecolor="white",
                markeredgewidth=0.8,
                zorder=8,
                alpha=alpha,
            )[0]
            for m in MARKERS * markers
        ]
        axes.set_aspect("equal")

    def move(self, points: Array) -> None:
        """Moves the beam, drawn as a smooth curve through its markers, and the links."""
        for line, ends in zip(self.links, links(points), strict=True):
            line.set_data(*ends.T)
        self.beam.set_data(*smooth(points).T)
        for line, point in zip(self.markers, points, strict=False):
            line.set_data(*point[:, None])


def smooth(points: Array) -> Array:
    """Returns the polynomial through the markers, which are at equal distances along the beam."""
    nodes, fine = np.linspace(-1, 1, len(points)), np.linspace(-1, 1, 81)
    return np.stack([np.polyval(np.polyfit(nodes, points[:, i], len(points) - 1), fine) for i in (0, 1)], -1)


def ground(axes: Axes, point: Array, size: float = 0.028) -> None:
    """Draws a pin on the ground that hangs from above."""
    x, y = point
    axes.add_patch(
        Polygon(
            [[x, y], [x - size, y + 1.5 * size], [x + size, y + 1.5 * size]],
            facecolor="white",
            edgecolor=DARK,
            linewidth=1.0,
            zorder=4,
        )
    )
    axes.plot([x - 1.8 * size, x + 1.8 * size], [y + 1.5 * size] * 2, color=DARK, linewidth=1.2, zorder=4)
    for i in range(6):
        at = x + size * (-1.6 + 0.65 * i)
        axes.plot(
            [at, at + 0.5 * size], [y + 1.5 * size, y + 2.1 * size], color=DARK, linewidth=0.7, zorder=4
        )
    axes.plot(x, y, marker="o", markersize=4.5, color=DARK, markeredgecolor="white", zorder=9)


def figure3(_: Results) -> Figure:
    """Draws the swing at rest and the force over time."""
    figure = plt.figure(figsize=(8.0, 2.9), layout="constrained")
    grid = figure.add_gridspec(1, 2, width_ratios=(2.5, 1.0))
    axes = figure.add_subplot(grid[0, 0])
    at_rest(axes)
    load(figure.add_subplot(grid[0, 1]))
    return figure


def at_rest(axes: Axes) -> None:
    """Draws the swing with its dimensions."""
    Swing(axes).move(START)
    for support in SUPPORTS:
        ground(axes, support)
    for m, point in zip(MARKERS, START, strict=True):
        note(axes, m, point, (7, -4) if m == "E" else (5, 7), bold=True)
    middle = START[2]
    axes.annotate(
        "",
        middle + (0.13, 0),
        middle,
        arrowprops={"arrowstyle": "-|>", "color": LOAD, "linewidth": 2.0, "shrinkA": 7},
        zorder=9,
    )
    axes.annotate("$F(t)$", middle + (0.11, 0), xytext=(0, 8), textcoords="offset points", color=LOAD)
    note(axes, "0.5 kg", middle, (0, -18), ha="center")
    dimension(axes, (0, -0.115), (BEAM, -0.115), f"beam {BEAM:g} m, section 1 × 5 mm²", (0, -9))
    dimension(axes, (-0.075, 0), (-0.075, LINKS[0]), f"{LINKS[0]:g} m", (-22, 0))
    middle = (START[-1] + SUPPORTS[1]) / 2
    note(axes, rf"${LINKS[0]:g}\sqrt{{2}}$ m", middle, (10, -10))
    for end in START[[0, -1]]:
        axes.plot([end[0]] * 2, [-0.13, -0.02], color=style.GRAY, linewidth=0.5, zorder=0)
    axes.plot([BEAM, BEAM], [0.02, 0.2], color=style.GRAY, linewidth=0.7, linestyle=(0, (4, 3)), zorder=0)
    axes.add_patch(Arc(START[-1], 0.28, 0.28, theta1=45, theta2=90, color=style.GRAY, linewidth=0.8))
    note(axes, "45°", START[-1] + (0.03, 0.145), (0, 0))
    note(axes, "link 1", (START[0] + SUPPORTS[0]) / 2, (5, 0))
    note(axes, "link 2", START[-1] + 0.72 * (SUPPORTS[1] - START[-1]), (-36, 6))
    # Axes of coordinates; there is no gravity.
    for text, tip, offset in (("x", (0.1, 0.0), (4, -3)), ("y", (0.0, 0.1), (5, 0))):
        origin = np.array([0.2, 0.2])
        axes.annotate(
            "", origin + tip, origin, arrowprops={"arrowstyle": "-|>", "color": style.GRAY, "linewidth": 0.9}
        )
        note(axes, f"${text}$", origin + tip, offset)
    note(axes, "no gravity; axes as drawn, origin at A", (0.2, 0.2), (-8, -12))
    axes.axis("off")
    axes.margins(0.04)
    axes.set_title("At rest")


def load(axes: Axes) -> None:
    """Draws the force on C over time."""
    axes.plot([0, RISE, PULSE, 0.4], [0, FORCE, 0, 0], color=LOAD, linewidth=2.0)
    axes.set(
        title="Force on C, along x",
        xlabel="time [s]",
        ylabel="$F$ [N]",
        xlim=(0, 0.4),
        ylim=(0, 1.12 * FORCE),
        xticks=(0, RISE, PULSE, 0.4),
    )
