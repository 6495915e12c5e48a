"""Penetration of shapes along the whole motion, by coal, swept: between instants a bound on the relative motion decides
whether a closer look is needed.

Two convex shapes whose points, seen from one of them, move by at most c metres in straight lines from one instant to
the next, and stray from these lines by at most m, are never nearer between both than (d0 + d1 - c) / 2 - m, where d0
and d1 are their distances at the instants. Where that may be a penetration beyond the limit, the stretch between them
is halved, which makes m four times smaller; what is not decided in the end is refused."""

from __future__ import annotations

from collections.abc import Set

import numpy as np

from ...langs.frozen import dataclass
from ..plan import Plan
from .bounds import Bounds
from .findings import Findings
from .geometry import Array, Frames
from .happenings import Happenings
from .kinematics import Motion
from .sampler import Grid, Placement, Sampler
from .settling import DEEPEST, MOST
from .shapes import Ruler, transform
from .solids import Solid, moved, pairs, solids
from .sweeps import (
    Sweep,
    edges,
    lower_bound,
    near_instants,
    near_pairs,
    near_resting,
    relative_steps,
    resting_edges,
    sweep,
)

SAME = 1e-7
"""Metres that make no difference to a distance."""
ROUNDING = 1e-5
"""Metres by which distances that coal gives may be wrong: nothing is halved for them."""
NO_DEPTH = -np.inf


def check_collisions(plan: Plan, motion: Motion, sampler: Sampler, findings: Findings) -> None:
    """Record the deepest penetration of every pair of shapes in every phase that comes near zero; of what rests, once
    for the same two places. What bodies do to each other that move only by themselves, and what has left the scene, is
    nobody's fault."""
    found, happenings = solids(plan), sampler.happenings
    own = {b for b in happenings.courses if all(b in free for free in happenings.free)}
    findings.measure("penetration_m", 0.0, "")
    fixed = {b.name for b in plan.bodies if not b.movable} - set(happenings.courses)
    at_rest = _AtRest(found, frozenset(k for k, solid in enumerate(found) if solid.thing in fixed))
    looked_at = _LookedAt(plan, found, at_rest, own, findings)
    for phase in range(len(plan.phases)):
        begin = float(motion.times[motion.ranges[phase][0]])
        gone = _away(found, happenings, begin) if happenings.gone else frozenset()
        for grid in sampler.grid(phase).parts():
            _check_part(_Part(sampler, phase, grid, found, at_rest), looked_at, gone, findings)


def _away(found: list[Solid], happenings: Happenings, begin: float) -> frozenset[int]:
    return frozenset(k for k, solid in enumerate(found) if happenings.away(solid.thing, begin))


def _check_part(part: _Part, looked_at: _LookedAt, gone: frozenset[int], findings: Findings) -> None:
    near = [pair for pair in looked_at.near(part) if gone.isdisjoint(pair)]
    part.look_ahead(near)
    for i, k in near:
        findings.check_time()
        search = part.search(i, k, findings)
        if search is None:
            continue
        names = [part.sweep(n).solid.name for n in (i, k)]
        deepest = search.worst
        if deepest.depth > 0.0:
            message = f"{names[0]} and {names[1]} overlap"
            findings.measure("penetration_m", deepest.depth, message, time=deepest.time, between=names)
        if search.undecided is not None:
            message = f"whether {names[0]} and {names[1]} overlap between instants cannot be decided"
            findings.fail("undecided", message, time=search.undecided, between=names)


class _AtRest:
    """What is known of resting solids, by their places: which never move and the `edges` of boxes around these, of each
    the last sweep, and which pairs were measured."""

    def __init__(self, found: list[Solid], fixed: frozenset[int]) -> None:
        self.fixed = sorted(fixed)
        self.loose = [k for k in range(len(found)) if k not in fixed]
        """The solids that may move."""
        self.edges = np.zeros((0, 3)), np.zeros((0, 3))
        self.last: dict[int, tuple[bytes, Sweep]] = {}
        self._found = found
        self._frames: dict[int, Frames] = {}
        self._measured = set[tuple[int, bytes, int, bytes]]()

    def place(self, placement: Placement) -> None:
        """Take in where the solids are that never move, once."""
        if self.fixed and not self._frames:
            self._frames = {k: self._found[k].frames(placement) for k in self.fixed}
            self.edges = resting_edges([self._found[k] for k in self.fixed], list(self._frames.values()))

    def known(self, index: int) -> Sweep:
        """The sweep of a solid that never moves."""
        return self.last[index][1] if index in self.last else self.sweep(index, self._found[index], self._frames[index])

    def sweep(self, index: int, solid: Solid, frames: Frames) -> Sweep:
        """The sweep of a solid that rests."""
        place = frames.position.tobytes() + frames.rotation.tobytes()
        if index not in self.last or self.last[index][0] != place:
            self.last[index] = place, sweep(solid, frames, np.zeros(0))
        return self.last[index][1]

    def is_new(self, i: int, k: int) -> bool:
        """Whether two resting solids were never asked about where they are now."""
        places = i, self.last[i][0], k, self.last[k][0]
        if places in self._measured:
            return False
        self._measured.add(places)
        return True


