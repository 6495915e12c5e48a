"""Rapidly exploring random trees from both ends (RRT-Connect, Kuffner and LaValle 2000) in the joints of one phase.

Several edges grow at a time, as a look at many poses costs little more than a look at one.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from .....compiler.motion.collision import PATH_MARGIN
from ....budget import Budget
from ....skeleton import Array
from .batch_kinematics import Indices
from .contact_margins import REQUIRED
from .exact_check import OUT_OF_SIGHT, poses_blocked, wholes_spare
from .phase_batch import Batch
from .proximity import close
from .settings import PHASES
from .withdrawals import withdrawals


class Space(Protocol):
    """Where trees grow: between bounds `(joints,)`."""

    lower: Array
    upper: Array

    def near(self, goals: Array) -> Array:
        """What trees grow towards instead of random goals `(m, joints)`."""

    def ways(self, root: Array) -> Sequence[Array]:
        """Ways `(poses, joints)` from a root, which is left out, by which its tree begins."""

    def advance(self, starts: Array, goals: Array) -> tuple[Array, NDArray[np.bool_]]:
        """How far edges `(m, joints)` are free: their last free poses `(m, joints)`, and whether those are the goals
        `(m,)`."""


class _Checker:
    """Whether poses of one phase are free, on what the optimiser sees, with the contacts of the phase exempt. What is
    thin is missed between them; edges are `sound` where it is not."""

    def __init__(self, batch: Batch, phase: int) -> None:
        self.batch = batch.take(np.array([phase]))
        self.geometry, self.exact = self.batch.coarse, self.batch.exact
        low, high = batch.inner_limits()
        self.lower, self.upper = low[phase], high[phase]

    def free(self, poses: Array) -> NDArray[np.bool_]:
        """`(poses,)` whether joint values `(poses, joints)` are free."""
        result: NDArray[np.bool_] = ((poses >= self.lower) & (poses <= self.upper)).all(axis=1)
        for found in close(self.geometry, poses[None], 0.0):
            result[found.time[found.clearance < REQUIRED[found.kind]]] = False
        if self.exact.wholes:
            left = np.flatnonzero(result)
            result[left] = ~poses_blocked(self.exact, poses[left], wholes=True)
        return result

    def near(self, goals: Array) -> Array:
        """These themselves."""
        return goals

    def ways(self, root: Array) -> list[Array]:
        """Straight ways out of what is near."""
        return withdrawals(self.batch, root, self.advance)

    def advance(self, starts: Array, goals: Array) -> tuple[Array, NDArray[np.bool_]]:
        """How far straight edges `(m, joints)` are free: their last free poses `(m, joints)`, and whether those are
        the goals `(m,)`."""
        way = goals - starts
        count = _steps(way)
        until = self._free_steps(starts, way, count)
        return starts + (until / count)[:, None] * way, until == count

    def sound(self, starts: Array, goals: Array) -> NDArray[np.bool_]:
        """Whether straight edges `(m, joints)` are free, looked at closely: `(m,)`."""
        way = goals - starts
        count = _steps(way)
        until = self._free_steps(starts, way, count)
        result: NDArray[np.bool_] = until == count
        if result.any():
            free = np.flatnonzero(result)
            result[free] = self._free_between(starts[free], way[free] / count[free, None], count[free])
        return result

    def _free_steps(self, starts: Array, way: Array, count: Indices) -> Indices:
        """How many of `count` steps `(m,)` along each edge, `way` long, are free, looked at by more and more at a
        time: most of the long edges are blocked soon."""
        until, left, done, ahead = count.copy(), np.arange(len(count)), 0, PHASES.first_steps
        while len(left):
            looked = np.minimum(count[left] - done, ahead)
            first = np.cumsum(looked) - looked
            edge = np.repeat(left, looked)
            number = np.arange(len(edge)) - np.repeat(first, looked) + done + 1
            poses = starts[edge] + (number / count[edge])[:, None] * way[edge]
            passed = np.where(self.free(poses), len(edge) + done, number - 1)
            passed = np.minimum(np.minimum.reduceat(passed, first), done + looked)
            until[left] = passed
            done, ahead = done + ahead, 2 * ahead
            left = left[(passed == done) & (count[left] > done)]
        return until

    def _free_between(self, starts: Array, steps: Array, count: Indices) -> NDArray[np.bool_]:
        """Whether edges of so many free steps `(m,)` are free between their poses, too, where what moves comes nearer
        to something than it moves."""
        first = np.cumsum(count) - count
        edge = np.repeat(np.arange(len(count)), count)
        number = np.arange(len(edge)) - first[edge]
        lower = starts[edge] + number[:, None] * steps[edge]
        way = self._moved(lower, lower + steps[edge])
        spare = self._spare(np.concatenate([lower, lower + steps[edge]]), way.max()).reshape(2, -1).sum(axis=0)
        looks = np.where(spare < way, np.ceil(way / PHASES.edge_look).astype(np.intp), 0)
        result = np.ones(len(count), bool)
        row = np.repeat(np.arange(len(edge)), looks)
        ahead = np.cumsum(looks) - looks
        look = np.arange(len(row)) - ahead[row]
        for middle in (True, False):  # most edges that are none are blocked half-way between two poses already
            chosen = np.flatnonzero(((look == looks[row] // 2) == middle) & result[edge[row]])
            if not len(chosen):
                break
            poses = lower[row[chosen]] + ((look[chosen] + 1) / looks[row[chosen]])[:, None] * steps[edge[row[chosen]]]
            clear = self.free(poses)
            clear[clear] = ~poses_blocked(self.exact, poses[clear])
            result[edge[row[chosen[~clear]]]] = False
        return result

    def _moved(self, poses: Array, others: Array) -> Array:
        """How far `(poses,)` the farthest moving point gets from one pose to the other."""
        kinematics, points = self.geometry.kinematics, self.geometry.points
        both = points.placed(kinematics.frames(np.concatenate([poses, others])[None]))[:, :, 0]
        apart = np.linalg.norm(both[..., : len(poses)] - both[..., len(poses) :], axis=1)
        return np.asarray(apart.max(axis=0, initial=0.0))

    def _spare(self, poses: Array, most: float) -> Array:
        """How much more clearance `(poses,)` there is at least than is required, at most `most`."""
        result = np.full(len(poses), most)
        for found in close(self.geometry, poses[None], most + PATH_MARGIN):
            np.minimum.at(result, found.time, found.clearance - REQUIRED[found.kind] - PATH_MARGIN)
        if self.exact.wholes:
            result = np.minimum(result, wholes_spare(self.exact, poses, most))
        return result


def _steps(way: Array) -> Indices:
    """In how many steps edges `(m, joints)` are looked at."""
    return np.asarray(np.maximum(2, np.ceil(np.abs(way).max(axis=1) / PHASES.edge_resolution)).astype(np.intp))


class _Tree:
    """Poses that can be reached from a root, first of all by `ways` from it."""

    def __init__(self, root: Array, ways: Sequence[Array]) -> None:
        self.poses = root[None]
        self.parents = [-1]
        for way in ways:
            first = len(self.poses)
            self.add(way, np.array([0, *range(first, first + len(way) - 1)]))

    def nearest(self, poses: Array) -> Indices:
        """Of each pose `(m, joints)` the nearest node `(m,)`."""
        return np.asarray(((self.poses - poses[:, None]) ** 2).sum(axis=2).argmin(axis=1))

    def add(self, poses: Array, parents: Indices) -> Indices:
        """The numbers `(m,)` of new nodes."""
        self.poses = np.concatenate([self.poses, poses])
        self.parents += parents.tolist()
        return np.arange(len(self.poses) - len(poses), len(self.poses))

    def branch(self, index: int) -> list[int]:
        """The nodes from one to the root."""
        found = []
        while index >= 0:
            found.append(index)
            index = self.parents[index]
        return found

    def drop(self, nodes: Sequence[int]) -> None:
        """Put some nodes, and what hangs on them, where nothing is near."""
        gone = set(nodes)
        for node in range(min(gone), len(self.parents)) if gone else ():
            if node in gone or self.parents[node] in gone:
                gone.add(node)
                self.poses[node] = OUT_OF_SIGHT


def _samples(space: Space, tree: _Tree, random: np.random.Generator) -> Array:
    """Poses `(edges, joints)` around those of the tree, or anywhere in the box that it has reached and somewhat beyond:
    limits of what drives are often far wider than the rooms in which it drives."""
    reached = tree.poses[tree.poses[:, 0] < OUT_OF_SIGHT]
    low = np.maximum(space.lower, reached.min(axis=0) - PHASES.beyond_reached)
    high = np.minimum(space.upper, reached.max(axis=0) + PHASES.beyond_reached)
    around = tree.poses[random.integers(len(tree.poses), size=PHASES.edges)]
    around = np.clip(around + random.normal(0.0, PHASES.spread, around.shape), space.lower, space.upper)
    near = random.random((PHASES.edges, 1)) < PHASES.around
    return space.near(np.where(near, around, random.uniform(low, high, around.shape)))


def connect(
    space: Space, start: Array, end: Array, random: np.random.Generator, budget: Budget, rounds: int,
    sound: Callable[[Array], NDArray[np.bool_]] | None = None,
) -> Array | None:  # fmt: skip
    """A free polyline `(poses, joints)` from start to end, or None after so many rounds. `sound` tells of a
    way that was found which of its edges are free, looked at closely: what hangs on others is dropped."""
    trees = [_Tree(root, space.ways(root)) for root in (start, end)]
    for number in range(rounds):
        budget.check()
        own, other = trees[number % 2], trees[1 - number % 2]
        goals = _samples(space, own, random)
        parents = own.nearest(goals)
        way = goals - own.poses[parents]
        way *= np.minimum(1.0, PHASES.edge_stride / np.maximum(np.abs(way).max(axis=1), 1e-9))[:, None]
        reached, _ = space.advance(own.poses[parents], own.poses[parents] + way)
        far = np.abs(reached - own.poses[parents]).max(axis=1) >= PHASES.shortest_edge
        if not far.any():
            continue
        nodes = own.add(reached[far], parents[far])
        partners = other.nearest(own.poses[nodes])
        back, met = space.advance(other.poses[partners], own.poses[nodes])
        if met.any():
            pairs = zip(nodes[met].tolist(), partners[met].tolist(), strict=True)
            ways = [(own.branch(node), other.branch(partner)) for node, partner in pairs]
            lines = [np.concatenate([own.poses[one[::-1]], other.poses[two]]) for one, two in ways]
            best = min(range(len(lines)), key=lambda k: _length(lines[k]))
            free = None if sound is None else sound(lines[best])
            if free is None or free.all():
                return lines[best] if number % 2 == 0 else lines[best][::-1]
            _drop_unsound(*ways[best], (own, other), free)
            continue
        far = np.abs(back - other.poses[partners]).max(axis=1) >= PHASES.shortest_edge
        other.add(back[far], partners[far])
    return None


def _drop_unsound(own: list[int], other: list[int], trees: tuple[_Tree, _Tree], free: NDArray[np.bool_]) -> None:
    """Of a way from the root of a tree over a node of it, `own` from there to the root, to one of the other tree, and
    on to the root of that: what hangs on edges that are not `free` is dropped from the trees."""
    edges = free.tolist()
    trees[0].drop([child for child, clear in zip(own[-2::-1], edges, strict=False) if not clear])
    trees[1].drop([child for child, clear in zip(other[:-1], edges[len(own) :], strict=False) if not clear])


def _length(line: Array) -> float:
    return float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())


def _lengths(line: Array) -> Array:
    """How long a polyline is up to each of its poses."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])


