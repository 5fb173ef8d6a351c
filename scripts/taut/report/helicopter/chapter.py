"""The helicopter blade's chapter of the report: claims, figures, Table 3 and what the paper leaves open."""

import numpy as np

from taut.formats import count, listed, number
from taut.report.document import Chapter, Figure, Paragraph, Section, Table
from taut.report.helicopter import figures as helicopter
from taut.report.helicopter.claims import CHECKS, CLAIMS, OLD, PAPER, RIGID, SOFT, STIFF, TIGHT
from taut.report.helicopter.measures import dominant_frequency, largest
from taut.report.judgment import judged
from taut.results import Results

CASES = (
    PAPER,
    OLD,
    TIGHT,
    "runaway_odepkg",
    SOFT,
    f"{SOFT}_tight",
    STIFF,
    f"{STIFF}_tight",
    RIGID,
    "cyclic",
)
CAPTIONS = (
    "The paper’s Figure 9: the blade root and its pitch link, to scale, from the dimensions of Table 3.",
    "The paper’s Figure 10: flap (top) and pitch (bottom), angles (left) and their rates (right). Flap "
    "settles into the forced motion of once per revolution within a few turns; the penalty’s pitch "
    "oscillates about it. The oscillation grows because the tolerance is loose: with 10⁻⁶ it does not.",
    "The paper’s Figure 11: the link’s length error (top) and its rate (bottom), with their signs. On the "
    "right, without the penalty and at scales a billion times finer, the baseline drifts.",
    "The paper’s Figure 12: tension of the pitch link (top left, and without the penalty top and bottom "
    "right) and the multiplier of the velocity correction (bottom left); that of the baseline is what it "
    "would take, not what is applied. What is left after the start is a third harmonic.",
    "One turn of the rotor with a swashplate that moves, collective and once per revolution: a constraint "
    "that depends on time. The paper describes this and does not run it; angles are to scale.",
)
# Property, symbol of the model, what the paper prints, unit.
TABLE_3 = (
    ("Rotor angular velocity, Ω", "omega", "40.0", "rad/s"),
    ("Rotor radius, R", "radius", "5.0", "m"),
    ("Blade flap inertia, I_b", "i_b", "416.67", "kg m²"),
    ("Blade twist inertia, I_f", "i_f", "9.375 × 10⁻²", "kg m²"),
    ("Blade centrifugal inertia, I_x", "i_x", "1.875 × 10⁻²", "kg m²"),
    ("Lock number, γ", "gamma", "8.0", ""),
    ("Flap hinge radial offset, x_β", "x_beta", "0.2", "m"),
    ("Point A radial offset, x_θ", "x_theta", "0.05", "m"),
    ("Point A chordwise offset, y_θ", "y_theta", "0.2", "m"),
    ("Point B radial offset, x_B", "x_b", "0.25", "m"),
    ("Point B chordwise offset, y_B", "y_b", "0.2", "m"),
    ("Point B out-of-plane offset, z_B", "z_b", "−0.15", "m"),
    ("Pitch link length, L", "length", "0.15", "m"),
    ("Blade flap frequency ratio, ν_β (computed)", "nu_beta", "1.0625", ""),
    ("… its square, ν_β²", "nu_beta_squared", "", ""),
    ("Pitch-flap coupling, K_p (computed)", "k_p", "0.25", ""),
    ("Control system stiffness, K_c (computed)", "k_c", "1.6538 × 10⁴", "N m"),
)


def build(results: Results) -> Chapter:
    """Returns the chapter; the figures must have been drawn."""
    figures = tuple(
        Figure(spec.title, spec.path(results), caption)
        for spec, caption in zip(helicopter.FIGURES, CAPTIONS, strict=True)
    )
    return Chapter(
        title="Helicopter blade",
        reference="Sect. 4.3",
        claims=judged(CLAIMS, results),
        checks=judged(CHECKS, results),
        figures=figures,
        sections=(
            Section("Table 3", table_3(results)),
            Section("The price of stiffness", stiffness(results)),
            Section("What the paper leaves open", left_open(results)),
        ),
        warnings=warnings(results),
    )


def warnings(results: Results) -> tuple[str, ...]:
    """Returns a line for each case with runs that did not reach the end."""
    lines = []
    for name in CASES:
        ended = [f"{method} ({status})" for method, status in results.case(name).unfinished.items()]
        if ended:
            lines.append(f"In case {name} these runs did not reach the end: {listed(ended)}.")
    return tuple(lines)


