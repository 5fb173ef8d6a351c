"""The figures of the pendulum, Sect. 4.1: trajectory, length error, velocity error and energy."""

from functools import partial

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from taut import style
from taut.formats import energy_label
from taut.report.drawing import FigureSpec
from taut.report.judgment import NEWTON_TOLERANCE
from taut.report.pendulum.measures import ENERGY_SCALE, LENGTH, PERIOD
from taut.results import Array, Case, Results, Run

# The paper's order, so that the legends read alike.
METHODS = ("baseline", "present", "baumgarte", "braun-goldfarb")


_RAW = {"color": style.METHODS["present"].color, "alpha": 0.5, "linewidth": 0.7, "zorder": 1.5}
_CIRCLE = {"color": "#cbd5e1", "linewidth": 5.0, "zorder": 1}
_TOLERANCE = {"color": style.GRAY, "linewidth": 0.9, "linestyle": (0, (4, 3)), "zorder": 1.2}
_WEDGE = {"color": "#e9ecf1", "linewidth": 0, "zorder": 0}


def four_panels(
    results: Results,
    case: str,
    methods: tuple[str, ...],
    energy: tuple[float, float],
    magnified: int,
    bold: tuple[str, ...] = (),
    settings: str = "",
) -> Figure:
    """Draws the paper's four panels; energy is a range in mJ, magnified the factor of the errors of paths."""
    data = results.case(case)
    runs = {method: data.run(method) for method in methods}
    t_end = max(float(run["t"][-1]) for run in runs.values())
    layout = ConstrainedLayoutEngine(w_pad=0.06, h_pad=0.06, hspace=0.03, wspace=0.03)
    figure, axes = plt.subplots(2, 2, figsize=(8.0, 6.6), layout=layout, height_ratios=(1.0, 1.12))
    figure.supxlabel(settings, fontsize=9.5, color=style.GRAY)
    trajectory(axes[0, 0], runs, magnified)
    errors(axes[0, 1], runs, "phi")
    axes[0, 1].set(title="Length", ylabel=r"length error $|\sqrt{x^2+z^2}-L|$ [m]")
    axes[0, 1].axhline(NEWTON_TOLERANCE, **_TOLERANCE)
    errors(axes[1, 0], runs, "phidot")
    axes[1, 0].set(title="Velocity", ylabel=r"velocity error $|\mathrm{d}\phi/\mathrm{d}t|$ [m/s]")
    total_energy(axes[1, 1], runs, energy, t_end, bold)
    for panel in axes.flat[1:]:
        panel.set(xlim=(0, t_end), xlabel="time [s]")
    figure.legend(
        handles=legend(data, methods),
        loc="outside upper center",
        ncols=3,
        columnspacing=2.0,
        handlelength=3.4,
    )
    return figure


def legend(case: Case, methods: tuple[str, ...]) -> list[Artist]:
    """Returns the legend's entries: the methods with their numbers of steps, and what else is drawn."""
    entries: list[Artist] = []
    for method in methods:
        look = style.method_style(method)
        # One marker in the middle of the sample line, whatever the rule on the curve.
        keywords = look.line(2) | {"markevery": [1]}
        entries.append(
            Line2D([0, 0.5, 1], [0, 0, 0], label=f"{look.label}: {case.steps(method):,} steps", **keywords)
        )
    entries.append(Line2D([], [], label="present, before replacement", **_RAW))
    entries.append(Line2D([], [], label="exact circle", **_CIRCLE))
    entries.append(Line2D([], [], label=r"inner loop’s tolerance, $10^{-12}$ m", **_TOLERANCE))
    entries.append(Patch(label="0.01 % of 9.81 J per period", **_WEDGE))
    return entries


def trajectory(axes: Axes, runs: dict[str, Run], magnified: int) -> None:
    """Draws the paths with the error of the length magnified: as they are, they all lie on the circle."""
    angle = np.linspace(-np.pi, 0.0, 361)
    axes.plot(LENGTH * np.cos(angle), LENGTH * np.sin(angle), **_CIRCLE)
    for method, run in runs.items():
        r, angle = polar_path(run)
        r = LENGTH + magnified * (r - LENGTH)
        keywords = style.method_style(method).line(len(r)) | {"marker": ""}
        axes.plot(r * np.cos(angle), r * np.sin(angle), **keywords)
    axes.plot(0, 0, marker="o", color="#374151", markersize=4, zorder=9)
    axes.annotate("pivot", (0, 0), xytext=(6, 3), textcoords="offset points", fontsize=8.5, color=style.GRAY)
    axes.set_aspect("equal")
    axes.set(title=f"Trajectory, length error × {magnified:,}", xlabel="x [m]", ylabel="z [m]")
    axes.set(xlim=(-1.35, 1.35), ylim=(-1.35, 0.2))
    axes.set_xticks(np.linspace(-1, 1, 5))


