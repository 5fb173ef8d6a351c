"""The newcomer's first mechanism is as its page says."""

import re
from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT
from mechanism_runs import blocks, rows, start, table

G = 9.81


@pytest.fixture(scope="session")
def page() -> str:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    return readme.split("## Your first mechanism in five minutes\n")[1].split("\n## ")[0]


@pytest.fixture
def first(page: str, tmp_path: Path) -> Path:
    (tmp_path / "first.nml").write_text(blocks(page)[0])
    return tmp_path


def test_first_mechanism_of_the_readme(mechanism: Path, page: str, first: Path) -> None:
    assert blocks(page)[1] == "fpm run mechanism --profile release -- first.nml\n"
    done = start(mechanism, first, "first.nml")
    assert (done.returncode, done.stderr) == (0, "")
    flat = " ".join(page.split())
    said = re.search(r"It says `([^`]+)`", flat)[1]
    assert said in done.stdout
    run = table(first / "results/first/present.csv")
    axes = [f"{kind}{axis}" for kind in "fm" for axis in "xyz123"]
    columns = {"tip.x", "tip.y", "tip.z", "hinge.angle", *(f"hinge.{axis}" for axis in axes)}
    columns |= {f"rod.{part}" for part in "x y z qa qb qc qd vx vy vz wx wy wz".split()}
    assert columns <= set(run)
    # About the hinge: J = m L^2/3 + m d^2/12, so that the hinge carries m g (1 - (L/2)^2 m/J).
    carried = G * (1 - 0.25 / (1 / 3 + 0.05**2 / 12))
    assert run["hinge.fz"][0] == pytest.approx(carried, abs=1e-9)
    assert f"`hinge.fz` is {carried:.3f} N" in flat
    assert (run["t"][-1], len(run["t"])) == (2.0, 201)
    assert {row["name"]: float(row["value"]) for row in rows(first / "results/first/model.csv")}["rank"] == 5


def test_second_rod_of_the_readme(mechanism: Path, page: str, first: Path) -> None:
    with (first / "first.nml").open("a") as file:
        file.write(blocks(page)[2])
    done = start(mechanism, first, "first.nml")
    assert (done.returncode, done.stderr) == (0, "")
    assert "2 bodies, 2 joints: 12 velocities, 8 constraints of rank 8, 4 degrees of freedom" in done.stdout


def test_driven_hinge_of_the_readme(mechanism: Path, page: str, first: Path) -> None:
    flat = " ".join(page.split())
    function, entry = re.search(r"drive the hinge with `([^`]+)` and `([^`]+)`", flat).groups()
    text = (first / "first.nml").read_text()
    driven = text.replace('type = "revolute"', f'type = "revolute", {entry}')
    assert driven != text
    (first / "first.nml").write_text(f"{driven}\n{function}\n")
    done = start(mechanism, first, "first.nml")
    assert (done.returncode, done.stderr) == (0, "")
    run = table(first / "results/first/present.csv")
    assert run["tip.x"] == pytest.approx(np.cos(3 * run["t"]), abs=1e-9)


def test_misspelt_entry_of_the_readme(mechanism: Path, first: Path) -> None:
    text = (first / "first.nml").read_text()
    (first / "first.nml").write_text(text.replace("thickness", "thicknes"))
    done = start(mechanism, first, "first.nml")
    assert done.returncode == 1
    assert "no entry thicknes; did you mean thickness? The entries are name, mass" in done.stderr
    help_text = start(mechanism, first, "--help-case").stdout
    assert all(f"&{group}" in help_text for group in ("body", "joint", "beam", "rolling", "analysis"))
