"""What the paper says about the swing (Sect. 4.2) and what taut gives: the event and the beam of elements."""

from functools import cache

import numpy as np

from taut.formats import count, listed, number, percent
from taut.report.document import Claim, Held
from taut.report.judgment import ABOUT, NEWTON_TOLERANCE, Row, once
from taut.report.swing.claims_modal import MODAL_CLAIMS
from taut.report.swing.measures import (
    BEFORE,
    MARKERS,
    TABLE_1,
    analysis_0,
    apart,
    energy_kept,
    events,
    highest_frequency,
    mode_shape,
    modes,
    paths_apart,
    peak_tension,
    positions,
    reference,
    static_shape,
    violations,
)
from taut.results import REACHED_END, Results, Run

# What cannot be told from the paper's figures.
NEGLIGIBLE = 1e-6
# 16 elements beyond the event, written often; the paper has no such case.
EVENT = "mesh16_event"
# The models whose event is looked at.
MODELS = (("1b", "4 elements"), (EVENT, "16 elements"), ("2b_tight", "modal"))
# Implicit and explicit runs of one mesh may part by this before the event [m].
IMPLICIT_APART = 1e-4
CAPPED, UNCAPPED = "with a cap of 10⁻⁵ s on the step", "without a cap on the step"
SLICE = "with the rotary inertia of slices of beam, which keeps the highest frequency low"


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
        once(not wrong),
        otherwise=f"other digits: {listed(wrong)}",
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
        once(max(off) < 0.02),
        otherwise="they differ",
    )


def alignment(results: Results) -> Claim:
    """Judges 'between 0.6 and 0.7 s, the first link and the beam are nearly aligned'."""
    texts, held = [], []
    for name, kind in MODELS:
        found = events(results, name)
        if not results.has(name):
            continue
        times = [found[event] for event in ("link-AC", "link-AE") if event in found]
        held.append(Held(f"with {kind} ({name})", bool(times) and 0.6 <= min(times) and max(times) <= 0.7))
        if "link-AC" in found:
            chord = found.get("link-AE")
            then = f"with the chord A–E at {number(chord, 4, 's')}" if chord else "never with the chord A–E"
            texts.append(f"with A–C at {number(found['link-AC'], 4, 's')}, {then} ({kind}, {name})")
    return Claim(
        "Between 0.6 and 0.7 s the first link and the beam are nearly aligned.",
        f"Link 1 in line {'; '.join(texts)}." if texts else "No run tells.",
        tuple(held[:1]),
        tuple(held[1:]),
        otherwise="outside of that interval" if texts else "link 1 never comes in line",
    )


def impulse(results: Results) -> Claim:
    """Judges 'the leftmost end of the beam receives a nearly impulsive excitation'."""
    told, held = [], []
    for name, kind in MODELS:
        if results.has(name):
            run = results.case(name).run("present")
            before, (most, at) = peak_tension(run, end=BEFORE)[0], peak_tension(run, BEFORE, 0.66)
            held.append(Held(f"with {kind} ({name})", most > 20 * before))
            told.append(f"{number(before)} → {number(most, 3, 'N')} at {number(at, 4, 's')} ({name})")
    analysis = reference(4)
    other = int(np.argmax(np.abs(analysis["T1"])))
    return Claim(
        "The leftmost end of the beam receives a nearly impulsive excitation.",
        f"Largest force of link 1 at the written points up to {BEFORE:g} s → from there to 0.66 s: "
        f"{'; '.join(told)}. Analysis (0), written every 1 ms: "
        f"{number(abs(float(analysis['T1'][other])), 3, 'N')} at "
        f"{number(float(analysis['t'][other]), 3, 's')}.",
        tuple(held[:1]),
        tuple(held[1:]),
        otherwise="the force hardly grows",
    )


