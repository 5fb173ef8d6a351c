"""Made-up results of the swing in the programs' format: the reference motion, and errors on it."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from taut.report.swing.measures import BEAM, MARKERS, reference

COLUMNS = "t,h,x,vx,phi,phidot,phiddot,phi_raw,phidot_raw,energy,mu1,mu2,lambda1,lambda2,rank," + ",".join(
    [f"{m}{axis}" for m in MARKERS for axis in "xyz"] + ["q1", "q2", "q3", "q4"]
)
SUMMARY = (
    "case,method,status,t_end,steps,rejected,rhs_evaluations,projection_iterations,jacobians,"
    "factorizations,newton_iterations,max_phi,max_phidot,max_phiddot,energy_drift,min_rank,note,"
    "link1_min,link1_min_t,link1_max,link1_max_t,wall_seconds"
)
FREQUENCIES = (
    ("0.443067", "bending", "symmetric"),
    ("18.17406", "bending", "antisymmetric"),
    ("28.45715", "bending", "symmetric"),
    ("72.47", "bending", "antisymmetric"),
    ("319.4767", "axial", "antisymmetric"),
)
EVENTS = {"link-AC": 0.6399, "link-AE": 0.6475}


@dataclass(frozen=True)
class Swung:
    """What a run is to show."""

    steps: int
    t_end: float = 1.0
    # How far all markers are from the reference, and from 0.64 s on in addition [m].
    off: float = 1e-4
    after: float = 0.0
    # The violation, and what it is before the state is replaced [m].
    phi: float = 9e-13
    raw: float = 2e-7
    h: float = 5e-5
    h_after: float = 0.0
    peak: float = 150.0
    energy: float = 0.064
    # The violation's rate from 0.65 s on, in multiples of what it is before.
    jump: float = 100.0
    status: str = "reached-end"
    # The axial amplitude when it peaks behind the event, and what stays of it.
    axial: float = 1e-4
    ringing: float = 0.0
    # Which of the reference curves it is on, and its Jacobians.
    curve: int = 4
    jacobians: int = 0


BASELINE = {
    "1a": Swung(69000, 0.69, 2.8e-4, phi=1e-14, raw=1e-14, h=1e-5),
    "1a_uncapped": Swung(31730, 0.69, phi=1e-2, h=2.1e-5),
    "2a": Swung(18341, off=1.5e-3, phi=6e-3, after=0.07),
    "3a": Swung(1003, off=1.5e-3, phi=4e-4, h=1e-3, after=0.3),
}
PRESENT = {
    "1b": Swung(69000, 0.69, 2.8e-4, phi=1e-14, raw=1e-14, h=1e-5),
    "1b_uncapped": Swung(31667, 0.69, h=2.1e-5),
    "1b_uncapped_long": Swung(200178, h_after=2e-8, energy=1.2e9),
    "1b_long": Swung(56522, 1.0, h=1.7e-5),
    "2b": Swung(18728, off=1.5e-3),
    "2b_tight": Swung(175918, off=1.5e-3),
    "3b": Swung(1003, off=1.5e-3, h=1e-3, after=0.3),
    "0_4x": Swung(3101, jacobians=300),
    "0_8x": Swung(6103, off=1e-5, curve=2, jacobians=300),
    "0_16x": Swung(9556, off=1e-5, jacobians=300),
    "0_32x": Swung(10211, off=1e-5, jacobians=300),
    "mesh4": Swung(56518, off=2.8e-4),
    "mesh8": Swung(113912, off=7.0e-5),
    "mesh16": Swung(244699, off=1.9e-5),
    "mesh32": Swung(493881, off=4.8e-6),
    "mesh64": Swung(987000, off=1.2e-6),
    "mesh16_event": Swung(160000, 0.66, 1.9e-5),
}
for _n, _off in ((4, 2.8e-4), (8, 7e-5), (16, 1.9e-5), (32, 4.8e-6), (64, 1.2e-6)):
    PRESENT[f"mesh{_n}_implicit"] = Swung(1000, off=_off, jacobians=30)
    PRESENT[f"mesh{_n}_implicit_loose"] = Swung(260, off=1.1 * _off, jacobians=40)
CASES = (*BASELINE, *PRESENT, "table1", "free_free")


def write_swing(root: Path, without: tuple[str, ...] = (), **changed: Swung) -> Path:
    """Writes the results of every case but some; a keyword such as run_1b replaces the run of a case."""
    for method, cases in (("baseline", BASELINE), ("present", PRESENT)):
        for case, made in cases.items():
            if case not in without:
                write_run(root, case, method, changed.get(f"run_{case}", made))
    if "table1" not in without:
        write_modes(root)
    if "free_free" not in without:
        write_frequencies(root / "free_free", (*FREQUENCIES, ("8496.95", "axial", "antisymmetric")))
    return root


def write_run(root: Path, case: str, method: str, made: Swung) -> None:
    """Writes the CSV files of a case of one method."""
    folder = root / case
    folder.mkdir(parents=True, exist_ok=True)
    rows = history(made)
    np.savetxt(folder / f"{method}.csv", rows, delimiter=",", header=COLUMNS, comments="")
    errors = f"{made.phi},{made.phi},1e-15"
    line = f"{case},{method},{made.status},{rows[-1, 0]},{made.steps},12,{6 * made.steps},{5 * made.steps}"
    line += f",{made.jacobians},{2 * made.jacobians},{9 * made.jacobians}"
    (folder / "summary.csv").write_text(
        f"{SUMMARY}\n{line},{errors},0.064,2,,-50,0.641,{made.peak},0.64,0.1\n", encoding="utf-8"
    )
    lines = [f"{method},{name},{t}" for name, t in EVENTS.items() if made.t_end > t]
    # A second alignment comes later and does not count.
    lines += [f"{method},link-AC,{0.95 * made.t_end}"] * bool(lines)
    (folder / "events.csv").write_text("\n".join(["method,event,t", *lines]) + "\n", encoding="utf-8")


def history(made: Swung) -> np.ndarray:
    """Returns the rows of a run, every 1e-3 s."""
    run = reference(made.curve)
    t = run["t"][run["t"] <= made.t_end + 1e-9]
    late = t > 0.64
    off = made.off * np.minimum(t / 0.3, 1.0) + made.after * np.where(late, (t - 0.64) / 0.36, 0.0)
    one, none = np.ones_like(t), np.zeros_like(t)
    h = np.where(t > 0.65, made.h_after or made.h, made.h)
    force = 0.2 + made.peak * np.exp(-(((t - 0.64) / 3e-3) ** 2))
    columns = [
        t,
        h,
        none,
        none,
        made.phi * one,
        made.phi * np.where(t > 0.65, made.jump, 1.0),
        none,
        made.raw * one,
        made.raw * one,
    ]
    columns += [made.energy * np.minimum(t / 0.256, 1.0) ** 2, none, none, force, none, 2 * one]
    for m in MARKERS:
        columns += [run[f"{m}x"][: len(t)], run[f"{m}y"][: len(t)] + off, none]
    axial = made.axial * np.exp(-(((t - 0.65) / 5e-3) ** 2)) + np.where(t > 0.65, made.ringing, 0.0)
    return np.column_stack([*columns, 0.01 * one, none, none, axial])


def write_frequencies(folder: Path, rows: tuple[tuple[str, str, str], ...]) -> None:
    """Writes the frequencies of a beam."""
    folder.mkdir(parents=True, exist_ok=True)
    lines = [f"{i},{','.join(row)}" for i, row in enumerate(rows, start=1)]
    (folder / "frequencies.csv").write_text(
        "\n".join(["mode,frequency,motion,symmetry", *lines]) + "\n", encoding="utf-8"
    )


def write_modes(root: Path, triangle: float = 1.0) -> None:
    """Writes the modes of a beam: the cubic, sines and, to this power, the triangle."""
    write_frequencies(root / "table1", FREQUENCIES)
    x = np.linspace(0.0, BEAM, 41)
    s = np.minimum(x, BEAM - x) / BEAM
    angle = 2 * np.pi * x / BEAM
    # Scaled as the program does, and with any sign.
    bending = (-(3 * s - 4 * s**3), np.sin(angle), 1 - np.cos(angle), np.sin(2 * angle), 0 * x)
    lines = ["mode,node,x,u_x,u_y,u_z,r_x,r_y,r_z"]
    for i, u_y in enumerate(bending, start=1):
        u_x = (2 * s) ** triangle if i == 5 else 0 * x
        for j in range(len(x)):
            lines.append(f"{i},{j + 1},{x[j]},{u_x[j]},{u_y[j]},0,0,0,0")
    (root / "table1" / "shapes.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")


def wider(case: str, **changed: object) -> Swung:
    """Returns the run of a case with something changed."""
    return replace((BASELINE | PRESENT)[case], **changed)
