"""Drives whose velocity jumps: the motion follows them at once; a kink at the end is not looked behind."""

import csv
import subprocess
from pathlib import Path

import pytest

from taut.programs import release

ROD = """&gravity /
&body name = "rod", shape = "rod", mass = 1.0, thickness = 0.05, from = 0.0, 0.0, 0.0, to = 1.0, 0.0, 0.0 /
&joint name = "hinge", type = "revolute", body_2 = "rod", point = 0.0, 0.0, 0.0, axis = 0.0, 1.0, 0.0,
       drive_angle = "g" /
&function name = "g", kind = "ramp", rate = 3.0, {times} /
&integration t_end = 1.0 /
&output dt = 0.05 /
"""


@pytest.fixture(scope="module")
def mechanism() -> Path:
    return release("mechanism")


def run(mechanism: Path, folder: Path, times: str, method: str = "") -> list[dict[str, float]]:
    (folder / "case.nml").write_text(ROD.format(times=times) + method)
    done = subprocess.run(
        [mechanism, "case.nml", "--quiet"], cwd=folder, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
    with (folder / "results/case/present.csv").open(newline="", encoding="utf-8") as file:
        return [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]


@pytest.mark.parametrize("projection", ["newton", "none"])
def test_ramp_that_starts_and_ends(mechanism: Path, tmp_path: Path, projection: str) -> None:
    method = f'&method stage_projection = "{projection}" /'
    rows = run(mechanism, tmp_path, "start = 0.2, finish = 0.55", method)
    for row in rows:
        assert row["phi"] <= 1e-12 and row["phidot"] <= 1e-12
        angle = 3.0 * min(max(row["t"] - 0.2, 0.0), 0.35)
        assert row["hinge.angle"] == pytest.approx(angle, abs=1e-12)
        if min(abs(row["t"] - 0.2), abs(row["t"] - 0.55)) > 1e-6:
            rate = 3.0 if 0.2 < row["t"] < 0.55 else 0.0
            assert row["rod.wy"] == pytest.approx(rate, abs=1e-12)


def test_kink_at_the_end(mechanism: Path, tmp_path: Path) -> None:
    rows = run(mechanism, tmp_path, "start = 0.0, finish = 1.0")
    last, before = rows[-1], rows[-2]
    assert last["t"] == 1.0
    assert last["rod.wy"] == pytest.approx(3.0, abs=1e-12)
    assert last["phidot"] <= 1e-12 and last["phiddot"] <= 1e-9
    # The centripetal force turns with the rod and does not jump.
    assert abs(last["hinge.fx"] - before["hinge.fx"]) <= 1.0