def regular_part(results: Results) -> Claim:
    """Judges 'the regular one, ... that is insensitive to the discretization'."""
    own = apart(analysis_0(results, 8), analysis_0(results, 16), end=BEFORE)
    other = apart(reference(2), reference(4), end=BEFORE)
    return Claim(
        "Analysis (0): the motion before the nearly impulsive loading is insensitive to the discretization …",
        f"With 8 and 16 two-node elements the markers are at most {number(own, unit='m')} apart up to "
        f"{BEFORE:g} s; by MBDyn with 2 and 4 of three nodes {number(other, unit='m')}.",
        once(own < 1e-3),
        otherwise="they differ",
    )


def chaotic_part(results: Results) -> Claim:
    """Judges 'mesh refinement leads to different behavior of B and D; A and E are minimally affected'."""
    apart, other = _paths_apart(results), _paths_apart_elsewhere()
    met = max(apart["A"], apart["E"]) < 0.1 * min(apart["B"], apart["D"])
    return Claim(
        "… and after it refinement leads to different behavior of B and D, while A and E are minimally "
        "affected …",
        f"With 8 and 16 two-node elements the paths of A and E are {number(1e3 * apart['A'])} and "
        f"{number(1e3 * apart['E'], unit='mm')} apart, those of B and D {number(1e3 * apart['B'])} and "
        f"{number(1e3 * apart['D'], unit='mm')}, whatever the time at which they are passed; by MBDyn with 2 "
        f"and 4 of three nodes {number(1e3 * other['A'])}, {number(1e3 * other['E'])}, "
        f"{number(1e3 * other['B'])} and {number(1e3 * other['D'], unit='mm')}.",
        once(met),
        otherwise="A or E part as far as B or D",
    )


def regularized(results: Results) -> Claim:
    """Judges '... C is regularized by its mass'."""
    apart, other = _paths_apart(results), _paths_apart_elsewhere()
    return Claim(
        "… and C is regularized by its mass.",
        f"The paths of C are {number(1e3 * apart['C'], unit='mm')} apart, those of B and D "
        f"{number(1e3 * apart['B'])} and {number(1e3 * apart['D'], unit='mm')}; by MBDyn "
        f"{number(1e3 * other['C'])}, {number(1e3 * other['B'])} and {number(1e3 * other['D'], unit='mm')}.",
        once(apart["C"] < 0.5 * min(apart["B"], apart["D"])),
        otherwise="C parts as far as B and D",
    )


def _paths_apart(results: Results) -> dict[str, float]:
    """Returns how far apart the paths of each marker are in analysis (0) on its two meshes [m]."""
    return _paths_of(analysis_0(results, 8), analysis_0(results, 16))


@cache
def _paths_apart_elsewhere() -> dict[str, float]:
    """Returns the same of MBDyn's curves [m]."""
    return _paths_of(reference(2), reference(4))


def _paths_of(coarse: Run, fine: Run) -> dict[str, float]:
    """Returns how far apart the paths of each marker are [m]."""
    ways = positions(coarse), positions(fine)
    return {m: paths_apart(ways[0][:, i], ways[1][:, i]) for i, m in enumerate(MARKERS)}


def beam_step_count(results: Results) -> Claim:
    """Judges Table 2's 69,033 steps to 0.69 s."""
    held, told = [], []
    for name, settings in (("1b", CAPPED), ("1b_uncapped", UNCAPPED)):
        if results.has(name):
            case = results.case(name)
            steps, t = case.steps("present"), case.number("present", "t_end")
            held.append(Held(settings, abs(steps / t / (69033 / 0.69) - 1) < 0.01))
            told.append(f"{count(steps)} to {number(t, 2, 's')} {settings}")
    return Claim(
        "Finite elements: 69,033 steps to 0.69 s.",
        f"{'; '.join(told)}.",
        tuple(held[:1]),
        tuple(held[1:]),
        otherwise="far from it",
        remark="the paper does not state the cap" if held[0].met else "",
    )


