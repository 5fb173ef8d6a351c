"""A mechanism in a panel: what can be seen of it, its supports, its floor and its traces."""

import re
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from scipy.interpolate import CubicSpline

from taut import style
from taut.animate import solids
from taut.animate.geometry import GROUND, Anchor, Body, Link, Mechanism
from taut.animate.moment import Moment
from taut.animate.motion import Motion
from taut.animate.parts import (
    NAMES,
    ON_FLOOR,
    Ball,
    Bars,
    Between,
    Canvas,
    Curve,
    Dot,
    Name,
    Part,
    Plate,
    Solid,
    shade,
)
from taut.animate.symbols import bushing, contact, joint_parts, spiral, supports
from taut.results import Array
from taut.view import View

# More bodies than this share the color of their group.
DISTINCT = 8
BEAM = "#0072B2"
OBLIQUE = (-60.0, 18.0)
# What goes less far out of a plane than this, of its size, is in the plane: it could not be seen.
FLAT = 1e-4


@dataclass(frozen=True)
class Look:
    """How a mechanism is looked at."""

    # Degrees about what is up, and above the level; None: OBLIQUE, or along the normal of a plane.
    view: tuple[float, float] | None = None
    # Bodies, points and joints that leave a trace; None: all &point groups.
    traces: tuple[str, ...] | None = None
    # Whether the names of points, and those of bodies, are written.
    points: bool = True
    names: bool = False
    # x_min, x_max, y_min, y_max of the picture [m]; None: all that is shown.
    window: tuple[float, float, float, float] | None = None


class Scene:
    """A mechanism in a panel; `move` shows it at the n-th time of its motion."""

    def __init__(
        self,
        axes: Axes,
        mechanism: Mechanism,
        motion: Motion,
        look: Look,
        strobe: Array | None = None,
        fine: Motion | None = None,
        whole: Motion | None = None,
    ) -> None:
        """Draws what moves and what does not.

        Args:
            axes: The panel.
            mechanism: What is drawn.
            motion: Where it is at the times that are shown.
            look: How it is looked at.
            strobe: Times at which it is drawn faintly.
            fine: The motion at closer times, for traces.
            whole: The motion at all times, which says from where it is seen and where it is drawn faintly.
        """
        self.mechanism, self.motion, self.fine = mechanism, motion, fine or motion
        whole = whole or motion
        corners = corners_of(mechanism, motion)
        face_on = face_on_view(mechanism, corners_of(mechanism, whole), look)
        self.flat = face_on is not None
        self.view = face_on or View.around(mechanism.up, *(look.view or OBLIQUE))
        up = self.view.up if self.flat else mechanism.up
        floor = None if self.flat else floor_height(mechanism, corners, up)
        grid = [] if floor is None else floor_grid(corners, up, floor)
        shown = np.concatenate([corners, *grid])
        flat, depths = self.view.flat(shown), self.view.depth(corners)
        self.canvas = canvas_of(axes, flat, depths, mechanism, up, floor, look)
        if floor is not None:
            lines = [self.view.flat(line) for line in grid]
            axes.add_collection(
                LineCollection(lines, colors="#d5dae0", linewidths=0.6, zorder=ON_FLOOR), autolim=False
            )
        colors = colors_of(mechanism)
        for i, time in enumerate([] if strobe is None else strobe):
            faint = 0.10 + 0.22 * (i + 1) / len(strobe)
            at = Moment(whole.at(np.array([time])), 0, self.view)
            canvas = Canvas(**{**vars(self.canvas), "alpha": faint, "depths": (0.0, 1e12)})
            for part in body_parts(canvas, mechanism, colors):
                part.move(at)
        self.parts = body_parts(self.canvas, mechanism, colors)
        for joint in mechanism.joints:
            self.parts += joint_parts(self.canvas, mechanism, motion, joint, self._is_ring(joint))
        for spring in mechanism.springs:
            if spring.type == "torsion":
                self.parts.append(spiral(self.canvas, spring))
            elif spring.type == "bushing":
                self.parts += bushing(self.canvas, spring)
            else:
                self.parts.append(Between(self.canvas, spring.bodies, spring.points, spring.type))
        self.parts += supports(self.canvas, mechanism, motion, self.view)
        self._points(look, colors)
        self._traces(look)
        axes.set_aspect("equal")
        axes.axis("off")
        if look.window and flat[:, 0].max() > look.window[1]:
            # What is cut off goes on.
            axes.annotate(
                "· · ·", (1.0, 0.5), xycoords="axes fraction", ha="right", fontsize=14, zorder=NAMES
            )

    def _is_ring(self, joint: Link) -> bool:
        """Tells whether a pin is seen along its axis, as a ring."""
        if joint.axes is None:
            return self.flat
        axis = self.motion.direction(joint.bodies[0], joint.axes[0])[0]
        return self.flat and abs(axis @ self.view.out) > 0.99

    def _points(self, look: Look, colors: dict[str, str]) -> None:
        """Marks points and writes names."""
        for name, anchor in self.mechanism.points.items():
            self.parts.append(
                Dot(
                    self.canvas,
                    anchor.body,
                    anchor.at,
                    1.5 * self.canvas.joint,
                    2.5,
                    color=TRACE[0],
                    markeredgecolor="white",
                )
            )
            if look.points:
                text = Name(self.canvas, anchor.body, anchor.at, np.zeros((1, 3)), name, "black")
                self.parts.append(text)
        if look.names:
            for name, body in self.mechanism.bodies.items():
                ends = ends_of(body)
                self.parts.append(Name(self.canvas, name, np.zeros(3), ends, name, colors[name]))

    def _traces(self, look: Look) -> None:
        """Draws the paths of points, which grow with time."""
        names = tuple(self.mechanism.points) if look.traces is None else look.traces
        paths = [self.fine.point(self.mechanism.anchor(name)) for name in names]
        paths += [contact(self.fine, joint) for joint in self.mechanism.joints if joint.type == "rolling"]
        self.traces = []
        self.times, paths = smooth(self.fine.times, paths)
        for i, path in enumerate(paths):
            color = TRACE[i % len(TRACE)]
            (line,) = self.canvas.axes.plot(
                [], [], color=color, linewidth=1.1, alpha=0.75, zorder=ON_FLOOR + 2
            )
            self.traces.append((line, self.view.flat(path)))

    def move(self, index: int) -> None:
        """Shows the mechanism at a time."""
        at = Moment(self.motion, index, self.view)
        for part in self.parts:
            part.move(at)
        past = np.searchsorted(self.times, self.motion.times[index] + 1e-12, side="right")
        for line, path in self.traces:
            line.set_data(*path[:past].T)


