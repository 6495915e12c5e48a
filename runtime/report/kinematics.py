"""Forward kinematics of a plan's modules at all time stamps at once, for drawing only.

Poses are arrays `(T, 7)`: x, y, z, qx, qy, qz, qw in the world frame, metres; T is the number of time stamps.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..plan import JointRecord, ModuleRecord

Array = NDArray[np.float64]
IDENTITY = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)


def multiply(left: Array, right: Array) -> Array:
    """Hamilton product of quaternions `(…, 4)`, x y z w."""
    a, b = left[..., :3], right[..., :3]
    s, t = left[..., 3:], right[..., 3:]
    vector = s * b + t * a + np.cross(a, b)
    return np.concatenate([vector, s * t - np.sum(a * b, axis=-1, keepdims=True)], axis=-1)


def rotate(quaternion: Array, vector: Array) -> Array:
    """Vectors `(…, 3)` turned by unit quaternions `(…, 4)`."""
    axis, scalar = quaternion[..., :3], quaternion[..., 3:]
    twice = 2.0 * np.cross(axis, vector)
    return vector + scalar * twice + np.cross(axis, twice)


def compose(left: Array, right: Array) -> Array:
    """Pose product left · right, shapes `(…, 7)` that broadcast."""
    position = left[..., :3] + rotate(left[..., 3:], right[..., :3])
    quaternion = multiply(*np.broadcast_arrays(left[..., 3:], right[..., 3:]))
    return np.concatenate([np.broadcast_to(position, (*quaternion.shape[:-1], 3)), quaternion], axis=-1)


def pose_rows(rows: Sequence[Sequence[float]]) -> Array:
    """Poses `(T, 7)` from plain lists, quaternions made unit; rows that are no pose become the identity."""
    good = [row if len(row) == 7 else IDENTITY for row in rows]
    poses = np.nan_to_num(np.array(good, dtype=np.float64).reshape(-1, 7))
    norms = np.linalg.norm(poses[:, 3:], axis=1, keepdims=True)
    unit = np.divide(poses[:, 3:], norms, out=np.zeros_like(poses[:, 3:]), where=norms > 1e-12)
    unit[norms[:, 0] <= 1e-12, 3] = 1.0
    return np.concatenate([poses[:, :3], unit], axis=1)


def joint_motion(joint: JointRecord, values: Array) -> Array:
    """The joint's own transform `(T, 7)` for values `(T,)`, rad or m; kinds other than these two stay put."""
    motion = np.zeros((len(values), 7))
    motion[:, 6] = 1.0
    axis = np.array(joint.axis[:3] if len(joint.axis) >= 3 else (0.0, 0.0, 1.0))
    axis = axis / max(float(np.linalg.norm(axis)), 1e-12)
    if joint.kind == "revolute":
        motion[:, 3:6] = np.sin(values / 2.0)[:, None] * axis
        motion[:, 6] = np.cos(values / 2.0)
    elif joint.kind == "prismatic":
        motion[:, :3] = values[:, None] * axis
    return motion


def joint_frames(module: ModuleRecord, base: Array, joints: Array) -> list[Array]:
    """The module frame, then every joint's moving frame, each `(T, 7)`.

    `base` `(T, 7)` is the pose of the module frame, `joints` `(T, n)` the joint values.
    """
    frames = [base]
    for index, joint in enumerate(module.joints):
        parent = joint.parent if -1 <= joint.parent < index else -1
        placement = pose_rows([joint.placement])
        moved = compose(placement, joint_motion(joint, joints[:, index]))
        frames.append(compose(frames[parent + 1], moved))
    return frames
