"""What the paper says about the pendulum (Sect. 4.1) and what taut gives, row by row."""

from functools import partial

from taut.errors import TautError
from taut.formats import count, listed, number, percent
from taut.report.document import Claim, Held
from taut.report.judgment import ABOUT, LOOSE, NEWTON_TOLERANCE, SIMILAR, TIGHT, Row, signed_and_honest
from taut.report.pendulum.claims_energy import (
    only_present,
    reduction,
    small_energy_change,
    tightening,
    unlike_the_others,
)
from taut.report.pendulum.measures import (
    MAX_TENSION,
    PERIOD,
    end_distance,
    energy_change,
    period,
    tension_error,
)
from taut.results import Results


def step_count(results: Results, case: str, paper: int) -> Claim:
    """Judges 'this required about N time steps', Braun and Goldfarb excepted."""
    methods = ("baseline", "present", "baumgarte")
    signed, honest = ([results.case(name).steps(m) for m in methods] for name in (case, f"{case}_standard"))
    near = [all(abs(n - paper) <= ABOUT * paper for n in steps) for steps in (signed, honest)]
    return Claim(
        f"About {count(paper)} time steps with the {'looser' if case == LOOSE else 'tighter'} tolerance.",
        f"{', '.join(map(count, signed))} (baseline, present, Baumgarte); with an honest error test "
        f"{', '.join(map(count, honest))}.",
        **signed_and_honest(*near),
        otherwise=f"off by more than {percent(ABOUT)}",
    )


# The dt of Braun and Goldfarb's method: the cases that have it, and what it is called there.
STEPS_OF_DT = (("0.1", "{0}", "braun-goldfarb"), ("0.05", "options{1}", "braun-goldfarb-0.05"))


def loose_braun_goldfarb(results: Results) -> Claim:
    """Judges 'it behaves much like Baumgarte's' at the loose tolerance, by steps, errors and energy."""
    case = results.case(LOOSE)
    theirs = (
        case.steps("baumgarte"),
        case.number("baumgarte", "max_phi"),
        energy_change(case.run("baumgarte")),
    )
    held, told = [], []
    for dt, place, method in STEPS_OF_DT:
        other = results.case(place.format(LOOSE, 1))
        ours = other.steps(method), other.number(method, "max_phi"), energy_change(other.run(method))
        near = (
            ours[0] <= 1.25 * theirs[0]
            and ours[1] <= 10 * theirs[1]
            and abs(ours[2]) <= SIMILAR * abs(theirs[2])
        )
        held.append(Held(f"with dt = {dt} s, which the paper does not state", near))
        told.append(
            f"{ours[0]} steps, {number(ours[1], unit='m')} and {number(ours[2], unit='J', plus=True)} (dt = "
            f"{dt} s)"
        )
    return Claim(
        "Loose tolerance: Braun and Goldfarb’s method behaves much like Baumgarte’s.",
        f"Steps, error of the length, change of energy: {'; '.join(told)}; Baumgarte {theirs[0]} steps, "
        f"{number(theirs[1], unit='m')} and {number(theirs[2], unit='J', plus=True)}.",
        tuple(held),
        otherwise="steps, errors and energy are not alike with either dt",
    )


def tight_braun_goldfarb(results: Results) -> Claim:
    """Judges 'at the cost of nearly twice the time steps'."""
    case = results.case(TIGHT)
    usual = sum(case.steps(m) for m in ("baseline", "present", "baumgarte")) / 3
    coarse, fine = case.steps("braun-goldfarb"), results.case("options2").steps("braun-goldfarb-0.05")
    twice = [(1.0 - ABOUT) * 2.0 * usual <= steps <= 2.0 * usual for steps in (coarse, fine)]
    between = coarse < 2.0 * usual < fine
    return Claim(
        "Tight tolerance: Braun and Goldfarb’s method takes nearly twice the time steps.",
        f"{count(coarse)} with dt = 0.1 s and {count(fine)} with dt = 0.05 s: {number(coarse / usual)} and "
        f"{number(fine / usual)} times the {count(round(usual))} of the others on average.",
        (
            Held("with dt = 0.1 s", twice[0]),
            Held("with dt = 0.05 s", twice[1]),
            Held("with a dt between 0.05 and 0.1 s, which the paper does not state", between or any(twice)),
        ),
        otherwise="no dt from 0.05 to 0.1 s comes near",
    )


def closer_to_present(results: Results) -> Claim:
    """Judges 'the solution is much closer to that of the proposed method' when the tolerance is tightened."""
    apart = []
    for pair in ((LOOSE, TIGHT), (f"{LOOSE}_standard", f"{TIGHT}_standard")):
        runs = [[results.case(case).run(m) for m in ("present", "braun-goldfarb")] for case in pair]
        apart.append([end_distance(*both) for both in runs])
    (loose, tight), honest = apart
    return Claim(
        "Tightened, Braun and Goldfarb’s solution is much closer to the proposed one.",
        f"{number(tight, unit='m')} apart after 10 s; {number(loose, unit='m')} with the loose tolerance. "
        "With an "
        f"honest error test {number(honest[1])} and {number(honest[0], unit='m')}.",
        **signed_and_honest(tight < 0.1 * loose, honest[1] < 0.1 * honest[0]),
        otherwise="not even ten times closer",
    )


