"""The paper's Figure 9: the blade root and its pitch link, drawn from the model's own dimensions."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon

from taut import style
from taut.report.helicopter.measures import Model, point_a, point_b
from taut.report.sketching import dimension, note
from taut.results import Array, Results
from taut.view import View

BLADE, HORN, LINK, PLATE, HUB = "#9db8d2", "#0072B2", "#D55E00", "#d8dce2", "#374151"
# How far the blade is drawn from the axis of rotation, and where its chord begins [m].
TIP, ROOT = 0.62, 0.33
# Where the blade's edges are, across [m].
EDGES = (-0.10, 0.05)


def view(points: Array, turn: float = -62.0, height: float = 24.0) -> Array:
    """Returns the picture of points in space seen from afar, from a direction given in degrees."""
    return View.around(np.array([0.0, 0.0, 1.0]), turn, height).flat(np.asarray(points))


def blade_point(model: Model, beta: float, theta: float, along: float, across: float) -> Array:
    """Returns a point of the blade, given from the flap hinge along and across, as in Eq. (28)."""
    return point_a(model | {"x_theta": along, "y_theta": across}, np.float64(beta), np.float64(theta))


class Root:
    """The blade root in space; `move` puts it where it is at a time."""

    def __init__(self, axes: Axes, model: Model) -> None:
        """Draws what moves and what does not."""
        self.model = model
        self.plate = axes.add_patch(
            Polygon([[0, 0]], facecolor=PLATE, edgecolor=style.GRAY, linewidth=0.8, zorder=1)
        )
        x = model["x_beta"]
        self._line(axes, [[0, 0, model["z_b"] - 0.08], [0, 0, 0.09]], color=HUB, linewidth=5, zorder=2)
        self._line(axes, [[0, 0, 0], [x, 0, 0]], color=HUB, linewidth=5, zorder=3)
        self._line(axes, [[x, -0.035, 0], [x, 0.035, 0]], color="black", linewidth=8, zorder=5)
        self.blade = axes.add_patch(
            Polygon([[0, 0]], facecolor=BLADE, edgecolor="#4b6a88", linewidth=0.9, alpha=0.92, zorder=4)
        )
        keywords = {
            "solid_capstyle": "round",
            "marker": "o",
            "markeredgecolor": "white",
            "markeredgewidth": 0.8,
        }
        (self.spar,) = axes.plot([], [], color="#4b6a88", linewidth=4, zorder=4.5)
        (self.horn,) = axes.plot([], [], color=HORN, linewidth=3.2, zorder=6, **keywords | {"marker": ""})
        (self.link,) = axes.plot([], [], color=LINK, linewidth=2.6, zorder=7, markersize=7, **keywords)
        axes.set_aspect("equal")
        axes.axis("off")

    @staticmethod
    def _line(axes: Axes, points: list[list[float]], **keywords: object) -> None:
        axes.plot(*view(np.array(points)).T, solid_capstyle="round", **keywords)

    def move(self, beta: float, theta: float, t: float) -> dict[str, Array]:
        """Moves the blade and returns where the named points are in the picture."""
        m = self.model
        a = point_a(m, np.float64(beta), np.float64(theta))
        b = point_b(m, np.float64(t))
        corners = [(ROOT - m["x_beta"], EDGES[0]), (TIP - m["x_beta"], EDGES[0])]
        corners += [(TIP - m["x_beta"], EDGES[1]), (ROOT - m["x_beta"], EDGES[1])]
        self.blade.set_xy(view(np.array([blade_point(m, beta, theta, *corner) for corner in corners])))
        spar = [blade_point(m, beta, theta, along, 0.0) for along in (0.0, ROOT - m["x_beta"])]
        self.spar.set_data(*view(np.array(spar)).T)
        self.horn.set_data(*view(np.array([blade_point(m, beta, theta, m["x_theta"], 0.0), a])).T)
        self.link.set_data(*view(np.array([a, b])).T)
        self.plate.set_xy(view(self._swashplate(b)))
        return {"A": view(a), "B": view(b)}

    def _swashplate(self, b: Array) -> Array:
        """Returns the rim of the plate through B that is level across the direction of B."""
        m = self.model
        angle = np.linspace(0, 2 * np.pi, 73)
        radius = float(np.hypot(m["x_b"], m["y_b"]))
        x, y = radius * np.cos(angle), radius * np.sin(angle)
        z = m["z_b"] + (b[2] - m["z_b"]) * (x * b[0] + y * b[1]) / (b[0] ** 2 + b[1] ** 2)
        return np.stack([x, y, z], axis=-1)


def figure9(results: Results) -> Figure:
    """Draws the blade root in space, from above and along the blade."""
    model = results.case("figure10").model
    figure = plt.figure(figsize=(8.0, 4.6), layout="constrained")
    grid = figure.add_gridspec(2, 2, width_ratios=(1.55, 1.0))
    in_space(figure.add_subplot(grid[:, 0]), model)
    from_above(figure.add_subplot(grid[0, 1]), model)
    along_blade(figure.add_subplot(grid[1, 1]), model)
    figure.legend(handles=legend(), loc="outside lower center", ncols=5, columnspacing=1.6, handlelength=1.6)
    return figure


def legend() -> list[Artist]:
    """Returns the legend's entries."""
    parts = (("rotor shaft and hub", HUB, 5), ("flap hinge", "black", 8), ("blade", BLADE, 8))
    parts += (("pitch horn", HORN, 3.2), ("pitch link", LINK, 2.6))
    return [Line2D([], [], color=color, linewidth=width, label=text) for text, color, width in parts]


