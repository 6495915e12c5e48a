"""Rigid poses as plain tuples `(x, y, z, qx, qy, qz, qw)`, metres and unit quaternions, for the start of a scene."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from .ir import IDENTITY, JointKind, ModuleType, Pose, SolidPart, Vec3

Quaternion = tuple[float, float, float, float]


def rotate(q: Quaternion, v: Vec3) -> Vec3:
    """The vector `v` turned by the unit quaternion `q` (x, y, z, w)."""
    x, y, z, w = q
    tx, ty, tz = 2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])
    return (
        v[0] + w * tx + y * tz - z * ty,
        v[1] + w * ty + z * tx - x * tz,
        v[2] + w * tz + x * ty - y * tx,
    )


def product(p: Quaternion, q: Quaternion) -> Quaternion:
    """First turn by `q`, then by `p`."""
    px, py, pz, pw = p
    qx, qy, qz, qw = q
    return (
        pw * qx + px * qw + py * qz - pz * qy,
        pw * qy - px * qz + py * qw + pz * qx,
        pw * qz + px * qy - py * qx + pz * qw,
        pw * qw - px * qx - py * qy - pz * qz,
    )


def position(pose: Pose) -> Vec3:
    return pose[0], pose[1], pose[2]


def orientation(pose: Pose) -> Quaternion:
    return pose[3], pose[4], pose[5], pose[6]


def make(p: Vec3, q: Quaternion) -> Pose:
    return (*p, *q)


def compose(a: Pose, b: Pose) -> Pose:
    """The pose `b`, given in the frame `a`, in the frame in which `a` is given."""
    offset = rotate(orientation(a), position(b))
    return make((a[0] + offset[0], a[1] + offset[1], a[2] + offset[2]), product(orientation(a), orientation(b)))


def part_pose(pose: Pose, part: SolidPart) -> Pose:
    """Where a part of a shape is whose frame is at `pose`."""
    return compose(pose, part.placement) if any(part.at) else pose


def inverse(pose: Pose) -> Pose:
    """The frame in which `pose` is given, in the frame `pose`."""
    turn = (-pose[3], -pose[4], -pose[5], pose[6])
    x, y, z = rotate(turn, position(pose))
    return make((-x, -y, -z), turn)


def about(axis: Vec3, angle: float) -> Quaternion:
    """A turn by `angle` radians about a unit axis."""
    s = math.sin(angle / 2)
    return axis[0] * s, axis[1] * s, axis[2] * s, math.cos(angle / 2)


def yaw(angle: float) -> Quaternion:
    """A turn by `angle` radians about the vertical."""
    return about((0.0, 0.0, 1.0), angle)


def roll_pitch_yaw(roll: float, pitch: float, turn: float) -> Quaternion:
    """Turns about the fixed x-, y- and z-axes, in this order, radians: the `rpy` of URDF."""
    return product(yaw(turn), product(about((0.0, 1.0, 0.0), pitch), about((1.0, 0.0, 0.0), roll)))


def between(a: Vec3, b: Vec3) -> Quaternion:
    """The smallest turn that takes the unit vector `a` to the unit vector `b`; a half turn is made about x, or about y
    where `a` lies along x."""
    dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    if dot < -1 + 1e-12:
        return (1.0, 0.0, 0.0, 0.0) if abs(a[0]) < 0.9 else (0.0, 1.0, 0.0, 0.0)
    x, y, z = a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
    w = 1 + dot
    n = math.sqrt(x * x + y * y + z * z + w * w)
    return x / n, y / n, z / n, w / n


def unit(v: Sequence[float]) -> Vec3 | None:
    """`v` scaled to length 1, or None for the zero vector."""
    n = math.sqrt(sum(x * x for x in v))
    n = n if n < math.inf else math.hypot(*v)
    return (v[0] / n, v[1] / n, v[2] / n) if n > 1e-12 else None


def joint_frames(module: ModuleType, pose: Pose, values: Sequence[float]) -> Mapping[int, Pose]:
    """The moving frame of every joint in the world, by its index; -1 is the module frame itself. The values of joints
    that follow others do not count."""
    frames: dict[int, Pose] = {-1: pose}
    for i, (joint, value) in enumerate(zip(module.joints, values, strict=True)):
        if joint.follows is not None:
            value = joint.follows.factor * values[joint.follows.leader] + joint.follows.offset
        base = compose(frames[joint.parent], joint.placement)
        if joint.kind == JointKind.REVOLUTE:
            motion = make((0.0, 0.0, 0.0), about(joint.axis, value))
        else:
            motion = make((joint.axis[0] * value, joint.axis[1] * value, joint.axis[2] * value), (0.0, 0.0, 0.0, 1.0))
        frames[i] = compose(base, motion)
    return frames


def effector_pose(module: ModuleType, name: str, values: Sequence[float]) -> Pose:
    """The effector's frame in the module frame."""
    effector = module.effector(name)
    return compose(joint_frames(module, IDENTITY, values)[effector.joint], effector.placement)