def compliance(results: Results) -> Claim:
    """Judges 'complies with the constraint with the accuracy of the inner loop (1e-12)'."""
    cases = (LOOSE, TIGHT, f"{LOOSE}_standard", f"{TIGHT}_standard")
    worst, speed = (
        [results.case(c).number("present", key) for c in cases] for key in ("max_phi", "max_phidot")
    )
    return Claim(
        "The proposed approach complies with the constraint with the accuracy of the inner loop, 10⁻¹².",
        f"|φ| up to {number(worst[0], unit='m')} (loose) and {number(worst[1], unit='m')} (tight), "
        f"|dφ/dt| up to {number(max(speed[:2]), unit='m/s')}; with an honest error test |φ| up to "
        f"{number(max(worst[2:]), unit='m')}.",
        **signed_and_honest(max(worst[:2]) <= NEWTON_TOLERANCE, max(worst[2:]) <= NEWTON_TOLERANCE),
        otherwise="a step ends above 10⁻¹² m",
    )


def larger_gains(results: Results) -> Claim:
    """Judges what larger gains do to Baumgarte's method."""
    found = [_with_gains(results, name) for name in ("gains_figure1", "gains")]
    wrong = listed(list(dict.fromkeys(text for _, failed in found for text in failed)))
    return Claim(
        "Larger gains in Baumgarte’s method: a smaller position error, a locally larger velocity error, "
        "much shorter steps.",
        f"{found[0][0]} at Figure 1’s own setting; {found[1][0]} at a tolerance of 10⁻⁹ with an honest "
        "error test.",
        (Held("at Figure 1’s own setting", not found[0][1]),),
        (Held("at a tolerance of 10⁻⁹ with an honest error test", not found[1][1]),),
        otherwise=wrong,
        remark=f"at Figure 1’s own setting {listed(found[0][1])}" if found[0][1] and not found[1][1] else "",
    )


def _with_gains(results: Results, name: str) -> tuple[str, list[str]]:
    """Returns what the smallest and the largest gain of a case give, and what of the statement fails."""
    case = results.case(name)
    labels = sorted((m for m in case.methods if m.startswith("baumgarte-")), key=_gain)
    ends = labels[0], labels[-1]
    length, speed = ([case.number(m, key) for m in ends] for key in ("max_phi", "max_phidot"))
    steps = [case.steps(m) for m in ends]
    told = {
        "the position error does not shrink": length[1] < length[0],
        "the velocity error does not grow": speed[1] > speed[0],
        "the steps do not get shorter": steps[1] > steps[0],
    }
    text = (
        f"Gains {_gain(ends[0]):g} → {_gain(ends[1]):g}: |φ| up to {number(length[0])} → "
        f"{number(length[1], unit='m')}, |dφ/dt| up to {number(speed[0])} → {number(speed[1], unit='m/s')}, "
        f"{count(steps[0])} → {count(steps[1])} steps"
    )
    return text, [text for text, met in told.items() if not met]


def _gain(label: str) -> float:
    """Returns the gain in a label such as 'baumgarte-10'."""
    try:
        return float(label.split("-", 1)[1])
    except ValueError:
        raise TautError(
            f"the label '{label}' of a case of gains must end in the gain, as in baumgarte-10"
        ) from None


def closed_period(results: Results) -> Claim:
    """Compares the period with the closed form; the paper does not, but nothing else is known exactly."""
    found = [period(results.case(case).run("present")) for case in (LOOSE, TIGHT)]
    off = [abs(value / PERIOD - 1.0) for value in found]
    return Claim(
        f"Closed form: a period of 4 K(1/√2) √(L/g) = {number(PERIOD, 7, 's')}.",
        f"{number(found[1], 7, 's')} (tight, off by {percent(off[1])}), "
        f"{number(found[0], 5, 's')} (loose, off by {percent(off[0])}).",
        (Held("at the loose tolerance", off[0] < 1e-3),),
        (Held("at the tight tolerance", off[1] < 1e-6),),
        otherwise=f"off by {percent(max(off))}",
    )


def closed_tension(results: Results) -> Claim:
    """Compares the multiplier with the rod's tension in closed form."""
    loose, tight = (results.case(case).run("present") for case in (LOOSE, TIGHT))
    off = [tension_error(run) / MAX_TENSION for run in (loose, tight)]
    return Claim(
        "Closed form: the rod’s tension is 3 m g sin θ, θ the angle below the horizontal; "
        f"at most {number(MAX_TENSION, 4, 'N')}.",
        f"Largest λ at a step’s end {number(float(tight['lambda'].max()), 6, 'N')} (tight); it differs from "
        f"3 m g sin θ by up to {number(off[1] * MAX_TENSION, unit='N')} (tight) and "
        f"{number(off[0] * MAX_TENSION, unit='N')} (loose).",
        (Held("at the loose tolerance", off[0] < 1e-3),),
        (Held("at the tight tolerance", off[1] < 1e-6),),
        otherwise=f"off by {percent(max(off))}",
    )


F1, F2 = "pendulum_figure1", "pendulum_figure2"
# What belongs to Figure 1, then to Figure 2.
CLAIMS = (
    Row(partial(step_count, case=LOOSE, paper=200), F1),
    Row(larger_gains, F1, ("gains", "gains_figure1")),
    Row(loose_braun_goldfarb, F1),
    Row(small_energy_change, F1),
    Row(reduction, F1),
    Row(unlike_the_others, F1),
    Row(partial(step_count, case=TIGHT, paper=850), F2),
    Row(tight_braun_goldfarb, F2),
    Row(closer_to_present, F2),
    Row(compliance, F2),
    Row(only_present, F2),
    *(Row(partial(tightening, method=method), F2) for method in ("baseline", "baumgarte", "present")),
)
CHECKS = (Row(closed_period), Row(closed_tension))
