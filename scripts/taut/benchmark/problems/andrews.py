"""Andrews' squeezing mechanism, 0.03 s: seven bodies in the plane.

Data: W. Schiehlen (ed.), Multibody Systems Handbook, Springer 1990. Angles and equations as in the Test set
for initial value problem solvers (F. Mazzia, C. Magherini, 2008). The end it gives is good to 1.5e-9 rad.
"""

import math

import numpy as np
from scipy.integrate import solve_ivp

from taut.benchmark.entrant import LADDER, Array, Problem
from taut.benchmark.problems.projected import TOLERANCE, Equations, System, stabilized

T_END = 0.03
# Angles of the published start and end, and their rates: beta, Theta, gamma, Phi, delta, Omega, epsilon.
START = (
    *(-0.0617138900142764496358948458001, 0.0, 0.455279819163070380255912382449),
    *(0.222668390165885884674473185609, 0.487364979543842550225598953530),
    *(-0.222668390165885884674473185609, 1.23054744454982119249735015568),
)
END = (
    *(15.81077119629904, -15.75637105984298, 0.04082224013073101, -0.5347301163226948),
    *(0.5244099658805304, 0.5347301163226948, 1.048080741042263),
)
END_RATES = (
    *(1139.920302151208, -1424.379294994111, 11.03291221937134, 19.29337464421385),
    *(0.5735699284790808, -19.29337464421385, 0.3231791658026955),
)
# Lengths [m] and fixed points of the loops.
D, E, RR, SS, U, ZF, ZT = 28e-3, 2e-2, 7e-3, 35e-3, 4e-2, 2e-2, 4e-2
XA, YA, XB, YB = -0.06934, -0.00227, -0.03635, 0.03273


def loops(q: Array) -> Array:
    """Returns by how much the three loops of the angles are open [m]."""
    b, th, g, ph, dl, om, ep = q
    x = RR * math.cos(b) - D * math.cos(b + th)
    y = RR * math.sin(b) - D * math.sin(b + th)
    return np.array(
        [
            x - SS * math.sin(g) - XB,
            y + SS * math.cos(g) - YB,
            x - E * math.sin(ph + dl) - ZT * math.cos(dl) - XA,
            y + E * math.cos(ph + dl) - ZT * math.sin(dl) - YA,
            x - ZF * math.cos(om + ep) - U * math.sin(ep) - XA,
            y - ZF * math.sin(om + ep) + U * math.cos(ep) - YA,
        ]
    )


def turned(x: Array, v: Array) -> tuple[Array, Array]:
    """Returns A, and A' x'; all parts of the loops are arms that turn: length, angle, and its rate."""
    be, th, ga, ph, dl, om, ep = x
    # Each arm (cos, sin) times its length, of an angle that is the sum of those named.
    arms = (
        (RR, be, (0,), (0, 1, 2)),
        (-D, be + th, (0, 1), (0, 1, 2)),
        (SS, ga + math.pi / 2, (2,), (0,)),
        (E, ph + dl + math.pi / 2, (3, 4), (1,)),
        (-ZT, dl, (4,), (1,)),
        (-ZF, om + ep, (5, 6), (2,)),
        (U, ep + math.pi / 2, (6,), (2,)),
    )
    jacobian, bend = np.zeros((6, 7)), np.zeros(6)
    for length, angle, turned_by, loops in arms:
        arm = length * np.array([math.cos(angle), math.sin(angle)])
        rate = sum(v[k] for k in turned_by)
        for loop in loops:
            bend[2 * loop : 2 * loop + 2] -= rate * rate * arm
            for k in turned_by:
                jacobian[2 * loop : 2 * loop + 2, k] += [-arm[1], arm[0]]
    return jacobian, bend


