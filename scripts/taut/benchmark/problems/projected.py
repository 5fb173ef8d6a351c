"""Sect. 3.5 in Python for systems with few constraints: dense, every stage projected."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import lstsq
from scipy.linalg.lapack import dposv

from taut.benchmark.entrant import Array

TOLERANCE = 1e-12
# Squared pivots and singular values below this, times the largest, count as zero where rank is lost.
CUT = 1e-8

Rates = Callable[[float, Array], Sequence[float] | Array]
Project = Callable[[Array], Array]
# Start, rates, and what makes a last state the one that is compared.
System = tuple[Array, Rates, Project]


@dataclass(frozen=True)
class Equations:
    """What M x'' + A^T lambda = f, phi(x, t) = 0 consists of, at one state."""

    mass: Array
    force: Array
    phi: Array
    jacobian: Array
    # Right-hand sides of A x' = b', A x'' = b''.
    velocity_rhs: Array
    acceleration_rhs: Array


def solve(s: Array, right: Array) -> Array:
    """Returns S^-1 times the right side by Cholesky, or the least solution where S is nearly singular."""
    factor, solution, info = dposv(s, right)
    if info == 0 and factor.diagonal().min() ** 2 > CUT * factor.diagonal().max() ** 2:
        return solution
    return lstsq(s, right, cond=CUT, check_finite=False)[0]


def stabilized(
    start: Array,
    equations: Callable[[float, Array, Array], Equations],
    t_end: float,
    tolerance: float = TOLERANCE,
) -> System:
    """Returns a system whose every stage is projected before its accelerations are had."""
    n = len(start) // 2

    def projected(t: float, y: Array) -> tuple[Array, Array, Equations]:
        place, speed = y[:n], y[n:]
        for _ in range(25):
            at = equations(t, place, speed)
            if abs(at.phi).max() <= tolerance:
                break
            a = at.jacobian
            place = place - a.T @ solve(a @ a.T, at.phi)
        a = at.jacobian
        speed = speed - a.T @ solve(a @ a.T, a @ speed - at.velocity_rhs)
        return place, speed, equations(t, place, speed)

    def rates(t: float, y: Array) -> Array:
        _, speed, at = projected(t, y)
        both = np.linalg.solve(at.mass, np.column_stack((at.force, at.jacobian.T)))
        free, across = both[:, 0], both[:, 1:]
        tension = solve(at.jacobian @ across, at.jacobian @ free - at.acceleration_rhs)
        return np.concatenate((speed, free - across @ tension))

    return start, rates, lambda y: np.concatenate(projected(t_end, y)[:2])
