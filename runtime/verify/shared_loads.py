"""Loads of closed loops. How these share them is open: a share that balances every node and keeps all strengths shows
that there is one. The share that a plan tells is tried first, put into balance exactly; at instants where it does not
do, or none is told, that which strains the least is asked for."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from ...compiler import ir
from .geometry import Array, Flags, Frames, crossed
from .limits import LIMITS
from .strengths import Joined, Loads, Node, Support, Wrench, judge, meeting_place, moves

CORNERS = 16
"""Of the polygons inside the circles that bound shear and bending."""
BALANCE = 1e-6
"""Share of the greatest load by which loads may be out of balance: rounding."""
LIFTED = 1e3
"""How dear it is that a foot is pulled, against the ratio of everything else."""


def shared(
    problem: ir.Problem, ring: tuple[Joined, ...], nodes: Mapping[Node, Frames], loads: Loads,
    known: Mapping[Joined, Wrench], support: Support, safety: float, told: Mapping[Joined, Wrench],
) -> dict[Joined, Wrench]:  # fmt: skip
    """The wrenches `(T, 3)` of the edges of a ring, far on near, about the origin; `told` are those that a plan tells
    of pairs."""
    count = max(len(f) for f in nodes.values())
    root = support.root(ring)
    inner = sorted({n for e in ring for n in (e.near, e.far)} - {root})
    right = np.zeros((count, 6 * len(inner)))
    for row, node in enumerate(inner):
        total = np.zeros((count, 6))
        if node in loads.forces:
            total += np.hstack([loads.forces[node], loads.moments[node]])
        for edge in support.hanging(node, ring):
            total += (1.0 if edge.near == node else -1.0) * np.hstack(known[edge])
        right[:, 6 * row : 6 * row + 6] = -total
    signs = _signs(ring, inner)
    taken = np.full((count, 6 * len(ring)), math.nan)
    left = np.ones(count, dtype=bool)
    if all(e in told for e in ring if not e.joint_of):
        taken, left = _balanced(ring, signs, right, told)
        left |= ~_kept(problem, ring, nodes, taken, safety)
    if left.any():
        equal = np.hstack([np.kron(signs, np.eye(6)), np.zeros((6 * len(inner), 2))])
        rows, limits = _rows(problem, ring, {n: f.spread(count) for n, f in nodes.items()}, count, safety)
        for t in np.flatnonzero(left):
            taken[t] = _solved(equal, right[t], rows[t], limits)
    return _by_edge(ring, taken)


def _by_edge(ring: tuple[Joined, ...], taken: Array) -> dict[Joined, Wrench]:
    return {edge: (taken[:, 6 * k : 6 * k + 3], taken[:, 6 * k + 3 : 6 * k + 6]) for k, edge in enumerate(ring)}


def _signs(ring: tuple[Joined, ...], inner: list[Node]) -> Array:
    """How the wrench of each edge of a ring counts in the balance of each inner node `(nodes, edges)`."""
    return np.array([[float(e.near == node) - float(e.far == node) for e in ring] for node in inner])


def _balanced(
    ring: tuple[Joined, ...], signs: Array, right: Array, told: Mapping[Joined, Wrench]
) -> tuple[Array, Flags]:
    """Wrenches `(T, 6 E)` that balance, near those told of the pairs, and at which instants they do not: joints bear
    what these leave, and what is then left for rounding is spread by least squares."""
    count = len(right)
    wanted = right.reshape(count, len(signs), 6)
    taken = np.zeros((count, len(ring), 6))
    for number, edge in enumerate(ring):
        if not edge.joint_of:
            taken[:, number] = np.hstack(told[edge])
    for free in ([bool(e.joint_of) for e in ring], [True] * len(ring)):
        own = np.where(free, signs, 0.0)
        taken += np.linalg.pinv(own) @ (wanted - signs @ taken)
    off = np.abs(wanted - signs @ taken).max(axis=(1, 2))
    return taken.reshape(count, -1), ~(off <= BALANCE * (1.0 + np.abs(right).max(axis=1)))


def _kept(
    problem: ir.Problem, ring: tuple[Joined, ...], nodes: Mapping[Node, Frames], taken: Array, safety: float
) -> Flags:
    """At which instants `(T,)` all strengths of a ring are kept."""
    kept = np.ones(len(taken), dtype=bool)
    for edge, wrench in _by_edge(ring, taken).items():
        for figure in judge(problem, edge, nodes, *wrench, safety):
            kept &= figure.amounts <= LIMITS[figure.kind]
    return kept


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
    return np.asarray(solved.x[:width]) if off <= BALANCE * (1.0 + np.abs(right).max()) else np.full(width, math.nan)


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
        side = crossed(axis, np.eye(3)[np.argmin(np.abs(axis), axis=1)])
        side /= np.linalg.norm(side, axis=1, keepdims=True)
        if math.isfinite(joint.bearing):
            for direction in _round(side, crossed(axis, side)):
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
    return np.concatenate([crossed(place, direction), direction], axis=1)


def _round(first: Array, second: Array) -> list[Array]:
    angles = np.pi * np.arange(CORNERS // 2) / (CORNERS // 2)
    return [np.cos(a) * first + np.sin(a) * second for a in angles]


