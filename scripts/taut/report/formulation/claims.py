"""What the paper says of the formulation (Sects 2 and 3) and what taut gives, row by row."""

import numpy as np

from taut.formats import count, listed, number
from taut.report.document import Claim, Held
from taut.report.formulation.measures import (
    ROLLING_RADIUS,
    circle_error,
    gaussians,
    integrators,
    slider_error,
)
from taut.report.judgment import LOOSE, NEWTON_TOLERANCE, TIGHT, Row, once
from taut.report.pendulum.measures import MAX_TENSION, end_distance
from taut.results import Results

REDUNDANT, ROLLING, DRIVEN = "redundant", "rolling_disc", "slider_crank"
COPIES = 3
# W = I and W = M.
WEIGHTS = ("present-identity", "present")
# Examples, and the integrators that they bring.
SHAPES, ACTUATOR = "shapes", "actuator"
BROUGHT = ("rk4", "newmark")


def redundancy(results: Results) -> Claim:
    """Judges 'this allows to account for redundant constraints' and Sect. 3.3's 'independent or not'."""
    case, single = results.case(REDUNDANT), results.case(f"{TIGHT}_standard")
    apart = end_distance(case.run("present"), single.run("present"))
    worst = case.number("present", "max_phi")
    met = apart < 1e-9 and worst <= NEWTON_TOLERANCE and case.steps("present") == single.steps("present")
    return Claim(
        "The generalized inverse allows for redundant constraints: positions are found whether the "
        "constraints are independent or not.",
        f"The pendulum’s constraint stated {COPIES} times: {count(case.steps('present'))} steps as against "
        f"{count(single.steps('present'))}, |φ| up to {number(worst, unit='m')}, the ends "
        f"{number(apart, unit='m')} apart.",
        strict=(Held("with an honest error test", met),),
        otherwise="the motion is another",
    )


def least_norm(results: Results) -> Claim:
    """Judges 'Eq. (7) yields a minimal norm of the multipliers'."""
    run = results.case(REDUNDANT).run("present")
    shares = [run[f"lambda{i}"] for i in range(1, COPIES + 1)]
    # 3 m g sin(angle below the horizontal), of which each of equal rows bears as much.
    tension = -MAX_TENSION * run["z"]
    apart = max(float(np.max(np.abs(share - shares[0]))) for share in shares)
    error = float(np.max(np.abs(sum(shares) - tension)))
    return Claim(
        "The multipliers of redundant constraints are those of least norm.",
        f"Each of {COPIES} equal constraints bears a third of the tension: they differ by up to "
        f"{number(apart, unit='N')}, and their sum from 3 m g sin θ by up to {number(error, unit='N')}.",
        strict=(Held("with an honest error test", apart < 1e-9 and error < 1e-6 * MAX_TENSION),),
        otherwise="they are not equal, or their sum is not the tension",
    )


def mu_of_exact_integration(results: Results) -> Claim:
    """Judges 'mu should be identically zero, were the integration exact'."""
    loose, tight = (
        float(np.max(np.abs(results.case(f"{name}_standard").run("present")["mu"])))
        for name in (LOOSE, TIGHT)
    )
    return Claim(
        "The multiplier μ should be identically zero, were the integration exact.",
        f"|μ| of the pendulum up to {number(loose, unit='m/s')} with the loose tolerance and "
        f"{number(tight, unit='m/s')} with the tight one.",
        once(tight < 1e-3 * loose),
        otherwise="it does not vanish with the tolerance",
    )


def arbitrary_weight(results: Results) -> Claim:
    """Judges 'the arbitrarily chosen weight matrix W', and the preference for W = I."""
    case = results.case(ROLLING)
    identity, mass = (circle_error(case.run(m)) for m in WEIGHTS)
    steps = [count(case.steps(m)) for m in WEIGHTS]
    worst = max(case.number(m, "max_phi") for m in WEIGHTS)
    met = worst <= NEWTON_TOLERANCE and max(identity, mass) < 10 * min(identity, mass)
    return Claim(
        "The weight W may be chosen at will; W = I is preferred, others take W = M.",
        "A rolling disc, whose moments of inertia are not its mass: off the exact circle by up to "
        f"{number(identity, unit='m')} with W = I in {steps[0]} steps, {number(mass, unit='m')} with W = M "
        f"in {steps[1]}; |φ| up to {number(worst, unit='m')}.",
        strict=(Held("at a strict tolerance", met),),
        otherwise="one of them violates the constraints, or is far less accurate",
    )


def nonholonomic(results: Results) -> Claim:
    """Judges 'non-holonomic constraints can be dealt with in a similar manner'."""
    case = results.case(ROLLING)
    rates = [case.number(m, "max_phidot") for m in ("present", "baseline")]
    error = circle_error(case.run("present"))
    met = rates[0] <= NEWTON_TOLERANCE and error < 1e-5 * ROLLING_RADIUS
    return Claim(
        "Non-holonomic constraints can be dealt with in a similar manner.",
        "A disc that rolls without slipping: violations of the velocities up to "
        f"{number(rates[0], unit='m/s')} (baseline {number(rates[1], unit='m/s')}), off the exact circle by "
        f"up to {number(error, unit='m')}.",
        strict=(Held("at a strict tolerance", met),),
        otherwise="it slips, or leaves the circle",
    )


