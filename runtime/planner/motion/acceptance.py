"""The check that accepts the motion of a phase: kept poses and clearances, on its splines, between its slices.

Clearances are exact, at samples that are much denser than the slices; kept poses are measured at the same samples.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence

import numpy as np

from ....compiler.ir import Fact, Problem, Shape
from ....compiler.kept_pairs import kept_pairs
from ....compiler.module_parts import module_parts, own_pairs
from ....compiler.motion.collision import PhaseContacts, pair
from ....compiler.part_names import part_names
from ....langs.frozen import dataclass
from ...geometry.exact_distances import Forms, distances, posed_at
from ...geometry.resampling import Resampled, effector_poses, resample
from ...geometry.transforms import compose, inverse, joint_frames
from ...skeleton import Array, Breach, Configuration, PhasePath, Violation
from .end_conditions import eased_samples
from .phases.contact_margins import REQUIRED, kind_of
from .phases.settings import PHASES
from .settings import ACCEPTANCE

STILL = 1e-9


def dense(problem: Problem, mode: frozenset[Fact], path: PhasePath, start: Configuration) -> Resampled:
    """The motion of a phase as the plan file will hold it, at least `samples` + 1 of them."""
    motion = eased_samples(path)
    looks = max(ACCEPTANCE.samples_per_slice * (path.samples - 1), ACCEPTANCE.samples)
    return resample(problem, mode, motion, start, 0.0, -(-looks // (motion.samples - 1)))


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
    """Joints that turn or slide by more than `PHASES.greatest_step` from one slice to the next."""
    for name, rows in path.modules.items():
        largest = np.abs(np.diff(rows[:, 7:], axis=0)).max(axis=0, initial=0.0)
        for joint, amount in zip(problem.world.modules[name].type.joints, largest, strict=True):
            if amount > PHASES.greatest_step:
                beyond = float(amount - PHASES.greatest_step)
                yield Violation(phase, Breach.STEP, (name, joint.name), beyond, joint.unit)


def past_limits(problem: Problem, phase: int, motion: Resampled) -> Iterator[Violation]:
    """Joints that go farther past their limits than `PHASES.beyond`, between slices too."""
    for name, values in motion.joints.items():
        for k, joint in enumerate(problem.world.modules[name].type.joints):
            amount = float(np.maximum(values[:, k] - joint.upper, joint.lower - values[:, k]).max())
            if amount > PHASES.beyond:
                yield Violation(phase, Breach.JOINT_LIMIT, (name, joint.name), amount, joint.unit)


# --- clearances ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Part:
    """One shape of a module or body: what contacts name it, how it is called, and its poses `(T, 7)`."""

    thing: str
    tag: str
    name: str
    shape: Shape
    poses: Array
    moves: bool


def clashes(
    problem: Problem, phase: int, contact: PhaseContacts, motion: Resampled, start: Configuration
) -> list[Violation]:
    """The pairs that overlap in a phase, the worst sample of each. Things that both rest are not looked at."""
    missed: dict[tuple[str, str], tuple[float, float, tuple[str, str]]] = {}
    parts = [*_module_parts(problem, motion), *_body_parts(problem, motion, start)]
    forms = Forms([part.shape for part in parts])
    centres = [part.poses[:, :3] for part in parts]
    for i, k in _pairs(problem, parts):
        one, other = parts[i], parts[k]
        kind = kind_of(contact, one.tag, other.tag)
        apart = np.linalg.norm(centres[i] - centres[k], axis=1) - forms.reach[i] - forms.reach[k]
        near = np.flatnonzero(apart < REQUIRED[kind])
        if not len(near):
            continue
        posed = (posed_at(forms, n, parts[n].poses[near]) for n in (i, k))
        amount = float((REQUIRED[kind] - distances(next(posed), next(posed), np.zeros(len(near))).value).max())
        if amount > 0.0:
            key = pair(one.tag, other.tag)
            told = amount, float(REQUIRED[kind]), (one.name, other.name)
            missed[key] = max(missed.get(key, told), told)
    found = [
        Violation(
            phase, Breach.SELF_COLLISION if _same(a, b) else Breach.COLLISION, (a, b), amount, "m", None, asked, parts
        )
        for (a, b), (amount, asked, parts) in missed.items()
    ]
    return sorted(found, key=lambda v: (-v.amount, v.kind, v.names))


def _same(one: str, other: str) -> bool:
    """Whether two parts belong to one module."""
    return one.partition(".")[0] == other.partition(".")[0]


def _pairs(problem: Problem, parts: Sequence[_Part]) -> Iterator[tuple[int, int]]:
    """Which parts may not overlap: of different things one of which moves, and those of a module that `own_pairs`
    names."""
    for i, k in itertools.combinations(range(len(parts)), 2):
        if parts[i].thing != parts[k].thing and (parts[i].moves or parts[k].moves):
            yield i, k
    first = {part.thing: k for k, part in reversed(list(enumerate(parts)))}
    for module in problem.world.modules.values():
        for i, k, _ in own_pairs(module.type):
            yield first[module.name] + i, first[module.name] + k


def _module_parts(problem: Problem, motion: Resampled) -> Iterator[_Part]:
    for module in problem.world.modules.values():
        base = np.broadcast_to(motion.poses[module.name], (len(motion.times), 7))
        frames = joint_frames(module.type.joints, base, motion.joints[module.name])
        own = module_parts(module.type)
        tags = [f"{module.name}.{part.effector}" if part.effector else module.name for part in own]
        for part, tag, name in zip(own, tags, part_names(module.name, tags), strict=True):
            yield _part(module.name, tag, name, part.shape, compose(frames[part.joint + 1], np.asarray(part.placement)))


def _body_parts(problem: Problem, motion: Resampled, start: Configuration) -> Iterator[_Part]:
    for body in problem.world.solids:
        poses = motion.bodies.get(body.name)
        rest = np.broadcast_to(start.bodies[body.name], (len(motion.times), 7))
        for part in body.shape.solids:
            placed = compose(rest if poses is None else poses, np.asarray(part.placement))
            yield _part(body.name, body.name, body.name, part.shape, placed)


def _part(thing: str, tag: str, name: str, shape: Shape, poses: Array) -> _Part:
    return _Part(thing, tag, name, shape, poses, bool(np.ptp(poses, axis=0).max() > STILL))
