"""Values of terms that hold numbers only: arithmetic, functions, and `jitter` and `random` by the seed."""

from __future__ import annotations

import math
import random
from collections.abc import Callable

from .. import ir

FUNCTIONS: dict[str, Callable[..., float]] = {
    "sqrt": math.sqrt,
    "abs": abs,
    "sin": math.sin,
    "cos": math.cos,
    "floor": math.floor,
}


class EvaluationError(Exception):
    """A term has no value: a division by zero or the root of a negative number."""


def function_value(name: str, arguments: list[float], source: random.Random | None) -> float | None:
    """The value of a built-in function of numbers; None for one that needs the scene or, without `source`, chance."""
    if name in FUNCTIONS:
        try:
            return FUNCTIONS[name](*arguments)
        except (ValueError, OverflowError) as error:
            raise EvaluationError(f"`{name}` has no value for {', '.join(f'{a:g}' for a in arguments)}") from error
    if source is None:
        return None
    if name == "jitter":
        return source.uniform(-arguments[0], arguments[0])
    if name == "random":
        return source.uniform(arguments[0], arguments[1])
    return None


def arithmetic(operator: str, left: float, right: float) -> float:
    """`left operator right`; whole numbers stay whole except under division."""
    if operator == "+":
        return left + right
    if operator == "-":
        return left - right
    if operator == "*":
        return left * right
    if right == 0:
        raise EvaluationError("division by zero")
    return left / right


def compare(operator: str, left: float, right: float) -> bool:
    """The truth of a comparison of two numbers."""
    return {
        "=": left == right,
        "!=": left != right,
        "<": left < right,
        "<=": left <= right,
        ">": left > right,
        ">=": left >= right,
    }[operator]


def truth(formula: ir.Formula) -> bool | None:
    """The truth of a formula over numbers; None where it speaks of objects or of something unknown."""
    if isinstance(formula, ir.Not):
        value = truth(formula.operand)
        return None if value is None else not value
    if isinstance(formula, ir.And | ir.Or):
        values = [truth(f) for f in formula.operands]
        if None in values:
            return None
        return all(values) if isinstance(formula, ir.And) else any(values)
    if isinstance(formula, ir.Compare) and isinstance(formula.left, ir.Number) and isinstance(formula.right, ir.Number):
        return compare(formula.operator, formula.left.value, formula.right.value)
    return None
