"""taut as a library of others: what is installed, and each way to build upon it, in an empty folder."""

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from conftest import ROOT
from debian import NoPackageError, install, nothing_to_test

from taut.files import locked
from taut.programs import BUILDING

EXAMPLE = ROOT / "cases/examples/bead.f90"
CMAKE = """\
cmake_minimum_required(VERSION 3.18)
project(wire Fortran)
find_package(PkgConfig REQUIRED)
pkg_check_modules(TAUT REQUIRED IMPORTED_TARGET taut)
add_executable(wire bead.f90)
target_link_libraries(wire PRIVATE PkgConfig::TAUT)
"""


def done(folder: Path, *command: str | Path, **variables: str) -> str:
    ran = subprocess.run(
        command,
        cwd=folder,
        env=os.environ | {"OPENBLAS_NUM_THREADS": "1"} | variables,
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )
    assert ran.returncode == 0, (ran.stdout + ran.stderr)[-3000:]
    return ran.stdout


def need(program: str, package: str) -> None:
    if not shutil.which(program):
        try:
            install(package)
        except NoPackageError as why:
            nothing_to_test(why)


@pytest.fixture
def room(tmp_path: Path) -> Path:
    """A folder with an example and nothing else."""
    shutil.copy(EXAMPLE, tmp_path)
    return tmp_path


def runs(folder: Path, program: Path) -> None:
    assert done(folder, program).startswith("reached-end")


def test_static_programs_hold_their_libraries(installed: Path, tmp_path: Path) -> None:
    # scripts/setup installs the archives on Debian; elsewhere they may be missing, and the script says so.
    if not Path(done(tmp_path, "gfortran", "-print-file-name=liblapack.a").strip()).is_file():
        nothing_to_test("there is no liblapack.a")
    done(tmp_path, ROOT / "scripts/install", "--static", "held")
    programs = sorted((tmp_path / "held/bin").iterdir())
    assert [program.name for program in programs] == [
        path.name for path in sorted((installed / "bin").iterdir())
    ]
    for program in programs:
        assert not re.search("lapack|blas|libgfortran", done(tmp_path, "ldd", program))
    # LAPACK's eigenvalues, and letters that C's library makes.
    found = []
    for folder in (installed, tmp_path / "held"):
        out = tmp_path / folder.name
        done(
            tmp_path, folder / "bin/beam_modes", ROOT / "cases/beam_modes/table1.nml", "--out", out, "--quiet"
        )
        lines = (out / "table1/frequencies.csv").read_text(encoding="utf-8").splitlines()[1:]
        found.append([float(line.split(",")[1]) for line in lines])
    # The lowest frequency is a small difference of stiff terms.
    assert found[1] == pytest.approx(found[0], rel=1e-5)


def test_install_takes_a_prefix_and_one_option(tmp_path: Path) -> None:
    for arguments in (["--shared"], ["a", "b"], ["--static", "--static"]):
        ran = subprocess.run(
            [ROOT / "scripts/install", *arguments], cwd=tmp_path, capture_output=True, text=True, check=False
        )
        assert ran.returncode == 1
        assert ran.stderr == "install: arguments are: [--static] [PREFIX]\n"
    ran = subprocess.run([ROOT / "scripts/install", ""], capture_output=True, text=True, check=False)
    assert (ran.returncode, ran.stderr.count("\n")) == (1, 1) and "PREFIX is empty" in ran.stderr


def test_a_full_disk_is_told_and_nothing_stays(small_disk: Path) -> None:
    (small_disk / "mine").write_text("kept\n", encoding="utf-8")
    with locked(BUILDING):
        ran = subprocess.run(
            [ROOT / "scripts/install", small_disk], capture_output=True, text=True, check=False, timeout=600
        )
    assert ran.returncode == 1
    assert ran.stderr.startswith(f"install: {small_disk} cannot be written, nothing is changed: ")
    assert ran.stderr.count("\n") == 1 and "No space left" in ran.stderr
    assert [path.name for path in small_disk.iterdir()] == ["mine"]


def test_modules_have_a_folder_of_their_own(installed: Path) -> None:
    assert [path.name for path in (installed / "include").iterdir()] == ["taut"]
    assert {"taut.mod", "taut_kinds.mod"} <= {path.name for path in (installed / "include/taut").iterdir()}


def test_plain_gfortran(installed: Path, room: Path) -> None:
    # As the page says it.
    page = (ROOT / "src/README.md").read_text(encoding="utf-8")
    [line] = re.findall(r"`(gfortran -I [^`]*wire\.f90[^`]*)`", page)
    words = line.replace("~/.local", str(installed)).replace("wire.f90", "bead.f90").split()
    done(room, *words, "-o", "wire")
    runs(room, room / "wire")


def test_pkg_config(installed: Path, room: Path) -> None:
    need("pkg-config", "pkg-config")
    path = {"PKG_CONFIG_PATH": str(installed / "lib/pkgconfig")}
    flags = done(room, "pkg-config", "--cflags", "--libs", "taut", **path).split()
    done(room, "gfortran", "bead.f90", *flags, "-o", "wire")
    runs(room, room / "wire")
    version = re.search(r'(?m)^version = "(.*)"', (ROOT / "fpm.toml").read_text(encoding="utf-8"))
    assert version and done(room, "pkg-config", "--modversion", "taut", **path).strip() == version[1]


def test_pkg_config_of_a_copy(installed: Path, room: Path) -> None:
    need("pkg-config", "pkg-config")
    shutil.copytree(installed, room / "elsewhere", symlinks=True)
    said = done(room, "pkg-config", "--libs", "taut", PKG_CONFIG_PATH=str(room / "elsewhere/lib/pkgconfig"))
    assert str(installed) not in said


def test_cmake(installed: Path, room: Path) -> None:
    for program in ("cmake", "make", "pkg-config"):
        need(program, program)
    (room / "CMakeLists.txt").write_text(CMAKE, encoding="utf-8")
    done(room, "cmake", "-B", "made", ".", PKG_CONFIG_PATH=str(installed / "lib/pkgconfig"))
    done(room, "cmake", "--build", "made")
    runs(room, room / "made/wire")


def test_threads_do_not_disturb_each_other(installed: Path, tmp_path: Path) -> None:
    done(
        tmp_path,
        *("gfortran", "-std=f2018", "-Wall", "-Wextra", "-Werror", "-O1", "-g", "-fopenmp"),
        *("-I", installed / "include/taut", ROOT / "scripts/tests/threads.f90"),
        *("-L", installed / "lib", "-ltaut", "-llapack", "-lblas", "-o", "threads"),
    )
    said = done(tmp_path, tmp_path / "threads", OMP_STACKSIZE="64m")
    assert said.splitlines()[0] == "0 of 400 differ"
    # What one of them said: each kind of complaint is among it.
    for words in ("b''", "rtol", "is unknown", "no method", "coordinates", "reached-end", "not a number"):
        assert words in said, words
