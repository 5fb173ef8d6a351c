"""The swing in motion: the markers leave traces, and beside it the force of the first link over time."""

from collections.abc import Iterator

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from taut import style
from taut.gif import cursor
from taut.report.swing import convergence
from taut.report.swing.measures import (
    MARKERS,
    SUPPORTS,
    event_time,
    positions,
    reference,
    sample,
)
from taut.report.swing.sketch import COLORS, LINK, Swing, ground
from taut.results import Results

FRAMES = 84
# The last frame stays for so many more.
HOLD = 12
EVENT = "#b3261e"


def swinging(results: Results) -> Iterator[Figure]:
    """Yields the frames of (3b), whose motion is closest to that of analysis (0) to the end."""
    run = results.case("3b").run("present")
    end = float(run["t"][-1])
    times = np.linspace(0.0, end, FRAMES)
    fine = np.linspace(0.0, end, 8 * (FRAMES - 1) + 1)
    path = sample(run["t"], positions(run), fine)
    figure = plt.figure(figsize=(7.2, 4.9), dpi=100, layout="constrained")
    grid = figure.add_gridspec(2, 1, height_ratios=(2.6, 1.0))
    axes = figure.add_subplot(grid[0])
    panel = figure.add_subplot(grid[1])
    traces = [axes.plot([], [], color=COLORS[m], linewidth=1.2, alpha=0.75, zorder=3)[0] for m in MARKERS]
    for m in range(len(MARKERS)):
        axes.plot(*positions(reference())[:, m].T, color="#d1d5db", linewidth=2.4, zorder=2)
    swing = Swing(axes)
    for support in SUPPORTS:
        ground(axes, support)
    axes.set(xlim=(-0.06, 1.16), ylim=(-0.17, 0.45))
    axes.axis("off")
    axes.set_title("Swing: modal model without the axial mode")
    clock = axes.text(0.56, 0.37, "", fontsize=11)
    told = axes.text(0.56, 0.31, "", fontsize=10, color=EVENT, fontweight="bold")
    panel.plot(run["t"], run["lambda1"], color=LINK, linewidth=0.9)
    dot = cursor(panel, "black")
    event = event_time(results, "3b")
    if event is not None:
        panel.axvline(event, color=EVENT, linewidth=1.0, linestyle=(0, (2, 2)))
        panel.annotate(
            "in line ",
            (event, 1.0),
            xycoords=("data", "axes fraction"),
            ha="right",
            va="top",
            color=EVENT,
            fontsize=9,
        )
    peaks = [f"peak {abs(run['lambda1']).max():.0f} N"]
    if forces := list(convergence.peaks(results).items())[-2:]:
        # The modal model is rougher than elements, whose peak converges.
        with_meshes = ", ".join(f"{force:.0f} N with {n}" for n, (force, _) in forces)
        peaks.append(f"finite elements: {with_meshes}")
    panel.annotate(
        "; ".join(peaks), (0.01, 0.97), xycoords="axes fraction", va="top", fontsize=9, color=style.GRAY
    )
    panel.set(xlim=(0, end), xlabel="time [s]", ylabel="link 1 [N]")
    panel.yaxis.label.set_color(style.GRAY)
    # The event itself lasts a few milliseconds; what is written about it stays for a while.
    for i in (*range(FRAMES), *[FRAMES - 1] * HOLD):
        t = float(times[i])
        swing.move(path[8 * i])
        for k, trace in enumerate(traces):
            trace.set_data(*path[: 8 * i + 1, k].T)
        clock.set_text(f"t = {t:.2f} s")
        after = event is not None and event <= t <= event + 0.15
        told.set_text(f"link 1 and A–C in line at {event:.3f} s" if after else "")
        dot.set_data([t], [np.interp(t, run["t"], run["lambda1"])])
        yield figure
