"""The swing: measures, verdicts, tables and figures, from made-up results."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from swing_results import (
    BASELINE,
    CASES,
    FREQUENCIES,
    Swung,
    wider,
    write_frequencies,
    write_modes,
    write_run,
    write_swing,
)

from taut import style
from taut.errors import TautError
from taut.report import judgment, problems
from taut.report import page as report_module
from taut.report.document import Claim, Table, Verdict
from taut.report.swing import chapter as swing_chapter
from taut.report.swing import claims as swing_claims
from taut.report.swing import claims_modal as swing_claims_modal
from taut.report.swing import convergence, measures
from taut.report.swing import figures as swing
from taut.report.swing import sketch as swing_sketch
from taut.results import Results, Run

YES, CONDITION, NO = Verdict.YES, Verdict.CONDITION, Verdict.NO


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Results:
    return Results(write_swing(tmp_path_factory.mktemp("results")))


@pytest.fixture
def again(results: Results, tmp_path: Path) -> Results:
    """A copy of the results that a test may change."""
    shutil.copytree(results.root, tmp_path, dirs_exist_ok=True)
    return Results(tmp_path)


def judged(again: Results, judge, **changed: Swung) -> Claim:  # noqa: ANN001
    for key, made in changed.items():
        case = key.removeprefix("run_")
        write_run(again.root, case, "baseline" if case in BASELINE else "present", made)
    return judge(again)


def test_the_links_have_their_lengths_in_the_reference_curves() -> None:
    for elements in (2, 4):
        points = measures.positions(measures.reference(elements))
        assert points[0] == pytest.approx(measures.START)
        for i, end in enumerate((0, -1)):
            lengths = np.linalg.norm(points[:, end] - measures.SUPPORTS[i], axis=-1)
            assert np.abs(lengths - measures.LINKS[i]).max() < 1e-7


def test_the_reference_curves_agree_before_the_event_only() -> None:
    pair = measures.reference(2), measures.reference(4)
    assert measures.apart(*pair, end=measures.BEFORE) == pytest.approx(1.02e-4, rel=1e-2)
    assert measures.apart(*pair, start=0.65) > 1e-2


def test_samples_between_uneven_steps_are_of_third_order() -> None:
    errors = []
    for n in (40, 80):
        t = np.linspace(0, 1, n + 1) ** 1.3
        # A time that comes twice, as after an event, counts once.
        t = np.insert(t, 5, t[5])
        times = np.linspace(0, 1, 333)
        found = measures.sample(t, np.stack([np.sin(5 * t), np.cos(5 * t)], -1), times)
        errors.append(np.abs(found - np.stack([np.sin(5 * times), np.cos(5 * times)], -1)).max())
    assert errors[1] < errors[0] / 7 and errors[1] < 1e-4


def test_distances_end_with_the_shorter_run(again: Results) -> None:
    write_run(again.root, "mesh8", "present", Swung(60000, 0.6, 7e-5))
    times, distance = measures.distances(again.case("mesh8").run("present"), measures.reference())
    assert times[-1] == pytest.approx(0.6) and distance.shape == (601, 5)
    assert distance.max() == pytest.approx(7e-5)


def test_the_largest_in_each_interval_keeps_the_peak() -> None:
    t = np.linspace(0, 1, 10001)
    values = np.full_like(t, -1e-3)
    values[7777] = -5.0
    at, most = measures.largest_in_pieces(t, values)
    assert len(at) == 500 and most.max() == 5.0 and abs(at[most.argmax()] - t[7777]) < 2e-3
    assert (most >= 1e-3).all()


def test_the_first_alignment_counts_and_there_may_be_none(again: Results) -> None:
    assert measures.events(again, "1b") == {"link-AC": 0.6399, "link-AE": 0.6475}
    # The run ends before.
    write_run(again.root, "mesh8", "present", Swung(60000, 0.6))
    assert measures.events(again, "mesh8") == {} and measures.event_time(again, "mesh8", "none") is None
    path = again.root / "1b" / "events.csv"
    path.write_text("method,what,t\npresent,link-AC,0.6\n")
    with pytest.raises(TautError, match=r"events\.csv: no columns event and t"):
        measures.events(again, "1b")
    path.unlink()
    assert measures.events(again, "1b") == {}
    assert measures.event_time(again, "1b", "2b") == 0.6399


def test_modes_are_found_by_their_kind(again: Results) -> None:
    assert measures.modes(again) == [(1, 0.443067), (2, 18.17406), (3, 28.45715), (5, 319.4767)]
    write_frequencies(again.root / "table1", FREQUENCIES[:3])
    number, frequency = measures.modes(again)[3]
    assert number == 0 and np.isnan(frequency)
    assert swing_claims.frequencies(again).verdict is NO
    style.use()
    assert "not among the modes" in swing.figure5(again).axes[3].get_title("left")
    assert swing_claims.shapes(again).verdict is NO


def test_the_paper_s_statements_on_results_like_taut_s(results: Results) -> None:
    claims = judgment.judged(swing_claims.CLAIMS, results)
    names = [row.judge.__name__ for row in swing_claims.CLAIMS]
    found = dict(zip(names, claims, strict=True))
    expected = {
        "regularized": NO,
        "beam_step_count": CONDITION,
        "same_steps": CONDITION,
        "beam_drift": CONDITION,
        "goes_on": CONDITION,
        "larger_violations": CONDITION,
        "modal_counts": CONDITION,
        "fewer_steps": NO,
        "simple_counts": CONDITION,
        "axial_mode": CONDITION,
    }
    assert {name: claim.verdict for name, claim in found.items() if claim.verdict is not YES} == expected
    assert all(claim.because for claim in claims if claim.verdict is not YES)


def test_frequencies_are_judged_by_the_digits_that_are_printed(again: Results) -> None:
    assert swing_claims.frequencies(again).verdict is YES
    write_frequencies(again.root / "table1", (("0.4437", *FREQUENCIES[0][1:]), *FREQUENCIES[1:]))
    claim = swing_claims.frequencies(again)
    assert claim.verdict is NO and "first symmetric bending" in claim.because


def test_an_axial_mode_that_is_no_triangle(again: Results) -> None:
    assert swing_claims.shapes(again).verdict is YES
    write_modes(again.root, triangle=1.2)
    assert swing_claims.shapes(again).verdict is NO


def test_steps_of_the_beam(again: Results) -> None:
    taut = swing_claims.same_steps(again).taut
    assert "31,730 (1a_uncapped) and 31,667 (1b_uncapped) without a cap" in taut
    claim = judged(again, swing_claims.same_steps, run_1b=wider("1b", steps=69001))
    assert claim.verdict is NO
    claim = judged(again, swing_claims.beam_step_count, run_1b=wider("1b", steps=34000))
    assert claim.verdict is NO and not claim.remark
    for name in ("1a_uncapped", "1b_uncapped"):
        shutil.rmtree(again.root / name)
    claim = judged(again, swing_claims.same_steps, run_1b=wider("1b"))
    assert claim.verdict is YES and "without" not in claim.taut


def test_baseline_and_present_that_part(again: Results) -> None:
    claim = judged(again, swing_claims.same_motion, run_1b_uncapped=wider("1b_uncapped", off=6e-2))
    assert claim.verdict is CONDITION and claim.because == "with a cap of 10⁻⁵ s on the step"
    claim = judged(again, swing_claims.same_motion, run_1b=wider("1b", off=2.9e-4))
    assert claim.verdict is NO


def test_drift_of_the_beam(again: Results) -> None:
    claim = judged(again, swing_claims.beam_drift, run_1a=wider("1a", phi=1e-9))
    assert claim.verdict is NO and "it drifts before" in claim.because
    claim = judged(again, swing_claims.beam_drift, run_1a=wider("1a", jump=1.0))
    assert claim.verdict is NO
    claim = judged(again, swing_claims.beam_drift, run_1a=wider("1a"))
    assert claim.because == "with a cap of 10⁻⁵ s on the step"


def test_a_beam_that_stops_or_crawls_after_the_event(again: Results) -> None:
    for wrong, said in (
        (wider("1b_long", h_after=1e-7), "1b_long"),
        (wider("1b_long", t_end=0.65, status="step-too-small"), "step-too-small"),
    ):
        claim = judged(again, swing_claims.goes_on, run_1b_long=wrong)
        assert claim.verdict is CONDITION and said in claim.taut
        assert "at a strict tolerance (1b_long)" in claim.because
    for name in ("1b", "1b_uncapped", "1b_uncapped_long"):
        shutil.rmtree(again.root / name)
    assert swing_claims.goes_on(again).verdict is YES


def test_a_run_that_makes_energy_has_not_converged(again: Results) -> None:
    path = again.root / "1b_long" / "present.csv"
    assert "1b_long" not in swing_claims.goes_on(again).because
    lines = path.read_text().splitlines()
    cells = lines[-1].split(",")
    cells[lines[0].split(",").index("energy")] = "1.15"
    path.write_text("\n".join([*lines[:-1], ",".join(cells)]) + "\n")
    claim = swing_claims.goes_on(again)
    assert "0.0640 → 1.15" in claim.taut and "1b_long" in claim.because


def test_alignment_and_impulse(again: Results) -> None:
    assert "0.6399" in swing_claims.alignment(again).taut
    early = wider("2b_tight", t_end=0.642)
    # With A-C alone, since the run ends before the chord.
    assert "never with the chord" in judged(again, swing_claims.alignment, run_2b_tight=early).taut
    weak = wider("1b", peak=0.1)
    assert judged(again, swing_claims.impulse, run_1b=weak).verdict is CONDITION


def test_counts_of_the_modal_model(again: Results) -> None:
    claim = judged(again, swing_claims_modal.modal_counts, run_2b=wider("2b", steps=40000))
    assert claim.verdict is NO
    claim = judged(again, swing_claims_modal.modal_mean_step, run_2b=wider("2b", steps=1000))
    assert claim.verdict is NO
    assert judged(again, swing_claims_modal.fewer_steps, run_2b=wider("2b", steps=60000)).verdict is NO


def test_the_axial_mode(again: Results) -> None:
    same = wider("3b", after=0.0)
    assert judged(again, swing_claims_modal.axial_mode, run_3b=same).verdict is YES
    other = wider("3b", off=5e-3)
    assert judged(again, swing_claims_modal.axial_mode, run_3b=other).verdict is NO


def test_the_transient_and_what_follows(again: Results) -> None:
    assert swing_claims_modal.transient(again).verdict is YES
    assert swing_claims_modal.free_vibrations(again).verdict is YES
    small = {f"run_{name}": wider(name, axial=1e-6) for name in ("2b", "2b_tight")}
    assert judged(again, swing_claims_modal.transient, **small).verdict is NO
    rings = {f"run_{name}": wider(name, ringing=1e-4) for name in ("2b", "2b_tight")}
    assert judged(again, swing_claims_modal.free_vibrations, **rings).verdict is NO


def test_counts_without_the_axial_mode(again: Results) -> None:
    claim = judged(again, swing_claims_modal.simple_counts, run_3b=wider("3b", steps=1004))
    assert claim.verdict is NO
    many = {f"run_{name}": wider(name, steps=2000) for name in ("3a", "3b")}
    assert judged(again, swing_claims_modal.simple_counts, **many).verdict is CONDITION
    claim = judged(again, swing_claims_modal.at_the_cap, run_3b=wider("3b", h=5e-4))
    assert claim.verdict is NO


def test_drift_and_its_cure(again: Results) -> None:
    claim = judged(again, swing_claims_modal.drift_cured, run_2b=wider("2b", phi=1e-9))
    assert claim.verdict is NO
    claim = judged(again, swing_claims_modal.simple_drift, run_3b=wider("3b", phi=1e-3))
    assert claim.verdict is NO
    claim = judged(again, swing_claims_modal.larger_violations, run_1a=wider("1a", phi=1e-3))
    assert claim.verdict is NO


def test_a_modal_model_far_from_the_beam(again: Results) -> None:
    claim = judged(again, swing_claims_modal.close_to_beam, run_2b_tight=wider("2b_tight", off=3e-3))
    assert claim.verdict is NO


def test_mesh_convergence_and_its_rate(results: Results) -> None:
    table, _, instants, _, compared, _ = swing_chapter.against_reference(results)
    assert table.rows[:2] == (
        ("4", "2.8\u00a0×\u00a010⁻⁴", ""),
        ("8", "7.0\u00a0×\u00a010⁻⁵", "2.00"),
    )
    assert [row[2] for row in table.rows[2:]] == ["1.88", "1.98", "2.00"]
    assert [row[0] for row in instants.rows] == ["2 of three nodes, by MBDyn"] + [
        f"{n} of two nodes" for n in (4, 8, 16, 32)
    ]
    assert instants.rows[1][3] == "1.0\u00a0×\u00a010⁻⁴"
    rows = {row[0]: row[1:] for row in compared.rows}
    assert rows["MBDyn"] == ("", "", "0.406")
    assert rows["2b, modal"] == ("1.5", "1.5 (1.00\u00a0s)", "0.407")
    assert rows["1b, 4 elements"] == ("0.28", "0.28 (0.690\u00a0s)", "")


def test_the_continuum_is_where_the_errors_of_the_meshes_point(results: Results) -> None:
    assert (
        np.abs(
            convergence.continuum(results)[1]
            - measures.sample(
                measures.reference()["t"], measures.positions(measures.reference()), np.array([0.6])
            )
        ).max()
        < 1e-12
    )
    errors = convergence.errors(results, "mesh8")
    assert errors[1:] == pytest.approx([7e-5] * 4) and errors[0] == pytest.approx(7e-5)


def test_what_the_meshes_and_integrators_do(results: Results, again: Results) -> None:
    distances, cost, forces, text = convergence.section(results)
    rows = {row[0]: row[1:] for row in distances.rows}
    assert len(rows) == 15 and rows["16, Radau IIA, rtol 10⁻⁴"][-1] == "0.019"
    rows = {row[0]: row[1:] for row in cost.rows}
    assert rows["64, Radau IIA, rtol 10⁻³"][:2] == ("260", "15 %")
    assert rows["4, Dormand–Prince, rtol 10⁻⁶"][:2] == ("56,518", "")
    assert forces.rows[-1] == ("64", "150.0", "0.6400")
    # A thrust counts like a tension.
    thrust = again.root / "mesh64_implicit/summary.csv"
    thrust.write_text(thrust.read_text(encoding="utf-8").replace(",-50,", ",-250,"), encoding="utf-8")
    assert convergence.peaks(again)[64] == (250.0, 0.641)
    assert "on one mesh in the whole run: 0, 0, 0, 0 and 0 mm" in text.text
    shutil.rmtree(again.root / "mesh64_implicit")
    assert convergence.section(again) == ()


def test_the_implicit_form_is_judged_by_motion_and_constraints(again: Results) -> None:
    assert swing_claims.fully_implicit(again).verdict is YES
    off = wider("mesh16_implicit_loose", off=3e-4)
    claim = judged(again, swing_claims.fully_implicit, run_mesh16_implicit_loose=off)
    assert claim.verdict is CONDITION and claim.because.startswith("at a strict tolerance")
    off = wider("mesh16_implicit", phi=1e-9)
    assert judged(again, swing_claims.fully_implicit, run_mesh16_implicit=off).verdict is NO


def test_table_2_has_the_paper_s_numbers_beside_the_runs(results: Results) -> None:
    table, _ = swing_chapter.table_2(results)
    rows = {row[0]: row[1:] for row in table.rows}
    assert rows["(2b) Modal, present"][:4] == ("1.00", "28,103", "1.00", "18,728")
    assert rows["(1b) without the cap of 10⁻⁵ s"][:4] == ("", "", "0.69", "31,667")


@pytest.mark.parametrize("spec", swing.FIGURES, ids=lambda spec: spec.name)
def test_each_figure_is_written(results: Results, spec) -> None:  # noqa: ANN001
    paths = spec.save(results)
    assert [path.suffix[1:] for path in paths] == list(spec.kinds)
    assert min(path.stat().st_size for path in paths) > 10_000
    if spec.kinds == ("gif",):
        with Image.open(paths[0]) as picture:
            assert picture.n_frames > 60 and picture.info["loop"] == 0
        assert paths[0].stat().st_size < 4_000_000


def test_markers_are_told_apart_in_color_and_in_gray() -> None:
    assert len(set(swing_sketch.COLORS.values())) == len(set(swing_sketch.SHAPES.values())) == 5


def test_the_beam_is_drawn_through_its_markers() -> None:
    points = measures.START + np.array([[0, 0.1], [0, 0.02], [0, -0.03], [0, 0.0], [0, 0.2]])
    curve = swing_sketch.smooth(points)
    assert curve[::20] == pytest.approx(points)


def test_a_figure_is_drawn_anew_when_the_reference_curves_are_newer(
    again: Results, monkeypatch: pytest.MonkeyPatch
) -> None:
    (spec,) = (spec for spec in swing.FIGURES if spec.name == "swing_figure4")
    assert spec.files == measures.REFERENCES
    drawn: list[str] = []
    monkeypatch.setattr(type(spec), "write", lambda self, results, paths: drawn.append(self.name))
    for path in again.root.glob("figures/*"):
        path.unlink()
    spec.save_if_stale(again)
    spec.save(again)
    assert drawn == ["swing_figure4"] * 2


@pytest.mark.parametrize(
    "without", [(), ("1a",), ("2b", "2b_tight"), ("3a", "3b", "table1"), tuple(set(CASES) - {"1b"})]
)
def test_a_report_without_some_cases(results: Results, tmp_path: Path, without: tuple[str, ...]) -> None:
    ignored = shutil.ignore_patterns(*without, "figures")
    shutil.copytree(results.root, tmp_path, ignore=ignored, dirs_exist_ok=True)
    chapter = swing_chapter.build(Results(tmp_path))
    assert all(claim.verdict is not Verdict.NOT_YET for claim in chapter.claims)
    told = " ".join(chapter.warnings)
    assert all((name in told) == (name in without) for name in ("1a", "2b", "3b"))
    for section in chapter.sections:
        assert section.blocks
        assert all(block.rows for block in section.blocks if isinstance(block, Table))


def test_a_problem_without_results_is_left_out_and_the_lead_tells(tmp_path: Path) -> None:
    with pytest.raises(TautError, match="no complete set of results: run scripts/reproduce first"):
        report_module.build(Results(tmp_path))
    with pytest.raises(TautError, match="has no results: run scripts/reproduce first"):
        problems.drawable(Results(tmp_path))
    write_swing(tmp_path, without=tuple(set(CASES) - {"1a", "1b"}))
    document = report_module.build(Results(tmp_path))
    assert [chapter.title for chapter in document.chapters] == ["Swing"]
    assert "Simple pendulum (figure1" in document.lead
    names = [spec.name for spec in problems.drawable(Results(tmp_path))]
    assert names == ["swing_figure3", "swing_figure6"]


def test_an_early_end_is_told(tmp_path: Path) -> None:
    only = tuple(set(CASES) - {"1b"})
    write_swing(tmp_path, without=only, run_1b=wider("1b", t_end=0.65, status="max-steps"))
    warning = "In case 1b these runs did not reach the end: present (max-steps)."
    assert warning in swing_chapter.warnings(Results(tmp_path))


def test_a_history_that_is_written_anew_is_read_anew(tmp_path: Path) -> None:
    write_swing(tmp_path, without=tuple(set(CASES) - {"1b"}))
    first = Results(tmp_path).case("1b").run("present")
    assert Results(tmp_path).case("1b").run("present") is first
    write_swing(tmp_path, without=tuple(set(CASES) - {"1b"}), run_1b=wider("1b", t_end=0.3))
    assert isinstance(first, Run) and Results(tmp_path).case("1b").run("present").steps == 300


def test_every_made_up_case_is_one_the_report_reads() -> None:
    assert set(swing_chapter.CASES) == set(CASES)
