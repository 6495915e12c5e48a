"""Penetration of shapes along the whole motion, by coal, swept: between samples a bound on the relative motion
decides whether a closer look is needed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ...compiler import ir
from ..plan import Plan
from .findings import Findings
from .geometry import Array, Frames, Indices
from .happenings import Happenings
from .kinematics import Kinematics, Motion
from .limits import LIMITS
from .sampler import Placement, Sampler
from .shapes import Ruler, transform
from .solids import Solid, pairs, solids

LOOKS = 10
"""Looks per knot interval of the splines, which is the planner's own resolution, before any closer look."""
DEEPEST = 7
"""How often an interval is halved at most."""
BEND = 1.1
"""How much longer the way between two samples may be than the straight line."""
STILL = 1e-7
"""Relative motion, in metres, below which a distance counts as unchanged."""


def check_collisions(
    problem: ir.Problem, plan: Plan, motion: Motion, kinematics: Mapping[str, Kinematics], happenings: Happenings,
    findings: Findings,
) -> None:  # fmt: skip
    """Record the deepest penetration of every pair of shapes in every phase that comes near zero. What bodies do to
    each other that move only by themselves, and what has left the scene, is nobody's fault."""
    found = solids(plan)
    own = {b for b in happenings.courses if all(b in free for free in happenings.free)}
    looked_at = np.array(pairs(plan, found, own), dtype=np.intp).reshape(-1, 2)
    sampler = Sampler(problem, plan, motion, kinematics, happenings)
    findings.measure("penetration_m", 0.0, "")
    at_rest: AtRest = {}
    for phase in range(len(plan.phases)):
        check = _PhaseCheck(sampler, phase, found, at_rest)
        begin = float(motion.times[motion.ranges[phase][0]])
        for i, k in _near_boxes(check, looked_at):
            findings.check_time()
            if any(happenings.away(found[n].thing, begin) for n in (int(i), int(k))):
                continue
            deepest = check.deepest(int(i), int(k))
            if deepest is not None and deepest.depth > 0.0:
                names = [found[i].name, found[k].name]
                message = f"{names[0]} and {names[1]} overlap"
                findings.measure("penetration_m", deepest.depth, message, time=deepest.time, between=names)


AtRest = dict[tuple[int, int], tuple[tuple[bytes, ...], float]]
"""How deep two solids overlap that rest, by their places."""


@dataclass(frozen=True, slots=True)
class _Depth:
    depth: float
    time: float


