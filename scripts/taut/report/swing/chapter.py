"""The swing's chapter of the report: claims, figures, Tables 1 and 2, and how far the models agree."""

import numpy as np

from taut.formats import count, listed, number
from taut.report.document import Chapter, Figure, Paragraph, Section, Table
from taut.report.judgment import judged
from taut.report.swing import convergence
from taut.report.swing import figures as swing
from taut.report.swing.claims import CLAIMS
from taut.report.swing.measures import (
    BEFORE,
    TABLE_1,
    TRUSTED,
    analysis_0,
    apart,
    distances,
    events,
    modes,
    reference,
)
from taut.results import Results, Run

# The paper's Table 2: case, what it is, method, last time [s], steps.
TABLE_2 = (
    ("1a", "Beam FE, baseline", "baseline", "0.69", 69033),
    ("1b", "Beam FE, present", "present", "0.69", 69033),
    ("2a", "Modal, baseline", "baseline", "1.00", 23075),
    ("2b", "Modal, present", "present", "1.00", 28103),
    ("3a", "Modal, baseline (no axial mode)", "baseline", "1.00", 1103),
    ("3b", "Modal, present (no axial mode)", "present", "1.00", 1103),
)
# Cases that the paper does not have.
FURTHER = (
    ("1a_uncapped", "(1a) without the cap of 10⁻⁵ s", "baseline"),
    ("1b_uncapped", "(1b) without the cap of 10⁻⁵ s", "present"),
    ("1b_uncapped_long", "(1b) without the cap, to the end", "present"),
    ("1b_long", "(1b) to the end, tight tolerance", "present"),
    ("mesh16_event", "16 elements, beyond the event", "present"),
    ("2b_tight", "(2b), tight tolerance", "present"),
)
COMPARED = (
    ("0_4x", "4 elements, generalized-alpha", "present"),
    ("0_8x", "8 elements, generalized-alpha", "present"),
    ("0_16x", "16 elements, generalized-alpha", "present"),
    ("0_32x", "32 elements, generalized-alpha", "present"),
    ("1b", "4 elements", "present"),
    ("1b_long", "4 elements, tight tolerance", "present"),
    ("mesh16_event", "16 elements", "present"),
    ("2b", "modal", "present"),
    ("2b_tight", "modal, tight tolerance", "present"),
    ("3b", "modal without axial mode", "present"),
)
CASES = (*(row[0] for row in TABLE_2), *(row[0] for row in FURTHER), *convergence.CASES)
CASES += ("0_4x", "0_8x", "0_16x", "0_32x", "table1", "free_free")
CAPTIONS = {
    "swing_figure3": "The paper’s Figure 3: the swing at rest, to scale, and the force on C over time.",
    "swing_figure4": "The paper’s Figure 4: trajectories of the markers in analysis (0), here by "
    "generalized-alpha with 8 (top) and 16 (bottom) two-node elements, which come about as far as the "
    "paper’s 2 and 4 elements of three nodes. Dashed: MBDyn with those, curves that come with taut as data. "
    "The swing is drawn at 0, 0.4, 0.64 and 1 s, the later the darker; the beam is a smooth curve through "
    "its markers.",
    "swing_mesh": "How far the markers are from the continuum at given instants, at the marker where it is "
    "most, over the mesh. Filled: implicit; open: explicit.",
    "swing_cost": "The same before the event (left) and after it (right) over the time of the run; the "
    "numbers are those of the elements. An explicit run costs what stability asks for, whatever its "
    "tolerance.",
    "swing_figure5": "The paper’s Figure 5: the modes of Table 1, with a largest displacement of one. The "
    "diamond is the mass at mid-span. Broad lines: what a static load at mid-span does.",
    "swing_figure6": "The paper’s Figure 6: error of the constraints (left) and of their derivative (right) "
    "of the finite element model, with steps of at most 10⁻⁵ s; each point is the largest error in 1/500 of "
    "the run. Values below 10⁻¹⁶, zero among them, are drawn at 10⁻¹⁶.",
    "swing_figure7": "The paper’s Figure 7: the same for the modal model. The thin line is what ‘present’ "
    "violates before its state is replaced at the end of a step; a violation below 10⁻¹² m is left as it is.",
    "swing_figure8": "The paper’s Figure 8: motion of the markers, finite elements (top), modal model "
    "(middle), modal model without the axial mode (bottom). Left: trajectories, with the markers where they "
    "end. Right: how far two runs are "
    "apart, at the marker where it is most; less than 10⁻¹⁴ m is drawn there. Before the event the models "
    "and methods agree.",
    "swing": "The swing in motion, (3b), with the traces of its markers and, in gray, those of MBDyn’s "
    "analysis (0); below, the tension of link 1.",
}


