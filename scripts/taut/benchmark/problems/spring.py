"""A mass of 1 kg on a stiff spring of 1 m, released from the horizontal: the pendulum, and a little stretch.

The spring is relaxed at the start, so that what rings is smaller than any tolerance here, F/k. The reference
is the rod's motion with the first-order term of a stiff spring, integrated as one equation of the angle.
"""

import math

import numpy as np
from scipy.integrate import solve_ivp

from taut.benchmark.entrant import Array, Problem

GRAVITY = 9.81
T_END = 1.0


def reference(size: int) -> Array:
    """Returns {x, y, vx, vy} after 1 s: along the spring the force of the rod over k, its length so far."""
    stiffness = 10.0**size

    def stretch(angle: float, rate: float) -> float:
        return (rate**2 + GRAVITY * math.sin(angle)) / stiffness

    # The angle below the horizontal, and the angular momentum about the support, (1 + e)^2 a'.
    def rates(_t: float, y: Array) -> tuple[float, float]:
        angle, momentum = y
        rate = momentum
        for _ in range(3):
            rate = momentum / (1 + stretch(angle, rate)) ** 2
        return rate, GRAVITY * (1 + stretch(angle, rate)) * math.cos(angle)

    done = solve_ivp(rates, (0.0, T_END), (0.0, 0.0), method="DOP853", rtol=1e-13, atol=1e-13)
    angle, rate = (float(value) for value in done.y[:, -1])
    length = 1 + stretch(angle, rate)
    place = length * np.array([math.cos(angle), -math.sin(angle)])
    return np.concatenate((place, rate * np.array([place[1], -place[0]])))


def error(_size: int, state: Array, reference: Array) -> float:
    """Returns the distance from the reference [m]."""
    return float(np.hypot(*(state[:2] - reference[:2])))


def stretch(_size: int, state: Array) -> float:
    """Returns how far the spring is from its length [m]: what a rod would violate."""
    return abs(float(np.hypot(*state[:2])) - 1.0)


PROBLEM = Problem(
    name="spring",
    title="Mass on a spring of 10^N N/m, 1 s",
    t_end=T_END,
    sizes=(8,),
    tolerances=(1e-3, 1e-4, 1e-5, 1e-6, 1e-7),
    atol=lambda rtol: 1e-3 * rtol,
    targets=lambda _size: (1e-4, 1e-6),
    reference=reference,
    error=error,
    violation=stretch,
    unit="powers of ten",
    stiff=True,
)