def same_steps(results: Results) -> Claim:
    """Judges 'the proposed algorithm requires exactly the same number of time steps'."""
    held, told = [], []
    for pair, settings in _pairs(results):
        steps = [results.case(name).steps(m) for name, m in zip(pair, ("baseline", "present"), strict=True)]
        held.append(Held(settings, steps[0] == steps[1]))
        told.append(f"{count(steps[0])} ({pair[0]}) and {count(steps[1])} ({pair[1]}) {settings}")
    return Claim(
        "Finite elements: ‘present’ takes exactly the same number of steps as ‘baseline’ …",
        f"{'; '.join(told)}.",
        tuple(held[:1]),
        tuple(held[1:]),
        otherwise="the numbers differ",
    )


def same_motion(results: Results) -> Claim:
    """Judges 'the error between the baseline and the present analysis is negligible'."""
    held, told = [], []
    for pair, settings in _pairs(results):
        most = apart(results.case(pair[0]).run("baseline"), results.case(pair[1]).run("present"))
        held.append(Held(settings, most < NEGLIGIBLE))
        told.append(f"{number(most, unit='m')} {settings}")
    return Claim(
        "… and the error between the two analyses is negligible.",
        f"The markers are apart by at most {'; '.join(told)}.",
        tuple(held[:1]),
        tuple(held[1:]),
        otherwise="they part",
    )


def _pairs(results: Results) -> list[tuple[tuple[str, str], str]]:
    """Returns the pairs of baseline and present of the beam of elements, and their settings."""
    pairs = ((("1a", "1b"), CAPPED), (("1a_uncapped", "1b_uncapped"), UNCAPPED))
    return [pair for pair in pairs if all(map(results.has, pair[0]))]


def beam_drift(results: Results) -> Claim:
    """Judges 'yields enough accuracy to limit the drift until stiffness actually comes into play'."""
    held, told = [], []
    for name, settings in (("1a", CAPPED), ("1a_uncapped", UNCAPPED)):
        if not results.has(name):
            continue
        run = results.case(name).run("baseline")
        length, rate = ([violations(run, c, end) for end in (0.65, np.inf)] for c in ("phi", "phidot"))
        small, jumps = length[0] <= NEWTON_TOLERANCE, max(length[1] / length[0], rate[1] / rate[0]) >= 10
        held.append(Held(settings, small and jumps))
        told.append(
            f"|φ| up to {number(length[0])} before 0.65 s, {number(length[1], unit='m')} in the whole run, "
            f"|dφ/dt| {number(rate[0])} and {number(rate[1], unit='m/s')} {settings}"
        )
    case = results.case("1b")
    return Claim(
        "The time step that stability asks for limits the drift until stiffness comes into play, at about "
        "0.67 s (Figure 6).",
        f"Baseline: {'; '.join(told)}. ‘Present’: {number(case.number('present', 'max_phi'), unit='m')} and "
        f"{number(case.number('present', 'max_phidot'), unit='m/s')}.",
        tuple(held[:1]),
        tuple(held[1:]),
        otherwise="it drifts before, or nothing changes there",
    )


def goes_on(results: Results) -> Claim:
    """Judges 'the FE models could not converge after the nearly-impulsive event'."""
    settings = {
        "1b": CAPPED,
        "1b_uncapped": UNCAPPED,
        "1b_uncapped_long": f"{UNCAPPED}, carried on to 1.0 s",
        "1b_long": "at a strict tolerance",
    }
    told, held = [], []
    for name in filter(results.has, settings):
        case = results.case(name)
        run, status, t = case.run("present"), case.text("present", "status"), case.number("present", "t_end")
        # What the load has put in stays, or the run is wrong.
        put_in, left = energy_kept(run)
        step = [float(np.median(run["h"][p])) for p in (run["t"] < BEFORE, run["t"] > min(0.65, t - 1e-9))]
        kept = abs(left / put_in - 1) < ABOUT
        fine = status == REACHED_END and t > 0.68 and kept and step[1] > 0.1 * step[0]
        held.append(Held(f"{settings[name]} ({name})", not fine))
        told.append(
            f"{name}: {status} at {number(t, 3, 's')}, steps of {number(step[0])} before {BEFORE:g} s and "
            f"{number(step[1], unit='s')} after the event, energy {number(put_in, 3)} → "
            f"{number(left, 3, 'J')}"
        )
    return Claim(
        "The finite element models could not converge after the event at about 0.65 s without excessively "
        "reducing the time step.",
        f"{'; '.join(told)}.",
        tuple(one for one in held if "strict" not in one.settings),
        tuple(one for one in held if "strict" in one.settings),
        otherwise=f"it goes on, {SLICE}",
    )


