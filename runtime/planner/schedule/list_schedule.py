"""When segments begin: one after the other, that with the longest tail first, as early as what it waits for and what is
in its way allow."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence

import numpy as np

from ....langs.frozen import dataclass
from .clearance import NEVER, START, SegmentClearances
from .dependencies import Precedence
from .settings import SCHEDULE


@dataclass(frozen=True, slots=True)
class Timetable:
    """By phase, in ticks: when its motion begins (None without one), and its switch."""

    starts: tuple[int | None, ...]
    switches: tuple[int, ...]

    @property
    def end(self) -> int:
        """The last switch."""
        return max(self.switches, default=0)


def tails(order: Precedence) -> list[int]:
    """By phase, ticks from the beginning of its motion to the end of all that waits for it, at least."""
    count = len(order)
    behind_switch, found = [0] * count, [0] * count
    for k in reversed(range(count)):
        after = [found[j] for j in range(k + 1, count) if k in order.begins_after[j]]
        after += [behind_switch[j] + 1 for j in range(k + 1, count) if k in order.ordered[j]]
        behind_switch[k] = max(after, default=0)
        own = order.segments[k]
        closing = [behind_switch[j] for j in range(k, count) if k in order.closes[j]]
        following = [found[j] for j in range(k + 1, count) if k in order.follows[j]]
        found[k] = (own.ticks if own is not None else 0) + max([*closing, *following], default=0)
    return found


def scheduled(
    order: Precedence, clearances: SegmentClearances | None, priority: Sequence[float], begun: Sequence[int] = (),
    earliest: int = 0,
) -> Timetable | None:  # fmt: skip
    """A schedule in which of all segments that may begin that of the highest priority is put first. Without
    `clearances` nothing is in the way. The first ones have `begun` at these ticks, the others begin, and all switches
    come, behind the tick `earliest`. Where what was put early blocks a segment for ever, that one is put before all
    later ones. None where a segment is blocked behind its place in the sequence, too."""
    early: set[int] = set()
    while True:
        found = _Placing(order, clearances, priority, begun, earliest, early).run()
        if isinstance(found, Timetable):
            return found
        if found in early:
            return None
        early.add(found)


class _Placing:
    def __init__(
        self, order: Precedence, clearances: SegmentClearances | None, priority: Sequence[float], begun: Sequence[int],
        earliest: int, early: Collection[int],
    ) -> None:  # fmt: skip
        self._order, self._clearances, self._priority, self._early = order, clearances, priority, early
        self._begun, self._least = begun, earliest
        self._starts: dict[int, int] = {}
        self._switches: dict[int, int] = {}
        self._taken: set[int] = set()
        self._lanes: dict[str, list[tuple[int, int, int]]] = {}

    def run(self) -> Timetable | int:
        """The schedule, or the first segment that is blocked for ever."""
        count = len(self._order)
        for phase, start in enumerate(self._begun):
            self._put(phase, start)
        waiting = [k for k in range(len(self._begun), count) if self._order.segments[k] is not None]
        self._switch()
        while waiting:
            ready = [k for k in waiting if self._may_begin(k)]
            ready.sort(key=lambda k: (-self._priority[k], k))
            placed = next(((k, s) for k in ready if (s := self._earliest(k)) is not None), None)
            if placed is None:
                return waiting[0]
            self._put(*placed)
            waiting.remove(placed[0])
            self._switch()
        phases = range(count)
        return Timetable(tuple(self._starts.get(k) for k in phases), tuple(self._switches[k] for k in phases))

    def _end(self, phase: int) -> int:
        segment = self._order.segments[phase]
        assert segment is not None
        return self._starts[phase] + segment.ticks

    def _may_begin(self, k: int) -> bool:
        if any(early < k and early not in self._starts for early in self._early):
            return False
        return self._order.begins_after[k] <= self._switches.keys() and self._order.follows[k] <= self._starts.keys()

    def _put(self, phase: int, start: int) -> None:
        segment = self._order.segments[phase]
        assert segment is not None
        self._starts[phase] = start
        for thing in segment.moved:
            self._lanes.setdefault(thing, []).append((start, start + segment.ticks, phase))

    def _switch(self) -> None:
        """Switches that have all they wait for, each at a tick of its own."""
        grew = True
        while grew:
            grew = False
            for k in range(len(self._order)):
                if k in self._switches or not self._order.ordered[k] <= self._switches.keys():
                    continue
                if not self._order.closes[k] <= self._starts.keys():
                    continue
                after = [self._end(j) for j in self._order.closes[k]]
                after += [self._switches[j] + 1 for j in self._order.ordered[k]]
                tick = max(after, default=1)
                while tick in self._taken or tick <= self._least:
                    tick += 1
                self._switches[k] = tick
                self._taken.add(tick)
                grew = True

    # --- what is in the way ----------------------------------------------------------------------------------------

    def _earliest(self, phase: int) -> int | None:
        """The first tick at which a segment may begin."""
        after = [self._switches[j] for j in self._order.begins_after[phase]]
        ready = max([*after, *(self._end(j) for j in self._order.follows[phase])], default=0)
        ready = max(ready, self._least)
        if self._clearances is None or self._is_free(phase, ready):
            return ready
        last = max((lane[-1][1] for lane in self._lanes.values()), default=0)
        start = ready
        while start < max(last, ready) + SCHEDULE.put_off:
            start += SCHEDULE.put_off
            if self._is_free(phase, start):
                while start - 1 > ready and self._is_free(phase, start - 1):
                    start -= 1
                return start
        return None

    def _is_free(self, phase: int, start: int) -> bool:
        segment, near = self._order.segments[phase], self._clearances
        assert segment is not None and near is not None
        end = start + segment.ticks
        moved = sorted(segment.moved & near.solids.of.keys())
        for thing in near.solids.of:
            if thing in segment.moved:
                continue
            for begin, until, state in self._rests(thing, start):
                blocked = near.blocked_past(phase, thing, state)
                if len(blocked) and np.any((blocked + start + 1 > begin) & (blocked + start < until)):
                    return False
                if until > end and any(near.blocked_states(one, phase, thing, state) for one in moved):
                    return False
        return all(self._passes(phase, start, moved, other) for other in self._starts if self._end(other) > start)

    def _passes(self, phase: int, start: int, moved: Sequence[str], other: int) -> bool:
        """Whether a segment meets another one neither while both move nor when it rests at its end."""
        segment, second, near = self._order.segments[phase], self._order.segments[other], self._clearances
        assert segment is not None and second is not None and near is not None
        if segment.held & second.held:
            return True
        begin, end = self._starts[other], start + segment.ticks
        if begin < end and near.first_meeting(phase, other, begin - start) != NEVER:
            return False
        for thing in moved if self._end(other) > end else ():
            blocked = near.blocked_past(other, thing, phase)
            if len(blocked) and np.any(blocked + begin + 1 > end):
                return False
        return True

    def _rests(self, thing: str, since: int) -> Iterator[tuple[int, int, int]]:
        """When a thing rests, from a tick on: begin, end and state."""
        free, state = 0, START
        for begin, end, phase in self._lanes.get(thing, ()):
            if begin > since:
                yield free, begin, state
            free, state = end, phase
        yield free, NEVER, state
