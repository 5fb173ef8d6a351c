"""What the paper says about the helicopter blade (Sect. 4.3) and what taut gives, row by row."""

import math

from taut.formats import count, number, percent
from taut.report.document import Claim, Held
from taut.report.helicopter.measures import (
    SETTLED,
    dominant_frequency,
    drift,
    harmonics,
    largest,
    third_harmonic,
    tries,
)
from taut.report.judgment import ABOUT, NEWTON_TOLERANCE, Row, once, paper_and_strict
from taut.results import Results

PAPER, OLD, TIGHT, AUTOMATIC = "figure10", "figure10_odepkg", "figure10_tight", "figure10_automatic"
SOFT, STIFF, RIGID = "soft_control", "stiff_control", "rigid_control"
# What is 'essentially' nothing beside something else.
NOTHING = 1e-2
# The moment that drives the flap once per revolution, as the paper has it [N m].
FLAP_MOMENT = 1e4
# So many more steps than with the constraint are as many.
AS_MANY = 0.1
# Angles that are off by less are 'qualitatively comparable'.
COMPARABLE = 0.25


def constraint_steps(results: Results) -> Claim:
    """Judges 'the first two cases ran the whole analysis at the maximum allowed step, thus 200 steps'."""
    cases = {
        PAPER: "with a first step of 0.01 s",
        OLD: "with a first step of 0.01 s and the signed error test of 2009",
        AUTOMATIC: "with an automatic first step",
    }
    steps = {
        name: [tries(results.case(name), m) for m in ("baseline", "present")]
        for name in filter(results.has, cases)
    }
    held = {name: Held(cases[name], pair == [200, 200]) for name, pair in steps.items()}
    return Claim(
        "‘Baseline’ and ‘present’ run at the maximum allowed time step: 200 steps.",
        "; ".join(f"{pair[0]} and {pair[1]} {cases[name]}" for name, pair in steps.items())
        + ", rejected ones counted.",
        tuple(held[name] for name in (OLD, AUTOMATIC) if name in held),
        (held[PAPER],),
        otherwise="not 200",
    )


def penalty_steps(results: Results) -> Claim:
    """Judges 'the last case required nearly 700 steps'."""
    case, runaway = results.case(PAPER), results.case("runaway_odepkg")
    accepted, tried = case.steps("penalty"), tries(case, "penalty")
    near = [(1 - ABOUT) * 700 <= steps <= 1.02 * 700 for steps in (accepted, tried)]
    return Claim(
        "The penalty takes nearly 700 steps.",
        f"{count(accepted)} steps and {count(tried - accepted)} rejected tries, {count(tried)} in all. With "
        "the signed error test it runs away: |φ| of "
        f"{number(runaway.number('penalty', 'max_phi'), unit='m')} within "
        f"{runaway.number('penalty', 't_end'):g} s.",
        (Held("with the signed error test of 2009", False),),
        (
            Held("counting accepted steps, with an honest error test", near[0]),
            Held("counting rejected tries too, with an honest error test", near[1]),
        ),
        otherwise="more or fewer by far",
    )


def comparable(results: Results) -> Claim:
    """Judges 'a solution that is qualitatively comparable to that of the first two cases'."""
    told, met = [], []
    for name in (PAPER, TIGHT):
        case = results.case(name)
        flap, pitch = (
            [largest(case.run(m), angle, SETTLED) for m in ("present", "penalty")]
            for angle in ("beta", "theta")
        )
        off = [abs(pair[1] / pair[0] - 1) for pair in (flap, pitch)]
        met.append(max(off) < COMPARABLE)
        told.append(
            f"largest flap {number(flap[1], 3)} against {number(flap[0], 3, 'rad')} of ‘present’, largest "
            "pitch "
            f"{number(pitch[1], 3)} against {number(pitch[0], 3, 'rad')}, off by {percent(max(off))}"
        )
    return Claim(
        "… to a solution that is qualitatively comparable.",
        f"After {SETTLED:g} s: {told[0]}; at a strict tolerance {told[1]}.",
        **paper_and_strict(*met),
        otherwise="an angle is off by more than a quarter",
    )


def stiffer(results: Results) -> Claim:
    """Judges 'if the stiffness is increased further, the analysis does not converge'."""
    case, tight = results.case(STIFF), results.case(f"{STIFF}_tight")
    length = case.model["length"]
    left, converged = (c.number("penalty", "max_phi") for c in (case, tight))
    diverges, cured = left > 0.1 * length, converged < 1e-3 * length
    ratio = case.model["k_c"] / results.case(PAPER).model["k_c"]
    return Claim(
        "If the stiffness of the control system is increased further, the analysis does not converge.",
        f"{number(ratio, 3)} times K_c: {count(case.steps('penalty'))} steps, and a link that is "
        f"{number(left, unit='m')} too long or too short; {count(tight.steps('penalty'))} steps and "
        f"{number(converged, unit='m')} with a relative tolerance of 10⁻⁶.",
        **paper_and_strict(diverges, not cured),
        otherwise="it converges",
    )


