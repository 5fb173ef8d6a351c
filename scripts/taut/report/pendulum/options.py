"""The pendulum's variants: parameters, weights, solvers and other methods, each with its table."""

from taut.formats import count, number, percent
from taut.report.document import Paragraph, Table
from taut.report.judgment import LOOSE, TIGHT
from taut.report.pendulum.measures import energy_change
from taut.results import Case, Results

SAME = {
    "weight-mass": "W = M",
    "form-force": "force form, Eqs. (19)",
    "solver-dgelsd": "solver `dgelsd`",
    "solver-factor": "solver `factor`",
}
CITED = {"yu-chen": "Yu–Chen, tolerance 10⁻⁶", "coordinate-projection": "coordinate projection (Eich)"}


def energy(case: Case, method: str) -> str:
    """Returns the energy change of a run as it is printed."""
    return number(energy_change(case.run(method)), plus=True)


def braun_goldfarb(results: Results) -> tuple[Paragraph | Table, ...]:
    """Shows how the unstated dt sets the step count."""
    rows = []
    for name, options in ((LOOSE, "options1"), (TIGHT, "options2")):
        word = "loose" if name == LOOSE else "tight"
        for case, method, dt in (
            (results.case(name), "braun-goldfarb", "0.1"),
            (results.case(options), "braun-goldfarb-0.05", "0.05"),
        ):
            length = number(case.number(method, "max_phi"))
            rows.append((f"{word}, dt = {dt} s", count(case.steps(method)), length, energy(case, method)))
    return (
        Paragraph(
            "The gains are α = β = 1/dt. A right-hand side does not know the step that it is called for, "
            "so dt is a fixed number, and the paper does not give it. ‘Much like Baumgarte’s’ at the loose "
            "tolerance suggests 0.1 s, the cap; ‘nearly twice the time steps’ at the tight one a value "
            "between 0.05 and 0.1 s."
        ),
        Table(
            "Braun–Goldfarb, signed error test.",
            ("tolerance, dt", "steps", "max |φ| [m]", "E [J]"),
            tuple(rows),
        ),
    )


def indifferent(results: Results) -> tuple[Paragraph | Table, ...]:
    """Shows the choices that change nothing here."""
    cases = results.case("options1"), results.case("options2")
    chosen = {"state-position-velocity": "W = I, acceleration form, default solver"} | SAME
    rows = tuple(
        (
            label,
            *(
                text
                for case in cases
                for text in (count(case.steps(m)), number(energy_change(case.run(m)), 6, plus=True))
            ),
        )
        for m, label in chosen.items()
    )
    return (
        Paragraph(
            "The paper prefers W = I; others take W = M. For a point mass M = m I, so the projection is "
            "the same: the choice matters where inertias differ in size or unit, such as masses beside "
            "rotary inertias. The force form and the three solvers for the multipliers state the same "
            "equations and differ by round-off."
        ),
        Table(
            "‘Present’, signed error test.",
            ("choice", "steps, loose", "E [J], loose", "steps, tight", "E [J], tight"),
            rows,
        ),
    )


def penalty(results: Results) -> tuple[Paragraph | Table, ...]:
    """Shows the price of a stiff spring, under the signed test too if that has been run."""
    labels = {
        "present": "present",
        "penalty-1e4": "penalty, 10⁴ N/m, 10 N s/m",
        "penalty-1e6": "penalty, 10⁶ N/m, 100 N s/m",
    }
    tests = {"penalty": "honest", "penalty_odepkg": "signed"}
    rows = []
    for name, test in tests.items():
        if results.has(name):
            case = results.case(name)
            for m in filter(labels.__contains__, case.methods):
                length, speed = (number(case.number(m, key)) for key in ("max_phi", "max_phidot"))
                rows.append((labels[m], test, count(case.steps(m)), length, speed, energy(case, m)))
    case = results.case("penalty")
    ratio = [case.steps(m) / case.steps("present") for m in ("penalty-1e4", "penalty-1e6")]
    left = [case.number(m, "max_phi") for m in ("penalty-1e4", "penalty-1e6")]
    return (
        Paragraph(
            "The classical alternative replaces the constraint by a stiff spring and damper. At the loose "
            f"tolerance with an honest error test it takes {number(ratio[0])} and {number(ratio[1])} times "
            f"the steps of ‘present’ and leaves a length error of {percent(left[0])} and "
            f"{percent(left[1])}. With the signed error test it runs away: the errors of a fast oscillation "
            "have both signs, and those of one sign always pass."
        ),
        Table(
            "Penalty, loose tolerance.",
            ("method", "error test", "steps", "max |φ| [m]", "max |dφ/dt| [m/s]", "E [J]"),
            tuple(rows),
            text_columns=2,
        ),
    )


def cited(results: Results) -> tuple[Paragraph | Table, ...]:
    """Shows the methods that correct the state after the step, outside the right-hand side."""
    rows = []
    for word, name in (("loose", "options1"), ("tight", "options2")):
        case = results.case(name)
        for m, label in CITED.items():
            length, speed = (number(case.number(m, key)) for key in ("max_phi", "max_phidot"))
            rows.append((label, word, count(case.steps(m)), length, speed, energy(case, m)))
    return (
        Paragraph(
            "Yu and Chen correct the state only when the violation exceeds a tolerance; coordinate "
            "projection corrects it after every step. Both integrate Eq. (8) and so work outside the "
            "right-hand side, where the proposed approach works inside it."
        ),
        Table(
            "Corrections after the step, signed error test.",
            ("method", "tolerance", "steps", "max |φ| [m]", "max |dφ/dt| [m/s]", "E [J]"),
            tuple(rows),
            text_columns=2,
        ),
    )
