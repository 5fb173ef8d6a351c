"""N-four-bars through their singular positions and driven four-bars past their change points: some minutes.

Run by name: pytest -c scripts/pytest.ini scripts/tests/study_singular_positions.py
"""

import csv
import math
import re
import subprocess
from functools import cache
from pathlib import Path

import numpy as np
import pytest

CASES = Path(__file__).parents[2] / "cases" / "mechanism"
GRAVITY = 9.81
SPEEDS = (0.5, 0.7, 1.0, 1.3, 1.7, 2.0, 2.5, 3.0, 4.0, 5.0)
# Of N windows: T = ((N + 1)/6 + N/2) a'^2, V = ((N + 1)/2 + N) g cos a of the cranks' angle a.
WINDOWS = 2


@cache
def pendulum(rate: float, t_end: float, windows: int = WINDOWS) -> float:
    """Returns the cranks' angle at the end: classical Runge-Kutta with steps whose error is round-off."""
    factor = ((windows + 1) / 2 + windows) * GRAVITY / (2 * ((windows + 1) / 6 + windows / 2))
    angle, steps = 0.0, 50_000
    h = t_end / steps
    for _ in range(steps):
        a1, r1 = rate, factor * math.sin(angle)
        a2, r2 = rate + h / 2 * r1, factor * math.sin(angle + h / 2 * a1)
        a3, r3 = rate + h / 2 * r2, factor * math.sin(angle + h / 2 * a2)
        a4, r4 = rate + h * r3, factor * math.sin(angle + h * a3)
        angle += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
        rate += h / 6 * (r1 + 2 * r2 + 2 * r3 + r4)
    return angle


def four_bar(speed: float, rtol: str, atol: str, more: str = "") -> str:
    """Returns the shipped case at another speed and other tolerances."""
    text = (CASES / "n_four_bar2.nml").read_text(encoding="utf-8")
    text = text.replace(
        "velocity = 0.5, 0.0, angle_rate = -1.0", f"velocity = {speed / 2}, 0.0, angle_rate = {-speed}"
    )
    text = text.replace("velocity = 1.0, 0.0, repeat = 2", f"velocity = {speed}, 0.0, repeat = 2")
    integration = f"&integration t_end = 10.0, rtol = {rtol}, atol = {atol}{more} /"
    return re.sub(r"&integration.*/", integration, text)


def run(mechanism: Path, folder: Path, text: str) -> tuple[str, str, dict[str, float]]:
    """Runs a case; returns its status, what was said, and the last row of its table."""
    (folder / "case.nml").write_text(text, encoding="utf-8")
    done = subprocess.run(
        [mechanism, "case.nml", "--quiet"], cwd=folder, capture_output=True, text=True, check=False
    )
    if not (folder / "results/case/summary.csv").exists():
        return "refused", done.stderr, {}
    with (folder / "results/case/summary.csv").open(newline="") as file:
        (summary,) = csv.DictReader(file)
    with (folder / "results/case/present.csv").open(newline="") as file:
        *_, last = csv.DictReader(file)
    return summary["status"], done.stderr, {name: float(value) for name, value in last.items()}


@pytest.mark.parametrize("integrator", ["dopri5", "dop853", "radau"])
@pytest.mark.parametrize("digits", range(3, 13))
@pytest.mark.parametrize("speed", SPEEDS)
def test_four_bars_pass_at_every_tolerance(
    mechanism: Path, tmp_path: Path, speed: float, digits: int, integrator: str
) -> None:
    more = f', integrator = "{integrator}"'
    status, said, last = run(mechanism, tmp_path, four_bar(speed, f"1e-{digits}", f"1e-{digits + 3}", more))
    assert status == "reached-end", said
    if digits >= 6:
        angle = pendulum(speed, 10.0)
        assert last["B0.x"] == pytest.approx(math.sin(angle), abs=3e3 * 10.0**-digits + 2e-5)


