"""Stills, animations and curves over time of a mechanism."""

from collections.abc import Iterator
from dataclasses import dataclass

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from taut import style
from taut.animate.geometry import Mechanism
from taut.animate.motion import Motion
from taut.animate.scene import Look, Scene, nice
from taut.gif import cursor
from taut.results import Array, Run

WIDTH, SCENE, CURVE = 7.2, 4.6, 1.2
# Endings of columns and what they mean.
UNITS = (
    ((".fx", ".fy", ".fz", ".f1", ".f2", ".f3"), "force [N]"),
    ((".mx", ".my", ".mz", ".m1", ".m2", ".m3"), "moment [N m]"),
    ((".vx", ".vy", ".vz"), "velocity [m/s]"),
    ((".wx", ".wy", ".wz"), "angular velocity [rad/s]"),
    ((".angle",), "angle [rad]"),
    ((".x", ".y", ".z", ".displacement"), "position [m]"),
    (("energy",), "energy [J]"),
)


def unit_of(column: str) -> str:
    """Returns what a column is, with its unit; others are named themselves."""
    return next((text for ends, text in UNITS if column.endswith(ends)), column)


def labeled(column: str) -> str:
    """Returns a column's name and, below it, its unit if it is known."""
    unit = unit_of(column).partition("[")[2]
    return f"{column}\n[{unit}" if unit else column


@dataclass(frozen=True)
class Shown:
    """A mechanism, its motion and how it is looked at."""

    mechanism: Mechanism
    motion: Motion
    look: Look = Look()
    title: str = ""

    @property
    def name(self) -> str:
        """What is written above the picture."""
        name = self.mechanism.name.replace("_", " ")
        return self.title or (f"{name}: {self.motion.about}" if self.motion.about else name)

    @property
    def mode(self) -> bool:
        """Whether it is a mode about an equilibrium."""
        return self.mechanism.static and len(self.motion.times) > 1

    def part(self, times: Array) -> "Shown":
        """Returns the same at other times."""
        return Shown(self.mechanism, self.motion.at(times), self.look, self.title)


def still(shown: Shown, time: float, strobe: int = 0) -> Figure:
    """Draws a mechanism at a time, with its traces and faint earlier positions."""
    figure = plt.figure(figsize=(WIDTH, SCENE + 0.3))
    axes = figure.add_axes((0.02, 0.055, 0.96, 0.875))
    draw_still(axes, shown, time, strobe)
    return figure


def draw_still(axes: Axes, shown: Shown, time: float, strobe: int = 0) -> None:
    """Draws a still in a panel."""
    start = float(shown.motion.times[0])
    time = float(np.clip(time, start, shown.motion.times[-1]))
    inside = shown.motion.times[(shown.motion.times > start) & (shown.motion.times < time)]
    until = shown.part(np.concatenate([[start], inside, [time]]))
    # The first position of a mode is its equilibrium.
    strobe = max(strobe, int(shown.mode))
    earlier = np.linspace(start, time, strobe + 1)[:-1]
    scene = Scene(axes, shown.mechanism, until.motion, shown.look, earlier, whole=shown.motion)
    scene.move(len(until.motion.times) - 1)
    title(axes, shown.name, time if len(shown.motion.times) > 1 else None)
    scale(axes)


def scale(axes: Axes) -> None:
    """Draws a length to measure by, below on the left."""
    low, high = axes.get_xlim()
    length = nice(0.16 * (high - low))
    ends = np.array([0.015, 0.015 + length / (high - low)])
    keywords = {"color": style.GRAY, "transform": axes.transAxes, "clip_on": False}
    axes.plot(ends, [-0.03, -0.03], linewidth=1.4, marker="|", markersize=5, **keywords)
    axes.text(ends[1] + 0.015, -0.03, f"{length:g} m", va="center", fontsize=8.5, **keywords)


def title(axes: Axes, name: str, time: float | None) -> None:
    """Writes the name, and the time at the right."""
    axes.set_title(name, loc="left")
    if time is not None:
        axes.set_title(clock(time), loc="right", fontweight="normal", color=style.GRAY)


def clock(time: float) -> str:
    """Returns a time in milliseconds where it is short."""
    return f"$t$ = {time:.2f} s" if time == 0 or abs(time) >= 0.1 else f"$t$ = {1e3 * time:.1f} ms"


def frames(
    shown: Shown, times: Array, run: Run | None = None, columns: tuple[str, ...] = ()
) -> Iterator[Figure]:
    """Yields a picture for each time, with curves of columns below it."""
    height = 0.3 + SCENE + (CURVE * len(columns) + 0.5 if columns else 0)
    figure = plt.figure(figsize=(WIDTH, height))
    bottom = 1 - (0.3 + SCENE) / height
    axes = figure.add_axes((0.02, bottom + 0.08 / height, 0.96, (SCENE - 0.08) / height))
    at = shown.part(times)
    inside = shown.motion.times[(shown.motion.times > times[0]) & (shown.motion.times < times[-1])]
    fine = shown.part(np.union1d(inside, times)).motion
    rest = shown.motion.times[:1] if shown.mode else None
    scene = Scene(axes, at.mechanism, at.motion, at.look, rest, fine, shown.motion)
    dots = []
    for i, column in enumerate(columns):
        low = (0.45 + CURVE * (len(columns) - 1 - i)) / height
        panel = figure.add_axes((0.11, low, 0.86, (CURVE - 0.18) / height))
        panel.plot(run["t"], run[column], color=style.COLORS[i % 8], linewidth=1.2)
        panel.set(xlim=(times[0], times[-1]), ylabel=labeled(column))
        panel.tick_params(labelbottom=i == len(columns) - 1)
        dots.append((cursor(panel, style.COLORS[i % 8]), run[column]))
    if columns:
        panel.set_xlabel("time [s]")
    for i, time in enumerate(times):
        scene.move(i)
        title(axes, at.name, float(time))
        for dot, values in dots:
            dot.set_data([time], [np.interp(time, run["t"], values)])
        yield figure


def curves(name: str, run: Run, columns: list[str]) -> Figure:
    """Draws columns over time: those of one unit in one panel."""
    panels: dict[str, list[str]] = {}
    for column in columns:
        panels.setdefault(unit_of(column), []).append(column)
    figure, grid = plt.subplots(
        len(panels),
        1,
        figsize=(WIDTH, 0.5 + 2.1 * len(panels)),
        sharex=True,
        squeeze=False,
        layout="constrained",
    )
    for axes, (unit, members) in zip(grid[:, 0], panels.items(), strict=True):
        for i, column in enumerate(members):
            axes.plot(run["t"], run[column], label=column, linewidth=1.3, color=style.COLORS[i % 8])
        axes.set_ylabel(unit)
        if members != [unit]:
            axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
        # A constant is no noise at the scale of round-off.
        low, high = axes.get_ylim()
        if high - low < 1e-9 * max(abs(low), abs(high)):
            axes.set_ylim(*(np.array([-0.05, 0.05]) * max(abs(low), abs(high)) + (low + high) / 2))
    axes.set(xlabel="time [s]", xlim=(run["t"][0], run["t"][-1]))
    grid[0, 0].set_title(name.replace("_", " "))
    return figure
