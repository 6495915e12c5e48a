"""The IR: a task with every name resolved, every loop of its scene unrolled and every parameter substituted.

Frozen and printable. Formulas and terms stay lifted: rules, motion predicates and heuristics keep their variables,
chains and loops; nothing here depends on how many modules or bodies the scene has. Lengths are metres, angles
radians; poses are `(x, y, z, qx, qy, qz, qw)` with a unit quaternion, in the world frame unless said otherwise.
`span` fields point to the source text and take no part in comparison.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import field
from enum import StrEnum

from ..langs.frozen import dataclass
from ..langs.source import Source, Span
from .lifted_ir import (
    Aggregate,
    And,
    Any_,
    Arith,
    Case,
    ChainEnd,
    ChainModule,
    ChainType,
    Compare,
    Conditional,
    Derived,
    Effect,
    EffectFor,
    EffectIf,
    EffectItem,
    Exists,
    Forall,
    Formula,
    Function,
    Heuristic,
    Letter,
    Literal,
    MotionPredicate,
    Not,
    Number,
    Object,
    ObjectType,
    Or,
    Predicate,
    Previous,
    Prune,
    RangeType,
    Row,
    Rule,
    Term,
    Type,
    ValueType,
    Var,
    Variable,
    Vector,
    conjuncts,
    effects_of,
    effects_with_loops,
    span_of,
)  # fmt: skip
from .objectives import Objective
from .physics.records import Hold, Inertial
from .remembering import remembered
from .solid_shapes import Pose, Shape, ShapeKind, SolidPart, Vec3

__all__ = [
    "IDENTITY", "Action", "Aggregate", "And", "Any_", "Arith", "Body", "Breakdown", "Case", "Chain", "ChainEnd",
    "ChainModule", "ChainType", "Compare", "Conditional", "Coupling", "Course", "Derived", "Effect",
    "EffectFor", "EffectIf", "EffectItem", "Effector", "Exists", "Fact", "Forall", "Formula", "Function",
    "Heuristic", "Hold", "Inertial", "Joint", "Letter", "Link", "Literal", "Module", "ModuleType",
    "MotionPredicate", "Not", "Number", "Object", "ObjectType", "Options", "Or", "Pose", "Predicate",
    "Previous", "Problem", "Prune", "RangeType", "Row", "Rule", "Shape", "ShapeKind", "SolidPart", "Term", "Type",
    "Value", "ValueType", "Var", "Variable", "Vec3", "Vector", "World", "conjuncts", "effects_of",
    "effects_with_loops", "span_of",
]  # fmt: skip

Fact = tuple[str, ...]
"""A ground literal: predicate name, then the names of objects."""

IDENTITY: Pose = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)

# --- the world ---------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Coupling:
    """A joint's value is always `factor` times that of joint `leader`, an index, plus `offset` (rad or m). The leader
    itself follows none, and its limits are within what its followers' allow it."""

    leader: int
    factor: float
    offset: float


class JointKind(StrEnum):
    REVOLUTE = "revolute"
    PRISMATIC = "prismatic"


@dataclass(frozen=True, slots=True)
class Joint:
    """`parent` is the index of the joint whose moving frame carries it, -1 for
    the module frame. The moving frame is parent · placement · motion(axis, q). Limits in rad or m, greatest speed per
    s, greatest acceleration per s², greatest `jerk` per s³. A `passive` joint has no drive; one that `follows` another
    has its leader's. A drive weighs `mass`, kg, sits at the joint on the parent's frame, gives at most `torque`, N m
    (N of a prismatic joint), and has the inertia `rotor`, kg m² (kg), behind the gear; across its axis a joint bears
    the moment `bearing`, N m. While it does not move, a `brake` bears up to that, N m (N). `stated` is where that is
    written."""

    name: str
    kind: JointKind
    parent: int
    placement: Pose
    axis: Vec3
    lower: float
    upper: float
    home: float
    speed: float
    acceleration: float = math.inf
    passive: bool = False
    follows: Coupling | None = None
    mass: float = 0.0
    torque: float = math.inf
    bearing: float = math.inf
    rotor: float = 0.0
    brake: float = 0.0
    jerk: float = math.inf
    stated: Span | None = field(default=None, compare=False, repr=False)

    @property
    def unit(self) -> str:
        """What its values are counted in."""
        return "rad" if self.kind == JointKind.REVOLUTE else "m"

    @property
    def slide(self) -> float:
        """How far it can carry its frame from where it is placed, metres."""
        return max(abs(self.lower), abs(self.upper)) if self.kind == JointKind.PRISMATIC else 0.0

    def strength(self, *, still: bool) -> float:
        """What it bears along its axis, N m (N): the drive, and while it does not move also the brake."""
        return max(self.torque, self.brake) if still else self.torque


