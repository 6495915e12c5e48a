"""A bidirectional rapidly exploring random tree (RRT-Connect, Kuffner and LaValle 2000) in the joints of one phase."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ....compiler.motion.collision import CHECK_MARGIN
from ...budget import Budget
from ...skeleton import Array
from .batch import Batch
from .shares import CONTACT_TOLERANCE, share_table

RESOLUTION = 0.05
"""Largest change of a joint between checked poses on an edge, radians or metres."""
STRIDE = 0.6
"""Largest change of a joint along one edge."""
ITERATIONS = 400
NEAR = 0.3
"""Share of the samples drawn around poses that were reached already."""
SPREAD = 0.6


class _Checker:
    """Whether poses of one phase are free, on the optimiser's spheres with the contacts of the phase exempt."""

    def __init__(self, batch: Batch, phase: int) -> None:
        self.batch = batch.take(np.array([phase]))
        coarse = self.batch.coarse
        least = share_table(np.arange(self.batch.slices + 1.0), self.batch.slices).min(axis=1)
        needed = np.where(least < 1.0, np.minimum(least, 0.0) - CONTACT_TOLERANCE, CHECK_MARGIN)
        self.needed = (needed[coarse.obstacle_kinds], needed[coarse.pair_kinds])
        self.needed_of_wholes = [needed[kinds] for kinds in coarse.whole_kinds]
        joints = self.batch.joints
        self.lower, self.upper = joints.lower[0] + 1e-3, joints.upper[0] - 1e-3

    def free(self, poses: Array) -> Array:
        """`(poses,)` whether joint values `(poses, joints)` are free."""
        obstacles, pairs, wholes = self.batch.coarse.clearances(poses[None])
        clear = (obstacles[:, :, 0] >= self.needed[0]).all(axis=(0, 1))
        clear &= (pairs[:, 0] >= self.needed[1]).all(axis=0)
        for clearance, needed in zip(wholes, self.needed_of_wholes, strict=True):
            clear &= (clearance[:, 0] >= needed).all(axis=0)
        return np.asarray(clear & ((poses >= self.lower) & (poses <= self.upper)).all(axis=1))

    def advance(self, start: Array, goal: Array) -> tuple[Array, bool]:
        """How far the straight edge is free: the last free pose, and whether that is the goal."""
        count = max(2, int(np.ceil(np.abs(goal - start).max() / RESOLUTION)))
        steps = start + (np.arange(1, count + 1) / count)[:, None] * (goal - start)
        free = self.free(steps)
        if free.all():
            return goal, True
        first = int(np.argmin(free))
        return (steps[first - 1] if first else start), False


@dataclass(slots=True)
class _Tree:
    poses: list[Array]
    parents: list[int] = field(default_factory=lambda: [-1])

    def nearest(self, pose: Array) -> int:
        return int(((np.array(self.poses) - pose) ** 2).sum(axis=1).argmin())

    def grow(self, checker: _Checker, index: int, goal: Array) -> tuple[int, bool]:
        """One edge from a node towards a goal: the new node (-1 when blocked) and whether it is the goal."""
        start = self.poses[index]
        length = np.abs(goal - start).max()
        target = goal if length <= STRIDE else start + (goal - start) * (STRIDE / length)
        reached, whole = checker.advance(start, target)
        if np.abs(reached - start).max() < 0.1 and not whole:
            return -1, False
        self.poses.append(reached)
        self.parents.append(index)
        return len(self.poses) - 1, whole and length <= STRIDE

    def branch(self, index: int) -> list[Array]:
        """The poses from a node to the root."""
        found = []
        while index >= 0:
            found.append(self.poses[index])
            index = self.parents[index]
        return found


def connect(checker: _Checker, start: Array, end: Array, random: np.random.Generator, budget: Budget) -> Array | None:
    """A free polyline `(poses, joints)` from start to end, or None after ITERATIONS."""
    trees = (_Tree([start]), _Tree([end]))
    for iteration in range(ITERATIONS):
        budget.check()
        own, other = trees[iteration % 2], trees[1 - iteration % 2]
        sample = random.uniform(checker.lower, checker.upper)
        if random.random() < NEAR:
            around = own.poses[int(random.integers(len(own.poses)))]
            sample = np.clip(around + random.normal(0.0, SPREAD, len(start)), checker.lower, checker.upper)
        node, _ = own.grow(checker, own.nearest(sample), sample)
        if node < 0:
            continue
        meeting = own.poses[node]
        partner, met = other.nearest(meeting), False
        while partner >= 0 and not met:
            partner, met = other.grow(checker, partner, meeting)
        if met:
            line = own.branch(node)[::-1] + other.branch(other.parents[partner])
            return np.array(line if iteration % 2 == 0 else line[::-1])
    return None


def shorten(checker: _Checker, line: Array, random: np.random.Generator, tries: int) -> Array:
    """Cut corners of a polyline where the straight edge is free."""
    for _ in range(tries):
        if len(line) < 3:
            break
        lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
        cuts = np.sort(random.uniform(0.0, lengths[-1], 2))
        first, second = np.clip(np.searchsorted(lengths, cuts) - 1, 0, len(line) - 2)
        if first == second:
            continue
        a, b = (
            line[i] + (line[i + 1] - line[i]) * (u - lengths[i]) / (lengths[i + 1] - lengths[i])
            for i, u in zip((first, second), cuts, strict=True)
        )
        if checker.advance(a, b)[1]:
            line = np.concatenate([line[: first + 1], [a, b], line[second + 1 :]])
    return line


def resample(line: Array, slices: int) -> Array:
    """Inner slices `(slices - 1, joints)` along a polyline, slow at both ends."""
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    share = np.arange(1, slices) / slices
    at = share * share * (3.0 - 2.0 * share) * lengths[-1]
    return np.stack([np.interp(at, lengths, line[:, j]) for j in range(line.shape[1])], axis=1)


def sampled_starts(batch: Batch, phase: int, random: np.random.Generator, budget: Budget, count: int) -> Array | None:
    """`count` starts `(count, slices - 1, joints)` for one phase along a sampled free polyline, or None."""
    checker = _Checker(batch, phase)
    start, end = batch.start[phase], batch.end[phase]
    line = connect(checker, start, end, random, budget)
    if line is None:
        return None
    return np.array([
        resample(shorten(checker, line, random, 20 * (k + 1)), batch.slices) for k in range(count)
    ])
