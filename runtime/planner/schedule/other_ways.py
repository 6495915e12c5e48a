"""Other motions between the same switches, for the sake of time.

P_seqPath takes the first way that is clear, around what rests while one action follows the other. From another start
there may be a way that takes half as long; and where robots work at once, what it goes around may be elsewhere by then.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np

from ....compiler.ir import Problem
from ...budget import Budget
from ...seeds import Seed
from ...skeleton import Bound, BoundResult, Configuration, PhasePath, Skeleton
from ..bounds.length_unit import LengthUnit
from ..bounds.verdicts import with_motion
from ..motion.phases.attempts import attempt, bumped, straight
from ..motion.phases.phase_paths import chained, grouped, motions, stored_paths
from ..motion.phases.smoothing import Schedule
from ..motion.settings import MotionSettings
from .settings import SCHEDULE


class OtherWays:
    """Looks for other motions in a problem. `settings` are those of its own unit of length."""

    def __init__(self, problem: Problem, settings: MotionSettings, seed: Seed, budget: Budget) -> None:
        self._unit, self._settings, self._seed, self._budget = LengthUnit(problem), settings, seed, budget

    def found(
        self, skeleton: Skeleton, switches: Sequence[Configuration], phases: Collection[int], alone: bool
    ) -> Mapping[int, PhasePath]:
        """Of those phases that are open chains the cheapest ways between the `switches` (the start first) that a few
        starts lead to, clear by the swept check; with `alone` as if nothing else were there that can be moved. Raises
        OutOfTime."""
        own = self._unit.skeleton(skeleton)
        trees, states, _, _ = chained(own, [self._unit.configuration(c) for c in switches], self._settings)
        asked = [t for t in trees if t.phase in phases and t.variables]
        groups = grouped(own, asked, states, self._settings, alone)
        for k, group in enumerate(groups):
            random = self._seed.child("other ways", k).random()
            every = np.arange(len(group.batch))
            bent = np.repeat(every, SCHEDULE.bent)
            starts = [bumped(group.batch.take(bent), random, size) for size in SCHEDULE.bends]
            index = np.concatenate([every, *(bent for _ in starts)])
            attempt(group, index, np.concatenate([straight(group.batch), *starts]), Schedule(), self._budget)
        clear = {int(p) for group in groups for p in group.batch.phases[group.solved]}
        asked = [t for t in asked if t.phase in clear]
        stored = stored_paths(own, motions(groups), asked, [states[t.phase] for t in asked], self._settings.slices)
        result = BoundResult(Bound.SEQ_PATH, True, 0.0, 0.0, 0, [], stored, [])
        made = self._unit.judgement(with_motion(own.problem.world, result, [])).paths or []
        return {t.phase: path for t, path in zip(asked, made, strict=True)}
