"""The figures of the swing, Sect. 4.2: trajectories, mode shapes, violations and motion."""

from functools import partial

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.lines import Line2D

from taut import style
from taut.report.drawing import AnimationSpec, FigureSpec, Spec
from taut.report.swing.animation import swinging
from taut.report.swing.convergence import FINEST, cost_figure, mesh_figure
from taut.report.swing.measures import (
    BEAM,
    LINKS,
    MARKERS,
    REFERENCES,
    SUPPORTS,
    TABLE_1,
    analysis_0,
    distances,
    event_time,
    largest_in_pieces,
    mode_shape,
    modes,
    positions,
    reference,
    sample,
    static_shape,
)
from taut.report.swing.sketch import COLORS, SHAPES, Swing, figure3, ground
from taut.results import Array, Results, Run

# When the swing is drawn beside the trajectories [s]; 0.64 is when link 1 and A-C are in line.
# Where the time is written beside A [points].
POSES = {0.0: (-5, -13), 0.4: (-24, 3), 0.64: (12, -1), 1.0: (8, 0)}
_OTHER = {"color": "black", "linewidth": 0.9, "linestyle": (0, (3, 2)), "zorder": 7.5}
FINE = np.linspace(0.0, 1.0, 1001)
# Below the smallest distance that is drawn [m].
NEAREST = 1e-14
_RAW = {"color": style.METHODS["present"].color, "alpha": 0.55, "linewidth": 0.8, "zorder": 1.5}
_EVENT = {"color": "#b3261e", "linewidth": 0.8, "linestyle": (0, (2, 2)), "zorder": 1}
# Figure 8: what a row shows, and its runs without and with the corrections.
ROWS = (
    ("Beam of finite elements", "1a", "1b"),
    ("Modal model", "2a", "2b"),
    ("Modal model without the axial mode", "3a", "3b"),
)


def figure4(results: Results) -> Figure:
    """Draws the trajectories of the markers in analysis (0), and those that another program gives."""
    layout = ConstrainedLayoutEngine(w_pad=0.04, h_pad=0.04)
    figure, axes = plt.subplots(2, 1, figsize=(7.4, 8.0), layout=layout, sharex=True)
    for panel, own, other in zip(axes, (8, 16), (2, 4), strict=True):
        run = analysis_0(results, own)
        for t in POSES:
            pose(panel, run, t)
        for i, m in enumerate(MARKERS):
            panel.plot(*positions(run)[:, i].T, color=COLORS[m], linewidth=1.5, zorder=7)
        for points in np.moveaxis(steps_of(reference(other)), 1, 0):
            panel.plot(*points.T, **_OTHER)
        frame(panel)
        panel.set(
            title=f"Analysis (0), {own} two-node elements; dashed: {other} of three nodes", ylabel="y [m]"
        )
    axes[-1].set_xlabel("x [m]")
    handles = [*marker_legend(), Line2D([], [], label="MBDyn", **_OTHER)]
    figure.legend(handles=handles, loc="outside upper center", ncols=4, columnspacing=1.6)
    return figure


def pose(axes: Axes, run: Run, t: float) -> None:
    """Draws the swing at a time, and the time below it."""
    points = sample(run["t"], positions(run), np.array([t]))[0]
    swing = Swing(axes, markers=False)
    swing.move(points)
    # The later, the darker.
    shade = str(0.72 - 0.5 * t / max(POSES))
    for line in (*swing.links, swing.beam):
        line.set(linewidth=0.9, color=shade, zorder=2)
    for i, (m, point) in enumerate(zip(MARKERS, points, strict=True)):
        keywords = {"markersize": 5, "color": COLORS[m], "markeredgecolor": "white", "zorder": 8 + 0.1 * i}
        axes.plot(*point, marker=SHAPES[m], **keywords)
    axes.annotate(
        f"{t:g} s",
        points[0],
        xytext=POSES[t],
        textcoords="offset points",
        fontsize=8.5,
        color=shade,
        zorder=12,
    )


