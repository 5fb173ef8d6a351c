"""What the paper says about the energy of the pendulum (Sect. 4.1) and what taut gives."""

from taut.formats import listed, number, percent
from taut.report.document import Claim, Verdict
from taut.report.judgment import LOOSE, SIGNED, SIMILAR, TIGHT, VANISHES, either
from taut.report.pendulum.measures import ENERGY_SCALE, energy_change, energy_per_period
from taut.results import Results
from taut.style import METHODS


def small_energy_change(results: Results) -> Claim:
    """Judges 'the change is less than 0.01 % of 9.81 J per period'."""
    cases = (LOOSE, TIGHT, f"{LOOSE}_standard", f"{TIGHT}_standard")
    share = [abs(energy_per_period(results.case(c).run("present"))) / ENERGY_SCALE for c in cases]
    small = [value < 1e-4 for value in share]
    position = results.case("options1").run("state-position")
    alone = abs(energy_per_period(position)) / ENERGY_SCALE
    decision, because = either(all(small[:2]), all(small[2:]))
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
    decision, because = either(max(change[:2]) < 0, max(change[2:]) < 0)
    text = [number(value, unit="J", plus=True) for value in change]
    return Claim(
        "… which happens to be a reduction …",
        f"{text[0]} (loose) and {text[1]} (tight) after 10 s; "
        f"with an honest error test {text[2]} and {text[3]}.",
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
        "; ".join(f"{METHODS[m].label} {number(value, unit='J', plus=True)}" for m, value in change.items())
        + " (loose).",
        Verdict.NO if losing else Verdict.YES,
        f"{listed(losing)} {'loses' if len(losing) == 1 else 'lose'} energy too" if losing else "",
    )


def only_present(results: Results) -> Claim:
    """Judges 'only the proposed stabilization results in essentially preserving the total energy'."""
    methods = ("present", "baseline", "baumgarte", "braun-goldfarb")
    signed, honest = (
        {m: abs(energy_change(results.case(case).run(m))) for m in methods}
        for case in (TIGHT, f"{TIGHT}_standard")
    )
    keep = [[m for m, value in change.items() if value < 1e-6 * ENERGY_SCALE] for change in (signed, honest)]
    alone = [names == ["present"] for names in keep]
    decision, because = either(*alone)
    if decision is Verdict.NO and "present" in keep[0] and set(keep[0]) == {"present", "braun-goldfarb"}:
        decision, because = Verdict.CONDITION, f"{SIGNED}, and Braun–Goldfarb does as well"
    elif decision is Verdict.NO:
        because = f"preserving it: {listed([METHODS[m].label for m in keep[0]]) or 'none'}"
    text = ", ".join(f"{METHODS[m].label} {number(value)}" for m, value in signed.items())
    return Claim(
        "Only the proposed stabilization essentially preserves the energy, provided the tolerance is strict "
        "enough.",
        f"Error in J: {text}; with an honest error test {number(max(honest.values()))} at most.",
        decision,
        because,
    )


def tightening(results: Results, method: str) -> Claim:
    """Judges what a tighter tolerance does to the energy error: not much, but for 'present' it vanishes."""
    pairs = ((LOOSE, TIGHT), (f"{LOOSE}_standard", f"{TIGHT}_standard"))
    errors = [[energy_change(results.case(case).run(method)) for case in pair] for pair in pairs]
    ratio = [abs(tight / loose) if loose else 0.0 for loose, tight in errors]
    vanishes = method == "present"
    met = [r < VANISHES if vanishes else 1 / SIMILAR <= r <= SIMILAR for r in ratio]
    effect = f"is not significantly affected ({METHODS[method].label})"
    if vanishes:
        effect = "essentially vanishes with the proposed approach"
    text = [f"{number(loose, plus=True)} → {number(tight, unit='J', plus=True)}" for loose, tight in errors]
    decision, because = either(*met)
    if decision is Verdict.NO:
        because = "it does not vanish" if vanishes else "it changes by far more"
    return Claim(
        f"Tightening the tolerance, the error on the energy {effect}.",
        f"{text[0]}; with an honest error test {text[1]}.",
        decision,
        because,
    )