def in_space(axes: Axes, model: Model) -> None:
    """Draws the root in space with its axes and angles."""
    root = Root(axes, model)
    points = root.move(0.0, 0.0, 0.0)
    for name, offset in (("A", (7, 5)), ("B", (-13, -12))):
        note(axes, name, points[name], offset, bold=True)
    note(axes, "swashplate", view(np.array([0.0, -0.2, model["z_b"]])), (0, 0), ha="center")
    arrow(axes, [TIP, 0, 0], [TIP + 0.1, 0, 0], "x")
    arrow(axes, [0, 0, 0.09], [0, 0, 0.2], "z")
    arrow(axes, [0, 0.0, 0], [0, 0.26, 0], "y")
    # Turning about the shaft, flapping up about the hinge, nose up about the blade.
    turn = np.linspace(-0.9, 2.4, 40)
    curve(
        axes,
        np.stack([0.055 * np.cos(turn), 0.055 * np.sin(turn), 0 * turn + 0.13], axis=-1),
        r"$\Omega$",
        (-14, 4),
    )
    up = np.linspace(0.05, 0.34, 30)
    flap = np.stack([model["x_beta"] + 0.38 * np.cos(up), 0 * up + EDGES[0], 0.38 * np.sin(up)], axis=-1)
    curve(axes, flap, r"$\beta$", (-4, 5))
    nose = np.linspace(-0.6, 1.5, 30)
    pitch = np.stack([0 * nose + TIP + 0.03, 0.06 * np.cos(nose), 0.06 * np.sin(nose)], axis=-1)
    curve(axes, pitch, r"$\theta$", (9, 4))
    axes.update_datalim(root.plate.get_xy())
    axes.set_title("In space")
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.04)
    axes.autoscale_view()


