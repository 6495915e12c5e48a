"""Connectives of reduced formulas, and arithmetic of numbers and arrays."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from ..ir import And, Arith, Compare, Exists, Forall, Formula, Function, Not, Number, Or, Term
from .normal_form import FALSE, NEGATED, TRUE

Environment = Mapping[str, Any]
"""Values of variables: an object's name, a number, a chain; or an array of object indices for a whole row at once."""

COMPARISONS: dict[str, Callable[[Any, Any], Any]] = {
    "=": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}
SLACK = 1e-9


class Undefined(Exception):
    """A term without value, such as a module past the end of a chain."""


def flip(formula: Formula) -> Formula:
    """The negation of a normal-form formula, negations at the leaves again."""
    match formula:
        case And():
            return Or(tuple(flip(f) for f in formula.operands))
        case Or():
            return And(tuple(flip(f) for f in formula.operands))
        case Exists():
            return Forall(formula.variables, flip(formula.body))
        case Forall():
            return Exists(formula.variables, flip(formula.body))
        case Not():
            return formula.operand
        case Compare():
            return Compare(NEGATED[formula.operator], formula.left, formula.right)
        case _:
            return Not(formula)


def negation(formula: Formula) -> Formula:
    if formula == TRUE:
        return FALSE
    if formula == FALSE:
        return TRUE
    return flip(formula)


def conjunction(parts: Iterable[Formula]) -> Formula:
    """And of reduced formulas, flattened and without repetition."""
    return _joined(parts, And, TRUE, FALSE)


def disjunction(parts: Iterable[Formula]) -> Formula:
    """Or of reduced formulas, flattened and without repetition."""
    return _joined(parts, Or, FALSE, TRUE)


def _joined(parts: Iterable[Formula], kind: type[And] | type[Or], neutral: Formula, absorbing: Formula) -> Formula:
    found: dict[Formula, None] = {}
    for part in parts:
        if part == absorbing:
            return absorbing
        if part != neutral:
            found.update(dict.fromkeys(part.operands if isinstance(part, kind) else (part,)))
    return next(iter(found)) if len(found) == 1 else kind(tuple(found))


def arithmetic(name: str, values: Sequence[Any]) -> Any:
    """+ - * / of two values, or "neg" of one."""
    if name == "neg" or len(values) == 1:
        return -values[0]
    left, right = values
    return {"+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv}[name](left, right)


def is_plain(formula: Compare) -> bool:
    """Whether both sides are lengths made of geometry and arithmetic only."""

    def plain(term: Term) -> bool:
        if isinstance(term, Function):
            return term.name in ("distance", "stride", "radius", "abs", "sqrt")
        return isinstance(term, Number) or (isinstance(term, Arith) and all(map(plain, term.operands)))

    return plain(formula.left) and plain(formula.right)


MATHS: dict[str, Callable[..., Any]] = {
    "abs": np.abs,
    "sqrt": np.sqrt,
    "sin": math.sin,
    "cos": math.cos,
    "floor": math.floor,
}


def holds(comparison: str, left: Any, right: Any) -> Any:
    """Compare two numbers up to a rounding error, so that the negation of each comparison is another one. Works on
    arrays."""
    if comparison in ("=", "!="):
        return COMPARISONS["<=" if comparison == "=" else ">"](abs(left - right), SLACK)
    slack = SLACK if comparison in ("<=", ">") else -SLACK
    return COMPARISONS[comparison](left, right + slack)
