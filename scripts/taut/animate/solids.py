"""Convex solids by their faces, in the axes of a body."""

import numpy as np

from taut.results import Array

SIDES = 28


def box(size: Array) -> list[Array]:
    """Returns the six faces of a box; their corners go round counterclockwise seen from outside."""
    half = size / 2
    faces = []
    for axis in range(3):
        b, c = (axis + 1) % 3, (axis + 2) % 3
        for sign in (1, -1):
            face = np.zeros((4, 3))
            face[:, axis] = sign * half[axis]
            face[:, b] = np.array([1, 1, -1, -1])[::sign] * half[b]
            face[:, c] = np.array([-1, 1, 1, -1])[::sign] * half[c]
            faces.append(face)
    return faces


def cylinder(radius: float, length: float, axis: Array | None = None) -> list[Array]:
    """Returns the two caps, and the strips of the side, of a cylinder about body axis z or another axis."""
    turn = np.linspace(0, 2 * np.pi, SIDES, endpoint=False)
    rim = np.stack([radius * np.cos(turn), radius * np.sin(turn), np.zeros(SIDES)], axis=1)
    top, bottom = rim + [0, 0, length / 2], rim - [0, 0, length / 2]
    faces = [top, bottom[::-1]]
    if length > 0:
        following = np.roll(np.arange(SIDES), -1)
        faces += [
            np.array([bottom[i], bottom[j], top[j], top[i]])
            for i, j in zip(range(SIDES), following, strict=True)
        ]
    if axis is None:
        return faces
    return [face @ along(axis).T for face in faces]


def along(axis: Array) -> Array:
    """Returns a rotation whose third axis is given."""
    other = np.eye(3)[np.argmin(np.abs(axis))]
    first = np.cross(other, axis)
    first = first / np.linalg.norm(first)
    return np.stack([first, np.cross(axis, first), axis], axis=1)


def normal(face: Array) -> Array:
    """Returns a face's outward normal."""
    n = np.cross(face[1] - face[0], face[2] - face[1])
    return n / (np.linalg.norm(n) or 1.0)
