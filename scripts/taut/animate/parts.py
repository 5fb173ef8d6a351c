"""What a picture is made of: each part draws itself once and moves to where it is at a moment."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import to_rgb
from matplotlib.patheffects import Normal, Stroke
from scipy.interpolate import CubicSpline
from scipy.spatial import ConvexHull, QhullError

from taut import style
from taut.animate.moment import Moment
from taut.animate.solids import normal
from taut.results import Array

SHADOW = "#e3e6ea"
# Heights of the layers: shadows below, then what is sorted by depth, then what is written.
ON_FLOOR, BODIES, NAMES = 1.0, 10.0, 40.0
# Of names [points].
SIZE = 9.5
# Where the light comes from: in the picture to the right, up, and out of it.
LIGHT = np.array([-0.35, 0.6, 0.72])


class Part(Protocol):
    """A part of the picture."""

    def move(self, at: Moment) -> None:
        """Shows the part as it is at a moment."""


@dataclass(frozen=True)
class Canvas:
    """Where parts are drawn: the panel, sizes, the depths that there are, and the floor's height."""

    axes: Axes
    # Width of a bar and radius of a joint [points], and a meter [points].
    bar: float
    joint: float
    meter: float
    depths: tuple[float, float]
    # What is up, and how high the floor is; None without a floor.
    up: Array
    floor: float | None = None
    alpha: float = 1.0

    @property
    def radius(self) -> float:
        """The radius of a joint [m]."""
        return self.joint / self.meter

    def layer(self, depth: float, above: float = 0.0) -> float:
        """Returns how high what has this depth lies in the picture."""
        low, high = self.depths
        return BODIES + 10.0 * (depth - low) / max(high - low, 1e-9) + above

    def on_floor(self, points: Array) -> Array:
        """Returns points dropped to the floor."""
        return points + np.outer((self.floor or 0.0) - points @ self.up, self.up)


def shade(color: str, factor: float) -> tuple[float, float, float]:
    """Returns a color lightened (above 1) or darkened (below 1)."""
    rgb = np.array(to_rgb(color))
    mixed = 1 - (1 - rgb) * (2 - factor) if factor > 1 else rgb * factor
    return tuple(np.clip(mixed, 0, 1))


class Bars:
    """Lines of a body as bars with a dark edge, and their shadow."""

    def __init__(self, canvas: Canvas, body: str, lines: list[Array], color: str, width: float) -> None:
        self.canvas, self.body, self.lines = canvas, body, lines
        keywords = {"capstyle": "round", "joinstyle": "round", "alpha": canvas.alpha}
        self.layers = [
            LineCollection([], colors=[shade(color, factor)], linewidths=w, **keywords)
            for factor, w in ((0.55, width + 0.22 * width + 0.5), (1.0, width))
        ]
        self.shadow = LineCollection(
            [], colors=SHADOW, linewidths=width, capstyle="round", zorder=ON_FLOOR + 0.5
        )
        if canvas.floor is not None and canvas.alpha == 1:
            canvas.axes.add_collection(self.shadow, autolim=False)
        for layer in self.layers:
            canvas.axes.add_collection(layer, autolim=False)

    def move(self, at: Moment) -> None:
        """Moves the bars."""
        lines = [at.points(self.body, line) for line in self.lines]
        depth = float(np.mean([at.view.depth(line).mean() for line in lines]))
        for i, layer in enumerate(self.layers):
            layer.set_segments([at.view.flat(line) for line in lines])
            layer.set_zorder(self.canvas.layer(depth) + 0.01 * i)
        self.shadow.set_segments([at.view.flat(self.canvas.on_floor(line)) for line in lines])


