"""The true shapes of what moves in phases of one structure, and the exact distances that accept or refuse a path."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .....compiler.extents import box_sides
from .....compiler.ir import Shape, ShapeKind, World
from .....compiler.module_parts import module_parts, own_pairs
from .....compiler.motion.collision import PhaseContacts, pose_matrix
from .....compiler.part_names import part_names
from .....langs.frozen import dataclass
from ....geometry.exact_distances import HULL, ROUND, Distances, Forms, Posed, distances
from ....skeleton import Array
from .batch_kinematics import BatchKinematics, Indices
from .collision_spheres import Lineage, seen_whole
from .contact_margins import NEVER, REQUIRED, Kinds, cross_kinds
from .joint_forest import PhaseTree
from .pair_groups import PairGroups
from .resting_shapes import Obstacle
from .settings import PHASES

NOTHING = Shape(ShapeKind.SPHERE, (0.0,))
OUT_OF_SIGHT = 1e9
"""Metres away: where missing obstacles are put."""


@dataclass(frozen=True, slots=True)
class MovingPart:
    """A shape at `local` `(4, 4)` in its node; `tag` is the effector or body that contacts name, None for a link. The
    optimiser sees it as it is where it is `whole`."""

    node: int
    local: Array
    shape: Shape
    owner: str
    tag: str | None
    name: str
    whole: bool


@dataclass(slots=True)
class PhaseParts:
    """What moves in a phase, the pairs `(pairs, 2)` of it that may not overlap, and what rests near."""

    tree: PhaseTree
    parts: tuple[MovingPart, ...]
    pairs: tuple[tuple[int, int], ...]
    obstacles: list[Obstacle]

    @property
    def structure(self) -> tuple[object, ...]:
        """Phases with equal structures can be stacked."""
        return tuple((p.node, p.whole) for p in self.parts), self.pairs


def phase_parts(lineage: Lineage, world: World, obstacles: list[Obstacle]) -> PhaseParts:
    """The true shapes of a phase. Parts of one module meet as `own_pairs` says, others when a joint moves them against
    each other."""
    tree = lineage.tree
    parts: list[MovingPart] = []
    pairs: list[tuple[int, int]] = []
    for module, links in tree.links.items():
        type_, first = world.modules[module].type, len(parts)
        pairs += [(first + i, first + k) for i, k, _ in own_pairs(type_)]
        own = module_parts(type_)
        tags = [f"{module}.{part.effector}" if part.effector else None for part in own]
        names = part_names(module, [tag or module for tag in tags])
        for part, tag, name in zip(own, tags, names, strict=True):
            node, local = links[part.joint]
            at, whole = local @ pose_matrix(part.placement), part.several or seen_whole(part.shape)
            parts.append(MovingPart(node, at, part.shape, module, tag, name, whole))
    for name, (node, local) in tree.bodies.items():
        if world.bodies[name].collides:
            shape = world.bodies[name].shape
            whole = seen_whole(shape)
            for solid in shape.solids:
                at = local @ pose_matrix(solid.placement)
                parts.append(MovingPart(node, at, solid.shape, name, name, name, whole))
    pairs += [
        (i, k) for k in range(len(parts)) for i in range(k) if parts[i].owner != parts[k].owner
    ]  # fmt: skip
    above = lineage.above
    moved = [(i, k) for i, k in pairs if (above[parts[i].node + 1] ^ above[parts[k].node + 1]).any()]
    return PhaseParts(tree, tuple(parts), tuple(moved), obstacles)


class ExactGeometry:
    """Phases of one structure. Per phase the `forms` of parts and obstacles; `obstacle_kinds` `(parts, obstacles,
    phases)` and `pair_kinds` `(pairs, phases)` are those of `contact_margins`."""

    def __init__(
        self, phases: Sequence[PhaseParts], contacts: Sequence[PhaseContacts], kinematics: BatchKinematics
    ) -> None:
        self.phases, self.kinematics = list(phases), kinematics
        parts = phases[0].parts
        self.nodes = np.array([p.node for p in parts], dtype=np.intp)
        self.pairs = np.array(phases[0].pairs, dtype=np.intp).reshape(-1, 2)
        owners: dict[str, int] = {}
        self.groups = PairGroups(
            self.pairs, np.array([owners.setdefault(p.owner, len(owners)) for p in parts], dtype=np.intp)
        )
        above = Lineage(phases[0].tree).above
        self.moved_by = above[self.nodes + 1]
        shapes: dict[Shape, int] = {NOTHING: 0}
        number = [[shapes.setdefault(p.shape, len(shapes)) for p in phase.parts] for phase in phases]
        count = max(len(phase.obstacles) for phase in phases)
        rest = [
            [shapes.setdefault(o.shape, len(shapes)) for o in phase.obstacles] + [0] * (count - len(phase.obstacles))
            for phase in phases
        ]
        self.forms = Forms(list(shapes))
        self.form = np.array(number, dtype=np.intp).reshape(len(phases), -1)
        self.rest = np.array(rest, dtype=np.intp).reshape(len(phases), -1)
        self.local = np.array([[p.local for p in phase.parts] for phase in phases]).reshape(len(phases), -1, 4, 4)
        far = np.eye(4)
        far[:3, 3] = OUT_OF_SIGHT
        self.at = np.array([
            [o.pose for o in phase.obstacles] + [far] * (count - len(phase.obstacles)) for phase in phases
        ]).reshape(len(phases), -1, 4, 4)  # fmt: skip
        self.half = np.array([box_sides(s) for s in shapes]) / 2
        self.extent = np.einsum("koij,koj->koi", np.abs(self.at[..., :3, :3]), self.half[self.rest])
        moving = [[p.whole for p in phase.parts] for phase in phases]
        self._whole = np.array(moving, dtype=bool).reshape(len(phases), -1)
        self._rests_whole = np.array([s.kind == ShapeKind.CONVEX for s in shapes])[self.rest]
        self.wholes = bool(self._whole.any() or self._rests_whole.any())
        """Whether there are shapes that the optimiser sees as they are, for want of spheres."""
        self._set_kinds(contacts, count)

    def _set_kinds(self, contacts: Sequence[PhaseContacts], count: int) -> None:
        parts = len(self.nodes)
        self.obstacle_kinds: Kinds = np.full((parts, count, len(self.phases)), NEVER, np.int8)
        self.pair_kinds: Kinds = np.empty((len(self.pairs), len(self.phases)), np.int8)
        for k, phase in enumerate(self.phases):
            contact, tags = contacts[phase.tree.phase], [p.tag for p in phase.parts]
            kinds = cross_kinds(contact, tags, [o.tag for o in phase.obstacles])
            self.obstacle_kinds[:, : len(phase.obstacles), k] = kinds
            self.pair_kinds[:, k] = cross_kinds(contact, tags, tags)[self.pairs[:, 0], self.pairs[:, 1]]
        self.obstacle_kinds[self.nodes < 0] = NEVER

    def ignore_collisions(self) -> None:
        """Let everything pass through everything."""
        self.obstacle_kinds[...] = NEVER
        self.pair_kinds[...] = NEVER

    def take(self, index: Indices) -> ExactGeometry:
        """The geometry of some of the phases, possibly repeated."""
        result = object.__new__(ExactGeometry)
        result.phases = [self.phases[i] for i in index]
        result.kinematics, result.nodes, result.pairs = self.kinematics.take(index), self.nodes, self.pairs
        result.groups = self.groups
        result.moved_by, result.forms, result.half = self.moved_by, self.forms, self.half
        result._whole, result._rests_whole, result.wholes = self._whole[index], self._rests_whole[index], self.wholes
        result.form, result.rest, result.local = self.form[index], self.rest[index], self.local[index]
        result.at, result.extent = self.at[index], self.extent[index]
        result.obstacle_kinds, result.pair_kinds = self.obstacle_kinds[..., index], self.pair_kinds[..., index]
        return result

    @property
    def reach(self) -> Array:
        """Radii `(phases, parts)` of the spheres around the parts."""
        return np.asarray(self.forms.reach[self.form])

    def centres(self, frames: Array) -> Array:
        """The parts' origins `(parts, 3, phases, times)` by frames `(nodes + 1, 4, 3, phases, times)`."""
        carried = frames[self.nodes]
        offset = self.local[:, :, :3, 3].transpose(1, 2, 0)[:, :, None, :, None]
        return np.asarray((carried[:, :3] * offset).sum(axis=1) + carried[:, 3])

    def placed(self, frames: Array, part: Indices, phase: Indices, time: Indices) -> Posed:
        """Parts `(m,)` in phases and at times `(m,)`."""
        carried, local = frames[self.nodes[part], :, :, phase, time], self.local[phase, part]
        turn = carried[:, :3].transpose(0, 2, 1)
        rotation, position = turn @ local[:, :3, :3], (turn @ local[:, :3, 3:])[:, :, 0] + carried[:, 3]
        return Posed(self.forms, self.form[phase, part], position, rotation)

    def resting(self, obstacle: Indices, phase: Indices) -> Posed:
        """Obstacles `(m,)` of phases `(m,)`."""
        at = self.at[phase, obstacle]
        return Posed(self.forms, self.rest[phase, obstacle], at[:, :3, 3], at[:, :3, :3])

    def is_whole(self, entries: Entries) -> NDArray[np.bool_]:
        """Of which `(m,)` one side is seen as it is."""
        second = self._whole if entries.among else self._rests_whole
        return np.asarray(self._whole[entries.phase, entries.first] | second[entries.phase, entries.second])

    def clash(self, phase: int, entries: Entries, chosen: int, amount: float) -> Clash:
        """What is told of a part and an obstacle of one of the phases, or `among` the parts."""
        stated, first, second = self.phases[phase], int(entries.first[chosen]), int(entries.second[chosen])
        part, other = stated.parts[first], stated.parts[second] if entries.among else stated.obstacles[second]
        pair = part.tag or part.owner, other.tag or other.owner
        parts = part.name, stated.parts[second].name if entries.among else other.tag or other.owner
        return Clash(pair, amount, float(REQUIRED[entries.kind[chosen]]), parts)


