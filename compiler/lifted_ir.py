"""The lifted half of the IR: types, terms, formulas and declarations, which keep their variables, chains and loops.

Frozen; nothing here depends on how many modules or bodies a scene has. `span` fields point to the source text and take
no part in comparison.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import field

from ..langs.frozen import dataclass
from ..langs.source import Span
from ..langs.trees import parts

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
    """`ANY`: matches every object; only inside deleted literals and `previous` patterns, as conditions say `exists`."""

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
    its letter as a second argument `Letter`, `torque` the name of a joint."""

    name: str
    args: tuple[Term, ...]
    span: Span | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class Letter:
    """The x, y or z in `axis(X, z)`, or the name of a joint."""

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


def conjuncts(formula: Formula) -> Iterator[Formula]:
    """The parts of a formula that all have to hold."""
    if isinstance(formula, And):
        for part in formula.operands:
            yield from conjuncts(part)
    else:
        yield formula


def span_of(formula: Formula) -> Span | None:
    """Where the first literal or comparison of a formula stands."""
    spans = (part.span for part in parts(formula) if isinstance(part, Literal | Compare))
    return next((span for span in spans if span is not None), None)


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
    borne: str | None = None
    """How a pair of which it holds is borne: bond, dock, grip, pad or rest, or not at all: nothing."""
    touching: tuple[tuple[str, str], ...] = ()
    """Pairs of variables whose objects may touch as long as it holds: those that are stated."""


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


def effects_of(items: Iterable[EffectItem]) -> Iterator[Effect]:
    """Every effect, however deep in loops and conditions."""
    return (part for part in parts(tuple(items)) if isinstance(part, Effect))


def effects_with_loops(
    items: Iterable[EffectItem], loops: tuple[Variable, ...] = ()
) -> Iterator[tuple[Effect, tuple[Variable, ...]]]:
    """Every effect with the variables of the loops around it."""
    for item in items:
        if isinstance(item, Effect):
            yield item, loops
        else:
            around = (*loops, *item.variables) if isinstance(item, EffectFor) else loops
            yield from effects_with_loops(item.effects, around)


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
