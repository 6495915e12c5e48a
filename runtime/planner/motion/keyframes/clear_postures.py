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
from .posture_samples import UP, Aim, Stance, hands, rooms, standing
from .settings import KEYFRAMES

Solids = Sequence[tuple[Shape, Array]]
"""Shapes and their poses `(7,)` in the world."""


def clear_posture(
    module: Module, values: Array, stance: Stance, aim: Aim, held: Array | None, room: float,
    random: np.random.Generator, solids: Solids,
) -> tuple[Array, float]:  # fmt: skip
    """Joint values `(n,)` that bring an effector of a module that stands on another one to its distance from an aim, on
    a side where there is room for it, with as little of the module in `solids` as can be found; and how much that
    still is, with what is missing to the aim, metres. What it holds comes upright to the point of the aim, turned about
    the vertical: `held` is where the effector is `(3,)` from that, in the world, while it is upright."""
    points = _sides(module, aim, random, solids) if held is None else _turned(aim, held, random)
    return _clearest(module, values, stance, aim, points, room, random, solids)


def _sides(module: Module, aim: Aim, random: np.random.Generator, solids: Solids) -> Array:
    """Points `(N, 3)` at the distance of an aim, those first around which there is room for the effector."""
    shape = module.type.effector(aim.effector).shape
    size = bounding_radius(shape) if shape else 0.0
    sides = random.normal(size=(KEYFRAMES.clear_sides, 3))
    sides /= np.linalg.norm(sides, axis=1, keepdims=True)
    points = aim.point + aim.distance * sides
    return np.asarray(points[np.argsort(_within(points, size, solids), kind="stable")[: KEYFRAMES.clear_tries]])


def _turned(aim: Aim, held: Array, random: np.random.Generator) -> Array:
    """Points `(N, 3)` at which what an effector holds is at an aim, in turns about the vertical."""
    turns = random.uniform(0.0, 2.0 * np.pi, KEYFRAMES.clear_tries)
    x, y = held[0] * np.cos(turns) - held[1] * np.sin(turns), held[0] * np.sin(turns) + held[1] * np.cos(turns)
    return np.asarray(aim.point + np.stack([x, y, np.full(len(turns), held[2])], axis=1))


def _clearest(
    module: Module, values: Array, stance: Stance, aim: Aim, points: Array, room: float, random: np.random.Generator,
    solids: Solids,
) -> tuple[Array, float]:  # fmt: skip
    """Of postures from which an effector was led to each of some points `(N, 3)`, as upright as the aim has it, the one
    that came nearest with the least in the way."""
    limits = rooms(module, room)
    anywhere = random.uniform(limits[0], limits[1], (KEYFRAMES.clear_postures, len(values)))
    drawn = np.concatenate([np.clip(values, *limits)[None], anywhere])
    there = _miss(module, stance, aim, drawn, np.zeros(3))
    tilted = np.linalg.norm(there[:, 3:], axis=1)
    nearest = [int((np.linalg.norm(there[:, :3] - point, axis=1) + tilted).argmin()) for point in points]
    found = drawn[nearest]
    for _ in range(KEYFRAMES.clear_steps):
        found = np.clip(found - _steps(module, stance, aim, found, points), *limits)
    miss = np.linalg.norm(_miss(module, stance, aim, found, points), axis=1)
    miss += _in_the_way(module, stance, found, solids)
    best = int(miss.argmin())
    return found[best], float(miss[best])


def _miss(module: Module, stance: Stance, aim: Aim, values: Array, points: Array) -> Array:
    """Where an effector is `(N, 6)` for joint values `(N, n)`, from points `(N, 3)`; and how tilted, in metres."""
    there = hands(module.type, stance, aim.effector, values)
    off = there[:, :3] - points
    if aim.upright is None:
        return np.concatenate([off, np.zeros_like(off)], axis=1)
    return np.concatenate([off, KEYFRAMES.tilted * (rotate(there[:, 3:], aim.upright) - UP)], axis=1)


def _steps(module: Module, stance: Stance, aim: Aim, values: Array, points: Array) -> Array:
    """Damped Gauss-Newton steps `(N, n)` of all postures at once, by differences."""
    count, size = values.shape
    varied = values[:, None] + KEYFRAMES.posture_difference * np.eye(size + 1, size, -1)
    there = _miss(module, stance, aim, varied.reshape(-1, size), np.repeat(points, size + 1, axis=0))
    there = there.reshape(count, size + 1, 6)
    miss, slopes = there[:, 0], (there[:, 1:] - there[:, :1]) / KEYFRAMES.posture_difference
    squares = slopes.transpose(0, 2, 1) @ slopes + KEYFRAMES.posture_damping * np.eye(6)
    return np.asarray((slopes @ np.linalg.solve(squares, miss[:, :, None]))[:, :, 0])


def _in_the_way(module: Module, stance: Stance, values: Array, solids: Solids) -> Array:
    """How deep the spheres of a module's links are in solids `(N,)`, all together, metres."""
    spheres = [s for s in module_spheres(module.type, PATH_MARGIN) if s.effector != stance[0]]
    if not spheres or not solids:
        return np.zeros(len(values))
    base, own = standing(module.type, stance, values)
    frames = compose(base, np.stack(own))[[s.joint + 1 for s in spheres]]
    local = np.array([s.centre for s in spheres])[:, None]
    centres = frames[..., :3] + rotate(frames[..., 3:], np.broadcast_to(local, frames[..., :3].shape))
    radii = np.repeat([s.radius for s in spheres], len(values))
    depths = _within(centres.reshape(-1, 3), radii, solids)
    return np.asarray(depths.reshape(len(spheres), -1).sum(axis=0))


def _within(points: Array, radius: Array | float, solids: Solids) -> Array:
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