def beam_mean_step(results: Results) -> Claim:
    """Judges 'the order of magnitude of the average time step drops to 1e-5'."""
    case = results.case("1b_uncapped")
    mean = case.number("present", "t_end") / case.steps("present")
    return Claim(
        "Finite elements: the average time step is of the order of 10⁻⁵ s.",
        f"{number(mean, unit='s')} without a cap.",
        once(10**-5.5 < mean < 10**-4.5),
        otherwise="another order of magnitude",
    )


def free_frequency(results: Results) -> Claim:
    """Judges 'the largest natural frequency of the free-free model is of the order of 1e4 Hz'."""
    highest = highest_frequency(results) or np.nan
    return Claim(
        "The largest natural frequency of the free-free model of 4 elements is of the order of 10⁴ Hz.",
        f"{number(highest, 3, 'Hz')}.",
        once(10**3.5 < highest < 10**4.5),
        otherwise="another order of magnitude",
    )


def fully_implicit(results: Results) -> Claim:
    """Judges that constraints can be added to a problem in fully implicit form, by what it is to give."""
    explicit = results.case("mesh16").run("present")
    told, held = [], []
    for name, settings in (
        ("mesh16_implicit_loose", "at the paper’s tolerance"),
        ("mesh16_implicit", "at a strict tolerance"),
    ):
        case = results.case(name)
        run = case.run("present")
        off = apart(run, explicit, end=BEFORE)
        violation = max(case.number("present", "max_phi"), case.number("present", "max_phidot"))
        ended = case.text("present", "status") == REACHED_END
        held.append(Held(settings, ended and off < IMPLICIT_APART and violation <= NEWTON_TOLERANCE))
        told.append(
            f"{settings} {count(case.steps('present'))} steps, markers at most {number(off, unit='m')} from "
            f"those of the explicit run up to {BEFORE:g} s, |φ| and |dφ/dt| up to {number(violation)}"
        )
    return Claim(
        "Sect. 3.4: constraints can be added to problems in the fully implicit form g(y, ẏ, t) = 0, Eq. "
        "(18), in an external loop.",
        "Radau IIA and generalized-alpha solve it with the multipliers of both levels as unknowns, here with "
        f"16 elements: {'; '.join(told)}. The explicit run takes "
        f"{count(results.case('mesh16').steps('present'))} steps.",
        tuple(held[:1]),
        tuple(held[1:]),
        otherwise="another motion, or off the constraints",
        remark="the multipliers are unknowns of the step, not of a loop around it",
    )


F4, F5, F6, SWINGING = "swing_figure4", "swing_figure5", "swing_figure6", "swing"
# By the figures that they are read from.
CLAIMS = (
    Row(regular_part, F4, ("0_8x", "0_16x")),
    Row(chaotic_part, F4, ("0_8x", "0_16x")),
    Row(regularized, F4, ("0_8x", "0_16x")),
    Row(frequencies, F5, ("table1",)),
    Row(shapes, F5, ("table1",)),
    Row(free_frequency, cases=("free_free",)),
    Row(beam_step_count, F6, ("1b",)),
    Row(same_steps, F6, ("1a", "1b")),
    Row(same_motion, F6, ("1a", "1b")),
    Row(beam_drift, F6, ("1a", "1b")),
    Row(beam_mean_step, cases=("1b_uncapped",)),
    Row(goes_on, cases=("1b",)),
    Row(alignment, SWINGING, ("1b",)),
    Row(impulse, SWINGING, ("1b",)),
    *MODAL_CLAIMS,
    Row(fully_implicit, "swing_cost", ("mesh16", "mesh16_implicit", "mesh16_implicit_loose")),
)
