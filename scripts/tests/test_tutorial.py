"""The tutorial of mechanisms, step by step as its reader does it."""

import os
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest
from mechanism_runs import blocks, rows, table

from taut.programs import release

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "cases/mechanism/README.md").read_text(encoding="utf-8").split("\n## ")[1]
PRESS, RUN, MOMENT, DRIVE, SPRING, BUSHING, PICTURES, SWEEP = blocks(
    re.sub(r"(?s)```toml\n.*?```\n", "", PAGE)
)
TOML = re.search(r"(?s)```toml\n(.*?)```", PAGE)[1]


@pytest.fixture(scope="module")
def mechanism() -> Path:
    return release("mechanism")


def done(folder: Path, *command: str | Path, **variables: str) -> str:
    ran = subprocess.run(
        command,
        cwd=folder,
        capture_output=True,
        text=True,
        env=os.environ | {"OPENBLAS_NUM_THREADS": "1"} | variables,
        check=False,
        timeout=120,
    )
    assert ran.returncode == 0, ran.stderr
    return ran.stdout


@pytest.fixture
def driven(tmp_path: Path) -> Path:
    """Saves the slider-crank with its motor and its spring."""
    entry = re.search(r"with `(drive_angle[^`]+)` in the `&joint` of the bearing", PAGE)[1]
    press = PRESS.replace('name = "bearing"', f'name = "bearing", {entry}')
    (tmp_path / "press.nml").write_text(press + DRIVE + SPRING, encoding="utf-8")
    return tmp_path


def test_slider_crank(mechanism: Path, tmp_path: Path) -> None:
    assert RUN == "fpm run mechanism --profile release -- press.nml\n"
    (tmp_path / "press.nml").write_text(PRESS, encoding="utf-8")
    assert re.search(r"says `(3 bodies[^`]+)`", " ".join(PAGE.split()))[1] in done(
        tmp_path, mechanism, "press.nml"
    )


def test_moment(mechanism: Path, tmp_path: Path) -> None:
    (tmp_path / "press.nml").write_text(PRESS + MOMENT, encoding="utf-8")
    done(tmp_path, mechanism, "press.nml")
    run = table(tmp_path / "results/press/present.csv")
    # What the moment does is the kinetic energy.
    turned = np.unwrap(run["crank.angle"])
    assert run["energy"] - run["energy"][0] == pytest.approx(0.5 * turned, rel=2e-6, abs=1e-6)


def test_bushing(mechanism: Path, tmp_path: Path) -> None:
    (tmp_path / "press.nml").write_text(PRESS + BUSHING, encoding="utf-8")
    done(tmp_path, mechanism, "press.nml")
    # It is relaxed at the start, where nothing else acts.
    run = table(tmp_path / "results/press/present.csv")
    assert run["slider.x"] == pytest.approx(run["slider.x"][0], abs=1e-9)


def test_drive_spring_and_reactions(mechanism: Path, driven: Path) -> None:
    said = done(driven, mechanism, "press.nml")
    assert re.search(r"`(velocities corrected[^`]+)`", PAGE)[1] in said
    assert " 0 degrees of freedom" in said
    run = table(driven / "results/press/present.csv")
    angle = 10.0 * run["t"]
    place = 0.1 * np.cos(angle) + np.sqrt(0.09 - 0.01 * np.sin(angle) ** 2)
    assert run["slider.x"] == pytest.approx(place, abs=1e-9)
    assert run["guide.displacement"] == pytest.approx(place - 0.4, abs=1e-9)
    # The motor's work is the energy and what the damper took.
    speed = run["slider.vx"]
    power = run["bearing.mz"] * 10.0 - 2.0 * speed**2
    work = np.concatenate([[0.0], np.cumsum((power[1:] + power[:-1]) / 2 * np.diff(run["t"]))])
    assert run["energy"] - run["energy"][0] == pytest.approx(work, abs=2e-4 * np.abs(work).max())
    # Along its guide the slider has the rod, which pushes with small_end's force, and the spring.
    spring = 200.0 * (run["slider.x"] - 0.4) + 2.0 * speed
    acceleration = np.gradient(speed, run["t"])
    pushed = 0.5 * acceleration + spring
    assert run["small_end.fx"][2:-2] == pytest.approx(pushed[2:-2], abs=2e-3 * np.abs(pushed).max())
    # Across it, the guide and the rod: no weight.
    assert run["guide.fy"] == pytest.approx(-run["small_end.fy"], abs=1e-9)


def test_pictures(mechanism: Path, driven: Path) -> None:
    done(driven, mechanism, "press.nml")
    for line in PICTURES.splitlines():
        command = line.split("#")[0].split()
        assert command[0] == "scripts/animate"
        if "--plot" in command:
            done(driven, ROOT / command[0], *command[1:])
            assert list((driven / "results/figures").iterdir())


def test_sweep(mechanism: Path, driven: Path) -> None:
    folder = driven / "cases/press"
    folder.mkdir(parents=True)
    (driven / "press.nml").rename(folder / "press.nml")
    (folder / "speed.toml").write_text(TOML, encoding="utf-8")
    for line in SWEEP.splitlines():
        command = line.split("#")[0].split()
        assert command[0] == "scripts/sweep"
        done(driven, ROOT / command[0], *command[1:], TAUT_BIN=str(mechanism.parent))
    found = rows(driven / "results/sweeps/speed/table.csv")
    assert len(found) == 9
    # Faster and heavier takes more.
    moments = {(float(row["mass"]), float(row["rate"])): float(row["moment"]) for row in found}
    assert moments[2.0, 20.0] > moments[0.5, 20.0] > moments[0.5, 10.0] > 0.0
