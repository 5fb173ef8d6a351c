"""What the paper says about the swing (Sect. 4.2) and what taut gives: the event and the beam of elements."""

from collections.abc import Callable

import numpy as np

from taut.formats import count, listed, number, percent
from taut.report.document import Claim, Verdict
from taut.report.judgment import ABOUT, NEWTON_TOLERANCE, verdict
from taut.report.swing.claims_modal import MODAL_CLAIMS
from taut.report.swing.measures import (
    BEFORE,
    MARKERS,
    TABLE_1,
    apart,
    distances,
    energy_kept,
    events,
    highest_frequency,
    mode_shape,
    modes,
    peak_tension,
    reference,
    static_shape,
    violations,
)
from taut.results import REACHED_END, Results

# What cannot be told from the paper's figures.
NEGLIGIBLE = 1e-6
# 16 elements beyond the event, written often; the paper has no such case.
EVENT = "mesh16_event"
SLICE = "with the rotary inertia of slices of beam, which keeps the highest frequency low"


def swing_claims(results: Results) -> tuple[Claim, ...]:
    """Returns the statements of Sects. 4.2, 3.4 and 5 whose cases have been run."""
    return tuple(judge(results) for cases, judge in CLAIMS if all(map(results.has, cases)))


def frequencies(results: Results) -> Claim:
    """Judges Table 1."""
    found = [frequency for _, frequency in modes(results)]
    printed = [row[-1] for row in TABLE_1]
    # As many decimals as the paper prints.
    same = [
        abs(f - float(text)) <= 0.5001 * 10.0 ** -len(text.partition(".")[2])
        for f, text in zip(found, printed, strict=True)
    ]
    wrong = [row[0].lower() for row, met in zip(TABLE_1, same, strict=True) if not met]
    return Claim(
        f"Table 1: {', '.join(printed[:3])} and {printed[3]} Hz.",
        f"{', '.join(number(f, 4) for f in found[:3])} and {number(found[3], 4, 'Hz')}; 40 elements, shear "
        "stiffness corrected, rotary inertia of slices.",
        *verdict(not wrong, f"other digits: {listed(wrong)}"),
    )


def shapes(results: Results) -> Claim:
    """Judges 'essentially a triangle' and 'basically the cubic'."""
    found = modes(results)
    off = []
    for i, column in ((3, "u_x"), (0, "u_y")):
        if found[i][0]:
            x, u = mode_shape(results, found[i][0], column)
            off.append(float(np.abs(u - static_shape(x, TABLE_1[i][1])).max()))
        else:
            off.append(np.inf)
    return Claim(
        "The axial mode is essentially a triangle, the first symmetric bending mode basically the cubic of a "
        "static load at mid-span.",
        f"They differ by at most {percent(off[0])} and {percent(off[1])} of their largest displacement.",
        *verdict(max(off) < 0.02, "they differ"),
    )


def alignment(results: Results) -> Claim:
    """Judges 'between 0.6 and 0.7 s, the first link and the beam are nearly aligned'."""
    found = {name: events(results, name) for name in ("1b", EVENT, "2b_tight")}
    texts, times = [], []
    for name, kind in (("1b", "4 elements"), (EVENT, "16 elements"), ("2b_tight", "modal")):
        if "link-AC" in found[name]:
            times.append(found[name]["link-AC"])
            chord = found[name].get("link-AE")
            times += [chord] if chord else []
            then = f"with the chord A–E at {number(chord, 4, 's')}" if chord else "never with the chord A–E"
            texts.append(f"with A–C at {number(found[name]['link-AC'], 4, 's')}, {then} ({kind}, {name})")
    met = bool(times) and min(times) >= 0.6 and max(times) <= 0.7
    return Claim(
        "Between 0.6 and 0.7 s the first link and the beam are nearly aligned.",
        f"Link 1 in line {'; '.join(texts)}." if texts else "No run tells.",
        *verdict(met, "outside of that interval" if texts else "link 1 never comes in line"),
    )


