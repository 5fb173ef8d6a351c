"""Implicit steps over singular positions at strict tolerances, where round-off may decide on the branch."""

import math
from pathlib import Path

import pytest
from study_singular_positions import four_bar, pendulum, run


@pytest.mark.parametrize(("speed", "digits"), [(1.7, 11), (2.0, 11), (0.5, 12)])
def test_implicit_steps_pass(mechanism: Path, tmp_path: Path, speed: float, digits: int) -> None:
    text = four_bar(speed, f"1e-{digits}", f"1e-{digits + 3}", ', integrator = "radau"')
    status, said, last = run(mechanism, tmp_path, text)
    assert status == "reached-end", said
    assert last["B0.x"] == pytest.approx(math.sin(pendulum(speed, 10.0)), abs=1e-5)
