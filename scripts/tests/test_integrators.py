"""Integrators that are not taut's, with its two calls: constraints are met, and motions are right."""

import os
import subprocess
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import debian
import pytest
from conftest import ROOT

from taut.programs import release

EXAMPLES = ROOT / "cases/examples"
SUNDIALS = Path("/usr/include/sundials/fortran")
PROBLEMS = ("pendulum", "loop", "stiff")
IMPLICIT = ("BDF", "DIRK", "Newmark", "radau")
PACKAGES = ("gfortran", "libsundials-dev", "libsundials-fortran-dev")


@dataclass(frozen=True)
class Row:
    """A line of the table that an example prints."""

    problem: str
    integrator: str
    steps: int
    evaluations: int
    jacobians: int
    time: float
    phi: float
    phidot: float
    phiddot: float
    error: float


def called(*command: str | Path, folder: Path = ROOT) -> str:
    done = subprocess.run(
        command,
        cwd=folder,
        env=os.environ | {"OPENBLAS_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        check=False,
        timeout=600,
    )
    assert done.returncode == 0, (done.stdout + done.stderr)[-3000:]
    return done.stdout


def rows(text: str) -> Iterator[Row]:
    for line in text.splitlines():
        if line.startswith(PROBLEMS):
            problem, *name, steps, evaluations, jacobians, time, phi, phidot, phiddot, error = line.split()
            numbers = [float(word) for word in (time, phi, phidot, phiddot, error)]
            yield Row(problem, " ".join(name), int(steps), int(evaluations), int(jacobians), *numbers)


@pytest.fixture(scope="session")
def with_sundials(installed: Path, tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], str]:
    """Compiles an example against SUNDIALS' Fortran interface, and returns what it prints."""
    if not SUNDIALS.is_dir():
        try:
            debian.install(*PACKAGES)
        except debian.NoPackageError as why:
            debian.nothing_to_test(why)
    folder = tmp_path_factory.mktemp("sundials")

    def said_by(name: str) -> str:
        files = [EXAMPLES / "integrators/problems.f90", EXAMPLES / "sundials/functions.f90"]
        interfaces = [f"sundials_f{name}_mod", "sundials_fnvecserial_mod"]
        libraries = [*interfaces, f"sundials_{name}", "sundials_nvecserial"]
        called(
            *("gfortran", "-std=f2018", "-Wall", "-Wextra", "-Werror", "-O2", "-fPIC"),
            *("-I", installed / "include/taut", "-I", SUNDIALS),
            *files,
            EXAMPLES / f"sundials/{name}.f90",
            *("-L", installed / "lib", "-ltaut", "-llapack", "-lblas"),
            *(f"-l{library}" for library in libraries),
            *("-o", name),
            folder=folder,
        )
        return called(folder / name)

    return said_by


def judge(text: str, names: set[str], problems: set[str], error: float) -> None:
    found = list(rows(text))
    assert {row.integrator for row in found if not row.integrator.startswith("taut")} == names
    for name in names:
        assert {row.problem for row in found if row.integrator == name} >= problems
    for row in found:
        assert row.steps > 10 and row.evaluations >= row.steps, row
        assert max(row.phi, row.phidot, row.phiddot) <= 1e-12, row
        assert row.error <= (1e-6 if row.integrator.startswith("taut") else error), row
        assert (row.jacobians > 0) == any(
            word in row.integrator for word in ("BDF", "DIRK", "Newmark", "radau")
        ), row


@pytest.mark.parametrize(
    ("name", "integrator", "error"), [("rk4", "RK4", 1e-7), ("newmark", "Newmark", 1e-4)]
)
def test_integrators_of_ones_own(name: str, integrator: str, error: float) -> None:
    text = called(release(name))
    judge(text, {integrator}, set(PROBLEMS), error)


def test_cvode(with_sundials: Callable[[str], str]) -> None:
    judge(with_sundials("cvode"), {"CVODE BDF"}, set(PROBLEMS), 2e-4)


def test_arkode(with_sundials: Callable[[str], str]) -> None:
    judge(with_sundials("arkode"), {"ARKODE explicit", "ARKODE DIRK"}, {"pendulum", "loop"}, 1e-6)
