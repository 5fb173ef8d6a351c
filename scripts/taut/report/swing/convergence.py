"""How the swing of finite elements converges, over mesh and over time spent, explicit and implicit."""

from dataclasses import dataclass

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.lines import Line2D

from taut import style
from taut.formats import listed, number
from taut.report.document import Paragraph, Table
from taut.report.swing.measures import BEFORE, apart, positions, sample
from taut.results import Array, Results

# Two-node elements; the two finest meshes give the continuum.
MESHES = (4, 8, 16, 32, 64)
# Before the event, at its beginning, when link 1 and A-C are in line, and after it [s].
INSTANTS = (0.3, 0.6, 0.64, 0.8, 1.0)
RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


@dataclass(frozen=True)
class Series:
    """Runs of one integrator over the meshes: their cases, and how they are drawn."""

    name: str
    # Relative tolerance, as a power of ten.
    power: str
    # The number of elements stands in the place of {}.
    case: str
    color: str
    marker: str
    dashes: object = "solid"

    @property
    def label(self) -> str:
        """What tables call it."""
        return f"{self.name}, rtol 10{self.power.translate(RAISED)}"

    @property
    def drawn(self) -> str:
        """What figures call it."""
        return f"{self.name}, rtol $10^{{{self.power}}}$"

    def cases(self, results: Results) -> dict[int, str]:
        """Returns the cases that have been run, by number of elements."""
        named = {n: self.case.format(n) for n in MESHES}
        return {n: name for n, name in named.items() if results.has(name)}


EXPLICIT = Series("Dormand–Prince", "-6", "mesh{}", style.COLORS[0], "o", (0, (5, 2)))
IMPLICIT = Series("Radau IIA", "-4", "mesh{}_implicit", style.COLORS[1], "s")
LOOSE = Series("Radau IIA", "-3", "mesh{}_implicit_loose", style.COLORS[4], "^", (0, (1.2, 1.2)))
SERIES = (EXPLICIT, IMPLICIT, LOOSE)
CASES = tuple(one.case.format(n) for one in SERIES for n in MESHES)
# Without these there is nothing to compare with.
FINEST = tuple(IMPLICIT.case.format(n) for n in MESHES[-2:])


def markers_at(results: Results, name: str, times: tuple[float, ...]) -> Array:
    """Returns where the markers of a run are: one row a time, then one a marker [m]."""
    run = results.case(name).run("present")
    return sample(run["t"], positions(run), np.array(times))


def continuum(results: Results) -> Array:
    """Returns where the markers are without a mesh: the errors of the two finest are as 4 to 1."""
    coarse, fine = (markers_at(results, name, INSTANTS) for name in FINEST)
    return fine + (fine - coarse) / 3


def errors(results: Results, name: str) -> Array:
    """Returns how far a run is from the continuum at the instants, at the marker where it is most [m]."""
    return np.linalg.norm(markers_at(results, name, INSTANTS) - continuum(results), axis=-1).max(axis=-1)


