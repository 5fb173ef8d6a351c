"""What the paper says about the modal models of the swing (Sects. 4.2 and 5) and what taut gives."""

import numpy as np

from taut.formats import count, number, percent
from taut.report.document import Claim, Held
from taut.report.judgment import NEWTON_TOLERANCE, Row, once, paper_and_strict
from taut.report.swing.measures import BEFORE, apart, event_time, strain_energies, violations
from taut.results import Results

# The cap on the step of the modal models [s].
CAP = 1e-3
MODAL_STEPS, SIMPLE_STEPS = (23075, 28103), 1103
# The transient, and where the vibrations that it leaves begin, after the event [s].
TRANSIENT = 0.02
# How far from the beam of elements four modes are before the event, at most [m].
CLOSE = 2e-3


def fewer_steps(results: Results) -> Claim:
    """Judges 'the modal models performed much better than the FE ones', by processor time."""
    modal, simple = (_seconds(results, name) for name in ("2b", "3b"))
    beam = [("with a cap on the step of the elements", _seconds(results, "1b"))]
    if results.has("1b_long"):
        beam.append(("beside elements at a strict tolerance (1b_long)", _seconds(results, "1b_long")))
    held = [
        Held(f"{what} axial mode, {settings}", one < 0.5 * seconds)
        for settings, seconds in beam
        for what, one in (("with the", modal), ("without the", simple))
    ]
    told = [
        f"{number(seconds / modal)} and {number(seconds / simple)} times that of the modal models with and "
        "without the "
        f"axial mode, {settings}"
        for settings, seconds in beam
    ]
    return Claim(
        "The modal models perform much better than the finite element ones.",
        f"Processor time to 1.0 s with finite elements: {'; '.join(told)}.",
        tuple(held[:2]),
        tuple(held[2:]),
        otherwise="hardly faster",
    )


def _seconds(results: Results, name: str) -> float:
    """Returns the time of a run, for each second of motion."""
    case = results.case(name)
    return case.number("present", "wall_seconds") / case.number("present", "t_end")


def close_to_beam(results: Results) -> Claim:
    """Compares four modes with the beam of elements; the paper compares by the eye only."""
    name = "2b_tight" if results.has("2b_tight") else "2b"
    modal, beam = results.case(name).run("present"), results.case("1b").run("present")
    before, after = apart(modal, beam, end=BEFORE), apart(modal, beam, start=BEFORE)
    return Claim(
        "Four modes dominate the motion of the beam.",
        f"Markers of {name} and 1b at most {number(1e3 * before, unit='mm')} apart up to {BEFORE:g} s, "
        f"{number(1e3 * after, unit='mm')} afterwards.",
        (Held("before the event", before <= CLOSE), Held("after the event", after <= CLOSE)),
        otherwise=f"more than {number(1e3 * CLOSE, 1, 'mm')} apart",
    )


def modal_counts(results: Results) -> Claim:
    """Judges 'the proposed algorithm requires only little more time steps than the baseline one'."""
    steps = [results.case("2a").steps("baseline"), results.case("2b").steps("present")]
    more = steps[1] / steps[0] - 1
    return Claim(
        f"Modal model: only little more steps with ‘present’, {count(MODAL_STEPS[1])} instead of "
        f"{count(MODAL_STEPS[0])}.",
        f"{count(steps[1])} instead of {count(steps[0])}.",
        # Which of the two has more is chance: a verdict must not hang on it.
        (
            Held("about as many", abs(more) < 0.5),
            Held("more whatever the first step", False),
        ),
        otherwise="there are far fewer" if more <= 0 else "there are many more",
        remark="which has more is chance: the counts are chaotic, for the step sits at the limit of "
        "stability, and another first step alone moves them by thousands",
    )


def modal_mean_step(results: Results) -> Claim:
    """Judges 'the order of magnitude of the average time step is close to 1e-4'."""
    case = results.case("2b")
    mean = case.number("present", "t_end") / case.steps("present")
    return Claim(
        "Modal model: the average time step is close to 10⁻⁴ s.",
        f"{number(mean, unit='s')}; the paper’s own count makes {number(1 / MODAL_STEPS[1], unit='s')}.",
        once(10**-4.5 < mean < 10**-3.5),
        otherwise="another order of magnitude",
    )


