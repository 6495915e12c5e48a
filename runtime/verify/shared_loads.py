"""Loads of closed loops: the balance of every node, and of all loads that balance those that strain the least."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from ...compiler import ir
from .geometry import Array, Frames
from .strengths import Joined, Node, Support, meeting_place, moves

CORNERS = 16
"""Of the polygons inside the circles that bound shear and bending."""
LIFTED = 1e3
"""How dear it is that a foot is pulled, against the ratio of everything else."""


def shared(
    problem: ir.Problem, ring: tuple[Joined, ...], nodes: Mapping[Node, Frames], forces: Mapping[Node, Array],
    moments: Mapping[Node, Array], known: Mapping[Joined, tuple[Array, Array]], support: Support, safety: float,
) -> dict[Joined, tuple[Array, Array]]:  # fmt: skip
    """The wrenches `(T, 3)` of the edges of a ring, far on near, about the origin."""
    count = max(len(f) for f in nodes.values())
    root = support.root(ring)
    inner = sorted({n for e in ring for n in (e.near, e.far)} - {root})
    weights: dict[Node, Array] = {}
    for node in inner:
        total = np.zeros((count, 6))
        if node in forces:
            total += np.hstack([forces[node], moments[node]])
        for edge in support.hanging(node, ring):
            total += (1.0 if edge.near == node else -1.0) * np.hstack(known[edge])
        weights[node] = total
    found = {e: (np.zeros((count, 3)), np.zeros((count, 3))) for e in ring}
    equal = _balance(ring, inner)
    rows, limits = _rows(problem, ring, {n: f.spread(count) for n, f in nodes.items()}, count, safety)
    for t in range(count):
        solved = _solved(equal, -np.concatenate([weights[node][t] for node in inner]), rows[t], limits)
        for number, edge in enumerate(ring):
            found[edge][0][t] = solved[6 * number : 6 * number + 3]
            found[edge][1][t] = solved[6 * number + 3 : 6 * number + 6]
    return found


def _balance(ring: tuple[Joined, ...], inner: list[Node]) -> Array:
    """What the wrenches of a ring put on its inner nodes, as a matrix over them, the ratio, and what lifts."""
    equal = np.zeros((6 * len(inner), 6 * len(ring) + 2))
    for row, node in enumerate(inner):
        block = slice(6 * row, 6 * row + 6)
        for number, edge in enumerate(ring):
            columns = slice(6 * number, 6 * number + 6)
            if edge.near == node:
                equal[block, columns] += np.eye(6)
            elif edge.far == node:
                equal[block, columns] -= np.eye(6)
    return equal


def _rows(
    problem: ir.Problem, ring: tuple[Joined, ...], nodes: Mapping[Node, Frames], count: int, safety: float
) -> tuple[Array, Array]:
    """The rows `(T, R, 6 E + 2)` of all strengths, and what each is at most."""
    width = 6 * len(ring)
    bounded = [(number, *row) for number, edge in enumerate(ring) for row in _bounds(problem, edge, nodes, safety)]
    rows, limits = np.zeros((count, len(bounded) + 1, width + 2)), np.zeros(len(bounded) + 1)
    for row, (number, functionals, share, constant) in enumerate(bounded, start=1):
        rows[:, row, 6 * number : 6 * number + 6] = functionals
        rows[:, row, width], rows[:, row, width + 1] = -share, -(share == 0.0)
        limits[row] = constant
    return rows, limits


def _solved(equal: Array, right: Array, rows: Array, limits: Array) -> Array:
    from scipy.optimize import linprog

    width = equal.shape[1] - 2
    cost = np.zeros(width + 2)
    cost[width], cost[width + 1] = 1.0, LIFTED
    bounds = [(None, None)] * width + [(0.0, None)] * 2
    solved = linprog(cost, rows, limits, equal, right, bounds, method="highs")
    if solved.x is None:
        return np.full(width, math.nan)
    off = np.abs(equal @ solved.x - right).max(initial=0.0)
    return np.asarray(solved.x[:width]) if off <= 1e-6 * (1.0 + np.abs(right).max()) else np.full(width, math.nan)


def _bounds(
    problem: ir.Problem, edge: Joined, nodes: Mapping[Node, Frames], safety: float
) -> list[tuple[Array, float, float]]:
    """Rows functional `(T, 6)` · wrench <= share · ratio + constant."""
    found: list[tuple[Array, float, float]] = []

    def within(functional: Array, strength: float) -> None:
        if math.isfinite(strength):
            found.extend((sign * functional, strength / safety, 0.0) for sign in (1.0, -1.0))

    if edge.joint_of:
        joint = next(j for j in problem.world.modules[edge.names[0]].type.joints if j.name == edge.names[1])
        axis = nodes[edge.far].rotation @ (np.asarray(joint.axis) / np.linalg.norm(joint.axis))
        place = nodes[edge.far].position
        turning = joint.kind == ir.JointKind.REVOLUTE
        strength = joint.torque if moves(edge, nodes) else max(joint.torque, joint.brake)
        within(_about(axis, place) if turning else _along(axis), strength)
        side = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis), axis=1)])
        side /= np.linalg.norm(side, axis=1, keepdims=True)
        if math.isfinite(joint.bearing):
            for direction in _round(side, np.cross(axis, side)):
                within(_about(direction, place), joint.bearing * math.cos(math.pi / CORNERS))
        return found
    if not edge.strength:
        return found
    place, axes, radius = meeting_place(problem, edge, nodes)
    most, shear, bending, twisting, friction = edge.strength
    contact = edge.manner in ("pad", "rest")
    sticks = (most if edge.manner == "pad" else 0.0) if contact else math.inf
    pull = _along(axes[:, :, 2])
    inside = math.cos(math.pi / CORNERS)
    if edge.manner == "grip":
        shear = min(shear, friction * most)
    for direction in _round(axes[:, :, 0], axes[:, :, 1]):
        slide, bend = _along(direction), _about(direction, place)
        within(slide, shear * inside)
        within(bend, bending * inside)
        if contact and math.isfinite(sticks):
            for sign in (1.0, -1.0):
                if math.isfinite(friction):
                    share = friction * inside / safety
                    found.append((sign * slide + share * pull, 0.0, share * sticks))
                if not math.isfinite(bending):
                    share = radius * inside / safety
                    found.append((sign * bend + share * pull, 0.0, share * sticks))
    within(_about(axes[:, :, 2], place), twisting)
    if not contact:
        within(pull, most)
    elif math.isfinite(sticks):
        found.append((pull, 0.0, sticks / safety))
    return found


def _along(direction: Array) -> Array:
    """The force of a wrench along directions `(T, 3)`, as a functional of force and moment about the origin."""
    return np.concatenate([direction, np.zeros_like(direction)], axis=1)


def _about(direction: Array, place: Array) -> Array:
    """The moment of a wrench about a line through `place`, as such a functional."""
    return np.concatenate([np.cross(place, direction), direction], axis=1)


def _round(first: Array, second: Array) -> list[Array]:
    angles = np.pi * np.arange(CORNERS // 2) / (CORNERS // 2)
    return [np.cos(a) * first + np.sin(a) * second for a in angles]


