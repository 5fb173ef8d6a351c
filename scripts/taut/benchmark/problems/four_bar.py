"""N four-bar loops in a row; all cranks share one angle, so that the reference is one equation.

N + 1 cranks of 1 m stand on the points (i, 0) and carry B_i; N rods of 1 m join B_0 to B_1, B_1 to B_2 and so
on. Every rod has 1 kg, spread evenly. B_0 starts upright at 1 m/s; twice a turn all rods are in one line,
where the mechanism could fold and the constraints lose rank.
"""

import math

import numpy as np
from scipy.integrate import solve_ivp

from taut.benchmark.entrant import LADDER, Array, Problem

GRAVITY = 9.81
T_END = 10.0


def angle(size: int, t_end: float = T_END) -> tuple[float, float]:
    """Returns the cranks' angle from the horizontal and its rate, by Lagrange's equation of one freedom.

    N + 1 cranks turn about their ends, inertia 1/3; N rods move as B does, without turning: the kinetic
    energy is ((N + 1)/3 + N) a'^2/2, the potential one ((N + 1)/2 + N) g sin a.
    """
    inertia = (size + 1) / 3 + size
    moment = ((size + 1) / 2 + size) * GRAVITY
    done = solve_ivp(
        lambda _t, y: (y[1], -moment / inertia * math.cos(y[0])),
        (0.0, t_end),
        (math.pi / 2, -1.0),
        method="DOP853",
        rtol=3e-14,
        atol=1e-14,
        max_step=0.02,
    )
    return float(done.y[0, -1]), float(done.y[1, -1])


def reference(size: int) -> Array:
    """Returns {x, y of B_0, B_1, ...; their rates} after 10 s."""
    a, rate = angle(size)
    place = np.column_stack((np.arange(size + 1) + math.cos(a), np.full(size + 1, math.sin(a))))
    speed = np.tile([-rate * math.sin(a), rate * math.cos(a)], size + 1)
    return np.concatenate((place.ravel(), speed))


def error(_size: int, state: Array, reference: Array) -> float:
    """Returns the distance of B_0 from its reference [m]."""
    return float(np.hypot(*(state[:2] - reference[:2])))


def violation(size: int, state: Array) -> float:
    """Returns the largest error of a rod's length [m]."""
    b = state[: 2 * size + 2].reshape(size + 1, 2)
    cranks = b - np.column_stack((np.arange(size + 1), np.zeros(size + 1)))
    rods = np.concatenate((cranks, np.diff(b, axis=0)))
    return float(abs(np.hypot(rods[:, 0], rods[:, 1]) - 1.0).max())


PROBLEM = Problem(
    name="four-bar",
    title="N four-bar loops, 10 s",
    t_end=T_END,
    sizes=(2, 40),
    tolerances=LADDER,
    atol=lambda rtol: rtol,
    targets=lambda _size: (1e-6, 1e-9),
    reference=reference,
    error=error,
    violation=violation,
    unit="loops",
)
