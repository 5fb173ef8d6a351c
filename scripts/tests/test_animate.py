"""Pictures of mechanisms: what the case file says, where the bodies are, and the files that come of it."""

import subprocess
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
from conftest import ROOT
from PIL import Image
from scipy.spatial.transform import Rotation

from taut import style
from taut.animate import gallery, solids
from taut.animate.command import main, time_of_still
from taut.animate.mechanism import GROUND, Anchor, Mechanism, expand, read_mechanism
from taut.animate.motion import Motion, of_mode, of_run
from taut.animate.pictures import Shown, curves, draw_still, frames, unit_of
from taut.animate.scene import Look, Scene, anchor_of, nice
from taut.errors import TautError
from taut.results import read_run
from taut.view import View

CASES = sorted((ROOT / "cases/mechanism").glob("*.nml"))

PENDULUM = """&mechanism planar = .true. /
&gravity /
&body name = "rod", shape = "rod", mass = 1, from = 0, 0, to = 1, 0 /
&joint name = "hinge", type = "revolute", body_2 = "rod", point = 0, 0 /
&point name = "tip", body = "rod", position = 1, 0 /
"""
# One of everything that can be drawn.
ZOO = """&gravity /
&body name = "box", shape = "box", size = 0.2, 0.3, 0.4, mass = 1, position = 0, 0, 1 /
&body name = "ball", shape = "sphere", radius = 0.1, mass = 1, position = 1, 0, 1 /
&body name = "can", shape = "cylinder", radius = 0.1, length = 0.3, mass = 1, position = 0, 1, 1 /
&body name = "disc", shape = "cylinder", radius = 0.3, length = 0, mass = 1, position = 1, 1, 0.3,
      orientation = 0, 1.5707963267948966, 0 /
&body name = "brick", mass = 1, inertia = 1e-2, 2e-2, 2.5e-2, position = 2, 0, 1 /
&body name = "top", mass = 1, inertia = 1e-2, 1e-2, 1.5e-2, position = 2, 1, 1 /
&body name = "arm", mass = 1, inertia = 1e-2, 1e-2, 1e-2, position = 2, 2, 1 /
&point_mass name = "mass", mass = 1, position = 0, 2, 1 /
&beam name = "n", from = 0, 3, 1, to = 1, 3, 1, elements = 2, young = 1e9, density = 1e3, thickness = 1e-2,
      width = 1e-2 /
&ground_point name = "peg", position = 0, 0, 2 /
&joint name = "j1", type = "spherical", body_1 = "peg", body_2 = "box" /
&joint name = "j2", type = "universal", body_1 = "box", body_2 = "ball", point = 0.5, 0, 1, axis_1 = 0, 1, 0,
       axis_2 = 0, 0, 1 /
&joint name = "j3", type = "prismatic", body_2 = "arm", point = 2, 2, 1, axis = 1, 0, 0 /
&joint name = "j4", type = "cylindrical", body_1 = "arm", body_2 = "top", point = 2, 1, 1, axis = 0, 0, 1 /
&joint name = "j5", type = "in-line", body_2 = "mass", axis = 1, 0, 0 /
&joint name = "j6", type = "fixed", body_1 = "n3", body_2 = "can", point = 1, 3, 1 /
&joint name = "j7", type = "planar", body_2 = "can", point = 0, 1, 1, axis = 0, 0, 1 /
&joint name = "j8", type = "coordinate", body_2 = "n1", point = 0, 3, 1, axis = 0, 0, 1 /
&joint name = "j9", type = "revolute", body_2 = "brick", point = 2, 0, 1, axis = 0, 1, 0 /
&joint name = "j10", type = "distance", body_1 = "arm", body_2 = "brick", point_1 = 2, 1.5, 1 /
&rolling name = "roll", body = "disc", radius = 0.3, axis = 1, 0, 0 /
&knife_edge name = "edge", body = "arm", point = 2, 2.5, 1, across = 1, 0, 0 /
&spring name = "s", body_1 = "peg", body_2 = "mass", stiffness = 1 /
&damper name = "d", body_1 = "ball", body_2 = "mass", damping = 1 /
"""