def impulse(results: Results) -> Claim:
    """Judges 'the leftmost end of the beam receives a nearly impulsive excitation'."""
    told, grown = [], []
    for name in ("1b", EVENT, "2b_tight"):
        if results.has(name):
            run = results.case(name).run("present")
            before, (most, at) = peak_tension(run, end=BEFORE)[0], peak_tension(run, BEFORE, 0.66)
            grown.append(most / before)
            told.append(f"{number(before)} → {number(most, 3, 'N')} at {number(at, 4, 's')} ({name})")
    analysis = reference(4)
    other = int(np.argmax(np.abs(analysis["T1"])))
    return Claim(
        "The leftmost end of the beam receives a nearly impulsive excitation.",
        f"Largest force of link 1 up to {BEFORE:g} s → from there to 0.66 s: {'; '.join(told)}. Analysis "
        f"(0), written every 1 ms: {number(abs(float(analysis['T1'][other])), 3, 'N')} at "
        f"{number(float(analysis['t'][other]), 3, 's')}.",
        *verdict(min(grown) > 20, "the force hardly grows"),
    )


def regular_part(_: Results) -> Claim:
    """Judges 'the regular one, ... that is insensitive to the discretization', on the reference curves."""
    times, distance = distances(reference(2), reference(4))
    most = float(distance[times <= BEFORE].max())
    return Claim(
        "Analysis (0): the motion before the nearly impulsive loading is insensitive to the discretization …",
        f"With 2 and 4 three-node elements the markers are at most {number(most, unit='m')} apart up to "
        f"{BEFORE:g} s.",
        *verdict(most < 1e-3, "they differ"),
    )


def chaotic_part(_: Results) -> Claim:
    """Judges 'mesh refinement leads to different behavior of B and D; A and E are minimally affected'."""
    times, distance = distances(reference(2), reference(4))
    after = {m: float(distance[times > BEFORE, i].max()) for i, m in enumerate(MARKERS)}
    others = max(after[m] for m in "ACE")
    told = ", ".join(f"{m} {number(1e3 * value, unit='mm')}" for m, value in after.items())
    if others < 0.2 * min(after["B"], after["D"]):
        decision, because = Verdict.YES, ""
    elif others < min(after["B"], after["D"]):
        decision, because = (
            Verdict.CONDITION,
            "the wiggles are those of B and D; in size the other markers part as well",
        )
    else:
        decision, because = Verdict.NO, "A, C or E part farther than B or D"
    return Claim(
        "… and after it refinement leads to different behavior of B and D; A and E are minimally affected, C "
        "is regularized by its mass.",
        f"After {BEFORE:g} s they come apart by {told}.",
        decision,
        because,
    )


def beam_step_count(results: Results) -> Claim:
    """Judges Table 2's 69,033 steps to 0.69 s."""
    case = results.case("1b")
    steps, t = case.steps("present"), case.number("present", "t_end")
    met = abs(steps / t / (69033 / 0.69) - 1) < 0.01
    free = ""
    if results.has("1b_uncapped"):
        free = f" {count(results.case('1b_uncapped').steps('present'))} without the cap."
    return Claim(
        "Finite elements: 69,033 steps to 0.69 s.",
        f"{count(steps)} to {number(t, 2, 's')} with steps of at most 10⁻⁵ s.{free}",
        Verdict.CONDITION if met else Verdict.NO,
        "with a cap of 10⁻⁵ s on the step, which the paper does not state" if met else "far from it",
    )


def same_steps(results: Results) -> Claim:
    """Judges 'the proposed algorithm requires exactly the same number of time steps'."""
    steps = [results.case("1a").steps("baseline"), results.case("1b").steps("present")]
    free: list[int] = []
    if results.has("1a_uncapped") and results.has("1b_uncapped"):
        free = [results.case("1a_uncapped").steps("baseline"), results.case("1b_uncapped").steps("present")]
    text = f"{count(steps[0])} (1a) and {count(steps[1])} (1b)"
    if free:
        text += f"; without the cap {count(free[0])} and {count(free[1])}"
    if steps[0] != steps[1]:
        decision, because = Verdict.NO, "the numbers differ"
    elif free and free[0] != free[1]:
        decision, because = Verdict.CONDITION, "with the cap, at which every step is the same"
    else:
        decision, because = Verdict.YES, ""
    return Claim(
        "Finite elements: ‘present’ takes exactly the same number of steps as ‘baseline’ …",
        f"{text}.",
        decision,
        because,
    )


def same_motion(results: Results) -> Claim:
    """Judges 'the error between the baseline and the present analysis is negligible'."""
    most = apart(results.case("1a").run("baseline"), results.case("1b").run("present"))
    return Claim(
        "… and the error between the two analyses is negligible.",
        f"The markers are at most {number(most, unit='m')} apart.",
        *verdict(most < NEGLIGIBLE, "they part"),
    )