def _along(line: Array, at: Array) -> Array:
    """Poses `(m, joints)` at shares `(m,)` of the length of a polyline."""
    lengths = _lengths(line)
    return np.stack([np.interp(at * lengths[-1], lengths, line[:, j]) for j in range(line.shape[1])], axis=1)


def shorten(
    space: Space, lines: list[Array], random: np.random.Generator,
    sound: Callable[[Array, Array], NDArray[np.bool_]] | None = None,
) -> list[Array]:  # fmt: skip
    """Polylines with a corner cut where a straight edge is free: of some random ones that which saves most, and, looked
    at closely, is `sound`."""
    shares = np.sort(random.uniform(0.0, 1.0, (len(lines), PHASES.cuts_at_once, 2)), axis=2)
    ends = np.array([_along(line, s.reshape(-1)) for line, s in zip(lines, shares, strict=True)])
    first, second = ends[:, 0::2], ends[:, 1::2]
    width = first.shape[2]
    free = space.advance(first.reshape(-1, width), second.reshape(-1, width))[1].reshape(first.shape[:2])
    result = []
    for k, line in enumerate(lines):
        cut = [(c, _cut(line, shares[k, c], first[k, c], second[k, c])) for c in np.flatnonzero(free[k])]
        saving = sorted((_length(shorter), n) for n, (_, shorter) in enumerate(cut) if _length(shorter) < _length(line))
        for n in (n for _, n in saving):
            c, shorter = cut[n]
            if sound is None or sound(first[k, c][None], second[k, c][None]).all():
                line = shorter
                break
        result.append(line)
    return result


