"""From a verified plan in sequence to one whose robots work at once: profiles, schedule, plan."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence
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
from .dependencies import Precedence, Segment, precedence
from .least_times import least_time
from .list_schedule import Timetable, scheduled, tails
from .other_ways import OtherWays
from .profiles import path_as_is, retimed
from .scheduled_plan import plan_order, scheduled_plan
from .settings import SCHEDULE


@dataclass(frozen=True, slots=True)
class Timed:
    """A plan in seconds: the plan, seconds until its last action, and that none with these motions is shorter than
    `bound` seconds; `seconds` of each action's motion, in the order of the search, and the numbers that its phases have
    in that `order`."""

    plan: Plan
    makespan: float
    bound: float
    seconds: tuple[float, ...]
    order: tuple[int, ...]


class Scheduler:
    """Makes plans of a problem shorter. `margin`, metres, is what two robots keep that move at once; `ways`
    finds other motions where some take long."""

    def __init__(
        self, problem: Problem, margin: float, seed: Seed, budget: Budget, ways: OtherWays | None = None
    ) -> None:
        self._problem, self._margin, self._seed, self._budget, self._ways = problem, margin, seed, budget, ways
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
        made = [(sequence, order)]
        found = self._best(skeleton, actions, order, faster)
        if found is not None and found[0].end < sequence.end:
            made.append(found)
        found = self._faster(skeleton, actions, *made[-1], faster, tick)
        if found is not None:
            made.append(found)
        for table, own in reversed(made):
            line = plan_order(table)
            done = [actions[k] for k in line]
            same = line == sorted(line)
            other = skeleton if same else build_skeleton(self._problem, done, successors, possible=True)
            plan = scheduled_plan(self._problem, done, other, own, table, tick, statistics)
            seconds = tuple(0.0 if s is None else s.ticks * tick for s in own.segments)
            yield Timed(plan, table.end * tick, _bound(own) * tick, seconds, tuple(line))

    def _faster(
        self, skeleton: Skeleton, actions: Sequence[Action], table: Timetable, order: Precedence,
        paths: Sequence[PhasePath], tick: float,
    ) -> tuple[Timetable, Precedence] | None:  # fmt: skip
        """A shorter schedule, if one is found, with other ways where motions take far longer than straight ones between
        their ends: first around what rests while one action follows the other, then as if others were not there."""
        least = [0 if s is None else _straight(self._problem, s, tick) for s in order.segments]
        best: tuple[Timetable, Precedence] | None = None
        for alone in (False, True):
            far = {k for k, s in enumerate(order.segments) if s is not None and s.ticks > SCHEDULE.detour * least[k]}
            straight = tuple(s and (replace(s, ticks=max(1, least[s.phase])) if s.phase in far else s)
                             for s in order.segments)  # fmt: skip
            end = _bound(replace(order, segments=straight))
            if table.end <= (1.0 + SCHEDULE.tight) * _bound(order):
                far &= _through(order, end)
            if self._ways is None or not far or end > (1.0 - SCHEDULE.shorter_by) * table.end:
                break
            ways = self._ways.found(skeleton, configurations(skeleton, paths), far, alone)
            faster = self._profiles(skeleton, [ways.get(k, path) for k, path in enumerate(paths)], tick)
            shorter = {k for k in ways if faster[k].duration < paths[k].duration - 0.5 * tick}
            chosen = [faster[k] if k in shorter else path for k, path in enumerate(paths)]
            own = precedence(skeleton, chosen, tick)
            found = self._best(skeleton, actions, own, chosen, alone=shorter if alone else ()) if shorter else None
            if found is not None and found[0].end < table.end:
                best, paths = found, chosen
                table, order = found
        return best

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
        begun: Sequence[int] = (), earliest: int = 0, alone: Collection[int] = (),
    ) -> tuple[Timetable, Precedence] | None:  # fmt: skip
        """The shortest of some schedules, whose actions can be done in its order, with what comes before what. Motions
        of the phases `alone` were made as if others were not there."""
        self._told.clear()
        clearances = SegmentClearances(skeleton, order, configurations(skeleton, paths), self._margin, alone)
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


def _through(order: Precedence, end: int) -> set[int]:
    """The phases through which chains of more than `end` ticks lead."""
    behind = tails(order)
    free = scheduled(order, None, behind)
    assert free is not None
    return {k for k, start in enumerate(free.starts) if start is not None and start + behind[k] > end}


def _straight(problem: Problem, segment: Segment, tick: float) -> int:
    """Ticks that joints take at least from where a segment begins to where it ends."""
    seconds = 0.0
    for name in segment.moved & segment.path.modules.keys():
        rows = segment.path.modules[name]
        joints = problem.world.modules[name].type.joints
        ways = np.abs(rows[-1, 7:] - rows[0, 7:]).tolist()
        seconds = max([seconds, *(least_time(j, w) for j, w in zip(joints, ways, strict=True))])
    return math.floor(seconds / tick)


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
