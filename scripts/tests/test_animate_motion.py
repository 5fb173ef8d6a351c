"""Where the bodies of a mechanism are over time, in a run and in a mode."""

from pathlib import Path

import numpy as np
import pytest
from animate_cases import geometry, made

from taut.animate.geometry import GROUND, Anchor
from taut.animate.motion import of_mode, of_run
from taut.errors import TautError
from taut.results import read_run
from taut.view import View


def test_points_move_with_their_bodies(drawn_pendulum: Path) -> None:
    mechanism = geometry(drawn_pendulum / "results/case")
    motion = of_run(mechanism, read_run(drawn_pendulum / "results/case/present.csv"))
    turned = 2 * motion.times
    tip = np.stack([np.cos(turned), np.sin(turned), 0 * turned], axis=1)
    assert motion.point(mechanism.points["tip"]) == pytest.approx(tip, abs=1e-12)
    (hinge,) = mechanism.joints
    assert motion.point(Anchor("rod", hinge.points[1])) == pytest.approx(0 * tip, abs=1e-12)
    assert motion.point(Anchor(GROUND, hinge.points[0])) == pytest.approx(0 * tip)
    # Between the times the angle is exact, and the center on its chord.
    half = motion.at(np.array([0.025, 2.5]))
    assert half.rotations["rod"][0, :2, 0] == pytest.approx([np.cos(0.05), np.sin(0.05)], abs=1e-12)
    assert half.positions["rod"][1] == pytest.approx(motion.positions["rod"][-1])


def test_quaternions_turn_bodies(mechanism: Path, tmp_path: Path) -> None:
    text = '&body name = "b", shape = "sphere", radius = 1, mass = 1 /\n&integration t_end = 1e-3 /\n'
    ball = geometry(made(mechanism, tmp_path, text))
    s = np.sqrt(0.5)
    (tmp_path / "r.csv").write_text(
        f"t,b.x,b.y,b.z,b.qa,b.qb,b.qc,b.qd\n0,1,2,3,{s},0,0,{s}\n1,1,2,3,{s},0,0,{s}\n"
    )
    motion = of_run(ball, read_run(tmp_path / "r.csv"))
    # A quarter turn about z brings x to y.
    assert motion.point(Anchor("b", np.array([1.0, 0, 0])))[0] == pytest.approx([1, 3, 3])


def test_modes_swing_about_the_equilibrium(drawn_modes: Path) -> None:
    mechanism, folder = geometry(drawn_modes / "results/case"), drawn_modes / "results/case"
    assert mechanism.static
    motion = of_mode(mechanism, folder, 1)
    assert motion.times[-1] == pytest.approx(2.0)
    tip = motion.point(mechanism.points["tip"])
    assert tip[0] == pytest.approx([0, -1, 0]) == tip[len(tip) // 2]
    assert tip[:, 0].max() == pytest.approx(-tip[:, 0].min()) and tip[:, 0].max() > 0.1
    # The hinge stays where it is but for what is of second order.
    hinge = motion.point(Anchor("rod", mechanism.joints[0].points[1]))
    assert np.abs(hinge).max() < tip[:, 0].max() ** 2
    with pytest.raises(TautError, match="there is no mode 2; it has 1"):
        of_mode(mechanism, folder, 2)


@pytest.mark.parametrize("up", [(0, 0, 1), (0, 1, 0), (0.6, 0, 0.8)])
def test_views_keep_up_upright_and_are_right_handed(up: tuple[float, ...]) -> None:
    view = View.around(np.array(up, float), -60.0, 18.0)
    assert np.cross(view.right, view.up) == pytest.approx(view.out)
    assert view.flat(np.array(up)) == pytest.approx([0, np.cos(np.radians(18))])
