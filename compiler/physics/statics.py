"""Loads of joints and kept pairs, at rest or in motion, for the planner: trees by recursion from their tips, closed
loops by a small program that shares the loads so that the worst one is least.

A wrench is what the far side of an edge puts on the near one: force (N) and moment (N m) about the world's origin. The
verifier has its own.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ...langs.frozen import dataclass
from ..ir import Fact, Hold, JointKind, Problem
from .frames import Array, Poses, crossed, meeting, node_weights, node_wrench
from .loops import shared
from .outlines import foot_radius
from .records import CONTACTS
from .structure import WORLD, Edge, Node, Structure, structure

KINDS = {
    "torque": "a torque", "bearing": "a bending moment", "dock": "a load", "foot": "a load",
    "slip": "a force across of {} of what friction holds", "tip": "a moment of {} of what its edge holds",
}  # fmt: skip
LIMITLESS = 1e3
"""A ratio that stands for a load that nothing could bear, as of a thing that is pulled off what only rests."""


@dataclass(frozen=True, slots=True)
class Load:
    """How near an edge comes to its strength over the samples `(T,)`: `ratio`, of what kind: torque, bearing, dock,
    foot, and of what friction and edges hold, slip and tip; `amount` and `strength` in `unit` where the
    ratio is greatest."""

    edge: Edge
    kind: str
    ratio: Array
    amount: Array
    strength: float
    unit: str


    @property
    def names(self) -> str:
        """Whom it concerns, for people."""
        first, second = self.edge.names
        return f"joint {second} of {first}" if self.edge.is_joint else f"{first} and {second}"

    def told(self, safety: float) -> str:
        """The greatest load in words: `joint j2 of c: a torque of 73 N m, 1.5 times, is 2.9 times the 38 N m that it
        bears`."""
        worst = int(np.argmax(self.ratio))
        if not self.unit:
            return f"{self.names}: {KINDS[self.kind].format(f'{self.amount[worst]:.3g}')}, {safety:g} times"
        amount, strength = f"{self.amount[worst]:.3g} {self.unit}", f"{self.strength:.3g} {self.unit}"
        ratio = f"is {self.ratio[worst]:.3g} times the {strength} that it bears"
        return f"{self.names}: {KINDS[self.kind]} of {amount}, {safety:g} times, {ratio}"


def loads(problem: Problem, mode: frozenset[Fact], at: Poses, safety: float = 1.0) -> list[Load]:
    """The loads of everything in a mode that states a strength, times `safety`, over that strength."""
    found = structure(problem, mode)
    return [
        load
        for edge, (force, moment) in zip(found.all, wrenches(problem, found, at, safety), strict=True)
        for load in loads_of(problem, edge, at, force, moment, safety)
    ]


def drives(problem: Problem, mode: frozenset[Fact], at: Poses, safety: float = 1.0) -> dict[tuple[str, int], Array]:
    """The torques (N m, of prismatic joints forces in N) `(T,)` that the drives of a mode give, by module and joint."""
    built = structure(problem, mode)
    return drives_of(problem, built, at, wrenches(problem, built, at, safety))


def drives_of(
    problem: Problem, built: Structure, at: Poses, borne: Sequence[tuple[Array, Array]]
) -> dict[tuple[str, int], Array]:
    """The same where the wrenches of all edges are known."""
    found: dict[tuple[str, int], Array] = {}
    for edge, (force, moment) in zip(built.all, borne, strict=True):
        if edge.is_joint:
            node = (edge.names[0], edge.joint)
            joint = problem.world.modules[node[0]].type.joints[edge.joint]
            axis = at.turns[node] @ (np.asarray(joint.axis) / np.linalg.norm(joint.axis))
            own = moment - crossed(at.places[node], force) if joint.kind == JointKind.REVOLUTE else force
            found[node] = (-1.0 if edge.child == node else 1.0) * (own * axis).sum(axis=1)
    return found


def met(problem: Problem, edge: Edge, at: Poses, force: Array, moment: Array) -> tuple[Array, Array]:
    """What the second of a pair's `names` puts on the first `(T, 3)`, in the axes of where they meet."""
    place, axes = meeting(problem, edge, at)
    own = np.einsum("tij,ti->tj", axes, force)
    bent = np.einsum("tij,ti->tj", axes, moment - crossed(place, force))
    return (-own, -bent) if edge.turned else (own, bent)


def wrenches(problem: Problem, found: Structure, at: Poses, safety: float) -> list[tuple[Array, Array]]:
    """Force and moment about the origin `(T, 3)` that the far side of every edge puts on the near one."""
    borne = hanging(problem, found, at)
    return shared(problem, found, at, borne, safety) if found.loops else borne


