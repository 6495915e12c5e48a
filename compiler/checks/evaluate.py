"""Values of terms that hold numbers only: arithmetic, functions, and `jitter` and `random` by the seed."""

from __future__ import annotations

import math
import operator as operators
import random
from collections.abc import Callable

from .. import ir

FUNCTIONS: dict[str, Callable[..., float]] = {
    "sqrt": math.sqrt,
    "abs": abs,
    "least": min,
    "sin": math.sin,
    "cos": math.cos,
    "floor": math.floor,
}
OPERATORS: dict[str, Callable[[float, float], float]] = {
    "+": operators.add,
    "-": operators.sub,
    "*": operators.mul,
    "/": operators.truediv,
}


class EvaluationError(Exception):
    """A term has no value: a division by zero, the root of a negative number, or one too large. `code` is that of the
    diagnostic."""

    def __init__(self, message: str, code: str) -> None:
        super().__init__(message)
        self.code = code


def function_value(name: str, arguments: list[float], source: random.Random | None) -> float | None:
    """The value of a built-in function of numbers; None for one that needs the scene or, without `source`, chance."""
    if name in FUNCTIONS:
        try:
            return FUNCTIONS[name](*arguments)
        except (ValueError, OverflowError) as error:
            values = ", ".join(f"{a:g}" for a in arguments)
            raise EvaluationError(f"`{name}` has no value for {values}", "E0205") from error
    if source is None:
        return None
    if name == "jitter":
        return source.uniform(-arguments[0], arguments[0])
    if name == "random":
        return source.uniform(arguments[0], arguments[1])
    return None


def arithmetic(operator: str, left: float, right: float) -> float:
    """`left operator right`; whole numbers stay whole except under division."""
    if operator == "/" and right == 0:
        raise EvaluationError("division by zero", "E0211")
    try:
        value = OPERATORS[operator](left, right)
        finite = math.isfinite(value)
    except OverflowError:
        finite = False
    if not finite:
        raise EvaluationError("this value is too large", "E0009")
    return value


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
