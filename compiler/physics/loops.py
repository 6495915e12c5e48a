"""Loads in closed loops: the share of each loop is what makes the worst ratio of load to strength least."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from ..ir import JointKind, Problem
from .frames import Array, Poses, foot_radius, meeting
from .records import CONTACTS
from .structure import WORLD, Edge, Structure, subtrees

SIDES = 4
"""Directions, and their opposites, in which the shear and the bending of a pair in a loop are limited: the eight sides
of a regular polygon inside the circle, at most 8 % too strict."""


def shared(
    problem: Problem, found: Structure, at: Poses, known: list[tuple[Array, Array]], safety: float
) -> list[tuple[Array, Array]]:
    """The wrenches of all edges, those of the trees corrected by what the loops take: sample by sample the share with
    the least worst ratio."""
    count, unknowns = len(at.turns[WORLD]), 6 * len(found.loops)
    ways = subtrees(found)
    signs = np.zeros((len(found.edges), len(found.loops)))
    for column, loop in enumerate(found.loops):
        for edge in ways[loop.child] ^ ways[loop.parent]:
            signs[edge, column] = -1.0 if edge in ways[loop.child] else 1.0
    total = [(f.copy(), m.copy()) for f, m in known]
    total += [(np.zeros((count, 3)), np.zeros((count, 3))) for _ in found.loops]
    for t in range(count):
        rows, constant, scale = _rows(problem, found, at, known, signs, t, safety)
        x = _least(rows, constant, scale, unknowns)
        for column in range(len(found.loops)):
            wrench = x[6 * column : 6 * column + 6]
            total[len(found.edges) + column][0][t] += wrench[:3]
            total[len(found.edges) + column][1][t] += wrench[3:]
            for number in map(int, np.flatnonzero(signs[:, column])):
                total[number][0][t] += signs[number, column] * wrench[:3]
                total[number][1][t] += signs[number, column] * wrench[3:]
    return total


def _rows(
    problem: Problem, found: Structure, at: Poses, known: Sequence[tuple[Array, Array]], signs: Array, t: int,
    safety: float,
) -> tuple[Array, Array, Array]:  # fmt: skip
    """Rows a · x + b <= s c of all strengths: c is 1 where the ratio s may grow, 0 where what rests must not lift."""
    rows, constants, scales = list[Array](), list[float](), list[float]()

    def add(edge_number: int, functional: Array, limit: float, grows: bool) -> None:
        """functional · (force, moment about the origin) <= limit."""
        row = np.zeros(6 * len(found.loops))
        base = np.zeros(6)
        if edge_number >= len(found.edges):
            column = edge_number - len(found.edges)
            row[6 * column : 6 * column + 6] = functional
        else:
            base = np.concatenate([known[edge_number][0][t], known[edge_number][1][t]])
            for other in map(int, np.flatnonzero(signs[edge_number])):
                row[6 * other : 6 * other + 6] = signs[edge_number, other] * functional
        rows.append(row / limit)
        constants.append(float(functional @ base) / limit)
        scales.append(1.0 if grows else 0.0)

    for number, edge in enumerate(found.all):
        for functional, limit, grows in _functionals(problem, edge, at, t, safety):
            add(number, functional, limit, grows)
    if not rows:
        return np.zeros((0, signs.shape[1] * 6)), np.zeros(0), np.zeros(0)
    return np.array(rows), np.array(constants), np.array(scales)


def _functionals(problem: Problem, edge: Edge, at: Poses, t: int, safety: float) -> list[tuple[Array, float, bool]]:
    """What is limited of an edge's wrench: linear functionals of it, their limits, and whether the ratio counts."""
    found: list[tuple[Array, float, bool]] = []

    def both(functional: Array, limit: float) -> None:
        if math.isfinite(limit):
            found.extend([(functional, limit / safety, True), (-functional, limit / safety, True)])

    if edge.is_joint:
        joint = problem.world.modules[edge.names[0]].type.joints[edge.joint]
        node = (edge.names[0], edge.joint)
        turn, place = at.turns[node][t], at.places[node][t]
        axis = turn @ (np.asarray(joint.axis) / np.linalg.norm(joint.axis))
        drive = _moment(axis, place) if joint.kind == JointKind.REVOLUTE else np.concatenate([axis, np.zeros(3)])
        both(drive, joint.torque)
        for direction in _across(axis):
            both(_moment(direction, place), joint.bearing * math.cos(math.pi / (4 * SIDES)))
        return found
    if edge.hold is None:
        return found
    one = Poses({n: r[t : t + 1] for n, r in at.turns.items()}, {n: p[t : t + 1] for n, p in at.places.items()})
    places, frames = meeting(problem, edge, one)
    place, axes = places[0], frames[0]
    hold, normal = edge.hold, axes[:, 2]
    inner = math.cos(math.pi / (2 * SIDES))
    contact = edge.manner in CONTACTS
    push = np.concatenate([normal if edge.turned else -normal, np.zeros(3)])
    sticks = hold.force if edge.manner == "pad" else 0.0 if contact else math.inf
    for k in range(SIDES):
        angle = math.pi * k / SIDES
        direction = math.cos(angle) * axes[:, 0] + math.sin(angle) * axes[:, 1]
        force, bend = np.concatenate([direction, np.zeros(3)]), _moment(direction, place)
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
        both(np.concatenate([normal, np.zeros(3)]), hold.force)
    elif math.isfinite(sticks):
        found.append((-push, max(sticks, 1e-6) / safety, sticks > 0.0))
    return found