def hanging(problem: Problem, found: Structure, at: Poses) -> list[tuple[Array, Array]]:
    """The same of the edges of the trees, where loops take nothing."""
    nodes = [e.child for e in found.edges if e.child in at.turns]
    count = len(at.turns[WORLD])
    sums: dict[Node, tuple[Array, Array]] = {n: (np.zeros((count, 3)), np.zeros((count, 3))) for n in (WORLD, *nodes)}
    for node, weight in node_weights(problem, nodes).items():
        sums[node] = node_wrench(weight, at.turns[node], at.places[node], at.times, at.group)
    borne: list[tuple[Array, Array]] = [(np.zeros(0), np.zeros(0))] * len(found.edges)
    for number in reversed(range(len(found.edges))):
        edge = found.edges[number]
        borne[number] = sums[edge.child]
        force, moment = sums[edge.parent]
        sums[edge.parent] = force + sums[edge.child][0], moment + sums[edge.child][1]
    return borne


def loads_of(problem: Problem, edge: Edge, at: Poses, force: Array, moment: Array, safety: float) -> list[Load]:
    """The loads of an edge under a wrench about the origin, times `safety`, over its strengths."""
    if edge.is_joint:
        return _joint_loads(problem, edge, at, force, moment, safety)
    if edge.hold is None:
        return []
    own, bent = met(problem, edge, at, force, moment)
    kind = "foot" if edge.manner in CONTACTS else "dock"
    rows = _held(edge.hold, own, bent, foot_radius(problem, edge.place), edge.manner, safety)
    return [
        Load(edge, own or kind, safety * amount / strength, amount, strength, unit)
        for amount, strength, unit, own in rows
    ]


def _joint_loads(problem: Problem, edge: Edge, at: Poses, force: Array, moment: Array, safety: float) -> list[Load]:
    joint = problem.world.modules[edge.names[0]].type.joints[edge.joint]
    node = (edge.names[0], edge.joint)
    axis = at.turns[node] @ (np.asarray(joint.axis) / np.linalg.norm(joint.axis))
    own = moment - crossed(at.places[node], force)
    along = (own if joint.kind == JointKind.REVOLUTE else force) * axis
    drive = np.abs(along.sum(axis=1))
    found = []
    strength = joint.strength(still=node not in at.moved)
    if math.isfinite(strength):
        unit = "N m" if joint.kind == JointKind.REVOLUTE else "N"
        found.append(Load(edge, "torque", safety * drive / strength, drive, strength, unit))
    if math.isfinite(joint.bearing):
        across = own - axis * (own * axis).sum(axis=1, keepdims=True) if joint.kind == JointKind.REVOLUTE else own
        bent = np.linalg.norm(across, axis=1)
        found.append(Load(edge, "bearing", safety * bent / joint.bearing, bent, joint.bearing, "N m"))
    return found


def _held(
    hold: Hold, force: Array, moment: Array, radius: float, manner: str, safety: float
) -> list[tuple[Array, float, str, str]]:
    """What a pair bears of force and moment in its own axes, as amounts, strengths, units, and kinds of their own. What
    presses on a contact is force along -z."""
    across, bend = np.linalg.norm(force[:, :2], axis=1), np.linalg.norm(moment[:, :2], axis=1)
    twist = np.abs(moment[:, 2])
    rows: list[tuple[Array, float, str, str]] = []
    for amount, strength, unit in ((across, hold.shear, "N"), (bend, hold.moment, "N m"), (twist, hold.twist, "N m")):
        if math.isfinite(strength):
            rows.append((amount, strength, unit, ""))
    if manner not in CONTACTS:
        if math.isfinite(hold.force):
            rows.append((np.abs(force[:, 2]), hold.force, "N", ""))
        if manner == "grip" and math.isfinite(hold.friction) and math.isfinite(hold.force):
            rows.append((across, hold.friction * hold.force, "N", ""))
        return rows
    sticks = hold.force if manner == "pad" else 0.0
    pull = np.maximum(force[:, 2], 0.0)
    if sticks > 0.0 and math.isfinite(sticks):
        rows.append((pull, sticks, "N", ""))
    if not math.isfinite(sticks):
        return rows
    held = np.maximum(sticks - force[:, 2], 1e-9)
    if math.isfinite(hold.friction):
        rows.append((np.minimum(across / (hold.friction * held), LIMITLESS), 1.0, "", "slip"))
    if not math.isfinite(hold.moment):
        rows.append((np.minimum(bend / (radius * held), LIMITLESS), 1.0, "", "tip"))
    return rows
