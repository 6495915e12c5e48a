"""Which spheres of a module can meet one another, and how far a module reaches."""

from __future__ import annotations

import itertools
import math
from functools import lru_cache

import numpy as np

from ..ir import Joint, JointKind, ModuleType, Vec3
from .collision import PATH_MARGIN, Sphere, module_spheres, on_axis, pose_matrix


def _lineage(type_: ModuleType, joint: int) -> list[int]:
    """The joints from `joint` up to the module frame."""
    found = []
    while joint >= 0:
        found.append(joint)
        joint = type_.joints[joint].parent
    return found


def _slide(joint: Joint) -> float:
    """How far a joint can carry its frame from where it is placed."""
    return max(abs(joint.lower), abs(joint.upper)) if joint.kind == JointKind.PRISMATIC else 0.0


def _length_between(type_: ModuleType, a: tuple[int, Vec3], b: tuple[int, Vec3]) -> float:
    """An upper bound of the distance of two points fixed to joint frames, along the joints between them."""
    ends: list[Vec3] = []
    length = 0.0
    for (joint, point), (other, _) in ((a, b), (b, a)):
        shared = _lineage(type_, other)
        while joint != -1 and joint not in shared:
            placement = type_.joints[joint].placement
            length += math.hypot(*point) + _slide(type_.joints[joint])
            point, joint = (placement[0], placement[1], placement[2]), type_.joints[joint].parent
        ends.append(point)
    return length + math.dist(ends[0], ends[1])


def _joints_between(type_: ModuleType, a: Sphere, b: Sphere) -> int:
    """How many joints can change the distance of two spheres: those between them, less the ones next to a
    sphere that turn about an axis through it (for the outer sphere `_hoist` has left these out already)."""
    own, other = _lineage(type_, a.joint), _lineage(type_, b.joint)
    up, down = [j for j in own if j not in other], [j for j in other if j not in own]
    if up and down:
        return len(up) + len(down)
    point = np.array([*(b if up else a).centre, 1.0])
    between = (up or down)[::-1]
    for count, index in enumerate(between):
        joint = type_.joints[index]
        point = np.linalg.solve(pose_matrix(joint.placement), point)
        if joint.kind != JointKind.REVOLUTE or not on_axis(joint.axis, point[:3]):
            return len(between) - count
    return 0


@lru_cache(maxsize=64)
def self_pairs(type_: ModuleType, margin: float = PATH_MARGIN) -> tuple[tuple[int, int], ...]:
    """Pairs of indices into `module_spheres(type_, margin)` that can meet: at least two joints change their
    distance, and along the joints they are farther apart than twice the distance at which they touch."""
    spheres = module_spheres(type_, margin)
    carried: dict[int, list[int]] = {}
    for i, sphere in enumerate(spheres):
        carried.setdefault(sphere.joint, []).append(i)
    found = []
    for inner, outer in itertools.combinations(sorted(carried, key=lambda joint: len(_lineage(type_, joint))), 2):
        far = spheres[carried[outer][0]]
        free = [i for i in carried[inner] if _joints_between(type_, spheres[i], far) >= 2]
        for i, k in itertools.product(free, carried[outer]):
            a, b = spheres[i], spheres[k]
            length = _length_between(type_, (a.joint, a.centre), (b.joint, b.centre))
            if length >= 2 * (a.radius + b.radius + PATH_MARGIN):
                found.append((min(i, k), max(i, k)))
    return tuple(sorted(found))


@lru_cache(maxsize=256)
def reach(type_: ModuleType, effector: str) -> float:
    """An upper bound of how far any point of the module can be from the origin of one effector's frame."""
    e = type_.effector(effector)
    start = (e.joint, (e.placement[0], e.placement[1], e.placement[2]))
    spheres = module_spheres(type_)
    lengths = (_length_between(type_, start, (s.joint, s.centre)) + s.radius for s in spheres)
    return max(lengths, default=0.0) + PATH_MARGIN
