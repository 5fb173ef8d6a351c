"""The pendulum's chapter of the report: claims, figures and what the paper leaves open."""

from taut.formats import listed, number
from taut.report.document import Chapter, Figure
from taut.report.judgment import judged
from taut.report.pendulum import figures as pendulum
from taut.report.pendulum.claims import CHECKS, CLAIMS
from taut.report.pendulum.measures import energy_change
from taut.report.pendulum.unsettled import what_is_open
from taut.results import Results

CASES = (
    "figure1",
    "figure2",
    "figure1_standard",
    "figure2_standard",
    "figure3",
    "options1",
    "options2",
    "penalty",
)


def build(results: Results) -> Chapter:
    """Returns the chapter; the figures must have been drawn."""
    captions = (paper_caption(1), paper_caption(2), third_caption(results))
    figures = tuple(
        Figure(spec.title, spec.path(results), caption)
        for spec, caption in zip(pendulum.FIGURES, captions, strict=True)
    )
    return Chapter(
        title="Simple pendulum",
        reference="Sect. 4.1",
        claims=judged(CLAIMS, results),
        checks=judged(CHECKS, results),
        figures=figures[:2],
        sections=what_is_open(results, figures[2]),
        warnings=warnings(results),
    )


def warnings(results: Results) -> tuple[str, ...]:
    """Returns a line for each case with runs that did not reach the end: their numbers are not comparable."""
    lines = []
    for name in CASES:
        ended = [f"{method} ({status})" for method, status in results.case(name).unfinished.items()]
        if ended:
            lines.append(f"In case {name} these runs did not reach the end: {listed(ended)}.")
    return tuple(lines)


def paper_caption(figure: int) -> str:
    """Returns the caption of a figure that the paper has."""
    tolerance = "10⁻³, absolute 10⁻⁶" if figure == 1 else "10⁻⁹, absolute 10⁻⁹"
    text = (
        f"The paper’s Figure {figure}: relative tolerance {tolerance}, signed error test of 2009. "
        "Trajectory, error of the rod’s length, velocity error and total energy; the energy’s final values "
        "stand in the margin. "
    )
    if figure == 1:
        return text + (
            "The thin line is what ‘present’ violates before its state is replaced at the end of a step; "
            "after it, only round-off is left. Values below 10⁻¹⁶, zero among them, are drawn at 10⁻¹⁶."
        )
    return text + (
        "Axes as in Figure 1. A step of ‘present’ that violates the constraint by less than the inner "
        "loop’s 10⁻¹² m is left as it is, hence the points just below that line."
    )


def third_caption(results: Results) -> str:
    """Returns the caption of the figure that the paper does not have."""
    case = results.case("figure3")
    position, both = (energy_change(case.run(m)) for m in ("present-position", "present"))
    return (
        "A figure that the paper does not have: Figure 1 with an honest error test and steps of at most "
        "0.05 s. Replacing the position alone at the end of a step leaves a velocity that points off the "
        f"circle, and the energy changes by {number(position, unit='J', plus=True)}; with the velocity "
        f"replaced as well it changes by {number(both, unit='J', plus=True)}. Note the scale of the energy, "
        "ten times that of Figure 1."
    )