# So many points are drawn for each one that is known of a path.
BETWEEN = 6


def smooth(times: Array, paths: list[Array]) -> tuple[Array, list[Array]]:
    """Returns times and paths with points between, on cubics: bodies move on curves, not on polygons."""
    whole = np.concatenate([[True], np.diff(times) > 0])
    times, paths = times[whole], [path[whole] for path in paths]
    if len(times) < 4:
        return times, paths
    known = np.arange(len(times))
    fine = np.interp(np.arange(BETWEEN * (len(times) - 1) + 1) / BETWEEN, known, times)
    return fine, [CubicSpline(times, path)(fine) for path in paths]


# Traces differ from bodies.
TRACE = ("#b3261e", "#1b7f5c", "#5b4a9e", "#a15c00", "#006d8f", "#8a2f62", "#4d5b1a")


def colors_of(mechanism: Mechanism) -> dict[str, str]:
    """Returns a color for each body; copies of one group share theirs if there are many bodies."""
    names = list(mechanism.bodies)
    keys = names if len(names) <= DISTINCT else [re.sub(r"\d+", "", name) for name in names]
    order = list(dict.fromkeys(keys))
    return {
        name: style.COLORS[order.index(key) % len(style.COLORS)]
        for name, key in zip(names, keys, strict=True)
    }


def ends_of(body: Body) -> Array:
    """Returns points of a body that show how far it goes, in its axes."""
    points = [np.zeros(3), *body.attached]
    if body.shape == "rod":
        points += [side * body.size[0] / 2 * body.axis for side in (-1, 1)]
    elif body.shape in ("box", "cylinder", "sphere") or is_free(body):
        signs = np.array(np.meshgrid(*[[-0.5, 0.5]] * 3)).reshape(3, -1).T
        corners = signs * body.size
        points += list(corners @ solids.along(body.axis).T if body.shape == "cylinder" else corners)
    return np.array(points)


def is_free(body: Body) -> bool:
    """Tells whether only its inertia says what a body is: something is fixed to one place at most."""
    if body.shape != "inertia" or body.size.max() == 0:
        return False
    return len({tuple(np.round(at, 9)) for at in body.attached}) < 2


def outline(mechanism: Mechanism) -> list[Anchor]:
    """Returns the points that a picture must show."""
    found = [Anchor(name, at) for name, body in mechanism.bodies.items() for at in ends_of(body)]
    for link in [*mechanism.joints, *mechanism.springs]:
        if link.type not in ("rolling", "coordinate", "torsion"):
            found += [anchor for anchor in link.anchors if anchor.body == GROUND]
    return found