def _cut(line: Array, shares: Array, first: Array, second: Array) -> Array:
    """The polyline with a straight edge between two of its poses, at shares `(2,)` of its length."""
    lengths = _lengths(line)
    before, after = lengths < shares[0] * lengths[-1], lengths > shares[1] * lengths[-1]
    return np.concatenate([line[before], [first, second], line[after]])


def resample(line: Array, slices: int) -> Array:
    """Inner slices `(slices - 1, joints)` along a polyline, slow at both ends."""
    share = np.arange(1, slices) / slices
    return _along(line, share * share * (3.0 - 2.0 * share))


def _connected(
    checker: _Checker, start: Array, end: Array, random: np.random.Generator, budget: Budget, rounds: int
) -> Array | None:
    """As `connect`. Most of the time would go into close looks at edges that no way takes: trees grow without them, and
    lose what hangs on edges of a way that was found that are not free. The next way shares most edges with it."""
    known: dict[bytes, bool] = {}

    def sound(line: Array) -> NDArray[np.bool_]:
        edges = [edge.tobytes() for edge in np.stack([line[:-1], line[1:]], axis=1)]
        new = np.array([edge not in known for edge in edges])
        found = checker.sound(line[:-1][new], line[1:][new]).tolist() if new.any() else []
        known.update(zip([edges[k] for k in np.flatnonzero(new)], found, strict=True))
        return np.array([known[edge] for edge in edges])

    return connect(checker, start, end, random, budget, rounds, sound)


