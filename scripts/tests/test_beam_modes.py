"""The app beam_modes: Table 1, and bad input in one line."""

import csv
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from taut.programs import release

ROOT = Path(__file__).parents[2]
Run = Callable[..., subprocess.CompletedProcess[str]]


@pytest.fixture(scope="module")
def program() -> Path:
    return release("beam_modes")


@pytest.fixture
def run(program: Path, environment: dict[str, str], tmp_path: Path) -> Run:
    def run_in_folder(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [program, *arguments], cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
        )

    return run_in_folder


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_table_1(run: Run, tmp_path: Path) -> None:
    done = run(ROOT / "cases/beam_modes/table1.nml", "--out", "out")
    assert done.returncode == 0, done.stderr
    modes = rows(tmp_path / "out/table1/frequencies.csv")
    axial = next(mode for mode in modes if mode["motion"] == "axial")
    found = [float(mode["frequency"]) for mode in [*modes[:3], axial]]
    assert [f"{frequency:#.4g}" for frequency in found] == ["0.4431", "18.17", "28.46", "319.5"]
    assert [mode["symmetry"] for mode in [*modes[:3], axial]] == [
        "symmetric",
        "antisymmetric",
        "symmetric",
        "antisymmetric",
    ]
    shapes = rows(tmp_path / "out/table1/shapes.csv")
    assert len(shapes) == len(modes) * 41
    # Largest displacement one; nothing out of the plane; the ends do not move.
    first = [row for row in shapes if row["mode"] == "1"]
    assert max(float(row["u_y"]) for row in first) == 1.0
    assert all(float(row["u_z"]) == 0.0 for row in shapes)
    assert float(first[0]["u_y"]) == float(first[-1]["u_y"]) == 0.0


VALUES = {
    "no elements": ("&beam elements = 0 /", "&beam", "elements = 0"),
    "odd elements": ("&beam elements = 5 /", "&beam", "mid-span", "even"),
    "too many elements": ("&beam elements = 100000 /", "&beam", "more than 500"),
    "too many modes": ("&beam elements = 2 /\n&modes number = 6 /", "case.nml:2: &modes", "more than", "5"),
    "no modes": ("&modes number = 0 /", "&modes", "number = 0"),
    "negative stiffness": ("&beam young = -1 /", "&beam", "Young", "Pa"),
    "not positive definite": ("&beam stiffness = 36*1.0 /", "&beam", "positive definite"),
    "not symmetric": ("&beam stiffness(1, 2) = 1.0 /", "&beam", "symmetric"),
    "thin air": ("&beam density = 0 /", "&beam", "density"),
    "no thickness": ("&beam thickness = 0 /", "&beam", "axis 2"),
    "length not a number": ("&beam length = nan /", "&beam", "length"),
    "unknown supports": ('&beam supports = "glued" /', "&beam", '"glued"', '"pinned"'),
    "nothing free": (
        '&beam elements = 1, mid_mass = 0, supports = "clamped" /',
        "&beam",
        "nothing",
        "more elements",
    ),
    "unknown entry": ("&beam\n lenght = 1 /", "case.nml:2: &beam", "lenght", "length"),
    "unknown group": ("&beams /", "case.nml:1", "&beams"),
}


@pytest.mark.parametrize("case", VALUES.values(), ids=VALUES)
def test_case_file_is_refused(run: Run, tmp_path: Path, case: tuple[str, ...]) -> None:
    text, *parts = case
    (tmp_path / "case.nml").write_text(text, encoding="utf-8")
    done = run("case.nml", "--out", "out")
    assert done.returncode == 1
    lines = done.stderr.splitlines()
    assert len(lines) == 1, done.stderr
    assert lines[0].startswith("beam_modes: case.nml")
    for part in parts:
        assert part in lines[0]
    assert "; " in lines[0], "there is no remedy"
    assert not (tmp_path / "out").exists()


def test_a_stiffness_matrix_of_ones_own(run: Run, tmp_path: Path) -> None:
    # The rectangle's own stiffness: E A, G A_s twice, G J, E I twice.
    young, shear = 73e9, 73e9 / 2.6
    thickness, width = 1e-3, 5e-3
    area = thickness * width
    shear_area = 5 / 6 * shear * area
    bending = (young * thickness * width**3 / 12, young * width * thickness**3 / 12)
    diagonal = [young * area, shear_area, shear_area, 0.04, *bending]
    entries = "".join(f"stiffness({i}, {i}) = {value}\n" for i, value in enumerate(diagonal, start=1))
    (tmp_path / "own.nml").write_text(f"&beam\n{entries}/\n", encoding="utf-8")
    done = run("own.nml", "--out", "out")
    assert done.returncode == 0, done.stderr
    modes = rows(tmp_path / "out/own/frequencies.csv")
    assert abs(float(modes[0]["frequency"]) / 0.4431 - 1) < 1e-3
    assert abs(float(modes[1]["frequency"]) / 18.174 - 1) < 1e-3
