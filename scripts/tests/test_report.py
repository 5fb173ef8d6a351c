"""The report: verdicts follow the numbers, and page and text say the same."""

import html
import re
import shutil
import subprocess
import sys
import tomllib
from dataclasses import fields
from itertools import islice
from pathlib import Path

import pytest
from helicopter_results import CASES as HELICOPTER
from report_results import ALL, Made, write_all, write_case
from swing_results import write_swing

from taut.errors import TautError
from taut.formats import energy_label, listed, number
from taut.gif import write_gif
from taut.report import cases, drawing, page
from taut.report.document import Claim, Held, Table, Verdict
from taut.report.helicopter import chapter as helicopter_chapter
from taut.report.judgment import HONEST, SIGNED
from taut.report.pendulum import chapter as pendulum_chapter
from taut.report.pendulum import claims, claims_energy
from taut.report.pendulum.measures import PERIOD, period, tension_error
from taut.results import Results

SCRIPTS = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Results:
    root = write_all(tmp_path_factory.mktemp("results"))
    return Results(write_swing(root))


@pytest.fixture(scope="module")
def document(results: Results) -> page.Report:
    # Two frames of an animation do for a page; the tests of the problems write them whole.
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(drawing, "write_gif", lambda frames, *rest: write_gif(islice(frames, 2), *rest))
        return page.build(results)


def judged(tmp_path: Path, judge, *arguments: object, **changed: dict[str, Made]) -> Claim:  # noqa: ANN001
    return judge(Results(write_all(tmp_path, **changed)), *arguments)


def test_step_counts_of_the_signed_test_alone_make_a_condition(results: Results) -> None:
    claim = claims.step_count(results, "figure1", 200)
    assert claim.verdict is Verdict.CONDITION and "signed" in claim.because
    assert "206, 185, 214" in claim.taut and "102, 102, 104" in claim.taut


def test_a_step_count_that_is_off_is_not_reproduced(tmp_path: Path) -> None:
    claim = judged(tmp_path, claims.step_count, "figure1", 200, figure1={"baseline": Made(300, 0.0)})
    assert claim.verdict is Verdict.NO and claim.because


def test_step_counts_met_by_both_tests_need_no_condition(tmp_path: Path) -> None:
    near = {m: Made(200, 0.0) for m in ("baseline", "present", "baumgarte")}
    claim = judged(tmp_path, claims.step_count, "figure1", 200, figure1_standard=near)
    assert claim.verdict is Verdict.YES and not claim.because


def test_compliance_is_lost_above_the_tolerance(results: Results, tmp_path: Path) -> None:
    assert claims.compliance(results).verdict is Verdict.YES
    off = {"present": Made(790, 0.0, 2e-12)}
    claim = judged(tmp_path, claims.compliance, figure2=off)
    assert claim.verdict is Verdict.CONDITION and claim.because == HONEST
    assert judged(tmp_path, claims.compliance, figure2=off, figure2_standard=off).verdict is Verdict.NO


def test_energy_per_period_is_judged_by_its_worst_period(results: Results, tmp_path: Path) -> None:
    claim = claims_energy.small_energy_change(results)
    assert claim.verdict is Verdict.CONDITION and "position" in claim.because
    # 1.6 mJ in 10 s, spread evenly, are 0.0039 % of 9.81 J in each period.
    assert "0.0039" in claim.taut
    large = {"present": Made(185, -9.9e-4 * 10 / PERIOD)}
    claim = judged(tmp_path, claims_energy.small_energy_change, figure1=large)
    assert claim.verdict is Verdict.NO


def test_a_reduction_and_the_other_methods(results: Results, tmp_path: Path) -> None:
    assert claims_energy.reduction(results).verdict is Verdict.CONDITION
    assert claims_energy.unlike_the_others(results).because == "baseline and Baumgarte (2, 2) lose energy too"
    gain = {m: Made(200, 0.01) for m in ("present", "baseline", "baumgarte")}
    changed = Results(write_all(tmp_path, figure1=gain))
    assert claims_energy.reduction(changed).verdict is Verdict.NO
    claim = claims_energy.unlike_the_others(changed)
    assert claim.verdict is Verdict.CONDITION and claim.because == SIGNED


