"""Every solver gives the same motion on the shipped cases, the redundant ones included.

Left out are the longest chain and what has no motion; hundreds of constraints get structured solvers only.
"""

import csv
import re
import subprocess
from functools import cache
from io import StringIO
from pathlib import Path

import f90nml
import pytest
from conftest import ROOT

from taut.programs import release

SOLVERS = ("auto", "banded", "sparse", "pivoted-cholesky", "dgelsd", "factor")
# Short enough for dense solvers, long enough for some hundred right-hand sides.
DURATION = {"pendulum": 1.0, "helicopter": 0.1, "swing": 0.004, "chain": 0.3, "mechanism": 0.1}
# Hundreds of constraints cost a dense solver a second a step.
STRUCTURED = {"n_four_bar40", "hundred_thousand"}
STATIC = {"pendulum_modes"}
CASES = [
    path
    for path in sorted((ROOT / "cases").glob("*/*.nml"))
    if path.parent.name in DURATION and path.stem not in STATIC | {"hundred_thousand"}
]


@cache
def program(app: str) -> Path:
    return release(app)


def variant(path: Path, solvers: tuple[str, ...]) -> str:
    """Returns a shipped case with a tight tolerance, a near end, and a method for each solver."""
    # The parser keeps groups of one name under names of its own, which cannot be taken out by that one.
    shipped = re.sub(r"(?m)^&method\b[^/]*/", "", path.read_text(encoding="utf-8"))
    groups = f90nml.Parser().read(StringIO(shipped))
    old = groups.pop("integration", {})
    groups.pop("output", None)
    start = old.get("t_start", 0.0)
    end = min(old.get("t_end", 10.0), start + DURATION[path.parent.name])
    text = StringIO()
    groups.write(text, sort=False)
    weight = ', weight = "mass"' if path.parent.name in ("mechanism", "swing") else ""
    methods = "\n".join(f'&method label = "{name}", solver = "{name}"{weight} /' for name in solvers)
    return (
        f"{text.getvalue()}\n&integration t_start = {start}, t_end = {end}, rtol = 1e-9, atol = 1e-11 /\n"
        f"&output dt = 100.0 /\n{methods}\n"
    )


def last_row(path: Path) -> dict[str, float]:
    with path.open(newline="", encoding="utf-8") as file:
        return {name: float(value) for name, value in list(csv.DictReader(file))[-1].items()}


@pytest.mark.parametrize("path", CASES, ids=[f"{path.parent.name}/{path.stem}" for path in CASES])
def test_same_motion(path: Path, tmp_path: Path) -> None:
    solvers = SOLVERS[:3] if path.stem in STRUCTURED else SOLVERS
    # Tables that a case names lie beside it.
    case = tmp_path / path.name
    case.write_text(variant(path, solvers))
    for table in path.parent.glob("*.csv"):
        (tmp_path / table.name).write_bytes(table.read_bytes())
    done = subprocess.run(
        [program(path.parent.name), case, "--quiet", "--out", tmp_path],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    rows = {name: last_row(tmp_path / path.stem / f"{name}.csv") for name in solvers}
    reference = rows["sparse"]
    # What is not the state: lengths of steps, violations, and what differs by sums over all columns.
    skipped = {"t", "h", "energy", "rank"}
    state = [name for name in reference if not name.startswith(("phi", "mu")) and name not in skipped]
    scale = max(1.0, *(abs(reference[name]) for name in state if not name.startswith("lambda")))
    for solver, row in rows.items():
        assert row["t"] == reference["t"]
        assert row["rank"] == reference["rank"], solver
        # Rows in very different units are scaled for their singular values: multipliers differ by that.
        redundant = reference["rank"] < sum(name.startswith("lambda") for name in reference)
        unique = list(reference)[: list(reference).index("phi")] if redundant else state
        for name in set(state) & set(unique) if solver in ("dgelsd", "factor") else state:
            size = max(1.0, abs(reference[name])) if name.startswith("lambda") else scale
            assert abs(row[name] - reference[name]) <= 1e-6 * size, (solver, name)
