"""The figures of the helicopter blade, Sect. 4.3: motion, errors and multipliers."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.lines import Line2D

from taut import style
from taut.report.drawing import AnimationSpec, FigureSpec, Spec
from taut.report.helicopter.animation import turning
from taut.report.helicopter.measures import SETTLED, fill, fitted, violation
from taut.report.helicopter.sketch import figure9
from taut.results import Array, Case, Results, Run

# Below, the penalty's fast oscillation; above it what the others do.
METHODS = ("penalty", "converged", "present", "baseline")
SETTINGS = (
    "Blade of Table 3; rtol $10^{-2}$, atol $10^{-4}$, honest error test, steps of at most 0.01 s. "
    "The growth of the penalty is the tolerance’s."
)
SMOOTH = ("present", "baseline")


def panels(results: Results) -> tuple[Figure, Array, dict[str, Run]]:
    """Returns a figure of two by two panels over the whole run with its legend, and the runs."""
    case, tight = results.case("figure10"), results.case("figure10_tight")
    runs = {method: tight.run("penalty") if method == "converged" else case.run(method) for method in METHODS}
    layout = ConstrainedLayoutEngine(w_pad=0.06, h_pad=0.06, hspace=0.04, wspace=0.04)
    figure, axes = plt.subplots(2, 2, figsize=(8.0, 5.6), layout=layout)
    t_end = max(float(run["t"][-1]) for run in runs.values())
    for panel in axes.flat:
        panel.set(xlim=(0, t_end), xlabel="time [s]")
        panel.axhline(0, color="#374151", linewidth=0.5, zorder=1)
    figure.legend(
        handles=legend(case, tight), loc="outside upper center", ncols=2, columnspacing=2.4, handlelength=3.4
    )
    figure.supxlabel(SETTINGS, fontsize=9.5, color=style.GRAY)
    return figure, axes, runs


def legend(case: Case, tight: Case) -> list[Artist]:
    """Returns the methods with their numbers of steps, in the paper's order."""
    entries: list[Artist] = []
    for method in ("baseline", "present", "penalty", "converged"):
        keywords = look(method, 2) | {"markevery": [1], "linewidth": 1.6}
        source, name = (tight, "penalty") if method == "converged" else (case, method)
        rejected = int(source.number(name, "rejected"))
        label = "penalty at rtol $10^{-6}$" if method == "converged" else style.method_style(method).label
        text = f"{label}: {source.steps(name):,} steps"
        entries.append(
            Line2D(
                [0, 0.5, 1], [0, 0, 0], label=text + f" + {rejected} rejected" * bool(rejected), **keywords
            )
        )
    return entries


def look(method: str, points: int) -> dict[str, object]:
    """Returns the keywords of a method's line; the penalty is too fast for dashes and markers."""
    keywords = style.method_style("penalty" if method == "converged" else method).line(points)
    if method == "converged":
        keywords |= {"color": "#7a4a00"}
    if method in ("penalty", "converged"):
        keywords |= {"linestyle": "solid", "linewidth": 0.7, "marker": "", "zorder": 1.5}
    if method == "present":
        # Wide enough to be seen below the baseline, which hardly differs.
        keywords |= {"linewidth": 3.0}
    return keywords


