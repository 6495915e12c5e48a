"""Penetration of shapes along the whole motion, by coal, swept: between instants a bound on the relative motion
decides whether a closer look is needed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ...compiler import ir
from ..plan import Plan
from .findings import Findings
from .geometry import Array, Frames
from .happenings import Happenings
from .kinematics import Kinematics, Motion
from .limits import LIMITS
from .sampler import Placement, Sampler
from .shapes import Ruler, transform
from .solids import Solid, pairs, solids
from .sweeps import BEND, Sweep, lower_bound, near_instants, near_pairs, relative_steps, sweep

LOOKS = 10
"""Instants per knot interval of the splines, which is the planner's own resolution, before any closer look."""
DEEPEST = 7
"""How often the interval between two instants is halved at most."""
SAME = 1e-7
"""Metres that make no difference to a distance."""
NO_DEPTH = -np.inf


def check_collisions(
    problem: ir.Problem, plan: Plan, motion: Motion, kinematics: Mapping[str, Kinematics], happenings: Happenings,
    findings: Findings,
) -> None:  # fmt: skip
    """Record the deepest penetration of every pair of shapes in every phase that comes near zero; of what rests, once
    for the same two places. What bodies do to each other that move only by themselves, and what has left the scene, is
    nobody's fault."""
    found = solids(plan)
    own = {b for b in happenings.courses if all(b in free for free in happenings.free)}
    looked_at = np.array(pairs(plan, found, own), dtype=np.intp).reshape(-1, 2)
    sampler = Sampler(problem, plan, motion, kinematics, happenings)
    findings.measure("penetration_m", 0.0, "")
    at_rest = _AtRest({}, set())
    for phase in range(len(plan.phases)):
        begin = float(motion.times[motion.ranges[phase][0]])
        check = _PhaseCheck(sampler, phase, found, at_rest)
        left = [k for k, solid in enumerate(found) if solid.thing in happenings.gone]
        away = [k for k in left if happenings.away(found[k].thing, begin)]
        for i, k in near_pairs(check.sweeps, looked_at[~np.isin(looked_at, away).any(axis=1)] if away else looked_at):
            findings.check_time()
            deepest = check.deepest(int(i), int(k))
            if deepest.depth > 0.0:
                names = [found[i].name, found[k].name]
                message = f"{names[0]} and {names[1]} overlap"
                findings.measure("penetration_m", deepest.depth, message, time=deepest.time, between=names)


@dataclass(frozen=True, slots=True)
class _AtRest:
    """What is known of resting solids, by their places: of each the last sweep, and which pairs were measured."""

    last: dict[int, tuple[bytes, Sweep]]
    measured: set[tuple[int, bytes, int, bytes]]

    def sweep(self, index: int, solid: Solid, frames: Frames, always: bool) -> Sweep:
        """The sweep of a solid that rests; `always`: it never does anything else."""
        if always and index in self.last:
            return self.last[index][1]
        place = frames.position.tobytes() + frames.rotation.tobytes()
        if index not in self.last or self.last[index][0] != place:
            self.last[index] = place, sweep(solid, frames)
        return self.last[index][1]

    def is_new(self, i: int, k: int) -> bool:
        """Whether two resting solids were never asked about where they are now."""
        places = i, self.last[i][0], k, self.last[k][0]
        if places in self.measured:
            return False
        self.measured.add(places)
        return True


@dataclass(frozen=True, slots=True)
class _Depth:
    """How deep two solids overlap, metres, and when; negative where they are apart."""

    depth: float
    time: float


