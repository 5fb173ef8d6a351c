"""Bricard's mechanism, 10 s: five slender rods, six hinges, one freedom; the reference is one equation of it.

Data: IFToMM's library of multibody benchmarks. By symmetry hinges 1, 3, 5 turn by one angle and 2, 4, 6 by
another, and the loop ties them together: (1 + sin a)(1 + sin b) = 1, both zero at the start.
"""

import math

import numpy as np
from scipy.integrate import solve_ivp

from taut.benchmark.entrant import LADDER, Array, Problem
from taut.benchmark.problems.projected import Equations, System, stabilized

GRAVITY = 9.81
T_END = 10.0
# Side of a rod's square section [m]: taut's, where none is given.
THICKNESS = 1e-3
# At the start: the axis of the hinge before each rod, and the rod [m]. The sixth hinge, about x, is at END.
AXES = (1, 2, 0, 1, 2)
RODS = np.array([[1, 0, 0], [0, -1, 0], [0, 0, 1], [-1, 0, 0], [0, 1, 0]])
END = np.array([0.0, 0.0, 1.0])


def kinematics(angles: Array, rates: Array) -> tuple[Array, Array, Array]:
    """Returns the rods' ends, their velocities, and the rods' angular velocities; for complex numbers too."""
    frame = np.eye(3, dtype=angles.dtype)
    spin = np.zeros(3, dtype=angles.dtype)
    point, speed = spin, spin
    points, speeds, spins = [], [], []
    for axis, rod, angle, rate in zip(AXES, RODS, angles, rates, strict=True):
        i, j = (axis + 1) % 3, (axis + 2) % 3
        cosine, sine = np.cos(angle), np.sin(angle)
        spin = spin + frame[:, axis] * rate
        turned = frame.copy()
        turned[:, i] = frame[:, i] * cosine + frame[:, j] * sine
        turned[:, j] = frame[:, j] * cosine - frame[:, i] * sine
        frame = turned
        along = frame @ rod
        point = point + along
        speed = speed + np.cross(spin, along)
        points.append(point)
        speeds.append(speed)
        spins.append(spin)
    return np.array(points), np.array(speeds), np.array(spins)


def motion(a: complex, b: complex, rate: complex) -> tuple[complex, complex, Array, Array]:
    """Returns kinetic energy [J], power of the weight against it [W], rods' ends and their velocities.

    The rate is of a parameter u with a' = cos b (1 + sin a) and b' = -cos a (1 + sin b): it keeps the loop
    closed, and goes through the dead points of either angle.
    """
    da, db = np.cos(b) * (1 + np.sin(a)), -np.cos(a) * (1 + np.sin(b))
    points, speeds, spins = kinematics(np.array([a, b, a, b, a]), rate * np.array([da, db, da, db, da]))
    ends = np.vstack((np.zeros(3), speeds))
    first, second = ends[:-1], ends[1:]
    kinetic = ((first * first).sum() + (first * second).sum() + (second * second).sum()) / 6
    # As thick as they are, rods turn about themselves, by twice as much as they resist more across.
    about = np.einsum("ij,ij->i", spins, np.diff(np.vstack((np.zeros(3), points)), axis=0))
    kinetic += ((spins * spins).sum() + (about * about).sum()) * THICKNESS**2 / 24
    return kinetic, GRAVITY * (first + second)[:, 1].sum() / 2, points, speeds


def angle_rates(_t: float, y: Array) -> tuple[float, float, float]:
    """Returns a', b' and u'' of T(u) u'^2 + V(u): 2 T u'' = -dT/du u'^2 - dV/du, dT/du by a complex step."""
    a, b, rate = y
    da, db = math.cos(b) * (1 + math.sin(a)), -math.cos(a) * (1 + math.sin(b))
    step = 1e-30j
    unit, weight, _, _ = motion(a + step * da, b + step * db, 1.0 + 0j)
    change = unit.imag / abs(step)
    return rate * da, rate * db, -(change * rate * rate + weight.real) / (2 * unit.real)


