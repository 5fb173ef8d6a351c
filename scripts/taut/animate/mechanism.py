"""What a mechanism's case file says of its geometry, read as the app `mechanism` does, copies included."""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from taut.case_file import read_groups
from taut.errors import TautError
from taut.results import Array

GROUND = "ground"


@dataclass
class Body:
    """A body: its shape in body axes, where it starts, and what is fixed to it."""

    name: str
    # rod, box, sphere, cylinder, point, node (of a beam); empty if only its inertia is given.
    shape: str = ""
    # Sides along body axes [m]; of a sphere and a cylinder the diameters.
    size: Array = field(default_factory=lambda: np.zeros(3))
    position: Array = field(default_factory=lambda: np.zeros(3))
    rotation: Array = field(default_factory=lambda: np.eye(3))
    # Where joints, springs and points are, in body axes [m].
    attached: list[Array] = field(default_factory=list)


@dataclass(frozen=True)
class Anchor:
    """A point of a body or of the ground, in its axes [m]; one without a place is a whole body."""

    body: str
    at: Array | None = None


@dataclass(frozen=True)
class Link:
    """What is between two bodies: a joint, a spring or a damper; points and axis in the axes of each."""

    name: str
    type: str
    bodies: tuple[str, str]
    points: tuple[Array, Array]
    # Axis in global axes at the start; zero where there is none.
    axis: Array
    # The second axis of a universal joint, the radius of a disc that rolls.
    axis_2: Array
    radius: float = 0.0


@dataclass
class Mechanism:
    """Bodies, joints, springs, beams and points by name, as the case file has them before the assembly."""

    name: str
    planar: bool
    # Against gravity.
    up: Array
    bodies: dict[str, Body] = field(default_factory=dict)
    anchors: dict[str, Anchor] = field(default_factory=lambda: {GROUND: Anchor(GROUND)})
    joints: list[Link] = field(default_factory=list)
    springs: list[Link] = field(default_factory=list)
    # The names of each beam's nodes.
    beams: list[list[str]] = field(default_factory=list)
    # What &point groups write out.
    points: dict[str, Anchor] = field(default_factory=dict)
    # What its results are: dynamics, equilibrium or modes.
    kind: str = "dynamics"

    @property
    def static(self) -> bool:
        """Whether there is no motion over time."""
        return self.kind != "dynamics"

    def pose(self, body: str) -> tuple[Array, Array]:
        """Returns where a body is at the start: position and rotation matrix."""
        if body == GROUND:
            return np.zeros(3), np.eye(3)
        return self.bodies[body].position, self.bodies[body].rotation

    def to_body(self, body: str, point: Array) -> Array:
        """Returns a point that is given in global axes at the start in the axes of a body."""
        position, rotation = self.pose(body)
        return rotation.T @ (point - position)

    def to_global(self, body: str, point: Array) -> Array:
        """Returns a point of a body in global axes at the start."""
        position, rotation = self.pose(body)
        return position + rotation @ point

    def anchor(self, name: str) -> Anchor:
        """Returns the ground, a body or a point."""
        if name not in self.anchors:
            raise TautError(f"{self.name}: there is no body or point '{name}' in the case file")
        return self.anchors[name]


def read_mechanism(path: Path) -> Mechanism:
    """Reads a case file of the app `mechanism`."""
    groups = [(name, values) for name, values in read_groups(path)]
    names = {name for name, _ in groups}
    if not names & {"body", "point_mass", "beam"}:
        raise TautError(f"{path}: the case has no &body, &point_mass or &beam: it is no mechanism")
    flags = next((values for name, values in groups if name == "mechanism"), {})
    planar = bool(flags.get("planar", False))
    made = Mechanism(path.stem, planar, np.array([0.0, 1.0, 0.0] if planar else [0.0, 0.0, 1.0]))
    # In an order in which names are known before they are used.
    readers = (
        {
            "gravity": _gravity,
            "analysis": _analysis,
            "body": _body,
            "beam": _beam,
            "point_mass": _point_mass,
            "ground_point": _ground_point,
        },
        {"point": _point},
        {"joint": _joint, "rolling": _rolling, "knife_edge": _knife_edge},
        {"force": _load, "moment": _load},
        {"spring": _spring, "damper": _spring},
    )
    for known in readers:
        for name, values in groups:
            if name in known:
                try:
                    known[name](made, dict(values) | {"group": name})
                except (KeyError, TypeError, ValueError) as error:
                    raise TautError(f"{path}: &{name} {values.get('name', '')}: {error}") from None
    return made


def expand(text: str, number: int) -> str:
    """Returns a name with the first # replaced by a number, #+2 and #-1 by others."""
    return re.sub(r"#([+-]\d+)?", lambda found: str(number + int(found[1] or 0)), text, count=1)


def vector(values: dict[str, Any], name: str) -> Array:
    """Returns an entry as three numbers; missing ones are zero."""
    value = values.get(name, [])
    value = value if isinstance(value, list) else [value]
    return np.array([*(0.0 if item is None else float(item) for item in value), 0.0, 0.0, 0.0])[:3]