def frame(axes: Axes) -> None:
    """Draws the supports and the circles that the links' ends keep to, and sets the scale."""
    for center, radius, ends in zip(SUPPORTS, LINKS, ((-90, 9), (-135, -103)), strict=True):
        angle = np.radians(np.linspace(*ends, 91))
        axes.plot(
            center[0] + radius * np.cos(angle),
            center[1] + radius * np.sin(angle),
            color="#cbd5e1",
            linewidth=4,
            zorder=1,
            solid_capstyle="butt",
        )
        ground(axes, center)
    axes.set_aspect("equal")
    axes.set(xlim=(-0.08, 1.16), ylim=(-0.17, 0.45))


def marker_legend() -> list[Artist]:
    """Returns an entry for each marker and one for the circles."""
    entries: list[Artist] = [
        Line2D([], [], color=COLORS[m], marker=SHAPES[m], markersize=5, markeredgecolor="white", label=m)
        for m in MARKERS
    ]
    entries.append(Line2D([], [], color="#cbd5e1", linewidth=4, label="circle of the link"))
    return entries


def figure5(results: Results) -> Figure:
    """Draws the modes of Table 1, two of them with the static shape that they come close to."""
    layout = ConstrainedLayoutEngine(w_pad=0.06, h_pad=0.06)
    figure, axes = plt.subplots(2, 2, figsize=(8.0, 4.8), layout=layout, sharex=True)
    for panel, row, (number, frequency) in zip(axes.flat, TABLE_1, modes(results), strict=True):
        name, motion, symmetry, rank, _ = row
        if number == 0:
            panel.set_title(f"{name}: not among the modes")
            continue
        axial = motion == "axial"
        x, u = mode_shape(results, number, "u_x" if axial else "u_y")
        panel.axhline(0, color="#374151", linewidth=0.6, zorder=1)
        if axial or (symmetry, rank) == ("symmetric", 1):
            label = "static: triangle" if axial else "static: cubic"
            fine = np.linspace(0, BEAM, 201)
            panel.plot(
                fine, static_shape(fine, motion), color="#E69F00", linewidth=5.5, alpha=0.45, label=label
            )
            panel.legend(loc="lower center")
        look = {"linewidth": 1.6, "marker": "o", "markersize": 2.6, "clip_on": False}
        panel.plot(x, u, color=style.METHODS["present"].color, **look)
        middle = len(x) // 2
        panel.plot(x[middle], u[middle], color="black", marker="D", markersize=7, markeredgecolor="white")
        panel.set(
            title=f"{name}: {frequency:.4g} Hz",
            ylabel=f"{'axial' if axial else 'transverse'} displacement [1]",
            ylim=(-1.15, 1.15),
            xlim=(-0.01, BEAM + 0.01),
        )
    for panel in axes[-1]:
        panel.set_xlabel("x [m]")
    text = "Simply supported beam, 40 two-node elements; the largest displacement is 1"
    figure.supxlabel(text, fontsize=9.5, color=style.GRAY)
    return figure