class _LookedAt:
    """Which pairs of solids are looked at: all that could come to touch and may not."""

    def __init__(
        self, plan: Plan, found: list[Solid], at_rest: _AtRest, own: Set[str], findings: Findings
    ) -> None:  # fmt: skip
        self._at_rest, self._loose = at_rest, np.array(at_rest.loose, dtype=np.intp)
        some = [found[k] for k in at_rest.loose]
        self._among = np.array(pairs(plan, some, own, findings.check_time), dtype=np.intp).reshape(-1, 2)
        things = moved(plan, own)
        self._movers = np.array([k for k, solid in enumerate(some) if solid.thing in things], dtype=np.intp)
        self._fixed = np.array(at_rest.fixed, dtype=np.intp)

    def near(self, part: _Part) -> list[tuple[int, int]]:
        """Those whose boxes around a part of a phase overlap, in order."""
        low, high = edges([part.sweep(k) for k in self._loose.tolist()])
        among = self._loose[self._among[near_pairs(low, high, self._among)]]
        lowest, highest = self._at_rest.edges
        apart = np.zeros((len(self._movers), len(self._fixed)), dtype=bool)
        for k in range(3):
            apart |= low[self._movers, k, None] > highest[:, k]
            apart |= high[self._movers, k, None] < lowest[:, k]
        mover, other = np.nonzero(~apart)
        beside = np.column_stack([self._loose[self._movers[mover]], self._fixed[other]])
        found = np.sort(np.concatenate([among, beside]), axis=1)
        return [(i, k) for i, k in found[np.lexsort((found[:, 1], found[:, 0]))].tolist()]


@dataclass(frozen=True, slots=True)
class _Depth:
    """How deep two solids overlap, metres, and when; negative where they are apart."""

    depth: float
    time: float


class _Part:
    """A phase, or part of it: what all solids sweep between the instants of a grid."""

    def __init__(self, sampler: Sampler, phase: int, grid: Grid, found: list[Solid], at_rest: _AtRest) -> None:
        self.sampler, self.phase, self.grid = sampler, phase, grid
        self.ruler = Ruler()
        placement = sampler.at(phase, grid.times)
        self.bounds = Bounds(sampler, phase, grid, placement)
        self._at_rest = at_rest
        self._sweeps: dict[int, Sweep] = {}
        self._near: dict[tuple[int, int], tuple[int, int] | None] = {}
        at_rest.place(placement)
        for index in at_rest.loose:
            frames = found[index].frames(placement)
            rests = len(frames) == 1
            made = at_rest.sweep(index, found[index], frames) if rests else self._moving(found[index], frames)
            self._sweeps[index] = made

    def sweep(self, index: int) -> Sweep:
        """What a solid sweeps."""
        return self._sweeps[index] if index in self._sweeps else self._at_rest.known(index)

    def look_ahead(self, pairs: list[tuple[int, int]]) -> None:
        """Find for pairs of a solid that moves and one that rests when they may come near, for all of one at once."""
        partners: dict[int, list[int]] = {}
        for i, k in pairs:
            if self.sweep(i).rests != self.sweep(k).rests:
                mover, other = (k, i) if self.sweep(i).rests else (i, k)
                partners.setdefault(mover, []).append(other)
        for mover, others in partners.items():
            found = near_resting(self.sweep(mover), *edges([self.sweep(k) for k in others]))
            self._near |= {(mover, k): near for k, near in zip(others, found, strict=True)}

    def _moving(self, solid: Solid, frames: Frames) -> Sweep:
        return sweep(solid, frames, self.bounds.bend(solid.node, solid.reach))

    def search(self, i: int, k: int, findings: Findings) -> _Search | None:
        """The search for the deepest penetration of two solids, carried out; None where they are not near, or where
        both rest and their distance is known."""
        a, b = self.sweep(i), self.sweep(k)
        if a.rests and b.rests:
            return _Search(self, a, b, findings).at_rest() if self._at_rest.is_new(i, k) else None
        known = (i, k) if b.rests else (k, i)
        near = self._near[known] if a.rests or b.rests else near_instants(a, b)
        if near is None:
            return None
        search = _Search(self, *_ordered(a, b), findings)
        search.moving(*near)
        return search

    def distance(self, a: Sweep, b: Sweep, instant: int) -> float:
        """The signed distance of two solids at an instant."""
        return self.ruler.distance(
            a.solid.solid, transform(*a.at(instant)), b.solid.solid, transform(*b.at(instant))
        )


def _ordered(a: Sweep, b: Sweep) -> tuple[Sweep, Sweep]:
    """The solid that is seen, of fewer points if possible, and that from which it is seen, which rests if one does."""
    if a.rests or (not b.rests and len(a.solid.points) > len(b.solid.points)):
        return b, a
    return a, b


