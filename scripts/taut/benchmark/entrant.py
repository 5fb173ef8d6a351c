"""What is measured: problems, entrants and their runs."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

Array = np.ndarray
# Tolerances of problems that are not stiff.
LADDER = tuple(float(f"1e-{digits}") for digits in range(3, 13))


@dataclass(frozen=True)
class Problem:
    """A problem with an independent reference; a state is the points' coordinates and velocities {x; v}."""

    name: str
    title: str
    t_end: float
    # Sizes for everyone, and larger ones for taut alone.
    sizes: tuple[int, ...]
    # Tolerances of the figure of work against precision; atol follows from rtol.
    tolerances: tuple[float, ...]
    atol: Callable[[float], float]
    # Errors [m] at which entrants are compared.
    targets: Callable[[int], tuple[float, ...]]
    # The state at the end by an independent way, and the error of a state against it [m].
    reference: Callable[[int], Array]
    error: Callable[[int, Array, Array], float]
    # Largest violation of the constraints [m].
    violation: Callable[[int, Array], float]
    large_sizes: tuple[int, ...] = ()
    max_step: float = 0.0
    # Whether implicit methods take part.
    stiff: bool = False
    # What `size` counts, and the unit of the error.
    unit: str = "masses"
    error_unit: str = "m"


@dataclass(frozen=True)
class Run:
    """The cheapest of some equal runs: processor time [s] beyond a program's start, and the last state."""

    seconds: float
    steps: int
    rhs: int
    # Of implicit methods; one by differences costs right-hand sides, which are counted as well.
    jacobians: int
    state: Array


@dataclass(frozen=True)
class Entrant:
    """A method of a peer on a problem of one size; a setting is rtol, or the step [s] where that is fixed."""

    label: str
    peer: str
    settings: tuple[float, ...]
    # Returns the best of the runs that fit into so many seconds, at least one.
    run: Callable[[float, float], Run]


@dataclass(frozen=True)
class Peer:
    """A code that takes part; one module each."""

    name: str
    # The version where it is installed, or None.
    version: Callable[[], str | None]
    entrants: Callable[[Problem, int], Sequence[Entrant]]
    # What --install installs: packages of PyPI, pinned, or of Debian.
    pypi: tuple[str, ...] = ()
    debian: tuple[str, ...] = ()