def mesh_figure(results: Results) -> Figure:
    """Draws the error over the number of elements at given instants."""
    layout = ConstrainedLayoutEngine(w_pad=0.05, h_pad=0.05)
    figure, axes = plt.subplots(figsize=(7.2, 4.6), layout=layout)
    colors = plt.get_cmap("viridis")(np.linspace(0.0, 0.85, len(INSTANTS)))
    for one in (EXPLICIT, IMPLICIT):
        cases = one.cases(results)
        found = np.array([errors(results, name) for name in cases.values()])
        for i, color in enumerate(colors):
            filled = {"markerfacecolor": color if one is IMPLICIT else "white"}
            look = {"color": color, "marker": one.marker, "linestyle": one.dashes, "markersize": 5}
            axes.loglog(list(cases), found[:, i], linewidth=1.2, **look, **filled)
    for i, (t, color) in enumerate(zip(INSTANTS, colors, strict=True)):
        # The last two lie close together.
        up = {len(INSTANTS) - 1: 3, len(INSTANTS) - 2: -3}.get(i, 0)
        text = {"xytext": (-8, up), "textcoords": "offset points", "ha": "right", "va": "center"}
        first = errors(results, IMPLICIT.case.format(MESHES[0]))[i]
        axes.annotate(f"{t:g} s", (MESHES[0], first), color=color, **text)
    guide = np.array([8.0, 64.0])
    axes.loglog(guide, 4e-6 * (guide / 64) ** -2.0, color=style.GRAY, linewidth=0.8)
    axes.annotate(
        "order 2",
        (8, 2.6e-4),
        color=style.GRAY,
        xytext=(-6, 0),
        textcoords="offset points",
        ha="right",
        va="center",
    )
    _over_elements(axes)
    handles = [
        Line2D([], [], color=style.DARK, marker=s.marker, linestyle=s.dashes, label=s.drawn, markersize=5)
        for s in (EXPLICIT, IMPLICIT)
    ]
    handles[0].set_markerfacecolor("white")
    axes.legend(handles=handles, loc="lower left")
    return figure


def _over_elements(axes: Axes) -> None:
    """Names the axes of a figure over the mesh."""
    axes.set(xlim=(2.9, 76), xticks=MESHES, xticklabels=[str(n) for n in MESHES])
    axes.minorticks_off()
    axes.set(xlabel="two-node elements", ylabel="distance from the continuum [m]")


# Where the number of a point may stand, in points from it, the best places first; and the size of a digit.
PLACES = (
    (-5, 5),
    (5, 5),
    (-5, -5),
    (5, -5),
    (0, 8),
    (0, -8),
    (-9, 0),
    (9, 0),
    (-12, 9),
    (12, 9),
    (-12, -9),
    (12, -9),
)
DIGIT = np.array([5.2, 7.5])


def cost_figure(results: Results) -> Figure:
    """Draws the error before and after the event over what a run has taken."""
    layout = ConstrainedLayoutEngine(w_pad=0.05, h_pad=0.05)
    figure, panels = plt.subplots(1, 2, figsize=(8.0, 4.1), layout=layout, sharex=True)
    numbered = []
    for axes, t in zip(panels, (BEFORE, INSTANTS[-1]), strict=True):
        at = INSTANTS.index(t)
        points: list[tuple[Series, list[int], Array]] = []
        for one in SERIES:
            cases = one.cases(results)
            seconds = [results.case(name).number("present", "wall_seconds") for name in cases.values()]
            found = [errors(results, name)[at] for name in cases.values()]
            look = {"color": one.color, "marker": one.marker, "linestyle": one.dashes, "markersize": 5}
            axes.loglog(seconds, found, linewidth=1.2, **look)
            points.append((one, list(cases), np.column_stack((seconds, found))))
        numbered.append((axes, points))
        axes.set(title=f"At {t:g} s", xlabel="time of the run to 1.0 s [s]")
    panels[0].set_ylabel("distance from the continuum [m]")
    handles = [
        Line2D([], [], color=s.color, marker=s.marker, linestyle=s.dashes, label=s.drawn, markersize=5)
        for s in SERIES
    ]
    figure.legend(handles=handles, loc="outside upper center", ncols=3, columnspacing=1.8)
    figure.draw_without_rendering()
    for axes, points in numbered:
        number_points(axes, points)
    return figure


