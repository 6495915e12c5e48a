"""Which modules stand for each other, and which are the same from both ends."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import lru_cache

from ..ir import (
    IDENTITY,
    ModuleType,
    Pose,
    Vec3,
)
from ..poses import compose, effector_pose, joint_frames, orientation, position, product, rotate

CLOSE = 1e-6


@lru_cache(maxsize=64)
def _reversible(kind: ModuleType) -> bool:
    if len(kind.effectors) != 2 or any(j.passive or j.follows is not None for j in kind.joints):
        return False
    first, second = kind.effectors
    if first.type != second.type or first.shape != second.shape:
        return False
    if (first.mass, first.holds) != (second.mass, second.holds) or kind.inertials:
        return False
    weights = [k.mass for k in kind.links]
    if weights != weights[::-1]:
        return False
    rest = [0.0] * len(kind.joints)
    frames = joint_frames(kind, IDENTITY, rest)
    ends = [inverse(effector_pose(kind, e.name, rest)) for e in kind.effectors]
    forward, backward = ([_seen(kind, frames, end, i) for i in range(len(kind.joints))] for end in ends)
    limits = all(math.isclose(-j.lower, j.upper, abs_tol=CLOSE) for j in kind.joints)
    return limits and all(_same(a, b) for a, b in zip(forward, reversed(backward), strict=True))


def is_reversible(kind: ModuleType) -> bool:
    """Whether a module of two effectors moves the same seen from either: joints mirrored, limits symmetric."""
    return _reversible(kind)


Seen = tuple[str, Vec3, Vec3, float, float, tuple[float, ...]]


def _seen(kind: ModuleType, frames: Mapping[int, Pose], end: Pose, i: int) -> Seen:
    joint = kind.joints[i]
    frame = compose(end, frames[i])
    axis = rotate(orientation(frame), joint.axis)
    return joint.kind, position(frame), axis, joint.upper, joint.speed, (
        joint.acceleration, joint.jerk, joint.mass, joint.torque, joint.bearing, joint.rotor,
        joint.brake,
    )


def _same(a: Seen, b: Seen) -> bool:
    along = abs(sum(x * y for x, y in zip(a[2], b[2], strict=True)))
    return (
        a[0] == b[0]
        and math.dist(a[1], b[1]) < CLOSE
        and along > 1 - CLOSE
        and abs(a[3] - b[3]) < CLOSE
        and abs(a[4] - b[4]) < CLOSE
        and a[5] == b[5]
    )


def inverse(pose: Pose) -> Pose:
    """The pose of the outer frame seen from the inner one."""
    x, y, z, w = orientation(pose)
    back = (-x, -y, -z, w)
    p = rotate(back, position(pose))
    return (-p[0], -p[1], -p[2], *product(back, (0.0, 0.0, 0.0, 1.0)))
