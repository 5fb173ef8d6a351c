"""The app mechanism from outside: bad input, what is noted, good input."""

from pathlib import Path

import pytest
from mechanism_runs import start, table

ROD = '&body name = "rod", shape = "rod", mass = 1, thickness = 0.05, from = 0, 0, 0, to = 1, 0, 0 /\n'
AXIS = "point = 0, 0, 0, axis = 0, 1, 0 /\n"
HINGE = '&joint name = "hinge", type = "revolute", body_2 = "rod", ' + AXIS
SHORT = "&integration t_end = 0.1 /\n"
PLANE = '&mechanism planar = .true. /\n&body name = "rod", mass = 1, inertia = 0.1 /\n'


BAD = {
    "missing body": (
        ROD + '&joint name = "hinge", type = "revolute", body_2 = "rood", ' + AXIS,
        'case.nml:2: &joint "hinge"',
        '"rood"',
    ),
    "missing first body": (
        ROD + '&joint name = "hinge", type = "revolute", body_1 = "arm", body_2 = "rod", ' + AXIS,
        'case.nml:2: &joint "hinge"',
        'body_1 = "arm"',
    ),
    "two bodies of one name": (ROD + ROD + HINGE, 'case.nml:2: &body "rod"', "two of it"),
    "two joints of one name": (ROD + HINGE + HINGE, 'case.nml:3: &joint "hinge"', "two of it"),
    "body named as a point": (
        '&ground_point name = "rod", position = 1, 0, 0 /\n' + ROD,
        'case.nml:2: &body "rod"',
        "two of it",
    ),
    "cannot be assembled": (
        ROD + HINGE + '&joint name = "far", type = "distance", body_2 = "rod",\n point_1 = 5, 0, 0, '
        "point_2 = 1, 0, 0, length = 0.5 /\n",
        'case.nml:3: &joint "far"',
        "cannot be assembled",
        "open by 3.5000 at the start",
    ),
    "zero mass": (
        '\n&body name = "rod", shape = "rod", length = 1, mass = 0 /\n' + HINGE,
        'case.nml:2: &body "rod"',
        "its mass is 0 kg",
    ),
    "negative mass": (
        '&body name = "rod", shape = "rod", length = 1, mass = -1 /\n' + HINGE,
        'case.nml:1: &body "rod"',
        "mass",
    ),
    "missing mass of a point": (
        '&point_mass name = "ball" /\n',
        'case.nml:1: &point_mass "ball"',
        "it has no mass",
    ),
    "triangle inequality": (
        '&body name = "rod", mass = 1, inertia = 1, 1, 3 /\n' + HINGE,
        'case.nml:1: &body "rod"',
        "triangle inequality",
    ),
    "neither inertia nor shape": ('&body name = "rod", mass = 1 /\n', 'case.nml:1: &body "rod"', "inertia"),
    "zero axis": (
        ROD + '&joint name = "hinge", type = "revolute", body_2 = "rod", point = 0, 0, 0, axis = 0, 0, 0 /\n',
        'case.nml:2: &joint "hinge"',
        "axis",
        "zero",
    ),
    "no axis": (
        ROD + '&joint name = "hinge", type = "revolute", body_2 = "rod", point = 0, 0, 0 /\n',
        'case.nml:2: &joint "hinge"',
        "no axis",
    ),
    "joint of a body with itself": (
        ROD + '&joint name = "ball", type = "spherical", body_1 = "rod", body_2 = "rod", point = 1, 0, 0 /\n',
        'case.nml:2: &joint "ball"',
        'joins "rod" to itself',
    ),
    "joint of the ground with itself": (
        ROD + '&joint name = "ball", type = "spherical", body_2 = "ground", point = 1, 0, 0 /\n',
        'case.nml:2: &joint "ball"',
        "to itself",
    ),
    "table not increasing": (
        '&function name = "drive", kind = "table", table = "drive.csv" /\n' + ROD + HINGE,
        'case.nml:1: &function "drive"',
        "not increasing in time",
        "row 3",
    ),
    "table that is missing": (
        '&function name = "drive", kind = "table", table = "other.csv" /\n' + ROD + HINGE,
        'case.nml:1: &function "drive"',
        "other.csv",
    ),
    "unknown entry": (
        ROD + '&joint name = "hinge",\n type = "revolute", body_2 = "rod", pont = 0, 0, 0 /\n',
        "case.nml:3: &joint",
        "no entry pont",
        "point, point_1",
    ),
    "unknown joint type": (
        ROD + '&joint name = "hinge", type = "revolut", body_2 = "rod", ' + AXIS,
        'case.nml:2: &joint "hinge"',
        '"revolut"',
        '"revolute"',
    ),
    "unknown shape": (
        '&body name = "rod", mass = 1, shape = "bar" /\n',
        'case.nml:1: &body "rod"',
        '"bar"',
        '"rod"',
    ),
    "unknown function": (
        ROD + HINGE.replace("axis", 'drive_angle = "g", axis'),
        'case.nml:2: &joint "hinge"',
        '"g"',
    ),
    "unknown group": (ROD + "&bodies /\n", "case.nml:2", "&bodies", "&mechanism"),
    "repeat without #": (
        '&body name = "rod", repeat = 3, shape = "rod", length = 1, mass = 1 /\n',
        'case.nml:1: &body "rod"',
        "no #",
        '"rod#"',
    ),
    "repeat of a missing body": (
        '&body name = "rod#", repeat = 2, shape = "rod", length = 1, mass = 1 /\n'
        '&joint name = "j#", repeat = 2, type = "spherical", point = 1, 0, 0,\n'
        ' body_1 = "rod#", body_2 = "rod#+1" /\n',
        'case.nml:2: &joint "j2"',
        '"rod3"',
    ),
    "no repeat": (
        '&body name = "rod#", repeat = 0, shape = "rod", length = 1, mass = 1 /\n',
        'case.nml:1: &body "rod#"',
        "repeat = 0",
    ),
    "no analysis of this name": (
        ROD + HINGE + '&analysis kind = "statics" /\n',
        "case.nml:3: &analysis",
        '"statics"',
        '"equilibrium"',
    ),
    "event of a missing joint": (
        ROD + HINGE + '&event name = "low", joint = "hing" /\n',
        'case.nml:3: &event "low"',
        '"hing"',
    ),
    "body that leaves its plane": (
        '&mechanism planar = .true. /\n&point_mass name = "ball", mass = 1, position = 0, 0, 1 /\n',
        'case.nml:2: &point_mass "ball"',
        "leaves the plane",
    ),
    "gravity of one number": (
        ROD + HINGE + "&gravity acceleration = 9.81 /\n",
        "case.nml:3: &gravity",
        "3 numbers",
    ),
    "moment that leaves its plane": (
        PLANE + '&moment name = "m", body = "rod", value = 0, 1, 0 /\n',
        'case.nml:3: &moment "m"',
        "leaves the plane",
        "one number",
    ),
    "force that leaves its plane": (
        PLANE + '&force name = "f", body = "rod", value = 0, 0, -50 /\n',
        'case.nml:3: &force "f"',
        "leaves the plane",
    ),
    "two events of one name": (
        ROD + HINGE + '&event name = "low", joint = "hinge" /\n' * 2,
        'case.nml:4: &event "low"',
        "two of it",
    ),
    "event at no number": (
        ROD + HINGE + '&event name = "low", joint = "hinge", value = nan /\n',
        'case.nml:3: &event "low"',
        "value = nan",
        "finite",
    ),
    "joint named as the ground": (
        ROD + HINGE.replace('"hinge"', '"ground"'),
        'case.nml:2: &joint "ground"',
        "two of it",
    ),
    "misspelt body": (
        ROD + '&joint name = "hinge", type = "revolute", body_2 = "rodd", ' + AXIS,
        'case.nml:2: &joint "hinge"',
        'did you mean "rod"?',
    ),
    "misspelt joint of a spring": (
        ROD + HINGE + '&spring name = "s", joint = "hing", stiffness = 1 /\n',
        'case.nml:3: &spring "s"',
        'did you mean "hinge"?',
    ),
    "misspelt type": (
        ROD + HINGE.replace("revolute", "revolut"),
        'case.nml:2: &joint "hinge"',
        'did you mean "revolute"?',
    ),
    "misspelt shape": (
        ROD.replace('shape = "rod"', 'shape = "rood"') + HINGE,
        'case.nml:1: &body "rod"',
        'did you mean "rod"?',
    ),
    "misspelt quantity": (
        ROD + HINGE + '&event name = "e", joint = "hinge", quantity = "angel" /\n',
        'case.nml:3: &event "e"',
        'did you mean "angle"?',
    ),
    "misspelt body that is held": ('&mechanism hold = "rodd.x" /\n' + ROD + HINGE, 'did you mean "rod"?'),
    "moments of inertia in the plane": (
        PLANE.replace("inertia = 0.1", "inertia = 0.1, 0.2, 0.3"),
        'case.nml:2: &body "rod"',
        "3 numbers",
        "about z",
    ),
    "vector of two numbers in space": (
        ROD.replace("to = 1, 0, 0", "to = 1, 0") + HINGE,
        'case.nml:1: &body "rod"',
        "to = 1, 0",
        "3 numbers",
    ),
    "table that is no file": (
        '&function name = "drive", kind = "table", table = "/dev/zero" /\n' + ROD + HINGE,
        'case.nml:1: &function "drive"',
        "/dev/zero",
        "cannot be read",
    ),
    "run-up without a rate": (
        '&function name = "drive", kind = "run-up", finish = 0.1 /\n' + ROD + HINGE,
        'case.nml:1: &function "drive"',
        "a run-up without rate stands still",
        "give rate",
    ),
    "wave without a frequency": (
        '&function name = "drive", kind = "sine", amplitude = 2 /\n' + ROD + HINGE,
        'case.nml:1: &function "drive"',
        "a sine without frequency stands still",
        "give frequency or omega",
    ),
    "entry of another kind": (
        '&function name = "drive", kind = "run-up", finish = 0.1, rate = 1, amplitude = 2 /\n' + ROD + HINGE,
        'case.nml:1: &function "drive"',
        'kind = "run-up" has no use for amplitude',
        "remove it",
    ),
    "run-up without an end": (
        '&function name = "drive", kind = "run-up", rate = 3 /\n' + ROD + HINGE,
        'case.nml:1: &function "drive"',
        "a run-up takes time",
    ),
    "columns of a spring that is not there": (
        ROD + HINGE + '&spring name = "coil", joint = "hinge", stiffness = 1 /\n&output springs = "coi" /\n',
        "case.nml:4: &output",
        'did you mean "coil"',
    ),
    "columns of a spring without a name": (
        ROD + HINGE + '&spring joint = "hinge", stiffness = 1 /\n&output springs = "all" /\n',
        "case.nml:4: &output: a spring, damper or bushing has no name",
    ),
    "columns of a spring with a name that is not fit": (
        ROD + HINGE + '&spring name = "a,b", joint = "hinge", stiffness = 1 /\n&output springs = "a,b" /\n',
        'case.nml:4: &output: spring "a,b": its name has a character',
    ),
    "columns of a spring and a joint of one name": (
        ROD + HINGE + '&spring name = "hinge", joint = "hinge", stiffness = 1 /\n&output springs = "all" /\n',
        'case.nml:4: &output: spring "hinge": the name is taken',
    ),
    "two functions for one drive": (
        ROD + HINGE.replace("axis = ", 'drive_angle = "g", "h", axis = '),
        'case.nml:2: &joint "hinge"',
        "more than one text",
        'kind = "sum"',
    ),
    "sum that contains itself": (
        ROD
        + '&function name = "g", kind = "sum", of = "h" /\n&function name = "h", kind = "sum", of = "g" /\n'
        + HINGE.replace("axis = ", 'drive_angle = "g", axis = '),
        'case.nml: function "g": it is a sum that contains itself',
        '"g" "h"',
    ),
    "sum of nothing": (
        '&function name = "g", kind = "sum" /\n' + ROD + HINGE,
        'case.nml:1: &function "g"',
        "of = the names of functions",
    ),
    "of without a sum": (
        '&function name = "g", of = "h" /\n' + ROD + HINGE,
        'case.nml:1: &function "g"',
        'kind = "constant" has no use for of',
    ),
    "spring between points at one place": (
        ROD
        + '&spring name = "bush", body_2 = "rod", point_1 = 0, 0, 0, point_2 = 0, 0, 0, stiffness = 1 /\n',
        'case.nml:2: &spring "bush"',
        "set them apart, or use &bushing",
    ),
    "bushing without stiffness": (
        ROD + '&bushing name = "bush", body_2 = "rod", damping = 0, 0, 0 /\n',
        'case.nml:2: &bushing "bush": it has neither stiffness nor damping',
    ),
    "bushing that adds energy": (
        ROD + '&bushing name = "bush", body_2 = "rod", damping = 0, 0, -1 /\n',
        'case.nml:2: &bushing "bush": a stiffness or a damping of -1.0000 is negative',
    ),
    "unknown bushing": (
        ROD + '&bushing name = "bush", body_2 = "rod", stiffness = 1, 1, 1 /\n&output springs = "bus" /\n',
        'case.nml:3: &output: springs = "bus"',
        'did you mean "bush"?',
        "&bushing",
    ),
    "spring on a bare ground": (
        ROD + '&spring name = "spring", body_2 = "rod", stiffness = 1 /\n',
        'case.nml:2: &spring "spring"',
        "point_1",
    ),
}