def violations_figure(
    results: Results, baseline: str, present: str, limits: tuple[float, float], more: float, settings: str
) -> Figure:
    """Draws the constraint's error and that of its derivative over time, before replacement too."""
    runs = {
        "baseline": results.case(baseline).run("baseline"),
        "present": results.case(present).run("present"),
    }
    layout = ConstrainedLayoutEngine(w_pad=0.06, h_pad=0.06)
    figure, axes = plt.subplots(1, 2, figsize=(8.0, 4.1), layout=layout)
    figure.supxlabel(settings, fontsize=9.5, color=style.GRAY)
    for panel, column, title, unit in (
        (axes[0], "phi", r"Constraint, $|\phi|$", "m"),
        (axes[1], "phidot", r"Its derivative, $|\mathrm{d}\phi/\mathrm{d}t|$", "m/s"),
    ):
        style.round_off_band(panel, 1e-18)
        for method, run in runs.items():
            look = style.method_style(method)
            t, value = largest_in_pieces(run["t"], np.maximum(np.abs(run[column]), style.FLOOR))
            panel.semilogy(t, value, **look.line(len(t)) | {"linewidth": 1.2})
        t, raw = largest_in_pieces(
            runs["present"]["t"], np.maximum(np.abs(runs["present"][f"{column}_raw"]), style.FLOOR)
        )
        panel.semilogy(t, raw, **_RAW)
        mark_event(panel, results, present, baseline)
        # The derivative's errors are larger by about the highest frequency.
        top = limits[1] * (more if column == "phidot" else 1.0)
        decades = np.arange(-16, np.log10(top) + 0.1, 2)
        panel.set(
            title=title,
            xlabel="time [s]",
            ylabel=f"error [{unit}]",
            ylim=(limits[0], top),
            yticks=10.0**decades,
        )
        panel.set_xlim(0, max(float(run["t"][-1]) for run in runs.values()))
        panel.minorticks_off()
    handles: list[Artist] = []
    for method, case in (("baseline", baseline), ("present", present)):
        look = style.method_style(method)
        steps = results.case(case).steps(method)
        keywords = look.line(2) | {"markevery": [1]}
        text = f"{look.label} ({case}): {steps:,} steps"
        handles.append(Line2D([0, 0.5, 1], [0, 0, 0], label=text, **keywords))
    handles.append(Line2D([], [], label="present, before replacement", **_RAW))
    figure.legend(
        handles=[*handles, Line2D([], [], label="link 1 in line with A–C", **_EVENT)],
        loc="outside upper center",
        ncols=2,
        columnspacing=2.4,
        handlelength=3.4,
    )
    return figure


def mark_event(axes: Axes, results: Results, *cases: str) -> None:
    """Marks when link 1 comes in line with A-C, if a run has told."""
    t = event_time(results, *cases)
    if t is not None:
        axes.axvline(t, **_EVENT)


def figure8(results: Results) -> Figure:
    """Draws the trajectories on the left and, on the right, how far runs are apart over time."""
    rows = [row for row in ROWS if results.has(row[1]) and results.has(row[2])]
    layout = ConstrainedLayoutEngine(w_pad=0.05, h_pad=0.05)
    figure, axes = plt.subplots(
        len(rows),
        2,
        figsize=(8.0, 0.9 + 2.45 * len(rows)),
        layout=layout,
        width_ratios=(1.55, 1.0),
        squeeze=False,
    )
    for (left, right), (title, baseline, present) in zip(axes, rows, strict=True):
        runs = {
            "present": results.case(present).run("present"),
            "baseline": results.case(baseline).run("baseline"),
        }
        frame(left)
        for method, run in runs.items():
            look = style.method_style(method)
            points = steps_of(run)
            for i in range(len(MARKERS)):
                left.plot(
                    *points[:, i].T,
                    color=look.color,
                    linestyle=look.dashes,
                    linewidth=look.width,
                    zorder=look.layer + 4,
                )
        for m, point in zip(MARKERS, positions(runs["present"])[-1], strict=True):
            look = {"marker": SHAPES[m], "markersize": 5, "color": COLORS[m], "markeredgecolor": "white"}
            left.plot(*point, zorder=13, **look)
        for m, point in zip(MARKERS, positions(runs["present"])[0], strict=True):
            offset = (-2, 6) if m == "E" else (-3, -13)
            left.annotate(m, point, xytext=offset, textcoords="offset points", fontweight="bold", zorder=12)
        left.set(title=f"{title} ({baseline}, {present})", ylabel="y [m]")
        how_far(right, results, runs)
        mark_event(right, results, present, baseline)
        right.set_title(f"How far apart: {baseline}, {present}")
        right.set_ylabel("distance of a marker [m]")
    axes[-1, 0].set_xlabel("x [m]")
    axes[-1, 1].set_xlabel("time [s]")
    figure.legend(
        handles=motion_legend(),
        loc="outside upper center",
        ncols=3,
        columnspacing=1.6,
        handlelength=3.0,
    )
    return figure