@dataclass(slots=True)
class Entries:
    """Parts `first` `(m,)` and what they may come near, obstacles or, `among` parts, others, at a time of a phase."""

    among: bool
    first: Indices
    second: Indices
    phase: Indices
    time: Indices
    kind: Kinds

    def __getitem__(self, chosen: Indices) -> Entries:
        return Entries(
            self.among, self.first[chosen], self.second[chosen], self.phase[chosen], self.time[chosen],
            self.kind[chosen],
        )  # fmt: skip

    def measured(self, geometry: ExactGeometry, frames: Array, beyond: Array) -> Distances:
        """Their distances, exact where they are less than `beyond` `(m,)` metres. What takes long to measure is looked
        at only where the boxes around it are near."""
        one = geometry.placed(frames, self.first, self.phase, self.time)
        if self.among:
            other = geometry.placed(frames, self.second, self.phase, self.time)
        else:
            other = geometry.resting(self.second, self.phase)
        slow = np.flatnonzero((one.kind != ROUND) & (other.kind != ROUND) | (one.kind == HULL) | (other.kind == HULL))
        if not len(slow):
            return distances(one, other, beyond)
        bound = _boxes_apart(one[slow], other[slow], geometry.half)
        far = bound > beyond[slow]
        beyond = beyond.copy()
        beyond[slow[far]] = -np.inf
        found = distances(one, other, beyond)
        found.value[slow[far]] = bound[far]
        return found

    def wholes(self, geometry: ExactGeometry) -> Entries:
        """Those of them of which one side is seen as it is."""
        return self[np.flatnonzero(geometry.is_whole(self))]