class Solid:
    """A convex solid: the faces that can be seen, lit from above, and its shadow."""

    def __init__(
        self,
        canvas: Canvas,
        body: str,
        faces: list[Array],
        color: str,
        at: Array | None = None,
        above: float = 0.0,
    ) -> None:
        self.canvas, self.body, self.color, self.above = canvas, body, color, above
        offset = np.zeros(3) if at is None else at
        self.faces = [face + offset for face in faces]
        self.normals = np.array([normal(face) for face in faces])
        self.polygons = PolyCollection([], linewidths=0.4, alpha=canvas.alpha)
        canvas.axes.add_collection(self.polygons, autolim=False)
        self.shadow = PolyCollection([], facecolors=SHADOW, edgecolors="none", zorder=ON_FLOOR + 0.5)
        if canvas.floor is not None and canvas.alpha == 1 and above == 0:
            canvas.axes.add_collection(self.shadow, autolim=False)

    def move(self, at: Moment) -> None:
        """Moves the solid."""
        faces = [at.points(self.body, face) for face in self.faces]
        normals = at.directions(self.body, self.normals)
        seen = [i for i in range(len(faces)) if normals[i] @ at.view.out > 1e-9]
        frame = np.stack([at.view.right, at.view.up, at.view.out], axis=1)
        colors = [shade(self.color, 0.72 + 0.75 * max(float(normals[i] @ frame @ LIGHT), 0.0)) for i in seen]
        self.polygons.set_verts([at.view.flat(faces[i]) for i in seen])
        self.polygons.set_facecolor(colors)
        # Strips of a curved side have no edges.
        dark = shade(self.color, 0.5)
        curved = len(self.faces) > 6
        self.polygons.set_edgecolor(
            [color if curved and i > 1 else dark for i, color in zip(seen, colors, strict=True)]
        )
        corners = np.concatenate(faces)
        self.polygons.set_zorder(self.canvas.layer(float(at.view.depth(corners).mean()), self.above))
        outline = hull(at.view.flat(self.canvas.on_floor(corners)))
        self.shadow.set_verts([outline] if len(outline) else [])


def hull(points: Array) -> Array:
    """Returns the corners of the convex hull of points in the picture; none if they are in line."""
    try:
        return points[ConvexHull(points).vertices]
    except QhullError:
        return points[:0]


class Plate:
    """The hull of points of a body, pale: what a body of which only joints are known may look like."""

    def __init__(self, canvas: Canvas, body: str, points: Array, color: str) -> None:
        self.canvas, self.body, self.corners = canvas, body, points
        self.polygon = PolyCollection([], facecolors=[color], edgecolors="none", alpha=0.35 * canvas.alpha)
        canvas.axes.add_collection(self.polygon, autolim=False)

    def move(self, at: Moment) -> None:
        """Moves the plate."""
        corners = at.points(self.body, self.corners)
        outline = hull(at.view.flat(corners))
        self.polygon.set_verts([outline] if len(outline) else [])
        self.polygon.set_zorder(self.canvas.layer(float(at.view.depth(corners).mean()), -0.1))


class Dot:
    """A point of a body as a marker of a size in points."""

    def __init__(
        self, canvas: Canvas, body: str, at: Array, size: float, above: float = 0.5, **keywords: object
    ) -> None:
        self.canvas, self.body, self.place, self.above = canvas, body, at, above
        keywords = {"marker": "o", "markeredgewidth": 0.8, "alpha": canvas.alpha} | keywords
        (self.line,) = canvas.axes.plot([], [], markersize=size, linestyle="", **keywords)

    def move(self, at: Moment) -> None:
        """Moves the marker."""
        point = at.points(self.body, self.place)
        self.line.set_data(*at.view.flat(point).T)
        self.line.set_zorder(self.canvas.layer(float(at.view.depth(point)[0]), self.above))


class Ball:
    """A sphere: a disk with a light spot, and its shadow."""

    def __init__(self, canvas: Canvas, body: str, radius: float, color: str) -> None:
        size = 2 * radius * canvas.meter
        self.dots = [
            Dot(canvas, body, np.zeros(3), size, 0.0, color=color, markeredgecolor=shade(color, 0.5)),
            Dot(canvas, body, np.zeros(3), 0.35 * size, 0.01, color=shade(color, 1.5), markeredgewidth=0),
        ]
        self.shift = radius * 0.35

    def move(self, at: Moment) -> None:
        """Moves the sphere."""
        for dot in self.dots:
            dot.move(at)
        x, y = self.dots[1].line.get_data()
        self.dots[1].line.set_data(x - self.shift, y + self.shift)


class Curve:
    """A smooth curve through the nodes of a beam."""

    def __init__(self, canvas: Canvas, nodes: list[str], color: str) -> None:
        self.canvas, self.nodes = canvas, nodes
        (self.line,) = canvas.axes.plot([], [], color=color, linewidth=0.8 * canvas.bar, alpha=canvas.alpha)

    def move(self, at: Moment) -> None:
        """Moves the beam."""
        points = np.concatenate([at.points(node, np.zeros(3)) for node in self.nodes])
        along = np.arange(len(points))
        fine = np.linspace(0, len(points) - 1, 12 * (len(points) - 1) + 1)
        curve = CubicSpline(along, points)(fine) if len(points) > 2 else points
        self.line.set_data(*at.view.flat(curve).T)
        self.line.set_zorder(self.canvas.layer(float(at.view.depth(points).mean())))


