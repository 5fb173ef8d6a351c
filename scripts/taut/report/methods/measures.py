"""What is measured on the runs of each method: violations, energy, error, work."""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from taut.report.formulation.measures import circle_error, slider_error
from taut.report.pendulum.measures import GRAVITY, LENGTH, MAX_TENSION, PERIOD
from taut.results import REACHED_END, Array, Case, Results, Run

# Violations and differences up to this are round-off.
KEPT = 1e-10


@dataclass(frozen=True)
class Method:
    """A method as the cases label it, its name in tables and what it is."""

    label: str
    name: str
    idea: str
    source: str


METHODS = (
    Method("baseline", "baseline", "multipliers eliminated", "Eq. (8)"),
    Method("udwadia-kalaba", "Udwadia–Kalaba", "M^-1/2 and a pseudo-inverse", "[18]"),
    Method("baumgarte", "Baumgarte", "violations decay", "[21]"),
    Method("braun-goldfarb", "Braun–Goldfarb", "violations decay, two projections", "[30]"),
    Method("bayo-penalty", "Bayo, penalty", "α on a violation’s oscillator", "[24]"),
    Method("augmented-lagrangian", "augmented Lagrangian", "the same, iterated", "[24]"),
    Method("penalty", "spring and damper", "forces instead of constraints", ""),
    Method("yu-chen", "Yu–Chen", "corrected above 10⁻⁶", "[33]"),
    Method("coordinate-projection", "coordinate projection", "projected after a step", "[15]"),
    Method("gear-gupta-leimkuhler", "Gear–Gupta–Leimkuhler", "half-explicit, index 2", "[22]"),
    Method("fuhrer-leimkuhler", "Führer–Leimkuhler", "three multipliers", "[23]"),
    Method("embedded-projection", "embedded projection", "the reactions’ impulse solved for", "[29]"),
    Method("dummy-derivatives", "dummy derivatives", "dependent variables solved for", "[25]"),
    Method("minimal-coordinates", "minimal, null space", "independent velocities", "Eq. (3)"),
    Method("minimal-partitioning", "minimal, partitioning", "single velocities", "Eq. (3)"),
    Method("minimal-drifting", "minimal, not projected", "positions integrated", "Eq. (3)"),
    Method("generalized-alpha-3", "generalized-α, index 3", "φ = 0 alone, implicit", "Eqs (1)"),
    Method("generalized-alpha", "generalized-α, index 2", "φ = 0 and φ̇ = 0, implicit", "[22]"),
    Method("energy-preserving", "energy-preserving", "reactions that do no work", "[28]"),
    Method("present", "present", "projected stages", "Sect. 3.5"),
)
# What the paper cites as a way to enforce constraints, where it does, and the methods that stand for it here.
CITED = (
    ("Lagrange’s equations of the first kind", "Sect. 1, Eqs (1)", ("generalized-alpha-3",)),
    (
        "Minimal coordinates: Lagrange’s equations of the second kind, Maggi, Kane, Jourdain [9, 10, 13, 14]",
        "Sect. 1, Eq. (3)",
        ("minimal-coordinates", "minimal-partitioning", "minimal-drifting"),
    ),
    ("Gauss’ principle and its kin [5–8, 17, 20]", "Sects 1, 2, Eqs (7)–(9)", ("baseline",)),
    ("Udwadia, Kalaba [18]; redundant constraints [19]", "Sect. 2", ("udwadia-kalaba",)),
    ("Eich [15]", "Sects 1, 3.3", ("coordinate-projection",)),
    ("Lubich, Engstler, Nowak, Pöhle [16]: half-explicit", "Sect. 1", ("gear-gupta-leimkuhler",)),
    ("Baumgarte [21]", "Sect. 2", ("baumgarte",)),
    (
        "Gear, Gupta, Leimkuhler [22]; Hairer, Wanner [31] with W = M",
        "Sects 2, 3.1",
        ("gear-gupta-leimkuhler", "generalized-alpha"),
    ),
    ("Führer, Leimkuhler [23]", "Sect. 2", ("fuhrer-leimkuhler",)),
    ("Bayo, García de Jalón, Serna [24]", "Sect. 2", ("bayo-penalty", "augmented-lagrangian")),
    ("Mattsson, Söderlind [25]; Pantelides [26]; Modelica [27]", "Sect. 2", ("dummy-derivatives",)),
    ("Bauchau [28]: derived from what the paper says", "Sect. 2", ("energy-preserving",)),
    (
        "Borri, Trainelli, Croce [29]: derived from what the paper says",
        "Sects 2, 3.1",
        ("embedded-projection",),
    ),
    ("Braun, Goldfarb [30]", "Sects 2, 3.1, 4.1", ("braun-goldfarb",)),
    ("Yu, Chen [33]", "Sect. 3.3", ("yu-chen",)),
    ("Penalty", "Sect. 4.3", ("penalty",)),
    ("The proposed approach", "Sect. 3", ("present",)),
)


