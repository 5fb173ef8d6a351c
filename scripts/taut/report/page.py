"""Builds the report from the chapters and renders it as one HTML page and as text for the terminal."""

import base64
import re
import shutil
import textwrap
from pathlib import Path

import jinja2
from markupsafe import Markup, escape

from taut.formats import NBSP, listed
from taut.report.document import Figure, Paragraph, Report, Table
from taut.report.problems import PROBLEMS, with_results
from taut.results import Results

TITLE = "taut: the paper says, taut gives"
LEAD = (
    "Each statement of P. Masarati, ‘Adding kinematic constraints to purely differential dynamics’, "
    "Computational Mechanics 47 (2011), that a run can confirm or refute, beside what the runs of taut "
    "give. Every number of taut’s is computed from the CSV files of its runs."
)
CLAIMS_HEADER = ("The paper says", "taut gives", "Verdict")
WIDTH = 110


def build(results: Results) -> Report:
    """Returns the report, and draws the figures that are missing or older than the results.

    A problem that has not been run is left out, and the lead tells.
    """
    problems = with_results(results)
    for problem in problems:
        for figure in problem.figures:
            if figure.can_draw(results):
                figure.save_if_stale(results)
    chapters = tuple(problem.build(results) for problem in problems)
    left_out = [
        f"{problem.title} ({listed(list(problem.missing(results)))})"
        for problem in PROBLEMS
        if problem not in problems
    ]
    lead = LEAD + f" Left out, for want of results: {listed(left_out)}." * bool(left_out)
    return Report(TITLE, lead, chapters)


def write(report: Report, folder: Path) -> tuple[Path, Path]:
    """Writes report.html and report.txt and returns their paths."""
    page, text = folder / "report.html", folder / "report.txt"
    page.write_text(html(report), encoding="utf-8")
    text.write_text(plain(report), encoding="utf-8")
    return page, text


# --- HTML


def html(report: Report) -> str:
    """Returns the report as a page that needs no other file."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"rich": _rich, "embed": _embed}
    environment.tests |= {
        kind.__name__.lower(): lambda block, kind=kind: isinstance(block, kind)
        for kind in (Paragraph, Table, Figure)
    }
    return environment.get_template("page.html.jinja").render(report=report, header=CLAIMS_HEADER)


def _rich(text: str) -> Markup:
    """Returns text for HTML, with what stands between backticks as code."""
    return Markup(re.sub(r"`([^`]*)`", r"<code>\1</code>", str(escape(text))))


def _embed(path: Path) -> str:
    """Returns a picture as a data address."""
    return f"data:image/{path.suffix[1:]};base64," + base64.b64encode(path.read_bytes()).decode("ascii")


# --- Text


def plain(report: Report, width: int = WIDTH) -> str:
    """Returns the report as text of so many columns."""
    lines = [report.title, "=" * len(report.title), "", *_fill(report.lead, width), ""]
    lines += ["   ".join(f"{verdict.sign} {number} {verdict.word}" for verdict, number in report.tally()), ""]
    for chapter in report.chapters:
        lines += [f"{chapter.title}, {chapter.reference}", ""]
        for warning in chapter.warnings:
            lines += [*_fill(f"Warning: {warning}", width), ""]
        rows = [
            (
                claim.paper,
                claim.taut,
                f"{claim.verdict.sign} {claim.verdict.word}" + (f": {claim.because}" * bool(claim.because)),
            )
            for claim in chapter.claims
        ]
        lines += [*_columns((CLAIMS_HEADER, *rows), 3, width, gap=True), ""]
    for chapter in report.chapters:
        for section in chapter.sections:
            title = f"{chapter.title}: {section.title}"
            lines += ["", title, "-" * len(title), ""]
            for block in section.blocks:
                if isinstance(block, Paragraph):
                    lines += _fill(block.text, width)
                elif isinstance(block, Table):
                    lines += [*_fill(block.caption, width), ""]
                    lines += _columns((block.header, *block.rows), block.text_columns, width)
                else:
                    lines += _fill(f"{block.title}. {block.caption}", width)
                    pdf = block.path.with_suffix(".pdf")
                    lines.append(f"  {pdf if block.path.suffix == '.png' else block.path}")
                lines.append("")
    return "\n".join(line.rstrip() for line in lines).replace(NBSP, " ").rstrip() + "\n"


def _fill(text: str, width: int) -> list[str]:
    """Returns text in lines of so many columns; hyphens and no-break spaces hold together."""
    return textwrap.wrap(text, width, break_on_hyphens=False, break_long_words=False) or [""]


def _columns(
    rows: tuple[tuple[str, ...], ...], text_columns: int, width: int, gap: bool = False
) -> list[str]:
    """Returns rows, the first of which is the header, side by side; cells that are too wide are wrapped."""
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    words = [max(len(word) for row in rows for word in row[i].split(" ")) for i in range(len(widths))]
    # Taking from the widest column first leaves the narrow ones, which hold numbers, unbroken.
    while sum(widths) + 2 * (len(widths) - 1) > width and any(map(int.__gt__, widths, words)):
        _, widest = max((columns, i) for i, columns in enumerate(widths) if columns > words[i])
        widths[widest] -= 1
    lines = []
    for number, row in enumerate(rows):
        cells = [_fill(cell, columns) for cell, columns in zip(row, widths, strict=True)]
        for i in range(max(map(len, cells))):
            line = [cell[i] if i < len(cell) else "" for cell in cells]
            pairs = enumerate(zip(line, widths, strict=True))
            lines.append(
                "  ".join(t.ljust(w) if column < text_columns else t.rjust(w) for column, (t, w) in pairs)
            )
        if number == 0:
            lines.append("  ".join("-" * columns for columns in widths))
        elif gap and number < len(rows) - 1:
            lines.append("")
    return lines


def terminal_width() -> int:
    """Returns the width to print at: the terminal's, neither cramped nor sprawling."""
    return min(max(shutil.get_terminal_size((WIDTH, 24)).columns, 80), 130)
