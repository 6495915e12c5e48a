"""From a verified plan in sequence to one whose robots work at once: profiles, schedule, plan."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from ....compiler.ir import Action, Problem
from ....compiler.symbolic.successors import Successors
from ....langs.frozen import dataclass
from ...budget import Budget
from ...plan import Plan, StatisticsRecord
from ...seeds import Seed
from ...skeleton import Configuration, PhasePath, Skeleton, start_configuration
from ..search.skeleton_replay import build_skeleton
from ..search.stepper import Inapplicable, Stepper, replayed
from ..statics import slowed
from .clearance import SegmentClearances
from .dependencies import Precedence, precedence
from .list_schedule import Timetable, scheduled, tails
from .profiles import path_as_is, retimed
from .scheduled_plan import plan_order, scheduled_plan
from .settings import SCHEDULE


@dataclass(frozen=True, slots=True)
class Timed:
    """A plan in seconds: the plan, seconds until its last action, that none with these motions is shorter than `bound`
    seconds, and whether its robots work at once; `seconds` of each action's motion, in the order of the search, and
    the numbers that its phases have in that `order`."""

    plan: Plan
    makespan: float
    bound: float
    at_once: bool
    seconds: tuple[float, ...]
    order: tuple[int, ...]


class Scheduler:
    """Makes plans of a problem shorter. `margin`, metres, is what two robots keep that move at once."""

    def __init__(self, problem: Problem, margin: float, seed: Seed, budget: Budget) -> None:
        self._problem, self._margin, self._seed, self._budget = problem, margin, seed, budget
        self._told: dict[tuple[int, ...], set[tuple[int, int]]] = {}

    def plans(
        self, skeleton: Skeleton, actions: Sequence[Action], paths: Sequence[PhasePath], statistics: StatisticsRecord,
        successors: Successors | None = None,
    ) -> Iterator[Timed]:  # fmt: skip
        """Plans with these motions, for the verifier to choose the first that it believes: the shortest that was found,
        and that with one phase after the other. Raises OutOfTime."""
        if not paths:
            return
        tick = self._tick(paths)
        faster = self._profiles(skeleton, paths, tick)
        order = precedence(skeleton, faster, tick)
        sequence = _in_sequence(order)
        bound = _bound(order) * tick
        seconds = tuple(0.0 if s is None else s.ticks * tick for s in order.segments)
        found = self._best(skeleton, actions, order, faster)
        if found is not None and found[0].end < sequence.end:
            line = plan_order(found[0])
            done = [actions[k] for k in line]
            same = line == sorted(line)
            other = skeleton if same else build_skeleton(self._problem, done, successors, possible=True)
            plan = scheduled_plan(self._problem, done, other, found[1], found[0], tick, statistics)
            yield Timed(plan, found[0].end * tick, bound, True, seconds, tuple(line))
        plan = scheduled_plan(self._problem, actions, skeleton, order, sequence, tick, statistics)
        yield Timed(plan, sequence.end * tick, bound, False, seconds, tuple(range(len(actions))))

    def placed(
        self, skeleton: Skeleton, actions: Sequence[Action], paths: Sequence[PhasePath], begun: Sequence[int],
        earliest: int,
    ) -> tuple[Timetable, Precedence] | None:  # fmt: skip
        """A schedule of motions of which the first ones have `begun` at these ticks, with knots at ticks, while the
        others begin behind the tick `earliest`; None where none was found. Raises OutOfTime."""
        tick, count = SCHEDULE.tick, len(begun)
        faster = [*paths[:count], *self._profiles(skeleton, paths, tick)[count:]]
        order = precedence(skeleton, faster, tick)
        if any(order.segments[k] is None for k in range(count)):
            return None
        return self._best(skeleton, actions, order, faster, begun, earliest)

    def _tick(self, paths: Sequence[PhasePath]) -> float:
        total = sum(path.duration for path in paths)
        return SCHEDULE.tick * max(1, math.ceil(total / (SCHEDULE.tick * SCHEDULE.most_ticks)))

    def _profiles(self, skeleton: Skeleton, paths: Sequence[PhasePath], tick: float) -> list[PhasePath]:
        """Every phase by its fastest law, as slow as its drives need."""
        faster = []
        for path in paths:
            self._budget.check()
            faster.append(retimed(self._problem.world, path, tick))
        slower, heavy = slowed(skeleton, faster, start_configuration(self._problem))
        if heavy:
            return [path_as_is(path, tick) for path in paths]
        return [self._borne(*laws, tick) for laws in zip(paths, faster, slower, strict=True)]

    def _borne(self, path: PhasePath, faster: PhasePath, slower: PhasePath, tick: float) -> PhasePath:
        """The fastest law where it need not be slower, else the better one of that and the law that the path has."""
        if slower.duration <= faster.duration:
            return faster
        return path_as_is(min(replace(faster, duration=slower.duration), path, key=lambda p: p.duration), tick)

    def _best(
        self, skeleton: Skeleton, actions: Sequence[Action], order: Precedence, paths: Sequence[PhasePath],
        begun: Sequence[int] = (), earliest: int = 0,
    ) -> tuple[Timetable, Precedence] | None:  # fmt: skip
        """The shortest of some schedules, whose actions can be done in its order, with what comes before what."""
        self._told.clear()
        clearances = SegmentClearances(skeleton, order, configurations(skeleton, paths), self._margin)
        random = self._seed.child("schedule").random()
        tail = np.array(tails(order), dtype=float)
        best: tuple[Timetable, Precedence] | None = None
        for attempt in range(SCHEDULE.orders):
            self._budget.check()
            noise = 1.0 if not attempt else random.uniform(0.6, 1.4, len(tail))
            found = self._applicable(actions, order, clearances, (tail * noise).tolist(), begun, earliest)
            if found is not None and (best is None or found[0].end < best[0].end):
                best = found
            if best is not None and best[0].end <= (1.0 + SCHEDULE.tight) * _bound(best[1], begun, earliest):
                break
        return best

    def _applicable(
        self, actions: Sequence[Action], order: Precedence, clearances: SegmentClearances, priority: Sequence[float],
        begun: Sequence[int], earliest: int,
    ) -> tuple[Timetable, Precedence] | None:  # fmt: skip
        """A schedule whose actions can be done in the order of its switches and reach the goal, or come to the same
        facts: where they do not, the actions that were exchanged keep their order."""
        while True:
            found = scheduled(order, clearances, priority, begun, earliest)
            if found is None:
                return None
            told = self._wrong(actions, plan_order(found))
            if not told:
                return found, order
            ordered = tuple(before | {a for a, b in told if b == k} for k, before in enumerate(order.ordered))
            order = replace(order, ordered=ordered)

    def _wrong(self, actions: Sequence[Action], line: Sequence[int]) -> set[tuple[int, int]]:
        """Pairs of actions that must not be exchanged, as an order of them shows; none where it works."""
        if tuple(line) not in self._told:
            self._told[tuple(line)] = self._exchanged_wrongly(actions, line)
        return self._told[tuple(line)]

    def _exchanged_wrongly(self, actions: Sequence[Action], line: Sequence[int]) -> set[tuple[int, int]]:
        exchanged = {(b, a) for i, a in enumerate(line) for b in line[i + 1 :] if b < a}
        if not exchanged:
            return set()
        facts, done = self._problem.init, 0
        try:
            for step in replayed(self._problem, [actions[k] for k in line]):
                facts, done = step.facts, done + 1
        except Inapplicable:
            failed = line[done]
            return {pair for pair in exchanged if failed in pair} or exchanged
        if Stepper(self._problem).holds(facts, self._problem.goal):
            return set()
        *_, end = replayed(self._problem, actions)
        return set() if facts == end.facts else exchanged


def _bound(order: Precedence, begun: Sequence[int] = (), earliest: int = 0) -> int:
    """Ticks below which no schedule of these motions ends: that of its longest chain, with nothing in the way."""
    free = scheduled(order, None, tails(order), begun, earliest)
    assert free is not None
    return free.end


def _in_sequence(order: Precedence) -> Timetable:
    """One phase after the other."""
    starts: list[int | None] = []
    switches: list[int] = []
    for segment in order.segments:
        begin = switches[-1] if switches else 0
        starts.append(None if segment is None else begin)
        switches.append(begin + max(1, 0 if segment is None else segment.ticks))
    return Timetable(tuple(starts), tuple(switches))


def configurations(skeleton: Skeleton, paths: Sequence[PhasePath]) -> list[Configuration]:
    """Where everything is at the switches of a plan in sequence, the start first."""
    found = [start_configuration(skeleton.problem)]
    for path in paths:
        modules = {**found[-1].modules, **{m: rows[-1] for m, rows in path.modules.items()}}
        found.append(found[-1].then(modules, {b: rows[-1] for b, rows in path.bodies.items()}))
    return found
