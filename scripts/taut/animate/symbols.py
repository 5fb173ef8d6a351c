"""Joints, springs and supports as symbols that engineers know."""

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.patches import Polygon

from taut import style
from taut.animate import solids
from taut.animate.geometry import GROUND, Link, Mechanism
from taut.animate.moment import Moment
from taut.animate.motion import Motion
from taut.animate.parts import Between, Canvas, Dot, Part, Segment, Solid
from taut.results import Array
from taut.view import View

WHITE = {"color": "white", "markeredgecolor": style.DARK}
DARK = {"color": style.DARK, "markeredgecolor": "white"}
# Shapes that show themselves where they slide.
SHOWN = ("box", "cylinder", "sphere")


def joint_parts(canvas: Canvas, mechanism: Mechanism, motion: Motion, joint: Link, flat: bool) -> list[Part]:
    """Returns the symbol of a joint."""
    one, two = joint.bodies
    p, q = joint.points
    size = 2 * canvas.joint
    axis = joint.axes[1] if joint.axes else np.zeros(3)
    match joint.type:
        case "revolute" if flat:
            return [Dot(canvas, two, q, size, 2.0, **WHITE)]
        case "revolute":
            faces = solids.cylinder(0.85 * canvas.radius, 3.4 * canvas.radius, axis)
            return [Solid(canvas, two, faces, "#9aa3af", q, above=0.8)]
        case "spherical" if flat:
            return [Dot(canvas, two, q, size, 2.0, **WHITE)]
        case "spherical":
            return [Dot(canvas, two, q, 1.15 * size, 0.8, **DARK)]
        case "distance":
            ends = [Dot(canvas, b, at, 0.6 * size, 0.9, **DARK) for b, at in ((one, p), (two, q))]
            return [Between(canvas, joint.bodies, joint.points, "distance"), *ends]
        case "prismatic" | "cylindrical" | "in-line":
            return _sliding(canvas, mechanism, motion, joint, axis)
        case "universal":
            arms = ((one, p, joint.axes[0]), (two, q, joint.axes[1]))
            cross = [
                Segment(
                    canvas,
                    body,
                    at + np.outer([-2.2, 2.2], along) * canvas.radius,
                    0.9,
                    linewidth=0.5 * canvas.bar,
                )
                for body, at, along in arms
            ]
            return [*cross, Dot(canvas, two, q, 0.8 * size, 1.0, **WHITE)]
        case "rolling":
            return [Contact(canvas, contact(motion, joint))]
        case "knife-edge":
            ends = q + np.outer([-2.5, 2.5], joint.side) * canvas.radius
            return [Segment(canvas, two, ends, 1.0, linewidth=0.8 * canvas.bar)]
        case "fixed":
            return [Dot(canvas, two, q, size, 1.0, marker="s", **DARK)]
        case "planar":
            return [Dot(canvas, two, q, size, 1.0, marker="s", **WHITE)]
    return [Dot(canvas, two, q, 0.8 * size, 1.0, marker="D", **WHITE)]


def spiral(canvas: Canvas, spring: Link) -> Part:
    """Returns a torsion spring: a spiral about the axis of its joint, fixed to the second body."""
    frame = solids.along(spring.axes[1])
    turn = np.linspace(0, 5 * np.pi, 90)
    radius = canvas.radius * np.linspace(1.2, 3.2, 90)[:, None]
    points = radius * (np.outer(np.cos(turn), frame[:, 0]) + np.outer(np.sin(turn), frame[:, 1]))
    return Segment(canvas, spring.bodies[1], spring.points[1] + points, 1.8, linewidth=0.9)


def bushing(canvas: Canvas, spring: Link) -> list[Part]:
    """Returns a bushing: a ring of rubber on the first body about a pin on the second."""
    (one, two), (p, q) = spring.bodies, spring.points
    ring = {"color": "#9aa3af", "markeredgecolor": style.DARK}
    return [
        Dot(canvas, one, p, 3.4 * canvas.joint, 0.9, **ring),
        Dot(canvas, two, q, 1.4 * canvas.joint, 1.0, **WHITE),
    ]


def _sliding(canvas: Canvas, mechanism: Mechanism, motion: Motion, joint: Link, axis: Array) -> list[Part]:
    """Returns a rail as long as the travel and, unless the body shows itself, a block on it."""
    one, two = joint.bodies
    p, q = joint.points
    rail_axis = joint.axes[0]
    paths = [motion.point(anchor) for anchor in joint.anchors]
    travel = ((paths[1] - paths[0]) * motion.direction(one, rail_axis)).sum(axis=1)
    r = canvas.radius
    ends = p + np.outer([travel.min() - 4.5 * r, travel.max() + 4.5 * r], rail_axis)
    parts: list[Part] = []
    if mechanism.bodies.get(two) is None or mechanism.bodies[two].shape not in SHOWN:
        frame = solids.along(axis)
        if mechanism.planar:
            frame = np.stack([np.cross(axis, [0, 0, 1.0]), [0, 0, 1.0], axis], axis=1)
        if joint.type == "cylindrical":
            faces = solids.cylinder(1.6 * r, 6 * r, axis)
        elif joint.type == "prismatic":
            faces = [face @ frame.T for face in solids.box(np.array([3.6, 3.6, 6.0]) * r)]
        else:
            faces = []
        if faces:
            parts.append(Solid(canvas, two, faces, "#c3cad3", q, above=0.6))
        else:
            parts.append(Dot(canvas, two, q, 2 * canvas.joint, 1.0, **WHITE))
    parts.append(Segment(canvas, one, ends, -0.5, linewidth=1.2))
    if one == GROUND:
        parts.append(Rail(canvas, ends, joint.type == "prismatic"))
    return parts


