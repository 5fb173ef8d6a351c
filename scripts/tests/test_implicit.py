"""Shipped cases by implicit integrators: the same motion as by the explicit one."""

import csv
import re
import subprocess
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT

from taut.programs import release

# Per step or per evaluation, or what another tolerance changes: not part of the state.
APART = re.compile(r"h|t|energy|work|rank|mu\d*|lambda\d*|phi.*|.*\.[fm][xyz123]|link_force")
# Case, end [s]; the swing up to its event, which magnifies what the tolerance leaves. Not here: what loses
# rank on the way (N four-bar loops, Bricard), and what runs at an error test of its own.
SHIPPED = (
    ("chain/ten", None),
    ("helicopter/figure10_tight", None),
    ("helicopter/soft_control_tight", None),
    ("mechanism/andrews", None),
    ("mechanism/bricard_box", None),
    ("mechanism/double_pendulum", None),
    ("mechanism/four_bar", None),
    ("mechanism/governor", None),
    ("mechanism/heavy_top", None),
    ("mechanism/rolling_disc", None),
    ("mechanism/simple_pendulum", None),
    ("mechanism/slider_crank", None),
    ("mechanism/spatial_slider_crank", None),
    ("pendulum/figure2_standard", None),
    ("pendulum/redundant", None),
    ("swing/out_of_plane", 0.3),
    ("swing/3b", 0.6),
)


@cache
def program(app: str) -> Path:
    return release(app)


def last_rows(case: str, end: float | None, integrator: str, folder: Path) -> dict[str, dict[str, float]]:
    """Runs a case with an integrator at a strict tolerance; returns the last row of each method."""
    text = (ROOT / "cases" / f"{case}.nml").read_text()
    for name, value in (("rtol", 1e-8), ("atol", 1e-10), ("t_end", end)):
        if value is not None:
            text = re.sub(rf"(?m)\b{name} *= *[-+.\de]+", f"{name} = {value}", text)
            if not re.search(rf"\b{name} *=", text):
                text = text.replace("&integration", f"&integration {name} = {value},", 1)
    text = text.replace("&integration", f'&integration integrator = "{integrator}",', 1)
    # The penalty method follows its spring, which is another motion at another tolerance.
    text = re.sub(r'&method\s+name = "penalty"[^/]*/', "", text)
    path = folder / f"{integrator}.nml"
    path.write_text(text)
    app = case.partition("/")[0]
    done = subprocess.run(
        [program(app), path, "--out", folder, "--quiet"],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    with (folder / integrator / "summary.csv").open(newline="") as file:
        summary = list(csv.DictReader(file))
    assert {row["status"] for row in summary} <= {"reached-end", "stopped-by-event"}
    found = {}
    for row in summary:
        with (folder / integrator / f"{row['method']}.csv").open(newline="") as file:
            *_, last = csv.DictReader(file)
        found[row["method"]] = {
            name: float(value) for name, value in last.items() if not APART.fullmatch(name)
        }
        if row["method"].startswith("present"):
            assert max(float(row[name]) for name in ("max_phi", "max_phidot")) < 1e-11
    return found


@pytest.mark.parametrize(("case", "end"), SHIPPED, ids=[case for case, _ in SHIPPED])
def test_a_shipped_case_ends_where_it_ends_explicitly(case: str, end: float | None, tmp_path: Path) -> None:
    explicit, implicit = (last_rows(case, end, name, tmp_path) for name in ("dopri5", "radau"))
    assert explicit.keys() == implicit.keys()
    for method, state in explicit.items():
        other = implicit[method]
        off = {name: abs(other[name] - value) / max(1.0, abs(value)) for name, value in state.items()}
        worst = max(off, key=lambda name: np.nan_to_num(off[name], nan=np.inf))
        assert off[worst] < 1e-4, f"{method}: {worst} is {other[worst]} instead of {state[worst]}"
