"""Whether segments of a schedule come too near each other, along their motion: between two looks, distances at both
less what both sides go there bound the least one.

A thing that rests where it rested when a motion was planned is no matter: that was accepted. All other pairs are
measured: two that move keep the margin, one that moves past another that rests elsewhere than then keeps less. What
was nearer at a switch of the plan may come as near again.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from ....compiler.distinct import distinct
from ...geometry.exact_distances import Indices, distances
from ...skeleton import Array, Configuration, Skeleton
from .dependencies import Precedence
from .settings import SCHEDULE
from .solid_motions import SolidFrames, Solids, travelled

START = -1
"""The state of a thing that nothing has moved yet; any other is the number of the phase that moved it last."""
NEVER = 10**9
"""A tick behind all others."""


class SegmentClearances:
    """What the segments of a plan have in their way. `configurations` are those at its switches, the start first. The
    segments `alone` were planned as if nothing else were there that can be moved."""

    def __init__(
        self, skeleton: Skeleton, order: Precedence, configurations: Sequence[Configuration], margin: float,
        alone: Collection[int] = (),
    ) -> None:  # fmt: skip
        self._skeleton, self._order, self._margin = skeleton, order, margin
        self._configurations, self._alone = configurations, alone
        self.solids = Solids(skeleton.problem)
        self._motions: dict[int, SolidFrames] = {}
        self._rests: dict[tuple[str, int], SolidFrames] = {}
        self._allowed: dict[tuple[str, str], Array] = {}
        self._past: dict[tuple[int, str, int], Indices] = {}
        self._both: dict[tuple[int, int, int], int] = {}
        self._states: dict[tuple[str, str, int, int], bool] = {}
        self._planned = self._planned_states()

    def _planned_states(self) -> list[dict[str, int]]:
        """By phase, the state of every thing while it was planned; behind the last phase, at the end."""
        now = dict.fromkeys(self.solids.of, START)
        found = [dict(now)]
        for k, segment in enumerate(self._order.segments):
            now |= dict.fromkeys(segment.moved & now.keys() if segment is not None else (), k)
            found.append(dict(now))
        return found

    # --- where things are ------------------------------------------------------------------------------------------

    def _motion(self, phase: int) -> SolidFrames:
        if phase not in self._motions:
            segment = self._order.segments[phase]
            assert segment is not None
            self._motions[phase] = self.solids.along(
                self._skeleton, phase, segment.path, self._configurations[phase], sorted(segment.moved), SCHEDULE.fine
            )
        return self._motions[phase]

    def _rest(self, thing: str, state: int) -> SolidFrames:
        if (thing, state) not in self._rests:
            self._rests[thing, state] = self.solids.resting(thing, self._configurations[state + 1])
        return self._rests[thing, state]

    def _least_allowed(self, one: str, other: str) -> Array:
        """How near each solid of a thing `(n, m)` comes to each of another at the switches of the plan."""
        if (one, other) not in self._allowed:
            found = np.full((len(self.solids.of[one]), len(self.solids.of[other])), np.inf)
            seen = {(states[one], states[other]) for states in self._planned}
            for first, second in sorted(seen):
                a, b = self._rest(one, first), self._rest(other, second)
                rows, columns = np.indices(found.shape).reshape(2, -1)
                zero = np.zeros(len(rows), dtype=np.intp)
                far = np.full(len(rows), self._margin + SCHEDULE.touch)
                measured = distances(self.solids.posed(a, zero, rows), self.solids.posed(b, zero, columns), far)
                found = np.minimum(found, measured.value.reshape(found.shape))
            self._allowed[one, other] = found
        return self._allowed[one, other]

    def _required(self, first: SolidFrames, second: SolidFrames, wished: float) -> Array:
        """What all pairs of solids keep `(n, m)`: what is wished for, or what they had at switches, less a little."""
        blocks = []
        for one in self.solids.things(first):
            blocks.append(np.hstack([self._least_allowed(one, other) for other in self.solids.things(second)]))
        allowed = np.vstack(blocks)
        return np.where(allowed > wished + SCHEDULE.touch, wished, allowed - SCHEDULE.touch)

    # --- questions ---------------------------------------------------------------------------------------------------

    def blocked_past(self, phase: int, thing: str, state: int) -> Indices:
        """The ticks of a segment, those before the ends of stretches that are too near a thing that rests; none where
        it rested there when the segment was planned."""
        if self._planned[phase][thing] == state and phase not in self._alone:
            return np.zeros(0, dtype=np.intp)
        key = phase, thing, state
        if key not in self._past:
            motion, rest = self._motion(phase), self._rest(thing, state)
            self._past[key] = self._too_near(motion, rest, SCHEDULE.near)
        return self._past[key]

    def blocked_states(self, one: str, first: int, other: str, second: int) -> bool:
        """Whether two things that both rest would be in each other's way; not where they rested so in the plan."""
        if any(states[one] == first and states[other] == second for states in self._planned):
            return False
        key = one, other, first, second
        if key not in self._states:
            a, b = self._rest(one, first), self._rest(other, second)
            self._states[key] = bool(len(self._too_near(a, b, SCHEDULE.near)))
        return self._states[key]

    def first_meeting(self, phase: int, other: int, shift: int) -> int:
        """The first tick of a segment at which it comes too near another one that begins `shift` ticks later; NEVER
        where it does not."""
        if phase > other:
            found = self.first_meeting(other, phase, -shift)
            return found if found == NEVER else found - shift
        key = phase, other, shift
        if key not in self._both:
            a, b = self._motion(phase), self._motion(other)
            looks = SCHEDULE.fine
            begin, end = max(0, shift * looks), min(len(a.positions), shift * looks + len(b.positions))
            self._both[key] = NEVER
            if end - begin > 1:
                part = slice(begin, end), slice(begin - shift * looks, end - shift * looks)
                ticks = self._too_near(a.at(part[0]), b.at(part[1]), self._margin, first_only=True)
                if len(ticks):
                    self._both[key] = int(ticks[0]) + begin // looks
        return self._both[key]

    # --- distances along motions -----------------------------------------------------------------------------------

    def _too_near(
        self, first: SolidFrames, second: SolidFrames, wished: float, first_only: bool = False
    ) -> Indices:  # fmt: skip
        """The ticks in which some pair is nearer than it may, at looks or between; only the first of them where that is
        enough."""
        count = max(len(first.positions), len(second.positions))
        reach_a, reach_b = self.solids.forms.reach[first.solids], self.solids.forms.reach[second.solids]
        one, two = (np.broadcast_to(f.positions, (count, *f.positions.shape[1:])) for f in (first, second))
        ways = [travelled(f, r) if len(f.positions) > 1 else np.zeros((count - 1, len(r)))
                for f, r in ((first, reach_a), (second, reach_b))]  # fmt: skip
        coarse = np.arange(0, count - 1, SCHEDULE.fine) if count > 1 else np.zeros(0, dtype=np.intp)
        if not len(coarse):
            return self._nearest_at(first, second, self._required(first, second, wished))
        ends = np.append(coarse, count - 1)
        apart = np.linalg.norm(one[ends][:, :, None] - two[ends][:, None], axis=-1) - reach_a[:, None] - reach_b
        way = np.add.reduceat(ways[0], coarse)[:, :, None] + np.add.reduceat(ways[1], coarse)[:, None]
        lower = 0.5 * (apart[:-1] + apart[1:] - way)
        if not (lower < wished).any():
            return np.zeros(0, dtype=np.intp)
        required = self._required(first, second, wished)
        stretch, i, k = np.nonzero(lower < required)
        if not len(stretch):
            return np.zeros(0, dtype=np.intp)
        values = self._measured(first, second, ends, distinct(np.concatenate([stretch, stretch + 1])), i, k, stretch,
                                required[i, k] + way[stretch, i, k])  # fmt: skip
        suspect = 0.5 * (values[0] + values[1] - way[stretch, i, k]) < required[i, k]
        return self._fine(first, second, ways, stretch[suspect], i[suspect], k[suspect], required, count, first_only)

    def _nearest_at(self, first: SolidFrames, second: SolidFrames, required: Array) -> Indices:
        rows, columns = np.indices(required.shape).reshape(2, -1)
        zero = np.zeros(len(rows), dtype=np.intp)
        a, b = self.solids.posed(first, zero, rows), self.solids.posed(second, zero, columns)
        near = distances(a, b, required.ravel()).value < required.ravel()
        return zero[:1] if near.any() else zero[:0]

    def _measured(
        self, first: SolidFrames, second: SolidFrames, ends: Indices, looks: Indices, i: Indices, k: Indices,
        stretch: Indices, beyond: Array,
    ) -> tuple[Array, Array]:  # fmt: skip
        """Distances of pairs at both ends of stretches."""
        found = []
        for at in (ends[stretch], ends[stretch + 1]):
            a = self.solids.posed(first, np.minimum(at, len(first.positions) - 1), i)
            b = self.solids.posed(second, np.minimum(at, len(second.positions) - 1), k)
            found.append(distances(a, b, beyond).value)
        return found[0], found[1]

    def _fine(
        self, first: SolidFrames, second: SolidFrames, ways: Sequence[Array], stretch: Indices, i: Indices, k: Indices,
        required: Array, count: int, first_only: bool,
    ) -> Indices:  # fmt: skip
        """Of suspected stretches those in which a closer look finds a pair too near, or cannot tell."""
        bad: set[int] = set()
        looks = SCHEDULE.fine
        for tick in distinct(stretch).tolist():
            chosen = stretch == tick
            a, b = i[chosen], k[chosen]
            at = np.arange(tick * looks, min((tick + 1) * looks, count - 1) + 1)
            rows = np.repeat(np.arange(len(a)), len(at))
            instants = np.tile(at, len(a))
            need = required[a, b]
            values = distances(
                self.solids.posed(first, np.minimum(instants, len(first.positions) - 1), a[rows]),
                self.solids.posed(second, np.minimum(instants, len(second.positions) - 1), b[rows]),
                np.repeat(need + 0.05, len(at)),
            ).value.reshape(len(a), len(at))
            way = ways[0][at[:-1]][:, a].T + ways[1][at[:-1]][:, b].T
            between = 0.5 * (values[:, :-1] + values[:, 1:] - way)
            touching = need < SCHEDULE.near / 2.0
            least = np.where(touching, values.min(axis=1), between.min(axis=1))
            if (least < need).any():
                bad.add(int(tick))
                if first_only:
                    break
        return np.array(sorted(bad), dtype=np.intp)
