"""The code at hand: its release build."""

import functools
import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from taut.benchmark.entrant import Array, Entrant, Peer, Problem, Run
from taut.benchmark.peers.program import arguments, call, read_run
from taut.benchmark.problems import bricard
from taut.bootstrap import ROOT
from taut.programs import release

# Names in tables, and the methods behind them as program/taut_benchmark.f90 takes them.
METHODS = {
    "taut": "present",
    "taut, stages as they are": "present-stage-none",
    "taut, dop853": "present-dop853",
    "taut, dop853, stages as they are": "present-stage-none-dop853",
    "taut, Eq. (8)": "baseline",
}
# What derivatives by hand are worth, on problems that program/phi_alone.f90 has without.
PHI_ALONE = ("chain", "four-bar")
# On problems that are stiff, implicit integrators as well.
STIFF = {
    "taut": "present",
    "taut, dop853": "present-dop853",
    "taut, Radau IIA": "present-radau",
    "taut, generalized-alpha": "present-generalized-alpha",
}


def squeezer_angles(state: Array) -> Array:
    """Returns the published angles and their rates, of seven bodies {x, y, angle; their rates}."""
    k1, k2, k3, k4, k5, k6, k7 = state.reshape(2, 7, 3)[:, :, 2].T
    return np.array([k1, k2 - k1, k3, k4 - k5, k5, k6 - k7, k7]).T.ravel()


def rod_ends(state: Array) -> Array:
    """Returns the ends of Bricard's rods 1 to 4 and their velocities, of the centers of the five rods."""
    # A body has a quaternion; behind the bodies the turning of the hinges is counted.
    place, speed = state[:35].reshape(5, 7)[:, :3], state[-30:].reshape(5, 6)[:, :3]
    ends = []
    for centers, last in ((place, bricard.END), (speed, np.zeros(3))):
        first = 2 * centers[0]
        second = 2 * centers[1] - first
        ends += [first, second, 2 * centers[2] - second, 2 * centers[4] - last]
    return np.concatenate(ends)


# The problems that program/taut_benchmark.f90 has a model of, and what of its state the problem asks for.
MODELS: dict[str, Callable[[int, Array], Array]] = {
    "pendulum": lambda _size, state: state,
    "chain": lambda _size, state: state,
    # Between two tips there is the center of the rod that joins them.
    "four-bar": lambda size, state: state.reshape(2, 2 * size + 1, 2)[:, ::2].ravel(),
    # Of the body's quaternion and angular velocity nothing is asked.
    "heavy_top": lambda _size, state: state[[0, 1, 2, 7, 8, 9]],
    "andrews": lambda _size, state: squeezer_angles(state),
    "bricard": lambda _size, state: rod_ends(state),
    "car-axis": lambda _size, state: state,
    # The body has an angle too.
    "spring": lambda _size, state: state.reshape(2, 3)[:, :2].ravel(),
    # Seven coordinates a node; a marker at every quarter.
    "swing": lambda size, state: state[: 7 * (size + 1)].reshape(size + 1, 7)[:: size // 4, :2].ravel(),
}
# From this size on, a single tolerance.
LARGE = 10000


@functools.cache
def program() -> Path:
    """Builds the program once."""
    return release("taut_benchmark")


def version() -> str:
    """Returns the version in fpm.toml."""
    found = re.search(r'(?m)^version = "([^"]+)"', (ROOT / "fpm.toml").read_text(encoding="utf-8"))
    return found[1] if found else "unknown"


def entrants(problem: Problem, size: int) -> Sequence[Entrant]:
    """Returns one entrant for each method."""
    if problem.name not in MODELS:
        return []

    def entrant(label: str, method: str) -> Entrant:
        def run(rtol: float, seconds: float) -> Run:
            done = read_run(call([program(), *arguments(problem, size, method, rtol, seconds)]))
            return replace(done, state=MODELS[problem.name](size, done.state))

        settings = problem.tolerances if size < LARGE else (1e-6,)
        return Entrant(label, "taut", settings, run)

    methods = STIFF if problem.stiff else METHODS
    if problem.name in PHI_ALONE:
        methods = methods | {"taut, phi alone": "present-phi"}
    return [entrant(label, method) for label, method in methods.items()]


PEER = Peer("taut", version, entrants)
