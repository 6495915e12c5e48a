"""Other ways for phases in which something is too heavily loaded between two switches that bear themselves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ....budget import Budget
from ....seeds import Seed
from ....skeleton import LOADS, BoundResult, PhasePath, Skeleton
from ...statics import exceeded_on
from ..path.closed_chains import solve_phase
from ..path.settings import PATHS
from ..settings import MotionSettings
from .attempts import attempt, bumped, homeward, straight
from .bearing import PhaseLoads
from .phase_paths import chained, grouped, motions, stored_paths
from .settings import PHASES
from .smoothing import Schedule


def relieved(
    skeleton: Skeleton, result: BoundResult, refused: BoundResult, settings: MotionSettings, seed: Seed, budget: Budget
) -> BoundResult:
    """`refused` is the feasible `result` as its loads have it. Its phases that are too heavily loaded on the way are
    solved anew: open chains give way to loads, in closed ones rows keep them. Raises OutOfTime."""
    if any(v.kind not in LOADS for v in refused.violations):
        return refused
    overloaded = sorted({v.phase for v in refused.violations})
    chains, paths = _open_chains(skeleton, result, overloaded, settings, seed, budget)
    for phase in overloaded:
        before, after = result.configurations[phase], result.configurations[phase + 1]
        if phase not in paths and phase in chains:
            return refused
        if phase not in paths:
            random = seed.child("relief", phase).random()
            found = solve_phase(skeleton, phase, before, after, settings, random, budget, PATHS.starts, bears=True)
            if found.violations:
                return refused
            paths[phase] = found.path
        if exceeded_on(skeleton, phase, paths[phase], before):
            return refused
    return replace(result, paths=[paths.get(k, path) for k, path in enumerate(result.paths)])


def _open_chains(
    skeleton: Skeleton, result: BoundResult, phases: list[int], settings: MotionSettings, seed: Seed, budget: Budget
) -> tuple[frozenset[int], dict[int, PhasePath]]:
    """Which of the phases are open chains, and the motions of those that bear themselves."""
    trees, states, _, _ = chained(skeleton, result.configurations, settings)
    groups = grouped(skeleton, [trees[k] for k in phases if trees[k].variables], states, settings)
    for group in groups:
        batch = group.batch
        batch.loads = tuple(
            PhaseLoads(skeleton.problem, skeleton.phases[k].mode, trees[k], states[k][0]) for k in batch.phases
        )
        random = seed.child("relief", *batch.phases.tolist()).random()
        every = np.arange(len(batch))
        attempt(group, every, straight(batch), Schedule(), budget)
        for count, size, far in PHASES.levels[: PHASES.quick_levels]:
            left = np.flatnonzero(~group.solved)
            if len(left):
                index = np.repeat(left, count)
                inner = bumped(batch.take(index), random, size)
                inner[::count] = homeward(batch.take(left), far)
                attempt(group, index, inner, Schedule(), budget)
    chains = frozenset(int(k) for group in groups for k in group.batch.phases)
    solved = [int(k) for group in groups for k in group.batch.phases[group.solved]]
    chosen = [trees[k] for k in solved], [states[k] for k in solved]
    made = stored_paths(skeleton, motions(groups), *chosen, settings.slices)
    return chains, dict(zip(solved, made, strict=True))
