"""Rigid transforms of many time stamps at once, for resampling and drawing.

Poses are arrays `(…, 7)`: x, y, z, qx, qy, qz, qw, in metres, with unit quaternions. The verifier has its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ...compiler.ir import JointKind

Array = NDArray[np.float64]


class Coupling(Protocol):
    """What a joint that follows another one has in common in both."""

    @property
    def leader(self) -> int: ...
    @property
    def factor(self) -> float: ...
    @property
    def offset(self) -> float: ...


class Joint(Protocol):
    """What the joints of the intermediate representation and of plan files have in common."""

    @property
    def kind(self) -> str: ...
    @property
    def follows(self) -> Coupling | None: ...
    @property
    def parent(self) -> int: ...
    @property
    def placement(self) -> Sequence[float]: ...
    @property
    def axis(self) -> Sequence[float]: ...


def cross(left: Array, right: Array) -> Array:
    """The cross products of vectors `(…, 3)`, as NumPy's, which takes several times as long for few of them."""
    result = np.empty(np.broadcast_shapes(left.shape, right.shape))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        result[..., i] = left[..., j] * right[..., k] - left[..., k] * right[..., j]
    return result


_FACTORS = np.array([[3, 2, 1, 0], [2, 3, 0, 1], [1, 0, 3, 2], [0, 1, 2, 3]])
_SIGNS = np.array([[1.0, -1.0, 1.0, 1.0], [1.0, 1.0, -1.0, 1.0], [-1.0, 1.0, 1.0, 1.0], [-1.0, -1.0, -1.0, 1.0]])
"""A product of quaternions is a matrix of the entries of the left one, times the right one."""
_CROSSED = np.array([[0, 2, 1], [2, 0, 0], [1, 0, 0]])
_CROSS_SIGNS = np.array([[0.0, -1.0, 1.0], [1.0, 0.0, -1.0], [-1.0, 1.0, 0.0]])
"""And so is a cross product."""


def _times(matrices: Array, vectors: Array) -> Array:
    found: Array = np.einsum("...ij,...j->...i", matrices, vectors)
    return found


def multiply(left: Array, right: Array) -> Array:
    """Hamilton product of quaternions `(…, 4)`, x y z w."""
    return _times(left[..., _FACTORS] * _SIGNS, right)


def rotations(quaternions: Array) -> Array:
    """The rotation matrices `(…, 3, 3)` of quaternions `(…, 4)`, x y z w, of any length but none."""
    a, b, c, w = np.moveaxis(quaternions, -1, 0)
    n = 2.0 / (a * a + b * b + c * c + w * w)
    rows = [
        [1 - n * (b * b + c * c), n * (a * b - c * w), n * (a * c + b * w)],
        [n * (a * b + c * w), 1 - n * (a * a + c * c), n * (b * c - a * w)],
        [n * (a * c - b * w), n * (b * c + a * w), 1 - n * (a * a + b * b)],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def quaternions(matrices: Array) -> Array:
    """Unit quaternions `(…, 4)` of rotation matrices `(…, 3, 3)`, with w >= 0: of the four multiples of one that are
    sums of entries, the greatest (Shepperd 1978)."""
    (a, b, c), (d, e, f), (g, h, i) = np.moveaxis(matrices, (-2, -1), (0, 1))
    multiples = np.stack([
        np.stack([1 + a - e - i, b + d, c + g, h - f], axis=-1),
        np.stack([b + d, 1 - a + e - i, f + h, c - g], axis=-1),
        np.stack([c + g, f + h, 1 - a - e + i, d - b], axis=-1),
        np.stack([h - f, c - g, d - b, 1 + a + e + i], axis=-1),
    ], axis=-2)  # fmt: skip
    greatest = np.diagonal(multiples, axis1=-2, axis2=-1).argmax(axis=-1)
    found = np.take_along_axis(multiples, greatest[..., None, None], axis=-2)[..., 0, :]
    found = found * np.where(found[..., 3:] < 0, -1.0, 1.0)
    return np.asarray(found / np.linalg.norm(found, axis=-1, keepdims=True))


def rotate(quaternion: Array, vector: Array) -> Array:
    """Vectors `(…, 3)` turned by unit quaternions `(…, 4)`."""
    crossing = quaternion[..., _CROSSED] * _CROSS_SIGNS
    twice = 2.0 * _times(crossing, vector)
    return np.asarray(vector + quaternion[..., 3:] * twice + _times(crossing, twice))


def compose(left: Array, right: Array) -> Array:
    """The pose `right`, given in the frame `left`, in the frame in which `left` is given; shapes `(…, 7)` broadcast."""
    turned = multiply(left[..., 3:], right[..., 3:])
    turned /= np.sqrt(np.einsum("...i,...i->...", turned, turned))[..., None]
    return np.concatenate([left[..., :3] + rotate(left[..., 3:], right[..., :3]), turned], axis=-1)


def inverse(poses: Array) -> Array:
    """The inverses of poses `(…, 7)`."""
    back = poses[..., 3:] * np.array([-1.0, -1.0, -1.0, 1.0])
    return np.concatenate([-rotate(back, poses[..., :3]), back], axis=-1)


@lru_cache(maxsize=1024)
def _in_parent(kind: str, placement: tuple[float, ...], axis: tuple[float, ...]) -> tuple[Array, Array]:
    """The pose `(7,)` of a joint in its parent at 0, and what it gains: of a hinge a quaternion `(4,)` for each sine of
    half the angle, of a slide a way `(3,)` for each metre, of other kinds nothing."""
    at = np.asarray(placement, dtype=np.float64)
    along = np.asarray(axis, dtype=np.float64)
    along = along / max(float(np.linalg.norm(along)), 1e-12)
    if kind == JointKind.REVOLUTE:
        return at, multiply(at[3:], np.append(along, 0.0))
    return at, rotate(at[3:], along) if kind == JointKind.PRISMATIC else np.zeros(0)


def _joint_poses(joint: Joint, values: Array) -> Array:
    """The poses `(T, 7)` of a joint in its parent for its values `(T,)`, rad or m; kinds other than the two stay
    put."""
    at, gain = _in_parent(joint.kind, tuple(joint.placement), tuple(joint.axis))
    poses = np.empty((len(values), 7))
    poses[:] = at
    if joint.kind == JointKind.REVOLUTE:
        half = values[:, None] / 2.0
        poses[:, 3:] = np.cos(half) * at[3:] + np.sin(half) * gain
    elif joint.kind == JointKind.PRISMATIC:
        poses[:, :3] += values[:, None] * gain
    return poses


def coupled(joints: Sequence[Joint], values: Array) -> Array:
    """The joint values `(…, n)` with those of joints that follow others taken from their leaders."""
    following = [(i, j.follows) for i, j in enumerate(joints) if j.follows is not None]
    if following:
        values = values.copy()
    for index, by in following:
        values[..., index] = by.factor * values[..., by.leader] + by.offset
    return values


def joint_frames(joints: Sequence[Joint], base: Array, values: Array) -> list[Array]:
    """The module frame, then every joint's moving frame, each `(T, 7)`.

    `base` `(T, 7)` is the pose of the module frame, `values` `(T, n)` those of the joints, parents first; of joints
    that follow others they do not count.
    """
    frames = [base]
    values = coupled(joints, values)
    for index, joint in enumerate(joints):
        frames.append(compose(frames[joint.parent + 1], _joint_poses(joint, values[:, index])))
    return frames
