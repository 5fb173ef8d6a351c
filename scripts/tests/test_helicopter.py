"""The helicopter blade: kinematics, measures, verdicts and figures, from made-up results."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from helicopter_results import (
    FLAP,
    MODEL,
    PENALTY,
    PRESENT,
    TIGHT,
    Blade,
    pitch,
    write_blade,
    write_helicopter,
)
from PIL import Image

from taut import style
from taut.errors import TautError
from taut.report import judgment
from taut.report.document import Claim, Verdict
from taut.report.helicopter import chapter as helicopter_chapter
from taut.report.helicopter import claims as helicopter_claims
from taut.report.helicopter import figures as helicopter
from taut.report.helicopter import measures
from taut.report.helicopter import sketch as helicopter_sketch
from taut.results import Results, Run


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Results:
    return Results(write_helicopter(tmp_path_factory.mktemp("results")))


def judged(tmp_path: Path, judge, **changed: dict[str, Blade]) -> Claim:  # noqa: ANN001
    return judge(Results(write_helicopter(tmp_path, **changed)))


def test_point_a_at_rest_and_after_quarter_turns() -> None:
    quarter = np.pi / 2
    assert measures.point_a(MODEL, 0.0, 0.0) == pytest.approx([0.25, 0.2, 0.0])
    assert measures.point_a(MODEL, quarter, 0.0) == pytest.approx([0.2, 0.2, 0.05])
    assert measures.point_a(MODEL, 0.0, quarter) == pytest.approx([0.25, 0.0, 0.2])


def test_the_rate_of_the_violation_is_its_derivative() -> None:
    t = np.linspace(0.0, 0.1, 20001)
    beta, theta = 0.3 * np.sin(40 * t), 0.2 * np.cos(70 * t)
    rates = 12 * np.cos(40 * t), -14 * np.sin(70 * t)
    names = ("t", "beta", "theta", "beta_rate", "theta_rate")
    run = Run(Path(), dict(zip(names, (t, beta, theta, *rates), strict=True)))
    phi, phidot = measures.violation(MODEL, run)
    assert np.abs(np.gradient(phi, t)[1:-1] - phidot[1:-1]).max() < 1e-5 * np.abs(phidot).max()


def test_steps_are_filled_in_with_their_rates(results: Results) -> None:
    run = results.case("figure10").run("present")
    t, value, rate = measures.fill(run, "beta")
    assert np.abs(value - FLAP * np.sin(40 * t)).max() < 1e-4 * FLAP
    assert np.abs(rate - 40 * FLAP * np.cos(40 * t)).max() < 5e-3 * 40 * FLAP


def test_harmonics_and_frequency_of_a_known_run(results: Results) -> None:
    case = results.case("figure10")
    amplitude = measures.harmonics(case.model, case.run("present"), "link_force")
    assert amplitude == pytest.approx([0, 0, 3.4e-3, 0, 0], abs=1e-6)
    found = measures.dominant_frequency(case.model, case.run("penalty"))
    assert found == pytest.approx(10.55 * 40, rel=1e-2)


def test_the_third_harmonic_is_that_of_the_exact_link() -> None:
    # The pitch that the link asks for on one turn; then the force from the equation of the pitch.
    t = 2 * np.pi / 40 * np.arange(256) / 256
    theta = pitch(FLAP * np.sin(40 * t))
    spectrum = np.fft.rfft(theta) / 128
    order = np.arange(len(spectrum))
    force = np.abs(MODEL["i_f"] * 40**2 * (1 - order**2) * spectrum) / MODEL["y_theta"]
    assert force[3] == pytest.approx(measures.third_harmonic(MODEL, FLAP), rel=1e-2)
    assert force[2] < 0.01 * force[3]


def test_the_paper_s_statements_on_results_like_taut_s(results: Results) -> None:
    claims = judgment.judged(helicopter_claims.CLAIMS, results)
    yes, condition, no = Verdict.YES, Verdict.CONDITION, Verdict.NO
    expected = {
        "constraint_steps": yes,
        "penalty_steps": condition,
        "comparable": condition,
        "stiffer": condition,
        "soft_frequency": yes,
        "soft_rates": condition,
        "soft_violation": condition,
        "no_drift": yes,
        "baseline_drift": condition,
        "oscillation": condition,
        "unloaded": yes,
        "second_harmonic": no,
        "multiplier": condition,
    }
    names = [row.judge.__name__ for row in helicopter_claims.CLAIMS]
    assert dict(zip(names, (claim.verdict for claim in claims), strict=True)) == expected
    assert all(claim.because for claim in claims if claim.verdict is not yes)


def test_step_counts(tmp_path: Path) -> None:
    claim = judged(tmp_path, helicopter_claims.constraint_steps, figure10={"present": Blade(210)})
    assert claim.verdict is not Verdict.YES
    claim = judged(
        tmp_path, helicopter_claims.penalty_steps, figure10={"penalty": replace(PENALTY, steps=690)}
    )
    assert claim.because == "counting accepted steps, with an honest error test"
    claim = judged(
        tmp_path, helicopter_claims.penalty_steps, figure10={"penalty": replace(PENALTY, steps=900)}
    )
    assert claim.verdict is Verdict.NO


def test_a_stiffer_control_system_that_converges(tmp_path: Path) -> None:
    claim = judged(tmp_path, helicopter_claims.stiffer, stiff_control={"penalty": Blade(7000, 0, 1e-6, 21.0)})
    assert claim.verdict is Verdict.NO
    runs = {"penalty": Blade(7000, 0, 1.5, 21.0)}
    claim = judged(tmp_path, helicopter_claims.stiffer, stiff_control_tight=runs)
    assert claim.verdict is Verdict.YES


def test_implicit_steps_at_any_stiffness(tmp_path: Path) -> None:
    assert judged(tmp_path, helicopter_claims.implicit_steps).verdict is Verdict.YES
    for slow in (Blade(700, 24, 5e-7), Blade(620, 24, 1e-2)):
        claim = judged(tmp_path, helicopter_claims.implicit_steps, rigid_control={"penalty": slow})
        assert claim.verdict is Verdict.NO


def test_drift(tmp_path: Path) -> None:
    claim = judged(tmp_path, helicopter_claims.no_drift, figure10={"penalty": replace(PENALTY, drift=5e-3)})
    assert claim.verdict is Verdict.CONDITION and claim.because == "at a strict tolerance"
    claim = judged(tmp_path, helicopter_claims.baseline_drift, figure10={"baseline": PRESENT})
    assert claim.verdict is Verdict.NO


def test_harmonics_of_the_link_force(tmp_path: Path) -> None:
    runs = {"present": Blade(374, 8, harmonic=2)}
    claim = judged(tmp_path, helicopter_claims.second_harmonic, figure10_tight=runs)
    assert claim.verdict is Verdict.YES


def test_a_multiplier_that_is_not_small(tmp_path: Path) -> None:
    claim = judged(tmp_path, helicopter_claims.multiplier, figure10={"present": replace(PRESENT, mu=1.0)})
    assert claim.verdict is Verdict.NO


def test_an_automatic_first_step_is_a_condition(tmp_path: Path) -> None:
    root = write_helicopter(tmp_path)
    write_blade(root, "figure10_automatic", {"baseline": Blade(203), "present": Blade(203)})
    claim = helicopter_claims.constraint_steps(Results(root))
    assert claim.verdict is Verdict.CONDITION and "automatic" not in claim.because
    assert "203 and 203 with an automatic first step" in claim.taut


def test_the_flap_has_its_amplitude_in_closed_form(tmp_path: Path) -> None:
    claim = judged(tmp_path, helicopter_claims.flap_amplitude)
    assert "0.02977" in claim.paper.replace("\u00a0", " ") and "0.0298" in claim.taut
    # Another moment, another amplitude.
    assert claim.verdict is not Verdict.NO
    for name in ("figure10", "figure10_tight"):
        path = tmp_path / name / "model.csv"
        path.write_text(path.read_text().replace("gamma,8.0", "gamma,9.0"))
    assert helicopter_claims.flap_amplitude(Results(tmp_path)).verdict is Verdict.NO


def test_a_soft_control_system(tmp_path: Path) -> None:
    same = {"penalty": TIGHT}
    claim = judged(tmp_path, helicopter_claims.soft_frequency, soft_control_tight=same)
    assert claim.verdict is Verdict.CONDITION and claim.because == "at the paper’s tolerance"
    claim = judged(tmp_path, helicopter_claims.soft_rates, soft_control={"penalty": PENALTY})
    assert claim.verdict is Verdict.NO
    large = {"penalty": Blade(263, 66, 2e-2, 5.6)}
    claim = judged(tmp_path, helicopter_claims.soft_violation, soft_control=large)
    assert claim.verdict is Verdict.YES


def test_table_3_has_the_model_s_numbers(results: Results) -> None:
    _, table = helicopter_chapter.table_3(results)
    rows = {row[0]: row[1:] for row in table.rows}
    assert rows["Rotor angular velocity, Ω"] == ("40.0", "40.000", "rad/s")
    assert rows["… its square, ν_β²"][1] == "1.0625"
    assert rows["Control system stiffness, K_c (computed)"][1] == "16,538"


def test_a_missing_or_foreign_model_is_told_in_one_line(tmp_path: Path) -> None:
    results = Results(write_helicopter(tmp_path))
    path = tmp_path / "figure10" / "model.csv"
    path.write_text("a,b\n1,2\n")
    with pytest.raises(TautError, match=r"model\.csv: the columns are a, b and should be name, value, unit"):
        _ = results.case("figure10").model
    path.write_text("name,value,unit\nomega,fast,rad/s\n")
    with pytest.raises(TautError, match=r"model\.csv: could not convert"):
        _ = results.case("figure10").model
    path.unlink()
    with pytest.raises(TautError, match=r"model\.csv is missing: run scripts/reproduce first"):
        helicopter_sketch.figure9(results)


@pytest.mark.parametrize("spec", helicopter.FIGURES, ids=lambda spec: spec.name)
def test_each_figure_is_written(results: Results, spec) -> None:  # noqa: ANN001
    paths = spec.save(results)
    assert [path.suffix[1:] for path in paths] == list(spec.kinds)
    assert min(path.stat().st_size for path in paths) > 10_000
    if spec.kinds == ("gif",):
        with Image.open(paths[0]) as picture:
            assert picture.n_frames > 30 and picture.info["loop"] == 0
        assert paths[0].stat().st_size < 3_000_000


def test_the_sketch_has_the_model_s_dimensions(results: Results) -> None:
    style.use()
    texts = [
        text.get_text()
        for axes in helicopter_sketch.figure9(results).axes
        for text in axes.texts
        if text.get_text()
    ]
    for label in (r"$x_\beta$ = 0.2 m", r"$x_\theta$ = 0.05 m", r"$y_\theta$ = 0.2 m", r"$L$ = 0.15 m"):
        assert label in texts
    assert r"$z_B$ = −0.15 m" in texts


def test_the_link_keeps_its_length_in_the_picture_s_space() -> None:
    a, b = measures.point_a(MODEL, 0.0, 0.0), measures.point_b(MODEL, 0.0)
    assert np.linalg.norm(a - b) == pytest.approx(MODEL["length"])
    # The view turns space rigidly: no length grows.
    points = np.random.default_rng(1).normal(size=(50, 3))
    assert (
        np.linalg.norm(helicopter_sketch.view(points), axis=1) <= np.linalg.norm(points, axis=1) + 1e-12
    ).all()