class Between:
    """A line in the picture between a point of one body and one of another: straight, zigzag or a dashpot."""

    def __init__(
        self, canvas: Canvas, bodies: tuple[str, str], points: tuple[Array, Array], kind: str
    ) -> None:
        self.canvas, self.bodies, self.ends, self.kind = canvas, bodies, points, kind
        width = 0.45 * canvas.bar if kind == "distance" else 1.1
        (self.line,) = canvas.axes.plot(
            [], [], color=style.DARK, linewidth=max(width, 1.0), alpha=canvas.alpha, solid_joinstyle="miter"
        )

    def move(self, at: Moment) -> None:
        """Moves the line."""
        space = np.concatenate([at.points(b, p) for b, p in zip(self.bodies, self.ends, strict=True)])
        one, two = at.view.flat(space)
        length = float(np.linalg.norm(two - one)) or 1.0
        forward = (two - one) / length
        across = np.array([-forward[1], forward[0]])
        x, y = symbol(self.kind, length, self.canvas.radius)
        self.line.set_data(*(one + np.outer(x, forward) + np.outer(y, across)).T)
        self.line.set_zorder(self.canvas.layer(float(at.view.depth(space).mean()), 1.5))


def symbol(kind: str, length: float, radius: float) -> tuple[Array, Array]:
    """Returns a symbol from 0 to a length along x, its half height some radii of a joint."""
    if kind == "spring":
        turns = 8
        lead = 0.14 * length
        x = np.concatenate([[0], np.linspace(lead, length - lead, 2 * turns + 1), [length]])
        y = np.concatenate([[0, 0], np.tile([1.0, -1.0], turns)[:-1], [0, 0]]) * 2.2 * radius
        return x, y
    if kind == "damper":
        # A rod with a piston in a cup.
        a, b, h = 0.4 * length, 0.62 * length, 1.5 * radius
        x = np.array(
            [0, a, a, b, np.nan, a, a, b, np.nan, 0.5 * length, 0.5 * length, np.nan, 0.5 * length, length]
        )
        y = np.array([0, 0, h, h, np.nan, 0, -h, -h, np.nan, 0.7 * h, -0.7 * h, np.nan, 0, 0])
        return x, y
    return np.array([0.0, length]), np.zeros(2)


class Segment:
    """A straight piece of a body, such as an axis, a rail or an edge."""

    def __init__(
        self, canvas: Canvas, body: str, ends: Array, above: float = 0.0, **keywords: object
    ) -> None:
        self.canvas, self.body, self.ends, self.above = canvas, body, ends, above
        keywords = {"color": style.DARK, "alpha": canvas.alpha} | keywords
        (self.line,) = canvas.axes.plot([], [], **keywords)

    def move(self, at: Moment) -> None:
        """Moves the piece."""
        ends = at.points(self.body, self.ends)
        self.line.set_data(*at.view.flat(ends).T)
        self.line.set_zorder(self.canvas.layer(float(at.view.depth(ends).mean()), self.above))


class Name:
    """A name beside a point of a body, on the side away from other points of it."""

    def __init__(self, canvas: Canvas, body: str, at: Array, others: Array, text: str, color: str) -> None:
        self.body, self.places, self.gap = body, np.array([at, *others]), canvas.joint + 2.0
        self.text = canvas.axes.annotate(
            text,
            (0, 0),
            xytext=(0, 0),
            textcoords="offset points",
            ha="center",
            va="center",
            color=color,
            fontsize=SIZE,
            fontweight="bold",
            zorder=NAMES,
            path_effects=[Stroke(linewidth=2.2, foreground="white"), Normal()],
        )

    def move(self, at: Moment) -> None:
        """Moves the name."""
        point, *others = at.view.flat(at.points(self.body, self.places))
        away = self._away(point, np.array(others))
        half = np.array([0.27 * SIZE * len(self.text.get_text()), 0.4 * SIZE])
        self.text.xy = tuple(point)
        self.text.set_position(tuple(away * (self.gap + half)))

    @staticmethod
    def _away(point: Array, others: Array) -> Array:
        """Returns the direction in which there is room: away from other points or, between them, across."""
        out = point - others.mean(axis=0)
        if len(others) > 1:
            far = others[np.argmax(np.linalg.norm(others - point, axis=1))] - point
            across = np.array([-far[1], far[0]])
            out = across * (np.sign(across @ out) if abs(across @ out) > 1e-6 * (across @ across) else 1.0)
        length = float(np.linalg.norm(out))
        return out / length if length > 0 else np.array([0.0, 1.0])