def test_tightening(results: Results, tmp_path: Path) -> None:
    verdicts = [claims_energy.tightening(results, m).verdict for m in ("baseline", "baumgarte", "present")]
    assert verdicts == [Verdict.CONDITION, Verdict.CONDITION, Verdict.YES]
    claim = judged(tmp_path, claims_energy.tightening, "present", figure2={"present": Made(790, -1e-3)})
    assert claim.verdict is not Verdict.YES


def test_braun_goldfarb_between_two_values_of_dt(results: Results, tmp_path: Path) -> None:
    assert claims.tight_braun_goldfarb(results).verdict is Verdict.CONDITION
    few = {"braun-goldfarb-0.05": Made(1200, 0.0)}
    assert judged(tmp_path, claims.tight_braun_goldfarb, options2=few).verdict is Verdict.NO


def test_larger_gains_at_both_settings(tmp_path: Path) -> None:
    good = {"baumgarte-2": Made(743, 0, 6e-10, 9e-10), "baumgarte-50": Made(5293, 0, 2e-11, 1e-9)}
    bad = {"baumgarte-2": Made(743, 0, 6e-10, 9e-10), "baumgarte-50": Made(700, 0, 2e-9, 1e-9)}
    for loose, tight, verdict in (
        (good, good, Verdict.YES),
        (bad, good, Verdict.CONDITION),
        (bad, bad, Verdict.NO),
    ):
        write_case(tmp_path, "gains_figure1", loose)
        write_case(tmp_path, "gains", tight)
        claim = claims.larger_gains(Results(tmp_path))
        assert claim.verdict is verdict and f"743 → {5293 if tight is good else 700:,}" in claim.taut
        assert ("shrink" in claim.because and "steps" in claim.because) == (verdict is not Verdict.YES)


def test_a_condition_cannot_be_lost() -> None:
    one, two = Held("with a cap", True), Held("without a cap", False)
    claim = Claim("It moves.", "It does.", (one,), (two,), otherwise="it does not")
    assert (claim.verdict, claim.because) == (Verdict.CONDITION, "with a cap")
    assert Claim("It moves.", "It does.", (one,), (one,)).verdict is Verdict.YES
    claim = Claim("It moves.", "It does.", (two,), (two,), otherwise="it does not")
    assert (claim.verdict, claim.because) == (Verdict.NO, "it does not")
    assert Claim("It moves.", "It does.").verdict is Verdict.NOT_YET
    # A verdict cannot be given, and where there are several settings each has its words.
    assert not {"verdict", "because"} & {field.name for field in fields(Claim)}
    with pytest.raises(ValueError, match="does not name each"):
        Claim("It moves.", "It does.", (Held("", True),), (two,))


def test_every_condition_is_where_the_statement_is_met(document: page.Report) -> None:
    claims = [claim for chapter in document.chapters for claim in chapter.claims]
    conditions = [claim for claim in claims if claim.verdict is Verdict.CONDITION]
    assert conditions
    text, html_page = page.plain(document, 2000), html.unescape(page.html(document, Path()))
    for claim in conditions:
        for held in claim.held:
            assert (held.settings in claim.because) == held.met, claim.paper
        assert claim.because.replace("\u00a0", " ") in text
        assert page._rich(claim.because) in html_page
    assert all(claim.otherwise for claim in claims if claim.verdict is Verdict.NO)


def test_each_row_says_which_files_its_numbers_come_from(document: page.Report, results: Results) -> None:
    chapters = {chapter.title: chapter for chapter in document.chapters}
    steps = next(claim for claim in chapters["Simple pendulum"].claims if claim.paper.startswith("About 200"))
    assert steps.files == (
        results.root / "figure1" / "summary.csv",
        results.root / "figure1_standard" / "summary.csv",
    )
    rows = [claim for chapter in document.chapters for claim in chapter.claims if claim.held]
    assert all(claim.files for claim in rows)


