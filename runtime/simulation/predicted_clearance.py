"""Whether a phase that was planned for things at rest stays clear of them as they move meanwhile."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...compiler import ir
from ...compiler.hulls import hull
from ...compiler.motion.collision import CHECK_MARGIN, body_spheres, bounding_radius, module_spheres, pair
from ..geometry.attachments import carrier, followers
from ..geometry.resampling import kept_pairs
from ..geometry.transforms import inverse, joint_frames, rotate
from ..skeleton import Array, Configuration, Phase, PhasePath
from .settings import SIMULATION
from .world import carried, moves, sampled


def deepest(
    problem: ir.Problem, before: Configuration, phase: Phase, path: PhasePath, own: Mapping[str, Array],
    everyone: bool = False,
) -> float:  # fmt: skip
    """How deep, in metres, a module whose joints move (or, with `everyone`, any), or a body that is held, gets into a
    body that the phase does not keep it to; negative when it stays clear. Arguments are those of `nearest`."""
    found = nearest(problem, before, phase, path, own)
    resting = {m for m, rows in path.modules.items() if not everyone and not moves(rows)}
    return -min((distance for (name, _), distance in found.items() if name not in resting), default=np.inf)


def nearest(
    problem: ir.Problem, before: Configuration, phase: Phase, path: PhasePath, own: Mapping[str, Array]
) -> dict[tuple[str, str], float]:
    """The least distance, in metres, of every module with joints, and of every body that is held, from every body that
    is not, that the phase does not keep it to, and that is not far.

    `own` gives the poses `(LOOKS, 7)` of the bodies that move on their own, evenly over the phase; `before` is the true
    configuration in which it starts. What moves is covered by spheres.
    """
    times = np.linspace(0.0, path.duration, SIMULATION.phase_looks)
    joints = sampled(path, times)
    poses = carried(problem, phase.mode, joints, before, own, path)
    kept = {pair(*(carrier(problem, name) for name in names)) for names in kept_pairs(problem, phase.mode)}
    world, held = problem.world, followers(problem, phase.mode)
    covers = {m.name: _cover(m, poses[m.name], joints[m.name]) for m in world.modules.values() if m.type.joints}
    covers |= {name: _body_cover(world.bodies[name], poses[name]) for name in sorted(held)}
    found = {}
    for name, cover in covers.items():
        for body in world.solids if len(cover[0]) else ():
            if body.name in held or pair(name, body.name) in kept:
                continue
            apart = np.linalg.norm(cover[0] - poses[body.name][None, :, :3], axis=2) - cover[1]
            if apart.min() < bounding_radius(body.shape) + SIMULATION.far:
                found[name, body.name] = float(_distances(cover, body, poses[body.name]).min())
    return found


def clearances(world: ir.World, configuration: Configuration, within: float) -> dict[tuple[str, str], float]:
    """The distances in metres of modules, covered by spheres, from bodies that are nearer than `within`."""
    found = {}
    for module in world.modules.values():
        state = configuration.modules[module.name][None, :]
        cover = _cover(module, state[:, :7], state[:, 7:])
        for body in world.solids:
            rows = configuration.bodies[body.name][None, :]
            apart = np.linalg.norm(cover[0][:, 0] - rows[:, :3], axis=1) - cover[1][:, 0]
            if apart.min(initial=np.inf) < bounding_radius(body.shape) + within:
                distance = float(_distances(cover, body, rows).min())
                if distance < within:
                    found[module.name, body.name] = distance
    return found


def _cover(module: ir.Module, poses: Array, joints: Array) -> tuple[Array, Array]:
    """Centres `(n, T, 3)` in the world, and radii `(n, 1)`, of the spheres of a module along a motion."""
    frames = joint_frames(module.type.joints, poses, joints)
    spheres = module_spheres(module.type, CHECK_MARGIN)
    centres = np.zeros((len(spheres), len(poses), 3))
    for joint in {s.joint for s in spheres}:
        mine = [k for k, s in enumerate(spheres) if s.joint == joint]
        frame = frames[joint + 1]
        centres[mine] = frame[:, :3] + rotate(frame[None, :, 3:], np.array([spheres[k].centre for k in mine])[:, None])
    return centres, np.array([sphere.radius for sphere in spheres])[:, None]


def _body_cover(body: ir.Body, poses: Array) -> tuple[Array, Array]:
    """The same for a body at poses `(T, 7)`."""
    spheres = body_spheres(body, CHECK_MARGIN)
    local = np.array([sphere.centre for sphere in spheres])[:, None]
    centres = poses[None, :, :3] + rotate(poses[None, :, 3:], local)
    return centres, np.array([sphere.radius for sphere in spheres])[:, None]


def _distances(cover: tuple[Array, Array], body: ir.Body, poses: Array) -> Array:
    """The distances `(n, T)` of the spheres of a cover from a body at `poses`, `(T, 7)` or `(1, 7)`."""
    centres, radii = cover
    rows = np.broadcast_to(poses, (centres.shape[1], 7))
    local = rotate(inverse(rows)[None, :, 3:], centres - rows[None, :, :3])
    return np.asarray(signed_distance(body.shape, local) - radii)


def signed_distance(shape: ir.Shape, points: Array) -> Array:
    """Signed distances `(…)` in metres of points `(…, 3)` to a shape, in its own frame; negative inside."""
    if shape.kind == ir.ShapeKind.BOX:
        beyond = np.abs(points) - 0.5 * np.array(shape.size)
    elif shape.kind == ir.ShapeKind.CYLINDER:
        radial = np.linalg.norm(points[..., :2], axis=-1) - shape.size[0]
        beyond = np.stack([radial, np.abs(points[..., 2]) - 0.5 * shape.size[1]], axis=-1)
    elif shape.kind in (ir.ShapeKind.SPHERE, ir.ShapeKind.CAPSULE):
        half = 0.5 * shape.size[1] if shape.kind == ir.ShapeKind.CAPSULE else 0.0
        along = np.clip(points[..., 2], -half, half)
        inner = np.stack([points[..., 0], points[..., 1], points[..., 2] - along], axis=-1)
        return np.asarray(np.linalg.norm(inner, axis=-1) - shape.size[0])
    else:
        return hull(shape).distance(points)
    outside = np.linalg.norm(np.maximum(beyond, 0.0), axis=-1)
    return np.asarray(outside + np.minimum(beyond.max(axis=-1), 0.0))