def _leaning(functional: Array, push: Array, share: float, sticks: float) -> tuple[Array, float, bool]:
    """functional <= share (push + sticks), where a force of 1 N counts as the limit of what does not grow."""
    return functional - share * push, max(share * sticks, 1e-6), sticks > 0.0


def _moment(direction: Array, place: Array) -> Array:
    """The functional of a wrench that is its moment about a line through `place`."""
    return np.concatenate([-np.cross(direction, place), direction])


def _across(axis: Array) -> list[Array]:
    first = np.cross(axis, np.eye(3)[int(np.abs(axis).argmin())])
    first /= np.linalg.norm(first)
    second = np.cross(axis, first)
    angles = [math.pi * k / (2 * SIDES) for k in range(2 * SIDES)]
    return [math.cos(a) * first + math.sin(a) * second for a in angles]


SOLVER: dict[str, Any] = {"piqp": {"eps_abs": 1e-9, "eps_rel": 1e-10, "max_iter": 100}, "error_on_fail": False}


@lru_cache(maxsize=64)
def _program(unknowns: int, rows: int) -> Any:
    import casadi as ca

    return ca.conic(
        "loads", "piqp", {"h": ca.Sparsity.diag(unknowns), "a": ca.Sparsity.dense(rows, unknowns)}, dict(SOLVER)
    )


def _least(rows: Array, constant: Array, scale: Array, unknowns: int) -> Array:
    """x with the least s such that rows · x + constant <= s scale. Rows that do not grow give way, dearly, where all
    cannot hold. A small square keeps what strengths leave open small."""
    if not len(rows):
        return np.zeros(unknowns)
    count = unknowns + 2
    weights = np.concatenate([np.full(unknowns, 1e-7), [1e-9, 1e-9]])
    gradient = np.concatenate([np.zeros(unknowns), [1.0, 100.0]])
    matrix = np.column_stack([rows, -scale, -(1.0 - scale)])
    low = np.concatenate([np.full(unknowns, -np.inf), [0.0, 0.0]])
    import casadi as ca

    solved = _program(count, len(rows))(
        h=ca.diag(ca.DM(weights)), g=gradient, a=matrix, lba=-np.inf, uba=-constant, lbx=low, ubx=np.inf
    )
    return np.asarray(solved["x"]).ravel()[:unknowns]
