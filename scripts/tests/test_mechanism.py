"""The app mechanism from outside: bad input, the newcomer's page, shipped cases, restarts, exact motions."""

import csv
import math
import re
import shutil
import signal
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT, built
from scipy.integrate import solve_ivp

CASES = ROOT / "cases" / "mechanism"
G = 9.81
ROD = '&body name = "rod", shape = "rod", mass = 1, thickness = 0.05, from = 0, 0, 0, to = 1, 0, 0 /\n'
AXIS = "point = 0, 0, 0, axis = 0, 1, 0 /\n"
HINGE = '&joint name = "hinge", type = "revolute", body_2 = "rod", ' + AXIS
SHORT = "&integration t_end = 0.1 /\n"
PLANE = '&mechanism planar = .true. /\n&body name = "rod", mass = 1, inertia = 0.1 /\n'


@pytest.fixture(scope="session")
def mechanism() -> Path:
    return built("mechanism")


def start(mechanism: Path, folder: Path, *arguments: str | Path) -> subprocess.CompletedProcess[str]:
    command = [mechanism, *arguments]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=300, check=False)


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def table(path: Path) -> dict[str, np.ndarray]:
    with path.open(encoding="utf-8") as file:
        names = file.readline().strip().split(",")
        values = np.loadtxt(file, delimiter=",", ndmin=2)
    return {name: values[:, i] for i, name in enumerate(names)}


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


def blocks(page: str) -> list[str]:
    """Returns the indented blocks of a page."""
    return [
        "\n".join(line[4:] for line in block.splitlines()).strip("\n") + "\n"
        for block in re.findall(r"(?:^(?:    .*|)\n)+", page, re.MULTILINE)
        if block.strip()
    ]


@pytest.fixture(scope="session")
def page() -> str:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    return readme.split("## Your first mechanism in five minutes\n")[1].split("\n## ")[0]


@pytest.fixture
def first(page: str, tmp_path: Path) -> Path:
    (tmp_path / "first.nml").write_text(blocks(page)[0])
    return tmp_path


def test_first_mechanism_of_the_readme(mechanism: Path, page: str, first: Path) -> None:
    assert blocks(page)[1] == "fpm run mechanism --profile release -- first.nml\n"
    done = start(mechanism, first, "first.nml")
    assert (done.returncode, done.stderr) == (0, "")
    flat = " ".join(page.split())
    said = re.search(r"It says `([^`]+)`", flat)[1]
    assert said in done.stdout
    run = table(first / "results/first/present.csv")
    axes = [f"{kind}{axis}" for kind in "fm" for axis in "xyz123"]
    columns = {"tip.x", "tip.y", "tip.z", "hinge.angle", *(f"hinge.{axis}" for axis in axes)}
    columns |= {f"rod.{part}" for part in "x y z qa qb qc qd vx vy vz wx wy wz".split()}
    assert columns <= set(run)
    # About the hinge: J = m L^2/3 + m d^2/12, so that the hinge carries m g (1 - (L/2)^2 m/J).
    carried = G * (1 - 0.25 / (1 / 3 + 0.05**2 / 12))
    assert run["hinge.fz"][0] == pytest.approx(carried, abs=1e-9)
    assert f"`hinge.fz` is {carried:.3f} N" in flat
    assert (run["t"][-1], len(run["t"])) == (2.0, 201)
    assert {row["name"]: float(row["value"]) for row in rows(first / "results/first/model.csv")}["rank"] == 5


def test_second_rod_of_the_readme(mechanism: Path, page: str, first: Path) -> None:
    with (first / "first.nml").open("a") as file:
        file.write(blocks(page)[2])
    done = start(mechanism, first, "first.nml")
    assert (done.returncode, done.stderr) == (0, "")
    assert "2 bodies, 2 joints: 12 velocities, 8 constraints of rank 8, 4 degrees of freedom" in done.stdout


def test_driven_hinge_of_the_readme(mechanism: Path, page: str, first: Path) -> None:
    flat = " ".join(page.split())
    function, entry = re.search(r"drive the hinge with `([^`]+)` and `([^`]+)`", flat).groups()
    text = (first / "first.nml").read_text()
    driven = text.replace('type = "revolute"', f'type = "revolute", {entry}')
    assert driven != text
    (first / "first.nml").write_text(f"{driven}\n{function}\n")
    done = start(mechanism, first, "first.nml")
    assert (done.returncode, done.stderr) == (0, "")
    run = table(first / "results/first/present.csv")
    assert run["tip.x"] == pytest.approx(np.cos(3 * run["t"]), abs=1e-9)


