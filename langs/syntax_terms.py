"""The syntax tree, first half: terms, conditions, variables and effects. `syntax` has the rest.

Numbers are already in SI units (metres, radians, seconds); `Number.kind` keeps the kind of quantity.
Every node has a `span`, which takes no part in comparison, so two trees are equal when they say the same.
"""

from __future__ import annotations

from dataclasses import field

from .frozen import dataclass
from .source import Span


@dataclass(frozen=True, slots=True, kw_only=True)
class Node:
    span: Span = field(compare=False, repr=False)


# --- terms -----------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Number(Node):
    """`3`, `0.05 m`, `120 deg`: the value in SI, the kind ("" plain, "length", "angle", "time", "speed",
    "angular speed", "acceleration", "angular acceleration", "jerk", "angular jerk", "mass", "density", "force",
    "torque", "inertia") and text."""

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
    """`distance(X, Y)`, `box(1 m, 1 m, 5 cm)`. A part of `union(…)`, `box(…) at (…)`, is one of `at`."""

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
