"""Clearances of the moving spheres of phases of one structure: to obstacles, among themselves, to carried bodies."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ....compiler.ir import World
from ....compiler.motion.collision import CHECK_MARGIN, PATH_MARGIN, PhaseContacts, bounding_radius
from ...skeleton import Array
from .balls import Ball, Lineage, meeting_pairs, moving_balls, obstacles_near
from .kinematics import Frame, Indices, Kinematics, Points
from .shapes import Shapes, half_sizes, rounded_box_distance
from .shares import NEVER, START, Kinds, cross_kinds
from .tree import Obstacle, PhaseTree

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


def make_part(lineage: Lineage, world: World, margin: float, exact_bodies: bool) -> Part:
    """The geometry of a phase with spheres that cover within `margin`. With `exact_bodies`, other spheres meet the
    true shapes of carried bodies and not their spheres."""
    tree = lineage.tree
    balls = moving_balls(tree, world, margin)
    near = obstacles_near(tree, lineage, balls, 2 * margin)
    pairs = meeting_pairs(lineage, balls, not exact_bodies)
    carried = tuple((name, _meets_body(tree, lineage, balls, name)) for name in tree.bodies) if exact_bodies else ()
    return Part(tree, balls, pairs, near, carried)


def make_parts(tree: PhaseTree, world: World) -> tuple[Part, Part]:
    """What the optimiser sees of a phase, and what accepts its path."""
    lineage = Lineage(tree)
    return make_part(lineage, world, PATH_MARGIN, False), make_part(lineage, world, CHECK_MARGIN, True)


def _meets_body(tree: PhaseTree, lineage: Lineage, balls: tuple[Ball, ...], name: str) -> tuple[int, ...]:
    """The spheres that can meet a carried body: those that some joint moves against it."""
    node = tree.bodies[name][0] + 1
    index = [b.node + 1 for b in balls]
    moved = (lineage.above[index] ^ lineage.above[node]).any(axis=1)
    return tuple(k for k, b in enumerate(balls) if moved[k] and b.owner != name)


@dataclass(slots=True)
class _Carried:
    """One carried body per phase: the spheres that can meet it, its node and pose there `(phases, 4, 4)`, its shape as
    in `shapes`, and the radius `(phases,)` of the sphere around it."""

    meets: Indices
    node: int
    local: Array
    half: Array
    rounding: Array
    turned: NDArray[np.bool_]
    extent: Array

    def take(self, index: Indices) -> _Carried:
        return _Carried(
            self.meets, self.node, self.local[index],
            self.half[:, index], self.rounding[index], self.turned[index], self.extent[index],
        )  # fmt: skip

    def distance_at(self, axes: Array, away: Array, phase: Indices) -> Array:
        """Signed distances `(m, times)` to the body in some phases `(m,)`, of points `(m, 3, times)` away from its
        origin; its axes are `(axes, 3, phases, times)`."""
        local = np.einsum("jimt,mit->mjt", axes[:, :, phase], away)[:, :, None]
        half = self.half[:, phase].transpose(1, 0, 2)[:, :, None]
        return np.asarray(rounded_box_distance(local, half, self.turned[phase, None])[0][:, 0] - self.rounding[phase])


class Geometry:
    """Phases of one structure. `obstacle_kinds` `(spheres, obstacles, phases)`, `pair_kinds` `(pairs, phases)` and one
    of `body_kinds` per carried body `(spheres, phases)` tell how much of the margin holds, as in `shares`."""

    def __init__(self, parts: Sequence[Part], contacts: Sequence[PhaseContacts], world: World) -> None:
        self.parts = list(parts)
        self.kinematics = Kinematics([p.tree for p in parts])
        self.points = Points([p.balls for p in parts])
        balls = parts[0].balls
        self.radius = np.array([b.radius for b in balls])[:, None, None]
        self.exact = np.array([b.exact for b in balls], dtype=np.intp)
        above = Lineage(parts[0].tree).above
        self.moved_by = above[[b.node + 1 for b in balls]]
        self.pairs = np.array(parts[0].pairs, dtype=int).reshape(-1, 2)
        self.touching = (self.radius[self.pairs[:, 0]] + self.radius[self.pairs[:, 1]]) if balls else self.radius
        count = max(len(p.obstacles) for p in parts)
        self.shapes = Shapes([
            [(o.shape, o.pose) for o in p.obstacles] + [None] * (count - len(p.obstacles)) for p in parts
        ])
        self._set_kinds(contacts, count)
        self._set_bodies(contacts, world)

    def _set_kinds(self, contacts: Sequence[PhaseContacts], count: int) -> None:
        spheres, phases = len(self.radius), len(self.parts)
        self.obstacle_kinds: Kinds = np.full((spheres, count, phases), NEVER, np.int8)
        self.pair_kinds: Kinds = np.empty((len(self.pairs), phases), np.int8)
        first, second = self.pairs.T
        for k, part in enumerate(self.parts):
            tags = [b.tag for b in part.balls]
            contact = contacts[part.tree.phase]
            self.obstacle_kinds[:, : len(part.obstacles), k] = cross_kinds(
                contact, tags, [o.tag for o in part.obstacles]
            )
            self.obstacle_kinds[[i for i, b in enumerate(part.balls) if b.node < 0], :, k] = NEVER
            self.pair_kinds[:, k] = cross_kinds(contact, tags, tags)[first, second]

    def _set_bodies(self, contacts: Sequence[PhaseContacts], world: World) -> None:
        self.bodies: list[_Carried] = []
        self.body_kinds: list[Kinds] = []
        for i, (_, meets) in enumerate(self.parts[0].carried):
            kinds = np.empty((len(meets), len(self.parts)), np.int8)
            mounts, halves, roundings, turned, extents = [], [], [], [], []
            for k, part in enumerate(self.parts):
                name = part.carried[i][0]
                tags = [part.balls[m].tag for m in meets]
                kinds[:, k] = cross_kinds(contacts[part.tree.phase], tags, [name])[:, 0]
                mounts.append(part.tree.bodies[name])
                half, rounding, is_turned = half_sizes(world.bodies[name].shape)
                halves.append(half)
                roundings.append(rounding)
                turned.append(is_turned)
                extents.append(bounding_radius(world.bodies[name].shape))
            self.bodies.append(_Carried(
                np.array(meets, dtype=np.intp), mounts[0][0], np.array([m[1] for m in mounts]),
                np.array(halves).T[:, :, None], np.array(roundings)[:, None], np.array(turned)[:, None],
                np.array(extents),
            ))
            self.body_kinds.append(kinds)

    def ignore_collisions(self) -> None:
        """Let everything pass through everything."""
        for kinds in (self.obstacle_kinds, self.pair_kinds, *self.body_kinds):
            kinds[...] = NEVER

    def take(self, index: Indices) -> Geometry:
        """The geometry of some of the phases, possibly repeated."""
        result = object.__new__(Geometry)
        result.parts = [self.parts[i] for i in index]
        result.kinematics, result.points = self.kinematics.take(index), self.points.take(index)
        result.radius, result.moved_by, result.pairs = self.radius, self.moved_by, self.pairs
        result.exact = self.exact
        result.touching, result.shapes = self.touching, self.shapes.take(index)
        result.obstacle_kinds = self.obstacle_kinds[:, :, index]
        result.pair_kinds = self.pair_kinds[:, index]
        result.bodies = [b.take(index) for b in self.bodies]
        result.body_kinds = [kinds[:, index] for kinds in self.body_kinds]
        return result

    def fading(self) -> Geometry:
        """Only the spheres that begin or end to touch an obstacle, and only against those."""
        result = copy.copy(self)
        kinds = np.where(self.obstacle_kinds >= START, self.obstacle_kinds, np.int8(NEVER))
        kept = np.flatnonzero((kinds != NEVER).any(axis=(1, 2)))
        result.obstacle_kinds, result.radius, result.exact = kinds[kept], self.radius[kept], self.exact[kept]
        result.moved_by, result.points = self.moved_by[kept], self.points.some(kept)
        result.pairs, result.touching = np.zeros((0, 2), int), np.zeros((0, 1, 1))
        result.pair_kinds, result.bodies, result.body_kinds = self.pair_kinds[:0], [], []
        return result

    def place(self, values: Array) -> tuple[Array, list[Frame]]:
        """The spheres' centres `(spheres, 3, phases, times)` and the node frames for joint values
        `(phases, times, joints)`."""
        frames, _, _ = self.kinematics.frames(values)
        return self.points.place(frames, *values.shape[:2]), frames

    def clearances(self, values: Array) -> tuple[Array, Array, list[Array]]:
        """Clearances for joint values `(phases, times, joints)`: of spheres to obstacles
        `(spheres, obstacles, phases, times)`, of pairs `(pairs, phases, times)`, and to each carried body
        `(spheres, phases, times)`."""
        points, frames = self.place(values)
        return *self.to_others(points), [self.to_body(points, frames, k) for k in range(len(self.bodies))]

    def to_others(self, points: Array) -> tuple[Array, Array]:
        """Clearances of placed spheres `(spheres, 3, phases, times)` to obstacles and among themselves."""
        obstacles = self.shapes.distance(points)[0] - self.radius[:, None]
        apart = points[self.pairs[:, 0]] - points[self.pairs[:, 1]]
        pairs = np.sqrt((apart * apart).sum(axis=1)) - self.touching
        return obstacles, pairs

    def body_frame(self, shape: tuple[int, ...], frames: list[Frame], k: int) -> tuple[Array, Array]:
        """Axes `(axes, 3, phases, times)` and origin `(3, phases, times)` of a carried body; `shape` is that of the
        origin."""
        body = self.bodies[k]
        frame = frames[body.node] if body.node >= 0 else WORLD
        carrier = np.stack([np.broadcast_to(a, shape) for a in frame])
        axes = np.einsum("kibt,bkj->jibt", carrier[:3], body.local[:, :3, :3])
        return axes, np.einsum("kibt,bk->ibt", carrier[:3], body.local[:, :3, 3]) + carrier[3]

    def to_body(self, points: Array, frames: list[Frame], k: int) -> Array:
        """Clearances `(spheres, phases, times)` of placed spheres to a carried body."""
        body = self.bodies[k]
        axes, origin = self.body_frame(points.shape[1:], frames, k)
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