def larger_violations(results: Results) -> Claim:
    """Judges 'the violation ... of the modal model appears to be much larger', Figs 6 and 7."""
    modal, raw = results.case("2a").run("baseline"), violations(results.case("2b").run("present"), "phi_raw")
    held, told = [], []
    for suffix, settings in (
        ("", "with a cap on the step of the elements"),
        ("_uncapped", "without that cap"),
    ):
        if not (results.has(f"1a{suffix}") and results.has(f"1b{suffix}")):
            continue
        beam = results.case(f"1a{suffix}").run("baseline")
        pairs = [[violations(run, column) for run in (beam, modal)] for column in ("phi", "phidot")]
        pairs.append([violations(results.case(f"1b{suffix}").run("present"), "phi_raw"), raw])
        held.append(Held(settings, all(pair[1] > 100 * pair[0] for pair in pairs)))
        told.append(
            f"Baseline: |φ| up to {number(pairs[0][1])} instead of {number(pairs[0][0], unit='m')}, |dφ/dt| "
            f"{number(pairs[1][1])} instead of {number(pairs[1][0], unit='m/s')}; ‘present’ before its "
            "state is "
            f"replaced: |φ| {number(pairs[2][1])} instead of {number(pairs[2][0], unit='m')} ({settings})"
        )
    return Claim(
        "The violations of the modal model are much larger than those of the finite elements.",
        f"{'. '.join(told)}.",
        tuple(held[:1]),
        tuple(held[1:]),
        otherwise="they are not",
    )


def drift_cured(results: Results) -> Claim:
    """Judges 'with the proposed correction, [it] does not suffer from the severe drift of the baseline'."""
    drift = results.case("2a").number("baseline", "max_phi")
    cured = results.case("2b").number("present", "max_phi")
    met = cured <= 1.001 * NEWTON_TOLERANCE and drift > 1e3 * cured
    return Claim(
        "With the proposed correction the modal model does not suffer from the severe drift of the baseline.",
        f"|φ| up to {number(drift, unit='m')} (2a) and {number(cured, unit='m')} (2b).",
        once(met),
        otherwise="it drifts, or the baseline does not",
    )


def simple_counts(results: Results) -> Claim:
    """Judges (3a) = (3b) = 1,103."""
    steps = [results.case("3a").steps("baseline"), results.case("3b").steps("present")]
    return Claim(
        f"Without the axial mode, baseline and present take the same number of steps: {count(SIMPLE_STEPS)}.",
        f"{count(steps[0])} and {count(steps[1])}.",
        (
            Held("they take the same number", steps[0] == steps[1]),
            Held("it is the paper’s", abs(steps[1] / SIMPLE_STEPS - 1) <= 0.01),
        ),
        otherwise="the numbers differ",
        remark=f"{count(steps[1])} is not {count(SIMPLE_STEPS)}" if steps[1] != SIMPLE_STEPS else "",
    )


def at_the_cap(results: Results) -> Claim:
    """Judges 'hitting the requested upper time step limit most of the times'."""
    run = results.case("3b").run("present")
    share = float((run["h"][1:] > 0.999 * CAP).mean())
    return Claim(
        "… hitting the upper limit of 10⁻³ s most of the time.",
        f"In {percent(share, 3)} of the time.",
        once(share > 0.5),
        otherwise="less than half of the time",
    )


def axial_mode(results: Results) -> Claim:
    """Judges 'the differences in the motion when the axial mode is omitted are negligible'."""
    name = "2b_tight" if results.has("2b_tight") else "2b"
    runs = [results.case(n).run("present") for n in ("3b", name)]
    event = event_time(results, name) or 0.64
    before, soon, whole = (apart(*runs, end=t) for t in (0.64, 0.65, float("inf")))
    return Claim(
        "The differences in the motion when the axial mode is omitted are negligible (Figure 8).",
        f"Markers of 3b and {name} at most {number(before, unit='m')} apart up to 0.64 s, "
        f"{number(1e3 * soon, unit='mm')} up to 0.65 s, {number(whole, unit='m')} in the whole run.",
        (
            Held(f"until the event at {number(event, 3, 's')}", before < 1e-3),
            Held("in the whole run", whole < 1e-2),
        ),
        otherwise="they differ from the start",
    )


