"""Entrants that are programs; all take the same arguments and print the same, see taut_benchmark.f90."""

import os
import subprocess
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from taut.benchmark.entrant import Problem, Run
from taut.bootstrap import ROOT
from taut.errors import TautError
from taut.programs import ONE_THREAD, last_line

# Where programs and references are kept; the folder can be deleted.
WORK = ROOT / "build" / "benchmark"
# Longest time that one entrant may take for one setting [s].
PATIENCE = 120


class TookTooLongError(TautError):
    """An entrant did not come to its end in time."""


def call(command: Sequence[str | Path], cwd: Path = ROOT) -> str:
    """Returns what a command prints; its last line of errors becomes the message when it fails."""
    name = Path(command[0]).name
    try:
        done = subprocess.run(
            list(map(str, command)),
            cwd=cwd,
            env=os.environ | ONE_THREAD,
            capture_output=True,
            text=True,
            check=False,
            timeout=PATIENCE,
        )
    except FileNotFoundError as error:
        raise TautError(f"{name} is not installed") from error
    except subprocess.TimeoutExpired as error:
        raise TookTooLongError(f"{name} took longer than {PATIENCE} s") from error
    if done.returncode != 0:
        reason = last_line(done.stderr.strip() or done.stdout, done.returncode).removeprefix(f"{name}: ")
        raise TautError(f"{name}: {reason}")
    return done.stdout


def arguments(problem: Problem, size: int, method: str, rtol: float, seconds: float) -> list[str]:
    """Returns the arguments that every program takes."""
    numbers = (rtol, problem.atol(rtol), problem.max_step, problem.t_end, seconds)
    return [problem.name, str(size), method, *map(repr, numbers)]


def read_run(text: str) -> Run:
    """Returns the run that a program printed."""
    lines = text.splitlines()
    try:
        names, (steps, rhs, jacobians, seconds) = lines[0], lines[1].split(",")
        if names != "steps,rhs,jacobians,seconds":
            raise ValueError(names)
        state = np.array([float(line) for line in lines[2:]])
        return Run(float(seconds), int(steps), int(rhs), int(jacobians), state)
    except (IndexError, ValueError) as error:
        raise TautError(f"a program printed what is not a run: {error}") from error


def build(sources: Sequence[Path], libraries: Sequence[str]) -> Path:
    """Compiles a C program where it is older than its sources, headers among them; returns its path.

    It has the name of the first.
    """
    WORK.mkdir(parents=True, exist_ok=True)
    program = WORK / sources[0].stem
    if not program.exists() or program.stat().st_mtime < max(source.stat().st_mtime for source in sources):
        compiled = [source for source in sources if source.suffix == ".c"]
        call(["cc", "-O3", "-o", program, *compiled, *(f"-l{name}" for name in libraries), "-lm"])
    return program