def case(folder: Path, text: str, name: str = "case") -> Mechanism:
    (folder / f"{name}.nml").write_text(text)
    return read_mechanism(folder / f"{name}.nml")


def at_rest(mechanism: Mechanism, times: int = 3) -> Motion:
    """A motion in which nothing moves."""
    positions = {name: np.tile(body.position, (times, 1)) for name, body in mechanism.bodies.items()}
    rotations = {name: np.tile(body.rotation, (times, 1, 1)) for name, body in mechanism.bodies.items()}
    return Motion(np.linspace(0, 1, times), positions, rotations)


def swinging(mechanism: Mechanism, plane: np.ndarray, wobble: float = 0.0) -> Motion:
    """The rod of PENDULUM, turning in the plane of the first two columns; it leaves it by a wobble."""
    times = np.linspace(0, 1, 21)
    turned = Rotation.from_rotvec(np.outer(2 * times, [0, 0, 1.0])).as_matrix()
    rotations = plane @ turned
    out = plane[:, 2] * wobble * np.sin(9 * times)[:, None]
    return Motion(times, {"rod": rotations @ [0.5, 0, 0] + out}, {"rod": rotations})


@pytest.fixture
def modes(tmp_path: Path) -> Path:
    """A folder with a hanging pendulum, its made up mode of 0.5 Hz and a case that asks for it."""
    (tmp_path / "case.nml").write_text('&analysis kind = "modes" /\n' + PENDULUM)
    folder = tmp_path / "results/case"
    folder.mkdir(parents=True)
    (folder / "equilibrium.csv").write_text(f"name,value\nrod.x,0\nrod.y,-0.5\nrod.angle,{-np.pi / 2}\n")
    (folder / "modes.csv").write_text("mode,frequency,growth,rod.vx,rod.vy,rod.wz\n1,0.5,0,0.5,0,1\n")
    return tmp_path


@pytest.fixture
def pendulum(tmp_path: Path) -> Path:
    """A folder with a pendulum that turns at 2 rad/s, as made up results."""
    (tmp_path / "case.nml").write_text(PENDULUM)
    folder = tmp_path / "results/case"
    folder.mkdir(parents=True)
    rows = ["t,rod.x,rod.y,rod.angle,hinge.fx,hinge.fy,energy"]
    for t in np.linspace(0, 2, 41):
        rows.append(f"{t},{0.5 * np.cos(2 * t)},{0.5 * np.sin(2 * t)},{2 * t},{np.sin(t)},1.0,0.0")
    (folder / "present.csv").write_text("\n".join(rows) + "\n")
    (folder / "summary.csv").write_text("case,method,status\ncase,present,reached-end\n")
    return tmp_path


def test_names_of_copies() -> None:
    assert [expand(text, 7) for text in ("rod", "rod#", "rod#-1", "a#+12b", "#-", "a#b#")] == [
        "rod",
        "rod7",
        "rod6",
        "a19b",
        "7-",
        "a7b#",
    ]


@pytest.mark.parametrize("path", CASES, ids=lambda path: path.stem)
def test_joints_of_shipped_cases_meet(path: Path) -> None:
    # At the start that the file gives, up to what the assembly moves.
    mechanism = read_mechanism(path)
    assert mechanism.bodies
    moved = {"four_bar": 0.03, "andrews": 1e-6}.get(path.stem, 1e-9)
    for joint in mechanism.joints:
        if joint.type in ("revolute", "spherical", "fixed", "prismatic", "universal"):
            one, two = (mechanism.to_global(b, p) for b, p in zip(joint.bodies, joint.points, strict=True))
            assert one == pytest.approx(two, abs=moved), joint.name


def test_copies_are_as_many_as_the_file_says() -> None:
    mechanism = read_mechanism(ROOT / "cases/mechanism/n_four_bar40.nml")
    assert (len(mechanism.bodies), len(mechanism.joints)) == (81, 121)
    joints = {joint.name: joint for joint in mechanism.joints}
    assert joints["right40"].bodies == ("bar40", "crank40")
    assert mechanism.to_global("bar40", joints["right40"].points[0]) == pytest.approx([40, 1, 0])
    assert mechanism.to_global("crank0", joints["left1"].points[0]) == pytest.approx([0, 1, 0])


