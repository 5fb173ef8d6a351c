"""Half a car on a bumpy road: a rod on two stiff springs, one end of whose axle follows the road; no units.

Equations, start and end: F. Mazzia and C. Magherini, Test set for initial value problem solvers, release 2.4,
2008, 'Car axis' (S. Schneider). The end was computed there by GAMD in quadruple precision.
"""

import math

import numpy as np

from taut.benchmark.entrant import Array, Problem
from taut.benchmark.problems.projected import Equations, System, stabilized

T_END = 3.0
# Length of rod and axle, of the relaxed springs; height and frequency of the bumps; mass of an end.
LENGTH, FREE, HEIGHT, FREQUENCY = 1.0, 0.5, 0.1, 10.0
K = 1e-4 * 10.0 / 2.0
# {x_l, y_l, x_r, y_r; their rates}.
START = (0.0, FREE, LENGTH, FREE, -FREE / LENGTH, 0.0, -FREE / LENGTH, 0.0)
END = (
    *(0.493455784275402809122e-1, 0.496989460230171153861, 1.04174252488542151681, 0.373911027265361256927),
    *(-0.770583684040972357970e-1, 0.744686658723778553466e-2),
    *(0.175568157537232222276e-1, 0.770341043779251976443),
)


def axle(t: float) -> tuple[Array, Array, Array]:
    """Returns where the end of the axle is that follows the road, its velocity and its acceleration."""
    y, v, a = (
        HEIGHT * value
        for value in (
            math.sin(FREQUENCY * t),
            FREQUENCY * math.cos(FREQUENCY * t),
            -(FREQUENCY**2) * math.sin(FREQUENCY * t),
        )
    )
    x = math.sqrt(LENGTH**2 - y**2)
    rate = -y * v / x
    return np.array([x, y]), np.array([rate, v]), np.array([-(v * v + y * a + rate * rate) / x, a])


def system(_size: int) -> System:
    """Returns the car axis, as published but for the constraints' factor."""
    mass = np.diag(np.full(4, K))

    def equations(t: float, x: Array, v: Array) -> Equations:
        road, rate, bend = axle(t)
        left, right = x[:2], x[2:]
        across = right - road
        rod, turning = left - right, v[:2] - v[2:]
        pull = [(FREE / math.hypot(*spring) - 1) * spring - [0.0, K] for spring in (left, across)]
        return Equations(
            mass=mass,
            force=np.concatenate(pull),
            phi=np.array([left @ road, rod @ rod - LENGTH**2]),
            jacobian=np.array([[*road, 0.0, 0.0], [*(2 * rod), *(-2 * rod)]]),
            velocity_rhs=np.array([-left @ rate, 0.0]),
            acceleration_rhs=np.array([-2 * v[:2] @ rate - left @ bend, -2 * turning @ turning]),
        )

    return stabilized(np.array(START), equations, T_END)


def error(_size: int, state: Array, reference: Array) -> float:
    """Returns the distance of the worse end of the rod from its reference."""
    return float(np.hypot(*(state[:4] - reference[:4]).reshape(2, 2).T).max())


def violation(_size: int, state: Array) -> float:
    """Returns how far the left spring is from standing across, or the rod's length from 1."""
    left, right = state[:4].reshape(2, 2)
    return max(abs(float(left @ axle(T_END)[0])), abs(float(np.hypot(*(right - left))) - LENGTH))


PROBLEM = Problem(
    name="car-axis",
    title="Car axis, 3 s",
    t_end=T_END,
    sizes=(1,),
    tolerances=(1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9),
    atol=lambda rtol: 1e-1 * rtol,
    targets=lambda _size: (1e-4, 1e-6),
    reference=lambda _size: np.array(END),
    error=error,
    violation=violation,
    stiff=True,
)