def _boxes_apart(one: Posed, other: Posed, half: Array) -> Array:
    """Lower bounds `(m,)` of distances, by the boxes of half sizes `half` `(forms, 3)` around the shapes along their
    own axes: how far each is from the box, along those axes, around the other."""
    turn = one.rotation.transpose(0, 2, 1) @ other.rotation
    size, first, second = np.abs(turn), half[one.form], half[other.form]
    offset = other.position - one.position
    seen = (offset[:, None] @ one.rotation)[:, 0], (offset[:, None] @ other.rotation)[:, 0]
    around = (size @ second[..., None])[..., 0], (first[:, None] @ size)[:, 0]
    apart = [
        np.linalg.norm(np.maximum(np.abs(way) - own - grown, 0.0), axis=1)
        for way, own, grown in zip(seen, (first, second), around, strict=True)
    ]
    return np.asarray(np.maximum(*apart))


def near_entries(geometry: ExactGeometry, frames: Array, room: Array) -> list[Entries]:
    """What may come nearer than `room` `(parts, phases, times)`, in metres and of both sides the sum: by spheres around
    parts and boxes around obstacles."""
    centres = geometry.centres(frames)
    grown = room + geometry.reach.T[:, :, None]
    found = []
    if geometry.at.shape[1]:
        low, high = (centres - grown[:, None]).min(axis=-1), (centres + grown[:, None]).max(axis=-1)
        middle, extent = geometry.at[:, :, :3, 3].transpose(1, 2, 0), geometry.extent.transpose(1, 2, 0)
        near = geometry.obstacle_kinds != NEVER
        for axis in (2, 0, 1):
            near &= low[:, None, axis] < middle[:, axis] + extent[:, axis]
            near &= high[:, None, axis] > middle[:, axis] - extent[:, axis]
        a, o, k = np.nonzero(near)
        away = np.abs(centres[a, :, k] - geometry.at[k, o, :3, 3, None]) - geometry.extent[k, o, :, None]
        away = np.maximum(away, 0.0)
        row, t = np.nonzero((away * away).sum(axis=1) < grown[a, k] ** 2)
        a, o, k = a[row], o[row], k[row]
        found.append(Entries(False, a, o, k, t, geometry.obstacle_kinds[a, o, k]))
    if len(geometry.pairs):
        found.append(_pairs_near(geometry, centres, grown))
    return found


