"""What the paper says about the modal models of the swing (Sects. 4.2 and 5) and what taut gives."""

from collections.abc import Callable

from taut.formats import count, number, percent
from taut.report.document import Claim, Verdict
from taut.report.judgment import ABOUT, NEWTON_TOLERANCE, verdict
from taut.report.swing.measures import BEFORE, apart, event_time, violations
from taut.results import Results

# The cap on the step of the modal models [s].
CAP = 1e-3
MODAL_STEPS, SIMPLE_STEPS = (23075, 28103), 1103
# How far from the beam of elements four modes are before the event, at most [m].
CLOSE = 2e-3


def fewer_steps(results: Results) -> Claim:
    """Judges 'the modal models performed much better than the FE ones'."""
    steps = {name: results.case(name).steps("present") for name in ("1b", "2b", "3b")}
    end = results.case("2b").number("present", "t_end")
    return Claim(
        "The modal models perform much better than the finite element ones.",
        f"{count(steps['2b'])} steps to {number(end, 2, 's')} with, {count(steps['3b'])} without the axial "
        f"mode; {count(steps['1b'])} to {number(results.case('1b').number('present', 't_end'), 2, 's')} with "
        "finite elements.",
        *verdict(steps["1b"] > 2 * steps["2b"] > 4 * steps["3b"], "hardly fewer steps"),
    )


def close_to_beam(results: Results) -> Claim:
    """Compares four modes with the beam of elements; the paper compares by the eye only."""
    name = "2b_tight" if results.has("2b_tight") else "2b"
    modal, beam = results.case(name).run("present"), results.case("1b").run("present")
    before, after = apart(modal, beam, end=BEFORE), apart(modal, beam, start=BEFORE)
    return Claim(
        "Four modes dominate the motion of the beam.",
        f"Markers of {name} and 1b at most {number(1e3 * before, unit='mm')} apart up to {BEFORE:g} s, "
        f"{number(1e3 * after, unit='mm')} afterwards.",
        Verdict.CONDITION if before <= CLOSE else Verdict.NO,
        "before the event only" if before <= CLOSE else f"more than {number(1e3 * CLOSE, 1, 'mm')} apart",
    )


def modal_counts(results: Results) -> Claim:
    """Judges 'the proposed algorithm requires only little more time steps than the baseline one'."""
    steps = [results.case("2a").steps("baseline"), results.case("2b").steps("present")]
    near = (
        all(0.5 < mine / theirs < 2.0 for mine, theirs in zip(steps, MODAL_STEPS, strict=True))
        and steps[1] < 1.5 * (steps[0])
    )
    return Claim(
        f"Modal model: only little more steps with ‘present’, {count(MODAL_STEPS[1])} instead of "
        f"{count(MODAL_STEPS[0])}.",
        f"{count(steps[1])} instead of {count(steps[0])}.",
        Verdict.CONDITION if near else Verdict.NO,
        "the counts are chaotic, for the step sits at the limit of stability: another first step alone moves "
        "them by thousands"
        if near
        else "other orders of magnitude",
    )


def modal_mean_step(results: Results) -> Claim:
    """Judges 'the order of magnitude of the average time step is close to 1e-4'."""
    case = results.case("2b")
    mean = case.number("present", "t_end") / case.steps("present")
    return Claim(
        "Modal model: the average time step is close to 10⁻⁴ s.",
        f"{number(mean, unit='s')}; the paper’s own count makes {number(1 / MODAL_STEPS[1], unit='s')}.",
        *verdict(10**-4.5 < mean < 10**-3.5, "another order of magnitude"),
    )


def larger_violations(results: Results) -> Claim:
    """Judges 'the violation ... of the modal model appears to be much larger', Figs 6 and 7."""
    beam, modal = results.case("1a").run("baseline"), results.case("2a").run("baseline")
    pairs = [[violations(run, column) for run in (beam, modal)] for column in ("phi", "phidot")]
    raw = [violations(results.case(name).run("present"), "phi_raw") for name in ("1b", "2b")]
    met = all(pair[1] > 100 * pair[0] for pair in pairs) and raw[1] > 100 * raw[0]
    return Claim(
        "The violations of the modal model are much larger than those of the finite elements.",
        f"Baseline: |φ| up to {number(pairs[0][1])} instead of {number(pairs[0][0], unit='m')}, |dφ/dt| "
        f"{number(pairs[1][1])} instead of {number(pairs[1][0], unit='m/s')}; ‘present’ before its state is "
        f"replaced: |φ| {number(raw[1])} instead of {number(raw[0], unit='m')}.",
        *verdict(met, "they are not"),
    )


