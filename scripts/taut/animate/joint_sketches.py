"""One sketch for each joint: its axes 1, 2, 3, what it carries and leaves free, which way is positive.

An arrow along an axis stands for a force or a sliding, one round an axis for a moment or a turn. Orange is
what the joint carries (positive: on body 2, this way), green is free (positive: body 2 against body 1, this
way).
"""

import argparse
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from taut import style
from taut.animate.solids import box, cylinder, normal
from taut.bootstrap import ROOT
from taut.results import Array

CARRIED, FREE, DARK = "#D55E00", "#009E73", "#374151"
BODY_1, BODY_2 = "#c3c8d0", "#5aa5d8"
# From afar: axis 1 to the left and towards the eye, axis 2 to the right, axis 3 up.
TURN, HEIGHT = np.radians(33), np.radians(21)
EYE = np.array([np.cos(HEIGHT) * np.cos(TURN), np.cos(HEIGHT) * np.sin(TURN), np.sin(HEIGHT)])
RIGHT = np.array([-np.sin(TURN), np.cos(TURN), 0.0])
UP = np.cross(EYE, RIGHT)
LIGHT = np.array([0.55, 0.35, 0.76])


@dataclass(frozen=True)
class Sketch:
    """A joint as it is drawn, its point in the origin."""

    bodies: Callable[["Panel"], None]
    # Components of force and moment that it carries, and what its drives and outputs are called.
    carried: str
    free: str
    names: dict[str, str] = field(default_factory=dict)
    # Axes 1, 2, 3 on the paper, in rows, where they begin and how long they are.
    axes: tuple[tuple[float, ...], ...] = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
    at: tuple[float, ...] = (0, 0, 0)
    reach: float = 1.25
    # Where the word of a force along an axis stands that is not upright: above it, or below.
    above: float = 0.2


class Panel:
    """Solids, lines and arrows seen from afar; what is drawn later lies above."""

    def __init__(self, axes: Axes) -> None:
        """Empties the panel."""
        self.axes = axes
        self.layer = 1
        axes.set_aspect("equal")
        axes.axis("off")

    def seen(self, points: Array) -> Array:
        """Returns points on the paper."""
        return np.stack([np.asarray(points) @ RIGHT, np.asarray(points) @ UP], axis=-1)

    def solid(self, faces: list[Array], color: str, at: tuple[float, float, float] = (0, 0, 0)) -> None:
        """Draws the faces of a convex solid that can be seen."""
        self.layer += 1
        for face in faces:
            out = normal(face)
            if out @ EYE <= 0:
                continue
            shade = 0.72 + 0.28 * max(0.0, float(out @ LIGHT))
            rgb = np.array(plt.matplotlib.colors.to_rgb(color)) * shade
            xy = self.seen(face + np.array(at))
            edge = rgb * 0.82 if len(faces) == 6 or len(face) > 4 else rgb
            self.axes.fill(*xy.T, facecolor=rgb, edgecolor=edge, linewidth=0.5, zorder=self.layer)

    def box(self, color: str, size: tuple[float, ...], at: tuple[float, ...] = (0, 0, 0)) -> None:
        """Draws a box."""
        self.solid(box(np.array(size)), color, at)

    def rod(self, color: str, radius: float, start: tuple[float, ...], end: tuple[float, ...]) -> None:
        """Draws a round rod."""
        a, b = np.array(start, float), np.array(end, float)
        length = float(np.linalg.norm(b - a))
        self.solid(cylinder(radius, length, (b - a) / length), color, tuple((a + b) / 2))

    def ball(self, color: str, radius: float, at: tuple[float, ...] = (0, 0, 0)) -> None:
        """Draws a ball."""
        self.layer += 1
        x, y = self.seen(np.array(at))
        rgb = np.array(plt.matplotlib.colors.to_rgb(color))
        self.axes.add_patch(
            plt.Circle(
                (x, y), radius, facecolor=rgb * 0.93, edgecolor=rgb * 0.75, linewidth=0.6, zorder=self.layer
            )
        )

    def line(self, points: list[tuple[float, ...]], color: str = DARK, **keywords: object) -> None:
        """Draws a line."""
        self.layer += 1
        keywords = {"linewidth": 0.9, "zorder": self.layer} | keywords
        self.axes.plot(*self.seen(np.array(points)).T, color=color, **keywords)

    def arrow(self, start: Array, end: Array, color: str, width: float = 1.8) -> None:
        """Draws an arrow."""
        self.layer += 1
        a, b = self.seen(np.array([start, end]))
        self.axes.annotate(
            "",
            b,
            a,
            annotation_clip=False,
            arrowprops={
                "arrowstyle": "-|>,head_width=0.22,head_length=0.5",
                "color": color,
                "linewidth": width,
                "shrinkA": 0,
                "shrinkB": 0,
            },
            zorder=self.layer,
        )

    def turn(self, center: Array, axis: Array, color: str, radius: float = 0.2) -> None:
        """Draws an arrow round an axis, by the right hand."""
        first = np.cross(axis, EYE)
        first /= np.linalg.norm(first)
        second = np.cross(axis, first)
        angle = np.radians(np.linspace(-60, 215, 60))[:, None]
        points = center + radius * (np.cos(angle) * first + np.sin(angle) * second)
        self.line([tuple(p) for p in points[:-6]], color, linewidth=1.8, solid_capstyle="butt")
        self.arrow(points[-8], points[-1], color)

    def text(self, at: Array, text: str, color: str = DARK, size: float = 10, **keywords: object) -> None:
        """Writes beside a place."""
        keywords = {"ha": "center", "va": "center"} | keywords
        self.axes.text(*self.seen(np.array(at)), text, color=color, fontsize=size, zorder=99, **keywords)