def corners_of(mechanism: Mechanism, motion: Motion) -> Array:
    """Returns where the points that a picture must show are at all times: (n, 3)."""
    return np.concatenate([motion.point(anchor) for anchor in outline(mechanism)])


def face_on_view(mechanism: Mechanism, corners: Array, look: Look) -> View | None:
    """Returns the view along the normal of the plane in which everything stays; None if there is no such."""
    if mechanism.planar:
        return View.of_plane()
    if look.view:
        return None
    centered = corners - corners.mean(axis=0)
    axes = np.linalg.eigh(centered.T @ centered)[1].T
    across, side, along = np.ptp(centered @ axes.T, axis=0)
    if across > FLAT * along:
        return None
    out = axes[0]
    if side <= FLAT * along:
        # All on a line: the plane is upright, or that with x or y if the line is so too.
        line = axes[2]
        other = next(e for e in (mechanism.up, *np.eye(3)) if np.linalg.norm(np.cross(line, e)) > 0.1)
        out = unit(np.cross(line, other))
    # Against gravity is up; in a level plane y is, or -z if y is its normal.
    _, y, z = np.eye(3)
    up = unit(
        next(a for a in (u - out * (u @ out) for u in (mechanism.up, y, -z)) if np.linalg.norm(a) > 0.1)
    )
    right = np.cross(up, out)
    sign = 1.0 if right[np.argmax(np.abs(right).round(6))] > 0 else -1.0
    return View(sign * right, up, sign * out)


def unit(direction: Array) -> Array:
    """Returns a direction of length 1."""
    return direction / np.linalg.norm(direction)


def floor_height(mechanism: Mechanism, corners: Array, up: Array) -> float:
    """Returns the height of the plane that something rolls on, or of one below everything."""
    for joint in mechanism.joints:
        if joint.type == "rolling" and joint.axes[0] @ up > 0.999:
            return float(joint.points[0] @ up)
    heights = corners @ up
    return float(heights.min() - 0.06 * np.ptp(corners, axis=0).max())


def canvas_of(
    axes: Axes, shown: Array, depths: Array, mechanism: Mechanism, up: Array, floor: float | None, look: Look
) -> Canvas:
    """Sets the limits of a panel to what is shown, and finds sizes that suit."""
    width, height = axes.get_position().size * axes.figure.get_size_inches() * 72
    low, high = shown.min(axis=0), shown.max(axis=0)
    if look.window:
        low, high = np.array(look.window[::2]), np.array(look.window[1::2])
    size = np.maximum(high - low, 1e-3 * max(high - low))
    reach = [np.ptp(ends_of(body), axis=0).max() for body in mechanism.bodies.values()]
    link = float(np.median([r for r in reach if r > 0] or [size.max()]))
    # Room for joints at the rim.
    for _ in range(3):
        meter = min(width / size[0], height / size[1])
        joint = float(np.clip(0.05 * link * meter, 1.1, 4.2))
        room = (0 if look.window else 5.0) * joint / meter
        size = high - low + 2 * room
    middle = (low + high) / 2
    half = np.array([width, height]) / meter / 2
    axes.set(xlim=(middle[0] - half[0], middle[0] + half[0]), ylim=(middle[1] - half[1], middle[1] + half[1]))
    bar = float(np.clip(0.06 * link * meter, 1.3, 5.0))
    return Canvas(axes, bar, joint, meter, (float(depths.min()), float(depths.max())), up, floor)


def body_parts(canvas: Canvas, mechanism: Mechanism, colors: dict[str, str]) -> list[Part]:
    """Returns the parts that show the bodies."""
    parts: list[Part] = [Curve(canvas, nodes, BEAM) for nodes in mechanism.beams]
    for name, body in mechanism.bodies.items():
        parts += one_body(canvas, body, colors[name])
    return parts


def one_body(canvas: Canvas, body: Body, color: str) -> list[Part]:
    """Returns a body as what it is: a rod, a solid, a point, or lines from its center to its joints."""
    if body.shape == "node":
        return [Dot(canvas, body.name, np.zeros(3), 0.9 * canvas.bar, color="white", markeredgecolor=BEAM)]
    if body.shape == "point":
        size = max(3.6 * canvas.joint, 5.0)
        return [Dot(canvas, body.name, np.zeros(3), size, 1.2, color=color, markeredgecolor="white")]
    if body.shape == "rod":
        half = body.size[0] / 2 * body.axis
        width = max(canvas.bar, body.size[1] * canvas.meter)
        return [Bars(canvas, body.name, [np.array([-half, half])], color, min(width, 3 * canvas.bar))]
    if body.shape == "sphere":
        return [Ball(canvas, body.name, body.size[0] / 2, color)]
    if body.shape == "cylinder":
        return round_parts(canvas, body.name, body.size[0] / 2, body.size[2], body.axis, color)
    if body.shape == "box":
        return [Solid(canvas, body.name, solids.box(body.size), color)]
    return general_body(canvas, body, color)