def drift_cured(results: Results) -> Claim:
    """Judges 'with the proposed correction, [it] does not suffer from the severe drift of the baseline'."""
    drift = results.case("2a").number("baseline", "max_phi")
    cured = results.case("2b").number("present", "max_phi")
    met = cured <= 1.001 * NEWTON_TOLERANCE and drift > 1e3 * cured
    return Claim(
        "With the proposed correction the modal model does not suffer from the severe drift of the baseline.",
        f"|φ| up to {number(drift, unit='m')} (2a) and {number(cured, unit='m')} (2b).",
        *verdict(met, "it drifts, or the baseline does not"),
    )


def simple_counts(results: Results) -> Claim:
    """Judges (3a) = (3b) = 1,103."""
    steps = [results.case("3a").steps("baseline"), results.case("3b").steps("present")]
    near = abs(steps[1] / SIMPLE_STEPS - 1) <= ABOUT
    decision, because = verdict(steps[0] == steps[1], "the numbers differ")
    if decision is Verdict.YES and not near:
        decision, because = Verdict.CONDITION, "the same number, but another one"
    return Claim(
        f"Without the axial mode, baseline and present take the same number of steps: {count(SIMPLE_STEPS)}.",
        f"{count(steps[0])} and {count(steps[1])}.",
        decision,
        because,
    )


def at_the_cap(results: Results) -> Claim:
    """Judges 'hitting the requested upper time step limit most of the times'."""
    run = results.case("3b").run("present")
    share = float((run["h"][1:] > 0.999 * CAP).mean())
    return Claim(
        "… hitting the upper limit of 10⁻³ s most of the time.",
        f"In {percent(share, 3)} of the time.",
        *verdict(share > 0.5, "less than half of the time"),
    )


def axial_mode(results: Results) -> Claim:
    """Judges 'the differences in the motion when the axial mode is omitted are negligible'."""
    name = "2b_tight" if results.has("2b_tight") else "2b"
    runs = [results.case(n).run("present") for n in ("3b", name)]
    event = event_time(results, name) or 0.64
    before, soon, whole = (apart(*runs, end=t) for t in (0.64, 0.65, float("inf")))
    if whole < 1e-2:
        decision, because = Verdict.YES, ""
    elif before < 1e-3:
        decision, because = Verdict.CONDITION, f"until the event at {number(event, 3, 's')} only"
    else:
        decision, because = Verdict.NO, "they differ from the start"
    return Claim(
        "The differences in the motion when the axial mode is omitted are negligible (Figure 8).",
        f"Markers of 3b and {name} at most {number(before, unit='m')} apart up to 0.64 s, "
        f"{number(1e3 * soon, unit='mm')} up to 0.65 s, {number(whole, unit='m')} in the whole run.",
        decision,
        because,
    )


def simple_drift(results: Results) -> Claim:
    """Judges 'even when the axial mode is removed, the proposed stabilization performs relatively well'."""
    drift = results.case("3a").number("baseline", "max_phi")
    cured = results.case("3b").number("present", "max_phi")
    return Claim(
        "Even when the axial mode is removed, the proposed stabilization performs relatively well.",
        f"|φ| up to {number(drift, unit='m')} (3a) and {number(cured, unit='m')} (3b).",
        *verdict(cured <= 1.001 * NEWTON_TOLERANCE and cured < drift, "it drifts"),
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
        *verdict(inner < 2 * calls, "many iterations"),
    )


MODAL_CLAIMS: tuple[tuple[tuple[str, ...], Callable[[Results], Claim]], ...] = (
    (("1b", "2b", "3b"), fewer_steps),
    (("1b", "2b"), close_to_beam),
    (("2a", "2b"), modal_counts),
    (("2b",), modal_mean_step),
    (("1a", "1b", "2a", "2b"), larger_violations),
    (("2a", "2b"), drift_cured),
    (("3a", "3b"), simple_counts),
    (("3b",), at_the_cap),
    (("2b", "3b"), axial_mode),
    (("3a", "3b"), simple_drift),
    (("2b",), small_overhead),
)
