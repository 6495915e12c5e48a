"""Formulas made uniform: derived predicates replaced by their bodies, negations at the leaves, outer existential
variables pulled out. All functions are pure and keep meaning."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import count
from typing import Any, TypeVar

from ...langs.trees import children, mapped, parts
from ..ir import (
    Aggregate,
    And,
    ChainEnd,
    ChainModule,
    Compare,
    EffectFor,
    EffectIf,
    EffectItem,
    Exists,
    Forall,
    Formula,
    Literal,
    Not,
    Number,
    Object,
    Or,
    Previous,
    Problem,
    Term,
    Type,
    Var,
    Variable,
)
from .settings import SYMBOLIC

TRUE = And(())
FALSE = Or(())
NEGATED = {"=": "!=", "!=": "=", "<": ">=", ">=": "<", "<=": ">", ">": "<="}
Renaming = Mapping[str, Term]
Part = TypeVar("Part")
_NONE: frozenset[str] = frozenset()
_free: dict[int, tuple[Formula | Term | Type, frozenset[str]]] = {}
"""By identity: equality of large terms costs more than what is looked up."""


class NormalForm:
    """Makes fresh names, so that no variable is ever bound twice in one formula."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self._fresh = count()

    def conjuncts(self, formula: Formula) -> tuple[tuple[Variable, ...], tuple[Formula, ...]]:
        """The formula as `exists variables { and of conjuncts }`, in negation normal form."""
        hidden: list[Variable] = []
        found: list[Formula] = []
        waiting = [self.normal(formula, {}, False)]
        while waiting:
            item = waiting.pop(0)
            if isinstance(item, And):
                waiting[:0] = item.operands
            elif isinstance(item, Exists):
                hidden.extend(item.variables)
                waiting.insert(0, item.body)
            elif item not in found:
                found.append(item)
        return tuple(hidden), tuple(found)

    def alternatives(self, formula: Formula) -> list[tuple[tuple[Variable, ...], tuple[Formula, ...]]]:
        """As `conjuncts`, for formulas of which one must hold: disjunctions that bind variables of their own are split
        up, as long as there are no more than `most_alternatives`."""
        whole = [self.conjuncts(formula)]
        while True:
            split = [part for option in whole for part in self._split(option)]
            if len(split) == len(whole) or len(split) > SYMBOLIC.most_alternatives:
                return whole
            whole = split

    def _split(
        self, option: tuple[tuple[Variable, ...], tuple[Formula, ...]]
    ) -> list[tuple[tuple[Variable, ...], tuple[Formula, ...]]]:
        hidden, conjuncts = option
        for k, formula in enumerate(conjuncts):
            if isinstance(formula, Or) and any(isinstance(part, Exists) for part in parts(formula)):
                found = []
                for operand in formula.operands:
                    more, parts_ = self.conjuncts(operand)
                    found.append(((*hidden, *more), (*conjuncts[:k], *parts_, *conjuncts[k + 1 :])))
                return found
        return [option]

    def effects(self, items: Sequence[EffectItem]) -> tuple[EffectItem, ...]:
        """Effects whose conditions are in normal form."""
        found: list[EffectItem] = []
        for item in items:
            if isinstance(item, EffectIf):
                found.append(EffectIf(self.normal(item.condition, {}, False), self.effects(item.effects)))
            elif isinstance(item, EffectFor):
                found.append(EffectFor(item.variables, self.effects(item.effects)))
            else:
                found.append(item)
        return tuple(found)

    def normal(self, formula: Formula, renaming: Renaming, negate: bool) -> Formula:
        """`formula`, or its negation, with derived predicates replaced and variables of quantifiers renamed apart."""
        match formula:
            case Literal():
                literal = substitute(formula, renaming)
                derived = self.problem.derived.get(formula.predicate)
                if derived is not None:
                    inner = {v.name: a for v, a in zip(derived.variables, literal.args, strict=True)}
                    return self.normal(derived.body, inner, negate)
                return Not(literal) if negate else literal
            case Compare():
                compare = substitute(formula, renaming)
                return replace(compare, operator=NEGATED[compare.operator]) if negate else compare
            case Previous():
                previous = substitute(formula, renaming)
                return Not(previous) if negate else previous
            case Not():
                return self.normal(formula.operand, renaming, not negate)
            case And() | Or():
                operands = tuple(self.normal(f, renaming, negate) for f in formula.operands)
                return And(operands) if isinstance(formula, And) is not negate else Or(operands)
            case Exists() | Forall():
                variables, inner_names = self._renamed(formula.variables, renaming)
                body = self.normal(formula.body, inner_names, negate)
                kind = Exists if isinstance(formula, Exists) is not negate else Forall
                return kind(variables, body)

    def _renamed(
        self, variables: tuple[Variable, ...], renaming: Renaming
    ) -> tuple[tuple[Variable, ...], dict[str, Term]]:
        names = dict(renaming)
        fresh = []
        for variable in variables:
            name = f"{variable.name.partition('`')[0]}`{next(self._fresh)}"
            fresh.append(Variable(name, substitute(variable.type, names)))
            names[variable.name] = Var(name)
        return tuple(fresh), names


def substitute(part: Part, renaming: Renaming) -> Part:
    """A formula, term, variable or type with its free variables replaced; that of a chain only by another one."""
    if not renaming:
        return part
    found: Part = _substituted(part, renaming)
    return found


def _substituted(whole: Any, renaming: Renaming) -> Any:
    match whole:
        case Var():
            return renaming.get(whole.name, whole)
        case Literal() | Compare():
            pass
        case ChainEnd() | ChainModule():
            new = renaming.get(whole.chain)
            whole = replace(whole, chain=new.name) if isinstance(new, Var) else whole
        case Exists() | Forall() | Aggregate():
            bound = {v.name for v in whole.variables}
            renaming = {name: term for name, term in renaming.items() if name not in bound}
            if not renaming:
                return whole
    return mapped(whole, lambda inner: _substituted(inner, renaming))


def free_names(item: Formula | Term | Type) -> frozenset[str]:
    """Names of the variables that are free in a formula, term or type; those of the last `known_names` are kept."""
    if isinstance(item, Var):
        return frozenset((item.name,))
    if isinstance(item, Object | Number):
        return _NONE
    known = _free.get(id(item))
    if known is not None and known[0] is item:
        return known[1]
    if len(_free) >= SYMBOLIC.known_names:
        _free.clear()
    names = frozenset(_names(item))
    _free[id(item)] = item, names
    return names


def _names(item: object) -> set[str]:
    found: set[str] = set().union(*map(free_names, children(item)))
    match item:
        case ChainEnd() | ChainModule():
            found.add(item.chain)
        case Exists() | Forall() | Aggregate():
            found -= {v.name for v in item.variables}
    return found
