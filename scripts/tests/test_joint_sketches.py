"""The sketches and the table of joints say what the app does: axes, rows, what is carried and its sign."""

import csv
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest

from taut.animate.joint_sketches import SKETCHES
from taut.programs import release

ROOT = Path(__file__).parents[2]
README = (ROOT / "cases/mechanism/README.md").read_text(encoding="utf-8")
# What acts on body 2 at the joint's point: force [N] and moment [N m] in global axes.
FORCE, MOMENT = np.array([3.0, -5.0, 7.0]), np.array([2.0, 4.0, -1.0])
POINT = np.array([0.3, -0.2, 0.6])
AXES = [(1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, -1.0, 0.0), (0.5, -0.7, 0.4), (0.2, 0.1, -0.9)]


def listed(values: np.ndarray) -> str:
    return ", ".join(repr(float(value)) for value in values)


def joint_axes(axis: tuple[float, ...]) -> np.ndarray:
    """Returns axes 1, 2, 3 in rows, by the words of the document."""
    third = np.array(axis) / np.linalg.norm(axis)
    if abs(third[2]) < 0.9:  # more than about 26 degrees from z
        first = np.cross([0.0, 0.0, 1.0], third)
    else:
        first = np.array([1.0, 0.0, 0.0]) - third[0] * third
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(third, first), third])


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory):  # noqa: ANN201
    """Runs a case for a moment; returns what the app says and the first row."""
    mechanism = release("mechanism")
    folder = tmp_path_factory.mktemp("joints")

    def start(groups: str) -> tuple[str, dict[str, float]]:
        (folder / "case.nml").write_text(groups + "&integration t_end = 1e-3 /\n", encoding="utf-8")
        done = subprocess.run(
            [mechanism, "case.nml"], cwd=folder, capture_output=True, text=True, check=False, timeout=60
        )
        assert done.returncode == 0, done.stderr
        with (folder / "results/case/present.csv").open(encoding="utf-8") as file:
            row = next(csv.DictReader(file))
        return done.stdout, {name: float(value) for name, value in row.items()}

    return start


def body(point: np.ndarray = POINT) -> str:
    return (
        f'&body name = "b", mass = 2.0, inertia = 0.2, 0.2, 0.2, position = {listed(point)} /\n'
        f'&force name = "f", body = "b", value = {listed(FORCE)}, point = {listed(POINT)} /\n'
        f'&moment name = "m", body = "b", value = {listed(MOMENT)} /\n'
    )


def expected(axes: np.ndarray, carried: str) -> dict[str, float]:
    """Returns the reaction on body 2: against what acts on it, where the joint carries that."""
    return {
        f"{kind}{i}": -float(load @ axes[i - 1]) if f"{kind}{i}" in carried.split() else 0.0
        for kind, load in (("f", FORCE), ("m", MOMENT))
        for i in (1, 2, 3)
    }


def table() -> dict[str, tuple[int, str]]:
    """Returns rows in space and what is carried, by the document's table."""
    joints = README[README.index("\n## Joints\n") : README.index("\n## Springs, dampers, loads\n")]
    rows = re.findall(r"(?m)^\| `&?([\w-]+)` \| (\d)[^|]*\|[^|]*\|[^|]*\| ([^|]*) \|$", joints)
    return {name: (int(count), carries) for name, count, carries in rows}


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("kind", sorted(set(SKETCHES) - {"distance", "rolling", "knife_edge", "coordinate"}))
def test_reactions_of_a_joint(run, kind: str, axis: tuple[float, ...]) -> None:  # noqa: ANN001
    axes = joint_axes(axis)
    given = f"axis = {listed(axes[2])}"
    if kind == "universal":
        given = f"axis_1 = {listed(axes[2])}, axis_2 = {listed(axes[1])}"
    if kind in ("spherical", "fixed"):
        axes, given = np.eye(3), ""
    said, row = run(
        body() + f'&joint name = "j", type = "{kind}", body_2 = "b", point = {listed(POINT)}, {given} /\n'
    )
    for name, value in expected(axes, SKETCHES[kind].carried).items():
        assert row[f"j.{name}"] == pytest.approx(value, abs=1e-9), name
    assert f" {table()[kind][0]} constraint" in said


@pytest.mark.parametrize("axis", AXES)
def test_coordinate(run, axis: tuple[float, ...]) -> None:  # noqa: ANN001
    axes = joint_axes(axis)
    _, row = run(
        body() + f'&joint name = "j", type = "coordinate", body_2 = "b", axis = {listed(axes[2])} /\n'
    )
    for name, value in expected(axes, SKETCHES["coordinate"].carried).items():
        if name[0] == "f":
            assert row[f"j.{name}"] == pytest.approx(value, abs=1e-9), name


def test_tension_pulls_body_2_towards_body_1(run) -> None:  # noqa: ANN001
    away = FORCE / np.linalg.norm(FORCE)
    anchor = POINT - 0.5 * away
    _, row = run(
        body() + f'&joint name = "j", type = "distance", body_2 = "b", point_1 = {listed(anchor)} /\n'
    )
    assert [row[f"j.f{axis}"] for axis in "xyz"] == pytest.approx(list(-FORCE), abs=1e-9)
    assert row["lambda"] == pytest.approx(np.linalg.norm(FORCE), abs=1e-9)
    assert row["j.displacement"] == pytest.approx(0.5)


