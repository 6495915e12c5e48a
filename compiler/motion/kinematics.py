"""Symbolic kinematics of modules, as CasADi expressions.

Quaternions are x, y, z, w. A module's slot is `(7 + n,)`: pose of its module frame in the world, whose quaternion is
normalised here, then its n joint values, of which those of joints that follow others do not count; a body's slot is
its pose `(7,)`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache, wraps
from typing import Any, TypeAlias

import casadi as ca

from ...langs.frozen import dataclass
from ..ir import Joint, JointKind, ModuleType, Pose
from ..joint_lines import line

Expression: TypeAlias = Any
"""A `casadi.SX` column, or for scalars also a float: CasADi carries no types."""


@dataclass(frozen=True, slots=True)
class Frame:
    """A symbolic frame: `position` (3,) in the world, unit `quaternion` (4,)."""

    position: Expression
    quaternion: Expression


def composed(*sizes: int) -> Callable[[Callable[..., Expression]], Callable[..., Expression]]:
    """Makes an expression of columns of the given sizes once; calls compose it in CasADi's own code, many times faster
    than operators in Python and with the same operations in the same order."""

    def decorate(build: Callable[..., Expression]) -> Callable[..., Expression]:
        @cache
        def function() -> Any:
            symbols = [ca.SX.sym("a", size) for size in sizes]
            return ca.Function("composed", symbols, [ca.densify(build(*symbols))])

        @wraps(build)
        def call(*arguments: Expression) -> Expression:
            return function()(*arguments)

        return call

    return decorate


def vector(items: Sequence[Expression]) -> Expression:
    """A column of the given scalars."""
    return ca.vertcat(*[ca.SX(i) for i in items])


@composed(4, 4)
def multiply(a: Expression, b: Expression) -> Expression:
    """The quaternion product a ⊗ b."""
    return ca.vertcat(
        a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1],
        a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0],
        a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3],
        a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2],
    )


@composed(4)
def conjugate(q: Expression) -> Expression:
    """The inverse of a unit quaternion."""
    return ca.vertcat(-q[0], -q[1], -q[2], q[3])


@composed(4)
def axes(q: Expression) -> Expression:
    """The rotation matrix (3, 3) of unit quaternion q."""
    x, y, z, w = q[0], q[1], q[2], q[3]
    first = ca.vertcat(1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w))
    second = ca.vertcat(2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w))
    third = ca.vertcat(2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y))
    return ca.horzcat(first, second, third)


def axis(q: Expression, letter: str) -> Expression:
    """The image (3,) of unit axis x, y or z under unit quaternion q."""
    return axes(q)[:, "xyz".index(letter)]


@composed(4, 3)
def rotate(q: Expression, v: Expression) -> Expression:
    """Vector v (3,) turned by unit quaternion q."""
    matrix = axes(q)
    return v[0] * matrix[:, 0] + v[1] * matrix[:, 1] + v[2] * matrix[:, 2]


@composed(4, 3)
def unrotate(q: Expression, v: Expression) -> Expression:
    """Vector v (3,) of the world in the axes of unit quaternion q."""
    matrix = axes(q)
    return ca.vertcat(*[ca.dot(matrix[:, i], v) for i in range(3)])


@composed(4, 4)
def rotation_difference(a: Expression, b: Expression) -> Expression:
    """2·vec(a* ⊗ b) with the sign of the shorter way (3,): the rotation from a to b in radians, to first order."""
    difference = multiply(conjugate(a), b)
    return 2 * ca.if_else(difference[3] < 0, -1, 1) * difference[:3]


def compose(parent: Frame, placement: Pose) -> Frame:
    """The frame at a constant `placement` in `parent`."""
    offset, turn = placement[:3], placement[3:]
    position = parent.position + rotate(parent.quaternion, ca.SX(ca.DM(offset))) if any(offset) else parent.position
    quaternion = parent.quaternion if turn == (0, 0, 0, 1) else multiply(parent.quaternion, ca.SX(ca.DM(turn)))
    return Frame(position, quaternion)


@composed(4)
def _normalised(q: Expression) -> Expression:
    return q / ca.norm_2(q)


def pose_frame(pose: Expression) -> Frame:
    """The frame of a pose (7,), its quaternion normalised."""
    return Frame(pose[:3], _normalised(pose[3:7]))


def joint_frame(parent: Frame, joint: Joint, value: Expression) -> Frame:
    """The moving frame of `joint` at joint value `value` (rad or m)."""
    base = compose(parent, joint.placement)
    length = sum(a * a for a in joint.axis) ** 0.5
    direction = [a / length for a in joint.axis]
    if joint.kind == JointKind.PRISMATIC:
        return Frame(base.position + value * rotate(base.quaternion, ca.SX(ca.DM(direction))), base.quaternion)
    turn = vector([a * ca.sin(value / 2) if a else 0 for a in direction] + [ca.cos(value / 2)])
    return Frame(base.position, multiply(base.quaternion, turn))


def joint_value(joint: Joint, index: int, slot: Expression) -> Expression:
    """The value of a joint of a module, by the module's slot."""
    if joint.follows is None:
        return slot[7 + index]
    return joint.follows.factor * slot[7 + joint.follows.leader] + joint.follows.offset


def joint_frames(kind: ModuleType, slot: Expression) -> list[Frame]:
    """The module frame, then the moving frame of each joint: index `joint + 1`."""
    frames = [pose_frame(slot)]
    for i, joint in enumerate(kind.joints):
        frames.append(joint_frame(frames[joint.parent + 1], joint, joint_value(joint, i, slot)))
    return frames


def effector_frame(kind: ModuleType, name: str, slot: Expression) -> Frame:
    """The frame of effector `name`; only the joints that carry it enter the expression."""
    return Frame(*_effector_function(kind, name)(slot))


@cache
def _effector_function(kind: ModuleType, name: str) -> Any:
    """Position and quaternion of an effector by its module's slot."""
    effector = kind.effector(name)
    slot = ca.SX.sym("x", 7 + len(kind.joints))
    frame = pose_frame(slot)
    for i in reversed(line(kind, effector.joint)[:-1]):
        frame = joint_frame(frame, kind.joints[i], joint_value(kind.joints[i], i, slot))
    frame = compose(frame, effector.placement)
    return ca.Function("effector", [slot], [frame.position, frame.quaternion])