def table_3(results: Results) -> tuple[Paragraph | Table, ...]:
    """Sets the model's numbers beside what the paper prints."""
    model = results.case(PAPER).model
    rows = tuple((text, printed, number(model[name], 5), unit) for text, name, printed, unit in TABLE_3)
    return (
        Paragraph(
            "The paper’s ‘blade flap frequency ratio’ of 1.0625 is the square of what its own footnote "
            "defines, ν_β = √(1 + 3/2 x_β/(R − x_β)); Eq. (30a) is used with ν_β², so that nothing else "
            "depends on it. K_p = x_θ/y_θ, and K_c = I_f (10.5 Ω)²."
        ),
        Table("Blade and pitch control.", ("property", "the paper prints", "taut", "unit"), rows),
    )


def stiffness(results: Results) -> tuple[Paragraph | Table, ...]:
    """Sets control systems of several stiffnesses beside the constraint, at both tolerances."""
    rows = []
    for name in (SOFT, PAPER, STIFF):
        for suffix, word in (("", "10⁻², 10⁻⁴"), ("_tight", "10⁻⁶, 10⁻⁸")):
            case = results.case(name + suffix)
            rows.append(_row(f"{case.model['control_frequency']:g} Ω", word, case, "penalty"))
    for name, word in ((PAPER, "10⁻², 10⁻⁴"), (TIGHT, "10⁻⁶, 10⁻⁸")):
        rows.append(_row("constraint, present", word, results.case(name), "present"))
    case, tight = results.case(PAPER), results.case(TIGHT)
    omega = tight.model["omega"]
    found = dominant_frequency(tight.model, tight.run("penalty"))
    turned = found * float(np.median(case.run("penalty")["h"]))
    return (
        Paragraph(
            "The ‘penalty’ of this problem is the control system’s own stiffness, K_c (θ_c − θ − K_p β) in "
            "Eq. (30b), and the constraint is evaluated without being enforced. The pitch then oscillates at "
            f"ω = {number(found / omega, 3)} Ω, once in {number(2e3 * np.pi / found, 2, 'ms')}, and that "
            "sets the step. The Dormand–Prince formulas amplify an undamped oscillation when ω h exceeds 1, "
            "by 0.3 % a step at 1.5; the paper’s relative tolerance of 10⁻² does not mind, and the median ω "
            f"h is {number(turned)}. So the oscillation is fed from step to step, and a control system a "
            "hundred times as stiff, which takes more steps, ends in a motion that is none. With a strict "
            "tolerance all of them converge to the constraint, the violation falling with the stiffness."
        ),
        Table(
            "Stiffness in place of the constraint, honest error test; tolerances relative, absolute.",
            ("control system", "tolerances", "steps", "rejected", "max |φ| [m]", "max |dφ/dt| [m/s]"),
            tuple(rows),
            text_columns=2,
        ),
        Paragraph(
            f"The constraint takes {count(case.steps('present'))} steps and complies to "
            f"{number(case.number('present', 'max_phi'), unit='m')}."
        ),
    )


def _row(label: str, tolerance: str, case, method: str) -> tuple[str, ...]:  # noqa: ANN001
    """Returns a row of the table of stiffnesses."""
    errors = (number(case.number(method, key)) for key in ("max_phi", "max_phidot"))
    return (label, tolerance, count(case.steps(method)), count(int(case.number(method, "rejected"))), *errors)


def left_open(results: Results) -> tuple[Paragraph | Table, ...]:
    """Tells what had to be chosen, and what the other choice does."""
    runaway = results.case("runaway_odepkg")
    cyclic = results.case("cyclic")
    run = cyclic.run("present")
    return (
        Paragraph(
            "The printed root of Eq. (29) reaches over −L; the length of the link stands outside of it here. "
            "The control command θ_c is not given; it is the pitch that the height of B asks for where the "
            "link is vertical, (z_B + L)/y_θ, zero in the paper’s run. The force of the link without a "
            "constraint is that of the stiffness at the arm y_θ. The first step is 0.01 s: an automatic one "
            "would cost a few steps more than the paper’s 200."
        ),
        Paragraph(
            "The error test matters for the penalty alone. With the signed test of 2009, which meets the "
            "paper’s numbers of the pendulum, the penalty runs away: after "
            f"{runaway.number('penalty', 't_end'):g} s the link is wrong by "
            f"{number(runaway.number('penalty', 'max_phi'), unit='m')}. So the honest test is the default "
            "here, and meets the paper’s nearly 700 with the rejected tries counted."
        ),
        Paragraph(
            "The paper says that a control of the pitch moves B, and keeps it at rest. With a collective and "
            "a cyclic motion of the swashplate the constraint depends on time: ‘present’ takes "
            f"{count(cyclic.steps('present'))} steps, complies to "
            f"{number(cyclic.number('present', 'max_phi'), unit='m')} and "
            f"{number(cyclic.number('present', 'max_phidot'), unit='m/s')}, and the pitch reaches "
            f"{number(largest(run, 'theta'), 3, 'rad')}; ‘baseline’ is off by "
            f"{number(cyclic.number('baseline', 'max_phi'), unit='m')}."
        ),
    )
