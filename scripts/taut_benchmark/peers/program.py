"""Entrants that are programs; all take the same arguments and print the same, see app/taut_benchmark.f90."""

import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from taut_report.bootstrap import ROOT

from taut_benchmark.entrant import BenchmarkError, Problem, Run

# One thread for everyone.
ENVIRONMENT = {
    f"{name}_NUM_THREADS": "1" for name in ("OPENBLAS", "OMP", "MKL", "BLIS", "NUMEXPR", "VECLIB_MAXIMUM")
}
# Where programs and references are kept; the folder can be deleted.
WORK = ROOT / "build" / "benchmark"
# Longest time that one entrant may take for one setting [s].
PATIENCE = 1800


def call(command: Sequence[str | Path], cwd: Path = ROOT) -> str:
    """Returns what a command prints; its last line of errors becomes the message when it fails."""
    name = Path(command[0]).name
    try:
        done = subprocess.run(
            list(map(str, command)),
            cwd=cwd,
            env=os.environ | ENVIRONMENT,
            capture_output=True,
            text=True,
            check=False,
            timeout=PATIENCE,
        )
    except FileNotFoundError as error:
        raise BenchmarkError(f"{name} is not installed") from error
    except subprocess.TimeoutExpired as error:
        raise BenchmarkError(f"{name} took longer than {PATIENCE} s") from error
    if done.returncode != 0:
        said = (done.stderr.strip() or done.stdout.strip()).splitlines()
        reason = said[-1].removeprefix(f"{name}: ") if said else f"exit code {done.returncode}"
        raise BenchmarkError(f"{name}: {reason}")
    return done.stdout


def arguments(problem: Problem, size: int, method: str, rtol: float, seconds: float) -> list[str]:
    """Returns the arguments that every program takes."""
    numbers = (rtol, problem.atol(rtol), problem.max_step, problem.t_end, seconds)
    return [problem.name, str(size), method, *map(repr, numbers)]


def read_run(text: str) -> Run:
    """Returns the run that a program printed."""
    lines = text.splitlines()
    try:
        names, (steps, rhs, seconds) = lines[0], lines[1].split(",")
        if names != "steps,rhs,seconds":
            raise ValueError(names)
        return Run(float(seconds), int(steps), int(rhs), np.array([float(line) for line in lines[2:]]))
    except (IndexError, ValueError) as error:
        raise BenchmarkError(f"a program printed what is not a run: {error}") from error


def build(source: Path, libraries: Sequence[str], flags: Sequence[str] = ()) -> Path:
    """Compiles a C or C++ program of this folder where it is older than its source; returns its path."""
    WORK.mkdir(parents=True, exist_ok=True)
    program = WORK / source.stem
    if not program.exists() or program.stat().st_mtime < source.stat().st_mtime:
        compiler = "c++" if source.suffix == ".cpp" else "cc"
        call([compiler, "-O3", "-o", program, source, *flags, *(f"-l{name}" for name in libraries), "-lm"])
    return program


def fpm() -> str:
    """Returns fpm: the one beside this Python, or on the path."""
    beside = Path(sys.executable).parent / "fpm"
    found = str(beside) if beside.exists() else shutil.which("fpm")
    if found is None:
        raise BenchmarkError("fpm is not installed; run scripts/setup first")
    return found


def release(app: str) -> Path:
    """Builds an app in the release profile and returns its path."""
    call([fpm(), "build", "--profile", "release"])
    # fpm itself tells where it puts it: a build folder may hold programs made with several sets of flags.
    said = call([fpm(), "run", app, "--profile", "release", "--runner", "echo"])
    return ROOT / said.strip().splitlines()[-1].strip()
