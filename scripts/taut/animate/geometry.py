"""What is where in a mechanism, as the app `mechanism` writes it beside its results: geometry.csv."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from taut.errors import TautError
from taut.results import Array, read_table

GROUND = "ground"
FILE = "geometry.csv"


@dataclass
class Body:
    """A body: its shape in body axes, and what is fixed to it."""

    name: str
    # rod, box, sphere, cylinder, point, node (of a beam) or inertia (of which only that is known).
    shape: str
    # Sides along body axes [m]; of a cylinder two diameters and its length.
    size: Array = field(default_factory=lambda: np.zeros(3))
    # Along which a rod or a cylinder lies.
    axis: Array = field(default_factory=lambda: np.eye(3)[2])
    # Where joints, springs, forces and points are, in body axes [m].
    attached: list[Array] = field(default_factory=list)


@dataclass(frozen=True)
class Anchor:
    """A point of a body or of the ground, in its axes [m]."""

    body: str
    at: Array


@dataclass(frozen=True)
class Link:
    """What is between two bodies: a joint, a spring or a damper; points and directions are in each's axes."""

    name: str
    type: str
    bodies: tuple[str, str]
    points: tuple[Array, Array]
    # The axis in both bodies; none where there is no axis.
    axes: tuple[Array, Array] | None
    # Across the axis, in the second body.
    side: Array
    # The length of a distance or a spring, the radius of a disc [m].
    length: float

    @property
    def anchors(self) -> tuple[Anchor, Anchor]:
        """Its ends."""
        return Anchor(self.bodies[0], self.points[0]), Anchor(self.bodies[1], self.points[1])


@dataclass
class Mechanism:
    """Bodies, joints, springs, beams and points by name."""

    name: str
    # The CRC-32 of the case file that it was read from.
    checksum: int
    # What its results are: dynamics, equilibrium or modes.
    kind: str
    planar: bool
    # Against gravity.
    up: Array
    bodies: dict[str, Body] = field(default_factory=dict)
    joints: list[Link] = field(default_factory=list)
    springs: list[Link] = field(default_factory=list)
    # The names of each beam's nodes.
    beams: list[list[str]] = field(default_factory=list)
    # What &point groups write out.
    points: dict[str, Anchor] = field(default_factory=dict)

    @property
    def static(self) -> bool:
        """Whether there is no motion over time."""
        return self.kind != "dynamics"

    def anchor(self, name: str) -> Anchor:
        """Returns a point, the center of a body or the point of a joint."""
        if name in self.points:
            return self.points[name]
        if name in self.bodies:
            return Anchor(name, np.zeros(3))
        for joint in self.joints:
            if joint.name == name:
                return joint.anchors[1]
        known = ", ".join([*self.bodies, *self.points, *(joint.name for joint in self.joints)])
        raise TautError(f"there is no body, point or joint '{name}'; there are {known}")


def read_geometry(path: Path, remedy: str) -> Mechanism:
    """Reads the file of a mechanism; the remedy is what to do about one that is missing or damaged."""
    try:
        rows = read_table(path, remedy=remedy).records()
        (case,), (analysis,), (whole,) = (_of(rows, kind) for kind in ("case", "analysis", "mechanism"))
        planar = whole["type"] == "planar"
        made = Mechanism(
            case["name"], int(case["type"], 16), analysis["type"], planar, _vector(whole, "axis_{}_1")
        )
        for row in _of(rows, "body"):
            body = Body(row["name"], row["type"])
            if row["size_x"]:
                body.size = _vector(row, "size_{}")
            if row["axis_x_1"]:
                body.axis = _vector(row, "axis_{}_1")
            made.bodies[body.name] = body
        made.beams = _beams(_of(rows, "beam"))
        made.points = {row["name"]: Anchor(row["body_1"], _vector(row, "{}_1")) for row in _of(rows, "point")}
        made.joints = [_link(row) for row in _of(rows, "joint")]
        made.springs = [_link(row) for row in _of(rows, "spring")]
        forces = [Anchor(row["body_1"], _vector(row, "{}_1")) for row in _of(rows, "force")]
        _attach(made, forces)
        _roll(made)
    except (KeyError, ValueError) as error:
        raise TautError(f"{path}: {error}: {remedy}") from None
    return made


def _of(rows: list[dict[str, str]], kind: str) -> list[dict[str, str]]:
    """Returns the rows of a kind."""
    return [row for row in rows if row["kind"] == kind]


def _vector(row: dict[str, str], names: str) -> Array:
    """Returns three columns as a vector."""
    return np.array([float(row[names.format(axis)]) for axis in "xyz"])


def _link(row: dict[str, str]) -> Link:
    """Returns a joint or a spring."""
    axes = (_vector(row, "axis_{}_1"), _vector(row, "axis_{}_2")) if row["axis_x_1"] else None
    return Link(
        row["name"],
        row["type"],
        (row["body_1"], row["body_2"]),
        (_vector(row, "{}_1"), _vector(row, "{}_2")),
        axes,
        _vector(row, "side_{}") if row["side_x"] else np.zeros(3),
        float(row["length"] or 0.0),
    )


def _beams(elements: list[dict[str, str]]) -> list[list[str]]:
    """Returns the nodes of each beam: one element goes on where the last one ends."""
    beams: list[list[str]] = []
    for element in elements:
        if beams and beams[-1][-1] == element["body_1"]:
            beams[-1].append(element["body_2"])
        else:
            beams.append([element["body_1"], element["body_2"]])
    return beams


def _roll(made: Mechanism) -> None:
    """Makes discs of the bodies that roll and of which only the inertia is known otherwise."""
    for joint in made.joints:
        body = made.bodies.get(joint.bodies[1])
        if joint.type == "rolling" and body is not None and body.shape == "inertia":
            body.shape, body.axis = "cylinder", joint.axes[1]
            body.size = np.array([2 * joint.length, 2 * joint.length, 0.1 * joint.length])


def _attach(made: Mechanism, forces: list[Anchor]) -> None:
    """Notes what is fixed to bodies, so that each is drawn up to there."""
    anchors = list(made.points.values())
    for joint in made.joints:
        if joint.type != "rolling":
            anchors += joint.anchors
    # A force in the center of mass says nothing of the body's shape.
    anchors += [force for force in forces if force.at.any()]
    for spring in made.springs:
        if spring.type != "torsion":
            anchors += spring.anchors
    for anchor in anchors:
        if anchor.body != GROUND:
            made.bodies[anchor.body].attached.append(anchor.at)
