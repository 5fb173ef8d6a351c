"""The chapter of the formulation on made-up runs: what it says of exact ones, and of ones that are not."""

from pathlib import Path

import numpy as np
import pytest
from report_results import FOUR, Made, history, write_case

from taut.report.document import Claim, Verdict
from taut.report.formulation import claims
from taut.report.formulation.measures import (
    CENTER,
    CRANK,
    CRANK_RATE,
    ROD,
    ROLLING_RADIUS,
    TURNING_RATE,
    circle_error,
    slider_error,
)
from taut.report.judgment import judged
from taut.results import Results

T = np.linspace(0.0, 2.0, 81)
SUMMARY = "case,method,status,t_end,steps,max_phi,max_phidot,max_phiddot"


def write(root: Path, case: str, methods: dict[str, dict[str, np.ndarray]], **worst: float) -> None:
    """Writes runs, and a summary in which all of them violate the constraints by so much."""
    folder = root / case
    folder.mkdir(parents=True)
    lines = [SUMMARY]
    for method, columns in methods.items():
        header, values = ",".join(columns), np.column_stack(list(columns.values()))
        np.savetxt(folder / f"{method}.csv", values, delimiter=",", header=header, comments="")
        left = [worst.get(level, 1e-13) for level in ("phi", "phidot", "phiddot")]
        lines.append(f"{case},{method},reached-end,2.0,626,{','.join(map(str, left))}")
    (folder / "summary.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")


def pendulum(share: float = 1 / 3) -> dict[str, np.ndarray]:
    """A pendulum: of its tension the first of three constraints bears a share, the others half the rest."""
    t, _, x, z, *_ = history(FOUR["figure2_standard"]["present"]).T
    shares = {
        f"lambda{i}": -29.43 * z * part
        for i, part in ((1, share), (2, (1 - share) / 2), (3, (1 - share) / 2))
    }
    return {"t": t, "x": x, "z": z} | shares


def disc(off: float = 0.0) -> dict[str, np.ndarray]:
    """A disc that rolls round its circle, and farther and farther off it."""
    radius = ROLLING_RADIUS + off * T / T[-1]
    return {
        "t": T,
        "disc.x": CENTER + radius * np.cos(TURNING_RATE * T),
        "disc.y": radius * np.sin(TURNING_RATE * T),
    }


def crank(rate: float = CRANK_RATE) -> dict[str, np.ndarray]:
    """A slider-crank that turns at a rate."""
    x = CRANK * np.cos(rate * T) + np.sqrt(ROD**2 - (CRANK * np.sin(rate * T)) ** 2)
    return {"t": T, "slider.x": x}


def verdicts(root: Path) -> dict[str, Claim]:
    """Returns the statements by the name of what judges them."""
    rows = [row for row in claims.CLAIMS if all(map(Results(root).has, row.cases))]
    return {row.judge.__name__: claim for row, claim in zip(rows, judged(rows, Results(root)), strict=True)}


def write_all(root: Path, **changed: object) -> Path:
    """Writes exact runs of everything that the chapter reads, unless told otherwise."""
    write(root, "redundant", {"present": changed.get("redundant", pendulum())})
    discs = changed.get("discs", (disc(1e-7), disc(2e-7), disc(1e-6)))
    names = ("present", "present-identity", "baseline")
    write(root, "rolling_disc", dict(zip(names, discs, strict=True)), phidot=changed.get("slip", 1e-15))
    write(root, "slider_crank", {"present": crank(changed.get("rate", CRANK_RATE))})
    for case in ("figure1_standard", "figure2_standard"):
        write_case(root, case, FOUR[case] | {"present": Made(626, 0.0, 0.0, 0.0)})
    return root


def test_exact_runs_meet_what_is_said_of_constraints(tmp_path: Path) -> None:
    found = verdicts(write_all(tmp_path))
    # The made-up pendulums have no mu.
    assert {name for name, one in found.items() if one.verdict is Verdict.YES} == {
        "redundancy",
        "least_norm",
        "arbitrary_weight",
        "nonholonomic",
        "rheonomic",
    }
    assert found["mu_of_exact_integration"].verdict is Verdict.NO
    assert all(one.files for one in found.values())


@pytest.mark.parametrize(
    ("lost", "changed"),
    [
        ("least_norm", {"redundant": pendulum(share=0.5)}),
        ("arbitrary_weight", {"discs": (disc(1e-3), disc(2e-7), disc())}),
        ("nonholonomic", {"discs": (disc(1e-3), disc(1e-3), disc())}),
        ("nonholonomic", {"slip": 1e-6}),
        ("rheonomic", {"rate": CRANK_RATE * (1 + 1e-9)}),
    ],
)
def test_what_is_lost_is_not_reproduced(tmp_path: Path, lost: str, changed: dict[str, object]) -> None:
    found = verdicts(write_all(tmp_path, **changed))
    assert found[lost].verdict is Verdict.NO and found[lost].because


def test_closed_forms_know_how_far_a_run_is_off(tmp_path: Path) -> None:
    write_all(tmp_path, discs=(disc(1e-3), disc(), disc()), rate=CRANK_RATE * 1.001)
    results = Results(tmp_path)
    assert circle_error(results.case("rolling_disc").run("present")) == pytest.approx(1e-3)
    assert slider_error(results.case("slider_crank").run("present")) > 1e-4
