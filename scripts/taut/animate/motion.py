"""Where every body is over time: from the columns of a run, or of a mode about an equilibrium."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from taut.animate.geometry import GROUND, Anchor, Mechanism
from taut.errors import TautError
from taut.results import Array, Run, read_run, read_table

# How far the farthest body center of a mode goes, of the mechanism's size; and the pictures of a period.
SWING, PERIOD = 0.15, 48


@dataclass(frozen=True)
class Motion:
    """Times (n), and by body positions (n, 3) and rotation matrices (n, 3, 3)."""

    times: Array
    positions: dict[str, Array]
    rotations: dict[str, Array]
    # Which mode it is, or that it is the equilibrium; empty of a run.
    about: str = ""

    def point(self, anchor: Anchor) -> Array:
        """Returns the path of a point: (n, 3)."""
        if anchor.body == GROUND:
            return np.broadcast_to(anchor.at, (len(self.times), 3))
        return self.positions[anchor.body] + self.rotations[anchor.body] @ anchor.at

    def direction(self, body: str, axis: Array) -> Array:
        """Returns a direction of a body, given in its axes, in space: (n, 3)."""
        if body == GROUND:
            return np.broadcast_to(axis, (len(self.times), 3))
        return self.rotations[body] @ axis

    def at(self, times: Array) -> "Motion":
        """Returns the motion at other times, between those that there are."""
        right = np.clip(np.searchsorted(self.times, times), 1, max(len(self.times) - 1, 1))
        if len(self.times) == 1:
            right, part = np.zeros(len(times), int), np.zeros(len(times))
        else:
            steps = np.maximum(self.times[right] - self.times[right - 1], 1e-300)
            part = np.clip((times - self.times[right - 1]) / steps, 0.0, 1.0)
        left = np.maximum(right - 1, 0)
        positions = {
            body: x[left] + part[:, None] * (x[right] - x[left]) for body, x in self.positions.items()
        }
        rotations = {}
        for body, matrices in self.rotations.items():
            step = Rotation.from_matrix(matrices[left]).inv() * Rotation.from_matrix(matrices[right])
            turned = Rotation.from_rotvec(part[:, None] * step.as_rotvec())
            rotations[body] = matrices[left] @ turned.as_matrix()
        return Motion(times, positions, rotations, self.about)


def of_run(mechanism: Mechanism, run: Run) -> Motion:
    """Takes the coordinates of all bodies from a run."""
    n = len(run["t"])
    positions, rotations = {}, {}
    for name, body in mechanism.bodies.items():
        z = np.zeros(n) if mechanism.planar else run[f"{name}.z"]
        positions[name] = np.stack([run[f"{name}.x"], run[f"{name}.y"], z], axis=1)
        if body.shape == "point":
            rotations[name] = np.broadcast_to(np.eye(3), (n, 3, 3))
        elif mechanism.planar:
            rotations[name] = _turned(run[f"{name}.angle"])
        else:
            q = np.stack([run[f"{name}.q{part}"] for part in "bcda"], axis=1)
            rotations[name] = Rotation.from_quat(q).as_matrix()
    return Motion(run["t"], positions, rotations)


def _turned(angle: Array) -> Array:
    """Returns rotations about z."""
    return Rotation.from_rotvec(np.outer(angle, [0.0, 0.0, 1.0])).as_matrix()


def of_mode(mechanism: Mechanism, folder: Path, mode: int) -> Motion:
    """Returns a period of a mode about the equilibrium, enlarged; mode 0 is the equilibrium itself."""
    rest = of_run(mechanism, _row(folder / "equilibrium.csv"))
    if mode == 0:
        return replace(rest, about="equilibrium")
    modes = read_run(folder / "modes.csv")
    if not 1 <= mode <= len(modes["mode"]):
        raise TautError(f"{folder / 'modes.csv'}: there is no mode {mode}; it has {len(modes['mode'])}")
    frequency = float(modes["frequency"][mode - 1])
    about = f"mode {mode}, {frequency:.4g} Hz"
    frequency = max(frequency, 1e-9)
    moves, turns = {}, {}
    for name, body in mechanism.bodies.items():
        parts = ("vx", "vy") if mechanism.planar else ("vx", "vy", "vz")
        move = [float(modes[f"{name}.{part}"][mode - 1]) for part in parts]
        moves[name] = np.array([*move, 0.0])[:3]
        turns[name] = np.zeros(3)
        if body.shape != "point":
            parts = ("wz",) if mechanism.planar else ("wx", "wy", "wz")
            turn = [float(modes[f"{name}.{part}"][mode - 1]) for part in parts]
            turns[name] = np.array([0.0, 0.0, *turn])[-3:]
    centers = np.array([x[0] for x in rest.positions.values()])
    size = max(
        float(np.ptp(centers, axis=0).max()), *(float(b.size.max()) for b in mechanism.bodies.values())
    )
    # Neither a long way nor a large angle.
    scale = min(
        SWING * size / max(max(np.linalg.norm(m) for m in moves.values()), 1e-300),
        0.35 / max(max(np.linalg.norm(t) for t in turns.values()), 1e-300),
    )
    phase = scale * np.sin(2 * np.pi * np.arange(PERIOD + 1) / PERIOD)
    positions = {name: rest.positions[name] + phase[:, None] * moves[name] for name in moves}
    rotations = {}
    for name, turn in turns.items():
        r = rest.rotations[name][0]
        # Angular velocities are about body axes in space, and about z in the plane, where both are the same.
        rotations[name] = r @ Rotation.from_rotvec(phase[:, None] * turn).as_matrix()
    return Motion(np.arange(PERIOD + 1) / (PERIOD * frequency), positions, rotations, about)


def _row(path: Path) -> Run:
    """Reads a table of names and values as a run of one moment."""
    try:
        table = read_table(path, remedy="run the case first")
        pairs = zip(table.column("name"), table.column("value"), strict=True)
        values = {name: np.array([float(value)]) for name, value in pairs}
    except ValueError as error:
        raise TautError(f"{path}: {error}: run the case again") from None
    return Run(path, {"t": np.zeros(1)} | values)
