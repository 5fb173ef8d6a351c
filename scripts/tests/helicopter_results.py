"""Made-up results of the helicopter blade in the programs' format: an exact motion, and errors on it."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from taut.report.helicopter.measures import point_a, point_b

COLUMNS = (
    "t,h,beta,theta,beta_rate,theta_rate,phi,phidot,phiddot,phi_raw,phidot_raw,energy,mu,lambda,rank"
    ",link_force"
)
SUMMARY = (
    "case,method,status,t_end,steps,rejected,rhs_evaluations,projection_iterations,max_phi,max_phidot,max_phiddot,"
    "energy_drift,min_rank,note,wall_seconds"
)
MODEL = {
    "omega": 40.0,
    "radius": 5.0,
    "i_b": 416.67,
    "i_f": 9.375e-2,
    "i_x": 1.875e-2,
    "gamma": 8.0,
    "x_beta": 0.2,
    "x_theta": 0.05,
    "y_theta": 0.2,
    "x_b": 0.25,
    "y_b": 0.2,
    "z_b": -0.15,
    "length": 0.15,
    "nu_beta": 1.0625**0.5,
    "nu_beta_squared": 1.0625,
    "k_p": 0.25,
    "k_c": 16537.5,
    "control_frequency": 10.5,
} | {f"b_{part}_{axis}": 0.0 for part in ("cosine", "sine") for axis in "xyz"}
FLAP = 0.0298


@dataclass(frozen=True)
class Blade:
    """What a run is to show: its steps, an oscillation and a drift of the pitch about the exact motion."""

    steps: int = 200
    rejected: int = 0
    # Amplitude [rad] and frequency per revolution of an oscillation that grows, and pitch at the end [rad].
    amplitude: float = 0.0
    frequency: float = 10.55
    drift: float = 0.0
    harmonic: int = 3
    mu: float = 5e-8
    status: str = "reached-end"


PRESENT, BASELINE = Blade(), Blade(drift=5e-10)
PENALTY = Blade(518, 176, 7e-3)
TIGHT = Blade(1313, 223, 5e-5)
CASES: dict[str, dict[str, Blade]] = {
    "figure10": {"baseline": BASELINE, "present": PRESENT, "penalty": PENALTY},
    "figure10_odepkg": {"baseline": BASELINE, "present": PRESENT},
    "figure10_tight": {"baseline": Blade(374, 8), "present": Blade(374, 8), "penalty": TIGHT},
    "runaway_odepkg": {"penalty": Blade(462, 111, 2.0)},
    "soft_control": {"present": PRESENT, "penalty": Blade(263, 66, 3e-3, 5.6)},
    "soft_control_tight": {
        "present": Blade(374, 8),
        "penalty": replace(TIGHT, amplitude=2e-4, frequency=5.6),
    },
    "stiff_control": {"present": PRESENT, "penalty": Blade(5481, 542, 1.5, 21.0)},
    "stiff_control_tight": {"present": Blade(374, 8), "penalty": Blade(7808, 1941, 1e-7, 21.0)},
    "rigid_control": {"present": Blade(614, 22), "penalty": Blade(620, 24, 5e-7)},
    "cyclic": {"baseline": BASELINE, "present": PRESENT, "penalty": PENALTY},
}
# The stiffness per revolution of the cases that change it.
CONTROL = {"soft": 5.5, "stiff": 105.0, "rigid": 1050.0}


def write_helicopter(root: Path, **changed: dict[str, Blade]) -> Path:
    """Writes the results of every case; a keyword replaces runs of a case."""
    for case, methods in CASES.items():
        write_blade(root, case, methods | changed.get(case, {}))
    return root


def write_blade(root: Path, case: str, methods: dict[str, Blade]) -> None:
    """Writes the CSV files of a case."""
    folder = root / case
    folder.mkdir(parents=True, exist_ok=True)
    control = CONTROL.get(case.split("_")[0], 10.5)
    model = MODEL | {"control_frequency": control, "k_c": MODEL["i_f"] * (control * MODEL["omega"]) ** 2}
    if case == "cyclic":
        model |= {"b_sine_z": 0.02}
    rows = [f"{name},{value!r},1" for name, value in model.items()]
    (folder / "model.csv").write_text("\n".join(["name,value,unit", *rows]) + "\n", encoding="utf-8")
    lines = [SUMMARY]
    for method, made in methods.items():
        rows = history(made)
        np.savetxt(folder / f"{method}.csv", rows, delimiter=",", header=COLUMNS, comments="")
        phi, phidot = np.abs(rows[:, 6]).max(), np.abs(rows[:, 7]).max()
        ended = f"{made.status},2.0,{made.steps},{made.rejected},0,0,{phi},{phidot},1e-15,0.0,1,,0.01"
        lines.append(f"{case},{method},{ended}")
    (folder / "summary.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")


def pitch(beta: np.ndarray) -> np.ndarray:
    """Returns the pitch that the link asks for, by Newton with the arm at rest."""
    theta = -MODEL["k_p"] * beta
    for _ in range(30):
        link = point_a(MODEL, beta, theta) - point_b(MODEL, 0 * beta)
        theta = theta - (np.linalg.norm(link, axis=-1) - MODEL["length"]) / MODEL["y_theta"]
    return theta


def history(made: Blade) -> np.ndarray:
    """Returns the rows of a run over 2 s, not more than are needed."""
    t = np.linspace(0.0, 2.0, min(made.steps, 1400) + 1)
    omega = MODEL["omega"]
    beta, p = FLAP * np.sin(omega * t), FLAP * omega * np.cos(omega * t)
    exact = pitch(beta)
    d = 1e-5
    exact_rate = (pitch(beta + d) - pitch(beta - d)) / (2 * d) * p
    grown, fast = made.amplitude * t / 2.0, made.frequency * omega
    error = grown * np.sin(fast * t) + made.drift * t / 2.0
    error_rate = grown * fast * np.cos(fast * t)
    theta, q = exact + error, exact_rate + error_rate
    force = 3.4e-3 * np.sin(made.harmonic * omega * t) + 3.5 * np.exp(-20 * t)
    force = force + MODEL["k_c"] * (error - made.drift * t / 2.0) / MODEL["y_theta"]
    phi, phidot = MODEL["y_theta"] * np.abs(error), MODEL["y_theta"] * np.abs(error_rate + made.drift)
    h, one = np.concatenate([[0.0], np.diff(t)]), np.ones_like(t)
    mu = made.mu * np.sin(3 * omega * t)
    return np.column_stack(
        [t, h, beta, theta, p, q, phi, phidot, 0 * t, phi, phidot, 0 * t, mu, force, one, force]
    )
