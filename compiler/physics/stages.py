"""Rows of motion programs that keep loads at rest within strengths, for structures without closed loops.

A row is (safety · load / strength)² - 1 <= 0: of drives, bearings, docks and feet, as in `statics`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import casadi as ca

from ..ir import Fact, Hold, JointKind, ModuleType, Problem, ShapeKind
from ..motion.kinematics import Expression, Frame, axes, effector_frame, joint_frames, pose_frame, rotate
from ..motion.stages import Stage
from .frames import GRAVITY, foot_radius, module_weights
from .masses import body_mass
from .records import CONTACTS
from .structure import WORLD, Node, structure

Place = tuple[int, int]
"""A slot by number, -1 for the world, and the joint of the module in it."""


@dataclass(frozen=True, slots=True)
class _Bond:
    """An edge without names: whom it joins, and what bounds it."""

    parent: Place
    child: Place
    joint: int = -1
    owner: int = -1
    manner: str = ""
    hold: Hold | None = None
    meets: tuple[int, str] = (-1, "")
    radius: float = 0.0


@dataclass(frozen=True, slots=True)
class Rows:
    """A stage, and the names of the slots that are its variables, in order."""

    stage: Stage
    slots: tuple[str, ...]


def rows_of(problem: Problem, mode: frozenset[Fact], safety: float) -> Rows | None:
    """The rows of a mode; None where nothing is bounded, or where loops leave loads open."""
    found = structure(problem, mode)
    if found.loops or not found.edges:
        return None
    names = list(dict.fromkeys(e.child[0] for e in found.edges))
    number = {name: k for k, name in enumerate(names)}

    def place(node: Node) -> Place:
        return (-1, -1) if node == WORLD else (number[node[0]], node[1])

    bonds = []
    for edge in found.edges:
        parent, child = place(edge.parent), place(edge.child)
        if edge.is_joint:
            bonds.append(_Bond(parent, child, edge.joint, number[edge.names[0]]))
        elif edge.hold is None:
            bonds.append(_Bond(parent, child))
        else:
            end = problem.world.effector(edge.place)
            meets = (number[end[0].name], end[1].name) if end is not None else (number.get(edge.place, -1), "")
            radius = foot_radius(problem, edge.place)
            bonds.append(_Bond(parent, child, -1, -1, edge.manner, edge.hold, meets, radius))
    world = problem.world
    kinds = tuple(world.modules[n].type if n in world.modules else body_mass(world.bodies[n]) for n in names)
    made = _stage(kinds, tuple(bonds), safety)
    return None if made is None else Rows(made, tuple(names))


@cache
def _stage(kinds: tuple[ModuleType | float, ...], bonds: tuple[_Bond, ...], safety: float) -> Stage | None:
    sizes = [7 + len(k.joints) if isinstance(k, ModuleType) else 7 for k in kinds]
    variables = ca.SX.sym("x", sum(sizes))
    slots, start = [], 0
    for size in sizes:
        slots.append(variables[start : start + size])
        start += size
    frames = [
        joint_frames(k, slot) if isinstance(k, ModuleType) else [pose_frame(slot)]
        for k, slot in zip(kinds, slots, strict=True)
    ]
    mass, moment = _weighed(kinds, frames)
    rows: list[Expression] = []
    for bond in reversed(bonds):
        own_mass, own_moment = mass[bond.child], moment[bond.child]
        rows += _rows(bond, kinds, slots, frames, own_mass, own_moment, safety)
        if bond.parent[0] >= 0:
            mass[bond.parent] += own_mass
            moment[bond.parent] += own_moment
    return Stage("bearing", variables, ca.SX.sym("p", 0), ca.vertcat(*rows)) if rows else None


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


def _rows(
    bond: _Bond, kinds: Sequence[ModuleType | float], slots: Sequence[Expression], frames: Sequence[Sequence[Frame]],
    mass: float, moment: Expression, safety: float,
) -> list[Expression]:  # fmt: skip
    found: list[Expression] = []

    def within(amount: Expression, strength: float) -> None:
        """amount is the square of a load."""
        if math.isfinite(strength):
            found.append(amount * (safety / strength) ** 2 - 1.0)

    def turning(place: Expression) -> Expression:
        lever = moment - mass * place
        return ca.vertcat(-GRAVITY * lever[1], GRAVITY * lever[0], 0)

    if bond.joint >= 0:
        kind = kinds[bond.owner]
        assert isinstance(kind, ModuleType)
        joint, frame = kind.joints[bond.joint], frames[bond.owner][bond.joint + 1]
        length = math.sqrt(sum(a * a for a in joint.axis))
        axis = rotate(frame.quaternion, ca.SX(ca.DM([a / length for a in joint.axis])))
        bent = turning(frame.position)
        along = ca.dot(axis, bent)
        if joint.kind == JointKind.REVOLUTE:
            within(along**2, joint.torque)
            within(ca.sumsqr(bent) - along**2, joint.bearing)
        else:
            within((GRAVITY * mass * axis[2]) ** 2, joint.torque)
            within(ca.sumsqr(bent), joint.bearing)
        return found
    hold = bond.hold
    if hold is None or bond.meets[0] < 0:
        return found
    slot, end = bond.meets
    kind = kinds[slot]
    frame = effector_frame(kind, end, slots[slot]) if isinstance(kind, ModuleType) else frames[slot][0]
    if bond.manner in CONTACTS:
        bent = turning(frame.position)
        sticks = hold.force if bond.manner == "pad" else 0.0
        within(ca.sumsqr(bent), hold.moment)
        if not math.isfinite(hold.moment) and math.isfinite(sticks):
            within(ca.sumsqr(bent), bond.radius * (sticks + GRAVITY * mass))
        return found
    turn = axes(frame.quaternion)
    shape = kind.effector(end).shape if isinstance(kind, ModuleType) else None
    out = shape.size[0] if shape is not None and shape.kind == ShapeKind.SPHERE else 0.0
    bent = turning(frame.position + out * turn[:, 2])
    about, down = ca.dot(turn[:, 2], bent), GRAVITY * mass * turn[2, 2]
    within(ca.sumsqr(bent) - about**2, hold.moment)
    within(about**2, hold.twist)
    within(down**2, hold.force)
    shear = min(hold.shear, hold.friction * hold.force) if bond.manner == "grip" else hold.shear
    within((GRAVITY * mass) ** 2 - down**2, shear)
    return found


