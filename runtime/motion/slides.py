"""Phases in which something that slides would have to go right through what rests. It can hardly be led around that,
and that no path is found is noticed long after P_seq."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from ...compiler import poses
from ...compiler.extents import box_sides
from ...compiler.ir import Module
from ...compiler.motion.collision import Sphere, module_spheres, pose_matrix
from ..skeleton import Array, Configuration, Skeleton
from .movement import followers
from .starts import to_tuple

LOOKS = 12
"""At how many places between two switches what slides is looked at."""
THROUGH = 0.5
"""The share of its spheres whose centres lie in something at rest from which it goes right through."""
MOVED = 0.05
"""Metres that something must slide to be looked at."""


def _sliding(module: Module) -> tuple[list[int], list[Sphere]]:
    """The sliding joints of a module, and the spheres that they carry."""
    joints = module.type.joints
    slides = [k for k, joint in enumerate(joints) if joint.kind == "prismatic"]
    carried: set[int] = set()
    for k, joint in enumerate(joints):
        if k in slides or joint.parent in carried:
            carried.add(k)
    return slides, [s for s in module_spheres(module.type) if s.joint in carried]


def _centres(module: Module, slot: Array, spheres: Sequence[Sphere]) -> Array:
    """Centres `(spheres, 3)` in the world, by the module's slot `(7 + joints,)`."""
    frames = poses.joint_frames(module.type, to_tuple(slot[:7]), slot[7:].tolist())
    matrices = {joint: pose_matrix(frames[joint]) for joint in {s.joint for s in spheres}}
    return np.array([matrices[s.joint][:3, :3] @ s.centre + matrices[s.joint][:3, 3] for s in spheres])


def pierced(skeleton: Skeleton, phase: int, before: Configuration, after: Configuration) -> bool:
    """Whether, on the straight way between the switches of a phase, most of something that slides is somewhere within
    a body at rest."""
    world = skeleton.problem.world
    carried = followers(skeleton.problem, skeleton.phases[phase].mode)
    blocks = [
        (pose_matrix(before.bodies[name]), np.array(box_sides(body.shape)) / 2)
        for name, body in world.bodies.items() if name not in carried and body.shape.kind in ("box", "convex")
    ]  # fmt: skip
    for name, module in world.modules.items():
        slides, spheres = _sliding(module)
        start, change = before.modules[name], after.modules[name] - before.modules[name]
        if not spheres or float(np.linalg.norm(change[7:][slides])) < MOVED:
            continue
        for share in np.arange(1, LOOKS) / LOOKS:
            slot = start.copy()
            slot[7:] += share * change[7:]
            points = _centres(module, slot, spheres)
            for frame, half in blocks:
                within = (np.abs((points - frame[:3, 3]) @ frame[:3, :3]) < half).all(axis=1)
                if within.mean() > THROUGH:
                    return True
    return False


def all_pierced(skeleton: Skeleton, first: int, configurations: Sequence[Configuration]) -> list[int]:
    """Such phases from `first` on, between switch configurations that begin with the state before it."""
    pairs = pairwise(configurations)
    return [first + k for k, (before, after) in enumerate(pairs) if pierced(skeleton, first + k, before, after)]


def held_back(configurations: Sequence[Configuration], phases: Sequence[int]) -> list[Configuration]:
    """Switch configurations as a start in which such phases, by their number in it, end where they begin; of two that
    follow each other the first, as it leads to where the second has to come from."""
    result = [configuration.copy() for configuration in configurations]
    held = -2
    for phase in phases:
        if phase - 1 != held:
            result[phase + 1] = result[phase].copy()
            held = phase
    return result
