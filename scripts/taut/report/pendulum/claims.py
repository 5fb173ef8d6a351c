"""What the paper says about the pendulum (Sect. 4.1) and what taut gives, row by row."""

from taut.errors import TautError
from taut.formats import count, listed, number, percent
from taut.report.document import Claim, Verdict
from taut.report.judgment import ABOUT, LOOSE, NEWTON_TOLERANCE, TIGHT, either
from taut.report.pendulum.claims_energy import (
    only_present,
    reduction,
    small_energy_change,
    tightening,
    unlike_the_others,
)
from taut.report.pendulum.measures import MAX_TENSION, PERIOD, end_distance, period, tension_error
from taut.results import Results


def pendulum_claims(results: Results) -> tuple[Claim, ...]:
    """Returns every statement of Sect. 4.1 that runs can confirm or refute, then the closed forms."""
    return (
        *larger_gains(results),
        step_count(results, LOOSE, 200),
        step_count(results, TIGHT, 850),
        loose_braun_goldfarb(results),
        tight_braun_goldfarb(results),
        closer_to_present(results),
        compliance(results),
        small_energy_change(results),
        reduction(results),
        unlike_the_others(results),
        only_present(results),
        tightening(results, "baseline"),
        tightening(results, "baumgarte"),
        tightening(results, "present"),
        closed_period(results),
        closed_tension(results),
    )


def step_count(results: Results, case: str, paper: int) -> Claim:
    """Judges 'this required about N time steps', Braun and Goldfarb excepted."""
    methods = ("baseline", "present", "baumgarte")
    signed, honest = ([results.case(name).steps(m) for m in methods] for name in (case, f"{case}_standard"))
    near = [all(abs(n - paper) <= ABOUT * paper for n in steps) for steps in (signed, honest)]
    decision, because = either(*near)
    return Claim(
        f"About {count(paper)} time steps with the {'looser' if case == LOOSE else 'tighter'} tolerance.",
        f"{', '.join(map(count, signed))} (baseline, present, Baumgarte); with an honest error test "
        f"{', '.join(map(count, honest))}.",
        decision,
        because if decision is not Verdict.NO else f"off by more than {percent(ABOUT)}",
    )


def loose_braun_goldfarb(results: Results) -> Claim:
    """Judges 'it behaves much like Baumgarte's' at the loose tolerance."""
    case, other = results.case(LOOSE), results.case("options1")
    ours, theirs, finer = (
        case.steps("braun-goldfarb"),
        case.steps("baumgarte"),
        other.steps("braun-goldfarb-0.05"),
    )
    errors = [case.number(m, "max_phi") for m in ("braun-goldfarb", "baumgarte")]
    near = ours <= 1.25 * theirs and errors[0] <= 10 * errors[1]
    return Claim(
        "Loose tolerance: Braun and Goldfarb’s method behaves much like Baumgarte’s.",
        f"{ours} against {theirs} steps and a length error up to {number(errors[0], unit='m')} against "
        f"{number(errors[1], unit='m')} with dt = 0.1 s; {finer} steps with dt = 0.05 s.",
        Verdict.CONDITION if near else Verdict.NO,
        "with dt = 0.1 s, which the paper does not state" if near else "more steps or a larger error by far",
    )


def tight_braun_goldfarb(results: Results) -> Claim:
    """Judges 'at the cost of nearly twice the time steps'."""
    case = results.case(TIGHT)
    usual = sum(case.steps(m) for m in ("baseline", "present", "baumgarte")) / 3
    coarse, fine = case.steps("braun-goldfarb"), results.case("options2").steps("braun-goldfarb-0.05")
    twice = [(1.0 - ABOUT) * 2.0 * usual <= steps <= 2.0 * usual for steps in (coarse, fine)]
    if all(twice):
        decision, because = Verdict.YES, ""
    elif any(twice) or coarse < 2.0 * usual < fine:
        decision, because = Verdict.CONDITION, "with a dt between 0.05 and 0.1 s; the paper does not state it"
    else:
        decision, because = Verdict.NO, "no dt from 0.05 to 0.1 s comes near"
    return Claim(
        "Tight tolerance: Braun and Goldfarb’s method takes nearly twice the time steps.",
        f"{count(coarse)} with dt = 0.1 s and {count(fine)} with dt = 0.05 s: {number(coarse / usual)} and "
        f"{number(fine / usual)} times the {count(round(usual))} of the others on average.",
        decision,
        because,
    )


