"""Other ways for phases in which something is too heavily loaded between two switches that bear themselves."""

from __future__ import annotations

from dataclasses import replace

from ....budget import Budget
from ....seeds import Seed
from ....skeleton import LOADS, BoundResult, Skeleton
from ...statics import exceeded_on
from ..settings import MotionSettings
from .closed_chains import solve_phase
from .settings import PATHS


def relieved(
    skeleton: Skeleton, result: BoundResult, refused: BoundResult, settings: MotionSettings, seed: Seed, budget: Budget
) -> BoundResult:
    """`refused` is the feasible `result` as its loads have it. Its phases that are too heavily loaded on the way are
    solved anew with rows for their loads; closed loops, which have none, are bumped only. Raises OutOfTime."""
    if any(v.kind not in LOADS for v in refused.violations):
        return refused
    paths = list(result.paths)
    for phase in sorted({v.phase for v in refused.violations}):
        before, after = result.configurations[phase], result.configurations[phase + 1]
        random = seed.child("relief", phase).random()
        found = solve_phase(skeleton, phase, before, after, settings, random, budget, PATHS.starts, bears=True)
        violations = found.violations or exceeded_on(skeleton, phase, found.path, before)
        if violations:
            return refused
        paths[phase] = found.path
    return replace(result, paths=paths)