class _Search:
    """Looks for the deepest penetration of two solids: a stretch of time is halved as long as the distances at its
    ends, and how far the solids move between them, leave room for a deeper one."""

    def __init__(self, part: _Part, a: Sweep, b: Sweep, findings: Findings) -> None:
        """`a` is seen from `b`."""
        self.worst = _Depth(NO_DEPTH, 0.0)
        self.undecided: float | None = None
        """A time at which nothing can be said."""
        self._part, self._a, self._b, self._findings = part, a, b, findings
        self._known: dict[int, float] = {}
        self._way, self._most = np.zeros(0), np.zeros(0)
        self._open: list[int] = []

    def at_rest(self) -> _Search:
        """Look at two solids that rest."""
        self._distance(0)
        return self

    def moving(self, first: int, last: int) -> None:
        """Look between two instants."""
        strayed = self._strayed(self._part.bounds, self._a, self._b)
        steps, strayed = relative_steps(self._a, self._b, first, last), strayed[first:last]
        steps = np.where(self._part.grid.joined[first:last], steps, 0.0)
        strayed = np.where(self._part.grid.joined[first:last], strayed, 0.0)
        bound = lower_bound(self._a, self._b, first, last)
        suspect = first + np.flatnonzero(bound[:-1] + bound[1:] - steps - 2.0 * strayed < 0.0)
        self._way = np.concatenate([np.zeros(first + 1), np.cumsum(steps)])
        self._most = np.concatenate([np.zeros(first), strayed])
        for run in np.split(suspect, np.flatnonzero(np.diff(suspect) > 1) + 1):
            if len(run):
                self._between(int(run[0]), int(run[-1]) + 1)
        if self._open:
            self._look_closer()

    def _strayed(self, bounds: Bounds, a: Sweep, b: Sweep) -> Array:
        """How far points of `a`, seen from `b`, stray from straight lines in each stretch."""
        apart = np.linalg.norm(a.frames.position - b.frames.position, axis=1) + a.solid.radius
        apart = np.broadcast_to(apart, (len(bounds.lengths) + 1,))
        _, seen = bounds.relative(b.solid.node, b.solid.offset, a.solid.node, a.solid.reach, apart)
        return bounds.strayed(seen.acceleration)

    def _between(self, first: int, last: int) -> None:
        """Look at instants between two, until no other can show a deeper penetration; keep what may have one beyond
        the limit between neighbouring instants."""
        self._findings.check_time()
        ends = self._distance(first), self._distance(last)
        least = 0.5 * (sum(ends) - (self._way[last] - self._way[first]))
        limit = -self._findings.limit("penetration_m") - ROUNDING
        safe = least - float(self._most[first:last].max()) >= limit
        if last - first == 1:
            if not safe:
                self._open.append(first)
        elif not safe or least < min(0.0, -self.worst.depth) - SAME:
            middle = (first + last) // 2
            self._between(first, middle)
            self._between(middle, last)

    def _distance(self, instant: int) -> float:
        if instant not in self._known:
            distance = self._known[instant] = self._part.distance(self._a, self._b, instant)
            self._note(distance, float(self._part.grid.times[instant]))
        return self._known[instant]

    def _note(self, distance: float, time: float) -> None:
        self.worst = max(self.worst, _Depth(-distance, time), key=lambda d: d.depth)

    def _look_closer(self) -> None:
        """Halve stretches until their ends say enough about what lies between, or a penetration is found."""
        stretches = np.array(self._open, dtype=np.intp)
        distances = np.array([[self._known[k], self._known[k + 1]] for k in self._open])
        grid = self._part.grid
        for _ in range(DEEPEST):
            if self.worst.depth > self._findings.limit("penetration_m") or not len(stretches):
                return
            if len(stretches) > MOST:
                break
            grid = grid.halved(stretches)
            a, b, strayed = self._closer(grid)
            middles = np.array([self._measured(a, b, grid, 3 * k + 1) for k in range(len(stretches))])
            ends = np.column_stack([distances[:, 0], middles, middles, distances[:, 1]]).reshape(-1, 2, 2)
            steps = np.where(grid.joined, relative_steps(a, b, 0, len(grid.times) - 1), 0.0)
            halves = np.append(0.5 * steps + strayed, 0.0).reshape(-1, 3)[:, :2]
            unsafe = 0.5 * ends.sum(axis=2) - halves < -self._findings.limit("penetration_m") - ROUNDING
            which, half = np.nonzero(unsafe)
            stretches, distances = 3 * which + half, ends[which, half]
        if len(stretches):
            self.undecided = float(grid.times[stretches[0]])

    def _measured(self, a: Sweep, b: Sweep, grid: Grid, instant: int) -> float:
        self._findings.check_time()
        distance = self._part.distance(a, b, instant)
        self._note(distance, float(grid.times[instant]))
        return distance

    def _closer(self, grid: Grid) -> tuple[Sweep, Sweep, Array]:
        """Both solids at other instants, and how far one strays."""
        placement = self._part.sampler.at(self._part.phase, grid.times)
        bounds = Bounds(self._part.sampler, self._part.phase, grid, placement)
        none = np.zeros(len(grid.joined))
        a, b = (sweep(s.solid, s.solid.frames(placement), none) for s in (self._a, self._b))
        return a, b, self._strayed(bounds, a, b)