def no_drift(results: Results) -> Claim:
    """Judges 'the penalty case does not drift'."""
    told, met = [], []
    for name in (PAPER, TIGHT):
        case = results.case(name)
        first, last, most = drift(case.model, case.run("penalty"))
        met.append(max(abs(first), abs(last)) < 0.05 * most)
        told.append(
            f"{number(first, unit='m')} in the first and {number(last, unit='m')} in the last fifth of the "
            "run, "
            f"beside an oscillation of {number(most, unit='m')}"
        )
    return Claim(
        "The penalty does not drift …",
        f"Mean of φ {told[0]}; at a strict tolerance {told[1]}.",
        **paper_and_strict(*met),
        otherwise="its mean moves",
    )


def baseline_drift(results: Results) -> Claim:
    """Judges '... while the baseline one does'."""
    told, met = [], []
    for name in (PAPER, TIGHT):
        case = results.case(name)
        first, last, _ = drift(case.model, case.run("baseline"))
        most = case.number("present", "max_phi")
        met.append(abs(last) > 2 * abs(first) and abs(last) > 5 * max(most, NEWTON_TOLERANCE))
        told.append(
            f"{number(first, unit='m')} in the first and {number(last, unit='m')} in the last fifth of the "
            "run, "
            f"while ‘present’ stays within {number(most, unit='m')}"
        )
    return Claim(
        "… while ‘baseline’ does.",
        f"Mean of φ {told[0]}; at a strict tolerance {told[1]}.",
        **paper_and_strict(*met),
        otherwise="its mean hardly moves",
    )


def oscillation(results: Results) -> Claim:
    """Judges 'the penalty case oscillates significantly about the expected solution'."""
    cases = results.case(PAPER), results.case(TIGHT)
    rates = [[largest(c.run(m), "theta_rate", SETTLED) for m in ("penalty", "present")] for c in cases]
    most = [c.number("penalty", "max_phi") for c in cases]
    told = [
        f"pitch rate up to {number(one[0])} against {number(one[1], unit='rad/s')}, φ up to "
        f"{number(phi, unit='m')}"
        for one, phi in zip(rates, most, strict=True)
    ]
    return Claim(
        "The penalty oscillates significantly about the expected solution.",
        f"At the paper’s tolerance {told[0]}; at a strict one {told[1]}.",
        **paper_and_strict(*(one[0] > 2 * one[1] for one in rates)),
        otherwise="the rate of pitch hardly differs",
        remark="the loose tolerance feeds the oscillation",
    )


def unloaded(results: Results) -> Claim:
    """Judges 'the pitch link is essentially unloaded'."""
    told, met = [], []
    for name in (PAPER, TIGHT):
        case = results.case(name)
        force = {m: largest(case.run(m), "link_force", SETTLED) for m in ("present", "baseline", "penalty")}
        start = largest(case.run("present"), "link_force")
        met.append(max(force["present"], force["baseline"]) < NOTHING * start)
        told.append(
            f"{number(force['present'])} (‘present’), {number(force['baseline'])} (baseline) and "
            f"{number(force['penalty'], unit='N')} (penalty), {number(start, unit='N')} at the start"
        )
    return Claim(
        "With a constraint the pitch link is essentially unloaded …",
        f"Largest force at the written points after {SETTLED:g} s: {told[0]}; at a strict tolerance "
        f"{told[1]}.",
        **paper_and_strict(*met),
        otherwise="it carries a force",
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
        strict=(Held("at a strict tolerance", order == 2),),
        otherwise="the nonlinear kinematics give a third harmonic: the link is vertical at rest, so that θ "
        "is an "
        "odd function of β",
    )


def multiplier(results: Results) -> Claim:
    """Judges 'the multiplier mu is essentially zero', and its use."""
    told, met = [], []
    for name in (PAPER, TIGHT):
        case = results.case(name)
        run = case.run("present")
        mu = largest(run, "mu")
        # mu moves the pitch rate by A_theta mu, and A_theta is y_theta at rest.
        moved, rate = case.model["y_theta"] * mu, largest(run, "theta_rate")
        left = [case.number(m, "max_phidot") for m in ("baseline", "present")]
        met.append(moved < 1e-4 * rate and left[1] < NOTHING * left[0])
        told.append(
            f"|μ| up to {number(mu, unit='1/(m s)')}: {number(moved, unit='rad/s')} of a pitch rate of "
            f"{number(rate, unit='rad/s')}; |dφ/dt| up to {number(left[0])} without (baseline), "
            f"{number(left[1], unit='m/s')} with it"
        )
    return Claim(
        "The multiplier μ is essentially zero, yet instrumental in eliminating the drift.",
        f"{told[0]}. At a strict tolerance {told[1]}.",
        **paper_and_strict(*met),
        otherwise="it is not small, or it does not help",
    )


