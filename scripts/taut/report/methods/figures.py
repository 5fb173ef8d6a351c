"""Work-precision figures of the methods: a panel for each, before all others."""

from functools import partial

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.figure import Figure

from taut import style
from taut.report.drawing import FigureSpec
from taut.report.methods.measures import METHODS, PENDULUMS, ended, pendulum_error, work
from taut.results import Case, Results

COLUMNS = 4
FAINT = "#9CA3AF"
STRONG = "#0072B2"


def energy_error(case: Case, method: str) -> float:
    """Returns the largest change of the pendulum's energy [J]."""
    energy = case.run(method)["energy"]
    return float(np.max(np.abs(energy - energy[0])))


def motion_error(case: Case, method: str) -> float:
    """Returns how far the pendulum is from the closed form, at most [m]."""
    return pendulum_error(case.run(method))


def panels(results: Results, measure: object, label: str, what: str) -> Figure:
    """Draws the error over the evaluations for four tolerances, one method a panel."""
    cases = [results.case(name) for name in PENDULUMS]
    curves = {}
    for method in METHODS:
        points = [
            (work(case, method.label), max(measure(case, method.label), 1e-16))
            for case in cases
            if ended(case, method.label)
        ]
        curves[method.label] = np.array(points).T
    rows = -(-len(METHODS) // COLUMNS)
    figure, axes = plt.subplots(
        rows, COLUMNS, figsize=(10.5, 2.35 * rows), sharex=True, sharey=True, layout="constrained"
    )
    for panel, method in zip(axes.flat, METHODS, strict=False):
        for points in curves.values():
            panel.loglog(*points, color=FAINT, linewidth=0.7, zorder=1)
        panel.loglog(*curves[method.label], "o-", color=STRONG, linewidth=1.8, markersize=4.5, zorder=3)
        panel.set_title(method.name, fontsize=10)
        panel.minorticks_off()
        panel.grid(visible=True, which="major", color="#E5E7EB", linewidth=0.5)
    figure.supxlabel("evaluations of the right-hand side", fontsize=10)
    figure.supylabel(label, fontsize=10)
    figure.suptitle(
        f"Pendulum, 1 kg, 1 m, released from the horizontal, 10 s: {what}\n"
        "blue: the method of the panel, relative and absolute tolerances "
        "$10^{-3}$, $10^{-5}$, $10^{-7}$, $10^{-9}$ from left to right; gray: all others",
        fontsize=10.5,
        color=style.GRAY,
    )
    return figure


FIGURES = (
    FigureSpec(
        "methods_motion",
        "Error of the motion over work",
        PENDULUMS,
        partial(
            panels,
            measure=motion_error,
            label="largest distance from the exact motion [m]",
            what="error of the motion over work",
        ),
    ),
    FigureSpec(
        "methods_energy",
        "Error of the energy over work",
        PENDULUMS,
        partial(
            panels,
            measure=energy_error,
            label="largest change of the energy [J]",
            what="error of the energy over work",
        ),
    ),
)