def test_bodies_have_the_size_of_their_shape_or_inertia(tmp_path: Path) -> None:
    bodies = case(tmp_path, ZOO).bodies
    assert bodies["box"].size == pytest.approx([0.2, 0.3, 0.4])
    assert bodies["can"].size == pytest.approx([0.2, 0.2, 0.3])
    a, b, c = bodies["brick"].size
    inertia = np.array([b * b + c * c, a * a + c * c, a * a + b * b]) / 12
    assert inertia == pytest.approx([1e-2, 2e-2, 2.5e-2])


def test_up_is_against_gravity(tmp_path: Path) -> None:
    ball = '&point_mass name = "a", mass = 1 /\n'
    assert case(tmp_path, ball).up == pytest.approx([0, 0, 1])
    assert case(tmp_path, "&gravity acceleration(2) = -9.81 /\n" + ball).up == pytest.approx([0, 1, 0])
    assert case(tmp_path, PENDULUM).up == pytest.approx([0, 1, 0])


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ('&joint name = "j", type = "spherical", body_2 = "b", point = 0, 0, 0 /\n', "no body or point 'b'"),
        ('&body name = "b", shape = "rod", mass = 1, from = 0, 0, to = "x" /\n', "&body b"),
        ('&joint name = "j" /\n', "&joint j"),
        ("&swing /\n", "no mechanism"),
        ("&mechanism planar = \n", "no namelist"),
    ],
)
def test_bad_case_is_told_in_one_line(
    pendulum: Path, text: str, part: str, capsys: pytest.CaptureFixture[str]
) -> None:
    good = "" if part == "no mechanism" else PENDULUM
    (pendulum / "case.nml").write_text(good + text)
    assert main([str(pendulum / "case.nml"), "--results", str(pendulum / "results")]) == 1
    error = capsys.readouterr().err
    assert error.startswith("animate: ") and error.count("\n") == 1
    assert part in error


def test_points_move_with_their_bodies(pendulum: Path) -> None:
    mechanism = read_mechanism(pendulum / "case.nml")
    motion = of_run(mechanism, read_run(pendulum / "results/case/present.csv"))
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


def test_quaternions_turn_bodies(tmp_path: Path) -> None:
    mechanism = case(tmp_path, '&body name = "b", shape = "sphere", radius = 1, mass = 1 /\n')
    s = np.sqrt(0.5)
    (tmp_path / "r.csv").write_text(
        f"t,b.x,b.y,b.z,b.qa,b.qb,b.qc,b.qd\n0,1,2,3,{s},0,0,{s}\n1,1,2,3,{s},0,0,{s}\n"
    )
    motion = of_run(mechanism, read_run(tmp_path / "r.csv"))
    # A quarter turn about z brings x to y.
    assert motion.point(Anchor("b", np.array([1.0, 0, 0])))[0] == pytest.approx([1, 3, 3])


def test_modes_swing_about_the_equilibrium(modes: Path) -> None:
    mechanism, folder = read_mechanism(modes / "case.nml"), modes / "results/case"
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


def test_a_mode_is_drawn_before_its_equilibrium_with_its_frequency(modes: Path) -> None:
    mechanism = read_mechanism(modes / "case.nml")
    shown = Shown(mechanism, of_mode(mechanism, modes / "results/case", 1))
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