def _copies(values: dict[str, Any]) -> Iterator[tuple[int, int]]:
    """Yields the index of each copy from 0 on and its number."""
    first = int(values.get("first", 1))
    yield from ((k, first + k) for k in range(int(values.get("repeat", 1))))


def _gravity(made: Mechanism, values: dict[str, Any]) -> None:
    """Takes its direction."""
    acceleration = vector(values, "acceleration")
    if "acceleration" in values and np.linalg.norm(acceleration) > 0 and not made.planar:
        made.up = -acceleration / np.linalg.norm(acceleration)


def _analysis(made: Mechanism, values: dict[str, Any]) -> None:
    """Takes what is sought."""
    made.kind = str(values.get("kind", "dynamics")).strip().lower()


def _body(made: Mechanism, values: dict[str, Any]) -> None:
    """Reads &body."""
    for k, number in _copies(values):
        position, rotation, length = _place(values, k)
        shape, size = _shape(values, length, made.planar)
        name = expand(values["name"], number)
        made.bodies[name] = Body(name, shape, size, position, rotation)
        made.anchors[name] = Anchor(name)


def _place(values: dict[str, Any], k: int) -> tuple[Array, Array, float]:
    """Returns position, rotation and length of a copy."""
    if "from" in values:
        ends = [vector(values, end) + k * vector(values, f"{end}_step") for end in ("from", "to")]
        along = ends[1] - ends[0]
        length = float(np.linalg.norm(along))
        # Axis 1 along it, axis 2 level if it can be.
        side = np.array([-along[1], along[0], 0.0])
        if np.linalg.norm(side) < 1e-6 * length:
            side = np.array([0.0, 1.0, 0.0])
        return (ends[0] + ends[1]) / 2, axes_near(along, side), float(values.get("length", length))
    position = vector(values, "position") + k * vector(values, "position_step")
    if "quaternion" in values:
        q = values["quaternion"]
        rotation = Rotation.from_quat([*q[1:], q[0]])
    else:
        angle = float(values.get("angle", 0.0)) + k * float(values.get("angle_step", 0.0))
        rotation = Rotation.from_rotvec(vector(values, "orientation") + [0.0, 0.0, angle])
    return position, rotation.as_matrix(), float(values.get("length", 0.0))


def axes_near(axis_1: Array, near_axis_2: Array) -> Array:
    """Returns the rotation whose axis 1 is given and whose axis 2 is near a direction."""
    one = axis_1 / np.linalg.norm(axis_1)
    three = np.cross(one, near_axis_2)
    three = three / np.linalg.norm(three)
    return np.stack([one, np.cross(three, one), three], axis=1)


def _shape(values: dict[str, Any], length: float, planar: bool) -> tuple[str, Array]:
    """Returns a body's shape and its sides; one of which only the inertia is known is a box that has it."""
    shape = values.get("shape", "")
    radius, thickness = float(values.get("radius", 0.0)), float(values.get("thickness", 0.0))
    if shape == "rod":
        return shape, np.array([length, thickness, thickness])
    if shape == "box":
        return shape, vector(values, "size")
    if shape == "sphere":
        return shape, np.full(3, 2 * radius)
    if shape == "cylinder":
        return shape, np.array([2 * radius, 2 * radius, length])
    if planar:
        return "", np.zeros(3)
    inertia = vector(values, "inertia")
    # A side: a^2 = 6 (J_b + J_c - J_a)/m.
    squares = 6 * (inertia.sum() - 2 * inertia) / float(values["mass"])
    return "", np.sqrt(np.maximum(squares, 0.0))


def _beam(made: Mechanism, values: dict[str, Any]) -> None:
    """Reads &beam: its nodes are bodies."""
    ends = vector(values, "from"), vector(values, "to")
    across = vector(values, "axis_2") if "axis_2" in values else np.array([0.0, 1.0, 0.0])
    elements = int(values.get("elements", 4))
    nodes = []
    for i in range(elements + 1):
        name = f"{values['name']}{i + 1}"
        position = ends[0] + i / elements * (ends[1] - ends[0])
        made.bodies[name] = Body(name, "node", np.zeros(3), position, axes_near(ends[1] - ends[0], across))
        made.anchors[name] = Anchor(name)
        nodes.append(name)
    made.beams.append(nodes)


def _point_mass(made: Mechanism, values: dict[str, Any]) -> None:
    """Reads &point_mass: a body that is a point."""
    for k, number in _copies(values):
        name = expand(values["name"], number)
        position = vector(values, "position") + k * vector(values, "position_step")
        made.bodies[name] = Body(name, "point", np.zeros(3), position)
        made.anchors[name] = Anchor(name, np.zeros(3))


def _ground_point(made: Mechanism, values: dict[str, Any]) -> None:
    """Reads &ground_point."""
    for k, number in _copies(values):
        at = vector(values, "position") + k * vector(values, "position_step")
        made.anchors[expand(values["name"], number)] = Anchor(GROUND, at)