def number_points(axes: Axes, series: list[tuple[Series, list[int], Array]]) -> None:
    """Writes the numbers of elements where they meet neither each other nor points and lines."""
    to_points = 72 / axes.figure.dpi
    places = [axes.transData.transform(points) * to_points for _, _, points in series]
    taken = []
    for line in places:
        for start, end in zip(line[:-1], line[1:], strict=True):
            taken += [(start + part * (end - start), np.array([1.0, 1.0])) for part in np.linspace(0, 1, 25)]
        taken += [(point, np.array([6.0, 6.0])) for point in line]
    for (one, numbers, points), line in zip(series, places, strict=True):
        for n, point, at in zip(numbers, points, line, strict=True):
            size = DIGIT * (len(str(n)), 1)
            tried = []
            for place in PLACES:
                middle = at + place + np.sign(place) * size / 2
                overlaps = [np.maximum((size + other) / 2 - abs(middle - where), 0) for where, other in taken]
                tried.append((sum(float(one_of.prod()) for one_of in overlaps), middle))
            middle = min(tried, key=lambda found: found[0])[1]
            taken.append((middle, size + 1))
            text = {"fontsize": 8.5, "ha": "center", "va": "center", "textcoords": "offset points"}
            axes.annotate(str(n), point, tuple(middle - at), color=one.color, **text)


def peaks(results: Results) -> dict[int, tuple[float, float]]:
    """Returns the largest force of link 1 [N], and when it acts [s], by number of elements."""
    found = {}
    for n, name in IMPLICIT.cases(results).items():
        case = results.case(name)
        ends = [[case.number("present", f"link1_{end}{of}") for of in ("", "_t")] for end in ("min", "max")]
        force, time = max(ends, key=lambda one: abs(one[0]))
        found[n] = (abs(force), time)
    return found


def section(results: Results) -> tuple[Paragraph | Table, ...]:
    """Tells what of the motion is mesh, what is tolerance and what is chaos, and what it costs."""
    if not all(map(results.has, FINEST)):
        return ()
    rows, cost = [], []
    for one in SERIES:
        for n, name in one.cases(results).items():
            case = results.case(name)
            found = [number(1e3 * error) for error in errors(results, name)]
            rows.append((f"{n}, {one.label}", *found))
            steps, seconds = case.steps("present"), case.number("present", "wall_seconds")
            jacobians = case.number("present", "jacobians")
            share = f"{100 * jacobians / max(steps, 1):.0f} %" if jacobians else ""
            cost.append((f"{n}, {one.label}", f"{steps:,}", share, number(seconds)))
    header = ("elements and integrator", *(f"{t:g} s" for t in INSTANTS))
    blocks: list[Paragraph | Table] = [
        Table("Largest distance of a marker from the continuum [mm].", header, tuple(rows)),
        Table(
            "What the runs to 1.0 s take.",
            ("elements and integrator", "steps", "Jacobians a step", "time [s]"),
            tuple(cost),
        ),
        Table(
            f"Largest force of link 1, in a step or at its end; {IMPLICIT.label}.",
            ("elements", "force [N]", "at [s]"),
            tuple((str(n), number(force, 4), number(at, 4)) for n, (force, at) in peaks(results).items()),
        ),
        Paragraph(what_is_what(results)),
    ]
    return tuple(blocks)


def what_is_what(results: Results) -> str:
    """Tells apart the shares of mesh, tolerance and chaos."""
    fine = errors(results, FINEST[1])
    text = (
        "The continuum is extrapolated from 32 and 64 elements, whose errors are as 4 to 1; it is good to "
        f"about {number(1e3 * fine[INSTANTS.index(BEFORE)])} mm at {BEFORE:g} s and "
        f"{number(1e3 * fine[-1], unit='mm')} at 1 s, the error of 64 elements."
    )
    both = [n for n in EXPLICIT.cases(results) if n in IMPLICIT.cases(results)]
    if both:
        pairs = [
            apart(
                results.case(EXPLICIT.case.format(n)).run("present"),
                results.case(IMPLICIT.case.format(n)).run("present"),
            )
            for n in both
        ]
        told = listed([number(1e3 * one) for one in pairs])
        text += (
            f" What is left of chaos is how far two integrators part on one mesh in the whole run: {told} mm "
            f"with {listed([str(n) for n in both])} elements. All else is mesh, which the event magnifies."
        )
    if results.has("2b_tight") and results.has("3b"):
        axial = apart(results.case("2b_tight").run("present"), results.case("3b").run("present"))
        text += f" Without the axial mode the modal model goes {number(1e3 * axial, unit='mm')} elsewhere."
    return text
