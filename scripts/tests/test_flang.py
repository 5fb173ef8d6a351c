"""flang, the second compiler: it builds the library, an app and an example, which compute what gfortran's do.

All unit tests by flang take minutes: `scripts/tests/study_flang.py`.
"""

import csv
import math
import os
import shutil
import subprocess
from pathlib import Path

import pytest
from conftest import ROOT
from debian import NoPackageError, install, nothing_to_test

COMPILER = "flang-new-22"
PROJECT = """\
name = "second"

[build]
link = ["lapack", "blas"]

[dependencies]
taut = { path = "TAUT" }

[[executable]]
name = "pendulum"
main = "pendulum.f90"

[[executable]]
name = "hanging_chain"
main = "hanging_chain.f90"
"""


def need_flang() -> None:
    """Looks for the compiler; a hundred megabytes and more on the disk, so that only CI installs it."""
    if shutil.which(COMPILER):
        return
    try:
        if not os.environ.get("CI"):
            raise NoPackageError(f"{COMPILER} is not installed (Debian: flang-22)")
        install("flang-22")
    except NoPackageError as why:
        if "Unable to locate package" in str(why):
            pytest.skip("the archives that apt knows have no flang-22; Debian 12 has it in bookworm-security")
        nothing_to_test(why)


def fpm(folder: Path, *arguments: str) -> str:
    done = subprocess.run(
        ["fpm", *arguments, "--compiler", COMPILER],
        cwd=folder,
        env=os.environ | {"OPENBLAS_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        check=False,
        timeout=1200,
    )
    assert done.returncode == 0, (done.stdout + done.stderr)[-3000:]
    return done.stdout


@pytest.fixture(scope="module")
def second(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A project with an app and an example of taut as its programs, built by flang."""
    need_flang()
    folder = tmp_path_factory.mktemp("flang")
    (folder / "app").mkdir()
    for file in ("app/pendulum.f90", "cases/examples/hanging_chain.f90"):
        shutil.copy(ROOT / file, folder / "app")
    taut = Path(os.path.relpath(ROOT, folder)).as_posix()  # fpm wants it relative
    (folder / "fpm.toml").write_text(PROJECT.replace("TAUT", taut), encoding="utf-8")
    fpm(folder, "build")
    return folder


def program(folder: Path, name: str) -> Path:
    return next(path for path in folder.glob(f"build/flang*/app/{name}") if path.is_file())


def rows(folder: Path, name: str) -> list[dict[str, str]]:
    with (folder / name).open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_methods_give_the_same_results(second: Path, pendulum: Path, tmp_path: Path) -> None:
    case = ROOT / "cases/pendulum/methods.nml"
    for name, made in (("flang", program(second, "pendulum")), ("gfortran", pendulum)):
        (tmp_path / name).mkdir()
        ran = subprocess.run(
            [made, case],
            cwd=tmp_path / name,
            env=os.environ | {"OPENBLAS_NUM_THREADS": "1"},
            capture_output=True,
            text=True,
            check=False,
        )
        assert ran.returncode == 0, ran.stdout + ran.stderr
    ours, theirs = (tmp_path / name / "results/methods" for name in ("gfortran", "flang"))
    summary = rows(ours, "summary.csv")
    assert len(summary) > 5
    for one, other in zip(summary, rows(theirs, "summary.csv"), strict=True):
        assert (one["method"], one["status"]) == (other["method"], other["status"])
        assert int(other["steps"]) == pytest.approx(int(one["steps"]), rel=0.01, abs=1), one["method"]
    for path in sorted(ours.glob("*.csv")):
        if path.name == "summary.csv":
            continue
        one, other = rows(ours, path.name)[-1], rows(theirs, path.name)[-1]
        for column in ("t", "x", "z"):
            assert math.isclose(float(one[column]), float(other[column]), abs_tol=1e-6), (path.name, column)


def test_system_without_derivatives(second: Path) -> None:
    ran = subprocess.run(
        [program(second, "hanging_chain")], capture_output=True, text=True, check=False, timeout=300
    )
    assert ran.returncode == 0, ran.stderr
    lines = [line for line in ran.stdout.splitlines() if "reached-end" in line]
    assert [line.split()[0] for line in lines] == ["5", "20"]
    assert all(abs(float(line.split()[-1])) < 1e-4 for line in lines)
