"""A mechanism at one time, as a picture needs it."""

from dataclasses import dataclass

import numpy as np

from taut.animate.geometry import GROUND
from taut.animate.motion import Motion
from taut.results import Array
from taut.view import View


@dataclass(frozen=True)
class Moment:
    """The poses of all bodies at one time, and how they are seen."""

    motion: Motion
    index: int
    view: View

    def points(self, body: str, at: Array) -> Array:
        """Returns points of a body, given in its axes, in space: (n, 3)."""
        if body == GROUND:
            return np.atleast_2d(at)
        position, rotation = self.motion.positions[body], self.motion.rotations[body]
        return position[self.index] + np.atleast_2d(at) @ rotation[self.index].T

    def directions(self, body: str, axes: Array) -> Array:
        """Returns directions of a body, given in its axes, in space: (n, 3)."""
        if body == GROUND:
            return np.atleast_2d(axes)
        return np.atleast_2d(axes) @ self.motion.rotations[body][self.index].T
