"""The stage behind a verified plan: a shorter one that the verifier believes, or the plan as it is."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import msgspec

from ....compiler.ir import Action, Problem
from ....compiler.symbolic.successors import Successors
from ....langs.counting import counted
from ...budget import Budget, OutOfTime
from ...plan import Plan
from ...seeds import Seed
from ...skeleton import PhasePath, Skeleton
from ...verify import verify
from ..bounds.length_unit import length_unit
from ..motion.settings import MotionSettings
from .other_ways import OtherWays
from .stage import Scheduler


class AtOnce:
    """Shortens the plans of a problem."""

    def __init__(
        self, problem: Problem, settings: MotionSettings, seed: Seed, budget: Budget, tell: Callable[[str, str], None]
    ) -> None:  # fmt: skip
        ways = OtherWays(problem, settings, seed, budget)
        self._scheduler = Scheduler(problem, settings.margin * length_unit(problem), seed, budget, ways)
        self._budget, self._tell = budget, tell

    def shorter(
        self, skeleton: Skeleton, actions: Sequence[Action], paths: Sequence[PhasePath], plan: Plan,
        successors: Successors | None = None, finish: Callable[[Plan, Sequence[int]], Plan] = lambda plan, _: plan,
    ) -> tuple[Plan, float | None, Sequence[float]]:  # fmt: skip
        """The first shorter plan with these motions that is verified, else the one that stands; the seconds below which
        none of them ends; and those of each action's motion. `finish` gets a plan and the numbers of its phases in the
        order of these actions, before it is verified. A plan is never lost: where time runs out, or no schedule
        can be made, the one that stands is given back."""
        bound: float | None = None
        seconds: Sequence[float] = [path.duration for path in paths]
        try:
            self._tell("schedule", f"letting robots work at once in {counted(len(actions), 'action')}")
            for timed in self._scheduler.plans(skeleton, actions, paths, plan.statistics, successors):
                bound, seconds = timed.bound, timed.seconds
                if timed.makespan >= plan.times[-1]:
                    break
                told = finish(timed.plan, timed.order)
                verdict = verify(told, self._budget.whole)
                if verdict.verified:
                    return msgspec.structs.replace(told, verdict=verdict, timing=plan.timing), bound, seconds
        except (OutOfTime, ValueError):  # no time, an order that the rules refuse, or numbers without a solution
            pass
        return plan, bound, seconds
