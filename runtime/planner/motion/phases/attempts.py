"""Attempts at the phases of one structure: straight starts, repair of what was missed, bumped starts, sampled ones."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .....compiler.distinct import distinct
from ....budget import Budget
from ....seeds import Seed
from ....skeleton import Array
from .batch_kinematics import Indices
from .penalty import most_missed
from .phase_batch import Batch
from .rrt_connect import sampled_starts, straighter_starts
from .settings import PHASES
from .smoothing import Schedule, path_cost, smooth_paths
from .swept_check import sweep

WIDER = Schedule(widening=1.6, iterations=15)
NEARER = Schedule(weight=1e5, widening=1.15, iterations=8, tolerance=1e-4)
TO_THE_END = Schedule(weight=1e5, iterations=100, tolerance=1e-5)


@dataclass(slots=True)
class PhaseGroup:
    """A batch with the best path of each phase so far; `detour` tells which phases no straight start solved. Of one
    that was `left` not everything was tried, as another one failed that takes far less."""

    batch: Batch
    paths: Array
    cost: Array
    solved: NDArray[np.bool_]
    clearance: Array
    detour: NDArray[np.bool_]
    left: bool = False

    @property
    def width(self) -> int:
        """How many joints move in each phase."""
        return int(self.paths.shape[2])


def start_group(batch: Batch) -> PhaseGroup:
    """Straight paths, which nobody has checked."""
    paths, count = batch.with_ends(straight(batch)), len(batch)
    unknown = np.full(count, -np.inf)
    return PhaseGroup(batch, paths, path_cost(batch, paths), np.zeros(count, bool), unknown, np.zeros(count, bool))


def straight(batch: Batch) -> Array:
    share = np.arange(1, batch.slices) / batch.slices
    share = (share * share * (3.0 - 2.0 * share))[:, None]
    return batch.start[:, None] * (1.0 - share) + batch.end[:, None] * share


def bumped(batch: Batch, random: np.random.Generator, size: float) -> Array:
    """Straight lines plus half and whole sine waves of random height, within the limits."""
    inner = straight(batch)
    share = (np.arange(1, batch.slices) / batch.slices)[:, None]
    shape = (len(batch), 1, inner.shape[2])
    inner += np.sin(np.pi * share) * random.normal(0.0, size, shape)
    inner += np.sin(2.0 * np.pi * share) * random.normal(0.0, size / 2.0, shape)
    return _within(batch, inner)


def homeward(batch: Batch, far: float) -> Array:
    """Straight lines that are bent towards the joints' home: half-way they are there by the share `far`."""
    wave = np.sin(np.pi * np.arange(1, batch.slices) / batch.slices)[:, None]
    middle = batch.joints.home + (1.0 - far) * (0.5 * (batch.start + batch.end) - batch.joints.home)
    return _within(batch, straight(batch) * (1.0 - wave) + wave * middle[:, None])


def _within(batch: Batch, inner: Array) -> Array:
    low, high = batch.inner_limits()
    return np.clip(inner, low[:, None], high[:, None])


def drawn_in(batch: Batch, paths: Array) -> Array:
    """Paths `(phases, slices + 1, joints)` whose splines pass limits between slices, as joints of small range do that
    are pushed from one end to the other: drawn towards the straight line, joint by joint, as far as it takes."""
    values, joints = batch.stored @ paths, batch.joints
    over = np.maximum(values - joints.upper[:, None], 0.0) + np.minimum(values - joints.lower[:, None], 0.0)
    phase, joint = np.nonzero(np.abs(over).max(axis=1) > PHASES.beyond)
    if not len(phase):
        return paths
    line = batch.with_ends(straight(batch))
    apart = values[phase, :, joint] - (batch.stored @ line)[phase, :, joint]
    off = over[phase, :, joint]
    share = np.divide(off, apart, out=np.zeros_like(off), where=np.abs(apart) > np.abs(off)).max(axis=1)[:, None]
    result = paths.copy()
    result[phase, :, joint] += share * (line - paths)[phase, :, joint]
    return result