@dataclass(frozen=True)
class Problem:
    """A problem on which the methods are set side by side."""

    case: str
    title: str
    # Columns that are compared with a run a million times as exact, and their unit.
    columns: tuple[str, ...] = ()
    unit: str = "m"

    @property
    def cases(self) -> tuple[str, ...]:
        """The cases that it needs."""
        return (self.case, f"{self.case}_exact") if self.columns else (self.case,)


PENDULUM = "side_pendulum_5"
TOLERANCES = (3, 5, 7, 9)
PENDULUMS = tuple(f"side_pendulum_{digits}" for digits in TOLERANCES)
LOOP = Problem("side_loop", "Redundant loop (Bricard), 5 s", ("P3.x", "P3.y", "P3.z"))
SINGULAR = Problem("side_singular", "Two four-bars through their singular position, 5 s", ("B0.x", "B0.y"))
PROBLEMS = (
    Problem(PENDULUM, "Pendulum, 10 s"),
    LOOP,
    SINGULAR,
    Problem("side_swing", "Swing to 0.6 s, modal", ("Cx", "Cz")),
    Problem("side_blade", "Helicopter blade, 2 s", ("beta", "theta"), "rad"),
    Problem("side_driven", "Driven slider-crank, 2 s (rheonomic)"),
    Problem("side_rolling", "Rolling disc, 5 s (non-holonomic)"),
)
CASES = (*PENDULUMS, *(case for problem in PROBLEMS[1:] for case in problem.cases))


def ended(case: Case, method: str) -> bool:
    """Returns whether the run of a method came to its end."""
    return case.text(method, "status") == REACHED_END


def pendulum_error(run: Run) -> float:
    """Returns how far the pendulum is from its closed form, at most [m]."""
    angle = np.array([pendulum_angle(t) for t in run["t"]])
    return float(np.max(np.hypot(run["x"] - LENGTH * np.sin(angle), run["z"] + LENGTH * np.cos(angle))))


def pendulum_angle(t: float) -> float:
    """Returns the angle from the downward vertical of a pendulum released from the horizontal at rest [rad].

    sin(angle/2) = k sn(K - sqrt(g/l) t) by descending Landen transformations, k = sin(45 deg).
    """
    k = math.sqrt(0.5)
    a, b, c = [1.0], k, [k]
    while abs(c[-1]) > 1e-16 and len(a) < 12:
        c.append((a[-1] - b) / 2)
        a, b = [*a, (a[-1] + b) / 2], math.sqrt(a[-1] * b)
    quarter = PERIOD / 4 * math.sqrt(GRAVITY / LENGTH)
    phase = 2 ** (len(a) - 1) * a[-1] * (quarter - math.sqrt(GRAVITY / LENGTH) * t)
    for i in range(len(a) - 1, 0, -1):
        phase = (phase + math.asin(c[i] * math.sin(phase) / a[i])) / 2
    return 2 * math.asin(k * math.sin(phase))


def tension_error(run: Run) -> float:
    """Returns the multiplier's largest error, relative to the largest tension."""
    return float(np.max(np.abs(run["lambda"] + MAX_TENSION * run["z"] / LENGTH))) / MAX_TENSION


def error(results: Results, problem: Problem, method: str) -> float:
    """Returns how far a run is from the exact motion, at most; infinite if it ended early."""
    case = results.case(problem.case)
    if not ended(case, method):
        return math.inf
    run = case.run(method)
    if problem.case == "side_driven":
        return slider_error(run)
    if problem.case == "side_rolling":
        return circle_error(run)
    if not problem.columns:
        return pendulum_error(run)
    exact = results.case(f"{problem.case}_exact").run("present")
    return max(float(np.max(np.abs(_at(run, exact["t"], c) - exact[c]))) for c in problem.columns)


def _at(run: Run, times: Array, column: str) -> Array:
    """Returns a column at times that the run has, but for round-off."""
    return run[column][np.clip(np.searchsorted(run["t"], times - 1e-9), 0, run.steps)]


def work(case: Case, method: str) -> int:
    """Returns the evaluations of the right-hand side."""
    return int(case.number(method, "rhs_evaluations"))


def files(results: Results) -> tuple[Path, ...]:
    """Returns the tables that the chapter is made from."""
    return tuple(results.case(case).folder / "summary.csv" for case in CASES)
