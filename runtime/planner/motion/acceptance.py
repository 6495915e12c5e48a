"""The check that accepts the motion of a phase: kept poses and clearances, on its splines, between its slices.

Clearances are those of spheres that cover the true shapes within CHECK_MARGIN, at samples that are much denser than the
slices; kept poses are measured at the same samples.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ....compiler.hulls import hull
from ....compiler.ir import Fact, Module, Problem, Shape
from ....compiler.motion.collision import (
    CHECK_MARGIN,
    PhaseContacts,
    bounding_radius,
    cover,
    module_spheres,
    pair,
    taper,
)
from ....compiler.motion.pairs import self_pairs
from ...geometry.resampling import Resampled, effector_poses, kept_pairs, resample
from ...geometry.transforms import compose, inverse, joint_frames, rotate
from ...skeleton import Array, Breach, Configuration, PhasePath, Violation
from .phases.contact_margins import CONTACT_TOLERANCE, EXACT_MARGIN
from .phases.phase_batch import GREATEST_STEP

FACTOR = 5
"""Samples per knot of the spline."""
SAMPLES = 200
"""Least samples per phase."""
STILL = 1e-9


_Record = Callable[[str, str, Array, bool], None]


def dense(problem: Problem, mode: frozenset[Fact], path: PhasePath, start: Configuration) -> Resampled:
    """The motion of a phase as the plan file will hold it, at least SAMPLES + 1 samples."""
    knots = max(len(rows) for rows in path.modules.values()) - 1
    return resample(problem, mode, path, start, 0.0, max(FACTOR, -(-SAMPLES // knots)))


def slip(problem: Problem, mode: frozenset[Fact], motion: Resampled, start: Configuration) -> float:
    """How far a kept pose drifts from where it is at the start: metres, or radians when that is more."""
    worst = 0.0
    for first, second in kept_pairs(problem, mode):
        relative = compose(inverse(_poses(problem, first, motion, start)), _poses(problem, second, motion, start))
        away = compose(inverse(relative[:1]), relative)
        turn = 2.0 * np.linalg.norm(away[:, 3:6], axis=1)
        worst = max(worst, float(np.linalg.norm(away[:, :3], axis=1).max()), float(turn.max()))
    return worst


def _poses(problem: Problem, name: str, motion: Resampled, start: Configuration) -> Array:
    found = problem.world.effector(name)
    if found:
        module, effector = found
        return compose(motion.poses[module.name], effector_poses(module, effector.name, motion.joints[module.name]))
    if name in motion.poses:
        return motion.poses[name]
    return motion.bodies[name] if name in motion.bodies else start.bodies[name][None, :]


def steps(problem: Problem, phase: int, path: PhasePath) -> Iterator[Violation]:
    """Joints that turn or slide by more than GREATEST_STEP from one slice to the next."""
    for name, rows in path.modules.items():
        largest = np.abs(np.diff(rows[:, 7:], axis=0)).max(axis=0, initial=0.0)
        for joint, amount in zip(problem.world.modules[name].type.joints, largest, strict=True):
            if amount > GREATEST_STEP:
                unit = "rad" if joint.kind == "revolute" else "m"
                yield Violation(phase, Breach.STEP, (name, joint.name), float(amount - GREATEST_STEP), unit)


# --- clearances ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Part:
    """One shape of a module or body: what contacts name it, its poses `(T, 7)`, and the spheres that cover it: centres
    `(T, N, 3)`, radii `(N,)`; none when it rests."""

    thing: str
    tag: str
    shape: Shape
    poses: Array
    moves: bool
    centres: Array
    radii: Array

    @property
    def reach(self) -> float:
        return bounding_radius(self.shape)

    @property
    def exact(self) -> bool:
        return self.shape.kind == "sphere"


def clashes(
    problem: Problem, phase: int, contact: PhaseContacts, motion: Resampled, start: Configuration, slices: int
) -> list[Violation]:
    """The pairs that come too near in a phase, the worst sample of each; `slices` is how many of them its contacts are
    counted in. Things that both rest are not looked at."""
    times = (motion.times - motion.times[0]) / max(motion.times[-1] - motion.times[0], 1e-9) * slices
    missed: dict[tuple[str, str], float] = {}

    def record(first: str, second: str, clearance: Array, exact: bool) -> None:
        """Keep what `clearance` `(T, N)` misses."""
        share = taper(contact, pair(first, second), times, slices)
        if share is None:
            return
        margin = EXACT_MARGIN if exact else CHECK_MARGIN
        wanted = np.where(share < 1.0, margin * share - CONTACT_TOLERANCE, margin)
        amount = float((wanted[:, None] - clearance).max(initial=0.0))
        if amount > 0.0:
            key = pair(first, second)
            missed[key] = max(missed.get(key, 0.0), amount)

    parts = [*_module_parts(problem, motion), *_body_parts(problem, motion, start)]
    for one, other in itertools.combinations(parts, 2):
        if one.thing != other.thing and (one.moves or other.moves):
            apart = np.linalg.norm(one.poses[:, :3] - other.poses[:, :3], axis=1)
            if apart.min() <= one.reach + other.reach + CHECK_MARGIN:
                balls, solid = sorted((one, other), key=lambda p: (not p.moves, len(p.radii)))
                clearance = _distance(balls.centres, solid.shape, solid.poses) - balls.radii
                record(one.tag, other.tag, clearance, balls.exact)
    for module in problem.world.modules.values():
        if module.type.joints:
            _within(module, motion, record)
    found = [
        Violation(phase, Breach.SELF_COLLISION if _same(a, b) else Breach.COLLISION, (a, b), amount, "m")
        for (a, b), amount in missed.items()
    ]
    return sorted(found, key=lambda v: (-v.amount, v.kind, v.names))


def _same(one: str, other: str) -> bool:
    """Whether two parts belong to one module."""
    return one.partition(".")[0] == other.partition(".")[0]


def _within(module: Module, motion: Resampled, record: _Record) -> None:
    """The spheres of one module that can meet."""
    frames = _joint_poses(module, motion)
    spheres = module_spheres(module.type, CHECK_MARGIN)
    centres = [_points(frames[s.joint], np.array([s.centre]))[:, 0] for s in spheres]
    tags = [f"{module.name}.{s.effector}" if s.effector else module.name for s in spheres]
    for i, k in self_pairs(module.type, CHECK_MARGIN):
        apart = np.linalg.norm(centres[i] - centres[k], axis=1) - spheres[i].radius - spheres[k].radius
        record(tags[i], tags[k], apart[:, None], spheres[i].exact and spheres[k].exact)


def _joint_poses(module: Module, motion: Resampled) -> dict[int, Array]:
    """Poses `(T, 7)` of a module's joint frames, -1 the module frame."""
    base = np.broadcast_to(motion.poses[module.name], (len(motion.times), 7))
    frames = joint_frames(module.type.joints, base, motion.joints[module.name])
    return dict(enumerate(frames, start=-1))


