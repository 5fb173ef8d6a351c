"""What the paper says about the pendulum (Sect. 4.1) and what taut gives, row by row."""

from taut_report.data import Results
from taut_report.document import Claim, Verdict
from taut_report.formats import count, listed, number, percent
from taut_report.pendulum_measures import (
    ENERGY_SCALE,
    end_distance,
    energy_change,
    energy_per_period,
)
from taut_report.style import METHODS

LOOSE, TIGHT = "figure1", "figure2"
SIGNED = "with the signed error test of 2009 (option `odepkg-2009`)"
# 'About 200' and 'nearly twice' leave room; a tenth is what two digits of the paper can mean.
ABOUT = 0.10
NEWTON_TOLERANCE = 1e-12
# An energy error that grows or shrinks by less than this factor is 'not significantly affected' ...
SIMILAR = 3.0
# ... and one that shrinks by more than this 'essentially vanishes'.
VANISHES = 1e-3


def verdict(signed: bool, honest: bool) -> tuple[Verdict, str]:
    """Returns the verdict on a claim that is met or not under either error test, with the condition."""
    if signed and honest:
        return Verdict.YES, ""
    if signed:
        return Verdict.CONDITION, SIGNED
    if honest:
        return Verdict.CONDITION, "with an honest error test only"
    return Verdict.NO, ""


