"""The syntax tree: what the parser gives and the formatter prints. One frozen class per construct.

Numbers are already in SI units (metres, radians, seconds); `Number.unit` keeps the kind of quantity.
Every node has a `span`, which takes no part in comparison, so two trees are equal when they say the same.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from .source import Span


@dataclass(frozen=True, slots=True, kw_only=True)
class Node:
    span: Span = field(compare=False, repr=False)


# --- terms -----------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Number(Node):
    """`3`, `0.05 m`, `120 deg`: the value in SI, the kind ("" plain, "length", "angle", "time", "speed",
    "angular speed", "acceleration", "angular acceleration") and text."""

    value: float
    kind: str
    text: str


@dataclass(frozen=True, slots=True)
class Text(Node):
    """A quoted string: a path, a URDF link name."""

    value: str


@dataclass(frozen=True, slots=True)
class Name(Node):
    name: str


@dataclass(frozen=True, slots=True)
class Wildcard(Node):
    """`ANY`."""


@dataclass(frozen=True, slots=True)
class Index(Node):
    """`shelf[i]`, `c[k]`."""

    base: Term
    index: Term


@dataclass(frozen=True, slots=True)
class Attribute(Node):
    """`p.first`, `c[k].out`, `c[1].A`."""

    base: Term
    name: str


@dataclass(frozen=True, slots=True)
class Call(Node):
    """`distance(X, Y)`, `box(1 m, 1 m, 5 cm)`."""

    function: str
    args: tuple[Term, ...]


@dataclass(frozen=True, slots=True)
class Negate(Node):
    operand: Term


@dataclass(frozen=True, slots=True)
class Binary(Node):
    """`operator` is one of + - * /."""

    operator: str
    left: Term
    right: Term


@dataclass(frozen=True, slots=True)
class Vector(Node):
    """`(x, y, z)`: two or three terms in parentheses."""

    items: tuple[Term, ...]


@dataclass(frozen=True, slots=True)
class Conditional(Node):
    """`if condition then a else b`."""

    condition: Formula
    then: Term
    otherwise: Term


@dataclass(frozen=True, slots=True)
class Aggregate(Node):
    """`min(c: module) distance(c, target)`; `operator` is min, max or sum."""

    operator: str
    binders: tuple[Parameter, ...]
    body: Term


Term = Number | Text | Name | Wildcard | Index | Attribute | Call | Negate | Binary | Vector | Conditional | Aggregate


# --- logic -----------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class NamedType(Node):
    """An object type (`base`, `module`, `object`) or a value type (`int`, `real`, `length`, `angle`)."""

    name: str


@dataclass(frozen=True, slots=True)
class ChainType(Node):
    """`chain of module by connected`."""

    element: str
    predicate: str


@dataclass(frozen=True, slots=True)
class RangeType(Node):
    """`1 .. length(c) - 1`, both ends included."""

    first: Term
    last: Term


Type = NamedType | ChainType | RangeType


@dataclass(frozen=True, slots=True)
class Parameter(Node):
    """One parameter or bound variable. `A B: port` gives two of them. `in` binders (`for i in 1 .. n`,
    `for X in base`) are parameters too. `default` is None where there is none; `allowed` bounds a value, as in
    `n: int in 1 .. 64 = 8`."""

    name: str
    type: Type
    default: Term | None = None
    allowed: RangeType | None = None


@dataclass(frozen=True, slots=True)
class Literal(Node):
    """`(support A)`, or with `motion` the thesis' square brackets: `[stable X A]`."""

    predicate: str
    args: tuple[Term, ...]
    motion: bool


@dataclass(frozen=True, slots=True)
class Not(Node):
    operand: Formula


@dataclass(frozen=True, slots=True)
class And(Node):
    operands: tuple[Formula, ...]


@dataclass(frozen=True, slots=True)
class Or(Node):
    operands: tuple[Formula, ...]


@dataclass(frozen=True, slots=True)
class Exists(Node):
    binders: tuple[Parameter, ...]
    body: Formula


@dataclass(frozen=True, slots=True)
class Forall(Node):
    binders: tuple[Parameter, ...]
    body: Formula


@dataclass(frozen=True, slots=True)
class Compare(Node):
    """`operator` is one of = != < <= > >=; = and != also compare objects."""

    operator: str
    left: Term
    right: Term


@dataclass(frozen=True, slots=True)
class Previous(Node):
    """`previous is disconnect(p, ANY)` in a heuristic: the kind and arguments of the action before."""

    rule: str
    args: tuple[Term, ...] | None


Formula = Literal | Not | And | Or | Exists | Forall | Compare | Previous


# --- effects ---------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Effect(Node):
    """One literal that an action adds, or with `negated` deletes."""

    literal: Literal
    negated: bool


@dataclass(frozen=True, slots=True)
class EffectIf(Node):
    """`if (on X A) { … }`: the condition is read in the state before the action."""

    condition: Formula
    effects: tuple[EffectItem, ...]


