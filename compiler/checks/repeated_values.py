"""Numbers that a loop of a scene asks for again and again: once checked, only their arithmetic is repeated."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from ...langs import syntax
from ..ir import Shape
from .evaluate import FUNCTIONS, EvaluationError, arithmetic, function_value
from .names import Entry

Evaluator = Callable[[Mapping[str, Entry]], float]


class Repeated:
    """The terms that were checked and had a value, each with how to find it for other values of its names: what kinds
    they have depends on the text alone."""

    def __init__(self) -> None:
        self._known: dict[int, tuple[syntax.Term, Evaluator | None]] = {}
        self._shapes: dict[tuple[int, tuple[float | None, ...]], tuple[syntax.Call, Shape]] = {}

    def checked(self, term: syntax.Term) -> None:
        """A term was found to be in order."""
        if id(term) not in self._known:
            self._known[id(term)] = term, _evaluator(term)

    def value(self, term: syntax.Term, entries: Mapping[str, Entry]) -> float | None:
        """The value of a term that was checked before; None where it must be checked again."""
        known = self._known.get(id(term))
        if known is None or known[1] is None:
            return None
        try:
            return known[1](entries)
        except (EvaluationError, KeyError, _UnknownValue):
            return None


    def shape(self, call: syntax.Call, entries: Mapping[str, Entry], make: Callable[[], Shape | None]) -> Shape | None:
        """The shape that a call makes; where it was checked before and all its sizes have values, shapes of equal sizes
        are one."""
        sizes = tuple([self.value(argument, entries) for argument in call.args])
        if None in sizes:
            return make()
        key = id(call), sizes
        if key not in self._shapes:
            made = make()
            if made is None:
                return None
            self._shapes[key] = call, made
        return self._shapes[key][1]


class _UnknownValue(Exception):
    """A name has no value yet."""


def _evaluator(term: syntax.Term) -> Evaluator | None:
    """None for a term of more than names, numbers and arithmetic."""
    match term:
        case syntax.Number(value=value):
            return lambda entries: value
        case syntax.Name(name=name):
            return lambda entries: _named(entries, name)
        case syntax.Negate():
            operand = _evaluator(term.operand)
            return operand and (lambda entries: -operand(entries))
        case syntax.Binary():
            return _binary(term.operator, _evaluator(term.left), _evaluator(term.right))
        case syntax.Call():
            return _call(term.function, [_evaluator(argument) for argument in term.args])
        case _:
            return None


def _named(entries: Mapping[str, Entry], name: str) -> float:
    value = entries[name].typed.value
    if value is None:
        raise _UnknownValue
    return value


def _binary(operator: str, left: Evaluator | None, right: Evaluator | None) -> Evaluator | None:
    if left is None or right is None:
        return None
    return lambda entries: arithmetic(operator, left(entries), right(entries))


def _call(name: str, arguments: list[Evaluator | None]) -> Evaluator | None:
    known = [argument for argument in arguments if argument is not None]
    if name not in FUNCTIONS or len(known) < len(arguments):
        return None

    def value(entries: Mapping[str, Entry]) -> float:
        found = function_value(name, [argument(entries) for argument in known], None)
        assert found is not None
        return found

    return value
