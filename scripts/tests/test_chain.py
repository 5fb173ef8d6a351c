"""The app chain: its joints hold, solvers agree, and bad input is one line."""

import csv
import math
import subprocess
from pathlib import Path

import pytest
from conftest import ROOT

from taut.programs import release


@pytest.fixture(scope="module")
def chain() -> Path:
    return release("chain")


def run(chain: Path, case: str, folder: Path) -> subprocess.CompletedProcess[str]:
    (folder / "case.nml").write_text(case)
    return subprocess.run(
        [chain, "case.nml", "--quiet"], cwd=folder, capture_output=True, text=True, timeout=120, check=False
    )


def rows(path: Path) -> list[dict[str, float]]:
    with path.open(newline="", encoding="utf-8") as file:
        return [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]


def test_solvers_agree(chain: Path, tmp_path: Path) -> None:
    solvers = ("auto", "banded", "sparse", "pivoted-cholesky", "dgelsd", "factor")
    methods = "\n".join(f'&method label = "{solver}", solver = "{solver}" /' for solver in solvers)
    times = "&integration t_end = 1.0, rtol = 1e-8, atol = 1e-10 / &output dt = 0.1 /"
    done = run(chain, f"&chain rods = 20 /\n{times}\n{methods}", tmp_path)
    assert done.returncode == 0, done.stderr
    reference = rows(tmp_path / "results/case/dgelsd.csv")
    for solver in solvers:
        for row, expected in zip(rows(tmp_path / f"results/case/{solver}.csv"), reference, strict=True):
            assert row["rank"] == 20
            for name in ("x20", "z20", "vx20", "lambda1", "energy"):
                assert row[name] == pytest.approx(expected[name], rel=1e-6, abs=1e-7), (
                    solver,
                    row["t"],
                    name,
                )


def test_joints_of_a_long_chain_hold(chain: Path, tmp_path: Path) -> None:
    case = """&chain rods = 3000 / &integration t_end = 0.3 /
    &output columns = "phi*", "energy", "rank" /
    &method stage_projection = "none", label = "none" / &method /"""
    done = run(chain, case, tmp_path)
    assert done.returncode == 0, done.stderr
    for method in ("none", "present"):
        for row in rows(tmp_path / f"results/case/{method}.csv"):
            assert row["phi"] <= 4 * math.ulp(3000.0)
            assert row["phidot"] <= 1e-12
            assert row["rank"] == 3000
            # A millionth of what it falls through.
            assert abs(row["energy"]) <= 1e-6 * 3000 * 9.81 * 0.5 * 9.81 * 0.3**2


def test_free_fall_of_the_end(chain: Path, tmp_path: Path) -> None:
    # The support is felt last at the far end: a horizontal chain falls freely at first.
    done = run(chain, "&chain rods = 200 / &integration t_end = 0.01 / &method /", tmp_path)
    assert done.returncode == 0, done.stderr
    last = rows(tmp_path / "results/case/present.csv")[-1]
    assert last["z200"] == pytest.approx(-0.5 * 9.81 * last["t"] ** 2, rel=1e-9)
    assert last["z1"] > last["z200"]


@pytest.mark.parametrize(
    ("group", "part"),
    [
        ("&chain rods = 0 /", "rods = 0"),
        ("&chain mass = -1 /", "mass"),
        ("&chain length = 0 /", "length"),
        ("&chain angle = 1e3 /", "angle"),
        ("&chain link = 1 /", "no entry link"),
        ('&chain / &method solver = "lu" /', '"lu"'),
    ],
)
def test_bad_input(chain: Path, tmp_path: Path, group: str, part: str) -> None:
    done = run(chain, group, tmp_path)
    assert done.returncode == 1
    assert len(done.stderr.splitlines()) == 1
    assert part in done.stderr
    assert "case.nml:1" in done.stderr
    assert not (tmp_path / "results").exists()


def test_shipped_case(chain: Path, tmp_path: Path) -> None:
    done = subprocess.run(
        [chain, ROOT / "cases/chain/ten.nml", "--quiet"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    for row in rows(tmp_path / "results/ten/present.csv"):
        assert row["phi"] <= 1e-12 and row["phidot"] <= 1e-12
        assert abs(row["energy"]) <= 1e-4