def build(results: Results) -> Chapter:
    """Returns the chapter from the cases that have been run; the figures must have been drawn."""
    figures = tuple(
        Figure(spec.title, spec.path(results), CAPTIONS[spec.name])
        for spec in swing.FIGURES
        if spec.can_draw(results)
    )
    sections = (
        Section("Table 1", table_1(results)),
        Section("Table 2", table_2(results)),
        Section("Against the reference", against_reference(results)),
        Section("Mesh, tolerance and chaos", convergence.section(results)),
        Section("What the paper leaves open", left_open(results)),
    )
    return Chapter(
        title="Swing",
        reference="Sects. 4.2, 3.4 and 5",
        claims=judged(CLAIMS, results),
        figures=figures,
        sections=tuple(section for section in sections if section.blocks),
        warnings=warnings(results),
    )


def warnings(results: Results) -> tuple[str, ...]:
    """Returns a line for each case with runs that did not reach the end, and one for cases not run."""
    lines = []
    for name in CASES:
        if not results.has(name) or name in ("table1", "free_free"):
            continue
        ended = [f"{method} ({status})" for method, status in results.case(name).unfinished.items()]
        if ended:
            lines.append(f"In case {name} these runs did not reach the end: {listed(ended)}.")
    missing = [name for name, *_ in TABLE_2 if not results.has(name)]
    if missing:
        lines.append(f"These cases of Table 2 have not been run: {listed(missing)}.")
    return tuple(lines)


def table_1(results: Results) -> tuple[Paragraph | Table, ...]:
    """Sets the frequencies beside the paper's."""
    if not results.has("table1"):
        return ()
    rows = tuple(
        (row[0], row[-1], number(frequency, 5))
        for row, (_, frequency) in zip(TABLE_1, modes(results), strict=True)
    )
    return (
        Table(
            "Frequencies in Hz of the simply supported beam, 40 two-node elements.",
            ("mode", "the paper prints", "taut"),
            rows,
        ),
        Paragraph(
            "All digits are the paper’s when the shear stiffness is corrected for the length l of an "
            "element, 1/GA* = 1/GA + l²/(12 EI), and a node has the rotary inertia of its slice of beam. The "
            "modulus is 73 GPa; the paper’s 73 MPa is a slip."
        ),
    )


def table_2(results: Results) -> tuple[Paragraph | Table, ...]:
    """Sets last times and steps beside the paper's, and below them cases that the paper does not have."""
    rows = []
    for name, text, method, t, steps in TABLE_2:
        if results.has(name):
            rows.append((f"({name}) {text}", t, count(steps), *_cells(results, name, method)))
    for name, text, method in FURTHER:
        if results.has(name):
            rows.append((text, "", "", *_cells(results, name, method)))
    if not rows:
        return ()
    header = ("case", "paper: last time [s]", "paper: steps", "last time [s]", "steps", "rejected")
    header += ("mean step [s]", "max |φ| [m]")
    return (
        Table("Steps that were taken; |φ| after replacement, where there is one.", header, tuple(rows)),
        Paragraph(
            "The counts of (2a) and (2b) are chaotic, for the step sits at the limit of stability: another "
            "first step alone moves them by thousands. Those of (1a) and (1b) are the length of "
            "the run over the cap on the step; those of (3a) and (3b) nearly so."
        ),
    )


def _cells(results: Results, name: str, method: str) -> tuple[str, ...]:
    """Returns what Table 2 tells about a run."""
    case = results.case(name)
    t, steps = case.number(method, "t_end"), case.steps(method)
    return (
        f"{t:.2f}",
        count(steps),
        count(int(case.number(method, "rejected"))),
        number(t / max(steps, 1)),
        number(case.number(method, "max_phi")),
    )


# Instants at which elements of two and of three nodes are compared [s].
INSTANTS = (0.2, 0.4, 0.6, 0.64, 0.8, 1.0)


