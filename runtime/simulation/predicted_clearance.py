"""Whether a phase that was planned for things at rest stays clear of them as they move meanwhile."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ...compiler import ir
from ...compiler.hulls import hull
from ...compiler.kept_pairs import kept_pairs
from ...compiler.module_parts import module_parts
from ...compiler.motion.collision import pair
from ..geometry.attachments import carrier, followers
from ..geometry.exact_distances import Forms, distances, posed_at
from ..geometry.transforms import compose, joint_frames
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
    configuration in which it starts.
    """
    times = np.linspace(0.0, path.duration, SIMULATION.phase_looks)
    joints = sampled(path, times)
    poses = carried(problem, phase.mode, joints, before, own, path)
    kept = {pair(*(carrier(problem, name) for name in names)) for names in kept_pairs(problem, phase.mode)}
    world, held = problem.world, followers(problem, phase.mode)
    movers = {m.name: _parts(m, poses[m.name], joints[m.name]) for m in world.modules.values() if m.type.joints}
    movers |= {name: _solids(world.bodies[name], poses[name]) for name in sorted(held) if world.bodies[name].collides}
    found = {}
    for name, parts in movers.items():
        for body in world.solids:
            if body.name in held or pair(name, body.name) in kept:
                continue
            distance = _nearest(parts, body, poses[body.name], SIMULATION.far)
            if distance < SIMULATION.far:
                found[name, body.name] = distance
    return found


def clearances(world: ir.World, configuration: Configuration, within: float) -> dict[tuple[str, str], float]:
    """The distances in metres of modules from bodies that are nearer than `within`."""
    found = {}
    for module in world.modules.values():
        state = configuration.modules[module.name][None, :]
        parts = _parts(module, state[:, :7], state[:, 7:])
        for body in world.solids:
            distance = _nearest(parts, body, configuration.bodies[body.name][None, :], within)
            if distance < within:
                found[module.name, body.name] = distance
    return found


def _parts(module: ir.Module, poses: Array, joints: Array) -> list[tuple[ir.Shape, Array]]:
    """The shapes of a module, and their poses `(T, 7)` along a motion."""
    frames = joint_frames(module.type.joints, poses, joints)
    return [(p.shape, compose(frames[p.joint + 1], np.asarray(p.placement))) for p in module_parts(module.type)]


def _solids(body: ir.Body, poses: Array) -> list[tuple[ir.Shape, Array]]:
    """The convex parts of a body at `poses`, `(T, 7)` or `(1, 7)`, and theirs."""
    return [(part.shape, compose(poses, np.asarray(part.placement))) for part in body.shape.solids]


def _nearest(parts: Sequence[tuple[ir.Shape, Array]], body: ir.Body, poses: Array, within: float) -> float:
    """The least distance of parts from a body at `poses`, `(T, 7)` or `(1, 7)`; infinite where it is `within` or
    more."""
    return min(_nearest_to(parts, shape, at, within) for shape, at in _solids(body, poses))


def _nearest_to(parts: Sequence[tuple[ir.Shape, Array]], shape: ir.Shape, poses: Array, within: float) -> float:
    forms, least = Forms([shape, *(part for part, _ in parts)]), np.inf
    for number, (_, rows) in enumerate(parts, start=1):
        where = np.broadcast_to(poses, rows.shape)
        apart = np.linalg.norm(rows[:, :3] - where[:, :3], axis=1) - forms.reach[number] - forms.reach[0]
        near = np.flatnonzero(apart < within)
        if len(near):
            first, second = posed_at(forms, number, rows[near]), posed_at(forms, 0, where[near])
            least = min(least, float(distances(first, second, np.full(len(near), within)).value.min()))
    return least if least < within else np.inf


def signed_distance(shape: ir.Shape, points: Array) -> Array:
    """Signed distances `(…)` in metres of points `(…, 3)` to a shape, in its own frame; negative inside."""
    if shape.parts:
        return np.asarray(np.min([signed_distance(p.shape, points - np.array(p.at)) for p in shape.parts], axis=0))
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
