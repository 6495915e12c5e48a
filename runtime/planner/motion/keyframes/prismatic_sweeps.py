"""Phases in which something that slides would have to go right through what rests. It can hardly be led around that,
and that no path is found is noticed long after P_seq."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise

import numpy as np

from .....compiler import poses
from .....compiler.extents import box_sides
from .....compiler.ir import JointKind, ModuleType, ShapeKind, Vec3
from .....compiler.motion.collision import module_spheres, pose_matrix
from ....geometry.attachments import followers
from ....skeleton import Array, Configuration, Skeleton
from .initial_guesses import to_tuple
from .settings import KEYFRAMES


def _slides(type_: ModuleType) -> list[int]:
    """The sliding joints of a module."""
    return [k for k, joint in enumerate(type_.joints) if joint.kind == JointKind.PRISMATIC]


@lru_cache(maxsize=64)
def _sliding(type_: ModuleType) -> dict[int, Array]:
    """The centres `(spheres, 3)` of the spheres that sliding joints of a module carry, by joint."""
    slides = _slides(type_)
    carried: set[int] = set()
    for k, joint in enumerate(type_.joints):
        if k in slides or joint.parent in carried:
            carried.add(k)
    centres: dict[int, list[Vec3]] = {}
    for sphere in module_spheres(type_) if carried else ():
        if sphere.joint in carried:
            centres.setdefault(sphere.joint, []).append(sphere.centre)
    return {joint: np.array(points) for joint, points in centres.items()}


def _centres(type_: ModuleType, slot: Array) -> Array:
    """Where these centres are `(spheres, 3)` in the world, by the module's slot `(7 + joints,)`."""
    frames = poses.joint_frames(type_, to_tuple(slot[:7]), slot[7:].tolist())
    placed = ((pose_matrix(frames[joint]), points) for joint, points in _sliding(type_).items())
    return np.concatenate([points @ frame[:3, :3].T + frame[:3, 3] for frame, points in placed])


def _slid(type_: ModuleType, before: Array, after: Array) -> Array | None:
    """Where these centres are `(places, spheres, 3)` between two slots of a module; None where it hardly slides."""
    slides = _slides(type_)
    if math.dist(before[7:][slides], after[7:][slides]) < KEYFRAMES.sweep_moved or not _sliding(type_):
        return None
    slots = np.repeat(before[None], KEYFRAMES.sweep_looks - 1, axis=0)
    slots[:, 7:] += np.arange(1, KEYFRAMES.sweep_looks)[:, None] / KEYFRAMES.sweep_looks * (after[7:] - before[7:])
    return np.array([_centres(type_, slot) for slot in slots])


def reach(skeleton: Skeleton, phase: int, before: Configuration, after: Configuration) -> float:
    """The share of the straight way between the switches of a phase up to where something that slides first touches
    the body at rest in which most of it then is somewhere; 1 where it goes through none."""
    world = skeleton.problem.world
    ways = (_slid(m.type, before.modules[name], after.modules[name]) for name, m in world.modules.items())
    slid = [points for points in ways if points is not None]
    least = KEYFRAMES.sweep_looks
    if not slid:
        return 1.0
    carried = followers(skeleton.problem, skeleton.phases[phase].mode)
    for body in world.solids:
        name = body.name
        flat = [p for p in body.shape.solids if p.shape.kind in (ShapeKind.BOX, ShapeKind.CONVEX)]
        for part in [] if name in carried else flat:
            frame = pose_matrix(before.bodies[name]) @ pose_matrix(part.placement)
            half = np.array(box_sides(part.shape)) / 2
            for points in slid:
                within = (np.abs((points - frame[:3, 3]) @ frame[:3, :3]) < half).all(axis=2)
                if within.mean(axis=1).max() > KEYFRAMES.sweep_through:
                    least = min(least, int(np.flatnonzero(within.sum(axis=1))[0]))
    return least / KEYFRAMES.sweep_looks


def all_pierced(skeleton: Skeleton, first: int, configurations: Sequence[Configuration]) -> list[int]:
    """Such phases from `first` on, between switch configurations that begin with the state before it."""
    pairs = pairwise(configurations)
    return [first + k for k, (before, after) in enumerate(pairs) if reach(skeleton, first + k, before, after) < 1.0]


def held_back(
    skeleton: Skeleton, first: int, configurations: Sequence[Configuration], phases: Sequence[int]
) -> list[Configuration]:
    """Switch configurations as a start in which modules end such phases, by their number in the skeleton, before
    what they would go through; of two that follow each other the first, as it leads to where the second has to come
    from. Configurations begin with the state before phase `first`."""
    held = [configuration.copy() for configuration in configurations]
    last = -2
    for phase in phases:
        if phase - 1 == last:
            continue
        last, k = phase, phase - first
        share = reach(skeleton, phase, configurations[k], configurations[k + 1])
        for name, slot in held[k + 1].modules.items():
            slot[:] = (1.0 - share) * configurations[k].modules[name] + share * slot
            slot[3:7] /= np.linalg.norm(slot[3:7])
    return held
