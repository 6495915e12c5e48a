"""The motion of one phase that is no set of open chains: closed chains, and `during` rows.

The phase is solved on its own between its two switches, as a motion program over the poses of all modules. Closure
holds at its slices; so that it also holds on the spline between them, the path is sampled more densely and projected
onto closure anew, until no kept pose drifts by more than `PATHS.slip`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from .....compiler.motion.collision import contacts
from ....budget import Budget
from ....geometry.splines import spline_weights
from ....skeleton import Array, Breach, Configuration, PhasePath, Skeleton, Violation, may_differ
from ..acceptance import clashes, dense, past_limits, slip, steps
from ..nlp.augmented_lagrangian import PATH, project
from ..settings import MotionSettings
from ..time_scaling import shortest_duration
from .path_program import PathProgram, attempt, displaced
from .projected_trees import sampled_way
from .settings import PATHS

CLOSURE = 1e-8
ACCURATE = 1e-4
"""Accuracy with which starts are put onto closure."""


@dataclass(slots=True)
class PhaseResult:
    """The motion of a phase, what is wrong with it (nothing: it is accepted), its cost and the iterations it took."""

    path: PhasePath
    violations: list[Violation]
    cost: float
    iterations: int


def solve_phase(
    skeleton: Skeleton, phase: int, before: Configuration, after: Configuration, settings: MotionSettings,
    random: np.random.Generator, budget: Budget, starts: int = PATHS.starts, bears: bool = False,
) -> PhaseResult:  # fmt: skip
    """The motion of one phase between two switches, from a straight start, then from bumped ones; with `bears` within
    all strengths at rest. Raises OutOfTime."""
    if not displaced(before, after):
        still = _still(skeleton, before, settings)
        path, violations = accepted(skeleton, phase, still, before, after, settings, budget)
        return PhaseResult(path, violations, 0.0, 0)
    best: PhaseResult | None = None
    iterations = 0
    if starts > 1:
        best = _unobstructed(skeleton, phase, before, after, settings, budget)
        if best.violations:
            return best
        iterations, best = best.iterations, None
    for number in range(starts):
        guess, used = _start(skeleton, phase, before, after, settings, number, random, budget)
        program = PathProgram(skeleton, used, [before, after], True, range(phase, phase + 1), bears)
        x = project(program.program(), program.pack(guess), ACCURATE, budget, PATHS.projections)
        bound, x = attempt(program, x, used, budget, PATH)
        iterations += bound.iterations
        path, violations = program.paths(program.unpack(x))[0], bound.violations
        if bound.feasible:
            path, violations = accepted(skeleton, phase, path, before, after, settings, budget)
        result = PhaseResult(path, violations, bound.cost, iterations)
        if best is None or _worst(result) < _worst(best):
            best = result
        if not violations:
            break
    assert best is not None
    best.iterations = iterations
    return best


def _start(
    skeleton: Skeleton, phase: int, before: Configuration, after: Configuration, settings: MotionSettings, number: int,
    random: np.random.Generator, budget: Budget,
) -> tuple[list[Configuration], MotionSettings]:  # fmt: skip
    """All slices of the start of one attempt, and the settings with which it goes on: a straight one, the same with a
    wider margin, then sampled ones in twice as many slices, as they turn around corners, or bumped ones where there
    are none."""
    if number < 2:
        wider = replace(settings, margin=settings.margin * PATHS.widening) if number else settings
        return _between(before, after, settings.slices, {}), wider
    finer = replace(settings, slices=2 * settings.slices, margin=settings.margin * PATHS.widening)
    way = sampled_way(skeleton, phase, before, after, finer, random, budget)
    if way:
        return way, finer
    bump = {n: random.normal(0.0, PATHS.bump, len(c) - 7) for n, c in before.modules.items()}
    return _between(before, after, settings.slices, bump), settings


def _still(skeleton: Skeleton, state: Configuration, settings: MotionSettings) -> PhasePath:
    """The motion of a phase in which nothing moves."""
    modules = {name: np.tile(slot, (settings.slices + 1, 1)) for name, slot in state.modules.items()}
    return PhasePath(modules, {}, shortest_duration(skeleton.problem.world, modules))


def _unobstructed(
    skeleton: Skeleton, phase: int, before: Configuration, after: Configuration, settings: MotionSettings,
    budget: Budget,
) -> PhaseResult:  # fmt: skip
    """The phase without collisions, which takes a quarter of the time: rings whose joints cannot get from one posture
    to the other are found here."""
    free = replace(settings, collisions=False)
    program = PathProgram(skeleton, free, [before, after], True, range(phase, phase + 1))
    x = program.pack(_between(before, after, free.slices, {}))
    x = project(program.program(), x, ACCURATE, budget, PATHS.projections)
    bound, x = attempt(program, x, free, budget, PATH)
    path, violations = program.paths(program.unpack(x))[0], bound.violations
    if bound.feasible:
        path, violations = accepted(skeleton, phase, path, before, after, free, budget)
    return PhaseResult(path, violations, bound.cost, bound.iterations)


def _between(
    before: Configuration, after: Configuration, slices: int, bump: Mapping[str, Array]
) -> list[Configuration]:
    """All slices along a smooth step of every pose and joint, plus `bump` times a half sine on the joints."""
    result = []
    for t in range(slices + 1):
        share = t / slices
        weight = share * share * (3.0 - 2.0 * share)
        modules = {}
        for name, slot in before.modules.items():
            modules[name] = _mixed(slot, after.modules[name], weight)
            if name in bump and np.abs(slot - after.modules[name]).max() > 0.0:
                modules[name][7:] += np.sin(np.pi * share) * bump[name]
        moved = may_differ(before, after)
        bodies = {name: _mixed(before.bodies[name], after.bodies[name], weight) for name in moved}
        result.append(before.then(modules, bodies))
    return result


def _mixed(first: Array, second: Array, weight: float) -> Array:
    """Between two slots; quaternions go the shorter way."""
    other = second.copy()
    if first[3:7] @ second[3:7] < 0.0:
        other[3:7] *= -1.0
    mixed = first + weight * (other - first)
    mixed[3:7] /= np.linalg.norm(mixed[3:7])
    return np.asarray(mixed)


def _worst(result: PhaseResult) -> float:
    return result.violations[0].amount if result.violations else 0.0


def accepted(
    skeleton: Skeleton, phase: int, path: PhasePath, before: Configuration, after: Configuration,
    settings: MotionSettings, budget: Budget,
) -> tuple[PhasePath, list[Violation]]:  # fmt: skip
    """The path, as dense as its closure asks for, and what the swept check finds wrong with it."""
    problem, mode = skeleton.problem, skeleton.phases[phase].mode
    finer, drift = path, np.inf
    for factor in PATHS.slice_factors:
        if factor > 1:
            finer = _denser(skeleton, phase, path, before, after, settings, factor, budget)
        motion = dense(problem, mode, finer, before)
        coarser, drift = drift, slip(problem, mode, motion, before)
        found = [*steps(problem, phase, finer), *past_limits(problem, phase, motion)]
        if (drift <= PATHS.slip and not found) or drift > max(PATHS.slip, PATHS.least_shrinking * coarser):
            break
    if drift > PATHS.slip:
        found.append(Violation(phase, Breach.DRIFT, (), drift, "m"))
    elif settings.collisions:
        found += clashes(problem, phase, contacts(skeleton)[phase], motion, before)
    return finer, sorted(found, key=lambda v: -v.amount)


def _denser(
    skeleton: Skeleton, phase: int, path: PhasePath, before: Configuration, after: Configuration,
    settings: MotionSettings, factor: int, budget: Budget,
) -> PhasePath:  # fmt: skip
    """The path with `factor` times as many slices, each projected onto the rows of its phase."""
    fine = replace(settings, slices=settings.slices * factor, collisions=False)
    program = PathProgram(skeleton, fine, [before, after], True, range(phase, phase + 1))
    tracks = {name: _spline(rows, factor) for name, rows in (path.modules | path.bodies).items()}
    slices = [before]
    for t in range(1, fine.slices):
        modules = {name: tracks[name][t] for name in path.modules}
        slices.append(before.then(modules, {name: tracks[name][t] for name in path.bodies}))
    slices.append(after)
    x = project(program.program(), program.pack(slices), CLOSURE, budget)
    return program.paths(program.unpack(x))[0]


def _spline(rows: Array, factor: int) -> Array:
    count = len(rows) - 1
    times = np.arange(count * factor + 1) / factor
    return spline_weights(count, times) @ rows