def spherical(panel: Panel) -> None:
    """Draws a ball in a cup."""
    panel.box(BODY_1, (0.8, 0.8, 0.12), (0, 0, -0.7))
    panel.rod(BODY_1, 0.27, (0, 0, -0.64), (0, 0, -0.06))
    panel.rod(BODY_2, 0.09, (-0.1, -0.14, 0.1), (-0.45, -0.66, 0.5))
    panel.ball(BODY_2, 0.25)


def revolute(panel: Panel) -> None:
    """Draws a pin in a bearing."""
    panel.box(BODY_1, (0.3, 0.8, 0.24), (0, -0.6, -0.1))
    panel.rod(BODY_1, 0.26, (0, 0, -0.32), (0, 0, 0.12))
    panel.rod(BODY_2, 0.12, (0, 0, 0.12), (0, 0, 0.3))
    panel.box(BODY_2, (1.3, 0.26, 0.12), (-0.5, 0, 0.36))


def prismatic(panel: Panel) -> None:
    """Draws a sleeve on a square rail."""
    panel.box(BODY_1, (0.22, 0.22, 0.75), (0, 0, -0.55))
    panel.box(BODY_2, (0.5, 0.5, 0.5))
    panel.box(BODY_1, (0.22, 0.22, 0.45), (0, 0, 0.475))


def cylindrical(panel: Panel) -> None:
    """Draws a sleeve on a round rail."""
    panel.rod(BODY_1, 0.12, (0, 0, -0.9), (0, 0, -0.25))
    panel.rod(BODY_2, 0.28, (0, 0, -0.25), (0, 0, 0.25))
    panel.rod(BODY_1, 0.12, (0, 0, 0.25), (0, 0, 0.7))


def universal(panel: Panel) -> None:
    """Draws a cross between two forks: axis_1 in the fork of body 1, axis_2 in that of body 2."""
    panel.box(BODY_1, (0.2, 0.16, 1.0), (0, -0.62, 0.0))
    panel.box(BODY_1, (0.2, 0.66, 0.14), (0, -0.31, -0.43))
    panel.rod(DARK, 0.06, (0, 0, -0.36), (0, 0, 0.36))
    panel.rod(DARK, 0.06, (0, -0.33, 0), (0, 0.33, 0))
    panel.box(BODY_1, (0.2, 0.66, 0.14), (0, -0.31, 0.43))
    panel.box(BODY_2, (0.14, 0.86, 0.2), (-0.5, 0, 0))
    panel.box(BODY_2, (0.6, 0.12, 0.2), (-0.17, -0.38, 0))
    panel.box(BODY_2, (0.6, 0.12, 0.2), (-0.17, 0.38, 0))