def steps_of(run: Run) -> Array:
    """Returns the markers at not more points than can be seen."""
    times = FINE[float(run["t"][-1]) + 1e-9 >= FINE]
    return sample(run["t"], positions(run), times)


# What is compared on the right of Figure 8: label, color, dashes.
_FROM = {
    "baseline": ("distance of baseline and present", "#7F3C8D", (0, (5, 1, 1, 1))),
    "reference": ("distance of present and analysis (0)", "#009E73", (0, (1.2, 1.2))),
    "axial": ("distance of 3b and 2b", "#E69F00", (0, (6, 1.5, 1, 1.5))),
}


def how_far(axes: Axes, results: Results, runs: dict[str, Run]) -> None:
    """Draws the distance of the farthest marker between runs."""
    pairs = {
        "baseline": (runs["baseline"], runs["present"]),
        "reference": (runs["present"], reference(4)),
    }
    if results.has("3b") and results.has("2b") and runs["present"] is results.case("3b").run("present"):
        pairs["axial"] = (runs["present"], results.case("2b").run("present"))
    for name, pair in pairs.items():
        times, distance = distances(*pair)
        _, color, dashes = _FROM[name]
        farthest = np.maximum(distance.max(axis=1), NEAREST)
        axes.semilogy(times, farthest, color=color, linestyle=dashes, linewidth=1.2)
    axes.set(xlim=(0, 1), ylim=(0.5 * NEAREST, 3.0), yticks=10.0 ** np.arange(-14, 1, 2))
    axes.minorticks_off()


def motion_legend() -> list[Artist]:
    """Returns what the lines on both sides mean."""
    entries: list[Artist] = []
    for method in ("present", "baseline"):
        look = style.method_style(method)
        keywords = {"color": look.color, "linestyle": look.dashes, "linewidth": look.width}
        entries.append(Line2D([], [], label=f"{look.label}: paths", **keywords))
    for label, color, dashes in _FROM.values():
        entries.append(Line2D([], [], color=color, linestyle=dashes, linewidth=1.2, label=label))
    entries.append(Line2D([], [], label="link 1 in line with A–C", **_EVENT))
    return entries


FIGURES: tuple[Spec, ...] = (
    FigureSpec("swing_figure3", "Figure 3", (), figure3),
    FigureSpec("swing_figure4", "Figure 4", ("0_8x", "0_16x"), figure4, files=REFERENCES),
    FigureSpec("swing_figure5", "Figure 5", ("table1",), figure5),
    FigureSpec(
        "swing_figure6",
        "Figure 6",
        ("1a", "1b"),
        partial(
            violations_figure,
            baseline="1a",
            present="1b",
            limits=(1e-18, 1e-13),
            more=1e3,
            settings="Beam of 4 elements; rtol $10^{-3}$, atol $10^{-6}$, steps of at most $10^{-5}$ s",
        ),
    ),
    FigureSpec(
        "swing_figure7",
        "Figure 7",
        ("2a", "2b"),
        partial(
            violations_figure,
            baseline="2a",
            present="2b",
            limits=(1e-18, 1e-1),
            more=1e3,
            settings="Modal model, four modes; rtol $10^{-3}$, atol $10^{-6}$, steps of at most $10^{-3}$ s",
        ),
    ),
    FigureSpec("swing_figure8", "Figure 8", ("1a", "1b", "2a", "2b", "3a", "3b"), figure8, files=REFERENCES),
    FigureSpec("swing_mesh", "Convergence", FINEST, mesh_figure),
    FigureSpec("swing_cost", "Error and time", FINEST, cost_figure),
    AnimationSpec("swing", "Animation", ("3b",), swinging, files=REFERENCES),
)