class _PhaseCheck:
    """One phase: the placement of all solids at evenly refined times, and closer looks where they are needed."""

    def __init__(self, sampler: Sampler, phase: int, found: list[Solid], at_rest: AtRest) -> None:
        self._sampler = sampler
        self._phase = phase
        self.found = found
        self._at_rest = at_rest
        self._ruler = Ruler()
        self._placement = sampler.at(phase, sampler.grid(phase, LOOKS))
        self.frames = [s.frames(self._placement) for s in found]
        self.rests = [s.joint is None and len(self._placement.bodies[s.thing]) == 1 for s in found]
        self._closer: dict[tuple[str, float], Placement] = {}

    def deepest(self, i: int, k: int) -> _Depth | None:
        """The deepest penetration of two solids; None when they certainly stay apart."""
        if self.rests[i] and self.rests[k]:
            return self._deepest_at_rest(i, k)
        a, b = self.frames[i], self.frames[k]
        bound = _lower_bound(self.found[i], a, self.found[k], b)
        steps = _relative_steps(self.found[i], a, self.found[k], b)
        suspect = np.flatnonzero(bound[:-1] + bound[1:] - BEND * steps < 0.0)
        if not len(suspect):
            return None
        times, known = self._placement.times, self._distances(i, k, suspect, steps)
        worst = min((known[t], t) for t in known)
        result = _Depth(-worst[0], float(times[worst[1]]))
        for s in (int(s) for s in suspect):
            unsafe = known[s] + known[s + 1] - BEND * steps[s] < -2 * LIMITS["penetration_m"]
            if unsafe and result.depth <= LIMITS["penetration_m"]:
                ends = (float(times[s]), float(times[s + 1]))
                closer = self._look_closer(i, k, ends, (known[s], known[s + 1]), 1)
                result = max(result, closer, key=lambda d: d.depth)
        return result

    def _deepest_at_rest(self, i: int, k: int) -> _Depth:
        """Of two solids that rest in the phase: measured once for the same two places."""
        a, b = self.frames[i], self.frames[k]
        places = tuple(f[slice(0, 1)].position.tobytes() + f[slice(0, 1)].rotation.tobytes() for f in (a, b))
        known = self._at_rest.get((i, k))
        if known is None or known[0] != places:
            known = self._at_rest[i, k] = (places, -self._distance(i, a, k, b, 0))
        return _Depth(known[1], float(self._placement.times[0]))

    def _distances(self, i: int, k: int, suspect: Indices, steps: Array) -> dict[int, float]:
        """Distances at both ends of the suspect intervals; equal ones are measured once."""
        known: dict[int, float] = {}
        for s in (int(s) for s in suspect):
            if s not in known:
                known[s] = self._distance(i, self.frames[i], k, self.frames[k], s)
            still = steps[s] < STILL
            known[s + 1] = known[s] if still else self._distance(i, self.frames[i], k, self.frames[k], s + 1)
        return known

    def _distance(self, i: int, a: Frames, k: int, b: Frames, at: int) -> float:
        return self._ruler.distance(
            self.found[i].solid, transform(a.position[at], a.rotation[at]),
            self.found[k].solid, transform(b.position[at], b.rotation[at]),
        )  # fmt: skip

    def _look_closer(
        self, i: int, k: int, ends: tuple[float, float], known: tuple[float, float], depth: int
    ) -> _Depth:
        """Halve an interval until its ends' distances say enough about what lies between them."""
        middle = 0.5 * (ends[0] + ends[1])
        a, b = (self._closer_frames(n, (ends[0], middle, ends[1])) for n in (i, k))
        distance = self._distance(i, a, k, b, 1)
        result = _Depth(-distance, middle)
        steps = _relative_steps(self.found[i], a, self.found[k], b)
        halves = (((ends[0], middle), (known[0], distance)), ((middle, ends[1]), (distance, known[1])))
        for (half, values), step in zip(halves, steps, strict=True):
            unsafe = sum(values) - BEND * step < -2 * LIMITS["penetration_m"]
            if unsafe and depth < DEEPEST and result.depth <= LIMITS["penetration_m"]:
                closer = self._look_closer(i, k, half, values, depth + 1)
                result = max(result, closer, key=lambda d: d.depth)
        return result

    def _closer_frames(self, index: int, times: tuple[float, ...]) -> Frames:
        parts = []
        thing = self.found[index].thing
        for time in times:
            if (thing, time) not in self._closer:
                self._closer[thing, time] = self._sampler.at(self._phase, np.array([time]), thing)
            parts.append(self.found[index].frames(self._closer[thing, time]))
        return Frames(
            np.vstack([p.position for p in parts]), np.concatenate([p.rotation for p in parts])
        )


# --- bounds ------------------------------------------------------------------------------------------------------


def _near_boxes(check: _PhaseCheck, looked_at: Indices) -> Indices:
    """The pairs whose boxes, along the world's axes and over the whole phase, overlap `(P, 2)`."""
    lower, upper = [], []
    for solid, frames, rests in zip(check.found, check.frames, check.rests, strict=True):
        some = frames[:1] if rests else frames
        points = some.position[:, None, :] + np.einsum("tij,mj->tmi", some.rotation, solid.points)
        step = np.linalg.norm(np.diff(points, axis=0), axis=2).max(initial=0.0)
        lower.append(points.min(axis=(0, 1)) - solid.ball - BEND * step)
        upper.append(points.max(axis=(0, 1)) + solid.ball + BEND * step)
    low, high = np.array(lower), np.array(upper)
    first, second = looked_at[:, 0], looked_at[:, 1]
    apart = (low[first] > high[second]) | (low[second] > high[first])
    return np.asarray(looked_at[~np.any(apart, axis=1)], dtype=np.intp)


def _lower_bound(first: Solid, a: Frames, second: Solid, b: Frames) -> Array:
    """A lower bound `(T,)` of the distance, from bounding spheres and boxes."""
    bound: Array = np.linalg.norm(a.position - b.position, axis=1) - first.radius - second.radius
    for box, frame, other, at in ((first, a, second, b), (second, b, first, a)):
        if box.kind == "box":
            local = np.abs(np.einsum("tji,tj->ti", frame.rotation, at.position - frame.position))
            outside = np.linalg.norm(np.maximum(local - 0.5 * np.asarray(box.size), 0.0), axis=1)
            bound = np.maximum(bound, outside - other.radius)
    return bound


def _relative_steps(first: Solid, a: Frames, second: Solid, b: Frames) -> Array:
    """How far any point of one solid moves, seen from the other, between neighbouring instants `(T - 1,)`."""
    if len(first.points) <= len(second.points):
        points, relative = first.points, a.relative_to(b)
    else:
        points, relative = second.points, b.relative_to(a)
    placed = relative.position[:, None, :] + np.einsum("tij,mj->tmi", relative.rotation, points)
    return np.asarray(np.linalg.norm(np.diff(placed, axis=0), axis=2).max(axis=1))
