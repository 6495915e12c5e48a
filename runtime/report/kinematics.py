"""Forward kinematics of a plan's modules at all time stamps, for drawing only; a plan file may hold anything."""

from __future__ import annotations

from collections.abc import Sequence

import msgspec
import numpy as np

from ..geometry import transforms
from ..geometry.transforms import Array
from ..plan import JointRecord, ModuleRecord

IDENTITY = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)


def pose_rows(rows: Sequence[Sequence[float]]) -> Array:
    """Poses `(T, 7)` from plain lists, quaternions made unit; rows that are no pose become the identity."""
    good = [row if len(row) == 7 else IDENTITY for row in rows]
    poses = np.nan_to_num(np.array(good, dtype=np.float64).reshape(-1, 7))
    norms = np.linalg.norm(poses[:, 3:], axis=1, keepdims=True)
    unit = np.divide(poses[:, 3:], norms, out=np.zeros_like(poses[:, 3:]), where=norms > 1e-12)
    unit[norms[:, 0] <= 1e-12, 3] = 1.0
    return np.concatenate([poses[:, :3], unit], axis=1)


def joint_frames(module: ModuleRecord, base: Array, joints: Array) -> list[Array]:
    """The module frame, then every joint's moving frame, each `(T, 7)`.

    `base` `(T, 7)` is the pose of the module frame, `joints` `(T, n)` the joint values.
    """
    return transforms.joint_frames([_drawable(j, i) for i, j in enumerate(module.joints)], base, joints)


def _drawable(joint: JointRecord, index: int) -> JointRecord:
    """The joint with whatever makes no sense in it replaced; its values are drawn as they are stored."""
    return msgspec.structs.replace(
        joint,
        parent=joint.parent if -1 <= joint.parent < index else -1,
        placement=pose_rows([joint.placement])[0].tolist(),
        axis=joint.axis[:3] if len(joint.axis) >= 3 else [0.0, 0.0, 1.0],
        follows=None,
    )