def planar(panel: Panel) -> None:
    """Draws a block on a plate."""
    panel.box(BODY_1, (1.7, 1.7, 0.08), (0, 0, -0.04))
    panel.box(BODY_2, (0.6, 0.6, 0.3), (0, 0, 0.15))


def in_line(panel: Panel) -> None:
    """Draws a point of a body on a straight line."""
    panel.box(BODY_1, (0.5, 0.5, 0.1), (0, 0, -0.85))
    panel.rod(BODY_1, 0.05, (0, 0, -0.8), (0, 0, 0.6))
    panel.rod(BODY_2, 0.1, (-0.1, -0.14, 0.1), (-0.5, -0.66, 0.45))
    panel.ball(BODY_2, 0.16)


def fixed(panel: Panel) -> None:
    """Draws two blocks in one."""
    panel.box(BODY_1, (0.8, 0.8, 0.4), (0, 0, -0.2))
    panel.box(BODY_2, (0.5, 0.5, 0.4), (0, 0, 0.2))


def distance(panel: Panel) -> None:
    """Draws two points and the line between them."""
    panel.box(BODY_1, (0.5, 0.5, 0.1), (0, -0.9, -0.3))
    panel.rod(BODY_1, 0.08, (0, -0.9, -0.25), (0, -0.9, 0))
    panel.line([(0, -0.9, 0), (0, 0.7, 0.5)], linewidth=1.6)
    panel.ball(BODY_1, 0.09, (0, -0.9, 0))
    panel.box(BODY_2, (0.4, 0.5, 0.4), (0, 0.88, 0.62))
    panel.ball(BODY_2, 0.09, (0, 0.7, 0.5))
    pull = np.array([0, -1.6, -0.5]) / np.hypot(1.6, 0.5)
    end = np.array([0, 0.7, 0.5])
    panel.arrow(end + 0.1 * pull, end + 0.62 * pull, CARRIED)
    panel.text(end + 0.45 * pull + [0, 0, 0.24], "tension", CARRIED)
    panel.text((0, -0.3, 0.42), "length", DARK, 9)


def coordinate(panel: Panel) -> None:
    """Draws a point at a height above the origin."""
    panel.box(BODY_1, (1.1, 1.1, 0.06), (0, 0, -0.95))
    panel.line([(0, 0, -0.92), (0, 0, 0)], linestyle=(0, (4, 2)))
    panel.text((0, 0.3, -0.55), "value", DARK, 9)
    panel.box(BODY_2, (0.5, 0.5, 0.36), (-0.2, -0.28, 0.0))
    panel.ball(BODY_2, 0.1)


def rolling(panel: Panel) -> None:
    """Draws a disc on a plane."""
    panel.box(BODY_1, (2.0, 2.0, 0.06), (0, 0, -0.03))
    axis = np.array([1.0, -0.5, 0.25])
    axis /= np.linalg.norm(axis)
    up = np.array([0, 0, 1.0]) - axis[2] * axis
    center = 0.6 * up / np.linalg.norm(up)
    panel.solid(cylinder(0.6, 0.07, axis), BODY_2, tuple(center))
    panel.line([tuple(center), tuple(center + 0.42 * axis)], DARK, linewidth=1.2)
    panel.text(center + 0.56 * axis, "axis", DARK, 9)
    panel.ball(DARK, 0.035, (0, 0, 0.0))


def knife_edge(panel: Panel) -> None:
    """Draws a blade on a plane, on its edge."""
    panel.box(BODY_1, (1.9, 1.9, 0.06), (0, 0, -0.03))
    panel.box(BODY_2, (1.1, 0.05, 0.3), (0, 0, 0.15))
    panel.box(BODY_2, (0.8, 0.34, 0.16), (0, 0, 0.38))
    panel.ball(DARK, 0.035)


