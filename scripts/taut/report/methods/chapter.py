"""The chapter 'The methods side by side': one table to print, then the numbers of each problem."""

import math

from taut.formats import count, number
from taut.report.document import Chapter, Figure, Paragraph, Section, Table
from taut.report.methods.figures import FIGURES
from taut.report.methods.measures import (
    CASES,
    CITED,
    KEPT,
    LOOP,
    METHODS,
    PENDULUM,
    PENDULUMS,
    PROBLEMS,
    SINGULAR,
    TOLERANCES,
    Method,
    Problem,
    ended,
    error,
    pendulum_error,
    tension_error,
    work,
)
from taut.results import Case, Results

__all__ = ["CASES", "build"]

# A motion this far from the exact one is another motion [m]; a multiplier this far off, relative, is wrong.
SAME_MOTION = 1e-2
RIGHT = 1e-3
YES, NO = "yes", "no"
CAPTIONS = {
    "methods_motion": "Four tolerances, from left to right. What falls steeply is limited by the integration "
    "alone; what lies flat is limited by a parameter of the method: a stiffness, a penalty.",
    "methods_energy": "The same runs: what is done against a violation is seen in the energy.",
}


def build(results: Results) -> Chapter:
    """Returns the chapter."""
    figures = tuple(
        Figure(spec.title, spec.path(results), CAPTIONS[spec.name])
        for spec in FIGURES
        if spec.can_draw(results)
    )
    sections = (
        Section("What each method keeps", (Paragraph(READING), overview(results), cited())),
        Section("Order on the pendulum", (orders(results),)),
        *(Section(problem.title, (numbers(results, problem),)) for problem in PROBLEMS),
    )
    return Chapter("The methods side by side", "Sect. 1 and its references", (), sections, figures)


READING = (
    "Every entry is computed from the runs. A level is kept if its largest violation on the pendulum at "
    "tolerances of 10⁻⁵ is at most 10⁻¹⁰. Redundancy and the singular position are survived if the run of "
    "the redundant loop and that of the two four-bars reach their end, and stay within a centimeter of the "
    "exact motion. Multipliers are right if the pendulum’s tension is within a thousandth of its largest "
    "value. All runs use `dopri5`, but for those that are an integrator of their own, of order 2: "
    "generalized-α and energy-preserving. W = M for mechanisms, else W = I. Half-explicit multipliers are "
    "forces over a stage: over a first step of microseconds they are far off, and φ̈ with them."
)


def overview(results: Results) -> Table:
    """Returns the table a lecturer would print."""
    return Table(
        "The methods at a glance.",
        ("Method", "Source", "What it does", "φ", "φ̇", "φ̈", "Redundant", "Singular", "Multipliers"),
        tuple(glance(results, method) for method in METHODS),
        text_columns=9,
    )


def cited() -> Table:
    """Returns what the paper cites, and what stands for it."""
    names = {method.label: method.name for method in METHODS}
    return Table(
        "Every method that the paper cites as one that enforces constraints.",
        ("The paper cites", "Where", "Here"),
        tuple((what, where, "; ".join(names[label] for label in labels)) for what, where, labels in CITED),
        text_columns=3,
    )


def glance(results: Results, method: Method) -> tuple[str, ...]:
    """Returns the row of a method."""
    case = results.case(PENDULUM)
    kept = tuple(
        "kept" if case.number(method.label, f"max_{level}") <= KEPT else "drifts"
        for level in ("phi", "phidot", "phiddot")
    )
    survived = tuple(
        YES if error(results, problem, method.label) <= SAME_MOTION else NO for problem in (LOOP, SINGULAR)
    )
    right = YES if tension_error(case.run(method.label)) <= RIGHT else NO
    return (method.name, method.source, method.idea, *kept, *survived, right)


def orders(results: Results) -> Table:
    """Returns steps and error of the pendulum at each tolerance."""
    rows = []
    for method in METHODS:
        cells = []
        for name in PENDULUMS:
            case = results.case(name)
            cells += [
                count(work(case, method.label)),
                number(pendulum_error(case.run(method.label)))
                if ended(case, method.label)
                else "ended early",
            ]
        rows.append((method.name, *cells))
    header = tuple(
        text for digits in TOLERANCES for text in (f"evaluations, 1e-{digits}", f"error, 1e-{digits} [m]")
    )
    return Table(
        "Pendulum: evaluations of the right-hand side and largest distance from the exact motion in 10 s.",
        ("Method", *header),
        tuple(rows),
    )


def early(case: Case, method: str) -> str:
    """Returns how and when a run ended before its time."""
    return f"{case.text(method, 'status')} at {number(case.number(method, 't_end'), unit='s')}"


def numbers(results: Results, problem: Problem) -> Table:
    """Returns what each method gives on a problem."""
    case = results.case(problem.case)
    rows = []
    for method in METHODS:
        off = error(results, problem, method.label)
        rows.append(
            (
                method.name,
                count(case.steps(method.label)),
                count(work(case, method.label)),
                *(
                    number(case.number(method.label, f"max_{level}"))
                    for level in ("phi", "phidot", "phiddot")
                ),
                number(case.number(method.label, "energy_drift"), plus=True),
                number(off) if math.isfinite(off) else early(case, method.label),
            )
        )
    return Table(
        f"{problem.title}: largest violations, change of the energy, largest error of the motion.",
        (
            "Method",
            "steps",
            "evaluations",
            "max |φ|",
            "max |φ̇|",
            "max |φ̈|",
            "ΔE [J]",
            f"error [{problem.unit}]",
        ),
        tuple(rows),
    )
