"""The shipped mechanisms: their energy, exact motions and modes."""

import math
import re
from pathlib import Path

import numpy as np
import pytest
from mechanism_runs import CASES, rows, start, table
from scipy.integrate import solve_ivp

G = 9.81


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
