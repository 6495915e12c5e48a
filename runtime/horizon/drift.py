"""Whether a phase that was planned for things at rest stays clear of them as they move meanwhile."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...compiler import ir
from ...compiler.hulls import hull
from ...compiler.motion.collision import CHECK_MARGIN, Sphere, module_spheres, pair
from ..motion.movement import carrier
from ..resampling import kept_pairs
from ..skeleton import Array, Configuration, Phase, PhasePath
from ..transforms import compose, inverse, joint_frames, rotate
from .world import carried, spline_values

LOOKS = 25
"""Instants of a phase that are looked at."""


def deepest(
    problem: ir.Problem, before: Configuration, phase: Phase, path: PhasePath, own: Mapping[str, Array],
    everyone: bool = False,
) -> float:  # fmt: skip
    """How deep, in metres, a module whose joints move (or, with `everyone`, any) gets into a body that the phase does
    not keep it to; negative when it stays clear.

    `own` gives the poses `(LOOKS, 7)` of the bodies that move on their own, evenly over the phase; `before` is the true
    configuration in which it starts. Modules are covered by spheres; bodies of other shapes than boxes and round ones
    are left to the check of what was carried out.
    """
    times = np.linspace(0.0, path.duration, LOOKS)
    joints = {name: spline_values(rows[:, 7:], path.duration, times) for name, rows in path.modules.items()}
    poses = carried(problem, phase.mode, joints, before, own, path)
    kept = {pair(*(carrier(problem, name) for name in names)) for names in kept_pairs(problem, phase.mode)}
    worst = -np.inf
    for module in problem.world.modules.values():
        if not len(module.type.joints) or not (everyone or np.ptp(joints[module.name], axis=0).any()):
            continue
        frames = joint_frames(module.type.joints, poses[module.name], joints[module.name])
        spheres = module_spheres(module.type, CHECK_MARGIN)
        centres = np.array([_centres(frames, sphere) for sphere in spheres])
        radii = np.array([sphere.radius for sphere in spheres])[:, None]
        for body in problem.world.bodies.values():
            if pair(module.name, body.name) in kept:
                continue
            rows = np.broadcast_to(poses[body.name], (LOOKS, 7))
            local = rotate(inverse(rows)[None, :, 3:], centres - rows[None, :, :3])
            worst = max(worst, float((radii - signed_distance(body.shape, local)).max()))
    return worst


def _centres(frames: list[Array], sphere: Sphere) -> Array:
    """Centres `(T, 3)` of a sphere of a module, in the world."""
    placed = compose(frames[sphere.joint + 1], np.array([*sphere.centre, 0.0, 0.0, 0.0, 1.0]))
    return placed[:, :3]


def signed_distance(shape: ir.Shape, points: Array) -> Array:
    """Signed distances `(…)` in metres of points `(…, 3)` to a shape, in its own frame; negative inside."""
    if shape.kind == "box":
        beyond = np.abs(points) - 0.5 * np.array(shape.size)
    elif shape.kind == "cylinder":
        radial = np.linalg.norm(points[..., :2], axis=-1) - shape.size[0]
        beyond = np.stack([radial, np.abs(points[..., 2]) - 0.5 * shape.size[1]], axis=-1)
    elif shape.kind in ("sphere", "capsule"):
        half = 0.5 * shape.size[1] if shape.kind == "capsule" else 0.0
        along = np.clip(points[..., 2], -half, half)
        inner = np.stack([points[..., 0], points[..., 1], points[..., 2] - along], axis=-1)
        return np.asarray(np.linalg.norm(inner, axis=-1) - shape.size[0])
    else:
        return hull(shape).distance(points)
    outside = np.linalg.norm(np.maximum(beyond, 0.0), axis=-1)
    return np.asarray(outside + np.minimum(beyond.max(axis=-1), 0.0))