@pytest.mark.parametrize("case", BAD.values(), ids=BAD)
def test_bad_input(mechanism: Path, tmp_path: Path, case: tuple[str, ...]) -> None:
    text, *parts = case
    (tmp_path / "case.nml").write_text(text + SHORT)
    (tmp_path / "drive.csv").write_text("t,value\n0,0\n1,1\n0.5,2\n")
    done = start(mechanism, tmp_path, "case.nml", "--out", "out")
    assert done.returncode == 1
    (line,) = done.stderr.splitlines()
    assert line.startswith("mechanism: case.nml:")
    for part in parts:
        assert part in line
    fault, _, remedy = line.partition("; ")
    assert fault.count(": ") >= 2 and remedy.strip()
    assert done.stdout == ""
    assert not (tmp_path / "out").exists()


NOTED = {
    "angle in degrees": (
        ROD + HINGE.replace("axis = 0, 1, 0", "axis = 0, 1, 0, angle = 90"),
        'case.nml:2: &joint "hinge": angle = 90.0000 rad is 14.3239 turns',
    ),
    "orientation in degrees": (
        ROD.replace("from = 0, 0, 0, to = 1, 0, 0", "length = 1, orientation = 0, 0, 90"),
        'case.nml:1: &body "rod": |orientation| = 90.0000 rad',
    ),
    "free angle in degrees": (
        ROD + HINGE + '&spring name = "s", joint = "hinge", stiffness = 0.1, free_angle = 45 /\n',
        'case.nml:3: &spring "s": free_angle = 45.0000 rad',
    ),
    "event in degrees": (
        ROD + HINGE + '&event name = "e", joint = "hinge", value = 45 /\n',
        'case.nml:3: &event "e": value = 45.0000 rad',
    ),
    "point in millimeters": (
        ROD + HINGE.replace("point = 0, 0, 0", "point = 1000, 0, 0"),
        'case.nml:2: &joint "hinge": its point is 999.5000 m from the center of "rod"',
    ),
}