SKETCHES = {
    "spherical": Sketch(spherical, "f1 f2 f3", "t1 t2 t3"),
    "revolute": Sketch(revolute, "f1 f2 f3 m1 m2", "t3", {"t3": "angle"}),
    "prismatic": Sketch(prismatic, "f1 f2 m1 m2 m3", "s3", {"s3": "displacement"}),
    "cylindrical": Sketch(cylindrical, "f1 f2 m1 m2", "s3 t3", {"s3": "displacement", "t3": "angle"}),
    "universal": Sketch(universal, "f1 f2 f3 m1", "t2 t3", {"t2": "axis_2", "t3": "axis_1"}),
    "planar": Sketch(planar, "f3 m1 m2", "s1 s2 t3"),
    "in-line": Sketch(in_line, "f1 f2", "s3 t1 t2 t3"),
    "fixed": Sketch(fixed, "f1 f2 f3 m1 m2 m3", ""),
    "distance": Sketch(distance, "", "", at=(0, -0.9, 0), reach=0.6),
    "coordinate": Sketch(coordinate, "f3", "s1 s2 t1 t2 t3"),
    "rolling": Sketch(rolling, "f1 f2 f3", ""),
    "knife_edge": Sketch(
        knife_edge, "f3", "", {"f3": "f3, across"}, ((-1, 0, 0), (0, 0, 1), (0, 1, 0)), above=-0.24
    ),
}


def place(panel: Panel, sketch: Sketch, i: int, axis: Array) -> None:
    """Draws an axis, and what acts or moves along it and round it."""
    start = np.array(sketch.at, float)
    end = start + sketch.reach * axis
    # Words stand beside an axis that is upright, above and below one that is not.
    upright = abs(axis[2]) > 0
    slides, color = _kind(sketch, i, "fs")
    panel.line([tuple(start), tuple((start + end) / 2)], DARK, linewidth=0.8, linestyle=(0, (2, 2)))
    panel.arrow((start + end) / 2, end, color, 1.8 if slides else 0.8)
    panel.text(end + 0.14 * axis, str(i), DARK, 11, weight="bold")
    side = 0.2 * RIGHT if upright else np.array([0, 0, sketch.above])
    panel.text(end + side, slides, color, ha="left" if upright else "center")
    turns, color = _kind(sketch, i, "mt")
    if color != DARK:
        panel.turn(start + 0.62 * (end - start), axis, color)
        side = -0.28 * RIGHT if upright else np.array([0, 0, -0.3])
        panel.text(start + 0.62 * (end - start) + side, turns, color, ha="right" if upright else "center")


def _kind(sketch: Sketch, i: int, kinds: str) -> tuple[str, str]:
    """Returns the label and the color of a component: carried, free or neither."""
    carried, free = f"{kinds[0]}{i}", f"{kinds[1]}{i}"
    if carried in sketch.carried.split():
        return sketch.names.get(carried, carried), CARRIED
    if free in sketch.free.split():
        return sketch.names.get(free, " "), FREE
    return "", DARK


def draw(name: str) -> plt.Figure:
    """Draws a joint's sketch."""
    sketch = SKETCHES[name]
    figure, axes = plt.subplots(figsize=(3.1, 2.9))
    panel = Panel(axes)
    sketch.bodies(panel)
    for i in (1, 2, 3):
        along = np.array(sketch.axes[i - 1], float)
        place(panel, sketch, i, along)
    axes.set(xlim=(-1.3, 1.5), ylim=(-1.2, 1.5))
    figure.subplots_adjust(0, 0, 1, 1)
    return figure


def draw_all(folder: Path) -> list[Path]:
    """Draws all sketches."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    with plt.rc_context(style.RC):
        for name in SKETCHES:
            path = folder / f"{name}.png"
            figure = draw(name)
            style.save(figure, path, dpi=130)
            paths.append(path)
    return paths


def main() -> int:
    """Draws all sketches into the folder of the documents."""
    argparse.ArgumentParser(prog="scripts/sketches", description=__doc__).parse_args()
    for path in draw_all(ROOT / "cases" / "mechanism" / "joints"):
        print(path)
    return 0
