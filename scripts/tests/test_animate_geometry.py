"""What the app `mechanism` says of the geometry of a case, copies included."""

from pathlib import Path

import numpy as np
import pytest
from animate_cases import PENDULUM, ZOO, at_rest, geometry, made
from conftest import ROOT

from taut.animate.geometry import GROUND, Anchor, read_geometry
from taut.case_file import Entry, Template
from taut.errors import TautError

CASES = sorted((ROOT / "cases/mechanism").glob("*.nml"))
# Which joints say where their points and axes are.
MEETING = ("revolute", "spherical", "fixed", "prismatic", "cylindrical", "universal")
PARALLEL = ("revolute", "prismatic", "cylindrical")


def shipped(app: Path, folder: Path, name: str) -> Path:
    """Runs a shipped case for a moment."""
    path = ROOT / f"cases/mechanism/{name}.nml"
    if "&analysis" in path.read_text():
        return made(app, folder, path.read_text(), name)
    return made(app, folder, Template(path, [Entry.read("integration.t_end")]).fill([1e-6]), name)


@pytest.mark.parametrize("name", [path.stem for path in CASES])
def test_joints_of_shipped_cases_meet(mechanism: Path, tmp_path: Path, name: str) -> None:
    folder = shipped(mechanism, tmp_path, name)
    made = geometry(folder)
    assert made.name == name and made.bodies
    if made.static:
        return
    motion = at_rest(folder)
    for joint in made.joints:
        one, two = (motion.point(anchor)[0] for anchor in joint.anchors)
        if joint.type in MEETING:
            gap = one - two
            if joint.type in ("prismatic", "cylindrical"):
                axis = motion.direction(joint.bodies[0], joint.axes[0])[0]
                gap = gap - axis * (axis @ gap)
            assert gap == pytest.approx(np.zeros(3), abs=1e-9), joint.name
        if joint.type in PARALLEL:
            first, second = (
                motion.direction(b, axis)[0] for b, axis in zip(joint.bodies, joint.axes, strict=True)
            )
            assert first == pytest.approx(second, abs=1e-9), joint.name


def test_copies_are_as_many_as_the_file_says(mechanism: Path, tmp_path: Path) -> None:
    folder = shipped(mechanism, tmp_path, "n_four_bar40")
    made, motion = geometry(folder), at_rest(folder)
    assert (len(made.bodies), len(made.joints)) == (81, 121)
    joints = {joint.name: joint for joint in made.joints}
    assert joints["right40"].bodies == ("bar40", "crank40")
    assert motion.point(joints["right40"].anchors[0])[0] == pytest.approx([40, 1, 0])
    assert motion.point(joints["left1"].anchors[0])[0] == pytest.approx([0, 1, 0])


def test_bodies_have_the_size_of_their_shape_or_inertia(mechanism: Path, tmp_path: Path) -> None:
    bodies = geometry(made(mechanism, tmp_path, ZOO)).bodies
    shapes = {name: body.shape for name, body in bodies.items()}
    assert shapes == {
        "box": "box",
        "ball": "sphere",
        "can": "cylinder",
        "disc": "cylinder",
        "brick": "inertia",
        "top": "inertia",
        "arm": "inertia",
        "mass": "point",
        "n1": "node",
        "n2": "node",
        "n3": "node",
    }
    assert bodies["box"].size == pytest.approx([0.2, 0.3, 0.4])
    assert bodies["ball"].size == pytest.approx([0.2, 0.2, 0.2])
    assert bodies["can"].size == pytest.approx([0.2, 0.2, 0.3])
    assert bodies["can"].axis == pytest.approx([0, 0, 1])
    a, b, c = bodies["brick"].size
    inertia = np.array([b * b + c * c, a * a + c * c, a * a + b * b]) / 12
    assert inertia == pytest.approx([1e-2, 2e-2, 2.5e-2])


def test_everything_has_its_place(mechanism: Path, tmp_path: Path) -> None:
    text = ZOO + '&force name = "f", body = "ball", point = 1, 0, 1.1, value = 0, 0, 1 /\n'
    text += '&spring name = "coil", joint = "j9", stiffness = 1 /\n'
    text += '&bushing name = "bush", body_1 = "arm", body_2 = "ball", axis = 0, 1, 0, stiffness = 1, 1, 1 /\n'
    folder = made(mechanism, tmp_path, text)
    zoo, motion = geometry(folder), at_rest(folder)
    assert zoo.beams == [["n1", "n2", "n3"]]
    assert [(link.name, link.type) for link in zoo.springs] == [
        ("s", "spring"),
        ("d", "damper"),
        ("coil", "torsion"),
        ("bush", "bushing"),
    ]
    joints = {joint.name: joint for joint in zoo.joints}
    assert joints["roll"].length == 0.3 and joints["roll"].axes[0] == pytest.approx([0, 0, 1])
    assert motion.direction("disc", joints["roll"].axes[1])[0] == pytest.approx([1, 0, 0])
    # A knife edge that is not to be crossed along x points along y.
    assert motion.direction("arm", joints["edge"].side)[0] == pytest.approx([0, 1, 0])
    assert motion.point(joints["edge"].anchors[1])[0] == pytest.approx([2, 2.5, 1])
    assert motion.direction("ball", joints["j2"].axes[1])[0] == pytest.approx([0, 0, 1])
    assert joints["j1"].axes is None
    force = Anchor("ball", zoo.bodies["ball"].attached[-3])
    assert motion.point(force)[0] == pytest.approx([1, 0, 1.1])
    coil = zoo.springs[2]
    bush = zoo.springs[3]
    assert motion.point(bush.anchors[0]) == pytest.approx(motion.point(bush.anchors[1]))
    assert motion.direction("ball", bush.axes[1])[0] == pytest.approx([0, 1, 0])
    assert coil.bodies == (GROUND, "brick") and coil.axes[0] == pytest.approx([0, 1, 0])


def test_what_rolls_is_a_disc(mechanism: Path, tmp_path: Path) -> None:
    text = ZOO.replace('"cylinder", radius = 0.3, length = 0', '"box", size = 1, 1, 1')
    assert geometry(made(mechanism, tmp_path, text)).bodies["disc"].shape == "box"
    text = ZOO.replace('shape = "cylinder", radius = 0.3, length = 0,', "inertia = 1e-2, 1e-2, 2e-2,")
    disc = geometry(made(mechanism, tmp_path, text, "disc")).bodies["disc"]
    assert disc.shape == "cylinder" and disc.size[:2] == pytest.approx([0.6, 0.6])
    assert abs(disc.axis) == pytest.approx([0, 0, 1])


def test_up_is_against_gravity(mechanism: Path, tmp_path: Path) -> None:
    ball = '&point_mass name = "a", mass = 1 /\n&integration t_end = 1e-3 /\n'
    assert geometry(made(mechanism, tmp_path, ball)).up == pytest.approx([0, 0, 1])
    pulled = "&gravity acceleration(2) = -9.81 /\n" + ball
    assert geometry(made(mechanism, tmp_path, pulled)).up == pytest.approx([0, 1, 0])
    assert geometry(made(mechanism, tmp_path, PENDULUM)).up == pytest.approx([0, 1, 0])


@pytest.mark.parametrize("text", ["", "kind,name\n", "kind,name,type,body_1\njoint,a,revolute,b\n"])
def test_a_damaged_file_is_told_in_one_line(tmp_path: Path, text: str) -> None:
    (tmp_path / "geometry.csv").write_text(text)
    with pytest.raises(TautError, match="geometry.csv: .*run it|geometry.csv is empty: run it"):
        read_geometry(tmp_path / "geometry.csv", "run it")
