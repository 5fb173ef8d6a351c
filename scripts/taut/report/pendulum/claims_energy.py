"""What the paper says about the energy of the pendulum (Sect. 4.1) and what taut gives."""

from taut.formats import listed, number, percent
from taut.report.document import Claim
from taut.report.judgment import LOOSE, SIMILAR, TIGHT, VANISHES, signed_and_honest
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
    return Claim(
        f"The energy changes by less than 0.01 % of {number(ENERGY_SCALE, 3, 'J')} per period.",
        f"‘Present’, worst period: {percent(share[0])} (loose), {percent(share[1])} (tight); "
        f"with an honest error test {percent(share[2])} and {percent(share[3])}.",
        **signed_and_honest(all(small[:2]), all(small[2:])),
        otherwise="more than 0.01 %",
        remark=f"position and velocity replaced; {percent(alone)} with the position alone"
        if alone >= 1e-4
        else "",
    )


def reduction(results: Results) -> Claim:
    """Judges 'and happens to consist in a reduction'."""
    names = (LOOSE, TIGHT, f"{LOOSE}_standard", f"{TIGHT}_standard")
    change = [energy_change(results.case(name).run("present")) for name in names]
    text = [number(value, unit="J", plus=True) for value in change]
    return Claim(
        "… which happens to be a reduction …",
        f"{text[0]} (loose) and {text[1]} (tight) after 10 s; "
        f"with an honest error test {text[2]} and {text[3]}.",
        **signed_and_honest(max(change[:2]) < 0, max(change[2:]) < 0),
        otherwise="the energy grows",
    )


def unlike_the_others(results: Results) -> Claim:
    """Judges '... as opposed to the other methods'."""
    others = ("baseline", "baumgarte", "braun-goldfarb")
    change = [
        {m: energy_change(results.case(c).run(m)) for m in others} for c in (LOOSE, f"{LOOSE}_standard")
    ]
    losing = [METHODS[m].label for m, value in change[0].items() if value <= 0]
    texts = [
        "; ".join(f"{METHODS[m].label} {number(value, unit='J', plus=True)}" for m, value in one.items())
        for one in change
    ]
    return Claim(
        "… as opposed to the other methods.",
        f"{texts[0]} (loose); with an honest error test {texts[1]}.",
        **signed_and_honest(not losing, all(value > 0 for value in change[1].values())),
        otherwise=f"{listed(losing)} {'loses' if len(losing) == 1 else 'lose'} energy too",
    )


def only_present(results: Results) -> Claim:
    """Judges 'only the proposed stabilization results in essentially preserving the total energy'."""
    methods = ("present", "baseline", "baumgarte", "braun-goldfarb")
    signed, honest = (
        {m: abs(energy_change(results.case(case).run(m))) for m in methods}
        for case in (TIGHT, f"{TIGHT}_standard")
    )
    keep = [[m for m, value in change.items() if value < 1e-6 * ENERGY_SCALE] for change in (signed, honest)]
    text = ", ".join(f"{METHODS[m].label} {number(value)}" for m, value in signed.items())
    names = [listed([METHODS[m].label for m in one]) or "none" for one in keep]
    return Claim(
        "Only the proposed stabilization essentially preserves the energy, provided the tolerance is strict "
        "enough.",
        f"Error in J: {text}; with an honest error test {number(max(honest.values()))} at most.",
        **signed_and_honest(*(one == ["present"] for one in keep)),
        otherwise=f"it is preserved by {names[0]}; with an honest error test by {names[1]}",
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
    return Claim(
        f"Tightening the tolerance, the error on the energy {effect}.",
        f"{text[0]}; with an honest error test {text[1]}.",
        **signed_and_honest(*met),
        otherwise="it does not vanish" if vanishes else "it changes by far more",
    )