def against_reference(results: Results) -> tuple[Paragraph | Table, ...]:
    """Tells how far the meshes and the modal model are from analysis (0) before the event."""
    blocks: list[Paragraph | Table] = []
    found = {
        n: apart(results.case(f"mesh{n}").run("present"), reference(4), end=BEFORE)
        for n in convergence.MESHES
        if results.has(f"mesh{n}")
    }
    if found:
        rows = []
        for n, distance in found.items():
            rate = f"{np.log2(found[n // 2] / distance):.2f}" if n // 2 in found else ""
            rows.append((str(n), number(distance), rate))
        blocks += [
            Table(
                f"Largest distance of a marker from MBDyn with 4 three-node elements, up to {BEFORE:g} s.",
                ("two-node elements", "distance [m]", "rate"),
                tuple(rows),
                text_columns=0,
            ),
            Paragraph(
                "The rate is the power of the element’s length with which the distance falls; two-node "
                "elements have a rate of 2. MBDyn’s curves are themselves good to "
                f"{number(TRUSTED, 1, 'm')}, so that the rate cannot hold much beyond the finest mesh here."
            ),
        ]
    blocks += other_elements(results)
    runs = {
        f"{name}, {text}": results.case(name).run(method)
        for name, text, method in COMPARED
        if results.has(name)
    }
    if runs:
        rows = [("MBDyn", "", "", height(reference(4)))]
        for label, run in runs.items():
            near = number(1e3 * apart(run, reference(4), end=BEFORE))
            whole = number(1e3 * apart(run, reference(4)))
            rows.append((label, near, f"{whole} ({number(float(run['t'][-1]), 3, 's')})", height(run)))
        blocks += [
            Table(
                "Largest distance of a marker from MBDyn with 4 three-node elements; where A ends up.",
                ("case", f"up to {BEFORE:g} s [mm]", "whole run [mm]", "y of A at 1 s [m]"),
                tuple(rows),
            ),
            Paragraph(after_the_event(runs)),
        ]
    return tuple(blocks)


def other_elements(results: Results) -> tuple[Paragraph | Table, ...]:
    """Tells at given instants what elements of three nodes make better than as many nodes of two."""
    own = {n: analysis_0(results, n) for n in (4, 8, 16, 32) if results.has(f"0_{n}x")}
    if not own:
        return ()
    runs = {"2 of three nodes, by MBDyn": reference(2)}
    runs |= {f"{n} of two nodes": run for n, run in own.items()}
    rows = []
    for label, run in runs.items():
        times, far = distances(run, reference(4))
        at = [int(np.argmin(abs(times - t))) for t in INSTANTS]
        rows.append((label, *(number(float(far[i].max())) for i in at)))
    return (
        Table(
            "Analysis (0) at given instants: largest distance of a marker from MBDyn with 4 three-node "
            "elements [m].",
            ("elements", *(f"{t:g} s" for t in INSTANTS)),
            tuple(rows),
        ),
        Paragraph(
            "An element of three nodes has two cuts, as two of two nodes have, and a curvature that changes "
            "along it, as none of them has. On as many nodes it is nearer, above all after the event: there "
            "2 of three nodes are about as good as 8 to 16 of two, before it as 4 to 8. So Figure 4 takes "
            "twice the cuts for the paper’s meshes; the element of three nodes itself is not in taut."
        ),
    )


def after_the_event(runs: dict[str, Run]) -> str:
    """Tells which runs end up elsewhere than analysis (0)."""
    whole = {label: float(run["Ay"][-1]) for label, run in runs.items() if run["t"][-1] > 1 - 1e-9}
    end = float(reference(4)["Ay"][-1])
    back = [f"({label.partition(',')[0]})" for label, y in whole.items() if y < 0.5 * end]
    on = [f"({label.partition(',')[0]})" for label, y in whole.items() if abs(y / end - 1) < 0.1]
    text = (
        "Before the event all models tell the same. What follows depends on how they take up the blow along "
    )
    text += "the beam"
    text += f": in {listed(back)} the swing turns back" * bool(back)
    text += f"{', while' if back else ':'} in {listed(on)} A goes on as in analysis (0)" * bool(on)
    return text + "."


def height(run: Run) -> str:
    """Returns y of A at 1 s, if the run comes so far."""
    return number(float(run["Ay"][-1]), 3) if run["t"][-1] > 1 - 1e-9 else ""


def left_open(results: Results) -> tuple[Paragraph | Table, ...]:
    """Tells what had to be chosen, and what the other choice does."""
    blocks: list[Paragraph | Table] = [
        Paragraph(
            "There is no gravity, the force on C points from A towards E, and the side of 1 mm lies in the "
            "plane of the motion: only so do link 1 and the beam come in line between 0.6 and 0.7 s. The "
            "steps of (1a) and (1b) are capped at 10⁻⁵ s, which makes the paper’s 69,033; those of the modal "
            "models at 10⁻³ s."
        )
    ]
    rows = []
    for name in ("1a", "1b", "1b_long", "mesh16_event", "2a", "2b", "2b_tight", "3a", "3b"):
        found = events(results, name)
        if found:
            times = [f"{found[e]:.4f}" if e in found else "never" for e in ("link-AC", "link-AE")]
            rows.append((name, *times))
    if rows:
        blocks.append(
            Table(
                "When link 1 is in line with A–C and with the chord A–E for the first time [s].",
                ("case", "with A–C", "with A–E"),
                tuple(rows),
            )
        )
    return tuple(blocks)