@dataclass(frozen=True, slots=True)
class Effector:
    """A frame at an end of a module, fixed to the moving frame of `joint` (-1: the module frame). Its z-axis is the
    outward normal. `shape` is centred at the frame's origin, or None. `mass`, kg, is None where none is stated."""

    name: str
    type: str
    joint: int
    placement: Pose
    shape: Shape | None
    mass: float | None = None
    holds: tuple[Hold, ...] = ()


@dataclass(frozen=True, slots=True)
class Link:
    """A collision shape fixed to the moving frame of `joint` (-1: the module frame)."""

    joint: int
    placement: Pose
    shape: Shape
    mass: float | None = None


@dataclass(frozen=True, slots=True)
class ModuleType:
    """Joints are in order of their tree: `parent` < own index."""

    name: str
    joints: tuple[Joint, ...]
    effectors: tuple[Effector, ...]
    links: tuple[Link, ...]
    inertials: tuple[Inertial, ...] = ()
    """Masses that a URDF states; shapes of those links weigh nothing of their own."""

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
    mass: float | None = None
    holds: tuple[Hold, ...] = ()
    collides: bool = True
    """False of a region, and of a mark on something: what is only a place, which things may occupy."""


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


class BreakdownKind(StrEnum):
    LOCKED = "locked"
    GONE = "gone"


@dataclass(frozen=True, slots=True)
class Breakdown:
    """From `time` (s) on a module's joints are stuck where they are or the module has left the scene."""

    module: str
    time: float
    kind: BreakdownKind
    span: Span | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class World:
    """`courses` (by body, then by start) and `breakdowns` (by time) happen while a plan is executed; a planner sees the
    scene as it is at time 0."""

    modules: Mapping[str, Module]
    bodies: Mapping[str, Body]
    courses: tuple[Course, ...] = ()
    breakdowns: tuple[Breakdown, ...] = ()

    @property
    def solids(self) -> tuple[Body, ...]:
        """The bodies that can be collided with."""
        return tuple([b for b in self.bodies.values() if b.collides])

    def effector(self, name: str) -> tuple[Module, Effector] | None:
        """The module and effector that object `name` denotes, or None when it is not an effector."""
        module, dot, effector = name.rpartition(".")
        if not dot or module not in self.modules:
            return None
        return self.modules[module], self.modules[module].type.effector(effector)

    def owner(self, name: str) -> str:
        """The module of which object `name` is an effector; any other object by its own name."""
        module = name.rpartition(".")[0]
        return module if module in self.modules else name


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
    physics: str | None = None
    safety: float | None = None
    minimise: Objective | None = None
    gap: float | None = None


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
    files: Mapping[str, bytes] = field(default_factory=dict)
    """What else was read, by path: URDFs and meshes."""
    names: Mapping[str, str] = field(default_factory=dict)
    """How sources and files, by path, are called on any machine."""
    touching: frozenset[tuple[str, str]] = frozenset()
    """Pairs of objects, in alphabetical order, that may touch at the start though no motion literal speaks of it:
    things side by side, or a robot in mid-run that has just let go."""
    pressed: frozenset[tuple[str, str]] = frozenset()
    """Those that overlap at the start by less than what `check` lets pass."""
    scene_motion: frozenset[Fact] | None = None
    """Where the problem begins in the midst of a task: the motion literals in the scene, before any action."""

    @property
    def motion_of_scene(self) -> frozenset[Fact]:
        """The motion literals of the scene as the task states it."""
        return self.init_motion if self.scene_motion is None else self.scene_motion

    def called(self, path: str) -> str:
        """How a source or file is called on any machine."""
        return self.names.get(path, path)

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
        return _of_type(self, type_name)


@remembered(4)
def _of_type(problem: Problem, type_name: str) -> tuple[str, ...]:
    fits = {t for t in set(problem.objects.values()) if problem.is_a(t, type_name)}
    return tuple([o for o, t in problem.objects.items() if t in fits])


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

    def part(self, index: int, side: str) -> str | None:
        """The module number `index`, from 1, or its end on the side "in" or "out"; None past the ends of the chain."""
        if not 1 <= index <= len(self.modules):
            return None
        return self.modules[index - 1][("", "in", "out").index(side)]

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