@pytest.mark.parametrize(
    ("kind", "arguments"), [("equilibrium", []), ("equilibrium", ["--mode", "0"]), ("modes", ["--mode", "0"])]
)
def test_an_equilibrium_is_a_still(
    modes: Path, kind: str, arguments: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    (modes / "case.nml").write_text(f'&analysis kind = "{kind}" /\n' + PENDULUM)
    assert main([str(modes / "case.nml"), "--results", str(modes / "results"), *arguments]) == 0
    picture = modes / "results/figures/case.png"
    assert capsys.readouterr().out == f"{picture}\n"
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("kind", "arguments", "part"),
    [
        ("equilibrium", ["--mode", "1"], "is an equilibrium, without modes"),
        ("modes", ["--mode", "2"], "there is no mode 2"),
        ("modes", ["--still", "2.1", "a.png"], "--still 2.1: the mode's period goes from 0 to 2 s"),
        ("modes", ["--plot", "rod.x"], "no times"),
        ("modes", ["--results", "other"], "profile release -- case.nml` first"),
    ],
)
def test_what_cases_without_motion_do_not_have(
    modes: Path,
    kind: str,
    arguments: list[str],
    part: str,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(modes)
    (modes / "case.nml").write_text(f'&analysis kind = "{kind}" /\n' + PENDULUM)
    assert main(["case.nml", *arguments]) == 1
    error = capsys.readouterr().err
    assert error.startswith("animate: ") and error.count("\n") == 1 and part in error


@pytest.mark.parametrize("up", [(0, 0, 1), (0, 1, 0), (0.6, 0, 0.8)])
def test_views_keep_up_upright_and_are_right_handed(up: tuple[float, ...]) -> None:
    view = View.around(np.array(up, float), -60.0, 18.0)
    assert np.cross(view.right, view.up) == pytest.approx(view.out)
    assert view.flat(np.array(up)) == pytest.approx([0, np.cos(np.radians(18))])


def test_faces_look_outwards() -> None:
    for faces in (solids.box(np.array([1.0, 2, 3])), solids.cylinder(1.0, 2.0, np.array([0.6, 0, 0.8]))):
        assert all(solids.normal(face) @ face.mean(axis=0) > 0 for face in faces)
        corners = np.concatenate(faces)
        assert np.abs(corners.mean(axis=0)).max() < 1e-12


def test_everything_can_be_drawn(tmp_path: Path) -> None:
    style.use()
    mechanism = case(tmp_path, ZOO)
    figure = plt.figure()
    axes = figure.add_subplot()
    look = Look(traces=("mass", "j10"), names=True)
    scene = Scene(axes, mechanism, at_rest(mechanism), look, np.array([0.0, 0.5]))
    scene.move(2)
    figure.canvas.draw()
    names = {text.get_text() for text in axes.texts}
    assert set(mechanism.bodies) == names
    # Everything is inside the picture.
    x, y = axes.get_xlim(), axes.get_ylim()
    for body in mechanism.bodies.values():
        at = scene.view.flat(body.position)
        assert x[0] < at[0] < x[1] and y[0] < at[1] < y[1]
    plt.close(figure)


def test_a_flat_motion_in_space_is_seen_from_its_normal() -> None:
    mechanism = read_mechanism(ROOT / "cases/mechanism/swing.nml")
    figure = plt.figure()
    scene = Scene(figure.add_subplot(), mechanism, at_rest(mechanism), Look())
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
    tmp_path: Path, first: tuple[float, ...], second: tuple[float, ...], until: int
) -> None:
    plane = np.stack([first, second, np.cross(first, second)], axis=1)
    mechanism = case(tmp_path, PENDULUM.replace("planar = .true.", ""))
    # What cannot be seen does not matter.
    whole = swinging(mechanism, plane, 1e-6)
    figure = plt.figure()
    scene = Scene(figure.add_subplot(), mechanism, whole.at(whole.times[: until + 1]), Look(), whole=whole)
    assert scene.flat and abs(scene.view.out @ plane[:, 2]) == pytest.approx(1, abs=1e-6)
    assert np.cross(scene.view.right, scene.view.up) == pytest.approx(scene.view.out)
    level = abs(plane[2, 2]) > 0.999
    assert scene.view.flat(np.array([0, 1.0, 0] if level else [0, 0, 1.0]))[1] > 0.5
    # What leaves the plane does, and who asks for another view gets it.
    for motion, look in ((swinging(mechanism, plane, 0.01), Look()), (whole, Look((-60.0, 18.0)))):
        scene = Scene(figure.add_subplot(), mechanism, motion, look)
        assert not scene.flat and scene.view.out @ mechanism.up == pytest.approx(np.sin(np.radians(18)))
    plt.close(figure)


