"""What strengths bound in structures with closed loops, as rows over many samples: linear functionals of wrenches."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ...langs.frozen import dataclass
from ..ir import Joint, JointKind, Problem
from .frames import Array, Poses, crossed, meeting
from .outlines import foot_radius
from .records import CONTACTS
from .structure import WORLD, Edge, Structure, subtrees

SIDES = 4
"""Directions, and their opposites, in which the shear and the bending of a pair in a loop are limited: the eight sides
of a regular polygon inside the circle, at most 8 % too strict."""


@dataclass(frozen=True, slots=True)
class StrengthRows:
    """Rows f · w <= s over T samples, where w (6,) is the wrench of an edge, about the middle `about` (T, 3) of the
    structure, which keeps moments small wherever a robot is. `functionals` (T, R, 6) are over their limits, `edges`
    (R,) tells whose wrench each is of. Those with `both` bound f · w from below, too; s is the ratio where a row
    `grows`, and else 0, for what rests must not lift. `hung` (T, E, 6) are the wrenches where loops take nothing,
    `signs` (E, L) how the wrench of each loop counts in each edge."""

    functionals: Array
    edges: Array
    both: Array
    grows: Array
    hung: Array
    signs: Array
    about: Array

    @property
    def unknowns(self) -> int:
        return 6 * int(self.signs.shape[1])

    def told(self, taken: Array) -> Array:
        """The left sides `(T, R)` where loops take these wrenches `(T, 6 L)`."""
        wrenches = self.hung + self.signs @ taken.reshape(len(taken), self.signs.shape[1], 6)
        return np.asarray(np.einsum("trk,trk->tr", self.functionals, wrenches[:, self.edges]))

    def slopes(self) -> Array:
        """How the left sides change with the wrenches that loops take `(T, R, 6 L)`."""
        own = self.signs[self.edges]
        return np.concatenate([self.functionals * column[:, None] for column in own.T], axis=2)


def signs_of(found: Structure) -> Array:
    """How the wrench of each loop counts in that of each edge `(edges, loops)`: 1, -1 or 0."""
    ways = subtrees(found)
    signs = np.zeros((len(found.all), len(found.loops)))
    for column, loop in enumerate(found.loops):
        signs[len(found.edges) + column, column] = 1.0
        for edge in ways[loop.child] ^ ways[loop.parent]:
            signs[edge, column] = -1.0 if edge in ways[loop.child] else 1.0
    return signs


def strength_rows(
    problem: Problem, found: Structure, at: Poses, known: Sequence[tuple[Array, Array]], safety: float
) -> StrengthRows:
    """The rows of all edges; `known` are the wrenches of the trees about the origin where loops take nothing."""
    count = len(at.turns[WORLD])
    about = np.mean([at.places[e.child] for e in found.edges], axis=0)
    hung = np.zeros((count, len(found.all), 6))
    for number, (force, moment) in enumerate(known):
        hung[:, number, :3], hung[:, number, 3:] = force, moment - crossed(about, force)
    made, numbers, chosen = list[_RowBlock](), list[int](), list[int]()
    for number, edge in enumerate(found.all):
        if edge.is_joint:
            chosen.append(number)
            continue
        own = _pair_rows(problem, edge, at, about, safety)
        made += own
        numbers += [number] * sum(len(rows.grows) for rows in own)
    for owners, turning in _joint_rows(problem, found, at, about, safety, chosen):
        made.append(turning)
        numbers += owners
    return StrengthRows(
        np.concatenate([rows.functionals for rows in made], axis=1) if made else np.zeros((count, 0, 6)),
        np.array(numbers, dtype=int), _joined([rows.both for rows in made]), _joined([rows.grows for rows in made]),
        hung, signs_of(found), about,
    )  # fmt: skip


def _joined(parts: Sequence[Array]) -> Array:
    return np.concatenate(parts) if parts else np.zeros(0, dtype=bool)


@dataclass(frozen=True, slots=True)
class _RowBlock:
    functionals: Array
    both: Array
    grows: Array


def _limited(functionals: Array, limit: float | Array, *, both: bool = True, grows: bool = True) -> _RowBlock:
    count = functionals.shape[1]
    over = functionals / np.asarray(limit).reshape(-1, 1)
    return _RowBlock(over, np.full(count, both), np.full(count, grows))


def _joint_rows(
    problem: Problem, found: Structure, at: Poses, about: Array, safety: float, chosen: Sequence[int]
) -> list[tuple[list[int], _RowBlock]]:
    """Rows of all joints at once: of those with a strength, and of those with a bearing moment; each with their
    edges."""
    rows = list[tuple[list[int], _RowBlock]]()
    edges = [found.edges[number] for number in chosen]
    joints = [problem.world.modules[e.names[0]].type.joints[e.joint] for e in edges]
    nodes = [(e.names[0], e.joint) for e in edges]
    strengths = [j.strength(still=n not in at.moved) for j, n in zip(joints, nodes, strict=True)]
    driven = [k for k, s in enumerate(strengths) if math.isfinite(s)]
    borne = [k for k, j in enumerate(joints) if math.isfinite(j.bearing)]
    if driven:
        axis, place = _axes(at, [joints[k] for k in driven], [nodes[k] for k in driven], about)
        turning = np.array([joints[k].kind == JointKind.REVOLUTE for k in driven])[:, None]
        own = np.where(turning, _moments(axis, place), _forces(axis))
        rows.append(([chosen[k] for k in driven], _limited(own, np.array([strengths[k] / safety for k in driven]))))
    if borne:
        axis, place = _axes(at, [joints[k] for k in borne], [nodes[k] for k in borne], about)
        inner = math.cos(math.pi / (4 * SIDES)) / safety
        limits = np.array([joints[k].bearing * inner for k in borne])
        for direction in _across(axis):
            rows.append(([chosen[k] for k in borne], _limited(_moments(direction, place), limits)))
    return rows


def _axes(at: Poses, joints: Sequence[Joint], nodes: Sequence[tuple[str, int]], about: Array) -> tuple[Array, Array]:
    """Axes of joints and where they are `(T, J, 3)`."""
    turns = np.stack([at.turns[n] for n in nodes], axis=1)
    places = np.stack([at.places[n] for n in nodes], axis=1) - about[:, None]
    own = np.array([joint.axis for joint in joints], dtype=float)
    own /= np.linalg.norm(own, axis=1, keepdims=True)
    return (turns @ own[None, :, :, None])[..., 0], places


def _pair_rows(problem: Problem, edge: Edge, at: Poses, about: Array, safety: float) -> list[_RowBlock]:
    hold = edge.hold
    if hold is None:
        return []
    point, axes = meeting(problem, edge, at)
    place, normal = (point - about)[:, None], axes[:, None, :, 2]
    contact = edge.manner in CONTACTS
    sticks = hold.force if edge.manner == "pad" else 0.0 if contact else math.inf
    inner = math.cos(math.pi / (2 * SIDES)) / safety
    angles = math.pi * np.arange(SIDES) / SIDES
    across = np.cos(angles)[:, None] * axes[:, None, :, 0] + np.sin(angles)[:, None] * axes[:, None, :, 1]
    force, bend = _forces(across), _moments(across, place)
    rows = list[_RowBlock]()

    def within(functionals: Array, limit: float) -> None:
        if math.isfinite(limit):
            rows.append(_limited(functionals, limit))

    shear = min(hold.shear, hold.friction * hold.force) if edge.manner == "grip" else hold.shear
    within(force, shear * inner)
    within(bend, hold.moment * inner)
    within(_moments(normal, place), hold.twist / safety)
    if not contact:
        within(_forces(normal), hold.force / safety)
    elif math.isfinite(sticks):
        push = _forces(normal if edge.turned else -normal)

        def leaning(functionals: Array, share: float) -> None:
            """functionals <= share (push + sticks), where a force of 1 N counts as the limit of what does not grow."""
            for sign in (1.0, -1.0):
                limit = max(share * sticks, 1e-6)
                rows.append(_limited(sign * functionals - share * push, limit, both=False, grows=sticks > 0.0))

        if math.isfinite(hold.friction):
            leaning(force, hold.friction * inner)
        if not math.isfinite(hold.moment):
            leaning(bend, foot_radius(problem, edge.place) * inner)
        rows.append(_limited(-push, max(sticks, 1e-6) / safety, both=False, grows=sticks > 0.0))
    return rows


def _forces(direction: Array) -> Array:
    """The functionals of a wrench that are its force along directions `(…, 3)`."""
    return np.concatenate([direction, np.zeros_like(direction)], axis=-1)


def _moments(direction: Array, place: Array) -> Array:
    """The functionals of a wrench that are its moment about lines through `place`."""
    place = np.broadcast_to(place, direction.shape)
    return np.concatenate([crossed(place, direction), direction], axis=-1)


def _across(axis: Array) -> list[Array]:
    """Directions all round across axes `(…, 3)`, each standing for its opposite, too."""
    first = crossed(axis, np.eye(3)[np.abs(axis).argmin(axis=-1)])
    first /= np.linalg.norm(first, axis=-1, keepdims=True)
    second = crossed(axis, first)
    angles = [math.pi * k / (2 * SIDES) for k in range(2 * SIDES)]
    return [math.cos(a) * first + math.sin(a) * second for a in angles]
