"""Clearances of the moving spheres of phases of one structure: to obstacles, among themselves, to carried bodies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ....compiler.ir import World
from ....compiler.motion.collision import CHECK_MARGIN, PATH_MARGIN, PhaseContacts, pair, taper
from ...skeleton import Array
from .balls import Ball, Lineage, meeting_pairs, moving_balls, obstacles_near
from .kinematics import Frame, Indices, Kinematics, Points
from .shapes import Shapes, half_sizes, rounded_box_distance
from .tree import Obstacle, PhaseTree

NEVER = -np.inf
WORLD: Frame = (*(np.eye(3)[k][:, None, None] for k in range(3)), np.zeros((3, 1, 1)))


@dataclass(slots=True)
class Part:
    """The geometry of one phase before phases are stacked: moving spheres, pairs of them, obstacles, carried
    bodies with the spheres that they can meet."""

    tree: PhaseTree
    balls: tuple[Ball, ...]
    pairs: tuple[tuple[int, int], ...]
    obstacles: list[Obstacle]
    carried: tuple[tuple[str, tuple[int, ...]], ...]

    @property
    def structure(self) -> tuple[object, ...]:
        """Phases with equal structures can be stacked."""
        tree = self.tree
        joints = tuple(zip(tree.parents, tree.kinds, tree.signs, strict=True))
        balls = tuple((b.node, round(b.radius, 9), b.exact) for b in self.balls)
        carried = tuple((tree.bodies[name][0], spheres) for name, spheres in self.carried)
        return joints, balls, self.pairs, carried


def make_part(tree: PhaseTree, world: World, margin: float, exact_bodies: bool) -> Part:
    """The geometry of a phase with spheres that cover within `margin`. With `exact_bodies`, other spheres meet the
    true shapes of carried bodies and not their spheres."""
    lineage = Lineage(tree)
    balls = moving_balls(tree, world, margin)
    near = obstacles_near(tree, lineage, balls, 2 * margin)
    pairs = meeting_pairs(lineage, balls, not exact_bodies)
    carried = tuple((name, _meets_body(tree, lineage, balls, name)) for name in tree.bodies) if exact_bodies else ()
    return Part(tree, balls, pairs, near, carried)


def make_parts(tree: PhaseTree, world: World) -> tuple[Part, Part]:
    """What the optimiser sees of a phase, and what accepts its path."""
    return make_part(tree, world, PATH_MARGIN, False), make_part(tree, world, CHECK_MARGIN, True)


def _meets_body(tree: PhaseTree, lineage: Lineage, balls: tuple[Ball, ...], name: str) -> tuple[int, ...]:
    """The spheres that can meet a carried body: those that some joint moves against it."""
    node = tree.bodies[name][0] + 1
    index = [b.node + 1 for b in balls]
    moved = (lineage.above[index] ^ lineage.above[node]).any(axis=1)
    return tuple(k for k, b in enumerate(balls) if moved[k] and b.owner != name)


def _shares(
    contact: PhaseContacts, first: Sequence[str | None], second: Sequence[str | None],
    times: Array, slices: int, out: Array,
) -> None:
    """Fill `out` `(first, second, times)` with the share of the margin that each two objects keep, or NEVER."""
    for a in {t for t in first if t is not None}:
        for b in {t for t in second if t is not None}:
            share = taper(contact, pair(a, b), times, slices)
            if share is None or share.min() < 1.0:
                rows = [k for k, t in enumerate(first) if t == a]
                columns = [k for k, t in enumerate(second) if t == b]
                out[np.ix_(rows, columns)] = NEVER if share is None else share


def _pair_shares(
    contact: PhaseContacts, tags: Sequence[str | None], pairs: Indices, times: Array, slices: int, out: Array
) -> None:
    """Fill `out` `(pairs, times)` likewise for pairs `(pairs, 2)` of spheres."""
    names = sorted({t for t in tags if t is not None})
    number = np.array([-1 if t is None else names.index(t) for t in tags], dtype=int)
    first, second = number[pairs].T
    for i, a in enumerate(names):
        for j, b in enumerate(names):
            share = taper(contact, pair(a, b), times, slices)
            if share is None or share.min() < 1.0:
                out[(first == i) & (second == j)] = NEVER if share is None else share


@dataclass(slots=True)
class _Carried:
    """One carried body per phase: the spheres that can meet it, its node and pose there `(phases, 4, 4)`, and its
    shape as in `shapes`."""

    meets: Indices
    node: int
    local: Array
    half: Array
    rounding: Array
    turned: NDArray[np.bool_]

    def take(self, index: Indices) -> _Carried:
        return _Carried(
            self.meets, self.node, self.local[index], self.half[:, index], self.rounding[index], self.turned[index]
        )


class Geometry:
    """Phases of one structure at given times. `obstacle_share` `(spheres, obstacles, phases, times)`, `pair_share`
    `(pairs, phases, times)` and one of `body_shares` per carried body `(spheres, phases, times)` tell which share of
    the margin holds: 1, less next to contacts, NEVER where two things touch or rest all the time."""

    def __init__(
        self, parts: Sequence[Part], contacts: Sequence[PhaseContacts], world: World, times: Array, slices: int
    ) -> None:
        self.parts = list(parts)
        self.kinematics = Kinematics([p.tree for p in parts])
        self.points = Points([p.balls for p in parts])
        balls = parts[0].balls
        self.radius = np.array([b.radius for b in balls])[:, None, None]
        self.exact = np.array([b.exact for b in balls])
        above = Lineage(parts[0].tree).above
        self.moved_by = above[[b.node + 1 for b in balls]]
        self.pairs = np.array(parts[0].pairs, dtype=int).reshape(-1, 2)
        self.touching = (self.radius[self.pairs[:, 0]] + self.radius[self.pairs[:, 1]]) if balls else self.radius
        count = max(len(p.obstacles) for p in parts)
        self.shapes = Shapes([
            [(o.shape, o.pose) for o in p.obstacles] + [None] * (count - len(p.obstacles)) for p in parts
        ])
        self._set_shares(contacts, count, times, slices)
        self._set_bodies(contacts, world, times, slices)

    def _set_shares(self, contacts: Sequence[PhaseContacts], count: int, times: Array, slices: int) -> None:
        spheres, phases = len(self.radius), len(self.parts)
        self.obstacle_share = np.ones((spheres, count, phases, len(times)))
        self.pair_share = np.ones((len(self.pairs), phases, len(times)))
        for k, part in enumerate(self.parts):
            tags = [b.tag for b in part.balls]
            contact = contacts[part.tree.phase]
            others = [o.tag for o in part.obstacles]
            _shares(contact, tags, others, times, slices, self.obstacle_share[:, :, k])
            self.obstacle_share[[i for i, b in enumerate(part.balls) if b.node < 0], :, k] = NEVER
            _pair_shares(contact, tags, self.pairs, times, slices, self.pair_share[:, k])

    def _set_bodies(self, contacts: Sequence[PhaseContacts], world: World, times: Array, slices: int) -> None:
        self.bodies: list[_Carried] = []
        self.body_shares: list[Array] = []
        for i, (_, meets) in enumerate(self.parts[0].carried):
            shares = np.ones((len(meets), len(self.parts), len(times)))
            mounts, halves, roundings, turned = [], [], [], []
            for k, part in enumerate(self.parts):
                name = part.carried[i][0]
                tags = [part.balls[m].tag for m in meets]
                _shares(contacts[part.tree.phase], tags, [name], times, slices, shares[:, None, k])
                mounts.append(part.tree.bodies[name])
                half, rounding, is_turned = half_sizes(world.bodies[name].shape)
                halves.append(half)
                roundings.append(rounding)
                turned.append(is_turned)
            self.bodies.append(_Carried(
                np.array(meets, dtype=np.intp), mounts[0][0], np.array([m[1] for m in mounts]),
                np.array(halves).T[:, :, None], np.array(roundings)[:, None], np.array(turned)[:, None],
            ))
            self.body_shares.append(shares)

    def ignore_collisions(self) -> None:
        """Let everything pass through everything."""
        for share in (self.obstacle_share, self.pair_share, *self.body_shares):
            share[...] = NEVER

    def take(self, index: Indices, columns: slice = slice(None)) -> Geometry:
        """The geometry of some of the phases, possibly repeated, with the shares at some of the times."""
        result = object.__new__(Geometry)
        result.parts = [self.parts[i] for i in index]
        result.kinematics, result.points = self.kinematics.take(index), self.points.take(index)
        result.radius, result.moved_by, result.pairs = self.radius, self.moved_by, self.pairs
        result.exact = self.exact
        result.touching, result.shapes = self.touching, self.shapes.take(index)
        result.obstacle_share = self.obstacle_share[:, :, index, columns]
        result.pair_share = self.pair_share[:, index, columns]
        result.bodies = [b.take(index) for b in self.bodies]
        result.body_shares = [s[:, index, columns] for s in self.body_shares]
        return result

    def place(self, values: Array) -> tuple[Array, list[Frame]]:
        """The spheres' centres `(spheres, 3, phases, times)` and the node frames for joint values
        `(phases, times, joints)`."""
        frames, _, _ = self.kinematics.frames(values)
        return self.points.place(frames, *values.shape[:2]), frames

    def clearances(self, values: Array) -> tuple[Array, Array, list[Array]]:
        """Clearances for joint values `(phases, times, joints)`, shaped as the shares."""
        points, frames = self.place(values)
        return *self.to_others(points), self.to_bodies(points, frames)

    def to_others(self, points: Array) -> tuple[Array, Array]:
        """Clearances of placed spheres `(spheres, 3, phases, times)` to obstacles and among themselves."""
        obstacles = self.shapes.distance(points)[0] - self.radius[:, None]
        apart = points[self.pairs[:, 0]] - points[self.pairs[:, 1]]
        pairs = np.sqrt((apart * apart).sum(axis=1)) - self.touching
        return obstacles, pairs

    def to_bodies(self, points: Array, frames: list[Frame]) -> list[Array]:
        """Clearances of placed spheres to each carried body."""
        return [self._to_body(points, frames, k) for k in range(len(self.bodies))]

    def _to_body(self, points: Array, frames: list[Frame], k: int) -> Array:
        body = self.bodies[k]
        frame = frames[body.node] if body.node >= 0 else WORLD
        carrier = np.stack([np.broadcast_to(a, points.shape[1:]) for a in frame])
        axes = np.einsum("kibt,bkj->jibt", carrier[:3], body.local[:, :3, :3])
        origin = np.einsum("kibt,bk->ibt", carrier[:3], body.local[:, :3, 3]) + carrier[3]
        offset = np.einsum("jibt,nibt->njbt", axes, points[body.meets] - origin)
        distance = rounded_box_distance(offset, body.half, body.turned)[0]
        return np.asarray(distance - body.rounding - self.radius[body.meets])

    def name_pair(self, phase: int, block: int, entry: tuple[int, ...]) -> tuple[str, str]:
        """The objects behind an entry of `clearances(…)[block]` (2 and above: bodies) in one of the phases."""
        part = self.parts[phase]
        ball = part.balls[entry[0]] if block == 0 else None
        if block == 0 and ball is not None:
            other = part.obstacles[entry[1]]
            return ball.tag or ball.owner, other.tag or other.owner
        if block == 1:
            a, b = (part.balls[i] for i in self.pairs[entry[0]])
            return a.tag or a.owner, b.tag or b.owner
        name, meets = part.carried[block - 2]
        ball = part.balls[meets[entry[0]]]
        return ball.tag or ball.owner, name