@pytest.mark.parametrize(
    ("along", "out"), [((1.0, 0, 0), (0, -1, 0)), ((0, 1.0, 0), (1, 0, 0)), ((0, 0, 1.0), (0, -1, 0))]
)
def test_what_is_on_a_line_is_seen_upright(
    tmp_path: Path, along: tuple[float, ...], out: tuple[float, ...]
) -> None:
    to = ", ".join(str(value) for value in along)
    beam = f'&beam name = "n", from = 0, 0, 0, to = {to}, axis_2 = 0.6, 0.48, 0.64, elements = 2 /\n'
    mechanism = case(tmp_path, "&gravity /\n" + beam)
    figure = plt.figure()
    scene = Scene(figure.add_subplot(), mechanism, at_rest(mechanism), Look())
    assert scene.view.out == pytest.approx(out) and scene.view.up == pytest.approx([0, 0, 1])
    plt.close(figure)


def test_a_disc_touches_its_plane_below_its_center(tmp_path: Path) -> None:
    from taut.animate.symbols import contact

    mechanism = case(tmp_path, ZOO)
    (joint,) = (joint for joint in mechanism.joints if joint.type == "rolling")
    assert contact(mechanism, at_rest(mechanism), joint)[0] == pytest.approx([1, 1, 0])


def test_traces_end_where_the_point_is(pendulum: Path) -> None:
    mechanism = read_mechanism(pendulum / "case.nml")
    motion = of_run(mechanism, read_run(pendulum / "results/case/present.csv"))
    figure = plt.figure()
    scene = Scene(figure.add_subplot(), mechanism, motion.at(np.array([0.0, 1.0, 2.0])), Look(), fine=motion)
    scene.move(1)
    ((line, _),) = scene.traces
    x, y = line.get_data()
    assert (x[-1], y[-1]) == pytest.approx((np.cos(2), np.sin(2)))
    assert len(x) == 21
    plt.close(figure)


def test_a_still_shows_its_time_and_its_strobe(pendulum: Path) -> None:
    mechanism = read_mechanism(pendulum / "case.nml")
    motion = of_run(mechanism, read_run(pendulum / "results/case/present.csv"))
    figure = plt.figure()
    axes = figure.add_subplot()
    draw_still(axes, Shown(mechanism, motion), 1.01, 3)
    assert axes.get_title("left") == "case" and "1.01 s" in axes.get_title("right")
    faint = [c for c in axes.collections if c.get_alpha() is not None and c.get_alpha() < 1]
    assert len(faint) == 2 * 3
    plt.close(figure)


def test_traces_of_what_there_is_not(pendulum: Path) -> None:
    mechanism = read_mechanism(pendulum / "case.nml")
    assert anchor_of(mechanism, "hinge").body == "rod"
    with pytest.raises(TautError, match="'tap'; there are rod, tip, hinge"):
        anchor_of(mechanism, "tap")


def test_meshes_are_round_numbers() -> None:
    assert [nice(v) for v in (0.97, 0.23, 33.0, 7.5e-3)] == pytest.approx([1.0, 0.2, 50.0, 0.01])


def test_columns_of_a_unit_share_a_panel(pendulum: Path) -> None:
    run = read_run(pendulum / "results/case/present.csv")
    figure = curves("case", run, ["hinge.fx", "rod.x", "hinge.fy", "energy"])
    assert [axes.get_ylabel() for axes in figure.axes] == ["force [N]", "position [m]", "energy [J]"]
    assert [len(axes.get_lines()) for axes in figure.axes] == [2, 1, 1]
    assert (unit_of("a.m3"), unit_of("rank")) == ("moment [N m]", "rank")
    plt.close(figure)