@pytest.mark.parametrize("integrator", ["dopri5", "dop853", "radau"])
@pytest.mark.parametrize("digits", range(4, 13))
@pytest.mark.parametrize("rate", (0.7, 1.0, 1.7, 2.3, 3.1))
def test_parallelograms_pass_flat(
    mechanism: Path, tmp_path: Path, rate: float, digits: int, integrator: str
) -> None:
    """A parallelogram keeps its rate, and is flat twice a turn."""
    x, y = math.cos(1.0), math.sin(1.0)
    half, whole = (f"velocity = {-share * rate * y!r}, {share * rate * x!r}" for share in (0.5, 1.0))
    rod, turning = 'shape = "rod", mass = 1.0', f"angle_rate = {rate}"
    lines = ["&mechanism planar = .true. /"]
    for name, at in (("crank", 0.0), ("rocker", 2.0)):
        lines += [
            f'&body name = "{name}", {rod}, from = {at}, 0.0, to = {at + x!r}, {y!r}, {half}, {turning} /',
            f'&joint name = "{name}_root", type = "revolute", body_2 = "{name}", point = {at}, 0.0 /',
        ]
    lines.append(f'&body name = "bar", {rod}, from = {x!r}, {y!r}, to = {2.0 + x!r}, {y!r}, {whole} /')
    for name, at in (("crank", x), ("rocker", 2.0 + x)):
        both = f'body_1 = "{name}", body_2 = "bar", point = {at!r}, {y!r}'
        lines.append(f'&joint name = "{name}_end", type = "revolute", {both} /')
    lines += [
        f'&point name = "P", body = "crank", position = {x!r}, {y!r} /',
        f"&integration t_end = 10.0, rtol = 1e-{digits}, atol = 1e-{digits + 2}",
        f'integrator = "{integrator}" /',
        "&output dt = 0.1 /",
    ]
    status, said, last = run(mechanism, tmp_path, "\n".join(lines) + "\n")
    assert status == "reached-end", said
    assert last["P.x"] == pytest.approx(math.cos(1.0 + 10.0 * rate), abs=3e3 * 10.0**-digits + 1e-7)


@pytest.mark.parametrize(
    "off", ["0", "1e-12", "1e-10", "1e-8", "1e-7", "1e-6", "1e-5", "1e-4", "1e-3", "1e-2"]
)
def test_starts_near_level(mechanism: Path, tmp_path: Path, off: str) -> None:
    angle, rate = math.pi / 2 - float(off), 1.0
    x, y = math.sin(angle), math.cos(angle)
    lines = ["&mechanism planar = .true. /", "&gravity /"]
    ends = [f"{i + x!r}, {y!r}" for i in range(3)]
    half, whole = (f"{share * rate * y!r}, {-share * rate * x!r}" for share in (0.5, 1.0))
    for i in range(3):
        rod = f'shape = "rod", mass = 1.0, to = {ends[i]}'
        lines += [
            f'&body name = "crank{i}", from = {i}, 0.0, {rod}, velocity = {half}, angle_rate = {-rate} /',
            f'&joint name = "A{i}", type = "revolute", body_2 = "crank{i}", point = {i}, 0.0 /',
        ]
        if i > 0:
            lines.append(f'&body name = "bar{i}", from = {ends[i - 1]}, {rod}, velocity = {whole} /')
            for name, end in (("left", i - 1), ("right", i)):
                both = f'body_1 = "crank{end}", body_2 = "bar{i}", point = {ends[end]}'
                lines.append(f'&joint name = "{name}{i}", type = "revolute", {both} /')
    lines += ["&integration t_end = 2.0, rtol = 1e-8, atol = 1e-8 /", "&output dt = 0.1 /"]
    status, said, last = run(mechanism, tmp_path, "\n".join(lines) + "\n")
    assert status == "reached-end", said
    assert abs(last["crank0.angle"]) < 100.0


