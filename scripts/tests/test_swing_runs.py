"""The app swing: Table 2's cases against each other and the reference curves; bad input in one line."""

import csv
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

ROOT = Path(__file__).parents[2]
Run = Callable[..., subprocess.CompletedProcess[str]]
MARKERS = [marker + axis for marker in "ABCDE" for axis in "xyz"]


@pytest.fixture(scope="module")
def results(
    swing: Path, environment: dict[str, str], tmp_path_factory: pytest.TempPathFactory
) -> Callable[[str], NDArray[np.void]]:
    folder = tmp_path_factory.mktemp("swing")

    def result(case: str) -> NDArray[np.void]:
        out = folder / case
        if not out.exists():
            done = subprocess.run(
                [swing, ROOT / f"cases/swing/{case}.nml", "--quiet", "--out", folder],
                env=environment,
                capture_output=True,
                text=True,
                check=False,
            )
            assert done.returncode == 0, done.stderr
        method = next(path for path in out.glob("*.csv") if path.stem in ("baseline", "present"))
        return np.genfromtxt(method, delimiter=",", names=True)

    result.folder = folder
    return result


def steps(folder: Path, case: str) -> int:
    with (folder / case / "summary.csv").open(encoding="utf-8", newline="") as file:
        return int(next(csv.DictReader(file))["steps"])


def distance(run: NDArray[np.void], reference: NDArray[np.void], markers: list[str], end: float) -> float:
    kept = run["t"] <= end + 1e-9
    return max(
        float(np.abs(run[name][kept] - np.interp(run["t"][kept], reference["t"], reference[name])).max())
        for name in markers
    )


def test_elements_with_the_cap(results: Callable[[str], NDArray[np.void]]) -> None:
    baseline, present = results("1a"), results("1b")
    assert steps(results.folder, "1a") == steps(results.folder, "1b")
    assert abs(steps(results.folder, "1b") - 69_000) <= 10
    assert distance(present, baseline, MARKERS, 0.69) <= 1e-10
    assert max(present["phi"].max(), baseline["phi"].max(), present["phi_raw"].max()) <= 1e-13
    assert max(np.abs(present[marker + "z"]).max() for marker in "ABCDE") == 0.0


def test_finer_meshes_come_closer_to_the_reference(results: Callable[[str], NDArray[np.void]]) -> None:
    reference = np.genfromtxt(ROOT / "cases/swing/data/mbdyn_4x3node.csv", delimiter=",", names=True)
    in_plane = [name for name in MARKERS if not name.endswith("z")]
    coarse = distance(results("mesh4"), reference, in_plane, 0.6)
    fine = distance(results("mesh8"), reference, in_plane, 0.6)
    assert coarse <= 1e-3
    # Second order: a factor of four.
    assert 3.0 <= coarse / fine <= 5.0


def test_modes(results: Callable[[str], NDArray[np.void]]) -> None:
    without = results("3b")
    results("3a")
    assert steps(results.folder, "3a") == steps(results.folder, "3b")
    assert 1_000 <= steps(results.folder, "3b") <= 1_140
    modal = results("2b")
    # Chaotic: only the order of magnitude means anything.
    assert 10_000 <= steps(results.folder, "2b") <= 40_000
    in_plane = [name for name in MARKERS if not name.endswith("z")]
    assert distance(modal, results("mesh4"), in_plane, 0.6) <= 2e-3
    assert distance(without, modal, MARKERS, 0.6) <= 1e-4
    assert max(modal["phi"].max(), modal["phidot"].max()) <= 1e-12


def test_events(results: Callable[[str], NDArray[np.void]]) -> None:
    results("3b")
    with (results.folder / "3b/events.csv").open(encoding="utf-8", newline="") as file:
        events = list(csv.DictReader(file))
    first = {
        name: min(float(row["t"]) for row in events if row["event"] == name)
        for name in ("link-AC", "link-AE")
    }
    assert abs(first["link-AC"] - 0.640) <= 0.005
    assert abs(first["link-AE"] - 0.6475) <= 0.005


BAD = {
    "no elements": ("&swing elements = 0 /", "elements = 0"),
    "odd number of elements": ("&swing elements = 7 /", "elements = 7"),
    "unknown model": ('&swing model = "fem" /', '"fem"'),
    "modes that do not exist": ('&swing model = "modal", elements = 8, modes = 1, 99 /', "modes"),
    "negative stiffness": ("&swing young = -1.0 /", "Young"),
    "no thickness": ("&swing thickness = 0.0 /", "thickness = 0.0 is not positive"),
    "link without length": ("&swing link_2 = 0.0 /", "link"),
    "times that do not increase": ("&swing times = 0.0, 0.3, 0.2 /", "times"),
    "unknown entry": ("&swing mass = 1.0 /", "mass"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_input(swing: Path, environment: dict[str, str], tmp_path: Path, name: str) -> None:
    text, said = BAD[name]
    (tmp_path / "bad.nml").write_text(text + "\n", encoding="utf-8")
    done = subprocess.run(
        [swing, "bad.nml"], cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )
    lines = done.stderr.strip().splitlines()
    assert done.returncode == 1
    assert len(lines) == 1
    assert "bad.nml:1: &swing" in lines[0]
    assert said in lines[0]
    assert not (tmp_path / "results").exists()