def from_above(axes: Axes, model: Model) -> None:
    """Draws the root in the plane of the disk."""
    x_beta, x, y = model["x_beta"], model["x_beta"] + model["x_theta"], model["y_theta"]
    axes.plot([0, x_beta], [0, 0], color=HUB, linewidth=5, zorder=3)
    axes.plot(0, 0, marker="o", markersize=9, color=HUB)
    axes.plot([x_beta, ROOT], [0, 0], color="#4b6a88", linewidth=4, zorder=4)
    axes.add_patch(
        Polygon(
            [[ROOT, EDGES[0]], [TIP, EDGES[0]], [TIP, EDGES[1]], [ROOT, EDGES[1]]],
            facecolor=BLADE,
            edgecolor="#4b6a88",
            linewidth=0.9,
        )
    )
    axes.plot([x_beta, x_beta], [-0.035, 0.035], color="black", linewidth=8, zorder=5)
    axes.plot([x, x], [0, y], color=HORN, linewidth=3.2, zorder=6)
    axes.plot(x, y, marker="o", markersize=7, color=LINK, markeredgecolor="white", zorder=7)
    note(axes, "A, B", (x, y), (6, 3), bold=True)
    dimension(axes, (0, -0.15), (x_beta, -0.15), rf"$x_\beta$ = {x_beta:g} m", (0, -10))
    dimension(axes, (0, -0.215), (model["x_b"], -0.215), rf"$x_B$ = {model['x_b']:g} m", (0, -10))
    axes.plot([model["x_b"]] * 2, [-0.225, -0.01], color=style.GRAY, linewidth=0.5, zorder=0)
    dimension(axes, (x_beta, 0.075), (x, 0.075), rf"$x_\theta$ = {model['x_theta']:g} m", (-38, -3))
    dimension(axes, (x + 0.05, 0), (x + 0.05, y), rf"$y_\theta = y_B$ = {y:g} m", (46, 0))
    for end in ((0, 0), (x_beta, 0)):
        low = -0.16 if end[0] else -0.225
        axes.plot([end[0], end[0]], [end[1], low], color=style.GRAY, linewidth=0.5, zorder=0)
    axes.set_title("From above")
    finish(axes)


def along_blade(axes: Axes, model: Model) -> None:
    """Draws the horn and the link as seen along the blade from outside."""
    y, z, length = model["y_theta"], model["z_b"], model["length"]
    axes.add_patch(
        Polygon(
            [[EDGES[0], -0.008], [EDGES[1], -0.008], [EDGES[1], 0.008], [EDGES[0], 0.008]],
            facecolor=BLADE,
            edgecolor="#4b6a88",
            linewidth=0.9,
        )
    )
    axes.plot([0, y], [0, 0], color=HORN, linewidth=3.2, zorder=6)
    axes.plot(
        [y, y], [0, z], color=LINK, linewidth=2.6, marker="o", markersize=7, markeredgecolor="white", zorder=7
    )
    axes.plot([-0.1, 0.26], [z - 0.012, z - 0.012], color=PLATE, linewidth=7, zorder=1, solid_capstyle="butt")
    axes.plot(0, 0, marker="+", markersize=9, color="black", zorder=8)
    note(axes, "A", (y, 0), (7, 4), bold=True)
    note(axes, "B", (y, z), (7, 2), bold=True)
    note(axes, "swashplate", (-0.09, z), (0, 3))
    dimension(axes, (0, 0.05), (y, 0.05), rf"$y_\theta$ = {y:g} m", (0, 8))
    dimension(axes, (y + 0.07, 0), (y + 0.07, z), rf"$L$ = {length:g} m", (30, 0))
    dimension(axes, (0.04, 0), (0.04, z), rf"$z_B$ = {z:g} m".replace("-", "−"), (38, 0))
    axes.set_title("Along the blade")
    finish(axes)


def finish(axes: Axes) -> None:
    """Gives a panel one scale in both directions and no axes."""
    axes.set_aspect("equal", adjustable="datalim")
    axes.axis("off")
    axes.margins(0.12)


def arrow(axes: Axes, start: list[float], end: list[float], text: str) -> None:
    """Draws an axis of coordinates."""
    first, last = view(np.array([start, end]))
    axes.annotate(
        "", last, first, arrowprops={"arrowstyle": "-|>", "color": style.GRAY, "linewidth": 0.9}, zorder=2
    )
    direction = (last - first) / np.linalg.norm(last - first)
    note(axes, f"${text}$", last, tuple(7 * direction - (2, 3)))


def curve(axes: Axes, points: Array, text: str, offset: tuple[float, float]) -> None:
    """Draws an angle as an arrow along points in space."""
    flat = view(points)
    axes.plot(*flat[:-1].T, color="black", linewidth=1.0, zorder=9)
    axes.annotate(
        "", flat[-1], flat[-3], arrowprops={"arrowstyle": "-|>", "color": "black", "linewidth": 1.0}, zorder=9
    )
    axes.annotate(text, flat[-1], xytext=offset, textcoords="offset points", fontsize=12, zorder=10)