class Rail:
    """The hatch below a rail on the ground."""

    def __init__(self, canvas: Canvas, ends: Array, block: bool) -> None:
        self.canvas, self.ends = canvas, ends
        # Below the block that slides on it.
        self.below = (1.8 if block else 0.0) * canvas.radius
        self.lines = LineCollection([], colors=style.DARK, linewidths=0.7, zorder=4)
        canvas.axes.add_collection(self.lines, autolim=False)

    def move(self, at: Moment) -> None:
        """Draws the hatch."""
        one, two = at.view.flat(self.ends)
        along = two - one
        length = float(np.linalg.norm(along)) or 1.0
        along = along / length
        down = np.array([along[1], -along[0]])
        down = down if down[1] <= 0 else -down
        self.lines.set_segments(hatch(one + self.below * down, along, down, length, self.canvas.radius))


def hatch(start: Array, along: Array, down: Array, length: float, radius: float) -> list[Array]:
    """Returns the line of a support and the strokes behind it."""
    strokes = max(int(length / (1.1 * radius)), 2)
    feet = start + np.outer((np.arange(strokes) + 0.7) / strokes * length, along)
    back = 1.0 * radius * (down - along)
    return [np.array([start, start + length * along]), *(np.array([foot, foot + back]) for foot in feet)]


class Support:
    """A pin on the ground: a triangle and a hatch, above or below it."""

    def __init__(self, canvas: Canvas, view: View, at: Array, above: bool) -> None:
        r = canvas.radius
        x, y = view.flat(at)
        up = 1.0 if above else -1.0
        layer = canvas.layer(float(view.depth(at)), -2.0)
        corners = [[x, y], [x - 1.9 * r, y + 3.2 * up * r], [x + 1.9 * r, y + 3.2 * up * r]]
        canvas.axes.add_patch(
            Polygon(corners, facecolor="white", edgecolor=style.DARK, linewidth=0.9, zorder=layer)
        )
        base = np.array([x - 2.9 * r, y + 3.2 * up * r])
        lines = hatch(base, np.array([1.0, 0.0]), np.array([0.0, up]), 5.8 * r, r)
        canvas.axes.add_collection(
            LineCollection(
                lines, colors=style.DARK, linewidths=[1.1, *[0.6] * (len(lines) - 1)], zorder=layer
            ),
            autolim=False,
        )

    def move(self, at: Moment) -> None:
        """The ground does not move."""


def contact(motion: Motion, joint: Link) -> Array:
    """Returns the path of the point where a disc touches its plane: (n, 3)."""
    normal, axes = joint.axes[0], motion.direction(joint.bodies[1], joint.axes[1])
    down = axes * (axes @ normal)[:, None] - normal
    down = down / np.maximum(np.linalg.norm(down, axis=1), 1e-300)[:, None]
    return motion.point(joint.anchors[1]) + joint.length * down


class Contact:
    """Where a disc touches its plane."""

    def __init__(self, canvas: Canvas, path: Array) -> None:
        self.path = path
        self.dot = Dot(canvas, GROUND, np.zeros(3), 1.4 * canvas.joint, 1.0, **DARK)

    def move(self, at: Moment) -> None:
        """Moves the point of contact."""
        self.dot.place = self.path[at.index]
        self.dot.move(at)


def supports(canvas: Canvas, mechanism: Mechanism, motion: Motion, view: View) -> list[Part]:
    """Returns a support for each point on the ground that carries a joint or a spring."""
    places: dict[tuple[float, ...], Support] = {}
    for link in [*mechanism.joints, *mechanism.springs]:
        if GROUND not in link.bodies or link.type in ("prismatic", "cylindrical", "in-line", "planar"):
            continue
        if link.type in ("rolling", "knife-edge", "coordinate", "torsion"):
            continue
        side = link.bodies.index(GROUND)
        at, other = link.points[side], link.bodies[1 - side]
        reach = np.linalg.norm(motion.positions[other] - at, axis=1).max()
        hangs = float((motion.positions[other].mean(axis=0) - at) @ canvas.up) < -0.15 * reach
        key = tuple(np.round(at, 9))
        if key not in places:
            places[key] = Support(canvas, view, at, hangs)
    return list(places.values())
