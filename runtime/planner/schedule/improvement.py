"""Behind a verified plan: candidates that promise to be better, by what motions have taken so far."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ....compiler.ir import Problem
from ....compiler.objectives import Objective
from ...plan import Plan
from ...skeleton import Array
from ..search.best_first import Candidate, SkeletonSearch
from .clocked_search import Clocked, ClockedSearch, Pace, Ways
from .objective_value import shares, spans
from .settings import SCHEDULE


class Improvement:
    """Learns from the plans of a problem what actions of each rule are worth at least, and searches with that."""

    def __init__(self, problem: Problem, objective: Objective) -> None:
        self._problem, self._objective = problem, objective
        self._seconds: dict[str, float] = {}
        self._more: dict[str, float] = {}
        self._all: dict[str, list[float]] = {}
        self._ends: dict[int, Mapping[str, Array]] = {
            -1: {name: np.asarray(m.joints, dtype=float) for name, m in problem.world.modules.items()}
        }
        self._met: list[Candidate] = []
        self._straight: dict[str, list[float]] = {}

    def learn(self, candidate: Candidate, sequence: Plan, seconds: Sequence[float]) -> None:
        """From a plan with one action after the other, and the seconds of each action's motion by the fastest law."""
        self._met.append(candidate)
        for rule, own, more in shares(self._problem, self._objective, sequence, seconds):
            self._seconds[rule] = min(own, self._seconds.get(rule, own))
            self._more[rule] = min(more, self._more.get(rule, more))
            self._all.setdefault(rule, []).append(own)
        before = -1
        for number, (phase, span) in zip(candidate.numbers, spans(sequence), strict=True):
            self._ends[number] = {t.name: np.asarray(t.joints[span.stop - 1], dtype=float) for t in sequence.tracks}
            ways = Ways(self._problem, self._ends)
            found = [ways.seconds(name, before, number) or 0.0 for name in self._ends[number]]
            self._straight.setdefault(phase.rule, []).append(max(found, default=0.0))
            before = number

    def nearer(self, search: SkeletonSearch, nodes: int) -> Clocked:
        """The best candidate that promises to be enough better where actions take as long as the ways between the
        postures that they had, and others as long as usual. Raises OutOfTime."""
        weights, rules = dict(self._objective.weights), self._problem.rules
        usual = {rule: sum(found) / len(found) for rule, found in self._all.items()}
        slower = {r: max(1.0, sum(self._all[r]) / sum(s)) for r, s in self._straight.items() if sum(s) > 0.0}
        longest = max((seconds / slower.get(rule, 1.0) for rule, seconds in usual.items()), default=0.0)
        pace = Pace(
            {r: self._seconds.get(r, 0.0) for r in rules}, {r: self._more.get(r, 0.0) for r in rules},
            weights.get("makespan", 0.0), weights.get("actions", 0.0), Ways(self._problem, self._ends),
            {r: usual.get(r, longest) for r in rules}, slower,
        )  # fmt: skip
        clocked = ClockedSearch(search, pace)
        below = (1.0 - SCHEDULE.worthwhile) * min(clocked.valued(c.numbers) for c in self._met)
        return clocked.best(below, nodes)

    def better(self, search: SkeletonSearch, below: float | None, nodes: int) -> Clocked:
        """The best candidate that promises to come `below` a value (None: below those met by enough to be tried), and
        what no candidate falls below by what was learnt, after at most so many nodes. Raises OutOfTime."""
        weights = dict(self._objective.weights)
        rules = self._problem.rules
        least = self._unused()
        pace = Pace(
            {r: self._seconds.get(r, least[0]) for r in rules}, {r: self._more.get(r, least[1]) for r in rules},
            weights.get("makespan", 0.0), weights.get("actions", 0.0),
        )  # fmt: skip
        clocked = ClockedSearch(search, pace)
        if below is None:
            below = (1.0 - SCHEDULE.worthwhile) * min(clocked.valued(c.numbers) for c in self._met)
        return clocked.best(below, nodes)

    def _unused(self) -> tuple[float, float]:
        """What an action is worth at least whose rule no plan used: the least that is known; where seconds count, as
        much less as the shortest way between switches takes straight ahead, since what slowed others down with its
        weight may not be there."""
        seconds, more = min(self._seconds.values(), default=0.0), min(self._more.values(), default=0.0)
        straight = min((s for found in self._straight.values() for s in found if s > 0.0), default=seconds)
        share = min(1.0, straight / seconds) if seconds > 0.0 and self._objective.timed else 1.0
        return share * seconds, share * more
