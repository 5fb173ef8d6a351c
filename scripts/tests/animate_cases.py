"""Mechanisms to be drawn: what the app `mechanism` makes of a case file, and motions that are made up."""

import subprocess
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from taut.animate.geometry import FILE, Mechanism, read_geometry
from taut.animate.motion import Motion, of_run
from taut.results import read_run

PENDULUM = """&mechanism planar = .true. /
&gravity /
&body name = "rod", shape = "rod", mass = 1, from = 0, 0, to = 1, 0 /
&joint name = "hinge", type = "revolute", body_2 = "rod", point = 0, 0 /
&point name = "tip", body = "rod", position = 1, 0 /
&integration t_end = 1e-3 /
"""
HANGING = PENDULUM.replace("1, 0 /", "0, -1 /")
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
&integration t_end = 1e-3 /
"""


def made(app: Path, folder: Path, text: str, name: str = "case") -> Path:
    """Runs a case for a moment and returns the folder of its results."""
    (folder / f"{name}.nml").write_text(text)
    command = [app, f"{name}.nml", "--quiet"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return folder / "results" / name


def geometry(folder: Path) -> Mechanism:
    """Returns the geometry that is in a folder of results."""
    return read_geometry(folder / FILE, "run it")


def at_rest(folder: Path, times: int = 3) -> Motion:
    """A motion in which everything stays where it starts."""
    start = of_run(geometry(folder), read_run(folder / "present.csv"))
    same = np.zeros(times, int)
    return Motion(
        np.linspace(0, 1, times),
        {name: at[same] for name, at in start.positions.items()},
        {name: at[same] for name, at in start.rotations.items()},
    )


def swinging(plane: np.ndarray, wobble: float = 0.0) -> Motion:
    """The rod of PENDULUM, turning in the plane of the first two columns; it leaves it by a wobble."""
    times = np.linspace(0, 1, 21)
    turned = Rotation.from_rotvec(np.outer(2 * times, [0, 0, 1.0])).as_matrix()
    rotations = plane @ turned
    out = plane[:, 2] * wobble * np.sin(9 * times)[:, None]
    return Motion(times, {"rod": rotations @ [0.5, 0, 0] + out}, {"rod": rotations})
