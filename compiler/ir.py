"""The IR: a task with every name resolved, every loop of its scene unrolled and every parameter substituted.

Frozen and printable. Formulas and terms stay lifted: rules, motion predicates and heuristics keep their variables,
chains and loops; nothing here depends on how many modules or bodies the scene has. Lengths are metres, angles
radians; poses are `(x, y, z, qx, qy, qz, qw)` with a unit quaternion, in the world frame unless said otherwise.
`span` fields point to the source text and take no part in comparison.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from ..langs.source import Source, Span

Vec3 = tuple[float, float, float]
Pose = tuple[float, float, float, float, float, float, float]
Fact = tuple[str, ...]
"""A ground literal: predicate name, then the names of objects."""

IDENTITY: Pose = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)

# --- types and variables -----------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class ObjectType:
    """Ranges over the objects of type `name` and of its subtypes."""

    name: str


@dataclass(frozen=True, slots=True)
class ChainType:
    """Ranges, in the current state, over the maximal directed lines of modules of type `element` (or a subtype)
    linked by the binary predicate `predicate` between their effectors; each line once from each end. A lone module
    with ends A and B gives two chains of length 1. Chains never branch and never revisit a module."""

    element: str
    predicate: str


@dataclass(frozen=True, slots=True)
class RangeType:
    """The integers from `first` to `last`, both included; empty when last < first. May refer to earlier variables."""

    first: Term
    last: Term


@dataclass(frozen=True, slots=True)
class ValueType:
    """`int`, `real`, `length`, `angle`, `time`, `speed`: only for parameters of declarations, never for variables of a
    rule."""

    name: str


Type = ObjectType | ChainType | RangeType | ValueType


@dataclass(frozen=True, slots=True)
class Variable:
    name: str
    type: Type


# --- terms -------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Number:
    value: float
    span: Span | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class Object:
    """A ground object, by its name: `item[3]`, `c[1].A`, `c[1]`."""

    name: str
    span: Span | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class Var:
    name: str
    span: Span | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class Any_:
    """`ANY`: matches every object; only inside deleted literals and `previous` patterns."""

    span: Span | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class ChainEnd:
    """`c.first` (`last` False) or `c.last`: the outer effector at that end of chain variable `chain`."""

    chain: str
    last: bool
    span: Span | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class ChainModule:
    """`c[k]`, counted from 1; with `side` "in" or "out" the effector by which the chain, walked from first to last,
    enters or leaves that module; with `side` "" the module itself."""

    chain: str
    index: Term
    side: str
    span: Span | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class Function:
    """A built-in function of terms; `builtins.FUNCTIONS` lists them with argument and result kinds. `axis` takes
    its letter as a second argument `Letter`."""

    name: str
    args: tuple[Term, ...]
    span: Span | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class Letter:
    """The x, y or z in `axis(X, z)`."""

    letter: str


@dataclass(frozen=True, slots=True)
class Arith:
    """`operator` is + - * /, or "neg" with one operand. Works on numbers and on 3-vectors, row by row."""

    operator: str
    operands: tuple[Term, ...]
    span: Span | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class Vector:
    items: tuple[Term, ...]
    span: Span | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class Conditional:
    condition: Formula
    then: Term
    otherwise: Term


@dataclass(frozen=True, slots=True)
class Aggregate:
    """min, max or sum of `body` over all values of `variables`."""

    operator: str
    variables: tuple[Variable, ...]
    body: Term


@dataclass(frozen=True, slots=True)
class Prune:
    """`prune` in a heuristic: an infinite cost-to-go."""


Term = (
    Number | Object | Var | Any_ | ChainEnd | ChainModule | Function | Letter | Arith | Vector | Conditional
    | Aggregate | Prune
)

# --- formulas ----------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Literal:
    """A logic literal; `predicate` may be derived. `motion` marks `[…]`, which occurs only in effects and facts."""

    predicate: str
    args: tuple[Term, ...]
    motion: bool = False
    span: Span | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class Not:
    operand: Formula


@dataclass(frozen=True, slots=True)
class And:
    """`And(())` is true."""

    operands: tuple[Formula, ...]


@dataclass(frozen=True, slots=True)
class Or:
    """`Or(())` is false."""

    operands: tuple[Formula, ...]


@dataclass(frozen=True, slots=True)
class Exists:
    variables: tuple[Variable, ...]
    body: Formula


@dataclass(frozen=True, slots=True)
class Forall:
    variables: tuple[Variable, ...]
    body: Formula


@dataclass(frozen=True, slots=True)
class Compare:
    """`operator` is = != < <= > >=. = and != compare objects or numbers, the others numbers."""

    operator: str
    left: Term
    right: Term
    span: Span | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class Previous:
    """True when the action before was an instance of `rule`; `args` None accepts any arguments."""

    rule: str
    args: tuple[Term, ...] | None


Formula = Literal | Not | And | Or | Exists | Forall | Compare | Previous

# --- declarations ------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Predicate:
    """`functional_in` is the index of the parameter that determines the others, or None."""

    name: str
    variables: tuple[Variable, ...]
    static: bool
    symmetric: bool
    functional_in: int | None
    span: Span | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class Derived:
    name: str
    variables: tuple[Variable, ...]
    body: Formula
    span: Span | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class Row:
    """One line of a motion predicate. `when` is "switch", "during" or "keep"; `operator` is "=", "<=" or ">=" between
    `left` and `right`, or "" for keep, where the value of `left` stays constant. `rows` is how many scalar residuals
    it gives (a keep of a pose gives 6: position, then rotation)."""

    when: str
    left: Term
    operator: str
    right: Term | None
    rows: int
    span: Span | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class MotionPredicate:
    name: str
    variables: tuple[Variable, ...]
    symmetric: bool
    rows: tuple[Row, ...]
    span: Span | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class Effect:
    literal: Literal
    negated: bool


@dataclass(frozen=True, slots=True)
class EffectIf:
    condition: Formula
    effects: tuple[EffectItem, ...]


@dataclass(frozen=True, slots=True)
class EffectFor:
    variables: tuple[Variable, ...]
    effects: tuple[EffectItem, ...]


EffectItem = Effect | EffectIf | EffectFor


@dataclass(frozen=True, slots=True)
class Rule:
    """A decision rule: applicable where `condition` (all of pre and where) holds. All deletions of an action happen
    before all its additions; conditions of effects are read in the state before."""

    name: str
    variables: tuple[Variable, ...]
    condition: Formula
    effects: tuple[EffectItem, ...]
    cost: Term
    span: Span | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class Case:
    """The change of the cost-to-go when the last action is an instance of `rule`, over the rule's own variables."""

    rule: str
    value: Term


