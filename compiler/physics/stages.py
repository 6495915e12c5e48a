"""Loads at rest as CasADi expressions, for structures without closed loops, and rows of motion programs that keep them
within strengths.

A row is (safety · load / strength)² - 1 <= 0: of drives, bearings, docks and feet, as in `statics`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import casadi as ca

from ...langs.frozen import dataclass
from ..ir import Fact, Hold, JointKind, ModuleType, Problem, ShapeKind
from ..motion.kinematics import Expression, Frame, axes, effector_frame, joint_frames, pose_frame, rotate
from ..motion.stages import Stage
from .frames import GRAVITY, module_weights
from .masses import body_mass
from .outlines import foot_radius
from .records import CONTACTS
from .structure import WORLD, Edge, Node, driven, structure

Place = tuple[int, int]
"""A slot by number, -1 for the world, and the joint of the module in it."""
SMOOTH = 1e-12
"""Squared ratios under a root: keeps its derivative finite where nothing is loaded."""


@dataclass(frozen=True, slots=True)
class Bond:
    """An edge without names: whom it joins, and what bounds it. `ahead`: the child is what moves with the joint."""

    parent: Place
    child: Place
    joint: int = -1
    owner: int = -1
    manner: str = ""
    hold: Hold | None = None
    meets: tuple[int, str] = (-1, "")
    radius: float = 0.0
    ahead: bool = True


@dataclass(frozen=True, slots=True)
class LoadGraph:
    """A structure without names: what is in its slots (module types, masses of bodies), and its bonds, each behind the
    one that bears its parent."""

    kinds: tuple[ModuleType | float, ...]
    bonds: tuple[Bond, ...]
    safety: float
    still: bool = True
    """Whether joints do not move there, so that brakes hold."""

    @property
    def sizes(self) -> list[int]:
        """How many numbers each slot has."""
        return [7 + len(k.joints) if isinstance(k, ModuleType) else 7 for k in self.kinds]


@dataclass(frozen=True, slots=True)
class Rows:
    """A stage, the names of the slots that are its variables, in order, and the edge that each row bounds."""

    stage: Stage
    slots: tuple[str, ...]
    edges: tuple[Edge, ...]


def graph_of(problem: Problem, mode: frozenset[Fact], safety: float) -> tuple[LoadGraph, tuple[str, ...]] | None:
    """The structure of a mode, with the names of its slots; None where loops leave loads open."""
    found = structure(problem, mode)
    if found.loops:
        return None
    names = list(dict.fromkeys(e.child[0] for e in found.edges))
    number = {name: k for k, name in enumerate(names)}

    def place(node: Node) -> Place:
        return (-1, -1) if node == WORLD else (number[node[0]], node[1])

    bonds = []
    for edge in found.edges:
        parent, child = place(edge.parent), place(edge.child)
        if edge.is_joint:
            ahead = edge.child == (edge.names[0], edge.joint)
            bonds.append(Bond(parent, child, edge.joint, number[edge.names[0]], ahead=ahead))
            continue
        end = problem.world.effector(edge.place)
        meets = (number[end[0].name], end[1].name) if end is not None else (number.get(edge.place, -1), "")
        radius = 0.0 if edge.place not in problem.world.bodies and end is None else foot_radius(problem, edge.place)
        bonds.append(Bond(parent, child, -1, -1, edge.manner, edge.hold, meets, radius))
    world = problem.world
    kinds = tuple(world.modules[n].type if n in world.modules else body_mass(world.bodies[n]) for n in names)
    return LoadGraph(kinds, tuple(bonds), safety), tuple(names)


def rows_of(problem: Problem, mode: frozenset[Fact], safety: float, *, still: bool = True) -> Rows | None:
    """The rows of a mode, while joints are `still` or move; None where nothing is bounded, or where loops leave loads
    open."""
    found = graph_of(problem, mode, safety)
    if found is None or not found[0].bonds:
        return None
    made = _stage(replace(found[0], still=still))
    if made is None:
        return None
    edges = structure(problem, mode).edges
    return Rows(made[0], found[1], tuple(edges[number] for number in made[1]))


@cache
def _stage(graph: LoadGraph) -> tuple[Stage, tuple[int, ...]] | None:
    """The stage of all rows, and the bond of each."""
    variables = ca.SX.sym("x", sum(graph.sizes))
    loads = SymbolicLoads(graph, variables)
    rows, whose = list[Expression](), list[int]()
    for number in reversed(range(len(graph.bonds))):
        found = loads.squares(number)
        rows += [square - 1.0 for square in found]
        whose += [number] * len(found)
    if not rows:
        return None
    return Stage("bearing", variables, ca.SX.sym("p", 0), ca.vertcat(*rows)), tuple(whose)


class SymbolicLoads:
    """What the bonds of a graph bear, as expressions of its slots."""

    def __init__(self, graph: LoadGraph, variables: Expression) -> None:
        self.graph = graph
        self._slots, start = list[Expression](), 0
        for size in graph.sizes:
            self._slots.append(variables[start : start + size])
            start += size
        self._frames = [
            joint_frames(k, slot) if isinstance(k, ModuleType) else [pose_frame(slot)]
            for k, slot in zip(graph.kinds, self._slots, strict=True)
        ]
        mass, moment = _weighed(graph.kinds, self._frames)
        self._mass, self._moment = list[float](), list[Expression]()
        for bond in reversed(graph.bonds):
            self._mass.insert(0, mass[bond.child])
            self._moment.insert(0, moment[bond.child])
            if bond.parent[0] >= 0:
                mass[bond.parent] += mass[bond.child]
                moment[bond.parent] += moment[bond.child]

    def ratio(self, numbers: Sequence[int]) -> Expression:
        """The worst ratio of load, times the safety, to strength of some bonds."""
        worst = ca.SX(0.0)
        for number in numbers:
            for square in self.squares(number):
                worst = ca.fmax(worst, square)
        return ca.sqrt(worst + SMOOTH)

    def drive(self, number: int) -> Expression:
        """What the drive of a joint gives, N m or N."""
        along = self._along(number)
        return -along if self.graph.bonds[number].ahead else along

    def wrench(self, number: int) -> Expression:
        """Force and moment (6,) that the child of a pair puts on its parent, in the axes of where they meet."""
        place, turn = self._meeting(number)
        weight = ca.vertcat(0, 0, -GRAVITY * self._mass[number])
        return ca.vertcat(turn.T @ weight, turn.T @ self._turning(number, place))

    def _turning(self, number: int, place: Expression) -> Expression:
        """The moment about a place of what a bond carries."""
        lever = self._moment[number] - self._mass[number] * place
        return ca.vertcat(-GRAVITY * lever[1], GRAVITY * lever[0], 0)

    def _axis(self, number: int) -> tuple[Expression, Frame]:
        bond = self.graph.bonds[number]
        kind, frame = self.graph.kinds[bond.owner], self._frames[bond.owner][bond.joint + 1]
        assert isinstance(kind, ModuleType)
        given = kind.joints[bond.joint].axis
        length = math.sqrt(sum(a * a for a in given))
        return rotate(frame.quaternion, ca.SX(ca.DM([a / length for a in given]))), frame

    def _along(self, number: int) -> Expression:
        bond = self.graph.bonds[number]
        kind = self.graph.kinds[bond.owner]
        assert isinstance(kind, ModuleType)
        axis, frame = self._axis(number)
        if kind.joints[bond.joint].kind == JointKind.REVOLUTE:
            return ca.dot(axis, self._turning(number, frame.position))
        return -GRAVITY * self._mass[number] * axis[2]

    def _meeting(self, number: int) -> tuple[Expression, Expression]:
        """Where a pair meets, and its axes as columns."""
        bond = self.graph.bonds[number]
        slot, end = bond.meets
        if slot < 0:
            return self._frames[bond.child[0]][bond.child[1] + 1].position, ca.SX.eye(3)
        kind = self.graph.kinds[slot]
        if isinstance(kind, ModuleType):
            frame, shape = effector_frame(kind, end, self._slots[slot]), kind.effector(end).shape
        else:
            frame, shape = self._frames[slot][0], None
        if bond.manner in CONTACTS:
            place = frame.position
            if isinstance(kind, ModuleType) and driven(kind, kind.effector(end).joint) != kind.effector(end).joint:
                under = self._frames[slot][driven(kind, kind.effector(end).joint) + 1].position
                place = ca.vertcat(under[0], under[1], place[2])
            return place, ca.SX.eye(3)
        turn = axes(frame.quaternion)
        out = shape.size[0] if shape is not None and shape.kind == ShapeKind.SPHERE else 0.0
        return frame.position + out * turn[:, 2], turn

    def squares(self, number: int) -> list[Expression]:
        """Squared ratios of load, times the safety, to strength, of everything that a bond bounds."""
        bond, found = self.graph.bonds[number], list[Expression]()

        def within(amount: Expression, strength: float) -> None:
            """amount is the square of a load."""
            if math.isfinite(strength):
                found.append(amount * (self.graph.safety / strength) ** 2)

        if bond.joint >= 0:
            kind = self.graph.kinds[bond.owner]
            assert isinstance(kind, ModuleType)
            joint, along = kind.joints[bond.joint], self._along(number)
            bent = ca.sumsqr(self._turning(number, self._axis(number)[1].position))
            within(along**2, joint.strength(still=self.graph.still))
            within(bent - along**2 if joint.kind == JointKind.REVOLUTE else bent, joint.bearing)
            return found
        hold, mass = bond.hold, self._mass[number]
        if hold is None or bond.meets[0] < 0:
            return found
        place, turn = self._meeting(number)
        bent = self._turning(number, place)
        if bond.manner in CONTACTS:
            sticks = hold.force if bond.manner == "pad" else 0.0
            within(ca.sumsqr(bent), hold.moment)
            if not math.isfinite(hold.moment) and math.isfinite(sticks):
                within(ca.sumsqr(bent), bond.radius * (sticks + GRAVITY * mass))
            return found
        about, down = ca.dot(turn[:, 2], bent), GRAVITY * mass * turn[2, 2]
        within(ca.sumsqr(bent) - about**2, hold.moment)
        within(about**2, hold.twist)
        within(down**2, hold.force)
        shear = min(hold.shear, hold.friction * hold.force) if bond.manner == "grip" else hold.shear
        within((GRAVITY * mass) ** 2 - down**2, shear)
        return found


def _weighed(
    kinds: Sequence[ModuleType | float], frames: Sequence[Sequence[Frame]]
) -> tuple[dict[Place, float], dict[Place, Expression]]:
    """Mass, and mass times centre, of every node."""
    mass: dict[Place, float] = {}
    moment: dict[Place, Expression] = {}
    for number, kind in enumerate(kinds):
        for joint in range(-1, len(frames[number]) - 1):
            mass[number, joint], moment[number, joint] = 0.0, ca.SX.zeros(3)
        if isinstance(kind, ModuleType):
            for joint, weight in module_weights(kind).items():
                frame = frames[number][joint + 1]
                centre = frame.position + rotate(frame.quaternion, ca.SX(ca.DM(weight.centre)))
                mass[number, joint], moment[number, joint] = weight.mass, weight.mass * centre
        else:
            mass[number, -1], moment[number, -1] = kind, kind * frames[number][0].position
    return mass, moment
