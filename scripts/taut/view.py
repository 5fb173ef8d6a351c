"""Pictures of space seen from afar: orthographic, so that equal lengths along a direction stay equal."""

from dataclasses import dataclass

import numpy as np

from taut.results import Array


@dataclass(frozen=True)
class View:
    """Directions in space: to the right and up in the picture, and out of it towards the eye."""

    right: Array
    up: Array
    out: Array

    @classmethod
    def around(cls, up: Array, turn: float, height: float) -> "View":
        """Looks from a direction given in degrees: turned about what is up, and above the level."""
        a, b = np.radians(turn), np.radians(height)
        # The level axes follow up in the order x, y, z: for z they are x and y.
        first = np.roll(np.eye(3)[np.argmax(np.abs(up))], 1)
        first = first - up * (first @ up)
        first = first / np.linalg.norm(first)
        second = np.cross(up, first)
        out = np.cos(b) * (np.cos(a) * first + np.sin(a) * second) + np.sin(b) * up
        right = np.cos(a) * second - np.sin(a) * first
        return cls(right, np.cross(out, right), out)

    @classmethod
    def of_plane(cls) -> "View":
        """Looks at the plane x-y against z."""
        return cls(*np.eye(3))

    def flat(self, points: Array) -> Array:
        """Returns where points are in the picture."""
        return points @ np.stack([self.right, self.up], axis=1)

    def depth(self, points: Array) -> Array:
        """Returns how near points are to the eye."""
        return points @ self.out
