"""The paper's swing of N beam elements up to 0.6 s, before the event that magnifies what is left.

The reference is of another code: MBDyn with 4 three-node elements, whose markers are good to 1e-5 m.
"""

import csv

import numpy as np

from taut.benchmark.entrant import Array, Problem
from taut.bootstrap import ROOT

T_END = 0.6
CURVES = ROOT / "cases" / "swing" / "data" / "mbdyn_4x3node.csv"
MARKERS = "ABCDE"
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
