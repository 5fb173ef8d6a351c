"""The pendulum, released from the horizontal; its closed form has Jacobi's elliptic functions."""

import math

import numpy as np
from scipy.special import ellipj, ellipk

from taut.benchmark.entrant import LADDER, Array, Problem

GRAVITY = 9.81


def exact(t: float) -> Array:
    """Returns {x, z, vx, vz} of a rod of 1 m at time t: sin(a/2) = k sn(K - w t), a from the lowest point."""
    k = math.sin(math.pi / 4)
    omega = math.sqrt(GRAVITY)
    sn, cn, dn, _ = ellipj(ellipk(k * k) - omega * t, k * k)
    angle = 2 * math.asin(k * sn)
    # d/dt sn(u) = -w cn dn and cos(a/2) = dn.
    rate = -2 * k * omega * cn
    sine, cosine = math.sin(angle), math.cos(angle)
    return np.array([sine, -cosine, rate * cosine, rate * sine])


def error(_size: int, state: Array, reference: Array) -> float:
    """Returns the distance from the reference [m]."""
    return float(np.hypot(*(state[:2] - reference[:2])))


PROBLEM = Problem(
    name="pendulum",
    title="Pendulum, 10 s",
    t_end=10.0,
    sizes=(1,),
    tolerances=LADDER,
    atol=lambda rtol: min(1e-6, rtol),
    targets=lambda _size: (1e-2, 1e-4, 1e-7, 1e-10),
    reference=lambda _size: exact(10.0),
    error=error,
    violation=lambda _size, state: abs(math.hypot(state[0], state[1]) - 1.0),
)