@dataclass(frozen=True, slots=True)
class EffectFor(Node):
    """`for i in 1 .. length(c) - 1 { … }`, `for X in base { … }` and `forall (X: base) { … }`."""

    binders: tuple[Parameter, ...]
    effects: tuple[EffectItem, ...]


EffectItem = Effect | EffectIf | EffectFor


# --- declarations ----------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Import(Node):
    """`import std.rules` (`is_path` False, `target` "std.rules") or `import "scenes/rubble.tamp"` (True)."""

    target: str
    is_path: bool


@dataclass(frozen=True, slots=True)
class TypeDecl(Node):
    name: str
    parent: str | None
    doc: str = ""


@dataclass(frozen=True, slots=True)
class PredicateDecl(Node):
    """`predicate (on X: object, A: object) functional in A`. `functional_in` names the parameter that determines
    the others."""

    name: str
    parameters: tuple[Parameter, ...]
    static: bool
    symmetric: bool
    functional_in: str | None
    doc: str = ""


@dataclass(frozen=True, slots=True)
class DerivedDecl(Node):
    """`derived (held X: object) = exists A: port { (taken A X) }`."""

    name: str
    parameters: tuple[Parameter, ...]
    body: Formula
    doc: str = ""


@dataclass(frozen=True, slots=True)
class FunctionDecl(Node):
    """`function halfway(X Y: object) = distance(X, Y) / 2`."""

    name: str
    parameters: tuple[Parameter, ...]
    body: Term
    doc: str = ""


@dataclass(frozen=True, slots=True)
class MotionRow(Node):
    """One line of a motion predicate. `when` is "switch" (`at switch`), "during" (`during`) or "keep"; a keep row
    has operator "" and right None: the value of `left` stays constant."""

    when: str
    left: Term
    operator: str
    right: Term | None


@dataclass(frozen=True, slots=True)
class MotionFor(Node):
    binders: tuple[Parameter, ...]
    rows: tuple[MotionItem, ...]


MotionItem = MotionRow | MotionFor


@dataclass(frozen=True, slots=True)
class MotionDecl(Node):
    name: str
    parameters: tuple[Parameter, ...]
    symmetric: bool
    items: tuple[MotionItem, ...]
    doc: str = ""


@dataclass(frozen=True, slots=True)
class RuleDecl(Node):
    """A decision rule. `pre` and `where` are the conjuncts as written; `cost` is None for the default 1."""

    name: str
    parameters: tuple[Parameter, ...]
    pre: tuple[Formula, ...]
    where: tuple[Formula, ...]
    post: tuple[EffectItem, ...]
    cost: Term | None
    doc: str = ""


@dataclass(frozen=True, slots=True)
class PlacementDecl(Node):
    """`placement (A: port) on (Y: base) { (support A), … }`: the literals that hold at the start for whatever a
    scene or task puts `on` something."""

    subject: Parameter
    support: Parameter
    post: tuple[EffectItem, ...]
    doc: str = ""


@dataclass(frozen=True, slots=True)
class HeuristicCase(Node):
    """`move(A, B, X, Y): …`: the change of the cost-to-go when the last action is this rule."""

    rule: str
    parameters: tuple[str, ...]
    value: Term


@dataclass(frozen=True, slots=True)
class HeuristicDecl(Node):
    name: str
    parameters: tuple[Parameter, ...]
    start: Term | None
    cases: tuple[HeuristicCase, ...]
    doc: str = ""


@dataclass(frozen=True, slots=True)
class EffectorItem(Node):
    """`effector A: port sphere(0.05 m) at (0, 0, 0) normal (0, 0, -1)`, or in a module from a URDF, with the name of a
    link, `effector A: port "tool0" sphere(4 cm)`. Without `shape` it is the shape of the link."""

    name: str
    type: str | None
    link: Text | None
    shape: Call | None
    at: Term | None
    normal: Term | None


@dataclass(frozen=True, slots=True)
class JointItem(Node):
    """`joint j2: revolute(y) in -120 deg .. 120 deg home 0.6 rad speed 2 rad/s acceleration 5 rad/s^2`, or with
    vectors of two lengths as limits `joint drive: planar(x, y) in (-5 m, -5 m) .. (5 m, 5 m)`."""

    name: str
    kind: str
    axes: tuple[Term, ...]
    lower: Term | None
    upper: Term | None
    home: Term | None
    speed: Term | None
    acceleration: Term | None


@dataclass(frozen=True, slots=True)
class LinkItem(Node):
    """`link 0.15 * size: capsule(0.04 m)`: go `length` metres along z, or by a vector, with that shape between."""

    length: Term
    shape: Call | None


@dataclass(frozen=True, slots=True)
class FactItem(Node):
    """`fact (linked A B)`, in a module, scene or task."""

    literal: Literal


