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


# What the examples print, as they do.
PRINTED = {
    "shapes": (
        "   apart   rank of A  rank of AX        left        status",
        " 0.0E+00           2           1    3.47E-18   reached-end",
        " 1.0E-03           2           1    5.00E-04   reached-end",
    ),
    "actuator": (
        "reached-end, x, and in closed form [m]:   0.60366313   0.60366313",
        "reached-end, w, and in closed form [A]:   0.01831564   0.01831564",
        "what a projection moves, x, v and w:  2.24E-01  4.47E-02  0.00E+00",
    ),
} | {
    name: (
        " problem      integrator    steps      rhs jacobian time [ms]      phi   phidot  phiddot    error",
        f"pendulum {integrator:>14}     8000    32000        0    27.40  8.9E-15  4.4E-16  1.1E-14  1.8E-10",
        "pendulum     taut dopri5      103      620        0      0.4  7.0E-13  4.4E-16  7.1E-15  2.1E-09",
    )
    for name, integrator in (("rk4", "RK4"), ("newmark", "Newmark"))
}


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
    found = judged(claims.CLAIMS, Results(root))
    return {row.judge.__name__: claim for row, claim in zip(claims.CLAIMS, found, strict=True)}


def write_all(root: Path, **changed: object) -> Path:
    """Writes exact runs of everything that the chapter reads, unless told otherwise."""
    write(root, "redundant", {"present": changed.get("redundant", pendulum())})
    discs = changed.get("discs", (disc(1e-7), disc(2e-7), disc(1e-6)))
    names = ("present", "present-identity", "baseline")
    write(root, "rolling_disc", dict(zip(names, discs, strict=True)), phidot=changed.get("slip", 1e-15))
    write(root, "slider_crank", {"present": crank(changed.get("rate", CRANK_RATE))})
    for case in ("figure1_standard", "figure2_standard"):
        write_case(root, case, FOUR[case] | {"present": Made(626, 0.0, 0.0, 0.0)})
    (root / "examples").mkdir()
    for name, lines in (PRINTED | changed.get("printed", {})).items():
        (root / "examples" / f"{name}.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")
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
        "least_functional",
        "poor_shapes",
        "other_states",
        "little_intrusion",
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
        ("poor_shapes", {"printed": {"shapes": [s.replace(" 1  ", " 2  ") for s in PRINTED["shapes"]]}}),
        (
            "other_states",
            {"printed": {"actuator": [s.replace("0.00E", "1.00E") for s in PRINTED["actuator"]]}},
        ),
        ("little_intrusion", {"printed": {"rk4": [s.replace("8.9E-15", "8.9E-09") for s in PRINTED["rk4"]]}}),
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