def reference(_size: int) -> Array:
    """Returns the ends of the rods 1 to 4 and their velocities."""
    done = solve_ivp(angle_rates, (0.0, T_END), (0.0, 0.0, 0.0), method="DOP853", rtol=1e-13, atol=1e-14)
    _, _, points, speeds = motion(*done.y[:, -1])
    return np.concatenate((points[:4].ravel(), speeds[:4].ravel()))


def system(_size: int) -> System:
    """Returns Bricard's mechanism: a chain of five rods in its five angles, whose end is held."""
    rods = len(AXES)
    across, about = (1 + THICKNESS**2) / 12, THICKNESS**2 / 6
    weight = np.array([0.0, -GRAVITY, 0.0])

    def equations(_t: float, x: Array, v: Array) -> Equations:
        frame, spin, turning = np.eye(3), np.zeros(3), np.zeros(3)
        arms, place, bend = np.zeros((3, rods)), np.zeros(3), np.zeros(3)
        axes = np.zeros((3, rods))
        mass, force = np.zeros((rods, rods)), np.zeros(rods)
        for k, (axis, rod) in enumerate(zip(AXES, RODS, strict=True)):
            axes[:, k] = frame[:, axis]
            turning = turning + np.cross(spin, axes[:, k]) * v[k]
            spin = spin + axes[:, k] * v[k]
            i, j = (axis + 1) % 3, (axis + 2) % 3
            cosine, sine = math.cos(x[k]), math.sin(x[k])
            frame[:, [i, j]] = frame[:, [i, j]] @ np.array([[cosine, -sine], [sine, cosine]])
            along = frame @ rod
            moved = np.cross(axes.T, along).T
            bent = np.cross(turning, along) + np.cross(spin, np.cross(spin, along))
            center, center_bend = arms + 0.5 * moved, bend + 0.5 * bent
            inertia = across * np.eye(3) + (about - across) * np.outer(along, along)
            mass += center.T @ center + axes.T @ inertia @ axes
            torque = inertia @ turning + np.cross(spin, inertia @ spin)
            force += center.T @ (weight - center_bend) - axes.T @ torque
            arms, place, bend = arms + moved, place + along, bend + bent
        # The last rod stays across the sixth hinge: its axis x along x.
        side = frame[:, 0]
        side_rate = np.cross(axes.T, side).T
        side_bend = np.cross(turning, side) + np.cross(spin, np.cross(spin, side))
        return Equations(
            mass,
            force,
            np.concatenate((place - END, side[1:])),
            np.vstack((arms, side_rate[1:])),
            np.zeros(5),
            -np.concatenate((bend, side_bend[1:])),
        )

    start, rates, project = stabilized(np.zeros(2 * rods), equations, T_END)

    def points(y: Array) -> Array:
        x, v = project(y).reshape(2, rods)
        place, speed, _ = kinematics(x, v)
        return np.concatenate((place[:4].ravel(), speed[:4].ravel()))

    return start, rates, points


def error(_size: int, state: Array, reference: Array) -> float:
    """Returns the distance of P3, the end of rod 3, from its reference [m]."""
    return float(np.linalg.norm((state - reference)[6:9]))


def violation(_size: int, state: Array) -> float:
    """Returns the largest error of a rod's length [m]."""
    rods = np.diff(np.vstack((np.zeros(3), state[:12].reshape(4, 3), END)), axis=0)
    return float(abs(np.linalg.norm(rods, axis=1) - 1.0).max())


PROBLEM = Problem(
    name="bricard",
    title="Bricard's mechanism, 10 s",
    t_end=T_END,
    sizes=(1,),
    tolerances=LADDER,
    atol=lambda rtol: rtol,
    targets=lambda _size: (1e-3, 1e-6, 1e-9),
    reference=reference,
    error=error,
    violation=violation,
)