def _keep_best(group: PhaseGroup, index: Indices, batch: Batch, paths: Array, budget: Budget) -> None:
    """Take over the cheapest clean path of each phase when it is cheaper than what there is, or while there is none,
    what is least in the way. `index` gives the phase of the group behind each path. Cheap paths are checked first, as
    the swept check is dear, and hopeless ones only where there is nothing else."""
    paths = drawn_in(batch, paths)
    cost, missed = path_cost(batch, paths), most_missed(batch, paths[:, 1:-1])
    hopeless = missed > batch.margin + PHASES.hopeless
    best = {int(p): int(r) for r, p in reversed(list(zip(np.argsort(missed), index[np.argsort(missed)], strict=True)))}
    waiting: dict[int, list[int]] = {}
    for row in np.argsort(cost, kind="stable"):
        phase = int(index[row])
        if hopeless[row] and (group.solved[phase] or best[phase] != row):
            continue
        if not group.solved[phase] or cost[row] < group.cost[phase]:
            waiting.setdefault(phase, []).append(int(row))
    while waiting:
        budget.check()
        rows = [candidates.pop(0) for candidates in waiting.values()]
        checked = sweep(batch.take(np.array(rows)), paths[rows])
        for k, (phase, row) in enumerate(zip(list(waiting), rows, strict=True)):
            if checked.clean[k]:
                group.solved[phase] = True
                waiting[phase] = []
            elif group.solved[phase] or checked.clearance[k] <= group.clearance[phase]:
                continue
            group.paths[phase], group.cost[phase] = paths[row], cost[row]
            group.clearance[phase] = checked.clearance[k]
        waiting = {phase: candidates for phase, candidates in waiting.items() if candidates}


def attempt(group: PhaseGroup, index: Indices, inner: Array, schedule: Schedule, budget: Budget, looks: int = 1) -> int:
    """Smooth starts of the group's phases `index` (repeats allowed), looked at so often per slice, keep what is clean,
    and repair what nearly is."""
    batch = group.batch.take(index)
    if looks > 1:
        batch = batch.looking(looks)
    inner, iterations = smooth_paths(batch, inner, schedule, budget)
    _keep_best(group, index, batch, batch.with_ends(inner), budget)
    group.detour |= ~group.solved
    for looks in PHASES.repair_looks:
        near = distinct(index[~group.solved[index] & (group.clearance[index] > -PHASES.repaired)])
        if len(near):
            iterations += _repair(group, near, looks, budget)
    return iterations


def _repair(group: PhaseGroup, phases: Indices, looks: int, budget: Budget) -> int:
    """Push the best paths of some phases away from what they meet, also between the slices."""
    batch = group.batch.take(phases).looking(looks)
    inner, iterations = smooth_paths(batch, group.paths[phases, 1:-1], WIDER, budget)
    _keep_best(group, phases, batch, batch.with_ends(inner), budget)
    return iterations


