"""The paper's swing of N beam elements up to 0.6 s, before the event that magnifies what is left.

The reference is of another code: MBDyn with 4 three-node elements, whose markers are good to 1e-5 m.
"""

import csv

import numpy as np

from taut.benchmark.entrant import Array, Problem
from taut.benchmark.problems.projected import Equations, System, stabilized
from taut.bootstrap import ROOT

T_END = 0.6
CURVES = ROOT / "cases" / "swing" / "data" / "mbdyn_4x3node.csv"
MARKERS = "ABCDE"
# The beam: length, sides of the section, material, mass in the middle; the force on it, when it is largest.
BEAM, THICKNESS, WIDTH = 0.72, 1e-3, 5e-3
YOUNG, POISSON, DENSITY = 73e9, 0.3, 2700.0
MID_MASS, FORCE, RISE = 0.5, 2.0, 0.128
# Supports and lengths of the links [m].
LINKS = (((0.0, 0.36), 0.36), ((1.08, 0.36), 0.36 * 2**0.5))


def reference(_size: int) -> Array:
    """Returns x and y of the markers A to E at 0.6 s."""
    with CURVES.open(newline="") as file:
        row = next(row for row in csv.DictReader(file) if abs(float(row["t"]) - T_END) < 1e-9)
    return np.array([float(row[f"{m}{axis}"]) for m in MARKERS for axis in "xy"])


def error(_size: int, state: Array, reference: Array) -> float:
    """Returns the distance of the farthest marker from its reference [m]."""
    return float(np.hypot(*(state - reference).reshape(-1, 2).T).max())


def violation(_size: int, state: Array) -> float:
    """Returns the largest error of a link's length [m]."""
    ends = (state[:2], state[-2:])
    return max(abs(float(np.hypot(*(e - c))) - length) for e, (c, length) in zip(ends, LINKS, strict=True))


def system(size: int) -> System:
    """Returns start, rates and projection in the plane: x, y and angle of each node, elements as taut's."""
    nodes, length = size + 1, BEAM / size
    area, second = THICKNESS * WIDTH, WIDTH * THICKNESS**3 / 12
    shear = 5 / 6 * YOUNG / (2 * (1 + POISSON)) * area
    stiffness = np.array([YOUNG * area, 1 / (1 / shear + length**2 / (12 * YOUNG * second))])
    share = np.full(nodes, DENSITY * area * length)
    share[[0, -1]] /= 2
    masses = np.column_stack((share, share, share * (second / area + length**2 / 12)))
    masses[size // 2, :2] += MID_MASS
    supports, lengths = np.array([one for one, _ in LINKS]), np.array([one for _, one in LINKS])
    ends = [0, -1]

    def force(t: float, place: Array) -> Array:
        along, middle = np.diff(place[:, :2], axis=0), (place[1:, 2] + place[:-1, 2]) / 2
        c, s = np.cos(middle), np.sin(middle)
        axial = stiffness[0] * ((c * along[:, 0] + s * along[:, 1]) / length - 1)
        across = stiffness[1] * (c * along[:, 1] - s * along[:, 0]) / length
        cut = np.column_stack((c * axial - s * across, s * axial + c * across))
        moment = YOUNG * second * np.diff(place[:, 2]) / length
        half = (along[:, 0] * cut[:, 1] - along[:, 1] * cut[:, 0]) / 2
        total = np.zeros((nodes, 3))
        total[:-1, :2] += cut
        total[1:, :2] -= cut
        total[:-1, 2] += half + moment
        total[1:, 2] += half - moment
        total[size // 2, 0] += FORCE * max(0.0, 1 - abs(t / RISE - 1))
        return total.ravel()

    def equations(t: float, place: Array, speed: Array) -> Equations:
        place, speed = place.reshape(nodes, 3), speed.reshape(nodes, 3)
        arm = place[ends, :2] - supports
        far = np.hypot(*arm.T)
        unit = arm / far[:, None]
        jacobian = np.zeros((2, nodes, 3))
        jacobian[[0, 1], ends, :2] = unit
        turning = unit[:, 0] * speed[ends, 1] - unit[:, 1] * speed[ends, 0]
        return Equations(
            mass=np.diag(masses.ravel()),
            force=force(t, place),
            phi=far - lengths,
            jacobian=jacobian.reshape(2, 3 * nodes),
            velocity_rhs=np.zeros(2),
            acceleration_rhs=-(turning**2) / far,
        )

    start = np.zeros((2, nodes, 3))
    start[0, :, 0] = np.linspace(0.0, BEAM, nodes)
    start, rates, project = stabilized(start.ravel(), equations, T_END)

    def markers(y: Array) -> Array:
        return project(y)[: 3 * nodes].reshape(nodes, 3)[:: size // 4, :2].ravel()

    return start, rates, markers


PROBLEM = Problem(
    name="swing",
    title="Swing of N beam elements, 0.6 s",
    t_end=T_END,
    sizes=(16,),
    tolerances=(1e-3, 1e-4, 1e-5, 1e-6),
    atol=lambda rtol: 1e-3 * rtol,
    targets=lambda _size: (1e-4,),
    reference=reference,
    error=error,
    violation=violation,
    unit="elements",
    stiff=True,
)
