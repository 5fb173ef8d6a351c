"""The app mechanism from outside: dead points, equilibria, restarts."""

import re
import shutil
import signal
import subprocess
import time
from pathlib import Path

import pytest
from mechanism_runs import CASES, rows, start

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
    assert not re.search(r"constraint \d", done.stderr)
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
