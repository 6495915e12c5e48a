"""Where the parts of everything that moves are in a motion program, and how they move with its unknowns.

A part is known by its anchors, points fixed to it: the centre of a sphere, the ends of a capsule's axis, of others the
origin and a point on each axis. They come from one stage Function per module type.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .....compiler.extents import box_sides
from .....compiler.ir import Problem, Shape, ShapeKind, Vec3
from .....compiler.module_parts import ModulePart, module_parts
from .....compiler.motion.collision import pose_matrix
from .....compiler.motion.constraints import frame_stage, sphere_stage
from .....compiler.motion.stages import PlacedBatch, Stage
from ....geometry.exact_distances import ROUND, Forms, Posed
from ....skeleton import Array
from ..nlp.unknowns import Indices, UnknownsLayout
from .broad_phase import Edges
from .settings import COLLISION


def anchors(part: ModulePart) -> list[Vec3]:
    """The anchors of a part in the moving frame of its joint."""
    frame = pose_matrix(part.placement)
    origin, axes = frame[:3, 3], frame[:3, :3].T
    if part.shape.kind == ShapeKind.SPHERE:
        points = [origin]
    elif part.shape.kind == ShapeKind.CAPSULE:
        points = [origin - part.shape.size[1] / 2 * axes[2], origin + part.shape.size[1] / 2 * axes[2]]
    else:
        points = [origin, *(origin + COLLISION.anchor_arm * axis for axis in axes)]
    return [(float(x), float(y), float(z)) for x, y, z in points]


class _Block:
    """All slots of one kind of thing: what its parts are, and the numbers that they have in each slot."""

    def __init__(self, stage: Stage, frames: Stage, parts: Sequence[ModulePart]) -> None:
        """`stage` finds the anchors, `frames` the centres and rotations of the parts."""
        self.stage, self.parts = stage, parts
        counts = [len(anchors(p)) for p in parts]
        first = np.cumsum([0, *counts[:-1]]) if parts else np.zeros(0, dtype=np.int64)
        chosen = [[f + min(k, n - 1) for k in range(COLLISION.anchors)] for f, n in zip(first, counts, strict=True)]
        self.anchors = np.array(chosen, dtype=np.int64).reshape(-1, COLLISION.anchors)
        self._frames = frames
        self._placed: PlacedBatch | None = None
        self.slots: list[Indices] = []
        self._numbers: list[int] = []
        self._tables = (np.zeros((0, stage.inputs), dtype=np.int64), np.zeros((0, len(parts)), dtype=np.int64))

    def add(self, slot: Indices, number: int) -> None:
        """Take in a slot, whose parts have numbers from `number` on."""
        self.slots.append(slot)
        self._numbers.append(number)
        self._placed = None

    @property
    def places(self) -> Indices:
        """The places (N, n) in z of all slots."""
        return self._filled()[0]

    @property
    def numbers(self) -> Indices:
        """The numbers (N, P) of all parts."""
        return self._filled()[1]

    def _filled(self) -> tuple[Indices, Indices]:
        if len(self._tables[0]) < len(self.slots):
            self._tables = (np.array(self.slots), np.array(self._numbers)[:, None] + np.arange(len(self.parts)))
        return self._tables

    def place(self, z: Array, position: Array, rotation: Array) -> None:
        """Enter where the parts are: their centres (…, 3) and rotations (…, 3, 3) at their numbers."""
        if self._placed is None:
            self._placed = self._frames.placed("values", self.places, np.zeros((len(self.slots), 0)))
        found = self._placed(z).reshape(len(self.slots), -1, 12)
        position[self.numbers] = found[:, :, :3]
        rotation[self.numbers] = found[:, :, 3:].reshape(*found.shape[:2], 3, 3)


class Cloud:
    """The parts of all slots that take part, numbered in the order in which slots are first asked for."""

    def __init__(self, problem: Problem, layout: UnknownsLayout) -> None:
        self.problem = problem
        self.layout = layout
        self.count = 0
        self.width = max([7 + len(m.type.joints) for m in problem.world.modules.values()], default=7)
        self._blocks: dict[str, _Block] = {}
        self._first: dict[int, int] = {}
        self._where: list[tuple[int, int, int]] = []
        self._shapes: list[Shape] = []
        self._last: tuple[Array, Posed] | None = None
        self._finished: tuple[Forms, Indices, Array] | None = None
        self._shared: tuple[Array, Array] | None = None

    def _block(self, name: str) -> _Block:
        world = self.problem.world
        module = world.modules.get(name)
        key = f"module {module.type.name}" if module else f"body {name}"
        if key not in self._blocks:
            parts = self.parts(name)
            points = tuple((part.joint, point) for part in parts for point in anchors(part))
            type_ = module.type if module else None
            frames = frame_stage(type_, tuple((part.joint, part.placement) for part in parts))
            self._blocks[key] = _Block(sphere_stage(type_, points), frames, parts)
        return self._blocks[key]

    def parts(self, name: str) -> Sequence[ModulePart]:
        """The parts of a module or body."""
        module = self.problem.world.modules.get(name)
        if module is None:
            return [ModulePart(-1, p.placement, p.shape) for p in self.problem.world.bodies[name].shape.solids]
        return module_parts(module.type)

    def first(self, slice_: int, name: str) -> int:
        """The number of the first part of one slot; those of the others follow."""
        offset = self.layout.slices[slice_][name]
        if offset not in self._first:
            block = self._block(name)
            number = list(self._blocks.values()).index(block)
            self._where += [(number, len(block.slots), i) for i in range(len(block.parts))]
            block.add(self.layout.slot(slice_, name), self.count)
            self._shapes += [part.shape for part in block.parts]
            self._first[offset] = self.count
            self.count += len(block.parts)
            self._finished = self._last = self._shared = None
        return self._first[offset]

    def _tables(self) -> tuple[Forms, Indices, Array]:
        """The forms, where each part is (block, slot, part), and half the sides of the boxes around the parts."""
        if self._finished is None:
            where = np.array(self._where, dtype=np.int64).reshape(-1, 3)
            half = np.array([box_sides(s) for s in self._shapes]).reshape(-1, 3) / 2
            self._finished = Forms(self._shapes), where, half
        return self._finished

    @property
    def forms(self) -> Forms:
        return self._tables()[0]

    def posed(self, z: Array) -> Posed:
        """All parts where they are at z."""
        if self._last is None or not (self._last[0] is z or np.array_equal(self._last[0], z)):
            position, rotation = np.zeros((self.count, 3)), np.zeros((self.count, 3, 3))
            for block in self._blocks.values():
                if block.slots:
                    block.place(z, position, rotation)
            self._last = z, Posed(self.forms, np.arange(self.count), position, rotation)
        return self._last[1]

    def edges(self, z: Array) -> Edges:
        """Least and greatest coordinates of all parts."""
        posed, half = self.posed(z), self._tables()[2]
        around = np.einsum("nij,nj->ni", np.abs(posed.rotation), half)
        ball = posed.forms.kind == ROUND
        around[ball] = np.abs(posed.axis[ball]) + posed.radius[ball, None]
        return posed.position - around, posed.position + around

    def places(self, numbers: Indices) -> Indices:
        """Places in z (len, width) of the slots of some parts; a short slot repeats place 0, which is constant or
        carries a zero derivative."""
        where = self._tables()[1][numbers]
        result = np.zeros((len(numbers), self.width), dtype=np.int64)
        for i, block in enumerate(self._blocks.values()):
            mine = np.flatnonzero(where[:, 0] == i)
            if len(mine):
                result[mine, : block.stage.inputs] = block.places[where[mine, 1]]
        return result

    def shares(self, numbers: Indices, points: Array, posed: Posed) -> Array:
        """The shares (len, anchors) that anchors have in points (len, 3) fixed to some parts."""
        least, turn = self._shares
        local = ((points - posed.position[numbers])[:, None, :] @ posed.rotation[numbers]) @ turn[numbers]
        return np.asarray(least[numbers] + local[:, 0])

    @property
    def _shares(self) -> tuple[Array, Array]:
        """The shares (P, anchors) that the anchors of parts have in their centres, and how these change (P, 3, anchors)
        with what lies elsewhere in their frames: of round ones on the axis."""
        if self._shared is None:
            least, turn = np.zeros((self.count, COLLISION.anchors)), np.zeros((self.count, 3, COLLISION.anchors))
            round_, half = self.forms.kind == ROUND, self.forms.half[:, 2]
            long = round_ & (half > 0.0)
            least[:, 0], least[long, 0], least[long, 1] = 1.0, 0.5, 0.5
            turn[long, 2, 1] = 0.5 / half[long]
            for axis in range(3):
                turn[~round_, axis, axis + 1] = 1.0 / COLLISION.anchor_arm
            turn[:, :, 0] = -turn[:, :, 1:].sum(axis=2)
            self._shared = least, turn
        return self._shared

    def slopes(self, z: Array, numbers: Indices, shares: Array, pulls: Array) -> Array:
        """Derivatives (len, width) by their slots of pull (len, 3) · point, for points that are made of the anchors of
        parts by shares."""
        where = self._tables()[1][numbers]
        result = np.zeros((len(numbers), self.width))
        weights = (shares[:, :, None] * pulls[:, None, :]).reshape(len(numbers), 1, 3 * COLLISION.anchors)
        for i, block in enumerate(self._blocks.values()):
            mine = (where[:, 0] == i).nonzero()[0]
            if len(mine):
                slot, places, inputs = where[mine, 1], block.places, block.stage.inputs
                if len(mine) < len(places):
                    used, slot = np.unique(slot, return_inverse=True)
                    places = places[used]
                jacobian = block.stage.jacobians(z[places], np.zeros((len(places), 0)))
                local = jacobian.reshape(len(places), -1, 3, inputs)[slot[:, None], block.anchors[where[mine, 2]]]
                result[mine, :inputs] = (weights[mine] @ local.reshape(len(mine), -1, inputs))[:, 0]
        return result

    def curvature(self, z: Array, ends: Sequence[tuple[Indices, Array, Array]]) -> list[tuple[Array, Indices]]:
        """Hessians, by slot, of the sum of pull (N, 3) · point over `ends`: numbers (N,), shares and pulls."""
        numbers, shares, pulls = (np.concatenate(column) for column in zip(*ends, strict=True))
        where = self._tables()[1][numbers]
        found = []
        for i, block in enumerate(self._blocks.values()):
            mine = np.flatnonzero(where[:, 0] == i)
            if len(mine):
                places = block.places
                weights = np.zeros((len(places), int(block.anchors.max(initial=-1)) + 1, 3))
                at = (np.repeat(where[mine, 1], COLLISION.anchors), block.anchors[where[mine, 2]].ravel())
                np.add.at(weights, at, (shares[mine, :, None] * pulls[mine, None, :]).reshape(-1, 3))
                flat = weights.reshape(len(places), -1)
                found.append((block.stage.hessians(z[places], np.zeros((len(places), 0)), flat), places))
        return found
