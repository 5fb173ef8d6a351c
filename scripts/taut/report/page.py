"""Builds the report from the chapters and renders it as one HTML page and as text for the terminal."""

import base64
import os
import re
import shutil
import subprocess
import textwrap
import tomllib
from datetime import UTC, datetime
from pathlib import Path

import jinja2
from markupsafe import Markup, escape

from taut.bootstrap import ROOT
from taut.formats import NBSP, listed
from taut.report.document import Claim, Figure, Held, Paragraph, Report, Table, Verdict
from taut.report.problems import PROBLEMS, with_results
from taut.results import LAST_FILES, Results

TITLE = "taut: the paper says, taut gives"
LEAD = (
    "Each statement of P. Masarati, ‘Adding kinematic constraints to purely differential dynamics’, "
    "Computational Mechanics 47 (2011), that a run can confirm or refute, beside what the runs of taut "
    "give. Every number of taut’s is computed from the CSV files of its runs."
)
CLAIMS_HEADER = ("The paper says", "taut gives", "Paper’s settings", "Strict settings", "Verdict")
GALLERY = (
    "Each shipped case of `mechanism` at a time of its motion, with earlier positions and traces; "
    "`scripts/animate` draws any mechanism so."
)
WIDTH = 130


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
        f"{problem.title} ({_told(problem.missing(results))})"
        for problem in PROBLEMS
        if problem not in problems
    ]
    lead = LEAD + f" Left out, for want of results: {listed(left_out)}." * bool(left_out)
    return Report(TITLE, lead, chapters, made(results), gallery(results))


def _told(names: tuple[str, ...], most: int = 3) -> str:
    """Returns the names of cases, or how many there are behind the first."""
    return listed(list(names)) if len(names) <= most else f"{names[0]} and {len(names) - 1} others"


def made(results: Results) -> str:
    """Returns the version of taut, its commit where there is one, and the day of the newest results."""
    version = tomllib.loads((ROOT / "fpm.toml").read_text(encoding="utf-8"))["version"]
    asked = ["git", "-C", str(ROOT), "describe", "--always", "--dirty"]
    try:
        commit = subprocess.run(asked, capture_output=True, text=True, check=False).stdout.strip()
    except OSError:
        commit = ""
    newest = max(path.stat().st_mtime for name in LAST_FILES for path in results.root.glob(f"*/{name}"))
    day = datetime.fromtimestamp(newest, UTC)
    return ", ".join(
        filter(None, (f"taut {version}", commit and f"commit {commit}", f"results of {day:%Y-%m-%d}"))
    )


def gallery(results: Results) -> Figure | None:
    """Returns the picture of all mechanisms if it has been drawn."""
    path = results.root / "figures" / "gallery" / "gallery.png"
    return Figure("Mechanisms", path, GALLERY) if path.is_file() else None


def write(report: Report, folder: Path) -> tuple[Path, Path]:
    """Writes report.html and report.txt and returns their paths."""
    page, text = folder / "report.html", folder / "report.txt"
    page.write_text(html(report, folder), encoding="utf-8")
    text.write_text(plain(report), encoding="utf-8")
    return page, text


# --- HTML


def html(report: Report, folder: Path) -> str:
    """Returns the report as a page for a folder: it needs no other file, but links to the figures there."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {
        "rich": _rich,
        "embed": _embed,
        "beside": lambda path: _beside(path, folder),
        "cases": _cases,
        "held": _held,
    }
    environment.tests |= {
        kind.__name__.lower(): lambda block, kind=kind: isinstance(block, kind)
        for kind in (Paragraph, Table, Figure)
    }
    return environment.get_template("page.html.jinja").render(report=report, header=CLAIMS_HEADER)


def _beside(path: Path, folder: Path) -> str:
    """Returns how a page in a folder refers to a file."""
    return os.path.relpath(path, folder)


def _cases(files: tuple[Path, ...]) -> str:
    """Returns the files that numbers come from, those of one case together."""
    cases: dict[str, list[str]] = {}
    for path in files:
        cases.setdefault(path.parent.name, []).append(path.name)
    return "; ".join(f"{case}: {', '.join(names)}" for case, names in cases.items())


def _held(held: tuple[Held, ...]) -> str:
    """Returns where a statement is met and where not."""
    return "; ".join(
        f"{(Verdict.YES if one.met else Verdict.NO).sign} {one.settings}".strip() for one in held
    )


def _rich(text: str) -> Markup:
    """Returns text for HTML, with what stands between backticks as code."""
    return Markup(re.sub(r"`([^`]*)`", r"<code>\1</code>", str(escape(text))))


def _embed(path: Path) -> str:
    """Returns a picture as a data address."""
    return f"data:image/{path.suffix[1:]};base64," + base64.b64encode(path.read_bytes()).decode("ascii")


# --- Text


def plain(report: Report, width: int = WIDTH) -> str:
    """Returns the report as text of so many columns."""
    lines = [report.title, "=" * len(report.title), "", report.made, "", *_fill(report.lead, width), ""]
    lines += [report.tally_line(), ""]
    for chapter in report.chapters:
        lines += [f"{chapter.title}, {chapter.reference}", ""]
        for warning in chapter.warnings:
            lines += [*_fill(f"Warning: {warning}", width), ""]
        lines += [*_rows(chapter.claims, width), ""]
        if chapter.checks:
            lines += [f"{chapter.title}: closed forms, of which the paper says nothing", ""]
            lines += [*_rows(chapter.checks, width), ""]
    for chapter in report.chapters:
        for figure in chapter.figures:
            lines += [*_figure(figure, width), ""]
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
                    lines += _figure(block, width)
                lines.append("")
    if report.gallery:
        lines += _figure(report.gallery, width)
    return "\n".join(line.rstrip() for line in lines).replace(NBSP, " ").rstrip() + "\n"


def _rows(claims: tuple[Claim, ...], width: int) -> list[str]:
    """Returns a table of statements."""
    rows = [
        (
            claim.paper,
            f"{claim.taut} [{_cases(claim.files)}]" if claim.files else claim.taut,
            _held(claim.at_paper),
            _held(claim.strict),
            f"{claim.verdict.sign} {claim.verdict.word}" + (f": {claim.because}" * bool(claim.because)),
        )
        for claim in claims
    ]
    return _columns((CLAIMS_HEADER, *rows), len(CLAIMS_HEADER), width, gap=True)


def _figure(figure: Figure, width: int) -> list[str]:
    """Returns a figure's title and caption, and where it is."""
    pdf = figure.path.with_suffix(".pdf")
    path = pdf if pdf.is_file() else figure.path
    return [*_fill(f"{figure.title}. {figure.caption}", width), f"  {path}"]


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
