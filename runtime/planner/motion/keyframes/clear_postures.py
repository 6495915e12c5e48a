"""Postures that bring a hand to a thing from a side that is free: into a box from above, say. Descent from a posture in
which a link goes through a wall of the box seldom gets out of it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .....compiler.ir import Module, Shape
from .....compiler.motion.collision import PATH_MARGIN, bounding_radius, module_spheres
from ....geometry.signed_distances import half_sizes
from ....geometry.transforms import compose, inverse, rotate
from ....skeleton import Array
from .posture_samples import Aim, Stance, closing, hands, rooms, standing
from .settings import KEYFRAMES

Solids = Sequence[tuple[Shape, Array]]
"""Shapes and their poses `(7,)` in the world."""


def clear_posture(
    module: Module, values: Array, stance: Stance, aim: Aim, room: float, random: np.random.Generator, solids: Solids
) -> Array:
    """Joint values `(n,)` that bring an effector of a module that stands on another one to its distance from an aim, on
    a side where there is room for it, with as little of the module in `solids` as can be found."""
    shape = module.type.effector(aim.effector).shape
    size = bounding_radius(shape) if shape else 0.0
    sides = random.normal(size=(KEYFRAMES.clear_sides, 3))
    sides /= np.linalg.norm(sides, axis=1, keepdims=True)
    points = aim.point + aim.distance * sides
    points = points[np.argsort(_within(points, size, solids), kind="stable")[: KEYFRAMES.clear_tries]]
    limits = rooms(module, room)
    anywhere = random.uniform(limits[0], limits[1], (KEYFRAMES.clear_postures, len(values)))
    drawn = np.concatenate([np.clip(values, *limits)[None], anywhere])
    there = hands(module.type, stance, aim.effector, drawn)[:, :3]
    nearest = [int(np.linalg.norm(there - point, axis=1).argmin()) for point in points]
    found = np.stack([
        closing(module, drawn[k], stance, Aim(aim.effector, point, 0.0), room)
        for k, point in zip(nearest, points, strict=True)
    ])
    miss = np.linalg.norm(hands(module.type, stance, aim.effector, found)[:, :3] - points, axis=1)
    return np.asarray(found[int((miss + _in_the_way(module, stance, found, solids)).argmin())])


def _in_the_way(module: Module, stance: Stance, values: Array, solids: Solids) -> Array:
    """How deep the spheres of a module's links are in solids `(N,)`, all together, metres."""
    base, own = standing(module.type, stance, values)
    depth = np.zeros(len(values))
    for sphere in module_spheres(module.type, PATH_MARGIN):
        if sphere.effector == stance[0]:
            continue
        frame = compose(base, own[sphere.joint + 1])
        centre = frame[:, :3] + rotate(frame[:, 3:], np.array(sphere.centre))
        depth += _within(centre, sphere.radius, solids)
    return depth


def _within(points: Array, radius: float, solids: Solids) -> Array:
    """How deep spheres around points `(N, 3)` are in the solid in which they are deepest, metres; 0 where in none."""
    deepest = np.zeros(len(points))
    for shape, pose in solids:
        half, rounding, turned = half_sizes(shape)
        local = rotate(inverse(pose)[3:], points - pose[:3])
        excess = np.abs(local)
        if turned:
            excess[:, 0] = np.hypot(local[:, 0], local[:, 1])
        excess -= half
        far = np.linalg.norm(np.maximum(excess, 0.0), axis=1) + np.minimum(excess.max(axis=1), 0.0) - rounding
        deepest = np.maximum(deepest, radius - KEYFRAMES.clear_touch - far)
    return deepest
