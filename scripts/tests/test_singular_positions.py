"""Implicit steps over singular positions at strict tolerances, where round-off may decide."""

import math
from pathlib import Path

import pytest
from study_singular_positions import check_driven, four_bar, pendulum, run


@pytest.mark.parametrize(("speed", "digits"), [(1.7, 11), (2.0, 11), (0.5, 12)])
def test_implicit_steps_pass(mechanism: Path, tmp_path: Path, speed: float, digits: int) -> None:
    text = four_bar(speed, f"1e-{digits}", f"1e-{digits + 3}", ', integrator = "radau"')
    status, said, last = run(mechanism, tmp_path, text)
    assert status == "reached-end", said
    assert last["B0.x"] == pytest.approx(math.sin(pendulum(speed, 10.0)), abs=1e-5)


@pytest.mark.parametrize("digits", [4, 8, 11])
@pytest.mark.parametrize("name", ["slider-crank", "kite"])
def test_implicit_steps_pass_where_a_drive_leaves_no_freedom(
    mechanism: Path, tmp_path: Path, name: str, digits: int
) -> None:
    check_driven(mechanism, tmp_path, name, 1.7, digits, "radau")


@pytest.mark.parametrize("digits", [6, 10, 12])
def test_steps_of_fixed_length_end_close_to_a_flat_parallelogram(
    mechanism: Path, tmp_path: Path, digits: int
) -> None:
    # A step ends a thousandth of a radian beyond the flat position: there, round-off is no longer small.
    start = math.pi - 2.0 + 1e-3
    x, y = math.cos(start), math.sin(start)
    crank = f"velocity = {-y / 2!r}, {x / 2!r}, angle_rate = 1.0"
    bar = f"velocity = {-y!r}, {x!r}"
    text = f"""&mechanism planar = .true. /
&body name = "crank", shape = "rod", mass = 1.0, from = 0.0, 0.0, to = {x!r}, {y!r}, {crank} /
&body name = "bar", shape = "rod", mass = 1.0, from = {x!r}, {y!r}, to = {2 + x!r}, {y!r}, {bar} /
&body name = "rocker", shape = "rod", mass = 1.0, from = 2.0, 0.0, to = {2 + x!r}, {y!r}, {crank} /
&joint name = "A", type = "revolute", body_2 = "crank", point = 0.0, 0.0 /
&joint name = "B", type = "revolute", body_1 = "crank", body_2 = "bar", point = {x!r}, {y!r} /
&joint name = "C", type = "revolute", body_1 = "bar", body_2 = "rocker", point = {2 + x!r}, {y!r} /
&joint name = "D", type = "revolute", body_2 = "rocker", point = 2.0, 0.0 /
&point name = "P", body = "crank", position = {x!r}, {y!r} /
&integration t_end = 3.0, rtol = 1e-{digits}, atol = 1e-{digits + 1}, integrator = "generalized-alpha",
   step_control = "fixed", first_step = 0.01 /
&output dt = 1.0 /
"""
    status, said, last = run(mechanism, tmp_path, text)
    assert status == "reached-end", said
    # Without gravity the crank turns evenly; the order is two.
    assert last["P.x"] == pytest.approx(math.cos(start + 3.0), abs=1e-4)
