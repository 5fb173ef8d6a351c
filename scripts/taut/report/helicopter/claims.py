"""What the paper says about the helicopter blade (Sect. 4.3) and what taut gives, row by row."""

from taut.formats import count, number, percent
from taut.report.document import Claim, Verdict
from taut.report.helicopter.measures import (
    SETTLED,
    dominant_frequency,
    drift,
    harmonics,
    largest,
    third_harmonic,
    tries,
)
from taut.report.judgment import ABOUT, NEWTON_TOLERANCE, either, verdict
from taut.results import Results

PAPER, OLD, TIGHT = "figure10", "figure10_odepkg", "figure10_tight"
SOFT, STIFF = "soft_control", "stiff_control"
# What is 'essentially' nothing beside something else.
NOTHING = 1e-2


def helicopter_claims(results: Results) -> tuple[Claim, ...]:
    """Returns every statement of Sect. 4.3 that runs can confirm or refute."""
    return (
        constraint_steps(results),
        penalty_steps(results),
        comparable(results),
        stiffer(results),
        no_drift(results),
        baseline_drift(results),
        oscillation(results),
        unloaded(results),
        second_harmonic(results),
        multiplier(results),
        soft_frequency(results),
        soft_rates(results),
        soft_violation(results),
    )


def constraint_steps(results: Results) -> Claim:
    """Judges 'the first two cases ran the whole analysis at the maximum allowed step, thus 200 steps'."""
    steps = [[tries(results.case(name), m) for m in ("baseline", "present")] for name in (PAPER, OLD)]
    decision, because = either(*(pair == [200, 200] for pair in reversed(steps)))
    return Claim(
        "‘Baseline’ and ‘present’ run at the maximum allowed time step: 200 steps.",
        f"{steps[0][0]} and {steps[0][1]}, none rejected; with the signed error test {steps[1][0]} and "
        f"{steps[1][1]}.",
        decision,
        because if decision is not Verdict.NO else "not 200",
    )


def penalty_steps(results: Results) -> Claim:
    """Judges 'the last case required nearly 700 steps'."""
    case, runaway = results.case(PAPER), results.case("runaway_odepkg")
    accepted, tried = case.steps("penalty"), tries(case, "penalty")
    near = [(1 - ABOUT) * 700 <= steps <= 1.02 * 700 for steps in (accepted, tried)]
    if near[0]:
        decision, because = Verdict.YES, ""
    elif near[1]:
        decision, because = Verdict.CONDITION, "counting rejected tries, with an honest error test"
    else:
        decision, because = Verdict.NO, "more or fewer by far"
    return Claim(
        "The penalty takes nearly 700 steps.",
        f"{count(accepted)} steps and {count(tried - accepted)} rejected tries, {count(tried)} in all. With "
        "the signed error test it runs away: |φ| of "
        f"{number(runaway.number('penalty', 'max_phi'), unit='m')} within "
        f"{runaway.number('penalty', 't_end'):g} s.",
        decision,
        because,
    )


def comparable(results: Results) -> Claim:
    """Judges 'a solution that is qualitatively comparable to that of the first two cases'."""
    case = results.case(PAPER)
    flap = [largest(case.run(m), "beta", SETTLED) for m in ("present", "penalty")]
    pitch = [largest(case.run(m), "theta", SETTLED) for m in ("present", "penalty")]
    off = [abs(pair[1] / pair[0] - 1) for pair in (flap, pitch)]
    decision, because = verdict(max(off) < 1.0, "an angle is off by its own size")
    if decision is Verdict.YES and max(off) > ABOUT:
        decision, because = Verdict.CONDITION, f"the largest pitch is off by {percent(off[1])}"
    return Claim(
        "… to a solution that is qualitatively comparable.",
        f"Largest flap after {SETTLED:g} s: {number(flap[1], 3, 'rad')} against {number(flap[0], 3, 'rad')} "
        f"of ‘present’; largest pitch {number(pitch[1], 3)} against {number(pitch[0], 3, 'rad')}.",
        decision,
        because,
    )