def system(_size: int, tolerance: float = TOLERANCE) -> System:
    """Returns Andrews' mechanism in its seven angles, as published."""
    m2, m3, m4, m5, m6, m7 = 0.00365, 0.02373, 0.00706, 0.07050, 0.00706, 0.05498
    i1, i2, i3, i4, i5, i6, i7 = 2.194e-6, 4.410e-7, 5.255e-6, 5.667e-7, 1.169e-5, 5.667e-7, 1.912e-5
    da, ea, fa, ra = 115e-4, 1421e-5, 1421e-5, 92e-5
    sa, sb, sc, sd, ta, tb, ua, ub = 1874e-5, 1043e-5, 18e-3, 2e-2, 2308e-5, 916e-5, 1228e-5, 449e-5
    xc, yc, stiffness, free, motor = 0.014, 0.072, 4530.0, 0.07785, 0.033
    lever4, lever6 = E - ea, ZF - fa
    mass = np.zeros((7, 7))
    mass[1, 1] = m2 * da**2 + i2
    mass[2, 2] = m3 * (sa**2 + sb**2) + i3
    mass[3, 3] = m4 * lever4**2 + i4
    mass[5, 5] = m6 * lever6**2 + i6

    def equations(_t: float, x: Array, v: Array) -> Equations:
        _, th, ga, ph, _, om, _ = x
        b1, t1, _, p1, d1, o1, e1 = v
        m = mass.copy()
        cosine = da * RR * math.cos(th)
        m[0, 0] = 0.04325 * ra**2 + m2 * (RR**2 - 2 * cosine + da**2) + i1 + i2
        m[0, 1] = m[1, 0] = m2 * (da**2 - cosine) + i2
        sine = ZT * lever4 * math.sin(ph)
        m[3, 4] = m[4, 3] = m4 * (lever4**2 + sine) + i4
        m[4, 4] = m4 * (ZT**2 + 2 * sine + lever4**2) + m5 * (ta**2 + tb**2) + i4 + i5
        sine = U * lever6 * math.sin(om)
        m[5, 6] = m[6, 5] = m6 * (lever6**2 - sine) + i6
        m[6, 6] = m6 * (lever6**2 - 2 * sine + U**2) + m7 * (ua**2 + ub**2) + i6 + i7
        to_x = sc * math.sin(ga) + sd * math.cos(ga)
        to_y = sd * math.sin(ga) - sc * math.cos(ga)
        away = np.array([to_x + XB - xc, to_y + YB - yc])
        length = math.hypot(*away)
        pull = -stiffness * (length - free) / length * away
        swing2 = m2 * da * RR * math.sin(th)
        swing4 = m4 * ZT * lever4 * math.cos(ph)
        swing6 = m6 * U * lever6 * math.cos(om)
        force = np.array(
            [
                motor - swing2 * t1 * (t1 + 2 * b1),
                swing2 * b1 * b1,
                pull[1] * to_x - pull[0] * to_y,
                swing4 * d1 * d1,
                -swing4 * p1 * (p1 + 2 * d1),
                -swing6 * e1 * e1,
                swing6 * o1 * (o1 + 2 * e1),
            ]
        )
        jacobian, bend = turned(x, v)
        return Equations(m, force, loops(x), jacobian, np.zeros(6), -bend)

    return stabilized(np.array(START + 7 * (0.0,)), equations, T_END, tolerance)


def reference(_size: int) -> Array:
    """Returns the published angles and rates to more digits, by DOP853 on the same equations."""
    start, rates, project = system(1, 1e-16)
    done = solve_ivp(rates, (0.0, T_END), start, method="DOP853", rtol=1e-13, atol=1e-13)
    return project(done.y[:, -1])


def error(_size: int, state: Array, reference: Array) -> float:
    """Returns the largest error of an angle [rad]."""
    return float(abs(state[:7] - reference[:7]).max())


def violation(_size: int, state: Array) -> float:
    """Returns how far the loops are open [m]."""
    return float(abs(loops(state[:7])).max())


PROBLEM = Problem(
    name="andrews",
    title="Andrews' squeezer, 0.03 s",
    t_end=T_END,
    sizes=(1,),
    tolerances=LADDER,
    atol=lambda rtol: rtol,
    targets=lambda _size: (1e-3, 1e-7, 1e-9),
    reference=reference,
    error=error,
    violation=violation,
    error_unit="rad",
)
