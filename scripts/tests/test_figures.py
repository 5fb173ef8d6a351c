"""The figures are drawn from CSV files alone, and a method looks the same in all of them."""

import subprocess
import sys
from pathlib import Path

import matplotlib.colors
import numpy as np
import pytest
from report_results import ALL, Made, write_case

from taut import style
from taut.errors import TautError
from taut.report.pendulum.figures import FIGURES, four_panels, polar_path
from taut.results import Results

SCRIPTS = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Results:
    root = tmp_path_factory.mktemp("results")
    for case in ("figure1", "figure2", "figure3"):
        write_case(root, case, ALL[case])
    return Results(root)


@pytest.mark.parametrize("spec", FIGURES, ids=lambda spec: spec.name)
def test_each_figure_is_written_as_pdf_and_png(results: Results, spec) -> None:  # noqa: ANN001
    paths = spec.save(results)
    assert [path.suffix for path in paths] == [".pdf", ".png"]
    assert paths[0].read_bytes().startswith(b"%PDF") and paths[1].read_bytes().startswith(b"\x89PNG")
    assert min(path.stat().st_size for path in paths) > 10_000


def test_the_same_results_make_the_same_files(results: Results) -> None:
    first, second = ([path.read_bytes() for path in FIGURES[0].save(results)] for _ in range(2))
    assert first == second


def test_a_method_has_its_color_and_dashes_in_every_panel_of_every_figure(results: Results) -> None:
    style.use()
    for spec in FIGURES:
        figure = spec.draw(results)
        used = {
            line.get_color()
            for axes in figure.axes
            for line in axes.get_lines()
            if len(line.get_xdata()) > 100
        }
        methods = [m for m in style.METHODS if m in ALL[spec.cases[0]]]
        assert {style.METHODS[m].color for m in methods} <= used


def test_methods_are_told_apart_in_color_and_in_gray() -> None:
    looks = list(style.METHODS.values())
    assert len({look.color for look in looks}) == len(looks)
    assert len({(str(look.dashes), look.marker) for look in looks}) == len(looks)
    assert all(matplotlib.colors.is_color_like(look.color) for look in looks)


def test_a_label_has_the_style_of_the_longest_method_that_it_starts_with() -> None:
    assert style.method_style("penalty-1e4") is style.METHODS["penalty"]
    assert style.method_style("present-position") is style.METHODS["present-position"]
    assert style.method_style("something-else").label == "something-else"


def test_errors_of_exactly_zero_are_drawn_on_the_floor(results: Results) -> None:
    style.use()
    figure = four_panels(results, "figure1", ("present", "baseline"), (-50, 40), 50)
    heights = np.concatenate([np.asarray(line.get_ydata(), float) for line in figure.axes[1].get_lines()])
    assert heights.min() == style.FLOOR


def test_the_path_between_steps_stays_on_the_circle(results: Results) -> None:
    radius, _ = polar_path(results.case("figure1").run("present"))
    assert np.abs(radius - 1.0).max() < 1e-12


def test_labels_in_the_margin_keep_their_distance() -> None:
    heights = style.spread([0.0, 0.01, -0.01, 5.0], 1.0, (-10, 10))
    assert np.diff(sorted(heights)).min() > 0.999
    assert heights[3] == pytest.approx(5.0)


def test_a_missing_file_and_a_missing_column_are_told_in_one_line(tmp_path: Path) -> None:
    results = Results(tmp_path)
    with pytest.raises(TautError, match=r"figure1/summary\.csv is missing: run scripts/reproduce first"):
        FIGURES[0].save(results)
    write_case(tmp_path, "figure1", ALL["figure1"])
    path = tmp_path / "figure1" / "present.csv"
    path.write_text(path.read_text().replace("phi_raw", "other"))
    with pytest.raises(TautError, match=r"present\.csv: no column 'phi_raw'; it has t, h, x, z") as caught:
        FIGURES[0].save(results)
    assert "\n" not in str(caught.value)
    path.unlink()
    with pytest.raises(TautError, match=r"present\.csv is missing"):
        FIGURES[0].save(results)


@pytest.mark.parametrize("text", ["", "t,x\n", "t,x\n1,2,3\n", "t,x\n1,abc\n"])
def test_a_damaged_file_is_told_in_one_line(tmp_path: Path, text: str) -> None:
    write_case(tmp_path, "figure1", {"present": Made(10, 0.0)})
    (tmp_path / "figure1" / "present.csv").write_text(text)
    with pytest.raises(TautError, match=r"present\.csv") as caught:
        Results(tmp_path).case("figure1").run("present")
    assert "\n" not in str(caught.value)


def test_the_script_says_what_is_missing_and_fails(tmp_path: Path) -> None:
    command = [sys.executable, str(SCRIPTS / "figures"), "--results", str(tmp_path)]
    ended = subprocess.run(command, capture_output=True, text=True, check=False)
    assert ended.returncode == 1
    assert ended.stderr.startswith("figures: ") and ended.stderr.endswith("run scripts/reproduce first\n")
    assert ended.stderr.count("\n") == 1