def stiffer(results: Results) -> Claim:
    """Judges 'if the stiffness is increased further, the analysis does not converge'."""
    case, tight = results.case(STIFF), results.case(f"{STIFF}_tight")
    length = case.model["length"]
    left, converged = (c.number("penalty", "max_phi") for c in (case, tight))
    diverges, cured = left > 0.1 * length, converged < 1e-3 * length
    ratio = case.model["k_c"] / results.case(PAPER).model["k_c"]
    decision, because = verdict(diverges, "it converges")
    if diverges and cured:
        decision, because = Verdict.CONDITION, "at the paper’s tolerance; a strict one converges"
    return Claim(
        "If the stiffness of the control system is increased further, the analysis does not converge.",
        f"{number(ratio, 3)} times K_c: {count(case.steps('penalty'))} steps, and a link that is "
        f"{number(left, unit='m')} too long or too short; {count(tight.steps('penalty'))} steps and "
        f"{number(converged, unit='m')} with a relative tolerance of 10⁻⁶.",
        decision,
        because,
    )


def no_drift(results: Results) -> Claim:
    """Judges 'the penalty case does not drift'."""
    case = results.case(PAPER)
    first, last, most = drift(case.model, case.run("penalty"))
    return Claim(
        "The penalty does not drift …",
        f"Mean of φ {number(first, unit='m')} in the first and {number(last, unit='m')} in the last fifth of "
        f"the run, beside an oscillation of {number(most, unit='m')}.",
        *verdict(max(abs(first), abs(last)) < 0.05 * most, "its mean moves"),
    )


def baseline_drift(results: Results) -> Claim:
    """Judges '... while the baseline one does'."""
    case = results.case(PAPER)
    first, last, _ = drift(case.model, case.run("baseline"))
    most = case.number("present", "max_phi")
    return Claim(
        "… while ‘baseline’ does.",
        f"Mean of φ {number(first, unit='m')} in the first and {number(last, unit='m')} in the last fifth of "
        f"the run; ‘present’ stays within {number(most, unit='m')}.",
        *verdict(
            abs(last) > 2 * abs(first) and abs(last) > 5 * max(most, NEWTON_TOLERANCE),
            "its mean hardly moves",
        ),
    )


def oscillation(results: Results) -> Claim:
    """Judges 'the penalty case oscillates significantly about the expected solution'."""
    case, tight = results.case(PAPER), results.case(TIGHT)
    most, converged = (c.number("penalty", "max_phi") for c in (case, tight))
    rate = [largest(case.run(m), "theta_rate", SETTLED) for m in ("penalty", "present")]
    decision, because = verdict(rate[0] > 2 * rate[1], "the rate of pitch hardly differs")
    return Claim(
        "The penalty oscillates significantly about the expected solution.",
        f"Pitch rate up to {number(rate[0], unit='rad/s')} against {number(rate[1], unit='rad/s')}, φ up to "
        f"{number(most, unit='m')}. The loose tolerance feeds the oscillation: with 10⁻⁶ it is "
        f"{number(converged, unit='m')}.",
        decision,
        because,
    )


def unloaded(results: Results) -> Claim:
    """Judges 'the pitch link is essentially unloaded'."""
    case = results.case(PAPER)
    force = {m: largest(case.run(m), "link_force", SETTLED) for m in ("present", "baseline", "penalty")}
    start = largest(case.run("present"), "link_force")
    met = max(force["present"], force["baseline"]) < NOTHING * start
    return Claim(
        "With a constraint the pitch link is essentially unloaded …",
        f"After {SETTLED:g} s at most {number(force['present'], unit='N')} (‘present’) and "
        f"{number(force['baseline'], unit='N')} (baseline), {number(start, unit='N')} at the start; the "
        f"penalty {number(force['penalty'], unit='N')}.",
        *verdict(met, "it carries a force"),
    )


