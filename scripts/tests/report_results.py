"""Made-up results in the programs' format: an exact pendulum with the errors that a test asks for."""

import math
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from helicopter_results import write_helicopter

from taut.report.pendulum.measures import GRAVITY, MAX_TENSION

COLUMNS = "t,h,x,z,vx,vz,phi,phidot,phiddot,phi_raw,phidot_raw,energy,mu,lambda,rank"
SUMMARY = (
    "case,method,status,t_end,steps,rejected,rhs_evaluations,projection_iterations,max_phi,max_phidot,max_phiddot,"
    "energy_drift,min_rank,note,wall_seconds"
)


@dataclass(frozen=True)
class Made:
    """What a run is to show: its steps, its energy at the end and its violations."""

    steps: int
    energy: float
    phi: float = 1e-5
    phidot: float = 1e-4
    status: str = "reached-end"


FOUR = {
    "figure1": {
        "baseline": Made(206, -0.027),
        "present": Made(185, -1.6e-3, 0.0, 0.0),
        "baumgarte": Made(214, -1.1e-3),
        "braun-goldfarb": Made(244, 0.033, 2e-5),
    },
    "figure2": {
        "baseline": Made(785, -0.044),
        "present": Made(790, -7e-8, 9e-13, 0.0),
        "baumgarte": Made(808, -2.1e-3),
        "braun-goldfarb": Made(1184, 3e-8),
    },
    "figure1_standard": {
        "baseline": Made(102, -0.14),
        "present": Made(102, 6.8e-3, 0.0, 0.0),
        "baumgarte": Made(104, -0.018),
        "braun-goldfarb": Made(115, 0.07),
    },
    "figure2_standard": {
        "baseline": Made(733, 4e-8),
        "present": Made(626, -1e-7, 0.0, 0.0),
        "baumgarte": Made(743, -2e-7),
        "braun-goldfarb": Made(1092, 4e-8),
    },
}
OPTIONS = (
    "state-none",
    "state-position",
    "state-position-velocity",
    "weight-mass",
    "form-force",
    "stage-none",
    "solver-dgelsd",
    "solver-factor",
    "yu-chen",
    "coordinate-projection",
)
ALL = FOUR | {
    "figure3": {
        m: Made(201, 1e-3) for m in ("baseline", "baumgarte", "braun-goldfarb", "present-position", "present")
    },
    "options1": {m: Made(185, -0.069) for m in OPTIONS} | {"braun-goldfarb-0.05": Made(420, 4e-5)},
    "options2": {m: Made(790, -7e-8) for m in OPTIONS} | {"braun-goldfarb-0.05": Made(1820, 2e-8)},
    "penalty": {
        "present": Made(102, 7e-3, 0.0, 0.0),
        "penalty-1e4": Made(588, -0.04, 3e-3),
        "penalty-1e6": Made(4428, -4e-5, 9e-5),
    },
}


def write_all(root: Path, **changed: dict[str, Made]) -> Path:
    """Writes the results of every case; a keyword replaces runs of a case, as in figure1={'present': ...}."""
    write_helicopter(root)
    for case, methods in ALL.items():
        write_case(root, case, methods | changed.get(case, {}))
    return root


def write_case(root: Path, case: str, methods: dict[str, Made]) -> None:
    """Writes the CSV files of a case."""
    folder = root / case
    folder.mkdir(parents=True, exist_ok=True)
    lines = [SUMMARY]
    for method, made in methods.items():
        np.savetxt(folder / f"{method}.csv", history(made), delimiter=",", header=COLUMNS, comments="")
        errors = f"{made.phi},{made.phidot},1e-15"
        errors = f"{made.phi},{made.phidot},1e-15"
        lines.append(f"{case},{method},{made.status},10.0,{made.steps},0,0,0,{errors},{made.energy},1,,0.01")
    (folder / "summary.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")


def history(made: Made) -> np.ndarray:
    """Returns the rows of a run over 10 s."""
    t, angle, rate = swing(made.steps)
    x, z = np.cos(angle), -np.sin(angle)
    vx, vz = -np.sin(angle) * rate, -np.cos(angle) * rate
    one = np.ones_like(t)
    h = np.concatenate([[0.0], np.diff(t)])
    columns = (t, h, x, z, vx, vz, made.phi * one, made.phidot * one, 1e-15 * one, 1e-8 * one, 1e-8 * one)
    return np.column_stack([*columns, made.energy * t / 10.0, 0 * one, -MAX_TENSION * z, one])


@cache
def swing(steps: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Returns times, the angle below the horizontal and its rate: classical Runge-Kutta, fine steps."""
    h = 10.0 / steps
    pieces = max(math.ceil(h / 5e-3), 1)
    d = h / pieces
    angle = rate = 0.0
    rows = [(angle, rate)]
    for _ in range(steps):
        for _ in range(pieces):
            a1, r1 = rate, GRAVITY * math.cos(angle)
            a2, r2 = rate + d / 2 * r1, GRAVITY * math.cos(angle + d / 2 * a1)
            a3, r3 = rate + d / 2 * r2, GRAVITY * math.cos(angle + d / 2 * a2)
            a4, r4 = rate + d * r3, GRAVITY * math.cos(angle + d * a3)
            angle += d / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
            rate += d / 6 * (r1 + 2 * r2 + 2 * r3 + r4)
        rows.append((angle, rate))
    return h * np.arange(steps + 1), *np.array(rows).T