def _point(made: Mechanism, values: dict[str, Any]) -> None:
    """Reads &point."""
    for k, number in _copies(values):
        owner = made.anchor(expand(values["body"], number)).body
        at = vector(values, "position") + k * vector(values, "position_step")
        if values.get("frame", "global") == "global":
            at = made.to_body(owner, at)
        name = expand(values["name"], number)
        made.anchors[name] = made.points[name] = Anchor(owner, at)
        _attach(made, made.points[name])


def _attach(made: Mechanism, anchor: Anchor) -> None:
    """Notes a point that is fixed to a body."""
    if anchor.body != GROUND and anchor.at is not None:
        made.bodies[anchor.body].attached.append(anchor.at)


def _ends(made: Mechanism, values: dict[str, Any], number: int, k: int) -> tuple[Anchor, Anchor]:
    """Returns the two ends of a joint or a spring; a side that has none takes the other's."""
    ends = [made.anchor(expand(values.get("body_1", GROUND), number))]
    ends.append(made.anchor(expand(values["body_2"], number)))
    in_body = values.get("frame", "global") == "body"
    centered = values["group"] != "joint" or (values["type"] == "distance" and "point" not in values)
    at: list[Array | None] = []
    for end, entry in zip(ends, ("point_1", "point_2"), strict=True):
        if end.at is not None:
            at.append(end.at)
        elif entry in values:
            at.append(vector(values, entry) if in_body else made.to_body(end.body, vector(values, entry)))
        elif "point" in values:
            shared = vector(values, "point") + k * vector(values, "point_step")
            at.append(made.to_body(end.body, shared))
        else:
            at.append(np.zeros(3) if centered else None)
    if at[0] is None and at[1] is None:
        # The center of mass of the second, or of the first if that is the ground.
        at[0 if ends[1].body == GROUND else 1] = np.zeros(3)
    for i in (0, 1):
        if at[i] is None:
            at[i] = made.to_body(ends[i].body, made.to_global(ends[1 - i].body, at[1 - i]))
    found = Anchor(ends[0].body, at[0]), Anchor(ends[1].body, at[1])
    for end in found:
        _attach(made, end)
    return found


def _joint(made: Mechanism, values: dict[str, Any]) -> None:
    """Reads &joint."""
    for k, number in _copies(values):
        one, two = _ends(made, values, number, k)
        axes = [vector(values, "axis_1" if "axis_1" in values else "axis"), vector(values, "axis_2")]
        if values.get("frame", "global") == "body":
            axes[0] = made.pose(one.body)[1] @ axes[0]
            axes[1] = made.pose(two.body)[1] @ axes[1]
        if made.planar and values["type"] == "revolute":
            axes[0] = np.array([0.0, 0.0, 1.0])
        _add(made.joints, values, number, values["type"], (one, two), (_unit(axes[0]), _unit(axes[1])))


def _unit(axis: Array) -> Array:
    """Returns a direction of length 1; zero stays."""
    return axis / (np.linalg.norm(axis) or 1.0)


def _add(
    links: list[Link],
    values: dict[str, Any],
    number: int,
    kind: str,
    ends: tuple[Anchor, Anchor],
    axes: tuple[Array, Array],
) -> None:
    """Adds a joint or a spring."""
    name = expand(values.get("name", ""), number)
    bodies, points = (ends[0].body, ends[1].body), (ends[0].at, ends[1].at)
    links.append(Link(name, kind, bodies, points, *axes, float(values.get("radius", 0.0))))


def _rolling(made: Mechanism, values: dict[str, Any]) -> None:
    """Reads &rolling: the axis is the plane's normal, the second that of the disc."""
    owner = made.anchor(values["body"])
    at = owner.at if owner.at is not None else np.zeros(3)
    if "center" in values:
        at = made.to_body(owner.body, vector(values, "center"))
    normal = vector(values, "normal") if "normal" in values else np.array([0.0, 0.0, 1.0])
    ends = Anchor(GROUND, vector(values, "plane_point")), Anchor(owner.body, at)
    _add(made.joints, values, 1, "rolling", ends, (_unit(normal), _unit(vector(values, "axis"))))


def _knife_edge(made: Mechanism, values: dict[str, Any]) -> None:
    """Reads &knife_edge: the axis is across the edge."""
    owner = made.anchor(values["body"])
    at = owner.at if owner.at is not None else np.zeros(3)
    if "point" in values:
        at = made.to_body(owner.body, vector(values, "point"))
    ends = Anchor(GROUND, at), Anchor(owner.body, at)
    _attach(made, ends[1])
    across = _unit(vector(values, "across"))
    _add(made.joints, values, 1, "knife_edge", ends, (across, across))


def _load(made: Mechanism, values: dict[str, Any]) -> None:
    """Notes where a load acts, so that a body is drawn up to there."""
    for _, number in _copies(values):
        owner = made.anchor(expand(values["body"], number))
        if "point" in values and values["group"] == "force":
            _attach(made, Anchor(owner.body, made.to_body(owner.body, vector(values, "point"))))


def _spring(made: Mechanism, values: dict[str, Any]) -> None:
    """Reads &spring and &damper; one about a joint is not drawn."""
    if "joint" in values:
        return
    for k, number in _copies(values):
        zero = np.zeros(3)
        _add(made.springs, values, number, values["group"], _ends(made, values, number, k), (zero, zero))