def figure10(results: Results) -> Figure:
    """Draws flap and pitch, angles on the left and rates on the right."""
    figure, axes, runs = panels(results)
    for row, (angle, name, symbol) in enumerate((("beta", "Flap", r"\beta"), ("theta", "Pitch", r"\theta"))):
        for method, run in runs.items():
            t, value, rate = fill(run, angle)
            keywords = look(method, len(t))
            if angle == "beta" and method in ("penalty", "converged"):
                # All flap alike: markers above the others show that these are there.
                shift = len(t) // 40 if method == "penalty" else len(t) // 16
                keywords |= {"marker": "P" if method == "penalty" else "x", "linestyle": "none", "zorder": 9}
                keywords |= {"markersize": 4.5, "markevery": (shift, max(len(t) // 11, 1))}
            axes[row, 0].plot(t, value, **keywords)
            axes[row, 1].plot(t, rate, **keywords)
        axes[row, 0].set(title=name, ylabel=rf"${symbol}$ [rad]")
        axes[row, 1].set(title=f"{name} rate", ylabel=rf"$\mathrm{{d}}{symbol}/\mathrm{{d}}t$ [rad/s]")
    return figure


def figure11(results: Results) -> Figure:
    """Draws the violation and its rate with their signs; without the penalty on the right."""
    case = results.case("figure10")
    figure, axes, runs = panels(results)
    signed = {method: violation(case.model, run) for method, run in runs.items()}
    rows = (
        ("Position", r"$\phi$", "m", (1e-3, 1e-12), ("$10^{-3}$ ", "$10^{-12}$ ")),
        ("Velocity", r"$\mathrm{d}\phi/\mathrm{d}t$", "m/s", (1.0, 1e-9), ("", "$10^{-9}$ ")),
    )
    for row, (name, symbol, unit, scales, powers) in enumerate(rows):
        for column, methods in enumerate((METHODS, SMOOTH)):
            for method in methods:
                t, value = runs[method]["t"], signed[method][row] / scales[column]
                axes[row, column].plot(t, value, **look(method, len(t)))
            axes[row, column].set(
                title=name + (", without the penalty" if column else ""),
                ylabel=f"{symbol} [{powers[column]}{unit}]",
            )
    return figure


def figure12(results: Results) -> Figure:
    """Draws the link's force, three times at three scales, and the multiplier of the velocity correction."""
    case = results.case("figure10")
    figure, axes, runs = panels(results)
    for panel, methods in ((axes[0, 0], METHODS), (axes[0, 1], SMOOTH)):
        for method in methods:
            t, force = runs[method]["t"], runs[method]["link_force"]
            panel.plot(t, force, **look(method, len(t)))
    axes[0, 0].set(title="Link force", ylabel="tension [N]")
    axes[0, 1].set(title="Link force, without the penalty", ylabel="tension [N]")
    for method in SMOOTH:
        t, mu = runs[method]["t"], runs[method]["mu"]
        axes[1, 0].plot(t, mu / 1e-8, **look(method, len(t)) | {"linewidth": 1.4})
    axes[1, 0].set(title="Velocity correction", ylabel=r"$\mu$ [$10^{-8}$ 1/(m s)]")
    settled_force(axes[1, 1], case, runs)
    return figure


def settled_force(axes: Axes, case: Case, runs: dict[str, Run]) -> None:
    """Draws the force once the start has died out: every step, and the harmonics that fit them."""
    t = np.linspace(SETTLED, SETTLED + 0.5, 501)
    mean, cosine, sine = fitted(case.model, runs["present"], "link_force")
    angle = case.model["omega"] * t[:, None] * np.arange(1, len(cosine) + 1)
    wave = mean + np.cos(angle) @ cosine + np.sin(angle) @ sine
    label = "1 to 5 per revolution, fitted"
    axes.plot(t, 1e3 * wave, color=style.METHODS["present"].color, linewidth=0.9, alpha=0.6, label=label)
    for method, size in (("present", 6.0), ("baseline", 3.4)):
        chosen = (runs[method]["t"] >= t[0] - 1e-9) & (runs[method]["t"] <= t[-1] + 1e-9)
        keywords = look(method, 2) | {"linestyle": "none", "markevery": None, "markersize": size}
        axes.plot(runs[method]["t"][chosen], 1e3 * runs[method]["link_force"][chosen], **keywords)
    axes.set(title=f"Link force after {SETTLED:g} s, at each step", ylabel="tension [mN]", xlim=(t[0], t[-1]))
    axes.set_ylim(top=1.35 * axes.get_ylim()[1])
    axes.legend(loc="upper right", fontsize=8.5)


FIGURES: tuple[Spec, ...] = (
    FigureSpec("helicopter_figure9", "Figure 9", ("figure10",), figure9),
    FigureSpec("helicopter_figure10", "Figure 10", ("figure10", "figure10_tight"), figure10),
    FigureSpec("helicopter_figure11", "Figure 11", ("figure10", "figure10_tight"), figure11),
    FigureSpec("helicopter_figure12", "Figure 12", ("figure10", "figure10_tight"), figure12),
    AnimationSpec("helicopter", "Animation", ("cyclic",), turning),
)