@dataclass(frozen=True, slots=True)
class Heuristic:
    """Arguments of the use in the task are already substituted. `start` is None for 0."""

    name: str
    start: Term | None
    cases: Mapping[str, Case]


# --- the world ---------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Shape:
    """`size` in metres: box (x, y, z), sphere (radius,), capsule and cylinder (radius, length along z without caps),
    convex (the coordinates of all corners in turn, of a hull whose box along the axes has its middle at the origin)."""

    kind: str
    size: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Joint:
    """`kind` is "revolute" or "prismatic". `parent` is the index of the joint whose moving frame carries it, -1 for
    the module frame. The moving frame is parent · placement · motion(axis, q). Limits in rad or m, greatest speed per
    s, greatest acceleration per s²."""

    name: str
    kind: str
    parent: int
    placement: Pose
    axis: Vec3
    lower: float
    upper: float
    home: float
    speed: float
    acceleration: float = math.inf


@dataclass(frozen=True, slots=True)
class Effector:
    """A frame at an end of a module, fixed to the moving frame of `joint` (-1: the module frame). Its z-axis is the
    outward normal. `shape` is centred at the frame's origin, or None."""

    name: str
    type: str
    joint: int
    placement: Pose
    shape: Shape | None


@dataclass(frozen=True, slots=True)
class Link:
    """A collision shape fixed to the moving frame of `joint` (-1: the module frame)."""

    joint: int
    placement: Pose
    shape: Shape


@dataclass(frozen=True, slots=True)
class ModuleType:
    """Joints are in order of their tree: `parent` < own index."""

    name: str
    joints: tuple[Joint, ...]
    effectors: tuple[Effector, ...]
    links: tuple[Link, ...]

    def effector(self, name: str) -> Effector:
        return next(e for e in self.effectors if e.name == name)