def test_rolling(run) -> None:  # noqa: ANN001
    # A disc upright on the plane through the point; what acts at the contact moves nothing.
    _, row = run(
        body(POINT + [0.0, 0.0, 0.25]).replace(f"value = {listed(MOMENT)}", "value = 0.0, 0.0, 0.0")
        + '&rolling name = "j", body = "b", radius = 0.25, axis = 0.0, 1.0, 0.0, '
        + f"plane_point = {listed(POINT)} /\n"
    )
    for i, axis in enumerate(joint_axes((0.0, 0.0, 1.0)), start=1):
        assert row[f"j.f{i}"] == pytest.approx(-FORCE @ axis, abs=1e-9)
    # The moment about the center is that of the force at the contact.
    moment = np.cross([0.0, 0.0, -0.25], -FORCE)
    assert [row[f"j.m{axis}"] for axis in "xyz"] == pytest.approx(list(moment), abs=1e-9)


@pytest.mark.parametrize("axis", AXES)
def test_knife_edge(run, axis: tuple[float, ...]) -> None:  # noqa: ANN001
    axes = joint_axes(axis)
    _, row = run(
        body() + f'&knife_edge name = "j", body = "b", point = {listed(POINT)}, across = {listed(axis)} /\n'
    )
    for name, value in expected(axes, SKETCHES["knife_edge"].carried).items():
        assert row[f"j.{name}"] == pytest.approx(value, abs=1e-9), name


def test_angle_is_that_of_body_2_by_the_right_hand(run) -> None:  # noqa: ANN001
    axis = np.array(AXES[3]) / np.linalg.norm(AXES[3])
    groups = (
        f'&body name = "b", mass = 2.0, inertia = 0.2, 0.2, 0.2, position = {listed(POINT)}, '
        f"angular_velocity = {listed(3.0 * axis)}, velocity = {listed(2.0 * axis)} /\n"
        f'&joint name = "j", type = "cylindrical", body_2 = "b", point = {listed(POINT)}, '
        f'axis = {listed(axis)}, drive_angle = "g", drive = "s" /\n'
        '&function name = "g", kind = "ramp", rate = 3.0, offset = 0.5 /\n'
        '&function name = "s", kind = "ramp", rate = 2.0, offset = 0.25 /\n'
    )
    _, row = run(groups)
    # What moves is body 2: along the axis, and turned about it by the right hand.
    assert row["j.angle"] == pytest.approx(0.5)
    assert row["j.displacement"] == pytest.approx(0.25)
    moved = np.array([row[f"b.{k}"] for k in "xyz"]) - POINT
    assert moved == pytest.approx(0.25 * axis)
    quaternion = [np.cos(0.25), *(np.sin(0.25) * axis)]
    assert [row[f"b.q{k}"] for k in "abcd"] == pytest.approx(quaternion)


def test_springs_pull_together_and_turn_back(run) -> None:  # noqa: ANN001
    spring = (
        '&body name = "b", mass = 2.0, inertia = 0.2, 0.2, 0.2, position = 0.0, 0.0, 0.0 /\n'
        '&joint name = "j", type = "fixed", body_2 = "b", point = 0.0, 0.0, 0.0 /\n'
        '&spring name = "s", point_1 = 1.0, 0.0, 0.0, body_2 = "b", point_2 = 0.0, 0.0, 0.0, '
        "stiffness = 10.0, free_length = 0.6, preload = 1.5 /\n"
    )
    _, row = run(spring)
    # Tension 1.5 + 10 (1 - 0.6) pulls the body along +x; the joint holds it.
    assert row["j.fx"] == pytest.approx(-5.5)
    about = (
        '&body name = "b", mass = 2.0, inertia = 0.2, 0.2, 0.2, position = 0.0, 0.0, 0.0 /\n'
        '&joint name = "j", type = "revolute", body_2 = "b", point = 0.0, 0.0, 0.0, axis = 1.0, 0.0, 0.0, '
        'drive_angle = "g" /\n&function name = "g", offset = 0.5 /\n'
        '&spring name = "s", joint = "j", stiffness = 10.0, free_angle = 0.2, preload = 1.5 /\n'
    )
    _, row = run(about)
    # The moment 1.5 + 10 (0.5 - 0.2) turns body 2 back; the drive holds it.
    assert row["j.m3"] == pytest.approx(4.5)


def test_table_says_what_the_sketches_show() -> None:
    for name, (_, carries) in table().items():
        sketch = SKETCHES[name]
        components = {part for part in re.findall(r"\b[fm][123]\b", carries.split("(")[0])}
        if name == "fixed":
            assert carries == "all"
        elif name == "universal":
            assert components == {"f1", "f2", "f3"} and "normal to both axes" in carries
        elif name not in ("distance", "rolling", "knife_edge"):
            assert components == set(sketch.carried.split()), name


def test_every_joint_has_its_sketch_in_the_document() -> None:
    for name in SKETCHES:
        assert (ROOT / f"cases/mechanism/joints/{name}.png").is_file()
        assert f"(joints/{name}.png)" in README
    assert set(table()) == set(SKETCHES)
