"""One turn of the rotor as an animation: the blade root on a moving swashplate, and curves beside it."""

from collections.abc import Iterator

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from taut.gif import cursor
from taut.report.helicopter.measures import fill, point_b
from taut.report.helicopter.sketch import HORN, LINK, Root
from taut.report.sketching import note
from taut.results import Array, Results, Run

FRAMES = 48


def turning(results: Results) -> Iterator[Figure]:
    """Yields the frames of the last turn of 'present', which starts over where it ends."""
    case = results.case("cyclic")
    model, run = case.model, case.run("present")
    turn = 2 * np.pi / model["omega"]
    # A whole number of turns from the start, so that the azimuth is zero.
    start = turn * (np.floor(float(run["t"][-1]) / turn) - 1)
    times = start + turn * np.arange(FRAMES) / FRAMES
    fine = start + turn * np.linspace(0, 1, 181)
    figure = plt.figure(figsize=(7.2, 3.6), dpi=100, layout="constrained")
    grid = figure.add_gridspec(3, 2, width_ratios=(1.35, 1.0))
    axes = figure.add_subplot(grid[:, 0])
    root = Root(axes, model)
    labels = [axes.text(0, 0, name, fontweight="bold", zorder=10) for name in "AB"]
    axes.set(xlim=(-0.33, 0.63), ylim=(-0.37, 0.22))
    axes.set_title("Blade root in the rotating frame")
    note(axes, "the swashplate moves B, the link turns the blade", (-0.32, -0.36), (0, 0))
    curves = (
        ("flap [°]", np.degrees(sample(run, "beta", fine)), "#4b6a88"),
        ("pitch [°]", np.degrees(sample(run, "theta", fine)), HORN),
        (r"$z_B$ [mm]", 1e3 * point_b(model, fine)[:, 2], LINK),
    )
    azimuth = np.linspace(0, 360, len(fine))
    dots = []
    for row, (name, values, color) in enumerate(curves):
        panel = figure.add_subplot(grid[row, 1])
        panel.plot(azimuth, values, color=color, linewidth=1.6)
        dots.append((cursor(panel, color), values))
        panel.set(xlim=(0, 360), ylabel=name, xticks=range(0, 361, 90))
        panel.margins(y=0.15)
        panel.tick_params(labelbottom=row == 2)
    panel.set_xlabel("azimuth [°]")
    beta, theta = (sample(run, angle, times) for angle in ("beta", "theta"))
    for i, t in enumerate(times):
        points = root.move(float(beta[i]), float(theta[i]), float(t))
        for label, name in zip(labels, "AB", strict=True):
            label.set_position(points[name] + (0.018, 0.012))
        at = 360.0 * i / FRAMES
        for dot, values in dots:
            dot.set_data([at], [np.interp(at, azimuth, values)])
        yield figure


def sample(run: Run, angle: str, times: Array) -> Array:
    """Returns an angle at times between the steps."""
    t, value, _ = fill(run, angle)
    return np.interp(times, t, value)
