"""A fast symmetric top on its tip, 2 s; the reference has its nutation in Jacobi's elliptic functions.

Data: O. Bruls and A. Cardona, J. Comput. Nonlinear Dyn. 5 (2010) 031002. The top begins level, where its
nutation turns, and dips almost straight down.
"""

import math

import numpy as np
from scipy.special import ellipj, ellipk, elliprf, elliprj

from taut.benchmark.entrant import LADDER, Array, Problem
from taut.benchmark.problems.projected import System

GRAVITY, MASS = 9.81, 15.0
# Moments of inertia about the tip: across the axis, about it; spin and first rate of precession [rad/s].
ACROSS, ALONG = 0.234375 + MASS, 0.46875
SPIN, PRECESSION = 150.0, -4.61538
T_END = 2.0


def pi(n: float, x: float, m: float) -> float:
    """Returns the elliptic integral of the third kind over the argument, of dx/(1 - n sn^2 x) from 0 to x."""
    half_turns = round(x / (2 * ellipk(m)))
    s, c, d, _ = ellipj(x - 2 * half_turns * ellipk(m), m)

    def carlson(less: float, s: float, c: float, d: float) -> float:
        # `less` is 1 - n.
        return s * elliprf(c * c, d * d, 1) + (1 - less) / 3 * s**3 * elliprj(
            c * c, d * d, 1, c * c + less * s * s
        )

    def one(s: float, c: float, d: float) -> float:
        if n > 0:
            return carlson(1 - n, s, c, d)
        # A large negative n cancels what it is added to: another one has positive terms alone (Abramowitz and
        # Stegun, 17.7.15 to 17.7.17).
        less, p = (1 - m) / (1 - n), math.sqrt(-n * (m - n) / (1 - n))
        positive = math.sqrt(less * (1 - m / (1 - less))) * carlson(less, s, c, d)
        return (positive + m / p * carlson(1.0, s, c, d) + math.atan(p * s * c / d)) / math.sqrt(
            (1 - n) * (1 - m / n)
        )

    return float(2 * half_turns * one(1.0, 0.0, math.sqrt(1 - m)) + one(s, c, d))


def exact(t: float) -> Array:
    """Returns the center of mass, 1 m from the tip, and its velocity.

    Of its height u the energy, less both angular momenta, says u'^2 = k (u - low)(u - 0)(u - high) with
    k = 2 m g/J: so u = low cn^2(K + w t), w = sqrt(k (high - low))/2. The rate of precession is
    (P - r u)/(1 - u^2), P the first one and r = J_3 spin/J.
    """
    k, r = 2 * MASS * GRAVITY / ACROSS, ALONG * SPIN / ACROSS
    # 1 + low is 3e-13, and must be known to all digits: c/b of the small root of k e^2 - b e + c = 0.
    b, c = 2 * k + PRECESSION**2 + r**2, (PRECESSION + r) ** 2
    gap = 2 * c / (b + math.sqrt(b * b - 4 * k * c))
    low, high = gap - 1, b / k - gap - 1
    m = -low / (high - low)
    w = 0.5 * math.sqrt(k * (high - low))
    start = ellipk(m)
    x = start + w * t
    sn, cn, dn, _ = ellipj(x, m)
    u, du = low * cn * cn, -2 * low * sn * cn * dn * w

    def turned(factor: float, over: float, n: float) -> float:
        return factor / (over * w) * (pi(n, x, m) - pi(n, start, m))

    # Of the two parts of 1/(1 - u^2), 1 - u = (1 - low)(1 - n sn^2) and 1 + u = gap (1 - n sn^2).
    angle = (
        math.pi / 2
        + turned((PRECESSION - r) / 2, 1 - low, -low / (1 - low))
        + turned((PRECESSION + r) / 2, gap, low / gap)
    )
    across = math.sqrt(1 - u * u)
    direction = np.array([math.cos(angle), math.sin(angle), 0.0])
    place = across * direction + [0.0, 0.0, u]
    rate = (PRECESSION - r * u) / (1 - u * u)
    velocity = rate * np.array([-place[1], place[0], 0.0]) - u * du / across * direction + [0.0, 0.0, du]
    return np.concatenate((place, velocity))


def points(y: Array) -> Array:
    """Returns the center of mass and its velocity, of a quaternion and the angular velocity in body axes."""
    a, b, c, d = y[:4] / np.linalg.norm(y[:4])
    along = np.array([2 * (b * c - a * d), 1 - 2 * (b * b + d * d), 2 * (c * d + a * b)])
    across_1 = np.array([1 - 2 * (c * c + d * d), 2 * (b * c + a * d), 2 * (b * d - a * c)])
    # omega x e_2 = omega_1 e_3 - omega_3 e_1, with e_3 = e_1 x e_2.
    return np.concatenate((along, y[4] * np.cross(across_1, along) - y[6] * across_1))


def system(_size: int) -> System:
    """Returns the heavy top about its tip: a quaternion, kept at length 1, and Euler's equations."""
    load = MASS * GRAVITY

    def rates(_t: float, y: Array) -> tuple[float, ...]:
        a, b, c, d, w1, w2, w3 = (float(value) for value in y)
        square = a * a + b * b + c * c + d * d
        # The moment of the weight is across the axis; of the vertical in body axes it takes 1 and 3.
        up_1, up_3 = 2 * (b * d - a * c) / square, (a * a - b * b - c * c + d * d) / square
        return (
            -0.5 * (b * w1 + c * w2 + d * w3),
            0.5 * (a * w1 + c * w3 - d * w2),
            0.5 * (a * w2 + d * w1 - b * w3),
            0.5 * (a * w3 + b * w2 - c * w1),
            (-load * up_3 - (ACROSS - ALONG) * w2 * w3) / ACROSS,
            0.0,
            (load * up_1 - (ALONG - ACROSS) * w1 * w2) / ACROSS,
        )

    return np.array([1.0, 0.0, 0.0, 0.0, 0.0, SPIN, PRECESSION]), rates, points


def error(_size: int, state: Array, reference: Array) -> float:
    """Returns the distance of the center of mass from its reference [m]."""
    return float(np.linalg.norm(state[:3] - reference[:3]))


PROBLEM = Problem(
    name="heavy_top",
    title="Heavy top, 2 s",
    t_end=T_END,
    sizes=(1,),
    tolerances=LADDER,
    atol=lambda rtol: rtol,
    targets=lambda _size: (1e-3, 1e-6, 1e-9),
    reference=lambda _size: exact(T_END),
    error=error,
    violation=lambda _size, state: abs(float(np.linalg.norm(state[:3])) - 1.0),
)
