"""Back end `constraints`: motion predicates to CasADi stage Functions.

Takes the rows of `ir.MotionPredicate` and the kinds of their arguments; gives one `Stage` per row and kinds, cached
per process. Residual signs: equalities r = 0, inequalities r <= 0.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache, partial

import casadi as ca

from ...langs.frozen import dataclass
from .. import ir
from ..physics.masses import module_mass, module_masses
from . import distances
from .distances import SIZES, DistanceShape
from .kinematics import (
    Expression,
    Frame,
    axis,
    compose,
    conjugate,
    effector_frame,
    joint_frames,
    multiply,
    pose_frame,
    rotate,
    rotation_difference,
    unrotate,
    vector,
)
from .stages import Stage

METRES = frozenset({"position", "centre", "gap", "top", "bottom", "inside", "radius"})


@dataclass(frozen=True, slots=True)
class EffectorKind:
    """An effector of a module whose slot is number `slot` of the row; `effector` "" is the module frame itself."""

    type: ir.ModuleType
    effector: str
    slot: int


@dataclass(frozen=True, slots=True)
class BodyKind:
    """A body that may move: its pose is slot number `slot`, its sizes are parameters; a convex one is given as a
    whole."""

    shape: ir.ShapeKind | ir.Shape
    slot: int
    mass: float | None = None


@dataclass(frozen=True, slots=True)
class RestKind:
    """A body that never moves: pose and sizes are parameters; a convex one is given as a whole."""

    shape: ir.ShapeKind | ir.Shape
    mass: float | None = None


Kind = EffectorKind | BodyKind | RestKind


def arguments(row: ir.Row, variables: tuple[ir.Variable, ...]) -> tuple[str, ...]:
    """The variables, by name, and ground objects that a row mentions: variables first, in declaration order."""
    found: dict[str, None] = {}

    def visit(term: ir.Term | None) -> None:
        match term:
            case ir.Var(name) | ir.Object(name):
                found[name] = None
            case ir.Function(_, inner) | ir.Arith(_, inner) | ir.Vector(inner):
                for item in inner:
                    visit(item)

    visit(row.left)
    visit(row.right)
    declared = [v.name for v in variables if v.name in found]
    return (*declared, *(n for n in found if n not in declared))


def units(row: ir.Row) -> tuple[str, ...]:
    """The unit of each scalar residual: m, rad or, for directions, 1."""
    if isinstance(row.left, ir.Function) and row.left.name == "pose":
        return ("m",) * 3 + ("rad",) * 3

    def metric(term: ir.Term | None) -> bool:
        match term:
            case ir.Function(name, _) if name in METRES:
                return True
            case ir.Function(_, inner) | ir.Arith(_, inner) | ir.Vector(inner):
                return any(metric(item) for item in inner)
        return False

    return ("m" if metric(row.left) or metric(row.right) else "1",) * row.rows


def slot_sizes(kinds: tuple[Kind, ...]) -> list[int]:
    """The sizes of the distinct slots of a row, in the order of their numbers."""
    sizes: dict[int, int] = {}
    for kind in kinds:
        match kind:
            case EffectorKind(type=module, slot=slot):
                sizes[slot] = 7 + len(module.joints)
            case BodyKind(slot=slot):
                sizes[slot] = 7
    return [sizes[i] for i in range(len(sizes))]


def parameter_sizes(kinds: tuple[Kind, ...]) -> list[int]:
    """How many parameters each argument takes: sizes of a body, and before them its pose when it never moves."""
    count = []
    for kind in kinds:
        match kind:
            case EffectorKind():
                count.append(0)
            case BodyKind(shape=shape):
                count.append(_size_count(shape))
            case RestKind(shape=shape):
                count.append(7 + _size_count(shape))
    return count


def solid(kind: Kind, slots: list[Expression], constants: Expression) -> DistanceShape:
    match kind:
        case EffectorKind(type=module, effector="", slot=slot):
            weight = partial(_balance, module, slots[slot])
            return DistanceShape(pose_frame(slots[slot]), ir.ShapeKind.SPHERE, (0.0,), weight)
        case EffectorKind(type=module, effector=name, slot=slot):
            shape = module.effector(name).shape or ir.Shape(ir.ShapeKind.SPHERE, (0.0,))
            frame = effector_frame(module, name, slots[slot])
            return DistanceShape(frame, shape.kind, shape.size, partial(_balance, module, slots[slot]), shape.parts)
        case BodyKind(shape=shape, slot=slot):
            return _shaped(pose_frame(slots[slot]), shape, constants, kind.mass)
        case RestKind(shape=shape):
            return _shaped(Frame(constants[:3], constants[3:7]), shape, constants[7:], kind.mass)


def _size_count(shape: ir.ShapeKind | ir.Shape) -> int:
    return 0 if isinstance(shape, ir.Shape) else SIZES[shape]


def _shaped(frame: Frame, shape: ir.ShapeKind | ir.Shape, sizes: Expression, mass: float | None) -> DistanceShape:
    balance = None if mass is None else lambda: (ca.SX(mass), frame.position)
    if isinstance(shape, ir.Shape):
        return DistanceShape(frame, shape.kind, shape.size, balance, shape.parts)
    return DistanceShape(frame, shape, [sizes[i] for i in range(SIZES[shape])], balance)


def _balance(module: ir.ModuleType, slot: Expression) -> tuple[Expression, Expression]:
    """Mass and centre of mass of a module."""
    frames, mass = joint_frames(module, slot), module_mass(module)
    moments = [m * compose(frames[joint + 1], place).position for joint, place, m in module_masses(module)]
    return ca.SX(mass), sum(moments[1:], moments[0]) / mass if moments else frames[0].position


def _measured(name: str, solid: DistanceShape) -> Expression:
    """Mass or centre of mass; of a body from its shape."""
    if solid.balance is not None:
        mass, centre = solid.balance()
        return mass if name == "mass" else centre
    return distances.mass(solid) if name == "mass" else solid.frame.position


class RowScope(dict[str, DistanceShape]):
    """The things of a row by name, and what its functions about loads are worth."""

    def __init__(self, loads: Mapping[ir.Function, Expression] | None = None) -> None:
        super().__init__()
        self.loads = loads or {}


def _function(name: str, args: tuple[ir.Term, ...], scope: Mapping[str, DistanceShape]) -> Expression:
    if name in distances.PAIRS:
        return distances.PAIRS[name](_object(args[0], scope), _object(args[1], scope))
    if name in distances.SINGLES:
        return distances.SINGLES[name](_object(args[0], scope))
    if name in ("mass", "centre"):
        return _measured(name, _object(args[0], scope))
    if name == "position":
        return _object(args[0], scope).frame.position
    if name == "axis" and isinstance(args[1], ir.Letter):
        return axis(_object(args[0], scope).frame.quaternion, args[1].letter)
    plain: dict[str, Callable[..., Expression]] = {
        "dot": ca.dot, "cross": ca.cross, "norm": lambda v: ca.sqrt(ca.dot(v, v) + distances.SMOOTH),
        "sqrt": ca.sqrt, "abs": ca.fabs, "least": ca.fmin, "sin": ca.sin, "cos": ca.cos,
    }  # fmt: skip
    if name not in plain:
        raise ValueError(f"`{name}` has no meaning in a motion predicate")
    return plain[name](*[_value(a, scope) for a in args])


def _object(term: ir.Term, scope: Mapping[str, DistanceShape]) -> DistanceShape:
    if isinstance(term, ir.Var | ir.Object):
        return scope[term.name]
    raise ValueError(f"{term} is not an object")


def _value(term: ir.Term, scope: Mapping[str, DistanceShape]) -> Expression:
    match term:
        case ir.Number(value):
            return ca.SX(value)
        case ir.Function(name, args):
            if isinstance(scope, RowScope) and term in scope.loads:
                return scope.loads[term]
            return _function(name, args, scope)
        case ir.Vector(items):
            return vector([_value(i, scope) for i in items])
        case ir.Arith(operator, operands):
            values = [_value(o, scope) for o in operands]
            if operator == "neg":
                return -values[0]
            left, right = values
            return {"+": left + right, "-": left - right, "*": left * right, "/": left / right}[operator]
    raise ValueError(f"{term} has no value in a motion predicate")


def _relative(frame: Frame, base: Frame) -> tuple[Expression, Expression]:
    return (
        unrotate(base.quaternion, frame.position - base.position),
        multiply(conjugate(base.quaternion), frame.quaternion),
    )


def _kept(term: ir.Term, scopes: list[dict[str, DistanceShape]], kinds: Mapping[str, Kind]) -> Expression:
    """The change of a kept term from one slice to the next. Relative to something that never moves, the pose in
    the world says the same with a smaller expression."""
    if not (isinstance(term, ir.Function) and term.name == "pose"):
        return _value(term, scopes[1]) - _value(term, scopes[0])
    target, base = term.args
    anchored = isinstance(base, ir.Var | ir.Object) and isinstance(kinds[base.name], RestKind)
    poses = []
    for scope in scopes:
        frame = _object(target, scope).frame
        poses.append((frame.position, frame.quaternion) if anchored else _relative(frame, _object(base, scope).frame))
    (p0, q0), (p1, q1) = poses
    return ca.vertcat(p1 - p0, rotation_difference(q0, q1))


@cache
def stage(row: ir.Row, names: tuple[str, ...], kinds: tuple[Kind, ...]) -> Stage:
    """The stage Function of one row whose arguments `names` have `kinds`.

    Its variables are the distinct slots in order of their numbers (for a keep row those of the earlier slice, then
    those of the later), its parameters those of each argument in turn. Raises ValueError for terms without meaning
    in a motion predicate.
    """
    sizes = slot_sizes(kinds)
    counts = parameter_sizes(kinds)
    slices = 2 if row.when == "keep" else 1
    variables = ca.SX.sym("x", slices * sum(sizes))
    constants = ca.SX.sym("p", sum(counts))
    scopes = []
    for i in range(slices):
        slots, start = [], i * sum(sizes)
        for size in sizes:
            slots.append(variables[start : start + size])
            start += size
        scope, used = {}, 0
        for name, kind, count in zip(names, kinds, counts, strict=True):
            scope[name] = solid(kind, slots, constants[used : used + count])
            used += count
        scopes.append(scope)
    if row.when == "keep":
        change = _kept(row.left, scopes, dict(zip(names, kinds, strict=True)))
    else:
        change = residual(row, scopes[0])
    return Stage(row.when, variables, constants, change)


def residual(row: ir.Row, scope: Mapping[str, DistanceShape]) -> Expression:
    """What is 0, of an inequality at most 0, where a row that compares holds."""
    left, right = _value(row.left, scope), _value(row.right or ir.Number(0.0), scope)
    found = right - left if row.operator == ">=" else left - right
    return ca.repmat(found, row.rows, 1) if found.numel() < row.rows else found


@cache
def sphere_stage(kind: ir.ModuleType | None, spheres: tuple[tuple[int, ir.Vec3], ...]) -> Stage:
    """Centres (3 S,) in the world of S spheres at `(joint, offset in its moving frame)` of a module; with `kind` None
    of a body, whose frame is number -1. Variables are the one slot, there are no parameters."""
    slot = ca.SX.sym("x", 7 if kind is None else 7 + len(kind.joints))
    frames = [pose_frame(slot)] if kind is None else joint_frames(kind, slot)
    centres = [compose(frames[joint + 1], (*offset, 0.0, 0.0, 0.0, 1.0)).position for joint, offset in spheres]
    return Stage("spheres", slot, ca.SX.sym("p", 0), ca.vertcat(*centres))


@cache
def frame_stage(kind: ir.ModuleType | None, parts: tuple[tuple[int, ir.Pose], ...]) -> Stage:
    """Centres (3,) and rotations by rows (9,) in the world of parts at `(joint, pose in its moving frame)`, one after
    the other (12 P,); modules and bodies as in `sphere_stage`."""
    slot = ca.SX.sym("x", 7 if kind is None else 7 + len(kind.joints))
    frames = [pose_frame(slot)] if kind is None else joint_frames(kind, slot)
    found = []
    for joint, placement in parts:
        frame = compose(frames[joint + 1], placement)
        axes = [rotate(frame.quaternion, ca.SX(axis)) for axis in ([1, 0, 0], [0, 1, 0], [0, 0, 1])]
        found += [frame.position, ca.reshape(ca.horzcat(*axes).T, 9, 1)]
    return Stage("frames", slot, ca.SX.sym("p", 0), ca.vertcat(*found))
