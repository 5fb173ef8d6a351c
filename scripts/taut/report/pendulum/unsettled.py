"""What the paper leaves open about the pendulum, and what each choice does, from the runs of its variants."""

from taut.formats import count, number
from taut.report.document import Figure, Paragraph, Section, Table
from taut.report.judgment import LOOSE, TIGHT
from taut.report.pendulum.measures import MASS, energy_change
from taut.report.pendulum.options import braun_goldfarb, cited, energy, indifferent, penalty
from taut.results import Results

METHODS = {
    "baseline": "baseline, Eq. (8)",
    "present": "present",
    "baumgarte": "Baumgarte (2, 2)",
    "braun-goldfarb": "Braun–Goldfarb, dt = 0.1 s",
}
VARIANTS = {
    "state-none": "nothing",
    "state-position": "position",
    "state-position-velocity": "position and velocity (default)",
    "stage-none": "position and velocity, but stages not projected",
}


def what_is_open(results: Results, figure: Figure) -> tuple[Section, ...]:
    """Returns the sections, most consequential first; the figure is of what is replaced after a step."""
    return (
        Section("What the paper leaves open", error_test(results)),
        Section("What of the state is replaced after a step", (*replaced(results), figure)),
        Section("The dt of Braun and Goldfarb’s method", braun_goldfarb(results)),
        Section("The weight W, the form of the equations and the solver", indifferent(results)),
        Section("The sign of Eq. (8)", sign(results)),
        Section("Penalty instead of a constraint", penalty(results)),
        Section("Methods the paper cites without a figure", cited(results)),
    )


def error_test(results: Results) -> tuple[Paragraph | Table, ...]:
    """Compares the signed error test of 2009 with an honest one."""
    rows = []
    for word, name in (("loose", LOOSE), ("tight", TIGHT)):
        cases = results.case(name), results.case(f"{name}_standard")
        for method, label in METHODS.items():
            steps = [count(case.steps(method)) for case in cases]
            rows.append((word, label, *steps, *(energy(case, method) for case in cases)))
    loose, tight = (results.case(f"{name}_standard") for name in (LOOSE, TIGHT))
    drift = [results.case(TIGHT).number("baseline", "max_phi"), tight.number("baseline", "max_phi")]
    return (
        Paragraph(
            "The paper’s step counts and energy curves come from `ode45` in Octave’s OdePkg as it was in "
            "2009. Its error test is signed: a component passes when δ ≤ max(rtol · y, atol), δ being the "
            "difference of the 5th and the 4th order solution, without absolute values on either side. An "
            "error of the wrong sign is never rejected, however large, and where y is negative the "
            "relative tolerance does not count. The option "
            '`step_control = "odepkg-2009"` does exactly this; it is there to meet the paper’s numbers, '
            "not for use. The default is an honest test."
        ),
        Table(
            "The four methods under both error tests; E is the energy change after 10 s.",
            ("tolerance", "method", "steps, signed", "steps, honest", "E [J], signed", "E [J], honest"),
            tuple(rows),
            text_columns=2,
        ),
        Paragraph(
            f"An honest test needs {count(loose.steps('baseline'))} steps at the loose tolerance, almost "
            "all at the cap of 0.1 s, where accuracy is what the cap leaves. At the tight tolerance the "
            f"baseline’s length drifts by {number(drift[1], unit='m')} instead of "
            f"{number(drift[0], unit='m')}: the drift in the paper’s Figure 2 is mostly the error test’s, "
            "not the formulation’s."
        ),
    )


def replaced(results: Results) -> tuple[Paragraph | Table, ...]:
    """Compares what is put back into the integrator's state after a step."""
    loose, tight = results.case("options1"), results.case("options2")
    rows = tuple(
        (label, count(loose.steps(m)), energy(loose, m), count(tight.steps(m)), energy(tight, m))
        for m, label in VARIANTS.items()
    )
    third = results.case("figure3")
    position, both = (energy_change(third.run(m)) for m in ("present-position", "present"))
    return (
        Paragraph(
            "Equations (11) and (17) project position and velocity inside the right-hand side. Whether the "
            "projected values also replace the integrator’s state at the end of a step is not said. "
            "Replacing both costs no further evaluation: the last stage of the step has projected them "
            "already."
        ),
        Table(
            "‘Present’ with the signed error test; E is the energy change after 10 s.",
            ("replaced", "steps, loose", "E [J], loose", "steps, tight", "E [J], tight"),
            rows,
        ),
        Paragraph(
            "With an honest error test and steps of 0.05 s (the figure below) the energy changes by "
            f"{number(position, unit='J', plus=True)} with the position replaced and by "
            f"{number(both, unit='J', plus=True)} with both: {number(abs(position / both))} times less at "
            "the same cost. That is why both is the default. Stages that are not projected keep the "
            "constraint at the ends of the steps only, and the energy error no longer vanishes with the "
            "tolerance."
        ),
    )


def sign(results: Results) -> tuple[Paragraph | Table, ...]:
    """Shows from the multiplier what the printed sign of Eq. (8) would do."""
    case = results.case(TIGHT)
    run = case.run("baseline")
    # With the printed sign A xddot - b'' is 2 (A a - b''); and A a - b'' = A M^-1 A' lambda, here lambda / m.
    printed = 2.0 * float(abs(run["lambda"]).max()) / MASS
    kept = case.number("baseline", "max_phiddot")
    return (
        Paragraph(
            "Equation (8) is printed with (b″ − A a) in its bracket; it must be (A a − b″), as in Eqs. (7) "
            "and (11b). With the printed sign the rod would push where it must pull, and the acceleration "
            f"constraint would be missed by 2 |A a − b″|, here up to {number(printed, 3, 'm/s²')}. taut’s "
            f"baseline uses the sign of (11b) and keeps the constraint to {number(kept, unit='m/s²')}."
        ),
    )