def _pairs_near(geometry: ExactGeometry, centres: Array, grown: Array) -> Entries:
    i, j = geometry.pairs.T
    if len(geometry.pairs) > PHASES.many_part_pairs:
        p, k, t = geometry.groups.meeting(centres, grown)
        apart = centres[i[p], :, k, t] - centres[j[p], :, k, t]
        near = (apart * apart).sum(axis=1) < (grown[i[p], k, t] + grown[j[p], k, t]) ** 2
        chosen = np.flatnonzero(near & (geometry.pair_kinds[p, k] != NEVER))
        p, k, t = p[chosen], k[chosen], t[chosen]
    else:
        apart = centres[i] - centres[j]
        near = (apart * apart).sum(axis=1) < (grown[i] + grown[j]) ** 2
        p, k, t = np.nonzero(near & (geometry.pair_kinds != NEVER)[:, :, None])
    return Entries(True, i[p], j[p], k, t, geometry.pair_kinds[p, k])


@dataclass(slots=True)
class Clash:
    """The worst pair of one phase and by how much its clearance is missed, metres."""

    pair: tuple[str, str]
    amount: float
    asked: float = 0.0
    parts: tuple[str, ...] = ()


def worst_clash(geometry: ExactGeometry, phase: int, values: Array) -> Clash:
    """The worst pair of one phase for joint values `(times, joints)`; its amount is 0 where nothing is missed."""
    one = geometry.take(np.array([phase]))
    frames = one.kinematics.frames(values[None])
    worst = Clash(("", ""), 0.0)
    for entries in near_entries(one, frames, np.full((len(one.nodes), 1, len(values)), PHASES.far)):
        missed = REQUIRED[entries.kind] - entries.measured(one, frames, np.full(len(entries.first), PHASES.far)).value
        if missed.max(initial=0.0) > worst.amount:
            k = int(missed.argmax())
            worst = one.clash(0, entries, k, float(missed[k]))
    return worst


def poses_blocked(geometry: ExactGeometry, poses: Array, wholes: bool = False) -> NDArray[np.bool_]:
    """`(times,)` whether the clearance that is required is missed, or with `wholes` that of what is seen as it is, in
    the one phase of `geometry`, for joint values `(times, joints)`."""
    result = np.zeros(len(poses), bool)
    if not len(poses):
        return result
    frames = geometry.kinematics.frames(poses[None])
    for near in near_entries(geometry, frames, np.zeros((len(geometry.nodes), 1, len(poses)))):
        entries = near.wholes(geometry) if wholes else near
        distance = entries.measured(geometry, frames, np.zeros(len(entries.first))).value
        result[entries.time[distance < REQUIRED[entries.kind]]] = True
    return result


def wholes_spare(geometry: ExactGeometry, poses: Array, most: float) -> Array:
    """`(times,)` by how much what is seen as it is keeps clear by more than is required, metres, at most `most`, in the
    one phase of `geometry`, for joint values `(times, joints)`."""
    result = np.full(len(poses), most)
    frames = geometry.kinematics.frames(poses[None])
    for near in near_entries(geometry, frames, np.full((len(geometry.nodes), 1, len(poses)), most)):
        entries = near.wholes(geometry)
        distance = entries.measured(geometry, frames, np.full(len(entries.first), most)).value
        np.minimum.at(result, entries.time, distance - REQUIRED[entries.kind])
    return result


def blocked(geometry: ExactGeometry, poses: Array) -> NDArray[np.bool_]:
    """`(phases,)` whether the clearance that is required is missed, for joint values `(phases, times, joints)`."""
    frames = geometry.kinematics.frames(poses)
    result = np.zeros(len(poses), bool)
    for entries in near_entries(geometry, frames, np.full((len(geometry.nodes), *poses.shape[:2]), PHASES.far)):
        distance = entries.measured(geometry, frames, np.full(len(entries.first), PHASES.far)).value
        result[entries.phase[distance < REQUIRED[entries.kind]]] = True
    return result