def transient(results: Results) -> Claim:
    """Judges 'the axial mode is expected to dominate the transient when the mass abruptly reverts'."""
    shares, told = [], []
    for name in ("2b", "2b_tight"):
        t, energies = strain_energies(results, name)
        event = event_time(results, name, "2b_tight") or BEFORE
        before = energies[:, t < BEFORE]
        during = energies[:, (t >= event) & (t <= event + TRANSIENT)]
        peak = during[:, np.argmax(during[-1])]
        shares.append(float(peak[-1] / peak.sum()))
        told.append(
            f"{percent(shares[-1])} of the beam’s strain energy when it peaks, within "
            f"{1e3 * TRANSIENT:g} ms of the event ({number(float(during[-1].max()), unit='J')}, "
            f"up to {BEFORE:g} s at most {number(float(before[-1].max()), unit='J')})"
        )
    return Claim(
        "The axial mode is expected to dominate the transient when the mass abruptly reverts its motion …",
        f"It has {told[0]}; at a strict tolerance {told[1]}.",
        **paper_and_strict(*(share > 0.5 for share in shares)),
        otherwise="less than half",
    )


def free_vibrations(results: Results) -> Claim:
    """Judges '... while the bending modes are expected to dominate the free vibrations of the beam'."""
    shares = []
    for name in ("2b", "2b_tight"):
        t, energies = strain_energies(results, name)
        event = event_time(results, name, "2b_tight") or BEFORE
        mean = energies[:, t > event + TRANSIENT].mean(axis=1)
        shares.append(float(mean[:-1].sum() / mean.sum()))
    return Claim(
        "… while the bending modes are expected to dominate the free vibrations.",
        f"Later than {number(1e3 * TRANSIENT, unit='ms')} after the event they have {percent(shares[0])} of "
        f"the strain energy on the average, at a strict tolerance {percent(shares[1])}: nothing damps the "
        "axial mode.",
        **paper_and_strict(*(share > 0.5 for share in shares)),
        otherwise="the axial mode has more than half",
    )


def simple_drift(results: Results) -> Claim:
    """Judges 'even when the axial mode is removed, the proposed stabilization performs relatively well'."""
    drift = results.case("3a").number("baseline", "max_phi")
    cured = results.case("3b").number("present", "max_phi")
    return Claim(
        "Even when the axial mode is removed, the proposed stabilization performs relatively well.",
        f"|φ| up to {number(drift, unit='m')} (3a) and {number(cured, unit='m')} (3b).",
        once(cured <= 1.001 * NEWTON_TOLERANCE and cured < drift),
        otherwise="it drifts",
    )


def small_overhead(results: Results) -> Claim:
    """Judges Sect. 5's 'minimal implementation overhead' by what the inner loop takes."""
    case = results.case("2b")
    calls, inner = (case.number("present", key) for key in ("rhs_evaluations", "projection_iterations"))
    return Claim(
        "Sect. 5: the positions are projected by a separate nonlinear algebraic problem, and the original "
        "problem remains explicit.",
        f"2b: {number(inner / calls)} iterations of the inner loop for each evaluation of the right-hand "
        "side.",
        once(inner < 2 * calls),
        otherwise="many iterations",
    )


F7, F8 = "swing_figure7", "swing_figure8"
MODAL_CLAIMS = (
    Row(larger_violations, F7, ("1a", "1b", "2a", "2b")),
    Row(drift_cured, F7, ("2a", "2b")),
    Row(simple_drift, F7, ("3a", "3b")),
    Row(fewer_steps, cases=("1b", "2b", "3b")),
    Row(modal_counts, cases=("2a", "2b")),
    Row(modal_mean_step, cases=("2b",)),
    Row(simple_counts, cases=("3a", "3b")),
    Row(at_the_cap, cases=("3b",)),
    Row(small_overhead, cases=("2b",)),
    Row(close_to_beam, F8, ("1b", "2b")),
    Row(transient, cases=("2b", "2b_tight", "table1")),
    Row(free_vibrations, cases=("2b", "2b_tight", "table1")),
    Row(axial_mode, F8, ("2b", "3b")),
)
