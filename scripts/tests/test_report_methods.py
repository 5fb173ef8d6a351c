"""The methods side by side: the exact pendulum, and a table of which nothing is typed."""

import math
from pathlib import Path

import pytest

from taut.report.methods import chapter
from taut.report.methods.measures import CITED, METHODS, PENDULUM, pendulum_angle
from taut.report.pendulum.measures import GRAVITY, LENGTH, PERIOD
from taut.results import Results

LEVELS = ("phi", "phidot", "phiddot")


def test_the_exact_pendulum_keeps_its_energy_and_its_period() -> None:
    assert pendulum_angle(0.0) == pytest.approx(math.pi / 2, abs=1e-12)
    assert pendulum_angle(PERIOD / 4) == pytest.approx(0.0, abs=1e-12)
    for t in (0.1, 0.37, 0.8, 1.9):
        rate = (pendulum_angle(t + 1e-5) - pendulum_angle(t - 1e-5)) / 2e-5
        energy = 0.5 * (LENGTH * rate) ** 2 - GRAVITY * LENGTH * math.cos(pendulum_angle(t))
        assert energy == pytest.approx(0.0, abs=1e-7)
        assert pendulum_angle(t + PERIOD) == pytest.approx(pendulum_angle(t), abs=1e-10)


def test_every_citation_has_a_method_and_every_method_a_citation() -> None:
    found = {label for _, _, labels in CITED for label in labels}
    assert found == {method.label for method in METHODS}


@pytest.mark.parametrize("level", LEVELS)
def test_what_is_kept_is_what_the_runs_say(
    level: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / PENDULUM
    folder.mkdir()
    header = "method," + ",".join(f"max_{name}" for name in LEVELS)
    values = ",".join("1e-3" if name == level else "1e-15" for name in LEVELS)
    (folder / "summary.csv").write_text(f"{header}\nbaseline,{values}\n", encoding="utf-8")
    (folder / "baseline.csv").write_text("t,z,lambda\n0,0,0\n1,-1,29.43\n", encoding="utf-8")
    monkeypatch.setattr(chapter, "error", lambda *_: 1.0)
    row = chapter.glance(Results(tmp_path), METHODS[0])
    assert row[3:6] == tuple("drifts" if name == level else "kept" for name in LEVELS)
    assert row[6:] == ("no", "no", "yes")