def step_count(results: Results, case: str, paper: int) -> Claim:
    """Judges 'this required about N time steps', Braun and Goldfarb excepted."""
    methods = ("baseline", "present", "baumgarte")
    steps = {name: [results.case(name).steps(m) for m in methods] for name in (case, f"{case}_standard")}
    met = [all(abs(n - paper) <= ABOUT * paper for n in counts) for counts in steps.values()]
    signed, honest = (", ".join(map(count, counts)) for counts in steps.values())
    tolerance = "looser" if case == LOOSE else "tighter"
    decision, because = verdict(*met)
    return (
        Claim(
            f"About {count(paper)} time steps with the {tolerance} tolerance.",
            f"{signed} (baseline, present, Baumgarte); with an honest error test {honest}.",
            decision,
            because or f"off by more than {percent(ABOUT)}",
        )
        if decision is not Verdict.YES
        else Claim(
            f"About {count(paper)} time steps with the {tolerance} tolerance.",
            f"{signed} (baseline, present, Baumgarte); with an honest error test {honest}.",
            decision,
        )
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
        f"The masses are {number(tight, unit='m')} apart after 10 s, {number(loose, unit='m')} with the loose tolerance.",
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


def small_energy_change(results: Results) -> Claim:
    """Judges 'the change is less than 0.01 % of 9.81 J per period'."""
    cases = (LOOSE, TIGHT, f"{LOOSE}_standard", f"{TIGHT}_standard")
    share = [abs(energy_per_period(results.case(c).run("present"))) / ENERGY_SCALE for c in cases]
    small = [value < 1e-4 for value in share]
    position = results.case("options1").run("state-position")
    alone = abs(energy_per_period(position)) / ENERGY_SCALE
    decision, because = verdict(all(small[:2]), all(small[2:]))
    if decision is Verdict.CONDITION and alone >= 1e-4:
        because += f", position and velocity replaced; {percent(alone)} with the position alone"
    return Claim(
        f"The energy changes by less than 0.01 % of {number(ENERGY_SCALE, 3, 'J')} per period.",
        f"‘Present’, worst period: {percent(share[0])} (loose), {percent(share[1])} (tight); "
        f"with an honest error test {percent(share[2])} and {percent(share[3])}.",
        decision,
        because or ("" if decision is Verdict.YES else "more than 0.01 %"),
    )


def reduction(results: Results) -> Claim:
    """Judges 'and happens to consist in a reduction'."""
    names = (LOOSE, TIGHT, f"{LOOSE}_standard", f"{TIGHT}_standard")
    change = [energy_change(results.case(name).run("present")) for name in names]
    decision, because = verdict(max(change[:2]) < 0, max(change[2:]) < 0)
    text = [number(value, unit="J") for value in change]
    return Claim(
        "… which happens to be a reduction …",
        f"{text[0]} (loose) and {text[1]} (tight) after 10 s; with an honest error test {text[2]} and {text[3]}.",
        decision,
        because or ("" if decision is Verdict.YES else "the energy grows"),
    )


def unlike_the_others(results: Results) -> Claim:
    """Judges '... as opposed to the other methods'."""
    others = ("baseline", "baumgarte", "braun-goldfarb")
    change = {m: energy_change(results.case(LOOSE).run(m)) for m in others}
    losing = [METHODS[m].label for m, value in change.items() if value <= 0]
    return Claim(
        "… as opposed to the other methods.",
        "; ".join(f"{METHODS[m].label} {number(value, unit='J')}" for m, value in change.items())
        + " (loose).",
        Verdict.NO if losing else Verdict.YES,
        f"{listed(losing)} {'loses' if len(losing) == 1 else 'lose'} energy too" if losing else "",
    )


def tightening(results: Results, method: str) -> Claim:
    """Judges what a tighter tolerance does to the energy error: nothing much, or it vanishes for 'present'."""
    pairs = ((LOOSE, TIGHT), (f"{LOOSE}_standard", f"{TIGHT}_standard"))
    errors = [[energy_change(results.case(case).run(method)) for case in pair] for pair in pairs]
    ratio = [abs(tight / loose) if loose else 0.0 for loose, tight in errors]
    vanishes = method == "present"
    met = [r < VANISHES if vanishes else 1 / SIMILAR <= r <= SIMILAR for r in ratio]
    effect = (
        "essentially vanishes with the proposed approach" if vanishes else "is not significantly affected"
    )
    text = [f"{number(loose)} → {number(tight, unit='J')}" for loose, tight in errors]
    decision, because = verdict(*met)
    if decision is Verdict.NO:
        because = "it does not vanish" if vanishes else "it changes by far more"
    return Claim(
        f"Tightening the tolerance, the error on the energy {effect}{'' if vanishes else f' ({METHODS[method].label})'}.",
        f"{text[0]}; with an honest error test {text[1]}.",
        decision,
        because,
    )


def only_present(results: Results) -> Claim:
    """Judges 'only the proposed stabilization essentially preserves the energy, if the tolerance is strict'."""
    methods = ("present", "baseline", "baumgarte", "braun-goldfarb")
    signed, honest = (
        {m: abs(energy_change(results.case(case).run(m))) for m in methods}
        for case in (TIGHT, f"{TIGHT}_standard")
    )
    keep = [[m for m, value in change.items() if value < 1e-6 * ENERGY_SCALE] for change in (signed, honest)]
    alone = [names == ["present"] for names in keep]
    decision, because = verdict(*alone)
    if decision is Verdict.NO and "present" in keep[0] and set(keep[0]) == {"present", "braun-goldfarb"}:
        decision, because = Verdict.CONDITION, f"{SIGNED}, and Braun–Goldfarb does as well"
    elif decision is Verdict.NO:
        because = f"preserving it: {listed([METHODS[m].label for m in keep[0]]) or 'none'}"
    text = ", ".join(f"{METHODS[m].label} {number(value)}" for m, value in signed.items())
    return Claim(
        "Only the proposed stabilization essentially preserves the energy, if the tolerance is strict enough.",
        f"Error in J: {text}; with an honest error test {number(max(honest.values()))} at most.",
        decision,
        because,
    )


def larger_gains(results: Results) -> list[Claim]:
    """Judges what larger gains do to Baumgarte's method, if runs with labels such as 'baumgarte-10' are there."""
    case = results.case("options2")
    gains = sorted(float(m.split("-")[1]) for m in case.methods if m.startswith("baumgarte-"))
    if not gains:
        return []
    label = f"baumgarte-{gains[-1]:g}"
    low, high = results.case(TIGHT), case
    values = [
        [c.number(m, key) for c, m in ((low, "baumgarte"), (high, label))]
        for key in ("max_phi", "max_phidot")
    ]
    steps = [low.steps("baumgarte"), high.steps(label)]
    smaller, faster, longer = values[0][1] < values[0][0], values[1][1] > values[1][0], steps[1] > steps[0]
    failed = [
        text
        for text, met in (
            ("the length error does not shrink", smaller),
            ("the velocity error does not grow", faster),
            ("the steps do not get shorter", longer),
        )
        if not met
    ]
    return [
        Claim(
            "Larger gains of Baumgarte’s method: a smaller position error, a locally larger velocity error, shorter steps.",
            f"Gains 2 → {gains[-1]:g}: |φ| {number(values[0][0])} → {number(values[0][1], unit='m')}, |dφ/dt| "
            f"{number(values[1][0])} → {number(values[1][1], unit='m/s')}, {count(steps[0])} → {count(steps[1])} steps.",
            Verdict.NO if failed else Verdict.YES,
            listed(failed),
        )
    ]
