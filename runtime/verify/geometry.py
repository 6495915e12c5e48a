"""Rigid motions as stacks of positions `(T, 3)` and rotation matrices `(T, 3, 3)`, and the measures between them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...langs.frozen import dataclass

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Flags = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Frames:
    """One frame at `T` instants: `position` `(T, 3)` in metres and `rotation` `(T, 3, 3)`, in the world."""

    position: Array
    rotation: Array

    def __getitem__(self, index: slice | Indices) -> Frames:
        return Frames(self.position[index], self.rotation[index])

    def __len__(self) -> int:
        return len(self.position)

    def spread(self, count: int) -> Frames:
        """The same where it is not one frame; else that one, `count` times."""
        if len(self) == count:
            return self
        return Frames(np.broadcast_to(self.position, (count, 3)), np.broadcast_to(self.rotation, (count, 3, 3)))

    def compose(self, placement: Frames) -> Frames:
        """The frames placed relative to these ones; `placement` has one instant or as many."""
        shift = (self.rotation @ placement.position[:, :, None])[:, :, 0]
        return Frames(self.position + shift, self.rotation @ placement.rotation)

    def relative_to(self, base: Frames) -> Frames:
        """These frames as seen from `base`."""
        turned = np.swapaxes(base.rotation, -1, -2)
        shift = (turned @ (self.position - base.position)[:, :, None])[:, :, 0]
        return Frames(shift, turned @ self.rotation)


@dataclass(frozen=True, slots=True)
class HeldFrames:
    """Frames at `T` instants, most of them those of the instant before: the `distinct` ones, and which of them holds
    `at` each instant `(T,)`. Things by the dozen that rest but for a phase or two take little memory so."""

    distinct: Frames
    at: Indices

    def __getitem__(self, index: slice | Indices) -> Frames:
        return self.distinct[self.at[index]]


def frames(poses: ArrayLike) -> Frames:
    """Poses `(T, 7)` or `(7,)` (x, y, z, qx, qy, qz, qw) as frames; quaternions are normalised."""
    rows = np.atleast_2d(np.asarray(poses, dtype=float))
    return Frames(rows[:, :3], rotation_matrices(rows[:, 3:]))


def frames_each(poses: Mapping[str, Sequence[float] | Array], count: int = 1) -> dict[str, Frames]:
    """The frames of poses `(7,)` by name, each at `count` instants."""
    if not poses:
        return {}
    every = frames(np.array(list(poses.values()), dtype=float))
    positions = np.broadcast_to(every.position[:, None], (len(poses), count, 3))
    rotations = np.broadcast_to(every.rotation[:, None], (len(poses), count, 3, 3))
    return {name: Frames(positions[k], rotations[k]) for k, name in enumerate(poses)}


def rotation_matrices(quaternions: Array) -> Array:
    """Rotation matrices `(T, 3, 3)` of quaternions `(T, 4)` in the order x, y, z, w."""
    x, y, z, w = (quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True)).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def crossed(first: Array, second: Array) -> Array:
    """Cross products `(…, 3)`, a third of the time of `np.cross`."""
    made = np.empty(np.broadcast_shapes(first.shape, second.shape))
    a, b, c = (first[..., k] for k in range(3))
    x, y, z = (second[..., k] for k in range(3))
    made[..., 0], made[..., 1], made[..., 2] = b * z - c * y, c * x - a * z, a * y - b * x
    return made


def angles(first: Array, second: Array) -> Array:
    """The angle `(T,)` in radians between rotations, accurate near zero."""
    chord = np.linalg.norm(np.asarray(first - second), axis=(-2, -1)) / (2 * np.sqrt(2))
    return np.asarray(2 * np.arcsin(np.clip(chord, 0.0, 1.0)))


def pose_differences(first: Array, second: Array) -> tuple[Array, Array]:
    """Distances in metres and angles in radians between poses `(T, 7)` and `(T, 7)`."""
    a, b = frames(first), frames(second)
    return np.linalg.norm(a.position - b.position, axis=1), angles(a.rotation, b.rotation)