def test_animation(pendulum: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = [str(pendulum / "case.nml"), "--results", str(pendulum / "results")]
    assert main([*arguments, "--seconds", "0.25", "--below", "hinge.fx"]) == 0
    path = pendulum / "results/figures/case.gif"
    assert capsys.readouterr().out == f"2 s in 0.25 s\n{path}\n"
    with Image.open(path) as picture:
        assert (picture.n_frames, picture.info["duration"]) == (5, 50)
        first = np.asarray(picture.convert("RGB"))
        picture.seek(4)
        assert (np.asarray(picture.convert("RGB")) != first).any()


def test_still_and_plot(pendulum: Path) -> None:
    arguments = [str(pendulum / "case.nml"), str(pendulum / "results/case/present.csv")]
    still, plot = pendulum / "new/still.png", pendulum / "plot.pdf"
    assert main([*arguments, "--still", "1.0", str(still), "--strobe", "2"]) == 0
    assert main([*arguments, "--plot", "hinge.fx", "energy", "--out", str(plot)]) == 0
    assert main([*arguments, "--still", str(pendulum / "last.png")]) == 0
    assert (pendulum / "last.png").read_bytes().startswith(b"\x89PNG")
    assert still.read_bytes().startswith(b"\x89PNG") and plot.read_bytes().startswith(b"%PDF")


@pytest.mark.parametrize(
    ("arguments", "part"),
    [
        (["--plot", "hinge.fz"], "no column 'hinge.fz'; there are hinge.f"),
        (["--trace", "tap"], "'tap'"),
        (["--out", "case.mp4"], "case.mp4: an .mp4 needs the program ffmpeg"),
        (["--out", "case.avi"], "a .gif or an .mp4"),
        (["--still", "soon", "a.png"], "no number"),
        (["--still", "1", "a.xyz"], "xyz"),
        (["--still", "99", "a.png"], "--still 99: the results go from 0 to 2 s"),
        (["--still", "-1", "a.png"], "the results go from 0 to 2 s"),
        (["--still", "nan", "a.png"], "the results go from 0 to 2 s"),
        (["--still", "1", "a.png", "b.png"], "--still takes [TIME] FILE"),
        (["--seconds", "-1"], "--seconds -1"),
        (["--seconds", "0"], "--seconds 0"),
        (["--strobe", "-1"], "--strobe -1"),
        (["--mode", "2"], "--mode 2: case.nml is a motion over time"),
        (["--window", "3", "1", "0", "1"], "--window 3 1 0 1: X1 must be less than X2"),
        (["--window", "0", "1", "1", "1"], "Y1 less than Y2"),
        (["none.csv"], "none.csv is missing: run `fpm run mechanism --profile release -- case.nml` first"),
        (["--from", "3"], "nothing between"),
    ],
    ids=" ".join,
)
def test_bad_arguments_are_told_in_one_line(
    pendulum: Path,
    arguments: list[str],
    part: str,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(pendulum)
    monkeypatch.setenv("PATH", "")
    assert main(["case.nml", *arguments]) == 1
    error = capsys.readouterr().err
    assert error.startswith("animate: ") and error.count("\n") == 1 and part in error


def test_results_that_are_missing(pendulum: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(pendulum / "case.nml"), "--results", str(pendulum / "other")]) == 1
    error = capsys.readouterr().err
    assert "other/case/summary.csv is missing" in error and f"release -- {pendulum / 'case.nml'}`" in error


def test_result_of_another_case(pendulum: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = pendulum / "results/case/present.csv"
    path.write_text(path.read_text().replace("rod.", "bar."))
    assert main([str(pendulum / "case.nml"), str(path)]) == 1
    assert "no column 'rod.x'" in capsys.readouterr().err


def test_script_asks_for_a_case() -> None:
    command = [sys.executable, str(ROOT / "scripts/animate")]
    ended = subprocess.run(command, capture_output=True, text=True, check=False)
    assert ended.returncode == 2
    assert "give a case file, or --gallery" in ended.stderr


def test_gallery_has_every_shipped_case() -> None:
    assert sorted(recipe.case for recipe in gallery.RECIPES) == [path.stem for path in CASES]
    picture = ROOT / "cases/mechanism/gallery.png"
    assert picture.stat().st_size <= 300_000


def test_gallery(pendulum: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from taut.results import Results

    monkeypatch.setattr(gallery, "RECIPES", (gallery.Recipe("case", "a pendulum", 1.0, 2),))
    paths = gallery.make(pendulum, Results(pendulum / "results"))
    assert [path.name for path in paths] == ["case.png", "gallery.png"]
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in paths)