def beam_drift(results: Results) -> Claim:
    """Judges 'yields enough accuracy to limit the drift until stiffness actually comes into play'."""
    run, case = results.case("1a").run("baseline"), results.case("1b")
    length = [violations(run, "phi", end) for end in (0.65, np.inf)]
    rate = [violations(run, "phidot", end) for end in (0.65, np.inf)]
    if length[0] > NEWTON_TOLERANCE:
        decision, because = Verdict.NO, "it drifts before"
    elif max(length[1] / length[0], rate[1] / rate[0]) < 10:
        decision, because = Verdict.NO, "nothing changes there"
    else:
        decision, because = Verdict.YES, ""
    return Claim(
        "The time step that stability asks for limits the drift until stiffness comes into play, at about "
        "0.67 s (Figure 6).",
        f"Baseline: |φ| up to {number(length[0])} before 0.65 s, {number(length[1], unit='m')} in the whole "
        f"run, |dφ/dt| {number(rate[0])} and {number(rate[1], unit='m/s')}; ‘present’ "
        f"{number(case.number('present', 'max_phi'), unit='m')} and "
        f"{number(case.number('present', 'max_phidot'), unit='m/s')}.",
        decision,
        because,
    )


def goes_on(results: Results) -> Claim:
    """Judges 'the FE models could not converge after the nearly-impulsive event'."""
    names = [n for n in ("1b", "1b_uncapped", "1b_long") if results.has(n)]
    told, fine = [], []
    for name in names:
        case = results.case(name)
        run, status, t = case.run("present"), case.text("present", "status"), case.number("present", "t_end")
        # What the load has put in stays, or the run is wrong.
        put_in, left = energy_kept(run)
        step = [float(np.median(run["h"][p])) for p in (run["t"] < BEFORE, run["t"] > min(0.65, t - 1e-9))]
        kept = abs(left / put_in - 1) < ABOUT
        fine.append(status == REACHED_END and t > 0.68 and kept and step[1] > 0.1 * step[0])
        told.append(
            f"{name}: {status} at {number(t, 3, 's')}, steps of {number(step[0])} before {BEFORE:g} s and "
            f"{number(step[1], unit='s')} after the event, energy {number(put_in, 3)} → "
            f"{number(left, 3, 'J')}"
        )
    if fine[-1]:
        decision, because = Verdict.NO, f"it goes on, {SLICE}"
    elif any(fine):
        decision, because = Verdict.CONDITION, "without a cap on the step or a tight tolerance"
    else:
        decision, because = Verdict.YES, ""
    return Claim(
        "The finite element models could not converge after the event at about 0.65 s without excessively "
        "reducing the time step.",
        f"{'; '.join(told)}.",
        decision,
        because,
    )


def beam_mean_step(results: Results) -> Claim:
    """Judges 'the order of magnitude of the average time step drops to 1e-5'."""
    case = results.case("1b_uncapped")
    mean = case.number("present", "t_end") / case.steps("present")
    return Claim(
        "Finite elements: the average time step is of the order of 10⁻⁵ s.",
        f"{number(mean, unit='s')} without a cap.",
        *verdict(10**-5.5 < mean < 10**-4.5, "another order of magnitude"),
    )


def free_frequency(results: Results) -> Claim:
    """Judges 'the largest natural frequency of the free-free model is of the order of 1e4 Hz'."""
    highest = highest_frequency(results) or np.nan
    return Claim(
        "The largest natural frequency of the free-free model of 4 elements is of the order of 10⁴ Hz.",
        f"{number(highest, 3, 'Hz')}.",
        *verdict(10**3.5 < highest < 10**4.5, "another order of magnitude"),
    )


def fully_implicit(_: Results) -> Claim:
    """States what taut does not have."""
    return Claim(
        "Sect. 3.4: constraints can be added to problems in the fully implicit form g(y, ẏ, t) = 0, Eq. "
        "(18), in an external loop.",
        "Taut integrates explicitly; Eqs (19) are there as the force form.",
        Verdict.NOT_YET,
        "there is no implicit integration",
    )


CLAIMS: tuple[tuple[tuple[str, ...], Callable[[Results], Claim]], ...] = (
    (("table1",), frequencies),
    (("table1",), shapes),
    (("1b",), alignment),
    (("1b",), impulse),
    ((), regular_part),
    ((), chaotic_part),
    (("1b",), beam_step_count),
    (("1a", "1b"), same_steps),
    (("1a", "1b"), same_motion),
    (("1a", "1b"), beam_drift),
    (("1b",), goes_on),
    (("1b_uncapped",), beam_mean_step),
    (("free_free",), free_frequency),
    *MODAL_CLAIMS,
    ((), fully_implicit),
)
