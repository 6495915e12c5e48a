"""Loads in closed loops: the share of each loop is what makes the worst ratio of load to strength least."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from ...langs.frozen import dataclass
from ..ir import JointKind, Problem
from .frames import Array, Poses, crossed, meeting
from .outlines import foot_radius
from .records import CONTACTS
from .structure import WORLD, Edge, Structure, subtrees

SIDES = 4
"""Directions, and their opposites, in which the shear and the bending of a pair in a loop are limited: the eight sides
of a regular polygon inside the circle, at most 8 % too strict."""


LIFTED = 100.0
"""What a row that does not grow costs, beside the ratio, where it gives way."""


def shared(
    problem: Problem, found: Structure, at: Poses, known: list[tuple[Array, Array]], safety: float
) -> list[tuple[Array, Array]]:
    """The wrenches of all edges, those of the trees corrected by what the loops take: sample by sample the share with
    the least worst ratio."""
    count, unknowns = len(at.turns[WORLD]), 6 * len(found.loops)
    signs = _signs(found)
    total = [(f.copy(), m.copy()) for f, m in known]
    total += [(np.zeros((count, 3)), np.zeros((count, 3))) for _ in found.loops]
    rows, constants, scale = _rows(problem, found, at, known, signs, safety)
    solver = _Least(rows.shape[1], unknowns, scale) if len(scale) else None
    taken = np.zeros((count, unknowns)) if solver is None else np.stack(
        [solver(rows[t], constants[t]).taken for t in range(count)]
    )
    for column in range(len(found.loops)):
        force, moment = taken[:, 6 * column : 6 * column + 3], taken[:, 6 * column + 3 : 6 * column + 6]
        total[len(found.edges) + column] = force.copy(), moment.copy()
        for number in map(int, np.flatnonzero(signs[:, column])):
            sign = signs[number, column]
            total[number] = total[number][0] + sign * force, total[number][1] + sign * moment
    return total


def _signs(found: Structure) -> Array:
    """How the wrench of each loop counts in that of each edge of a tree `(edges, loops)`: 1, -1 or 0."""
    ways = subtrees(found)
    signs = np.zeros((len(found.edges), len(found.loops)))
    for column, loop in enumerate(found.loops):
        for edge in ways[loop.child] ^ ways[loop.parent]:
            signs[edge, column] = -1.0 if edge in ways[loop.child] else 1.0
    return signs


@dataclass(frozen=True, slots=True)
class Share:
    """How loops share their loads: the wrenches that close them, the worst ratio of load to strength, and what each row
    weighs in that."""

    taken: Array
    ratio: float
    weights: Array


def shares(
    problem: Problem, found: Structure, at: Poses, known: list[tuple[Array, Array]], safety: float
) -> list[Share]:
    """The best share of every sample. Where something must lift off to bear itself, that counts a hundredfold."""
    rows, constants, scale = _rows(problem, found, at, known, _signs(found), safety)
    if not len(scale):
        return [Share(np.zeros(rows.shape[2]), 0.0, scale)] * len(rows)
    solver = _Least(rows.shape[1], rows.shape[2], scale)
    return [solver(rows[t], constants[t]) for t in range(len(rows))]


def ratios_of(
    problem: Problem, found: Structure, at: Poses, known: list[tuple[Array, Array]], safety: float,
    shared_so: Sequence[Share],
) -> Array:
    """What the worst ratio `(T,)` of samples is to first order beside those whose shares are given, one for each: the
    weighted rows under the same wrenches."""
    rows, constants, _ = _rows(problem, found, at, known, _signs(found), safety)
    taken, weights = np.stack([s.taken for s in shared_so]), np.stack([s.weights for s in shared_so])
    return np.asarray(((np.einsum("tru,tu->tr", rows, taken) + constants) * weights).sum(axis=1))


def _rows(
    problem: Problem, found: Structure, at: Poses, known: Sequence[tuple[Array, Array]], signs: Array, safety: float
) -> tuple[Array, Array, Array]:
    """Rows a · x + b <= s c of all strengths, over the samples: a (T, R, 6 L), b (T, R); c (R,) is 1 where the ratio s
    may grow, 0 where what rests must not lift."""
    count, width = len(at.turns[WORLD]), 6 * len(found.loops)
    rows, constants, scales = list[Array](), list[Array](), list[float]()
    for number, edge in enumerate(found.all):
        own = _functionals(problem, edge, at, safety)
        if not own:
            continue
        base = np.concatenate(known[number], axis=1) if number < len(found.edges) else np.zeros((count, 6))
        for functional, limit, grows in own:
            row = np.zeros((count, width))
            if number >= len(found.edges):
                column = number - len(found.edges)
                row[:, 6 * column : 6 * column + 6] = functional
            else:
                for other in map(int, np.flatnonzero(signs[number])):
                    row[:, 6 * other : 6 * other + 6] = signs[number, other] * functional
            rows.append(row / limit)
            constants.append((functional * base).sum(axis=1) / limit)
            scales.append(1.0 if grows else 0.0)
    if not rows:
        return np.zeros((count, 0, width)), np.zeros((count, 0)), np.zeros(0)
    return np.stack(rows, axis=1), np.stack(constants, axis=1), np.array(scales)


def _functionals(problem: Problem, edge: Edge, at: Poses, safety: float) -> list[tuple[Array, float, bool]]:
    """What is limited of an edge's wrench: linear functionals of it `(T, 6)`, their limits, and whether the ratio
    counts."""
    found: list[tuple[Array, float, bool]] = []

    def both(functional: Array, limit: float) -> None:
        if math.isfinite(limit):
            found.extend([(functional, limit / safety, True), (-functional, limit / safety, True)])

    if edge.is_joint:
        joint = problem.world.modules[edge.names[0]].type.joints[edge.joint]
        node = (edge.names[0], edge.joint)
        turn, place = at.turns[node], at.places[node]
        axis = turn @ (np.asarray(joint.axis) / np.linalg.norm(joint.axis))
        strength = joint.strength(still=node not in at.moved)
        both(_moment(axis, place) if joint.kind == JointKind.REVOLUTE else _force(axis), strength)
        if math.isfinite(joint.bearing):
            for direction in _across(axis):
                both(_moment(direction, place), joint.bearing * math.cos(math.pi / (4 * SIDES)))
        return found
    if edge.hold is None:
        return found
    place, axes = meeting(problem, edge, at)
    hold, normal = edge.hold, axes[:, :, 2]
    inner = math.cos(math.pi / (2 * SIDES))
    contact = edge.manner in CONTACTS
    push = _force(normal if edge.turned else -normal)
    sticks = hold.force if edge.manner == "pad" else 0.0 if contact else math.inf
    for k in range(SIDES):
        angle = math.pi * k / SIDES
        direction = math.cos(angle) * axes[:, :, 0] + math.sin(angle) * axes[:, :, 1]
        force, bend = _force(direction), _moment(direction, place)
        shear = min(hold.shear, hold.friction * hold.force) if edge.manner == "grip" else hold.shear
        both(force, shear * inner)
        both(bend, hold.moment * inner)
        if contact and math.isfinite(sticks):
            for sign in (1.0, -1.0):
                if math.isfinite(hold.friction):
                    found.append(_leaning(sign * force, push, hold.friction * inner / safety, sticks))
                if not math.isfinite(hold.moment):
                    radius = foot_radius(problem, edge.place)
                    found.append(_leaning(sign * bend, push, radius * inner / safety, sticks))
    both(_moment(normal, place), hold.twist)
    if not contact:
        both(_force(normal), hold.force)
    elif math.isfinite(sticks):
        found.append((-push, max(sticks, 1e-6) / safety, sticks > 0.0))
    return found


def _leaning(functional: Array, push: Array, share: float, sticks: float) -> tuple[Array, float, bool]:
    """functional <= share (push + sticks), where a force of 1 N counts as the limit of what does not grow."""
    return functional - share * push, max(share * sticks, 1e-6), sticks > 0.0


def _force(direction: Array) -> Array:
    """The functional of a wrench that is its force along a direction."""
    return np.concatenate([direction, np.zeros_like(direction)], axis=1)


def _moment(direction: Array, place: Array) -> Array:
    """The functional of a wrench that is its moment about a line through `place`."""
    return np.concatenate([crossed(place, direction), direction], axis=1)


def _across(axis: Array) -> list[Array]:
    """Directions all round across axes `(T, 3)`."""
    first = crossed(axis, np.eye(3)[np.abs(axis).argmin(axis=1)])
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = crossed(axis, first)
    angles = [math.pi * k / (2 * SIDES) for k in range(2 * SIDES)]
    return [math.cos(a) * first + math.sin(a) * second for a in angles]


SOLVER: dict[str, Any] = {"piqp": {"eps_abs": 1e-9, "eps_rel": 1e-10, "max_iter": 100}, "error_on_fail": False}


@lru_cache(maxsize=64)
def _program(unknowns: int, rows: int) -> Any:
    import casadi as ca

    return ca.conic(
        "loads", "piqp", {"h": ca.Sparsity.diag(unknowns), "a": ca.Sparsity.dense(rows, unknowns)}, dict(SOLVER)
    )


class _Least:
    """x with the least s such that rows · x + constant <= s scale. Rows that do not grow give way, dearly, where all
    cannot hold. A small square keeps what strengths leave open small."""

    def __init__(self, rows: int, unknowns: int, scale: Array) -> None:
        self._unknowns, count = unknowns, unknowns + 2
        program = _program(count, rows)
        self._buffer, self._solve = program.buffer()
        self._matrix, self._upper, self._found = np.zeros((count, rows)), np.zeros(rows), np.zeros(count)
        self._weights = np.zeros(rows)
        self._matrix[unknowns], self._matrix[unknowns + 1] = -scale, -(1.0 - scale)
        given = {
            "h": np.concatenate([np.full(unknowns, 1e-7), [1e-9, 1e-9]]),
            "g": np.concatenate([np.zeros(unknowns), [1.0, LIFTED]]), "a": self._matrix,
            "lba": np.full(rows, -np.inf), "uba": self._upper,
            "lbx": np.concatenate([np.full(unknowns, -np.inf), [0.0, 0.0]]), "ubx": np.full(count, np.inf),
        }  # fmt: skip
        self._given = list(given.values())
        for name, values in given.items():
            self._buffer.set_arg(program.index_in(name), values.reshape(-1).data)
        self._buffer.set_res(program.index_out("x"), self._found.data)
        self._buffer.set_res(program.index_out("lam_a"), self._weights.data)

    def __call__(self, rows: Array, constant: Array) -> Share:
        self._matrix[: self._unknowns] = rows.T
        self._upper[:] = -constant
        self._solve()
        taken, (grown, lifted) = self._found[: self._unknowns].copy(), self._found[self._unknowns :]
        return Share(taken, float(grown + LIFTED * lifted), self._weights.copy())
