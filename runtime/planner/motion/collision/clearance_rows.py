"""Collision rows: spheres that cover what moves against spheres and rounded boxes, in metres.

Centres come from one stage Function per module type; distances and their derivatives are plain array arithmetic, and
Jacobians are taken of rows that push only. A rounded box is all points within `radius` of a box: boxes, spheres and
capsules are such, cylinders are covered by spheres.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from .....compiler.hulls import slices
from .....compiler.ir import Body, Problem
from .....compiler.motion.collision import Sphere, body_spheres, module_spheres, pose_matrix
from .....compiler.motion.constraints import sphere_stage
from .....compiler.motion.distances import SMOOTH
from .....compiler.motion.stages import Stage
from ....skeleton import Array
from ..nlp.row_groups import Chosen, RowLabel
from ..nlp.unknowns import Indices, UnknownsLayout
from .broad_phase import NO_PAIRS, Blocks, Edges, Pairs

NEAR = 0.3
"""Metres: pairs closer than this at the start of a solve take part in it; the others are looked at afterwards."""

Solids = tuple[Array, Array, Array]
"""Rotations (3, 3, N), positions (3, N) and half sizes (3, N) of boxes, by coordinates."""


class _Block:
    """All slots of one kind, and the numbers of their spheres."""

    def __init__(self, stage: Stage, spheres: tuple[Sphere, ...]) -> None:
        self.stage = stage
        self.spheres = spheres
        self.slots: list[Indices] = []
        self._numbers: list[Indices] = []
        self._tables = (np.zeros((0, stage.inputs), dtype=np.int64), np.zeros(0, dtype=np.int64))

    def add(self, slot: Indices, numbers: Indices) -> None:
        """Take in a slot and the numbers of its spheres."""
        self.slots.append(slot)
        self._numbers.append(numbers)

    def tables(self) -> tuple[Indices, Indices]:
        """The places (N, n) of all slots, and the numbers (N · S,) of their spheres."""
        if len(self._tables[0]) < len(self.slots):
            self._tables = (np.array(self.slots), np.concatenate(self._numbers))
        return self._tables

    @property
    def places(self) -> Indices:
        return self.tables()[0]

    def centres(self, z: Array) -> tuple[Indices, Array]:
        places, numbers = self.tables()
        values = self.stage.values(z[places], np.zeros((len(places), 0)))
        return numbers, values.reshape(-1, 3)


class Cloud:
    """The spheres of all slots that take part, numbered in the order in which slots are first asked for."""

    def __init__(self, problem: Problem, layout: UnknownsLayout) -> None:
        self.problem = problem
        self.layout = layout
        self.count = 0
        self.width = max([7 + len(m.type.joints) for m in problem.world.modules.values()], default=7)
        self._blocks: dict[str, _Block] = {}
        self._first: dict[int, int] = {}
        self._radii: list[float] = []
        self._where: list[tuple[int, int, int]] = []
        self._last: tuple[Array, Array] | None = None
        self._finished: tuple[Array, Indices] | None = None

    def _block(self, name: str) -> _Block:
        world = self.problem.world
        module = world.modules.get(name)
        key = f"module {module.type.name}" if module else f"body {name}"
        if key not in self._blocks:
            spheres = module_spheres(module.type) if module else body_spheres(world.bodies[name])
            points = tuple((s.joint, s.centre) for s in spheres)
            self._blocks[key] = _Block(sphere_stage(module.type if module else None, points), spheres)
        return self._blocks[key]

    def owners(self, name: str) -> list[str]:
        """The object that each sphere of a module or body belongs to: an effector, or the thing itself."""
        return [f"{name}.{s.effector}" if s.effector else name for s in self._block(name).spheres]

    def first(self, slice_: int, name: str) -> int:
        """The number of the first sphere of one slot; those of the others follow."""
        offset = self.layout.slices[slice_][name]
        if offset not in self._first:
            block = self._block(name)
            count = len(block.spheres)
            number = list(self._blocks.values()).index(block)
            self._where += [(number, len(block.slots), i) for i in range(count)]
            block.add(self.layout.slot(slice_, name), np.arange(self.count, self.count + count))
            self._radii += [s.radius for s in block.spheres]
            self._first[offset] = self.count
            self.count += count
            self._finished = None
        return self._first[offset]

    def _tables(self) -> tuple[Array, Indices]:
        if self._finished is None:
            self._finished = (np.array(self._radii), np.array(self._where, dtype=np.int64).reshape(-1, 3))
        return self._finished

    @property
    def radii(self) -> Array:
        return self._tables()[0]

    def centres(self, z: Array) -> Array:
        """Centres (count, 3) of all spheres."""
        if self._last is None or self._last[0] is not z:
            centres = np.zeros((self.count, 3))
            for block in self._blocks.values():
                if block.slots:
                    numbers, values = block.centres(z)
                    centres[numbers] = values
            self._last = (z, centres)
        return self._last[1]

    def edges(self, z: Array) -> Edges:
        """Least and greatest coordinates of all spheres."""
        centres, radii = self.centres(z), self.radii[:, None]
        return centres - radii, centres + radii

    def places(self, numbers: Indices) -> Indices:
        """Places in z (len, width) of the slots of some spheres; a short slot repeats place 0, which is constant or
        carries a zero derivative."""
        where = self._tables()[1][numbers]
        result = np.zeros((len(numbers), self.width), dtype=np.int64)
        for i, block in enumerate(self._blocks.values()):
            mine = np.flatnonzero(where[:, 0] == i)
            if len(mine):
                result[mine, : block.stage.inputs] = block.places[where[mine, 1]]
        return result

    def derivatives(self, z: Array, numbers: Indices) -> Array:
        """Derivatives (len, 3, width) of some centres by their slots."""
        where = self._tables()[1][numbers]
        result = np.zeros((len(numbers), 3, self.width))
        for i, block in enumerate(self._blocks.values()):
            mine = np.flatnonzero(where[:, 0] == i)
            if len(mine):
                used = np.zeros(len(block.slots), dtype=np.bool_)
                used[where[mine, 1]] = True
                inverse = (np.cumsum(used) - 1)[where[mine, 1]]
                places = block.places[used]
                jacobian = block.stage.jacobians(z[places], np.zeros((len(places), 0)))
                local = jacobian.reshape(len(places), -1, 3, block.stage.inputs)
                result[mine, :, : block.stage.inputs] = local[inverse, where[mine, 2]]
        return result

    def curvature(self, z: Array, ends: Sequence[tuple[Indices, Array]]) -> list[tuple[Array, Indices]]:
        """Hessians, by slot, of the sum of pull (N, 3) · centre over `ends`: numbers (N,) and pulls."""
        numbers = np.concatenate([numbers for numbers, _ in ends])
        pulls = np.concatenate([pull for _, pull in ends])
        where = self._tables()[1][numbers]
        found = []
        for i, block in enumerate(self._blocks.values()):
            mine = np.flatnonzero(where[:, 0] == i)
            if len(mine):
                places = block.places
                weights = np.zeros((len(places), len(block.spheres), 3))
                np.add.at(weights, (where[mine, 1], where[mine, 2]), pulls[mine])
                flat = weights.reshape(len(places), -1)
                found.append((block.stage.hessians(z[places], np.zeros((len(places), 0)), flat), places))
        return found


class Obstacles:
    """Rounded boxes at rest."""

    def __init__(self) -> None:
        self.names: list[str] = []
        self._rotations: list[Array] = []
        self._positions: list[Array] = []
        self._halves: list[tuple[float, float, float]] = []
        self._radii: list[float] = []
        self._of: dict[tuple[str, int], Indices] = {}

    def add(self, body: Body, place: int, pose: Array) -> Indices:
        """The numbers of the rounded boxes that make up a body that rests at `pose`, which `place` stands for."""
        if (body.name, place) not in self._of:
            matrix = pose_matrix(pose)
            first = len(self.names)
            for centre, half, radius in self._parts(body):
                self.names.append(body.name)
                self._rotations.append(matrix[:3, :3])
                self._positions.append(matrix[:3, :3] @ np.array(centre) + matrix[:3, 3])
                self._halves.append(half)
                self._radii.append(radius)
            self._of[body.name, place] = np.arange(first, len(self.names))
        return self._of[body.name, place]

    @staticmethod
    def _parts(body: Body) -> list[tuple[tuple[float, float, float], tuple[float, float, float], float]]:
        size, origin = body.shape.size, (0.0, 0.0, 0.0)
        if body.shape.kind == "box":
            return [(origin, (size[0] / 2, size[1] / 2, size[2] / 2), 0.0)]
        if body.shape.kind == "sphere":
            return [(origin, origin, size[0])]
        if body.shape.kind == "capsule":
            return [(origin, (0.0, 0.0, size[1] / 2), size[0])]
        if body.shape.kind == "convex":
            return [(centre, half, 0.0) for centre, half in slices(body.shape)]
        return [(s.centre, origin, s.radius) for s in body_spheres(body)]

    def arrays(self) -> tuple[Array, Array, Array, Array]:
        """Rotations (B, 3, 3), positions (B, 3), half sizes (B, 3), radii (B,)."""
        return (
            np.array(self._rotations).reshape(-1, 3, 3), np.array(self._positions).reshape(-1, 3),
            np.array(self._halves).reshape(-1, 3), np.array(self._radii),
        )  # fmt: skip

    def edges(self) -> Edges:
        """Least and greatest coordinates of all rounded boxes."""
        rotations, positions, halves, radii = self.arrays()
        around = np.einsum("bij,bj->bi", np.abs(rotations), halves) + radii[:, None]
        return positions - around, positions + around


# --- rows ------------------------------------------------------------------------------------------------------


def _lengths(vectors: Array) -> Array:
    """Smooth lengths (N,) of vectors (N, 3)."""
    return np.asarray(np.sqrt(np.einsum("ij,ij->i", vectors, vectors) + SMOOTH))


def _length(squares: Array) -> Array:
    """Smooth lengths (N,) of vectors by the squares (3, N) of their coordinates."""
    total = squares[0] + squares[1]
    total += squares[2]
    total += SMOOTH
    return np.asarray(np.sqrt(total, out=total))


class ClearanceGroup:
    """Rows wanted distance − distance <= 0, between sphere `first` and sphere or rounded box `second`."""

    kind = "inequality"
    scale = 1.0

    def __init__(
        self, cloud: Cloud, obstacles: Obstacles | None, blocks: Blocks, label_of: Callable[[Indices], RowLabel]
    ) -> None:
        """`blocks` hold all pairs and the distances to keep between surfaces; `label_of` turns the tag of a pair into a
        label."""
        self.cloud = cloud
        self.boxes = obstacles.arrays() if obstacles else None
        self._edges = obstacles.edges() if obstacles else None
        self._blocks = blocks
        self.label_of = label_of
        self._use(NO_PAIRS)

    def _use(self, pairs: Pairs) -> None:
        self.pairs = pairs
        self.first, self.second, self.wanted = pairs.first, pairs.second, self._reached(pairs)
        parts = [self.cloud.places(self.first)]
        if not self.boxes:
            parts.append(self.cloud.places(self.second))
        self._places = np.concatenate(parts, axis=1)
        self._taken = self._solids(pairs.second)

    def _reached(self, pairs: Pairs) -> Array:
        """The distances to keep between centres and boxes, or centres."""
        radii = self.cloud.radii
        reach = radii[pairs.first] + (self.boxes[3] if self.boxes else radii)[pairs.second]
        return np.asarray(pairs.wanted + reach)

    def refresh(self, z: Array, near: float = NEAR) -> bool:
        """Let the pairs that are now closer than `near` beyond their wanted distance take part, besides those that
        already do. Returns whether one of the new ones is violated."""
        edges = self.cloud.edges(z)
        pairs, taking_part = self.pairs.joined(self._blocks.near(edges, self._edges or edges, near))
        value = self._reached(pairs) - self._distances(z, pairs.first, pairs.second, self._solids(pairs.second))
        close = taking_part | (value > -near)
        broken = bool((value[close & ~taking_part] > 1e-4).any())
        self._use(pairs[np.flatnonzero(close)])
        return broken

    def _distances(self, z: Array, first: Indices, second: Indices, solids: Solids | None) -> Array:
        """Signed distances (N,) from centres to boxes, or to centres. By coordinates, as sums over three numbers a row
        take longer than all else."""
        centres = self.cloud.centres(z)
        if solids is None:
            apart = centres.take(first, axis=0) - centres.take(second, axis=0)
            return _length(np.square(apart, out=apart).T)
        rotations, positions, halves = solids
        offset = np.ascontiguousarray(centres.take(first, axis=0).T)
        offset -= positions
        excess = rotations[0] * offset[0]
        excess += rotations[1] * offset[1]
        excess += rotations[2] * offset[2]
        np.abs(excess, out=excess)
        excess -= halves
        deep = np.minimum(np.maximum(np.maximum(excess[0], excess[1]), excess[2]), 0.0)
        np.maximum(excess, 0.0, out=excess)
        deep += _length(np.square(excess, out=excess))
        return np.asarray(deep)

    def _solids(self, second: Indices) -> Solids | None:
        if not self.boxes:
            return None
        rotations, positions, halves, _ = (part[second] for part in self.boxes)
        return rotations.transpose(1, 2, 0).copy(), positions.T.copy(), halves.T.copy()

    def _excess(self, centres: Array, first: Indices, second: Indices) -> tuple[Array, Array]:
        assert self.boxes is not None
        rotations, positions, halves, _ = self.boxes
        local = np.matmul((centres[first] - positions[second])[:, None, :], rotations[second])[:, 0]
        return np.abs(local) - halves[second], local

    def _directions(self, z: Array, first: Indices, second: Indices) -> Array:
        """Unit directions (N, 3) in which the distance grows when the first sphere moves."""
        centres = self.cloud.centres(z)
        if not self.boxes:
            difference = centres[first] - centres[second]
            return np.asarray(difference / _lengths(difference)[:, None])
        excess, local = self._excess(centres, first, second)
        outside = np.maximum(excess, 0.0)
        slope = outside / _lengths(outside)[:, None]
        deep = np.flatnonzero(excess.max(1) < 0)
        slope[deep, excess[deep].argmax(1)] = 1.0
        slope *= np.sign(local)
        return np.asarray(np.matmul(self.boxes[0][second], slope[:, :, None])[:, :, 0])

    @property
    def shape(self) -> tuple[int, int]:
        return len(self.first), 1

    def label(self, instance: int) -> RowLabel:
        return self.label_of(self.pairs.tags[instance])

    def residuals(self, z: Array) -> Array:
        values: Array = self.wanted - self._distances(z, self.first, self.second, self._taken)
        return values[:, None]

    def jacobians(self, z: Array, chosen: Chosen) -> tuple[Array, Indices]:
        first, second = self.first[chosen], self.second[chosen]
        direction = self._directions(z, first, second)[:, None, :]
        parts = [-np.matmul(direction, self.cloud.derivatives(z, first))]
        if not self.boxes:
            parts.append(np.matmul(direction, self.cloud.derivatives(z, second)))
        return np.concatenate(parts, axis=2), self._places[chosen]

    def curvature(self, z: Array, weights: Array) -> list[tuple[Array, Indices]]:
        """Of the centres, and of the distances by the centres."""
        chosen = np.flatnonzero(weights[:, 0])
        if not len(chosen):
            return []
        first, second, weight = self.first[chosen], self.second[chosen], weights[chosen, 0]
        pull = -weight[:, None] * self._directions(z, first, second)
        bend = -weight[:, None, None] * self._bends(z, first, second)
        motion = [self.cloud.derivatives(z, first)]
        ends = [(first, pull)]
        if not self.boxes:
            motion.append(-self.cloud.derivatives(z, second))
            ends.append((second, -pull))
        chain = np.concatenate(motion, axis=2)
        bent = np.matmul(chain.transpose(0, 2, 1), np.matmul(bend, chain))
        return [(bent, self._places[chosen]), *self.cloud.curvature(z, ends)]

    def _bends(self, z: Array, first: Indices, second: Indices) -> Array:
        """Second derivatives (N, 3, 3) of the distance by the first centre."""
        centres = self.cloud.centres(z)
        if not self.boxes:
            direction = self._directions(z, first, second)
            length = _lengths(centres[first] - centres[second])
            return np.asarray((np.eye(3) - direction[:, :, None] * direction[:, None, :]) / length[:, None, None])
        excess, local = self._excess(centres, first, second)
        outside = np.maximum(excess, 0.0)
        length = _lengths(outside)
        slope = outside / length[:, None] * np.sign(local)
        bend = -slope[:, :, None] * slope[:, None, :]
        bend[:, range(3), range(3)] += excess > 0
        rotation = self.boxes[0][second]
        return np.asarray(np.matmul(rotation, np.matmul(bend / length[:, None, None], rotation.transpose(0, 2, 1))))

    def span(self) -> Indices:
        return self._places