def general_body(canvas: Canvas, body: Body, color: str) -> list[Part]:
    """Returns lines from the center of mass to joints, a plate between them, and what has such an inertia."""
    parts: list[Part] = []
    spokes = [at for at in body.attached if np.linalg.norm(at) > 1e-9]
    if len(spokes) > 2:
        parts.append(Plate(canvas, body.name, np.array([np.zeros(3), *spokes]), color))
    if spokes:
        lines = [np.array([np.zeros(3), at]) for at in spokes]
        parts.append(Bars(canvas, body.name, lines, color, 0.75 * canvas.bar))
    if is_free(body):
        a = body.size
        pair = next((k for k in range(3) if abs(a[(k + 1) % 3] - a[(k + 2) % 3]) < 1e-3 * a.max()), None)
        if pair is None:
            parts.append(Solid(canvas, body.name, solids.box(a), color))
        else:
            # A disk or cylinder of the same inertia: m r^2/2 = m a^2/6.
            radius = a[(pair + 1) % 3] / np.sqrt(3)
            parts += round_parts(canvas, body.name, radius, a[pair], np.eye(3)[pair], color)
    else:
        keywords = {"color": "white", "markeredgecolor": color, "markeredgewidth": 1.2}
        parts.append(Dot(canvas, body.name, np.zeros(3), 1.2 * canvas.joint, 0.6, **keywords))
    return parts


def round_parts(
    canvas: Canvas, name: str, radius: float, length: float, axis: Array, color: str
) -> list[Part]:
    """Returns a cylinder or a disk with spokes on its caps, so that it is seen to turn."""
    parts: list[Part] = [Solid(canvas, name, solids.cylinder(radius, length, axis), color)]
    if length < 2 * radius:
        parts.append(Spokes(canvas, name, radius, length, axis, color))
    return parts


class Spokes:
    """Lines on that cap of a disk that can be seen."""

    def __init__(
        self, canvas: Canvas, body: str, radius: float, length: float, axis: Array, color: str
    ) -> None:
        self.canvas, self.body, self.axis, self.length = canvas, body, axis, length
        frame = solids.along(axis)
        turns = np.linspace(0, 2 * np.pi, 6, endpoint=False)
        self.rim = radius * (np.outer(np.cos(turns), frame[:, 0]) + np.outer(np.sin(turns), frame[:, 1]))
        colors = [shade(color, 0.45), *[shade(color, 0.8)] * 5]
        self.lines = LineCollection([], colors=colors, linewidths=[1.6, *[0.7] * 5], alpha=canvas.alpha)
        canvas.axes.add_collection(self.lines, autolim=False)

    def move(self, at: Moment) -> None:
        """Moves the spokes."""
        out = float(np.sign(at.directions(self.body, self.axis)[0] @ at.view.out)) or 1.0
        center = out * self.length / 2 * self.axis
        ends = at.view.flat(at.points(self.body, np.concatenate([[center], center + self.rim])))
        self.lines.set_segments([np.array([ends[0], end]) for end in ends[1:]])
        middle = float(at.view.depth(at.points(self.body, np.zeros(3)))[0])
        self.lines.set_zorder(self.canvas.layer(middle, 0.01))


def floor_grid(corners: Array, up: Array, height: float) -> list[Array]:
    """Returns the lines of a grid on the floor below what is shown."""
    frame = solids.along(up)
    flat = corners @ frame
    low, high = flat[:, :2].min(axis=0), flat[:, :2].max(axis=0)
    step = nice(max(high - low) / 6)
    low, high = np.floor(low / step - 0.05) * step, np.ceil(high / step + 0.05) * step
    lines = []
    for k in (0, 1):
        for value in np.arange(low[k], high[k] + step / 2, step):
            ends = np.zeros((2, 3))
            ends[:, k] = value
            ends[:, 1 - k] = low[1 - k], high[1 - k]
            ends[:, 2] = height
            lines.append(ends @ frame.T)
    return lines


def nice(value: float) -> float:
    """Returns a number near a value that is 1, 2 or 5 times a power of ten."""
    power = 10.0 ** np.floor(np.log10(max(value, 1e-12)))
    return float(min((1, 2, 5, 10), key=lambda m: abs(np.log(m * power / max(value, 1e-12)))) * power)