def test_forty_windows_at_a_strict_tolerance(mechanism: Path, tmp_path: Path) -> None:
    text = (CASES / "n_four_bar40.nml").read_text(encoding="utf-8")
    text = re.sub(r"rtol = \S+, atol = \S+", "rtol = 1e-11, atol = 1e-11", text)
    status, said, last = run(mechanism, tmp_path, text)
    assert status == "reached-end", said
    angle = pendulum(1.0, last["t"], windows=40)
    assert last["B0.x"] == pytest.approx(math.sin(angle), abs=1e-6)


def rocker(
    crank: float, coupler: float, follower: float, ground: float, angle: float, open_side: bool
) -> tuple:
    """Returns where the crank's and the follower's ends are: the follower's on one side of the diagonal."""
    b = np.array([crank * math.cos(angle), crank * math.sin(angle)])
    d = np.array([ground, 0.0])
    along, length = (d - b), float(np.hypot(*(d - b)))
    u = along / length
    part = (coupler**2 - follower**2 + length**2) / (2 * length)
    height = math.sqrt(coupler**2 - part**2)
    normal = np.array([-u[1], u[0]]) * (1.0 if open_side else -1.0)
    return b, b + part * u + height * normal


# Lengths of crank, coupler, follower and ground; the last ones pass their change point by a gap.
LINKAGES = {
    "crank-rocker": (0.3, 1.0, 0.8, 1.0),
    "drag-link": (1.0, 0.9, 1.1, 0.4),
    **{f"change-point-1e-{k}": (0.4, 1.0, 0.6 + 10.0**-k, 1.2) for k in range(1, 7)},
}


@pytest.mark.parametrize("digits", range(2, 10))
@pytest.mark.parametrize("name", LINKAGES)
def test_driven_four_bars_stay_on_their_branch_or_say_so(
    mechanism: Path, tmp_path: Path, name: str, digits: int
) -> None:
    lengths = LINKAGES[name]
    b, c = rocker(*lengths, angle=1.0, open_side=True)
    at_b, at_c = ", ".join(map(repr, b.tolist())), ", ".join(map(repr, c.tolist()))
    text = f"""&mechanism planar = .true. /
&function name = "turning", kind = "ramp", rate = 2.0 /
&body name = "crank", shape = "rod", mass = 1.0, from = 0.0, 0.0, to = {at_b} /
&body name = "bar", shape = "rod", mass = 1.0, from = {at_b}, to = {at_c} /
&body name = "rocker", shape = "rod", mass = 1.0, from = {at_c}, to = {lengths[3]}, 0.0 /
&joint name = "A", type = "revolute", body_2 = "crank", point = 0.0, 0.0, drive_angle = "turning" /
&joint name = "B", type = "revolute", body_1 = "crank", body_2 = "bar", point = {at_b} /
&joint name = "C", type = "revolute", body_1 = "bar", body_2 = "rocker", point = {at_c} /
&joint name = "D", type = "revolute", body_2 = "rocker", point = {lengths[3]}, 0.0 /
&point name = "end", body = "rocker", position = {at_c} /
&integration t_end = 10.0, rtol = 1e-{digits}, atol = 1e-{digits} /
&output dt = 0.01 /
"""
    status, said, last = run(mechanism, tmp_path, text)
    if status != "reached-end":
        assert said.strip()
        pytest.skip(f"said so: {said.strip()[:150]}")
    angle = 1.0 + 2.0 * last["t"]
    _, exact = rocker(*lengths, angle=angle, open_side=True)
    assert math.hypot(last["end.x"] - exact[0], last["end.y"] - exact[1]) < 1e-6