@pytest.mark.parametrize("case", NOTED.values(), ids=NOTED)
def test_what_may_not_be_meant_is_noted(mechanism: Path, tmp_path: Path, case: tuple[str, str]) -> None:
    text, note = case
    (tmp_path / "case.nml").write_text(text + SHORT)
    done = start(mechanism, tmp_path, "case.nml", "--out", "out")
    assert (done.returncode, done.stderr) == (0, "")
    assert [line for line in done.stdout.splitlines() if line.startswith(f"note: {note}")]
    assert "notes on the case file: 1" in (tmp_path / "out/case/summary.csv").read_text()


def test_point_along_an_axis_is_not_noted(mechanism: Path, tmp_path: Path) -> None:
    (tmp_path / "case.nml").write_text(ROD + HINGE.replace("point = 0, 0, 0", "point = 0, 1000, 0") + SHORT)
    done = start(mechanism, tmp_path, "case.nml", "--out", "out")
    assert done.returncode == 0
    assert "note" not in done.stdout
    assert done.stdout.splitlines()[-1] == "results in out/case"


def test_moment_of_one_number_in_the_plane(mechanism: Path, tmp_path: Path) -> None:
    (tmp_path / "case.nml").write_text(
        PLANE + '&moment name = "m", body = "rod", value = 0.5 /\n&integration t_end = 1 /\n'
    )
    done = start(mechanism, tmp_path, "case.nml", "--out", "out", "--quiet")
    assert (done.returncode, done.stderr) == (0, "")
    assert table(tmp_path / "out/case/present.csv")["rod.wz"][-1] == pytest.approx(5.0, abs=1e-9)


def test_good_input(mechanism: Path, tmp_path: Path) -> None:
    # What the tests above look for must be missing here, or they would pass with any program.
    (tmp_path / "case.nml").write_text(ROD + HINGE + SHORT)
    done = start(mechanism, tmp_path, "case.nml", "--out", "out", "--quiet")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    names = {path.name for path in (tmp_path / "out/case").iterdir()}
    assert names == {"geometry.csv", "model.csv", "present.csv", "summary.csv"}
