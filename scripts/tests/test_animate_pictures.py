"""Pictures of mechanisms: how they are seen, what is drawn, and what is written beside it."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
from animate_cases import PENDULUM, ZOO, at_rest, geometry, made, swinging
from conftest import ROOT

from taut import style
from taut.animate import solids
from taut.animate.command import time_of_still
from taut.animate.motion import of_mode, of_run
from taut.animate.parts import Dot, Segment
from taut.animate.pictures import Shown, curves, draw_still, frames, labeled, unit_of
from taut.animate.scene import BETWEEN, Look, Scene, nice
from taut.animate.symbols import contact
from taut.case_file import Entry, Template
from taut.errors import TautError
from taut.results import read_run


def test_a_mode_is_drawn_before_its_equilibrium_with_its_frequency(drawn_modes: Path) -> None:
    mechanism = geometry(drawn_modes / "results/case")
    shown = Shown(mechanism, of_mode(mechanism, drawn_modes / "results/case", 1))
    # It goes farthest after a quarter of its two seconds.
    assert time_of_still(["a.png"], shown) == pytest.approx(0.5)
    figure = plt.figure()
    axes = figure.add_subplot()
    draw_still(axes, shown, 0.5)
    assert axes.get_title("left") == "case: mode 1, 0.5 Hz" and "0.50 s" in axes.get_title("right")
    faint = [c for c in axes.collections if c.get_alpha() is not None and c.get_alpha() < 1]
    assert faint[0].get_segments()[0] == pytest.approx(np.array([[0, 0], [0, -1]]), abs=1e-12)
    plt.close(figure)
    # In an animation of a part of the period too.
    figure = next(frames(shown, np.array([0.4, 0.5])))
    faint = [c for c in figure.axes[0].collections if c.get_alpha() is not None and c.get_alpha() < 1]
    assert faint[0].get_segments()[0] == pytest.approx(np.array([[0, 0], [0, -1]]), abs=1e-12)
    plt.close(figure)


def test_faces_look_outwards() -> None:
    for faces in (solids.box(np.array([1.0, 2, 3])), solids.cylinder(1.0, 2.0, np.array([0.6, 0, 0.8]))):
        assert all(solids.normal(face) @ face.mean(axis=0) > 0 for face in faces)
        corners = np.concatenate(faces)
        assert np.abs(corners.mean(axis=0)).max() < 1e-12


def test_everything_can_be_drawn(mechanism: Path, tmp_path: Path) -> None:
    style.use()
    folder = made(mechanism, tmp_path, ZOO)
    zoo, motion = geometry(folder), at_rest(folder)
    figure = plt.figure()
    axes = figure.add_subplot()
    look = Look(traces=("mass", "j10"), names=True)
    scene = Scene(axes, zoo, motion, look, np.array([0.0, 0.5]))
    scene.move(2)
    figure.canvas.draw()
    names = {text.get_text() for text in axes.texts}
    assert set(zoo.bodies) == names
    # Everything is inside the picture.
    x, y = axes.get_xlim(), axes.get_ylim()
    for position in motion.positions.values():
        at = scene.view.flat(position[0])
        assert x[0] < at[0] < x[1] and y[0] < at[1] < y[1]
    plt.close(figure)


def test_a_flat_motion_in_space_is_seen_from_its_normal(mechanism: Path, tmp_path: Path) -> None:
    text = Template(ROOT / "cases/mechanism/swing.nml", [Entry.read("integration.t_end")]).fill([1e-6])
    folder = made(mechanism, tmp_path, text)
    figure = plt.figure()
    scene = Scene(figure.add_subplot(), geometry(folder), at_rest(folder), Look())
    assert scene.view.out == pytest.approx([0, 0, 1])
    plt.close(figure)


# The plane x-z, one that leans, the level one seen from above, and one in which no axis lies.
PLANES = (
    ((1.0, 0, 0), (0, 0, 1.0)),
    ((0, 1.0, 0), (0.6, 0, 0.8)),
    ((0, 1.0, 0), (1.0, 0, 0)),
    ((0.8, 0, -0.6), (0.36, 0.8, 0.48)),
)


@pytest.mark.parametrize(("first", "second"), PLANES)
@pytest.mark.parametrize("until", [0, 1, 20])
def test_a_motion_in_any_plane_is_seen_from_its_normal_at_any_time(
    mechanism: Path, tmp_path: Path, first: tuple[float, ...], second: tuple[float, ...], until: int
) -> None:
    plane = np.stack([first, second, np.cross(first, second)], axis=1)
    in_space = PENDULUM.replace("planar = .true.", "").replace("0, 0 /", "0, 0, 0, axis = 0, 0, 1 /")
    in_space = in_space.replace("from = 0, 0, to = 1, 0", "from = 0, 0, 0, to = 1, 0, 0").replace(
        "1, 0 /", "1, 0, 0 /"
    )
    rod = geometry(made(mechanism, tmp_path, in_space))
    # What cannot be seen does not matter.
    whole = swinging(plane, 1e-6)
    figure = plt.figure()
    scene = Scene(figure.add_subplot(), rod, whole.at(whole.times[: until + 1]), Look(), whole=whole)
    assert scene.flat and abs(scene.view.out @ plane[:, 2]) == pytest.approx(1, abs=1e-6)
    assert np.cross(scene.view.right, scene.view.up) == pytest.approx(scene.view.out)
    level = abs(plane[2, 2]) > 0.999
    assert scene.view.flat(np.array([0, 1.0, 0] if level else [0, 0, 1.0]))[1] > 0.5
    # What leaves the plane does, and who asks for another view gets it.
    for motion, look in ((swinging(plane, 0.01), Look()), (whole, Look((-60.0, 18.0)))):
        scene = Scene(figure.add_subplot(), rod, motion, look)
        assert not scene.flat and scene.view.out @ rod.up == pytest.approx(np.sin(np.radians(18)))
    plt.close(figure)


@pytest.mark.parametrize(
    ("along", "out"), [((1.0, 0, 0), (0, -1, 0)), ((0, 1.0, 0), (1, 0, 0)), ((0, 0, 1.0), (0, -1, 0))]
)
def test_what_is_on_a_line_is_seen_upright(
    mechanism: Path, tmp_path: Path, along: tuple[float, ...], out: tuple[float, ...]
) -> None:
    to = ", ".join(str(value) for value in along)
    beam = f'&beam name = "n", from = 0, 0, 0, to = {to}, axis_2 = 0.6, 0.48, 0.64, elements = 2, '
    beam += "young = 1e9, density = 1e3, thickness = 1e-2, width = 1e-2 /\n"
    folder = made(mechanism, tmp_path, "&gravity /\n" + beam + "&integration t_end = 1e-6 /\n")
    figure = plt.figure()
    scene = Scene(figure.add_subplot(), geometry(folder), at_rest(folder), Look())
    assert scene.view.out == pytest.approx(out) and scene.view.up == pytest.approx([0, 0, 1])
    plt.close(figure)


def test_a_disc_touches_its_plane_below_its_center(mechanism: Path, tmp_path: Path) -> None:
    folder = made(mechanism, tmp_path, ZOO)
    (joint,) = (joint for joint in geometry(folder).joints if joint.type == "rolling")
    assert contact(at_rest(folder), joint)[0] == pytest.approx([1, 1, 0])


def test_traces_end_where_the_point_is(drawn_pendulum: Path) -> None:
    mechanism = geometry(drawn_pendulum / "results/case")
    motion = of_run(mechanism, read_run(drawn_pendulum / "results/case/present.csv"))
    figure = plt.figure()
    scene = Scene(figure.add_subplot(), mechanism, motion.at(np.array([0.0, 1.0, 2.0])), Look(), fine=motion)
    scene.move(1)
    ((line, _),) = scene.traces
    x, y = line.get_data()
    assert (x[-1], y[-1]) == pytest.approx((np.cos(2), np.sin(2)))
    # As far as the time, and smooth: on the circle between the points that are known.
    assert len(x) == BETWEEN * 20 + 1 and np.hypot(x, y) == pytest.approx(np.ones(len(x)), abs=1e-5)
    plt.close(figure)


def test_a_still_shows_its_time_and_its_strobe(drawn_pendulum: Path) -> None:
    mechanism = geometry(drawn_pendulum / "results/case")
    motion = of_run(mechanism, read_run(drawn_pendulum / "results/case/present.csv"))
    figure = plt.figure()
    axes = figure.add_subplot()
    draw_still(axes, Shown(mechanism, motion), 1.01, 3)
    assert axes.get_title("left") == "case" and "1.01 s" in axes.get_title("right")
    faint = [c for c in axes.collections if c.get_alpha() is not None and c.get_alpha() < 1]
    assert len(faint) == 2 * 3
    plt.close(figure)


def test_traces_of_what_there_is_not(drawn_pendulum: Path) -> None:
    mechanism = geometry(drawn_pendulum / "results/case")
    assert mechanism.anchor("hinge").body == "rod"
    with pytest.raises(TautError, match="'tap'; there are rod, tip, hinge"):
        mechanism.anchor("tap")


def test_a_torsion_spring_turns_with_its_body(drawn_pendulum: Path, mechanism: Path, tmp_path: Path) -> None:
    text = PENDULUM + '&spring name = "coil", joint = "hinge", stiffness = 1 /\n'
    folder = made(mechanism, tmp_path, text, "sprung")
    rod = geometry(folder)
    motion = of_run(rod, read_run(drawn_pendulum / "results/case/present.csv"))
    figure = plt.figure()
    scene = Scene(figure.add_subplot(), rod, motion, Look())
    (line,) = (part.line for part in scene.parts if isinstance(part, Segment))
    scene.move(0)
    first = np.array(line.get_data())
    scene.move(20)
    # By 2 rad about the hinge, which is the origin.
    turned = np.array([[np.cos(2), -np.sin(2)], [np.sin(2), np.cos(2)]]) @ first
    assert np.array(line.get_data()) == pytest.approx(turned)
    plt.close(figure)


def test_a_bushing_is_a_ring_about_a_pin(drawn_pendulum: Path, mechanism: Path, tmp_path: Path) -> None:
    text = PENDULUM + '&bushing body_2 = "rod", point_1 = 0.3, 0, point_2 = 0.5, 0, stiffness = 1, 1 /\n'
    rod = geometry(made(mechanism, tmp_path, text, "held"))
    motion = of_run(rod, read_run(drawn_pendulum / "results/case/present.csv"))
    figure = plt.figure()
    scene = Scene(figure.add_subplot(), rod, motion, Look())
    scene.move(20)
    dots = [part.line for part in scene.parts if isinstance(part, Dot)]
    (ring,) = (line for line in dots if line.get_color() == "#9aa3af")
    assert np.array(ring.get_data()).ravel() == pytest.approx([0.3, 0.0])
    # The rod has turned by 2 rad about the origin.
    at = 0.5 * np.array([np.cos(2), np.sin(2)])
    assert any(np.array(line.get_data()).ravel() == pytest.approx(at) for line in dots)
    plt.close(figure)


def test_a_still_has_a_scale_and_what_is_cut_off_a_mark(drawn_pendulum: Path) -> None:
    rod = geometry(drawn_pendulum / "results/case")
    motion = of_run(rod, read_run(drawn_pendulum / "results/case/present.csv"))
    figure = plt.figure()
    axes = figure.add_subplot()
    draw_still(axes, Shown(rod, motion, Look(window=(-1.0, 0.5, -1.0, 1.0))), 1.0)
    texts = [text.get_text() for text in axes.texts]
    assert "· · ·" in texts and any(text.endswith(" m") for text in texts)
    low, high = axes.get_xlim()
    (bar,) = (line for line in axes.get_lines() if line.get_marker() == "|")
    length = float(next(text for text in texts if text.endswith(" m")).removesuffix(" m"))
    assert np.ptp(bar.get_xdata()) * (high - low) == pytest.approx(length)
    plt.close(figure)


def test_meshes_are_round_numbers() -> None:
    assert [nice(v) for v in (0.97, 0.23, 33.0, 7.5e-3)] == pytest.approx([1.0, 0.2, 50.0, 0.01])


def test_columns_of_a_unit_share_a_panel(drawn_pendulum: Path) -> None:
    run = read_run(drawn_pendulum / "results/case/present.csv")
    figure = curves("case", run, ["hinge.fx", "rod.x", "hinge.fy", "energy"])
    assert [axes.get_ylabel() for axes in figure.axes] == ["force [N]", "position [m]", "energy [J]"]
    assert [len(axes.get_lines()) for axes in figure.axes] == [2, 1, 1]
    assert (unit_of("a.m3"), unit_of("rank")) == ("moment [N m]", "rank")
    assert (labeled("a.m3"), labeled("rank")) == ("a.m3\n[N m]", "rank")
    plt.close(figure)