def closer_to_present(results: Results) -> Claim:
    """Judges 'the solution is much closer to that of the proposed method' when the tolerance is tightened."""
    runs = {
        case: {m: results.case(case).run(m) for m in ("present", "braun-goldfarb")} for case in (LOOSE, TIGHT)
    }
    loose, tight = (end_distance(pair["present"], pair["braun-goldfarb"]) for pair in runs.values())
    met = tight < 0.1 * loose
    return Claim(
        "Tightened, Braun and Goldfarb’s solution is much closer to the proposed one.",
        f"{number(tight, unit='m')} apart after 10 s; {number(loose, unit='m')} with the loose tolerance.",
        Verdict.YES if met else Verdict.NO,
        "" if met else "not even ten times closer",
    )


def compliance(results: Results) -> Claim:
    """Judges 'complies with the constraint with the accuracy of the inner loop (1e-12)'."""
    worst = [results.case(case).number("present", "max_phi") for case in (LOOSE, TIGHT)]
    speed = max(results.case(case).number("present", "max_phidot") for case in (LOOSE, TIGHT))
    met = max(worst) <= NEWTON_TOLERANCE
    return Claim(
        "The proposed approach complies with the constraint with the accuracy of the inner loop, 10⁻¹².",
        f"|φ| up to {number(worst[0], unit='m')} (loose) and {number(worst[1], unit='m')} (tight), "
        f"|dφ/dt| up to {number(speed, unit='m/s')}.",
        Verdict.YES if met else Verdict.NO,
        "" if met else "a step ends above 10⁻¹² m",
    )


def larger_gains(results: Results) -> tuple[Claim, ...]:
    """Judges what larger gains do to Baumgarte's method, if there is a case 'gains'."""
    if not results.has("gains"):
        return ()
    case = results.case("gains")
    labels = sorted((m for m in case.methods if m.startswith("baumgarte-")), key=_gain)
    if len(labels) < 2:
        return ()
    ends = labels[0], labels[-1]
    length, speed = ([case.number(m, key) for m in ends] for key in ("max_phi", "max_phidot"))
    steps = [case.steps(m) for m in ends]
    told = {
        "the position error does not shrink": length[1] < length[0],
        "the velocity error does not grow": speed[1] > speed[0],
        "the steps do not get shorter": steps[1] > steps[0],
    }
    failed = [text for text, met in told.items() if not met]
    return (
        Claim(
            "Larger gains in Baumgarte’s method: a smaller position error, a locally larger velocity error, "
            "much shorter steps.",
            f"Gains {_gain(ends[0]):g} → {_gain(ends[1]):g}: |φ| up to {number(length[0])} → "
            f"{number(length[1], unit='m')}, |dφ/dt| up to {number(speed[0])} → "
            f"{number(speed[1], unit='m/s')}, {count(steps[0])} → {count(steps[1])} steps.",
            Verdict.NO if failed else Verdict.YES,
            listed(failed),
        ),
    )


def _gain(label: str) -> float:
    """Returns the gain in a label such as 'baumgarte-10'."""
    try:
        return float(label.split("-", 1)[1])
    except ValueError:
        raise TautError(
            f"the label '{label}' of case 'gains' must end in the gain, as in baumgarte-10"
        ) from None


def closed_period(results: Results) -> Claim:
    """Compares the period with the closed form; the paper does not, but nothing else is known exactly."""
    found = [period(results.case(case).run("present")) for case in (LOOSE, TIGHT)]
    off = [abs(value / PERIOD - 1.0) for value in found]
    met = off[0] < 1e-3 and off[1] < 1e-6
    return Claim(
        f"Closed form: a period of 4 K(1/√2) √(L/g) = {number(PERIOD, 7, 's')}.",
        f"{number(found[1], 7, 's')} (tight, off by {percent(off[1])}), "
        f"{number(found[0], 5, 's')} (loose, off by {percent(off[0])}).",
        Verdict.YES if met else Verdict.NO,
        "" if met else f"off by {percent(max(off))}",
    )


def closed_tension(results: Results) -> Claim:
    """Compares the multiplier with the rod's tension in closed form."""
    loose, tight = (results.case(case).run("present") for case in (LOOSE, TIGHT))
    off = [tension_error(run) / MAX_TENSION for run in (loose, tight)]
    met = off[0] < 1e-3 and off[1] < 1e-6
    return Claim(
        "Closed form: the rod’s tension is 3 m g sin θ, θ the angle below the horizontal; "
        f"at most {number(MAX_TENSION, 4, 'N')}.",
        f"Largest λ at a step’s end {number(float(tight['lambda'].max()), 6, 'N')} (tight); it differs from "
        f"3 m g sin θ by up to {number(off[1] * MAX_TENSION, unit='N')} (tight) and "
        f"{number(off[0] * MAX_TENSION, unit='N')} (loose).",
        Verdict.YES if met else Verdict.NO,
        "" if met else f"off by {percent(max(off))}",
    )