def test_figures_follow_the_rows_that_are_read_from_them(document: page.Report) -> None:
    for chapter in document.chapters:
        groups = chapter.groups
        assert [claim for group in groups for claim in group.claims] == list(chapter.claims)
        shown = [*chapter.opening, *(figure for group in groups for figure in group.figures)]
        assert sorted(shown, key=str) == sorted(chapter.figures, key=str)
        for group in groups:
            for figure in group.figures:
                assert group.claims[-1].figure == figure.path.stem
    titles = [figure.title for chapter in document.chapters for figure in chapter.figures]
    numbered = [title for title in titles if title.startswith("Figure")]
    assert len(set(numbered)) == len(numbered)


def test_the_page_says_what_it_was_made_of(document: page.Report) -> None:
    version = tomllib.loads((SCRIPTS.parent / "fpm.toml").read_text())["version"]
    assert document.made.startswith(f"taut {version}, ")
    assert re.search(r"results of \d{4}-\d\d-\d\d$", document.made)
    assert document.made in page.html(document, Path()) and document.made in page.plain(document)


def test_closed_forms_on_an_exact_run(results: Results, tmp_path: Path) -> None:
    run = results.case("figure2").run("present")
    assert period(run) == pytest.approx(PERIOD, rel=1e-7)
    assert PERIOD == pytest.approx(2.36784195, abs=1e-8)
    assert tension_error(run) < 1e-12
    assert claims.closed_period(results).verdict is Verdict.YES
    path = write_all(tmp_path) / "figure2" / "present.csv"
    lines = path.read_text().splitlines()
    lines[5:] = [re.sub(r"^[^,]+", lambda t: str(1.001 * float(t[0])), line) for line in lines[5:]]
    path.write_text("\n".join(lines))
    claim = claims.closed_period(Results(tmp_path))
    assert claim.verdict is Verdict.CONDITION and claim.because == "at the loose tolerance"


def test_the_page_holds_every_table_and_figure_and_needs_nothing_else(document: page.Report) -> None:
    whole = page.html(document, Path())
    assert not re.search(r"https?://|<script|<link|@import|url\(", whole)
    blocks = [
        block for chapter in document.chapters for section in chapter.sections for block in section.blocks
    ]
    tables = [block for block in blocks if isinstance(block, Table)]
    rows = sum(len(chapter.groups) + bool(chapter.checks) for chapter in document.chapters)
    assert whole.count("<table") == len(tables) + rows
    assert whole.count('src="data:image/png;base64,') == 15
    assert whole.count('src="data:image/gif;base64,') == 2
    assert "prefers-color-scheme: dark" in whole and "@media print" in whole


def test_text_and_page_have_the_same_numbers(document: page.Report) -> None:
    plain_page = re.sub(r"<style>.*?</style>|<[^>]*>", " ", page.html(document, Path()), flags=re.S)
    # Wide enough that no cell is wrapped.
    text = page.plain(document, 2000)
    words = re.compile(r"[+−]?\d[\d.,]*\d|\d")
    clean = html.unescape(plain_page).replace("\u00a0", " ")
    assert set(words.findall(clean)) == set(words.findall(re.sub(r"\S*\.(pdf|gif)", "", text)))


def test_the_text_keeps_to_its_width(document: page.Report) -> None:
    lines = page.plain(document).splitlines()
    assert max(len(line) for line in lines if not line.endswith((".pdf", ".gif"))) <= page.WIDTH
    assert lines[0] == page.TITLE and "The paper says" in "\n".join(lines[:16])


def test_a_run_that_ended_early_is_told(results: Results, document: page.Report, tmp_path: Path) -> None:
    assert document.chapters
    early = {"baseline": Made(206, -0.027, status="max-steps")}
    made = Results(write_all(tmp_path, figure1=early))
    # Figures newer than the results are not drawn again.
    shutil.copytree(results.root / "figures", tmp_path / "figures", copy_function=shutil.copyfile)
    built = page.build(made)
    warning = "In case figure1 these runs did not reach the end: baseline (max-steps)."
    assert built.chapters[0].warnings == (warning,)
    assert warning in page.html(built, tmp_path) and warning in page.plain(built)


