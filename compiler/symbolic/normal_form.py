"""Formulas made uniform: derived predicates replaced by their bodies, negations at the leaves, outer existential
variables pulled out. All functions are pure and keep meaning."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import count

from ..ir import (
    Aggregate,
    And,
    Arith,
    ChainEnd,
    ChainModule,
    ChainType,
    Compare,
    Conditional,
    EffectFor,
    EffectIf,
    EffectItem,
    Exists,
    Forall,
    Formula,
    Function,
    Literal,
    Not,
    Or,
    Previous,
    Problem,
    RangeType,
    Term,
    Type,
    Var,
    Variable,
    Vector,
)

TRUE = And(())
FALSE = Or(())
MOST_ALTERNATIVES = 16
NEGATED = {"=": "!=", "!=": "=", "<": ">=", ">=": "<", "<=": ">", ">": "<="}
Renaming = Mapping[str, Term]
MOST_KNOWN = 10000
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
        up, as long as there are no more than `MOST_ALTERNATIVES`."""
        whole = [self.conjuncts(formula)]
        while True:
            split = [part for option in whole for part in self._split(option)]
            if len(split) == len(whole) or len(split) > MOST_ALTERNATIVES:
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
                args = tuple(substitute(a, renaming) for a in formula.args)
                derived = self.problem.derived.get(formula.predicate)
                if derived is not None:
                    inner = {v.name: a for v, a in zip(derived.variables, args, strict=True)}
                    return self.normal(derived.body, inner, negate)
                literal = Literal(formula.predicate, args, formula.motion, formula.span)
                return Not(literal) if negate else literal
            case Compare():
                operator = NEGATED[formula.operator] if negate else formula.operator
                left, right = self._term(formula.left, renaming), self._term(formula.right, renaming)
                return Compare(operator, left, right, formula.span)
            case Previous():
                args_ = None if formula.args is None else tuple(substitute(a, renaming) for a in formula.args)
                return Not(Previous(formula.rule, args_)) if negate else Previous(formula.rule, args_)
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
            fresh.append(Variable(name, substitute_type(variable.type, names)))
            names[variable.name] = Var(name)
        return tuple(fresh), names

    def _term(self, term: Term, renaming: Renaming) -> Term:
        return substitute(term, renaming)


def substitute(term: Term, renaming: Renaming) -> Term:
    """`term` with variables replaced; a chain variable may only be replaced by another one."""
    match term:
        case Var():
            return renaming.get(term.name, term)
        case ChainEnd():
            return ChainEnd(_chain_name(term.chain, renaming), term.last)
        case ChainModule():
            return ChainModule(_chain_name(term.chain, renaming), substitute(term.index, renaming), term.side)
        case Function():
            return Function(term.name, tuple(substitute(a, renaming) for a in term.args))
        case Arith():
            return Arith(term.operator, tuple(substitute(a, renaming) for a in term.operands))
        case Vector():
            return Vector(tuple(substitute(a, renaming) for a in term.items))
        case Conditional():
            condition = rename(term.condition, renaming)
            return Conditional(condition, substitute(term.then, renaming), substitute(term.otherwise, renaming))
        case Aggregate():
            inner = {n: t for n, t in renaming.items() if all(v.name != n for v in term.variables)}
            variables = tuple(Variable(v.name, substitute_type(v.type, inner)) for v in term.variables)
            return Aggregate(term.operator, variables, substitute(term.body, inner))
        case _:
            return term


def rename(formula: Formula, renaming: Renaming) -> Formula:
    """`formula` with its free variables replaced."""
    match formula:
        case Literal():
            return Literal(formula.predicate, tuple(substitute(a, renaming) for a in formula.args), formula.motion)
        case Compare():
            return Compare(formula.operator, substitute(formula.left, renaming), substitute(formula.right, renaming))
        case Previous():
            args = None if formula.args is None else tuple(substitute(a, renaming) for a in formula.args)
            return Previous(formula.rule, args)
        case Not():
            return Not(rename(formula.operand, renaming))
        case And() | Or():
            return type(formula)(tuple(rename(f, renaming) for f in formula.operands))
        case Exists() | Forall():
            inner = {n: t for n, t in renaming.items() if all(v.name != n for v in formula.variables)}
            variables = tuple(Variable(v.name, substitute_type(v.type, inner)) for v in formula.variables)
            return type(formula)(variables, rename(formula.body, inner))


def substitute_type(kind: Type, renaming: Renaming) -> Type:
    if isinstance(kind, RangeType):
        return RangeType(substitute(kind.first, renaming), substitute(kind.last, renaming))
    return kind


def _chain_name(name: str, renaming: Renaming) -> str:
    new = renaming.get(name)
    return new.name if isinstance(new, Var) else name


def free_names(item: Formula | Term | Type) -> frozenset[str]:
    """Names of the variables that are free in a formula, term or type; those of the last `MOST_KNOWN` are kept."""
    known = _free.get(id(item))
    if known is not None and known[0] is item:
        return known[1]
    if len(_free) >= MOST_KNOWN:
        _free.clear()
    names = frozenset(_names(item))
    _free[id(item)] = item, names
    return names


def _names(item: Formula | Term | Type) -> Iterator[str]:
    match item:
        case Var():
            yield item.name
        case ChainEnd():
            yield item.chain
        case ChainModule():
            yield item.chain
            yield from _names(item.index)
        case Function() | Literal():
            for part in item.args:
                yield from _names(part)
        case Previous():
            for part in item.args or ():
                yield from _names(part)
        case Arith() | And() | Or():
            for operand in item.operands:
                yield from _names(operand)
        case Vector():
            for part in item.items:
                yield from _names(part)
        case Conditional():
            yield from _names(item.condition)
            yield from _names(item.then)
            yield from _names(item.otherwise)
        case Not():
            yield from _names(item.operand)
        case Compare():
            yield from _names(item.left)
            yield from _names(item.right)
        case RangeType():
            yield from _names(item.first)
            yield from _names(item.last)
        case Exists() | Forall() | Aggregate():
            bound = {v.name for v in item.variables}
            inner = [*(_names(v.type) for v in item.variables), _names(item.body)]
            for names in inner:
                yield from (n for n in names if n not in bound)
        case ChainType():
            return
        case _:
            return


def conjuncts(formula: Formula) -> Iterator[Formula]:
    """The parts of a formula that all have to hold."""
    if isinstance(formula, And):
        for part in formula.operands:
            yield from conjuncts(part)
    else:
        yield formula


def parts(item: Formula | Term) -> Iterator[Formula | Term]:
    """A formula or term and everything in it, types of variables left out."""
    yield item
    inner: tuple[Formula | Term, ...] = ()
    match item:
        case Conditional():
            inner = (item.condition, item.then, item.otherwise)
        case Arith() | And() | Or():
            inner = item.operands
        case Function() | Literal():
            inner = item.args
        case Previous():
            inner = item.args or ()
        case Vector():
            inner = item.items
        case ChainModule():
            inner = (item.index,)
        case Aggregate() | Exists() | Forall():
            inner = (item.body,)
        case Not():
            inner = (item.operand,)
        case Compare():
            inner = (item.left, item.right)
        case _:
            pass
    for part in inner:
        yield from parts(part)