def _module_parts(problem: Problem, motion: Resampled) -> Iterator[_Part]:
    for module in problem.world.modules.values():
        frames = _joint_poses(module, motion)
        ends: dict[int, list[_Part]] = {}
        for end in module.type.effectors:
            if end.shape is not None:
                poses = compose(frames[end.joint], np.asarray(end.placement))
                ends.setdefault(end.joint, []).append(_part(module.name, f"{module.name}.{end.name}", end.shape, poses))
        for parts in ends.values():
            yield from parts
        for link in module.type.links:
            part = _part(module.name, module.name, link.shape, compose(frames[link.joint], np.asarray(link.placement)))
            yield _outside(part, ends.get(link.joint, []))


def _outside(link: _Part, ends: Sequence[_Part]) -> _Part:
    """A link without the spheres that lie inside an effector rigid with it: what touches them touches the effector."""
    bare = np.ones(len(link.radii), bool)
    for end in ends:
        bare &= _distance(link.centres[:1], end.shape, end.poses[:1])[0] > STILL - link.radii
    return replace(link, centres=link.centres[:, bare], radii=link.radii[bare])


def _body_parts(problem: Problem, motion: Resampled, start: Configuration) -> Iterator[_Part]:
    for body in problem.world.bodies.values():
        poses = motion.bodies.get(body.name)
        rest = np.broadcast_to(start.bodies[body.name], (len(motion.times), 7))
        yield _part(body.name, body.name, body.shape, rest if poses is None else poses)


def _part(thing: str, tag: str, shape: Shape, poses: Array) -> _Part:
    moves = bool(np.ptp(poses, axis=0).max() > STILL)
    spheres = cover(shape, CHECK_MARGIN) if moves else ()
    centres = _points(poses, np.array([c for c, _ in spheres]).reshape(-1, 3))
    return _Part(thing, tag, shape, poses, moves, centres, np.array([r for _, r in spheres]))


def _points(poses: Array, points: Array) -> Array:
    """Points `(N, 3)` fixed to frames `(T, 7)`, in the world `(T, N, 3)`."""
    times, count = len(poses), len(points)
    turned = rotate(np.repeat(poses[:, 3:], count, axis=0), np.tile(points, (times, 1))).reshape(times, count, 3)
    return np.asarray(turned + poses[:, None, :3])


def _distance(points: Array, shape: Shape, poses: Array) -> Array:
    """Signed distances `(T, N)` of points `(T, N, 3)` to the surface of a shape at poses `(T, 7)`."""
    back, count = inverse(poses), points.shape[1]
    turned = rotate(np.repeat(back[:, 3:], count, axis=0), points.reshape(-1, 3)).reshape(points.shape)
    local = turned + back[:, None, :3]
    size = shape.size
    if shape.kind == "sphere":
        return np.asarray(np.linalg.norm(local, axis=2) - size[0])
    if shape.kind == "capsule":
        along = np.clip(local[:, :, 2], -size[1] / 2, size[1] / 2)
        local = np.concatenate([local[:, :, :2], (local[:, :, 2] - along)[:, :, None]], axis=2)
        return np.asarray(np.linalg.norm(local, axis=2) - size[0])
    if shape.kind == "convex":
        return hull(shape).distance(local)
    if shape.kind == "box":
        excess = np.abs(local) - np.array(size) / 2
    else:
        around = np.hypot(local[:, :, 0], local[:, :, 1]) - size[0]
        excess = np.stack([around, np.abs(local[:, :, 2]) - size[1] / 2], axis=2)
    outside = np.linalg.norm(np.maximum(excess, 0.0), axis=2)
    return np.asarray(outside + np.minimum(excess.max(axis=2), 0.0))
