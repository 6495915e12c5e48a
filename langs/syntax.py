"""The syntax tree: what the parser gives and the formatter prints. One frozen class per construct.

Numbers are already in SI units (metres, radians, seconds). Every node has a `span`, which takes no part in comparison,
so two trees are equal when they say the same. Terms, conditions and effects are in `syntax_terms`.
"""

from __future__ import annotations

from .frozen import dataclass
from .syntax_parts import CouplingItem, EffectorItem, Holds, JointItem, LinkItem, PhysicalNode, Stated
from .syntax_terms import (
    Aggregate,
    And,
    Attribute,
    Binary,
    Call,
    ChainType,
    Compare,
    Conditional,
    Effect,
    EffectFor,
    EffectIf,
    EffectItem,
    Exists,
    Forall,
    Formula,
    Index,
    Literal,
    Name,
    NamedType,
    Negate,
    Node,
    Not,
    Number,
    Or,
    Parameter,
    Previous,
    RangeType,
    Term,
    Text,
    Type,
    Vector,
    Wildcard,
)  # fmt: skip

__all__ = [
    "Aggregate", "And", "Argument", "Attribute", "Binary", "BodyItem", "BranchItem", "BreakdownItem", "Call",
    "ChainType", "Compare", "Conditional", "CouplingItem", "CourseItem", "Declaration", "DerivedDecl",
    "DisturbanceItem", "Effect", "EffectFor", "EffectIf", "EffectItem", "EffectorItem", "Exists", "FactItem",
    "File", "ForItem", "Forall", "Formula", "FunctionDecl", "GoalItem", "GuideUse", "Happening", "HeuristicCase",
    "HeuristicDecl", "Holds", "IfItem", "Import", "Index", "JointItem", "LinkItem", "Literal", "ModuleDecl",
    "ModuleItem", "MotionDecl", "MotionFor", "MotionItem", "MotionRow", "MotionTouching", "Name", "NamedType",
    "Negate", "Node", "Not", "Number",
    "OptionsItem", "Or", "Parameter", "PlacementDecl", "PredicateDecl", "Previous", "RangeType", "RobotItem",
    "RuleDecl", "SceneDecl", "SceneItem", "SceneUse", "Stated", "TaskDecl", "Term", "Text", "Type", "TypeDecl",
    "Vector", "Wildcard", "flat_items",
]  # fmt: skip

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


@dataclass(frozen=True, slots=True)
class MotionTouching(Node):
    """`touching X Y`: the two may touch as long as the literal holds."""

    first: Term
    second: Term


MotionItem = MotionRow | MotionTouching | MotionFor


@dataclass(frozen=True, slots=True)
class MotionDecl(Node):
    name: str
    parameters: tuple[Parameter, ...]
    symmetric: bool
    items: tuple[MotionItem, ...]
    doc: str = ""
    borne: str | None = None


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
class FactItem(Node):
    """`fact (linked A B)`, in a module, scene or task."""

    literal: Literal


@dataclass(frozen=True, slots=True)
class BranchItem(Node):
    """`branch { … }`: the items inside go on from here, and those behind it from here again."""

    items: tuple[ModuleItem, ...]


ModuleItem = EffectorItem | JointItem | CouplingItem | LinkItem | FactItem | BranchItem


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
class BodyItem(PhysicalNode):
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
    """`moves shelf[3] along (0, 0, -0.1 m), (5 cm, 0, -0.1 m) at 1 cm/s from 5 s and back`: the body moves on its own
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
