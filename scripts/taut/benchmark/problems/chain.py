"""A horizontal chain of rods falls; the reference has the rods' angles for coordinates and no constraints."""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import solve_banded

from taut.benchmark.entrant import LADDER, Array, Problem

GRAVITY = 9.81


def angular(_time: float, y: Array) -> Array:
    """Returns the rates of angles a (from the horizontal) and angular velocities w.

    With rods e_i = (cos a_i, sin a_i) of 1 m and unit masses: T_(i+1) e_(i+1) - T_i e_i + g accelerates
    mass i, and the difference of two of them is w_i' n_i - w_i^2 e_i: along e_i it gives the tensions T,
    across it w'.
    """
    n = len(y) // 2
    a, w = y[:n], y[n:]
    difference = np.diff(a)
    cosine, sine = np.cos(difference), np.sin(difference)
    bands = np.zeros((3, n))
    bands[0, 1:] = bands[2, :-1] = -cosine
    bands[1] = 2.0
    bands[1, 0] = 1.0
    # The first rod hangs on a fixed point, which does not accelerate: gravity stays in its row.
    right = w * w
    right[0] -= GRAVITY * np.sin(a[0])
    tension = solve_banded((1, 1), bands, right, overwrite_ab=True, overwrite_b=True, check_finite=False)
    rate = np.empty_like(y)
    rate[:n] = w
    rate[n:] = 0.0
    rate[n:-1] += tension[1:] * sine
    rate[n + 1 :] -= tension[:-1] * sine
    rate[n] -= GRAVITY * np.cos(a[0])
    return rate


def points(a: Array, w: Array) -> Array:
    """Returns {x1, z1, x2, ...; their rates} of a chain with these angles and angular velocities."""
    place = np.cumsum(np.column_stack((np.cos(a), np.sin(a))), axis=0)
    speed = np.cumsum(np.column_stack((-w * np.sin(a), w * np.cos(a))), axis=0)
    return np.concatenate((place.ravel(), speed.ravel()))


def reference(size: int) -> Array:
    """Returns the points after 1 s by DOP853 on the angles."""
    # Round-off of the angles adds up along a long chain, which no tolerance mends.
    rtol = 1e-13 if size <= 100 else 1e-12 if size <= 1000 else 1e-10
    done = solve_ivp(
        angular, (0.0, 1.0), np.zeros(2 * size), method="DOP853", rtol=rtol, atol=rtol, t_eval=[1.0]
    )
    return points(done.y[:size, -1], done.y[size:, -1])


def error(size: int, state: Array, reference: Array) -> float:
    """Returns the largest distance of a mass from its reference [m]."""
    away = (state[: 2 * size] - reference[: 2 * size]).reshape(size, 2)
    return float(np.hypot(away[:, 0], away[:, 1]).max())


def violation(size: int, state: Array) -> float:
    """Returns the largest error of a rod's length [m]."""
    rods = np.diff(state[: 2 * size].reshape(size, 2), axis=0, prepend=[[0.0, 0.0]])
    return float(abs(np.hypot(rods[:, 0], rods[:, 1]) - 1.0).max())


PROBLEM = Problem(
    name="chain",
    title="Chain of n rods, 1 s",
    t_end=1.0,
    sizes=(10, 100, 1000),
    large_sizes=(10000, 100000),
    tolerances=LADDER,
    atol=lambda rtol: 1e-2 * rtol,
    targets=lambda size: (1e-5,) if size <= 10000 else (1e-4,),
    reference=reference,
    error=error,
    violation=violation,
)
