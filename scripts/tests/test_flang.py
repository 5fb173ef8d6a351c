"""flang, the second compiler: an app and two thirds of the library, which compute what gfortran's do.

All of the library with its unit tests, and an example, take minutes: `scripts/tests/study_flang.py`.
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
name = "PROGRAM"
main = "PROGRAM.f90"
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


def project(folder: Path, source: str) -> Path:
    """Makes a project with a program of taut as its own, built by flang, and returns the program."""
    need_flang()
    (folder / "app").mkdir()
    shutil.copy(ROOT / source, folder / "app")
    taut = Path(os.path.relpath(ROOT, folder)).as_posix()  # fpm wants it relative
    name = Path(source).stem
    text = PROJECT.replace("TAUT", taut).replace("PROGRAM", name)
    (folder / "fpm.toml").write_text(text, encoding="utf-8")
    fpm(folder, "build")
    return next(path for path in folder.glob(f"build/flang*/app/{name}") if path.is_file())


def rows(folder: Path, name: str) -> list[dict[str, str]]:
    with (folder / name).open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_methods_give_the_same_results(pendulum: Path, tmp_path: Path) -> None:
    (tmp_path / "second").mkdir()
    made_by_flang = project(tmp_path / "second", "app/pendulum.f90")
    case = ROOT / "cases/pendulum/methods.nml"
    for name, made in (("flang", made_by_flang), ("gfortran", pendulum)):
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