def polar_path(run: Run, pieces: int = 12) -> tuple[Array, Array]:
    """Returns radius and angle, each step filled in by the cubics that have its end values and rates."""
    x, z, vx, vz = (run[name] for name in ("x", "z", "vx", "vz"))
    r = np.hypot(x, z)
    s = np.linspace(0.0, 1.0, pieces, endpoint=False)[None, :]
    h = np.diff(run["t"])[:, None]
    path = []
    # Cubics in x and z would leave the circle between the steps by more than some methods do at the steps.
    for value, rate in ((r, (x * vx + z * vz) / r), (np.unwrap(np.arctan2(z, x)), (x * vz - z * vx) / r**2)):
        curve = value[:-1, None] * (1 + 2 * s) * (1 - s) ** 2 + value[1:, None] * s**2 * (3 - 2 * s)
        curve += h * (rate[:-1, None] * s * (1 - s) ** 2 - rate[1:, None] * s**2 * (1 - s))
        path.append(np.append(curve.ravel(), value[-1]))
    return path[0], path[1]


def errors(axes: Axes, runs: dict[str, Run], column: str) -> None:
    """Draws violations over time on a logarithmic scale, those of 'present' before its replacement too."""
    limits = (1e-18, 1e-1)
    style.round_off_band(axes, limits[0])
    for method, run in runs.items():
        look = style.method_style(method)
        values = np.maximum(np.abs(run[column]), style.FLOOR)
        keywords = look.line(len(values))
        # What jumps between round-off and the tolerance from step to step is a cloud of points, not a curve.
        if np.median(values) < style.ROUND_OFF:
            axes.semilogy(run["t"], values, ".", color=look.color, markersize=2.4, zorder=look.layer)
            keywords |= {"linestyle": "none"}
        axes.semilogy(run["t"], values, **keywords)
    if "present" in runs:
        raw = np.maximum(np.abs(runs["present"][f"{column}_raw"]), style.FLOOR)
        axes.semilogy(runs["present"]["t"], raw, **_RAW)
    axes.set_ylim(*limits)
    axes.set_yticks(10.0 ** np.arange(-16, 0, 2))
    axes.minorticks_off()


def total_energy(
    axes: Axes, runs: dict[str, Run], limits: tuple[float, float], t_end: float, bold: tuple[str, ...]
) -> None:
    """Draws the energy in mJ, the final values in the margin and the paper's 0.01 % per period as a wedge."""
    bound = 1e3 * 1e-4 * ENERGY_SCALE * t_end / PERIOD
    axes.fill_between([0, t_end], [0, -bound], [0, bound], **_WEDGE)
    axes.axhline(0, color="#374151", linewidth=0.6, zorder=1)
    for method, run in runs.items():
        axes.plot(run["t"], 1e3 * run["energy"], **style.method_style(method).line(len(run["t"])))
    axes.set(title="Energy", ylabel="total energy [mJ]", ylim=limits)
    final = [float(run["energy"][-1]) for run in runs.values()]
    heights = style.spread([1e3 * value for value in final], 0.062 * (limits[1] - limits[0]), limits)
    for method, value, height in zip(runs, final, heights, strict=True):
        axes.annotate(
            energy_label(value),
            (1.0, min(max(1e3 * value, limits[0]), limits[1])),
            xycoords=axes.get_yaxis_transform(),
            xytext=(1.06, height),
            textcoords=axes.get_yaxis_transform(),
            arrowprops={
                "arrowstyle": "-",
                "color": style.method_style(method).color,
                "linewidth": 0.6,
                "shrinkA": 0,
                "shrinkB": 0,
            },
            va="center",
            fontsize=9,
            fontweight="bold" if method in bold else "normal",
            color=style.method_style(method).color,
            annotation_clip=False,
        )


PENDULUM = "Pendulum, 1 kg, 1 m, released from the horizontal"
LOOSE = PENDULUM + "; rtol $10^{-3}$, atol $10^{-6}$, signed error test"
TIGHT = PENDULUM + "; rtol $10^{-9}$, atol $10^{-9}$, signed error test"
OWN = PENDULUM + "; rtol $10^{-3}$, atol $10^{-6}$, honest error test, steps of at most 0.05 s"
_paper = partial(four_panels, methods=METHODS, energy=(-50.0, 40.0), magnified=50)
FIGURES = (
    FigureSpec("pendulum_figure1", "Figure 1", ("figure1",), partial(_paper, case="figure1", settings=LOOSE)),
    FigureSpec("pendulum_figure2", "Figure 2", ("figure2",), partial(_paper, case="figure2", settings=TIGHT)),
    FigureSpec(
        "pendulum_figure3",
        "What is replaced",
        ("figure3",),
        partial(
            four_panels,
            case="figure3",
            methods=("baseline", "present", "present-position", "baumgarte", "braun-goldfarb"),
            energy=(-4.5, 4.5),
            magnified=2000,
            bold=("present", "present-position"),
            settings=OWN,
        ),
    ),
)
