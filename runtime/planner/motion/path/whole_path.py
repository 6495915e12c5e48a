"""P_path: the whole motion of a skeleton in one program, and P_seqPath with its switches pinned (thesis section
3.2). The general way, for closed chains and `during` rows; open chains go faster phase by phase."""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np

from ....budget import Budget
from ....seeds import Seed
from ....skeleton import Array, BoundResult, Configuration, Skeleton
from ..nlp.augmented_lagrangian import PATH
from ..settings import MotionSettings
from .closed_chains import accepted
from .path_program import RESUME, PathProgram, attempt
from .settings import PATHS


def solve_path(
    skeleton: Skeleton,
    settings: MotionSettings,
    seed: Seed,
    budget: Budget,
    sequence: BoundResult,
    pinned: bool = False,
    effort: int | None = None,
    bears: bool = False,
) -> BoundResult:
    """P_path from the switch configurations of P_seq; with `pinned` they stay as they are (P_seqPath). Phases that
    stall get their joints bumped, at most six times, and no more once `effort` is spent: iterations times unknowns.
    Raises OutOfTime."""
    began = time.monotonic()
    random = seed.child("path").random()
    switches = sequence.configurations
    path = PathProgram(skeleton, settings, switches, pinned, bears=bears)
    slices = path.start(switches, [None] * len(skeleton))
    start = path.pack(slices)
    iterations, most = 0, None if effort is None else max(1, effort // max(1, len(start)))
    best: BoundResult | None = None
    for number in range(PATHS.bumps + 1):
        left = None if most is None else most - iterations
        result, x = attempt(path, path.pack(slices), settings, budget, PATH if number == 0 else RESUME, left)
        iterations += result.iterations
        if result.feasible:
            _check(path, result, settings, budget)
        if best is None or _worst(result) < _worst(best):
            best = result
        if result.feasible or number == PATHS.bumps or (most is not None and iterations >= most):
            break
        slices = _bumped(path, switches, path.unpack(x), {v.phase for v in result.violations}, random)
    assert best is not None
    best.seconds, best.iterations = time.monotonic() - began, iterations
    return best


def _check(path: PathProgram, result: BoundResult, settings: MotionSettings, budget: Budget) -> None:
    """The swept check of every phase, as P_seqPath makes it."""
    for k, phase in enumerate(path.phases):
        ends = result.configurations[k], result.configurations[k + 1]
        result.paths[k], wrong = accepted(path.skeleton, phase, result.paths[k], *ends, settings, budget)
        result.violations += wrong
    result.violations.sort(key=lambda v: -v.amount)
    result.feasible = not result.violations


def _worst(result: BoundResult) -> float:
    return result.violations[0].amount if result.violations else 0.0


def _bumped(
    path: PathProgram,
    switches: Sequence[Configuration],
    slices: list[Configuration],
    stalled: set[int],
    random: np.random.Generator,
) -> list[Configuration]:
    """The slices with the stalled phases interpolated anew, their joints bumped."""
    bumps: list[dict[str, Array] | None] = [None] * len(path.phases)
    for phase in sorted(stalled):
        bump = {n: random.normal(0.0, PATHS.bump, len(c) - 7) for n, c in switches[0].modules.items()}
        bumps[path.phases.index(phase)] = bump
    fresh = path.start(switches, bumps)
    result = list(slices)
    for phase in sorted(stalled):
        k = path.phases.index(phase)
        for t in range(k * path.count + 1, (k + 1) * path.count + 1):
            result[t] = fresh[t]
    return result