@dataclass(frozen=True, slots=True)
class Module:
    """A module in the scene: pose of its module frame and joint values at the start. Its effectors are the objects
    `name.A`, `name.B`, …"""

    name: str
    type: ModuleType
    pose: Pose
    joints: tuple[float, ...]
    span: Span | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class Body:
    """A rigid thing in the scene, with its pose at the start. `movable` is True when some rule can make it follow
    something (as second argument of a motion literal that keeps a pose)."""

    name: str
    type: str
    shape: Shape
    pose: Pose
    movable: bool
    span: Span | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class Course:
    """How a body moves on its own. From time `start` (s) on its centre goes from where it is then through `points`
    (world, metres) at `speed` (m/s; 0 jumps to the last point at once) and stays there, or goes back and forth for
    ever when it `returns`. Its orientation stays. A later course of the same body ends an earlier one, on the way or
    not; no two of one body have the same `start`. `courses.centre_at` says where that puts it."""

    body: str
    start: float
    points: tuple[Vec3, ...]
    speed: float
    returns: bool
    span: Span | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class Breakdown:
    """From `time` (s) on a module's joints are stuck where they are (`kind` "locked") or the module has left the scene
    ("gone")."""

    module: str
    time: float
    kind: str
    span: Span | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class World:
    """`courses` (by body, then by start) and `breakdowns` (by time) happen while a plan is executed; a planner sees the
    scene as it is at time 0."""

    modules: Mapping[str, Module]
    bodies: Mapping[str, Body]
    courses: tuple[Course, ...] = ()
    breakdowns: tuple[Breakdown, ...] = ()

    def effector(self, name: str) -> tuple[Module, Effector] | None:
        """The module and effector that object `name` denotes, or None when it is not an effector."""
        module, dot, effector = name.rpartition(".")
        if not dot or module not in self.modules:
            return None
        return self.modules[module], self.modules[module].type.effector(effector)


@dataclass(frozen=True, slots=True)
class Options:
    """What the task's `options` block sets; None where it is silent. Seconds for `time`."""

    bound: str | None = None
    search: str | None = None
    time: float | None = None
    nodes: int | None = None
    solver: str | None = None
    slices: int | None = None
    margin: float | None = None


@dataclass(frozen=True, slots=True)
class Problem:
    """One task, ready for the back ends."""

    task: str
    file: str
    seed: int
    parameters: Mapping[str, float | int]
    types: Mapping[str, str | None]
    """Type name to parent; object, effector and module are always there, as are the module types (parent module)."""
    objects: Mapping[str, str]
    """Object name to type, in declaration order: bodies, modules, effectors."""
    predicates: Mapping[str, Predicate]
    derived: Mapping[str, Derived]
    motions: Mapping[str, MotionPredicate]
    rules: Mapping[str, Rule]
    heuristic: Heuristic | None
    init: frozenset[Fact]
    """Logic facts at the start; symmetric ones in both orders."""
    init_motion: frozenset[Fact]
    """Motion literals at the start."""
    goal: Formula
    world: World
    options: Options
    sources: tuple[Source, ...]
    touching: frozenset[tuple[str, str]] = frozenset()
    """Pairs of objects, in alphabetical order, that may touch at the start though no motion literal speaks of it: a
    robot in mid-run that has just let go."""

    def is_a(self, type_name: str, ancestor: str) -> bool:
        """Whether type `type_name` is `ancestor` or a subtype of it."""
        current: str | None = type_name
        while current is not None:
            if current == ancestor:
                return True
            current = self.types[current]
        return False

    def of_type(self, type_name: str) -> tuple[str, ...]:
        """The objects of that type and its subtypes, in declaration order."""
        return tuple(o for o, t in self.objects.items() if self.is_a(t, type_name))


# --- ground actions ----------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Chain:
    """A chain of modules in one state: per module its name and the effectors by which it is entered and left."""

    modules: tuple[tuple[str, str, str], ...]
    """(module, effector object entered by, effector object left by), such as ("c[1]", "c[1].A", "c[1].B")."""

    @property
    def first(self) -> str:
        return self.modules[0][1]

    @property
    def last(self) -> str:
        return self.modules[-1][2]

    def __str__(self) -> str:
        return "[" + " ".join(f"{enter} {leave}" for _, enter, leave in self.modules) + "]"


Value = str | int | Chain
"""What a rule's variable is bound to: an object's name, a number of a range, or a chain."""


@dataclass(frozen=True, slots=True)
class Action:
    """A ground decision: a rule and the values of its variables, in order."""

    rule: str
    args: tuple[Value, ...]

    def __str__(self) -> str:
        return f"{self.rule}({', '.join(map(str, self.args))})"