def second_harmonic(results: Results) -> Claim:
    """Judges '... except for a small second harmonic', which nonlinear kinematics are to explain."""
    case = results.case(TIGHT)
    run = case.run("present")
    amplitude = harmonics(case.model, run, "link_force")
    expected = third_harmonic(case.model, largest(run, "beta", SETTLED))
    order = int(amplitude.argmax()) + 1
    return Claim(
        "… except for a small second harmonic, entirely due to the nonlinear kinematics.",
        f"Amplitudes of once to four times per revolution: {', '.join(number(a) for a in amplitude[:3])} and "
        f"{number(amplitude[3], unit='N')}; kinematics alone, sin θ = −K_p tan β, gives a third harmonic of "
        f"{number(expected, unit='N')}.",
        *verdict(
            order == 2,
            "the nonlinear kinematics give a third harmonic: the link is vertical at rest, so that θ is an "
            "odd function of β",
        ),
    )


def multiplier(results: Results) -> Claim:
    """Judges 'the multiplier mu is essentially zero', and its use."""
    case = results.case(PAPER)
    run = case.run("present")
    mu = largest(run, "mu")
    # mu moves the pitch rate by A_theta mu, and A_theta is y_theta at rest.
    moved, rate = case.model["y_theta"] * mu, largest(run, "theta_rate")
    left = [case.number(m, "max_phidot") for m in ("baseline", "present")]
    met = moved < 1e-4 * rate and left[1] < NOTHING * left[0]
    return Claim(
        "The multiplier μ is essentially zero, yet instrumental in eliminating the drift.",
        f"|μ| up to {number(mu, unit='1/(m s)')}: {number(moved, unit='rad/s')} of a pitch rate of "
        f"{number(rate, unit='rad/s')}. |dφ/dt| up to {number(left[0], unit='m/s')} without (baseline), "
        f"{number(left[1], unit='m/s')} with it.",
        *verdict(met, "it is not small, or it does not help"),
    )


def soft_frequency(results: Results) -> Claim:
    """Judges 'although oscillating at nearly half the frequency'."""
    stiff, soft = results.case(TIGHT), results.case(f"{SOFT}_tight")
    omega = stiff.model["omega"]
    found = [dominant_frequency(c.model, c.run("penalty")) / omega for c in (soft, stiff)]
    ratio = found[0] / found[1]
    return Claim(
        "A control system of 5.5 Ω oscillates at nearly half the frequency …",
        f"{number(found[0], 3)} Ω instead of {number(found[1], 3)} Ω: {number(ratio)} times.",
        *verdict(abs(ratio - 0.5) < ABOUT, "not near half"),
    )


def soft_rates(results: Results) -> Claim:
    """Judges 'the angular velocity oscillations can be much less pronounced'."""
    stiff, soft, present = (
        largest(results.case(c).run(m), "theta_rate")
        for c, m in ((PAPER, "penalty"), (SOFT, "penalty"), (PAPER, "present"))
    )
    return Claim(
        "… with angular velocity oscillations that are much less pronounced …",
        f"Pitch rate up to {number(soft, unit='rad/s')} instead of {number(stiff, unit='rad/s')}; "
        f"{number(present, unit='rad/s')} of it is the motion itself. "
        f"{count(results.case(SOFT).steps('penalty'))} steps.",
        *verdict(
            soft - present < 0.5 * (stiff - present),
            f"{percent((soft - present) / (stiff - present))} are left",
        ),
    )


def soft_violation(results: Results) -> Claim:
    """Judges 'at the cost of a much larger violation of the constraint'."""
    loose, tight = (
        [results.case(f"{name}{suffix}").number("penalty", "max_phi") for name in (SOFT, PAPER)]
        for suffix in ("", "_tight")
    )
    met = [pair[0] > 2 * pair[1] for pair in (loose, tight)]
    if met[0]:
        decision, because = Verdict.YES, ""
    elif met[1]:
        decision, because = (
            Verdict.CONDITION,
            "in runs with a strict tolerance; at the paper’s, what the integration adds to the stiffer "
            "oscillation is more",
        )
    else:
        decision, because = Verdict.NO, "it is not larger"
    return Claim(
        "… but at the cost of a much larger violation of the constraint.",
        f"|φ| up to {number(loose[0])} instead of {number(loose[1], unit='m')}; with a relative tolerance of "
        f"10⁻⁶ {number(tight[0])} instead of {number(tight[1], unit='m')}.",
        decision,
        because,
    )