def sampled_starts(
    batch: Batch, phase: int, random: np.random.Generator, budget: Budget, rounds: int, cuts: Sequence[int]
) -> list[Array]:
    """Starts `(slices - 1, joints)` for one phase along a sampled free polyline, each after so many rounds of cuts;
    none when an end is not free or nothing was found in so many rounds."""
    checker = _Checker(batch, phase)
    start, end = batch.start[phase], batch.end[phase]
    if not checker.free(np.stack([start, end])).all():
        return []
    line = _connected(checker, start, end, random, budget, rounds)
    if line is None:
        return []
    return _cut_down(checker, line, random, budget, cuts, checker.sound)


def straighter_starts(
    batch: Batch, phase: int, line: Array, random: np.random.Generator, budget: Budget, cuts: Sequence[int]
) -> list[Array]:
    """Starts as those, along a polyline `(poses, joints)` that is known to be free; its cuts are not looked at between
    poses."""
    return _cut_down(_Checker(batch, phase), line, random, budget, cuts)


def _cut_down(
    checker: _Checker, line: Array, random: np.random.Generator, budget: Budget, cuts: Sequence[int],
    sound: Callable[[Array, Array], NDArray[np.bool_]] | None = None,
) -> list[Array]:  # fmt: skip
    lines = [line] * len(cuts)
    for number in range(max(cuts)):
        budget.check()
        left = [k for k, most in enumerate(cuts) if number < most]
        for k, shorter in zip(left, shorten(checker, [lines[k] for k in left], random, sound), strict=True):
            lines[k] = shorter
    return [resample(line, checker.batch.slices) for line in lines]