def solve_groups(
    groups: Sequence[PhaseGroup], seed: Seed, budget: Budget, thorough: bool, sampled_to: float = math.inf
) -> int:
    """Attempt after attempt, each at all groups, until every phase is solved; returns the iterations of the longest
    phases. Unless `thorough`, phases are left unsolved after QUICK_LEVELS and one look for a way among samples, and
    that is spared those of many more joints than others that failed: it takes long, and the skeleton is refused. None
    is looked for with more joints than `sampled_to`."""
    iterations = 0
    randoms = [seed.child("group", k).random() for k in range(len(groups))]
    for group in groups:
        every = np.arange(len(group.batch))
        iterations += attempt(group, every, straight(group.batch), Schedule(), budget)
    quick, phases = PHASES.quick_levels, sum(len(group.batch) for group in groups)
    tries = min(PHASES.most_tries, 1 + phases // PHASES.phases_per_try)
    for levels, rounds in ((PHASES.levels[:quick], PHASES.quick_rounds), (PHASES.levels[quick:], PHASES.rounds)):
        for level in levels:
            for group, random in zip(groups, randoms, strict=True):
                if not group.solved.all():
                    iterations += _try_bumped(group, *level, random, budget)
        least, narrowest = math.inf, min((group.width for group in groups), default=0)
        for group, random in sorted(zip(groups, randoms, strict=True), key=lambda pair: pair[0].width):
            looks = tries if group.width < PHASES.once_from * narrowest else 1
            group.left = not thorough and not group.solved.all() and group.width >= PHASES.far_wider * least
            for _ in range(0 if group.left or group.width > sampled_to else looks):
                if not group.solved.all():
                    iterations += _try_sampled(group, rounds, random, budget)
            if not group.left:
                least = least if group.solved.all() else min(least, group.width)
        if not thorough:
            break
    return iterations


def _try_bumped(
    group: PhaseGroup, count: int, size: float, far: float, random: np.random.Generator, budget: Budget
) -> int:
    left = np.flatnonzero(~group.solved)
    index = np.repeat(left, count)
    inner = bumped(group.batch.take(index), random, size)
    inner[::count] = homeward(group.batch.take(left), far)
    return attempt(group, index, inner, Schedule(), budget)


def _try_sampled(group: PhaseGroup, rounds: int, random: np.random.Generator, budget: Budget) -> int:
    finer = max(1, group.batch.slices // PHASES.usual_slices)
    cuts = [finer * count for count in PHASES.cuts]
    found = [
        (phase, start)
        for phase in np.flatnonzero(~group.solved)
        for start in sampled_starts(group.batch, int(phase), random, budget, finer * finer * rounds, cuts)
    ]
    if not found:
        return 0
    index, starts = (np.array(column) for column in zip(*found, strict=True))
    return attempt(group, index, starts, Schedule(weight=1e5), budget, PHASES.repair_looks[0])


def _straighten(group: PhaseGroup, seed: Seed, budget: Budget) -> None:
    """Go evenly along paths that wind, and cut their corners: those of solved phases that are far dearer than straight
    ones. Clearances that are asked at slices push these along the way, too, until they crowd before narrow places."""
    batch, random = group.batch, seed.random()
    dear = group.cost > PHASES.winding * path_cost(batch, batch.with_ends(straight(batch)))
    for phase in np.flatnonzero(dear & group.solved):
        line = (batch.stored @ group.paths[phase])[:: PHASES.looks_apart]
        starts = np.array(straighter_starts(batch, int(phase), line, random, budget, (0, *PHASES.cuts)))
        index = np.full(len(starts), phase)
        taken = batch.take(index)
        _keep_best(group, index, taken, taken.with_ends(starts), budget)


def polish_groups(groups: Sequence[PhaseGroup], seed: Seed, budget: Budget) -> int:
    """Optimise the paths that keep clear of something by a detour once more, nearer to what they keep clear of, and
    straighten those that wind; returns the iterations of the longest phases. Others are as cheap as they can be near
    where they are."""
    iterations = 0
    for k, group in enumerate(groups):
        late = np.flatnonzero(group.detour & group.solved)
        if len(late):
            batch = group.batch.take(late).looking(PHASES.repair_looks[0])
            inner, more = smooth_paths(batch, group.paths[late, 1:-1], NEARER, budget)
            _keep_best(group, late, batch, batch.with_ends(inner), budget)
            iterations += more
        _straighten(group, seed.child("straight", k), budget)
    return iterations


def improve(group: PhaseGroup, random: np.random.Generator, starts: int, budget: Budget) -> int:
    """Cheaper paths for solved phases: optimised to the end from where they are, and from `starts` bumped starts."""
    every = np.arange(len(group.batch))
    iterations = attempt(group, every, group.paths[:, 1:-1], TO_THE_END, budget)
    again = np.repeat(every, starts)
    inner = bumped(group.batch.take(again), random, PHASES.levels[0][1])
    return iterations + attempt(group, again, inner, Schedule(), budget)