def test_the_script_writes_both_and_prints_the_text(results: Results) -> None:
    command = [sys.executable, str(SCRIPTS / "report"), "--results", str(results.root)]
    ended = subprocess.run(command, capture_output=True, text=True, encoding="utf-8", check=True)
    *_, where, tally = ended.stdout.splitlines()
    assert where.startswith("report: ") and re.fullmatch(r"✓ \d+ reproduced .* ○ 0 not yet", tally)
    quiet = subprocess.run(
        [*command, "--quiet"], capture_output=True, text=True, encoding="utf-8", check=True
    )
    assert quiet.stdout.splitlines() == [where, tally]
    assert (results.root / "report.html").stat().st_size > 100_000 and (results.root / "report.txt").exists()


def test_a_missing_summary_column_is_told_in_one_line(tmp_path: Path) -> None:
    path = write_all(tmp_path) / "figure1" / "summary.csv"
    path.write_text(path.read_text().replace("max_phi,", "other,"))
    with pytest.raises(TautError, match=r"figure1/summary\.csv: no column 'max_phi'; it has case, method"):
        claims.compliance(Results(tmp_path))


def test_numbers_as_they_are_read() -> None:
    assert number(-0.0272, 2, "J") == "−0.027\u00a0J"
    assert number(7.4e-8) == "7.4\u00a0×\u00a010⁻⁸"
    assert (
        number(9.99e-4, 2) == "0.0010" and number(0.0) == "0" and number(3.4e-5, plus=True).startswith("+3.4")
    )
    assert energy_label(-7.38e-8) == "−73.8 nJ" and energy_label(0.0332) == "+33.2 mJ"
    assert listed(["a"]) == "a" and listed(["a", "b", "c"]) == "a, b and c"


def test_cases_run_with_the_program_of_their_folder(tmp_path: Path) -> None:
    program = tmp_path / "bin" / "swing"
    program.parent.mkdir()
    program.write_text(
        '#!/bin/sh\ncase $1 in *bad.nml) echo "swing: wrong" >&2; exit 1;; esac\necho $1 >> "$3"\n'
    )
    program.chmod(0o755)
    folder = tmp_path / "cases" / "swing"
    folder.mkdir(parents=True)
    for name in ("one", "two"):
        (folder / f"{name}.nml").touch()
    told: list[int] = []
    jobs = cases.find(tmp_path / "cases", program.parent)
    cases.run_all(jobs, tmp_path / "out", 2, lambda done, job: told.append(done))
    assert told == [1, 2] and len((tmp_path / "out").read_text().splitlines()) == 2
    (folder / "bad.nml").touch()
    jobs = cases.find(tmp_path / "cases", program.parent)
    with pytest.raises(TautError, match=r"bad\.nml failed: swing: wrong"):
        cases.run_all(jobs, tmp_path / "out", 1, lambda done, job: None)


def test_cases_without_a_program_or_with_the_same_name_are_refused(tmp_path: Path) -> None:
    for name in ("a", "b"):
        (tmp_path / "cases" / name).mkdir(parents=True)
        (tmp_path / "cases" / name / "same.nml").touch()
    with pytest.raises(TautError, match="has not been built"):
        cases.find(tmp_path / "cases", tmp_path)
    for name in ("a", "b"):
        (tmp_path / name).touch()
        (tmp_path / name).chmod(0o755)
    with pytest.raises(TautError, match="same folder"):
        cases.find(tmp_path / "cases", tmp_path)


def test_every_made_up_case_is_one_the_report_reads() -> None:
    assert set(pendulum_chapter.CASES) == set(ALL)
    assert set(helicopter_chapter.CASES) == set(HELICOPTER)
