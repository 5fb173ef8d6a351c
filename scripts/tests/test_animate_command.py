"""scripts/animate: files that come of it, and what is refused."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from animate_cases import HANGING, PENDULUM, made
from conftest import ROOT
from PIL import Image

from taut.animate import gallery
from taut.animate.command import main
from taut.results import Results


def test_animation(drawn_pendulum: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = [str(drawn_pendulum / "case.nml"), "--results", str(drawn_pendulum / "results")]
    assert main([*arguments, "--seconds", "0.25", "--below", "hinge.fx"]) == 0
    path = drawn_pendulum / "results/figures/case.gif"
    assert capsys.readouterr().out == f"2 s in 0.25 s\n{path}\n"
    with Image.open(path) as picture:
        assert (picture.n_frames, picture.info["duration"]) == (5, 50)
        first = np.asarray(picture.convert("RGB"))
        picture.seek(4)
        assert (np.asarray(picture.convert("RGB")) != first).any()


def test_still_and_plot(drawn_pendulum: Path) -> None:
    arguments = [str(drawn_pendulum / "case.nml"), str(drawn_pendulum / "results/case/present.csv")]
    still, plot = drawn_pendulum / "new/still.png", drawn_pendulum / "plot.pdf"
    assert main([*arguments, "--still", "1.0", str(still), "--strobe", "2"]) == 0
    assert main([*arguments, "--plot", "hinge.fx", "energy", "--out", str(plot)]) == 0
    assert main([*arguments, "--still", str(drawn_pendulum / "last.png")]) == 0
    assert (drawn_pendulum / "last.png").read_bytes().startswith(b"\x89PNG")
    assert still.read_bytes().startswith(b"\x89PNG") and plot.read_bytes().startswith(b"%PDF")


@pytest.mark.parametrize(
    ("kind", "arguments"), [("equilibrium", []), ("equilibrium", ["--mode", "0"]), ("modes", ["--mode", "0"])]
)
def test_an_equilibrium_is_a_still(
    mechanism: Path, drawn_modes: Path, kind: str, arguments: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    if kind == "equilibrium":
        made(mechanism, drawn_modes, f'&analysis kind = "{kind}" /\n' + HANGING)
    assert main([str(drawn_modes / "case.nml"), "--results", str(drawn_modes / "results"), *arguments]) == 0
    picture = drawn_modes / "results/figures/case.png"
    assert capsys.readouterr().out == f"{picture}\n"
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("kind", "arguments", "part"),
    [
        ("equilibrium", ["--mode", "1"], "is an equilibrium, without modes"),
        ("modes", ["--mode", "2"], "there is no mode 2"),
        ("modes", ["--still", "2.1", "a.png"], "--still 2.1: the mode's period goes from 0 to 2 s"),
        ("modes", ["--plot", "rod.x"], "no times"),
        ("modes", ["--results", "other"], "profile release -- case.nml` first"),
    ],
)
def test_what_cases_without_motion_do_not_have(
    mechanism: Path,
    drawn_modes: Path,
    kind: str,
    arguments: list[str],
    part: str,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(drawn_modes)
    if kind == "equilibrium":
        made(mechanism, drawn_modes, f'&analysis kind = "{kind}" /\n' + HANGING)
    assert main(["case.nml", *arguments]) == 1
    error = capsys.readouterr().err
    assert error.startswith("animate: ") and error.count("\n") == 1 and part in error


@pytest.mark.parametrize(
    ("arguments", "part"),
    [
        (["--plot", "hinge.fz"], "no column 'hinge.fz'; there are hinge.f"),
        (["--trace", "tap"], "'tap'"),
        (["--out", "case.mp4"], "case.mp4: an .mp4 needs the program ffmpeg"),
        (["--out", "case.avi"], "a .gif or an .mp4"),
        (["--still", "soon", "a.png"], "no number"),
        (["--still", "1", "a.xyz"], "xyz"),
        (["--still", "99", "a.png"], "--still 99: the results go from 0 to 2 s"),
        (["--still", "-1", "a.png"], "the results go from 0 to 2 s"),
        (["--still", "nan", "a.png"], "the results go from 0 to 2 s"),
        (["--still", "1", "a.png", "b.png"], "--still takes [TIME] FILE"),
        (["--seconds", "-1"], "--seconds -1"),
        (["--seconds", "0"], "--seconds 0"),
        (["--strobe", "-1"], "--strobe -1"),
        (["--mode", "2"], "--mode 2: case.nml is a motion over time"),
        (["--window", "3", "1", "0", "1"], "--window 3 1 0 1: X1 must be less than X2"),
        (["--window", "0", "1", "1", "1"], "Y1 less than Y2"),
        (["none.csv"], "none.csv is missing: run `fpm run mechanism --profile release -- case.nml` first"),
        (["--from", "3"], "nothing between"),
    ],
    ids=" ".join,
)
def test_bad_arguments_are_told_in_one_line(
    drawn_pendulum: Path,
    arguments: list[str],
    part: str,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(drawn_pendulum)
    monkeypatch.setenv("PATH", "")
    assert main(["case.nml", *arguments]) == 1
    error = capsys.readouterr().err
    assert error.startswith("animate: ") and error.count("\n") == 1 and part in error


def test_results_that_are_missing(drawn_pendulum: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(drawn_pendulum / "case.nml"), "--results", str(drawn_pendulum / "other")]) == 1
    error = capsys.readouterr().err
    assert (
        "other/case/geometry.csv is missing" in error
        and f"release -- {drawn_pendulum / 'case.nml'}`" in error
    )


def test_results_of_another_case_are_refused(
    mechanism: Path, drawn_pendulum: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    made(mechanism, drawn_pendulum, HANGING, "other")
    result = drawn_pendulum / "results/case/present.csv"
    assert main([str(drawn_pendulum / "other.nml"), str(result), "--still", "a.png"]) == 1
    error = capsys.readouterr().err
    assert f"{result.parent} has the results of another case, case" in error and error.count("\n") == 1


def test_a_case_that_has_changed_since_its_run_is_told(
    drawn_pendulum: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    case, picture = drawn_pendulum / "case.nml", drawn_pendulum / "a.png"
    case.write_text(PENDULUM + "! another length\n")
    assert main([str(case), "--results", str(drawn_pendulum / "results"), "--still", str(picture)]) == 0
    said = capsys.readouterr()
    assert f"{case} has changed since the run" in said.err and said.err.count("\n") == 1
    assert said.out == f"{picture}\n"


def test_a_result_without_the_columns_of_its_bodies(
    drawn_pendulum: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = drawn_pendulum / "results/case/present.csv"
    path.write_text(path.read_text().replace("rod.", "bar."))
    assert main([str(drawn_pendulum / "case.nml"), str(path)]) == 1
    assert "no column 'rod.x'" in capsys.readouterr().err


def test_script_asks_for_a_case() -> None:
    command = [sys.executable, str(ROOT / "scripts/animate")]
    ended = subprocess.run(command, capture_output=True, text=True, check=False)
    assert ended.returncode == 2
    assert "give a case file, or --gallery" in ended.stderr


def test_gallery_has_every_shipped_case() -> None:
    # What the report sets side by side are the same mechanisms by other methods.
    cases = (path for path in (ROOT / "cases/mechanism").glob("*.nml") if not path.stem.startswith("side_"))
    assert sorted(recipe.case for recipe in gallery.RECIPES) == sorted(path.stem for path in cases)
    picture = ROOT / "cases/mechanism/gallery.png"
    assert picture.stat().st_size <= 300_000


def test_gallery(drawn_pendulum: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gallery, "RECIPES", (gallery.Recipe("case", "a pendulum", 1.0, 2),))
    paths = gallery.make(Results(drawn_pendulum / "results"))
    assert [path.name for path in paths] == ["case.png", "gallery.png"]
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in paths)