@dataclass(frozen=True, slots=True)
class BranchItem(Node):
    """`branch { … }`: the items inside go on from here, and those behind it from here again."""

    items: tuple[ModuleItem, ...]


ModuleItem = EffectorItem | JointItem | LinkItem | FactItem | BranchItem


@dataclass(frozen=True, slots=True)
class ModuleDecl(Node):
    name: str
    parameters: tuple[Parameter, ...]
    urdf: Text | None
    items: tuple[ModuleItem, ...]
    doc: str = ""

    def flat(self) -> tuple[ModuleItem, ...]:
        """The items in the order of the text, those of branches in place of the branches."""
        return flat_items(self.items)


def flat_items(items: tuple[ModuleItem, ...]) -> tuple[ModuleItem, ...]:
    """`items` with those of branches in place of the branches."""
    found: list[ModuleItem] = []
    for item in items:
        found += flat_items(item.items) if isinstance(item, BranchItem) else (item,)
    return tuple(found)


@dataclass(frozen=True, slots=True)
class BodyItem(Node):
    """`base shelf[i]: box(0.3 m, 0.8 m, 0.05 m) at (0, 0, 0) heading 0.2`, or `object b: box(…) on shelf at (x, y)`."""

    type: str
    name: Term
    shape: Call
    on: Term | None
    at: Term | None
    heading: Term | None


@dataclass(frozen=True, slots=True)
class RobotItem(Node):
    """`arm c[k]: A on ground at (0, 0.3 * k) heading 90 deg`, with arguments `arm(size = 2 m) c: …`.
    Without `on` the module frame itself is put `at` a point."""

    type: str
    args: tuple[Argument, ...]
    name: Term
    effector: str | None
    on: Term | None
    at: Term | None
    heading: Term | None


@dataclass(frozen=True, slots=True)
class Argument(Node):
    """An argument in a use of a scene, module or heuristic; `name` is None for a positional one."""

    name: str | None
    value: Term


@dataclass(frozen=True, slots=True)
class ForItem(Node):
    binders: tuple[Parameter, ...]
    items: tuple[SceneItem, ...]


@dataclass(frozen=True, slots=True)
class IfItem(Node):
    """`if n > 3 { … }` among scene or task items."""

    condition: Formula
    items: tuple[SceneItem, ...]


@dataclass(frozen=True, slots=True)
class SceneUse(Node):
    """`scene shelves(n)` inside a task or another scene."""

    name: str
    args: tuple[Argument, ...]


@dataclass(frozen=True, slots=True)
class GoalItem(Node):
    """`goal (held target), (on shelf b)`: the conjuncts."""

    formulas: tuple[Formula, ...]


@dataclass(frozen=True, slots=True)
class GuideUse(Node):
    """`guide approach(target)`."""

    name: str
    args: tuple[Argument, ...]


@dataclass(frozen=True, slots=True)
class OptionsItem(Node):
    """`options { bound = path, time = 60 s }`; a value is a term (a name for words such as `path`)."""

    entries: tuple[tuple[str, Term], ...]


@dataclass(frozen=True, slots=True)
class CourseItem(Node):
    """`moves stair[3] along (0, 0, -0.1 m), (5 cm, 0, -0.1 m) at 1 cm/s from 5 s and back`: the body moves on its own
    through points that are measured from where it is when it starts; without `start` that is at once."""

    body: Term
    points: tuple[Term, ...]
    speed: Term
    start: Term | None
    returns: bool


@dataclass(frozen=True, slots=True)
class DisturbanceItem(Node):
    """`disturb target by (5 cm, 0, 0) at 12 s`: the body jumps."""

    body: Term
    by: Term
    time: Term


@dataclass(frozen=True, slots=True)
class BreakdownItem(Node):
    """`fail c[2] at 20 s: locked`: the module breaks down; `kind` is the word behind the colon."""

    module: Term
    time: Term
    kind: str


Happening = CourseItem | DisturbanceItem | BreakdownItem
SceneItem = (
    BodyItem | RobotItem | FactItem | ForItem | IfItem | SceneUse | GoalItem | GuideUse | OptionsItem | Happening
)


@dataclass(frozen=True, slots=True)
class SceneDecl(Node):
    name: str
    parameters: tuple[Parameter, ...]
    items: tuple[SceneItem, ...]
    doc: str = ""


@dataclass(frozen=True, slots=True)
class TaskDecl(Node):
    name: str
    parameters: tuple[Parameter, ...]
    items: tuple[SceneItem, ...]
    doc: str = ""


Declaration = (
    Import | TypeDecl | PredicateDecl | DerivedDecl | FunctionDecl | MotionDecl | RuleDecl | PlacementDecl
    | HeuristicDecl | ModuleDecl | SceneDecl | TaskDecl
)


@dataclass(frozen=True, slots=True)
class File(Node):
    """One parsed file: its declarations in source order."""

    path: str
    declarations: tuple[Declaration, ...]