def driven_slider_crank(rate: float) -> str:
    """Returns a slider-crank whose rod is as long as its crank: the slider can stay in the crank's pivot."""
    x, y = math.cos(1.0), math.sin(1.0)
    rod = 'shape = "rod", mass = 1.0'
    return f"""&mechanism planar = .true. /
&function name = "turning", kind = "ramp", rate = {rate} /
&body name = "crank", {rod}, from = 0.0, 0.0, to = {x!r}, {y!r} /
&body name = "bar", {rod}, from = {x!r}, {y!r}, to = {2 * x!r}, 0.0 /
&joint name = "A", type = "revolute", body_2 = "crank", point = 0.0, 0.0, drive_angle = "turning" /
&joint name = "B", type = "revolute", body_1 = "crank", body_2 = "bar", point = {x!r}, {y!r} /
&joint name = "C", type = "in-line", body_2 = "bar", point = {2 * x!r}, 0.0, axis = 1.0, 0.0 /
&point name = "P", body = "bar", position = {2 * x!r}, 0.0 /
"""


def driven_kite(rate: float) -> str:
    """Returns a kite of arms of 1 m and 2 m: where the short ones meet, the long ones can turn as one."""
    bx, by = math.cos(1.0), math.sin(1.0)
    cx, cy = kite_tip(1.0)
    rod = 'shape = "rod", mass = 1.0'
    return f"""&mechanism planar = .true. /
&function name = "turning", kind = "ramp", rate = {rate} /
&body name = "crank", {rod}, from = 0.0, 0.0, to = {bx!r}, {by!r} /
&body name = "bar", {rod}, from = {bx!r}, {by!r}, to = {cx!r}, {cy!r} /
&body name = "rocker", {rod}, from = 1.0, 0.0, to = {cx!r}, {cy!r} /
&joint name = "A", type = "revolute", body_2 = "crank", point = 0.0, 0.0, drive_angle = "turning" /
&joint name = "B", type = "revolute", body_1 = "crank", body_2 = "bar", point = {bx!r}, {by!r} /
&joint name = "C", type = "revolute", body_1 = "bar", body_2 = "rocker", point = {cx!r}, {cy!r} /
&joint name = "D", type = "revolute", body_2 = "rocker", point = 1.0, 0.0 /
&point name = "P", body = "rocker", position = {cx!r}, {cy!r} /
"""


def kite_tip(angle: float) -> tuple[float, float]:
    """Returns the tip, on the line that halves the angle of the short arms; the motion goes on smoothly."""
    far = math.cos(angle / 2) + math.sqrt(4.0 - math.sin(angle / 2) ** 2)
    return far * math.cos(angle / 2), far * math.sin(angle / 2)


def check_driven(
    mechanism: Path, folder: Path, name: str, rate: float, digits: int, integrator: str, more: str = ""
) -> None:
    """Drives a linkage through positions where its motion branches; it goes straight on."""
    made = {"slider-crank": driven_slider_crank, "kite": driven_kite}[name](rate)
    text = f"""{made}&integration t_end = 10.0, rtol = 1e-{digits}, atol = 1e-{digits + 2}
integrator = "{integrator}"{more} /
&output dt = 0.1 /
"""
    status, said, last = run(mechanism, folder, text)
    assert status == "reached-end", said
    angle = 1.0 + 10.0 * rate
    exact = kite_tip(angle) if name == "kite" else (2.0 * math.cos(angle), 0.0)
    assert math.hypot(last["P.x"] - exact[0], last["P.y"] - exact[1]) < 1e-8


@pytest.mark.parametrize("integrator", ["dopri5", "dop853", "radau"])
@pytest.mark.parametrize("digits", range(4, 13))
@pytest.mark.parametrize("rate", (0.7, 1.0, 1.7, 2.3, 3.1))
@pytest.mark.parametrize("name", ["slider-crank", "kite"])
def test_driven_linkages_pass(
    mechanism: Path, tmp_path: Path, name: str, rate: float, digits: int, integrator: str
) -> None:
    check_driven(mechanism, tmp_path, name, rate, digits, integrator)
