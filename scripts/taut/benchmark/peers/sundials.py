"""SUNDIALS' ARKODE: an explicit method of order 5(4) with projection after each step, in C (sundials.c)."""

import functools
from collections.abc import Sequence
from pathlib import Path

from taut.benchmark.entrant import Entrant, Peer, Problem, Run
from taut.benchmark.peers.program import arguments, build, call, read_run
from taut.errors import TautError

LIBRARIES = ("sundials_arkode", "sundials_nvecserial", "lapack")
MODELS = ("pendulum", "chain", "four-bar")


@functools.cache
def program() -> Path:
    """Compiles the program once."""
    return build(Path(__file__).with_suffix(".c"), LIBRARIES)


def version() -> str | None:
    """Returns the version of the library, or None where the program cannot be compiled."""
    try:
        return call([program(), "--version"]).strip()
    except TautError:
        return None


def entrants(problem: Problem, size: int) -> Sequence[Entrant]:
    """Returns ARKODE's Dormand-Prince method."""
    if problem.name not in MODELS:
        return []

    def run(rtol: float, seconds: float) -> Run:
        return read_run(call([program(), *arguments(problem, size, "erk", rtol, seconds)]))

    return [Entrant("SUNDIALS ARKODE", "sundials", problem.tolerances, run)]


PEER = Peer("sundials", version, entrants, debian=("libsundials-dev", "liblapack-dev"))
