"""SUNDIALS' integrators on models by hand in C (sundials.c): ARKODE with projection after each step, IDA."""

import functools
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from taut.benchmark.entrant import Array, Entrant, Peer, Problem, Run
from taut.benchmark.peers.program import arguments, build, call, read_run
from taut.benchmark.problems import heavy_top
from taut.errors import TautError

SOURCES = [
    Path(__file__).with_name(name)
    for name in ("sundials.c", "sundials_models.c", "sundials_stiff.c", "sundials_models.h")
]
LIBRARIES = ("sundials_arkode", "sundials_ida", "sundials_nvecserial", "lapack", "blas")
# Names in tables, and the methods behind them as the program takes them.
METHODS = {"SUNDIALS ARKODE": "erk", "SUNDIALS ARKODE, order 8": "erk8"}
STIFF = {"SUNDIALS ARKODE": "erk", "SUNDIALS ARKStep": "dirk", "SUNDIALS IDA": "ida"}


def whole(_size: int, state: Array) -> Array:
    """Returns the state as it is."""
    return state


# The problems that the program has a model of, and what of its state the problem asks for.
MODELS: dict[str, Callable[[int, Array], Array]] = {
    "pendulum": whole,
    "chain": whole,
    "four-bar": whole,
    "heavy_top": lambda _size, state: heavy_top.points(state),
    "andrews": whole,
    "spring": whole,
    "car-axis": whole,
    # Three coordinates a node; a marker at every quarter.
    "swing": lambda size, state: state[: 3 * (size + 1)].reshape(size + 1, 3)[:: size // 4, :2].ravel(),
}


@functools.cache
def program() -> Path:
    """Compiles the program once."""
    return build(SOURCES, LIBRARIES)


def version() -> str | None:
    """Returns the version of the library, or None where the program cannot be compiled."""
    try:
        return call([program(), "--version"]).strip()
    except TautError:
        return None


def entrants(problem: Problem, size: int) -> Sequence[Entrant]:
    """Returns one entrant for each method."""
    if problem.name not in MODELS:
        return []

    def entrant(label: str, method: str) -> Entrant:
        def run(rtol: float, seconds: float) -> Run:
            done = read_run(call([program(), *arguments(problem, size, method, rtol, seconds)]))
            return replace(done, state=MODELS[problem.name](size, done.state))

        return Entrant(label, "sundials", problem.tolerances, run)

    return [entrant(label, method) for label, method in (STIFF if problem.stiff else METHODS).items()]


PEER = Peer("sundials", version, entrants, debian=("libsundials-dev", "liblapack-dev"))