def soft_frequency(results: Results) -> Claim:
    """Judges 'although oscillating at nearly half the frequency'."""
    told, met = [], []
    for soft, stiff in ((SOFT, PAPER), (f"{SOFT}_tight", TIGHT)):
        cases = results.case(soft), results.case(stiff)
        found = [dominant_frequency(c.model, c.run("penalty")) / c.model["omega"] for c in cases]
        met.append(abs(found[0] / found[1] - 0.5) < ABOUT)
        told.append(
            f"{number(found[0], 3)} Ω instead of {number(found[1], 3)} Ω, {number(found[0] / found[1])} times"
        )
    return Claim(
        "A control system of 5.5 Ω oscillates at nearly half the frequency …",
        f"{told[0]}; at a strict tolerance {told[1]}.",
        **paper_and_strict(*met),
        otherwise="not near half",
    )


def soft_rates(results: Results) -> Claim:
    """Judges 'the angular velocity oscillations can be much less pronounced'."""
    told, met = [], []
    for soft, stiff in ((SOFT, PAPER), (f"{SOFT}_tight", TIGHT)):
        rates = [largest(results.case(c).run("penalty"), "theta_rate") for c in (soft, stiff)]
        motion = largest(results.case(stiff).run("present"), "theta_rate")
        met.append(rates[0] - motion < 0.5 * (rates[1] - motion))
        told.append(
            f"{number(rates[0])} instead of {number(rates[1], unit='rad/s')}, of which "
            f"{number(motion, unit='rad/s')} is the motion itself"
        )
    return Claim(
        "… with angular velocity oscillations that are much less pronounced …",
        f"Pitch rate up to {told[0]}; at a strict tolerance {told[1]}.",
        **paper_and_strict(*met),
        otherwise="more than half of them is left",
    )


def soft_violation(results: Results) -> Claim:
    """Judges 'at the cost of a much larger violation of the constraint'."""
    loose, tight = (
        [results.case(f"{name}{suffix}").number("penalty", "max_phi") for name in (SOFT, PAPER)]
        for suffix in ("", "_tight")
    )
    met = [pair[0] > 2 * pair[1] for pair in (loose, tight)]
    return Claim(
        "… but at the cost of a much larger violation of the constraint.",
        f"|φ| up to {number(loose[0])} instead of {number(loose[1], unit='m')}; with a relative tolerance of "
        f"10⁻⁶ {number(tight[0])} instead of {number(tight[1], unit='m')}.",
        **paper_and_strict(*met),
        otherwise="it is not larger",
    )


def flap_amplitude(results: Results) -> Claim:
    """Compares the flap with the forced motion of Eq. (30a), whose damping balances the resonance."""
    told, met = [], []
    for name, near in ((PAPER, 1e-2), (TIGHT, 1e-3)):
        case = results.case(name)
        model = case.model
        off_resonance, damping = model["nu_beta_squared"] - 1, model["gamma"] / 16
        exact = FLAP_MOMENT / (model["i_b"] * model["omega"] ** 2 * math.hypot(off_resonance, damping))
        found = float(harmonics(model, case.run("present"), "beta")[0])
        met.append(abs(found / exact - 1) < near)
        told.append(f"{number(found, 5)} ({percent(found / exact - 1)})")
    return Claim(
        "Closed form: damping balances the resonance at a flap of M/(I_b Ω²) / √((ν_β² − 1)² + (γ/16)²) = "
        f"{number(exact, 4, 'rad')}.",
        f"Once per revolution after {SETTLED:g} s {told[0]}; at a strict tolerance {told[1]}.",
        **paper_and_strict(*met),
        otherwise="another amplitude",
    )


def implicit_steps(results: Results) -> Claim:
    """Compares implicit steps with a control system far stiffer than the paper's and with the constraint."""
    case = results.case(RIGID)
    ratio = case.model["k_c"] / results.case(PAPER).model["k_c"]
    stiff, constrained = case.steps("penalty"), case.steps("present")
    left = case.number("penalty", "max_phi")
    met = abs(stiff / constrained - 1) <= AS_MANY and left < 1e-3 * case.model["length"]
    return Claim(
        "Implicit steps do not depend on the stiffness of the control system, which tends to the constraint.",
        f"{count(round(ratio))} times K_c by Radau IIA at a tolerance of 10⁻⁶: {count(stiff)} steps, "
        f"and {count(constrained)} with the constraint; |φ| up to {number(left, unit='m')}.",
        strict=once(met),
        otherwise="more steps, or another motion",
    )


F10, F11, F12 = (f"helicopter_figure{i}" for i in (10, 11, 12))
# By the figures that they are read from.
CLAIMS = (
    Row(constraint_steps, F10),
    Row(penalty_steps, F10),
    Row(comparable, F10),
    Row(stiffer, F10),
    Row(soft_frequency, F10),
    Row(soft_rates, F10),
    Row(soft_violation, F11),
    Row(no_drift, F11),
    Row(baseline_drift, F11),
    Row(oscillation, F11),
    Row(unloaded, F12),
    Row(second_harmonic, F12),
    Row(multiplier, F12),
)
CHECKS = (Row(flap_amplitude), Row(implicit_steps, cases=(RIGID,)))
