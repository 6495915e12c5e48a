"""The moving spheres of phases of one structure, and what they can meet: obstacles, each other, whole shapes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .....compiler.ir import ShapeKind, World
from .....compiler.motion.collision import PATH_MARGIN, PhaseContacts
from ....geometry.signed_distances import Shapes
from .batch_kinematics import BatchKinematics, Indices, Points
from .collision_spheres import Ball, Lineage, Meetings, balls_around, moving_balls, obstacles_near
from .contact_margins import NEVER, Kinds, cross_kinds
from .exact_check import PhaseParts, phase_parts
from .joint_forest import PhaseTree
from .pair_groups import PairGroups
from .resting_shapes import Obstacle


@dataclass(slots=True)
class Part:
    """The geometry of one phase before phases are stacked: moving spheres, pairs of them `(pairs, 2)`, obstacles, and
    moving shapes that spheres meet as they are."""

    tree: PhaseTree
    balls: tuple[Ball, ...]
    pairs: Indices
    obstacles: list[Obstacle]

    @property
    def structure(self) -> tuple[object, ...]:
        """Phases with equal structures can be stacked."""
        tree = self.tree
        joints = tuple(zip(tree.parents, tree.kinds, tree.signs, tree.columns, strict=True))
        balls = tuple((b.node, round(b.radius, 9), b.exact) for b in self.balls), tuple(_owners(self.balls))
        return joints, balls, self.pairs.tobytes()


def _owners(balls: Sequence[Ball]) -> list[int]:
    """The modules and bodies of spheres, numbered in the order in which they come first."""
    numbers: dict[str, int] = {}
    return [numbers.setdefault(b.owner, len(numbers)) for b in balls]


def make_parts(tree: PhaseTree, world: World) -> tuple[Part, PhaseParts]:
    """What the optimiser sees of a phase: spheres; and the true shapes, which accept its path, and of which it sees
    those, too, that would take many spheres."""
    lineage = Lineage(tree)
    balls = moving_balls(tree, world, PATH_MARGIN)
    near = obstacles_near(tree, lineage, (*balls, *balls_around(tree, world)), 2 * PATH_MARGIN)
    seen = [o for o in near if o.shape.kind != ShapeKind.CONVEX]
    pairs = Meetings(lineage, balls).pairs()
    return Part(tree, balls, pairs, seen), phase_parts(lineage, world, near)


class Geometry:
    """Phases of one structure. `obstacle_kinds`
    `(spheres, obstacles, phases)`, `pair_kinds` `(pairs, phases)` and one of `whole_kinds` per whole shape
    `(spheres, phases)` tell how much of the margin holds, as in `shares`."""

    def __init__(self, parts: Sequence[Part], contacts: Sequence[PhaseContacts], world: World) -> None:
        self.parts = list(parts)
        self.kinematics = BatchKinematics([p.tree for p in parts])
        self.points = Points([p.balls for p in parts])
        balls = parts[0].balls
        self.radius = np.array([b.radius for b in balls])[:, None, None]
        above = Lineage(parts[0].tree).above
        self.moved_by = above[[b.node + 1 for b in balls]]
        self.pairs = parts[0].pairs
        self.touching = (self.radius[self.pairs[:, 0]] + self.radius[self.pairs[:, 1]]) if balls else self.radius
        number = np.zeros(len(balls), np.intp)
        for group, (_, mine, _) in enumerate(self.points.groups):
            number[mine] = group
        self.groups = PairGroups(self.pairs, number)
        """The pairs by the nodes that carry their spheres."""
        count = max(len(p.obstacles) for p in parts)
        self.shapes = Shapes([
            [(o.shape, o.pose) for o in p.obstacles] + [None] * (count - len(p.obstacles)) for p in parts
        ])
        self._set_kinds(contacts, count)

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

    def ignore_collisions(self) -> None:
        """Let everything pass through everything."""
        self.obstacle_kinds[...] = NEVER
        self.pair_kinds[...] = NEVER

    def take(self, index: Indices) -> Geometry:
        """The geometry of some of the phases, possibly repeated."""
        result = object.__new__(Geometry)
        result.parts = [self.parts[i] for i in index]
        result.kinematics, result.points = self.kinematics.take(index), self.points.take(index)
        result.radius, result.moved_by, result.pairs = self.radius, self.moved_by, self.pairs
        result.touching, result.shapes = self.touching, self.shapes.take(index)
        result.groups = self.groups
        result.obstacle_kinds = self.obstacle_kinds[:, :, index]
        result.pair_kinds = self.pair_kinds[:, index]
        return result
