"""One length unit per problem: robots that are very small or very large are planned for as if they reached a metre.

Lengths, tolerances and weights of the motion programs are those of robots of about a metre. The bounds see a problem
whose unit of length is the reach of its largest module, and whose unit of time is such that gravity stays what it is
(Froude): forces and masses then keep their figures, moments are divided by the unit of length. What they answer is
turned back.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import chain
from typing import Any

import numpy as np

from ....compiler import ir
from ....compiler.motion.collision import shape_reach
from ....compiler.motion.constraints import METRES, units
from ....compiler.physics.masses import part_mass
from ....compiler.physics.records import Hold, Inertial
from ....langs.trees import mapped
from ...skeleton import Array, BoundResult, Configuration, PhasePath, Skeleton, Violation
from ..motion.keyframes.causes import Cause
from ..motion.settings import ACCEPTANCE
from .scaled_rows import in_unit
from .settings import BOUNDS
from .verdicts import Conflict, Judgement


def length_unit(problem: ir.Problem) -> float:
    """The unit of length of a problem, in metres: 1 where its robots are of the usual size, else the reach of the
    largest of them. Where only slides make that long, as those of a plate that drives about a hall, or of a small robot
    on a table, it is no larger than it must: what moves, and the clearances that are wished for, are of the usual
    size."""
    types = [m.type for m in problem.world.modules.values()]
    reach = max(map(_reach, types), default=1.0)
    bodily = max(map(_bodily, types), default=1.0)
    least, greatest = BOUNDS.least_reach, BOUNDS.greatest_reach
    if reach == 0.0 or (reach <= greatest and bodily >= least):
        return 1.0
    return reach / greatest if bodily <= greatest < reach else min(reach, max(bodily, reach / greatest))


def _reach(type_: ir.ModuleType) -> float:
    """How far from its frame a module comes at most, in metres."""
    return max((length for length, _ in _parts(type_, slides=True)), default=0.0)


def _bodily(type_: ir.ModuleType) -> float:
    """How far from its frame the shapes of a module come at most, in metres, as if nothing slid."""
    parts = _parts(type_, slides=False)
    return max((length + (shape_reach(shape) if shape else 0.0) for length, shape in parts), default=0.0)


def _parts(type_: ir.ModuleType, slides: bool) -> Iterator[tuple[float, ir.Shape | None]]:
    """How far out each end and link of a module is at most, in metres, and its shape."""
    lengths = [0.0]
    for joint in type_.joints:
        slide = joint.slide if slides else 0.0
        lengths.append(lengths[joint.parent + 1] + math.hypot(*joint.placement[:3]) + slide)
    parts = [*[(e.joint, e.placement, e.shape) for e in type_.effectors],
             *[(k.joint, k.placement, k.shape) for k in type_.links]]  # fmt: skip
    for parent, placement, shape in parts:
        yield lengths[parent + 1] + math.hypot(*placement[:3]), shape


class LengthUnit:
    """A problem in its own unit of length, and the way there and back."""

    def __init__(self, problem: ir.Problem, metres: float | None = None) -> None:
        self.metres = length_unit(problem) if metres is None else metres
        self._given = problem
        self.seconds = math.sqrt(self.metres)
        self.plain = self.metres == 1.0
        self.problem = problem if self.plain else self._problem(problem)

    # --- there ----------------------------------------------------------------------------------------------------

    def skeleton(self, skeleton: Skeleton) -> Skeleton:
        return skeleton if self.plain else replace(skeleton, problem=self.problem)

    def _problem(self, problem: ir.Problem) -> ir.Problem:
        types = {m.type.name: self._type(m.type) for m in problem.world.modules.values()}
        modules = {
            name: replace(
                m, type=types[m.type.name], pose=self._pose(m.pose), joints=tuple(self._joints(m.type, m.joints))
            )
            for name, m in problem.world.modules.items()
        }
        bodies = {
            name: replace(
                b, pose=self._pose(b.pose), shape=self._shape(b.shape), mass=part_mass(b.shape, b.mass),
                holds=self._holds(b.holds),
            )
            for name, b in problem.world.bodies.items()
        }  # fmt: skip
        motions = {
            name: replace(m, rows=tuple(self._row(row) for row in m.rows))
            for name, m in problem.motions.items()
        }
        return replace(problem, world=replace(problem.world, modules=modules, bodies=bodies), motions=motions)

    def _row(self, row: ir.Row) -> ir.Row:
        """The same row in the unit. Where it is not plain which of its numbers are lengths, these stay in metres: what
        is measured beside them becomes metres, too, and the whole is turned back. Poses that are kept are compared with
        poses alone."""
        if isinstance(row.left, ir.Function) and row.left.name == "pose":
            return row
        plain = in_unit(row, self.metres)
        if plain is not None:
            return plain

        def in_metres(term: Any) -> Any:
            inner = mapped(term, in_metres)
            if not isinstance(inner, ir.Function):
                return inner
            if inner.name == "wrench":
                return ir.Arith("*", (ir.Vector((ir.Number(1.0),) * 3 + (ir.Number(self.metres),) * 3), inner))
            long = inner.name in METRES or (inner.name == "torque" and self._turns(inner.args[1]))
            return ir.Arith("*", (ir.Number(self.metres), inner)) if long else inner

        left, right = in_metres(row.left), in_metres(row.right or ir.Number(0.0))
        if units(row)[0] == "m":
            left, right = (ir.Arith("/", (side, ir.Number(self.metres))) for side in (left, right))
        return replace(row, left=left, right=row.right and right)

    def _turns(self, joint: ir.Term) -> bool:
        """Whether a joint of that name turns: what its drive gives is then a moment."""
        types = {m.type for m in self._given.world.modules.values()}
        named = [j for t in types for j in t.joints if isinstance(joint, ir.Letter) and j.name == joint.letter]
        return any(j.kind == ir.JointKind.REVOLUTE for j in named)

    def _type(self, type_: ir.ModuleType) -> ir.ModuleType:
        return replace(
            type_,
            joints=tuple(self._joint(type_, joint) for joint in type_.joints),
            effectors=tuple(
                replace(
                    e, placement=self._pose(e.placement), shape=e.shape and self._shape(e.shape),
                    mass=e.mass if e.shape is None else part_mass(e.shape, e.mass), holds=self._holds(e.holds),
                )
                for e in type_.effectors
            ),
            links=tuple(
                replace(
                    link, placement=self._pose(link.placement), shape=self._shape(link.shape),
                    mass=part_mass(link.shape, link.mass),
                )
                for link in type_.links
            ),
            inertials=tuple(self._inertial(i) for i in type_.inertials),
        )  # fmt: skip

    def _joint(self, type_: ir.ModuleType, joint: ir.Joint) -> ir.Joint:
        size, time = self.metres, self.seconds
        long = size if joint.kind == ir.JointKind.PRISMATIC else 1.0
        moment = 1.0 if joint.kind == ir.JointKind.PRISMATIC else size
        follows = joint.follows
        if follows is not None:
            led = size if type_.joints[follows.leader].kind == ir.JointKind.PRISMATIC else 1.0
            follows = replace(follows, factor=follows.factor * led / long, offset=follows.offset / long)
        return replace(
            joint, placement=self._pose(joint.placement), lower=joint.lower / long, upper=joint.upper / long,
            home=joint.home / long, speed=joint.speed * time / long, follows=follows,
            acceleration=joint.acceleration * time**2 / long, torque=joint.torque / moment,
            bearing=joint.bearing / size, rotor=joint.rotor / moment**2, brake=joint.brake / moment,
        )  # fmt: skip

    def _inertial(self, inertial: ir.Inertial) -> ir.Inertial:
        x, y, z = (value / self.metres for value in inertial.centre)
        xx, xy, xz, yy, yz, zz = (value / self.metres**2 for value in inertial.inertia)
        return Inertial(inertial.joint, inertial.mass, (x, y, z), (xx, xy, xz, yy, yz, zz))

    def _holds(self, holds: tuple[Hold, ...]) -> tuple[Hold, ...]:
        return tuple(replace(h, moment=h.moment / self.metres, twist=h.twist / self.metres) for h in holds)

    def _shape(self, shape: ir.Shape) -> ir.Shape:
        parts = tuple(ir.SolidPart(self._point(p.at), self._shape(p.shape)) for p in shape.parts)
        return replace(shape, size=tuple(value / self.metres for value in shape.size), parts=parts)

    def _point(self, at: ir.Vec3) -> ir.Vec3:
        return at[0] / self.metres, at[1] / self.metres, at[2] / self.metres

    def _pose(self, pose: ir.Pose) -> ir.Pose:
        x, y, z, *turn = pose
        a, b, c, w = turn
        return (x / self.metres, y / self.metres, z / self.metres, a, b, c, w)

    def _joints(self, type_: ir.ModuleType, values: tuple[float, ...]) -> list[float]:
        return [
            value / self.metres if joint.kind == ir.JointKind.PRISMATIC else value
            for joint, value in zip(type_.joints, values, strict=True)
        ]

    def configuration(self, configuration: Configuration) -> Configuration:
        return configuration if self.plain else self._configuration(configuration, 1.0 / self.metres)

    # --- and back -------------------------------------------------------------------------------------------------

    def judgement(self, judgement: Judgement) -> Judgement:
        """What the bounds say, in metres and seconds."""
        if self.plain:
            return judgement
        paths = judgement.paths
        return replace(
            judgement,
            paths=None if paths is None else [self._path(path) for path in paths],
            conflicts=[self._conflict(conflict) for conflict in judgement.conflicts],
            ahead=[self._configuration(c, self.metres) for c in judgement.ahead],
        )

    def result(self, result: BoundResult) -> BoundResult:
        """What one bound says, in metres and seconds."""
        if self.plain:
            return result
        return replace(
            result,
            configurations=[self._configuration(c, self.metres) for c in result.configurations],
            paths=[self._path(path) for path in result.paths],
            violations=[self._violation(v) for v in result.violations],
        )

    def cause(self, cause: Cause) -> Cause:
        """Why something is refused, in metres."""
        return replace(
            cause, missed=self._violation(cause.missed), at=tuple(map(self._violation, cause.at)),
            nearest=self._configuration(cause.nearest, self.metres),
        )  # fmt: skip

    def _path(self, path: PhasePath) -> PhasePath:
        """A little slower than in its own unit, so that times are round."""
        seconds = math.ceil(path.duration * self.seconds * 100.0 - 1e-6) / 100.0
        ends = self._configuration(Configuration(path.modules, path.bodies), self.metres)
        return PhasePath(ends.modules, dict(ends.bodies), max(ACCEPTANCE.shortest_phase, seconds))

    def _configuration(self, configuration: Configuration, factor: float) -> Configuration:
        """Poses `(…, 7)` and slots `(…, 7 + n)` with their lengths multiplied."""
        modules = {name: slot * self._lengths(name, factor) for name, slot in configuration.modules.items()}
        of_body = np.array([factor] * 3 + [1.0] * 4)
        return configuration.then(modules, {name: pose * of_body for name, pose in configuration.bodies.items()})

    def _lengths(self, module: str, factor: float) -> Array:
        joints = self.problem.world.modules[module].type.joints
        return np.array(list(chain(
            [factor] * 3, [1.0] * 4, (factor if j.kind == ir.JointKind.PRISMATIC else 1.0 for j in joints)
        )))  # fmt: skip

    def _conflict(self, conflict: Conflict) -> Conflict:
        switches = tuple(self._configuration(c, self.metres) for c in conflict.switches)
        return replace(conflict, violations=tuple(self._violation(v) for v in conflict.violations), switches=switches)

    def _violation(self, violation: Violation) -> Violation:
        long = violation.unit in ("m", "N m", "Nm")
        if not long:
            return violation
        load = violation.load and (violation.load[0] * self.metres, violation.load[1], violation.load[2] * self.metres)
        return replace(
            violation, amount=violation.amount * self.metres, asked=violation.asked * self.metres, load=load
        )