def test_misspelt_entry_of_the_readme(mechanism: Path, first: Path) -> None:
    text = (first / "first.nml").read_text()
    (first / "first.nml").write_text(text.replace("thickness", "thicknes"))
    done = start(mechanism, first, "first.nml")
    assert done.returncode == 1
    assert "no entry thicknes; did you mean thickness? The entries are name, mass" in done.stderr
    help_text = start(mechanism, first, "--help-case").stdout
    assert all(f"&{group}" in help_text for group in ("body", "joint", "beam", "rolling", "analysis"))


# Most that the energy may drift [J], as the case files say what is to be expected; None: it is not constant.
ENERGY = {
    "andrews": None,
    "bricard": 1e-3,
    "bricard_box": 1e-3,
    "chain": 1e-3,
    "double_pendulum": 1e-5,
    "four_bar": 1e-3,
    "governor": None,
    "heavy_top": 1e-3,
    "n_four_bar2": 1e-3,
    "n_four_bar40": 1e-2,
    "rolling_disc": 1e-5,
    "simple_pendulum": 1e-6,
    "slider_crank": None,
    "spatial_slider_crank": 1e-4,
    "swing": None,
}


@pytest.fixture(scope="module")
def shipped(mechanism: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the results of all shipped cases with a motion."""
    folder = tmp_path_factory.mktemp("shipped")
    for case in ENERGY:
        done = start(mechanism, folder, CASES / f"{case}.nml", "--quiet")
        assert (done.returncode, done.stdout, done.stderr) == (0, "", ""), case
    return folder / "results"


def test_no_shipped_case_is_left_out() -> None:
    # What the report sets side by side are the same problems by other methods.
    cases = [path for path in CASES.glob("*.nml") if not path.stem.startswith("side_")]
    static = {path.stem for path in cases if "&analysis" in path.read_text(encoding="utf-8")}
    assert static == {"pendulum_modes"}
    assert {path.stem for path in cases} == static | set(ENERGY)


@pytest.mark.parametrize("case", ENERGY)
def test_shipped_case(shipped: Path, case: str) -> None:
    summary, *others = rows(shipped / case / "summary.csv")
    assert {one["status"] for one in (summary, *others)} == {"reached-end"}
    assert summary["method"] == "present"
    run = table(shipped / case / "present.csv")
    assert all(np.isfinite(column).all() for column in run.values())
    # How far coordinates are from zero sets the spacing of numbers, in which the joints can hold at best.
    reach = max(np.abs(run[name]).max() for name in run if re.fullmatch(r".*\.[xyz]", name))
    floor = max(1e-12, 4 * math.ulp(reach))
    assert run["phi"].max() <= floor
    assert run["phidot"].max() <= floor
    if ENERGY[case] is not None:
        assert np.abs(run["energy"] - run["energy"][0]).max() <= ENERGY[case]


def test_swing_keeps_its_energy_after_the_force(shipped: Path) -> None:
    run = table(shipped / "swing/present.csv")
    after = run["energy"][run["t"] > 0.257]
    assert np.ptp(after) <= 1e-4
    assert after[-1] == pytest.approx(0.0639, abs=5e-4)


def test_damper_takes_energy_and_angular_momentum_stays(shipped: Path) -> None:
    run = table(shipped / "governor/present.csv")
    assert np.diff(run["energy"]).max() <= 1e-6
    assert run["energy"][-1] < run["energy"][0] - 0.1
    # Balls and arms about z; the shaft and the sleeve add J w, all turning together.
    balls = sum(
        run[f"ball{i}.x"] * run[f"ball{i}.vy"] - run[f"ball{i}.y"] * run[f"ball{i}.vx"] for i in (1, 2)
    )
    arms = sum(
        0.2 * (run[f"arm{i}.x"] * run[f"arm{i}.vy"] - run[f"arm{i}.y"] * run[f"arm{i}.vx"]) for i in (1, 2)
    )
    # About their own centers: J = m L^2/12 about axes across the rod, of which z sees the part away from it.
    own = 0.0
    for i in (1, 2):
        q = {part: run[f"arm{i}.q{part}"] for part in "abcd"}
        along = 2 * (q["b"] * q["d"] - q["a"] * q["c"])
        inertia = 0.2 / 12 * ((0.25 + 0.02**2) * (1 - along**2) + 2 * 0.02**2 * along**2)
        own = own + inertia * run["shaft.wz"]
    still = (2.0 * 0.02**2 + 0.5 * 0.04**2) / 2 * run["shaft.wz"]
    momentum = balls + arms + own + still
    assert np.ptp(momentum) <= 1e-5 * momentum[0]


def n_four_bar(windows: int, end: float) -> tuple[float, float]:
    """Returns where B0 is, from the one angle that all cranks share."""
    inertia = (windows + 1) / 6 + windows / 2
    weight = ((windows + 1) / 2 + windows) * G
    exact = solve_ivp(
        lambda _, y: (y[1], weight / (2 * inertia) * math.sin(y[0])),
        (0, end),
        (0.0, 1.0),
        method="DOP853",
        rtol=1e-12,
        atol=1e-12,
    )
    return math.sin(exact.y[0, -1]), math.cos(exact.y[0, -1])


@pytest.mark.parametrize("windows", [2, 40])
def test_n_four_bar_against_the_exact_motion(shipped: Path, windows: int) -> None:
    text = (CASES / f"n_four_bar{windows}.nml").read_text(encoding="utf-8")
    assert "rtol = 1e-8, atol = 1e-8" in text
    run = table(shipped / f"n_four_bar{windows}/present.csv")
    assert run["t"][-1] == 10.0
    error = math.dist((run["B0.x"][-1], run["B0.y"][-1]), n_four_bar(windows, 10.0))
    print(f"N = {windows}: error of B0 after 10 s: {error:.2e} m")
    assert error <= 1e-5
    # No branch is switched: the cranks stay parallel.
    for number in range(windows + 1):
        assert run[f"crank{number}.angle"] == pytest.approx(run["crank0.angle"], abs=1e-5)


def test_two_four_bars_keep_their_energy_at_the_default_tolerance(mechanism: Path, tmp_path: Path) -> None:
    text = (CASES / "n_four_bar2.nml").read_text(encoding="utf-8")
    (tmp_path / "case.nml").write_text(text.replace(", rtol = 1e-8, atol = 1e-8", ""))
    assert start(mechanism, tmp_path, "case.nml", "--quiet").returncode == 0
    run = table(tmp_path / "results/case/present.csv")
    assert run["t"][-1] == 10.0
    assert np.abs(run["energy"] - run["energy"][0]).max() <= 1e-3


def test_bricard(shipped: Path) -> None:
    run = table(shipped / "bricard/present.csv")
    assert run["t"][-1] == 10.0
    assert np.abs(run["energy"] - run["energy"][0]).max() <= 1e-3
    assert run["phi"].max() <= 1e-10
    assert (run["rank"] == 29).all()
    model = {row["name"] for row in rows(shipped / "bricard/model.csv")}
    assert len([name for name in model if name.startswith("redundant:")]) == 1
    assert {f"not_unique:J{i}" for i in range(1, 7)} <= model


def test_modes_of_the_shipped_case(mechanism: Path, tmp_path: Path) -> None:
    done = start(mechanism, tmp_path, CASES / "pendulum_modes.nml", "--quiet")
    assert (done.returncode, done.stderr) == (0, "")
    found = [float(row["frequency"]) for row in rows(tmp_path / "results/pendulum_modes/modes.csv")]
    exact = [math.sqrt((3 + sign * 6 / math.sqrt(7)) * G) / (2 * math.pi) for sign in (-1, 1)]
    assert found == pytest.approx(exact, rel=1e-9)


TOGGLE = """&mechanism planar = .true. /
&function name = "turn", kind = "ramp", rate = 0.5 /
&body name = "crank", shape = "rod", mass = 0.5, from = 0, 0, to = 0.25, 0.433012701892219 /
&body name = "coupler", shape = "rod", mass = 1.2, from = 0.25, 0.433012701892219,
      to = 1.42473949850705, 0.677935364476571 /
&body name = "rocker", shape = "rod", mass = 0.8, from = 1, 0, to = 1.42473949850705, 0.677935364476571 /
&joint name = "O", type = "revolute", body_2 = "crank", point = 0, 0 /
&joint name = "A", type = "revolute", body_1 = "crank", body_2 = "coupler", point = 0.25, 0.433012701892219 /
&joint name = "B", type = "revolute", body_1 = "coupler", body_2 = "rocker",
       point = 1.42473949850705, 0.677935364476571 /
&joint name = "C", type = "revolute", body_2 = "rocker", point = 1, 0, drive_angle = "turn" /
&integration t_end = 10 /
&output dt = 0.01 /
"""


def test_a_drive_that_cannot_be_followed_is_named(mechanism: Path, tmp_path: Path) -> None:
    (tmp_path / "toggle.nml").write_text(TOGGLE)
    done = start(mechanism, tmp_path, "toggle.nml")
    assert done.returncode == 1
    assert "a dead point, where C cannot be driven; drive another joint, or end before it" in done.stderr
    assert "repeat" not in done.stdout
    # The remedy: the crank may be driven all the way.
    cured = TOGGLE.replace(', drive_angle = "turn"', "").replace(
        "point = 0, 0 /", 'point = 0, 0, drive_angle = "turn" /'
    )
    (tmp_path / "toggle.nml").write_text(cured)
    done = start(mechanism, tmp_path, "toggle.nml")
    assert (done.returncode, done.stderr) == (0, "")


TROLLEY = """&mechanism planar = .true. /
&gravity /
&body name = "cart", mass = 2, inertia = 1, velocity = 0, 0 /
&body name = "load", shape = "rod", mass = 1, from = 0, 0, to = 0.2, -1 /
&joint name = "rail", type = "prismatic", body_2 = "cart", point = 0, 0, axis = 1, 0 /
&joint name = "pin", type = "revolute", body_1 = "cart", body_2 = "load", point = 0, 0 /
&damper name = "air", joint = "pin", damping = 0.01 /
&analysis kind = "modes" /
"""


def test_an_equilibrium_says_how_it_lies(mechanism: Path, tmp_path: Path) -> None:
    (tmp_path / "trolley.nml").write_text(TROLLEY)
    done = start(mechanism, tmp_path, "trolley.nml")
    assert (done.returncode, done.stderr) == (0, "")
    told = done.stdout.splitlines()
    assert any("from the start" in line and "1.97E-01 rad (load)" in line for line in told)
    assert "  stable" in told
    assert any("free motions" in line and line.endswith(" 1") for line in told)
    assert any(line.endswith("0.000000 Hz, a free motion") for line in told)
    assert any("damping ratio" in line for line in told)
    assert "velocities of the start" not in done.stdout
    modes = rows(tmp_path / "results/trolley/modes.csv")
    assert [float(row["damping_ratio"]) > 0 for row in modes] == [False, True]

    (tmp_path / "trolley.nml").write_text(TROLLEY.replace("velocity = 0, 0", "velocity = 1, 0"))
    done = start(mechanism, tmp_path, "trolley.nml")
    assert "velocities of the start, and gyroscopic forces with them, are left out" in done.stdout

    upright = TROLLEY.replace("to = 0.2, -1", "to = 0.2, 1").replace("modes", "equilibrium")
    (tmp_path / "trolley.nml").write_text(upright)
    done = start(mechanism, tmp_path, "trolley.nml")
    assert any(line.startswith("  unstable: ") for line in done.stdout.splitlines())


# Chaotic: what is not the same to the last bit soon differs in the first digit.
LONG = """&integration t_end = 3.0, rtol = 1e-9, atol = 1e-9, max_step = 2e-4 /
&output dt = 2e-3 /
&event name = "low", point = "hand", quantity = "z", value = -1.0 /
"""


@pytest.fixture
def long_case(tmp_path: Path) -> Path:
    text = (CASES / "double_pendulum.nml").read_text(encoding="utf-8")
    kept = re.sub(r"&(integration|output)[^/]*/", "", text)
    (tmp_path / "long.nml").write_text(kept + LONG)
    return tmp_path


def without_times(folder: Path) -> dict[str, object]:
    """Returns the files of a folder, the summary without its times."""
    files: dict[str, object] = {path.name: path.read_bytes() for path in folder.iterdir()}
    files["summary.csv"] = [{**row, "wall_seconds": ""} for row in rows(folder / "summary.csv")]
    return files


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
def test_restart_continues_byte_for_byte(mechanism: Path, long_case: Path, number: signal.Signals) -> None:
    whole = long_case / "whole"
    whole.mkdir()
    shutil.copy(long_case / "long.nml", whole)
    assert start(mechanism, whole, "long.nml", "--quiet").returncode == 0
    expected = without_times(whole / "results/long")
    assert len(expected["events.csv"].splitlines()) > 1
    checkpoint = Path("results/long/checkpoint.taut")
    command = [mechanism, "long.nml", "--checkpoint", "0.02", "--quiet"]
    with subprocess.Popen(command, cwd=long_case, stderr=subprocess.PIPE) as process:
        while not (long_case / checkpoint).exists():
            assert process.poll() is None, "it was over before its first checkpoint"
            time.sleep(0.002)
        process.send_signal(number)
    assert process.returncode != 0, "it was over before the signal"
    assert not (long_case / "results/long/present.csv").exists()
    done = start(mechanism, long_case, "--restart", checkpoint, "--quiet")
    assert (done.returncode, done.stderr) == (0, "")
    assert without_times(long_case / "results/long") == expected