class _PhaseCheck:
    """One phase: what all solids sweep between evenly refined instants."""

    def __init__(self, sampler: Sampler, phase: int, found: list[Solid], at_rest: _AtRest) -> None:
        placement = sampler.at(phase, sampler.grid(phase, LOOKS))
        self.times = placement.times
        frames = [s.frames(placement) for s in found]
        self.sweeps = [
            sweep(s, f) if len(f) > 1 else at_rest.sweep(k, s, f, s.thing in sampler.fixed)
            for k, (s, f) in enumerate(zip(found, frames, strict=True))
        ]
        self._at_rest = at_rest
        self._sampler, self._phase = sampler, phase
        self._ruler = Ruler()
        self._closer: dict[tuple[str, float], Placement] = {}

    def deepest(self, i: int, k: int) -> _Depth:
        """The deepest penetration of two solids, as far as they may have one that is not known yet."""
        a, b = self.sweeps[i], self.sweeps[k]
        if a.rests and b.rests:
            new = self._at_rest.is_new(i, k)
            return _Depth(-self.distance(a, b, 0), float(self.times[0])) if new else _Depth(NO_DEPTH, 0.0)
        near = near_instants(a, b)
        if near is None:
            return _Depth(NO_DEPTH, 0.0)
        steps = relative_steps(a, b, *near)
        bound = lower_bound(a, b, *near)
        suspect = near[0] + np.flatnonzero(bound[:-1] + bound[1:] - BEND * steps < 0.0)
        search = _Search(self, a, b, np.concatenate([np.zeros(near[0] + 1), np.cumsum(steps)]))
        for run in np.split(suspect, np.flatnonzero(np.diff(suspect) > 1) + 1):
            if len(run):
                search.between(int(run[0]), int(run[-1]) + 1)
        return search.worst

    def distance(self, a: Sweep, b: Sweep, instant: int) -> float:
        """The signed distance of two solids at an instant."""
        return self._ruler.distance(
            a.solid.solid, transform(*a.at(instant)), b.solid.solid, transform(*b.at(instant))
        )

    def closer(self, a: Solid, b: Solid, times: Array) -> tuple[Sweep, Sweep]:
        """Two solids at other times."""
        return sweep(a, self._frames(a, times)), sweep(b, self._frames(b, times))

    def _frames(self, solid: Solid, times: Array) -> Frames:
        parts = []
        for time in times:
            key = solid.thing, float(time)
            if key not in self._closer:
                self._closer[key] = self._sampler.at(self._phase, np.array([time]), solid.thing)
            parts.append(solid.frames(self._closer[key]))
        return Frames(np.vstack([p.position for p in parts]), np.concatenate([p.rotation for p in parts]))


class _Search:
    """Looks for the deepest penetration of two solids: a stretch of time is halved as long as the distances at its
    ends, and how far the solids move between them, leave room for a deeper one."""

    def __init__(self, check: _PhaseCheck, a: Sweep, b: Sweep, way: Array) -> None:
        """`way` `(T,)`: how far any point of one solid has moved, seen from the other, at each instant."""
        self.worst = _Depth(NO_DEPTH, 0.0)
        self._check, self._a, self._b, self._way = check, a, b, way
        self._known: dict[int, float] = {}

    def between(self, first: int, last: int) -> None:
        """Look between two instants."""
        ends = self._distance(first), self._distance(last)
        least = 0.5 * (sum(ends) - BEND * (self._way[last] - self._way[first]))
        if least >= min(0.0, -self.worst.depth) - SAME:
            return
        if last - first > 1:
            middle = (first + last) // 2
            self.between(first, middle)
            self.between(middle, last)
        elif least < -LIMITS["penetration_m"] and self.worst.depth <= LIMITS["penetration_m"]:
            self._look_closer((float(self._check.times[first]), float(self._check.times[last])), ends, 1)

    def _distance(self, instant: int) -> float:
        if instant not in self._known:
            distance = self._known[instant] = self._check.distance(self._a, self._b, instant)
            self._note(distance, float(self._check.times[instant]))
        return self._known[instant]

    def _note(self, distance: float, time: float) -> None:
        self.worst = max(self.worst, _Depth(-distance, time), key=lambda d: d.depth)

    def _look_closer(self, ends: tuple[float, float], known: tuple[float, float], depth: int) -> None:
        """Halve the interval between two neighbouring instants until its ends say enough about what lies between."""
        middle = 0.5 * (ends[0] + ends[1])
        a, b = self._check.closer(self._a.solid, self._b.solid, np.array([ends[0], middle, ends[1]]))
        distance = self._check.distance(a, b, 1)
        self._note(distance, middle)
        halves = (((ends[0], middle), (known[0], distance)), ((middle, ends[1]), (distance, known[1])))
        for (half, values), step in zip(halves, relative_steps(a, b, 0, 2), strict=True):
            unsafe = sum(values) - BEND * step < -2 * LIMITS["penetration_m"]
            if unsafe and depth < DEEPEST and self.worst.depth <= LIMITS["penetration_m"]:
                self._look_closer(half, values, depth + 1)