def rheonomic(results: Results) -> Claim:
    """Judges Eqs (6), (13): constraints that depend on time, by p_v and p_a."""
    case = results.case(DRIVEN)
    units = {"max_phi": "m", "max_phidot": "m/s", "max_phiddot": "m/s²"}
    worst = {key: case.number("present", key) for key in units}
    told = listed([number(worst[key], unit=unit) for key, unit in units.items()])
    error = slider_error(case.run("present"))
    met = max(worst.values()) <= NEWTON_TOLERANCE and error < 1e-11
    return Claim(
        "Rheonomic constraints correct the unconstrained velocity and acceleration too, by p_v and p_a.",
        f"A slider-crank turned by a drive: violations up to {told}; the slider is off its closed form by up "
        f"to {number(error, unit='m')}.",
        strict=(Held("at a strict tolerance", met),),
        otherwise="it does not comply, or is elsewhere",
    )


def least_functional(results: Results) -> Claim:
    """Judges 'the proposed approach minimizes the functional' of Eq. (15)."""
    of_run, least = gaussians(results.case(f"{TIGHT}_standard").run("present"))
    scale = float(least.max())
    apart = float(np.max(np.abs(of_run - least))) / scale
    return Claim(
        "The proposed approach minimizes the functional G of Eq. (15) under its constraints.",
        "Pendulum: G by differences of the run’s velocities and positions is within "
        f"{number(apart)} of its largest value, {number(scale, 3, 'J/s²')}, of the least one that the "
        "geometry of the circle allows, at all times.",
        strict=(Held("at a strict tolerance", apart < 1e-3),),
        otherwise="it is not the least",
    )


def poor_shapes(results: Results) -> Claim:
    """Judges Sect. 3.4.2: A X of lower rank, though A and X have full rank; 'mildly inconsistent'."""
    alike, apart = (line.split() for line in results.printed(SHAPES)[-2:])
    met = alike[1:3] == apart[1:3] == ["2", "1"] and float(alike[3]) <= NEWTON_TOLERANCE < float(apart[3])
    return Claim(
        "Ritz forms may leave A X without full rank although A and X have it; then the constraints might not "
        "be satisfied within the tolerance: they become mildly inconsistent.",
        f"Three masses in two shapes, two of them held: A has rank {alike[1]}, A X rank {alike[2]}. Held "
        f"alike, |φ| of {number(float(alike[3]), unit='m')} is left; held "
        f"{number(float(apart[0]), unit='m')} apart, {number(float(apart[3]), unit='m')} of each, "
        "which is refused unless it is asked for.",
        once(met),
        otherwise="the ranks are others, or what can be met is not",
        remark=f"example `{SHAPES}`",
    )


def other_states(results: Results) -> Claim:
    """Judges Sect. 3.5: 'the projection does not affect any non-mechanical part w of the state'."""
    position, current, moved = results.printed(ACTUATOR)[-3:]
    errors = [abs(float(a) - float(b)) for a, b in (line.split()[-2:] for line in (position, current))]
    x, v, w = (float(word) for word in moved.split()[-3:])
    return Claim(
        "The projection affects the mechanical states alone, and no non-mechanical part w of the state.",
        f"A coil pulls a bead along a wire: a state beside the wire is moved by {number(x, unit='m')}, "
        f"its velocity by {number(v, unit='m/s')}, the current w by {number(w)}; in motion the bead is off "
        f"its closed form by {number(errors[0], unit='m')}, w by {number(errors[1], unit='A')}.",
        once(min(x, v) > 0.0 and w == 0.0 and max(errors) < 1e-7),
        otherwise="w is moved, or is not what it is without the constraint",
        remark=f"example `{ACTUATOR}`",
    )


def little_intrusion(results: Results) -> Claim:
    """Judges 'a simple, little-intrusive means to enforce constraints into existing implementations'."""
    rows = [
        row
        for name in BROUGHT
        for row in integrators(results, name)
        if not row["integrator"].startswith("taut")
    ]
    worst = max(float(row[level]) for row in rows for level in ("phi", "phidot"))
    error = max(float(row["error"]) for row in rows)
    names = listed(sorted({row["integrator"] for row in rows}))
    problems = listed(sorted({row["problem"] for row in rows}))
    return Claim(
        "The intrusiveness is minimal: constraints are added to implementations of purely differential "
        "problems, which stay what they are.",
        f"{names}, written for y’ = f(t, y), with the right-hand side and one call behind each step: "
        f"{problems} with violations up to {number(worst)} and motions off by up to "
        f"{number(error, unit='m')}.",
        once(worst <= 10 * NEWTON_TOLERANCE and error < 1e-3),
        otherwise="they do not comply, or move otherwise",
        remark="examples " + listed([f"`{name}`" for name in BROUGHT]),
    )


CLAIMS = (
    Row(least_functional, cases=(f"{TIGHT}_standard",)),
    Row(redundancy, cases=(REDUNDANT, f"{TIGHT}_standard")),
    Row(least_norm, cases=(REDUNDANT,)),
    Row(mu_of_exact_integration, cases=(f"{LOOSE}_standard", f"{TIGHT}_standard")),
    Row(arbitrary_weight, cases=(ROLLING,)),
    Row(nonholonomic, cases=(ROLLING,)),
    Row(rheonomic, cases=(DRIVEN,)),
    Row(poor_shapes, prints=(SHAPES,)),
    Row(other_states, prints=(ACTUATOR,)),
    Row(little_intrusion, prints=BROUGHT),
)
