"""Texts of objectives, read: a task's option, `--minimise`, the Python interface."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence

from ..langs import syntax
from ..langs.diagnostics import UsageError, did_you_mean
from ..langs.source import Source, Span
from ..langs.trees import parts
from .objectives import EXAMPLE, MEASURES, Objective


class ObjectiveFault(Exception):
    """A text that is no objective: a code, where, what is wrong, and a hint."""

    def __init__(self, code: str, span: Span, message: str, help: str | None = None) -> None:
        super().__init__(message)
        self.code, self.span, self.help = code, span, help


Weight = Callable[[syntax.Term], float | None]
"""The value of a term that names no measure; None where it is not known, or wrong in itself."""


def objective_of(term: syntax.Term, weight: Weight, known: Callable[[str], bool]) -> Objective | None:
    """The objective that a term spells; None where a weight is wrong in itself. `known` tells the names that weights
    may hold. Raises ObjectiveFault."""
    sums: dict[str, float] = {}
    for name, share in _summands(term, 1.0, weight, known):
        if share is None:
            return None
        sums[name] = sums.get(name, 0.0) + share
    for name, total in sums.items():
        if total < 0.0 or not math.isfinite(total):
            told = f"the weight of {name} is {total:g}"
            raise ObjectiveFault("E0214", term.span, told, "weights are positive: what is minimised is a cost")
    kept = tuple((name, sums[name]) for name in MEASURES if sums.get(name, 0.0) > 0.0)
    if not kept:
        raise ObjectiveFault("E0214", term.span, "all weights are zero", f"write `{EXAMPLE}`")
    return Objective(kept, term.span)


def _summands(
    term: syntax.Term, share: float | None, weight: Weight, known: Callable[[str], bool]
) -> Iterator[tuple[str, float | None]]:
    """The measures in a sum, each with its weight."""
    match term:
        case syntax.Name(name=name) if name in MEASURES:
            yield name, share
        case syntax.Negate(operand=operand):
            yield from _summands(operand, _times(share, -1.0), weight, known)
        case syntax.Binary(operator="+" | "-" as operator, left=left, right=right):
            yield from _summands(left, share, weight, known)
            yield from _summands(right, _times(share, 1.0 if operator == "+" else -1.0), weight, known)
        case syntax.Binary(operator="*", left=left, right=right) if _has_measure(left) or _has_measure(right):
            factor, rest = (right, left) if _has_measure(left) else (left, right)
            yield from _summands(rest, _times(share, _weight(factor, weight)), weight, known)
        case syntax.Binary(operator="/", left=left, right=right) if _has_measure(left):
            divisor = _weight(right, weight)
            if divisor == 0.0:
                raise ObjectiveFault("E0211", right.span, "a weight is divided by zero")
            yield from _summands(left, _times(share, None if divisor is None else 1.0 / divisor), weight, known)
        case _:
            raise _stray(term, known)


def _times(one: float | None, other: float | None) -> float | None:
    return None if one is None or other is None else one * other


def _weight(term: syntax.Term, weight: Weight) -> float | None:
    if _has_measure(term):
        raise ObjectiveFault("E0215", term.span, "two objectives are multiplied", f"add them up: `{EXAMPLE}`")
    quantity = next((n for n in parts(term) if isinstance(n, syntax.Number) and n.kind), None)
    if quantity is not None:
        told = f"`{quantity.text}` is no weight: weights are plain numbers, per second, radian, joule or action"
        raise ObjectiveFault("E0215", quantity.span, told, f"write `{EXAMPLE}`")
    return weight(term)


def _stray(term: syntax.Term, known: Callable[[str], bool]) -> ObjectiveFault:
    """What is wrong with a part of a sum that is no measure."""
    names = (n for n in parts(term) if isinstance(n, syntax.Name) and n.name not in MEASURES)
    name = next((n for n in names if not known(n.name)), None)
    if name is not None:
        help = did_you_mean(name.name, MEASURES) or f"known here: {', '.join(f'`{m}`' for m in MEASURES)}"
        return ObjectiveFault("E0212", name.span, f"unknown objective `{name.name}`", help)
    told = "this has no unit in common with an objective: it measures nothing of a plan"
    return ObjectiveFault("E0215", term.span, told, f"write `{EXAMPLE}`")


def _has_measure(term: syntax.Node) -> bool:
    return any(isinstance(n, syntax.Name) and n.name in MEASURES for n in parts(term))


def spelled(text: str) -> Objective:
    """The objective that a text spells, whose weights are numbers. Raises UsageError, with a code."""
    from ..langs.parser import parse

    file, wrong = parse(Source("minimise", f"task t() {{ options {{ minimise = {text} }} }}"))
    term = None if wrong else _only_entry(file.declarations)
    if term is None:
        raise UsageError(f"`{text}` is no objective", "E0210", help=f"write one such as `{EXAMPLE[11:]}`")
    try:
        found = objective_of(term, _constant, lambda _: False)
    except ObjectiveFault as fault:
        raise UsageError(str(fault), fault.code, help=fault.help) from None
    if found is None:
        raise UsageError(f"a weight in `{text}` is no number", "E0210")
    return Objective(found.weights)


def _only_entry(declarations: Sequence[syntax.Declaration]) -> syntax.Term | None:
    """The value of the only option of the only task."""
    match declarations:
        case [syntax.TaskDecl(items=[syntax.OptionsItem(entries=[(_, term)])])]:
            return term
    return None


def _constant(term: syntax.Term) -> float | None:
    match term:
        case syntax.Number(value=value):
            return value
        case syntax.Negate(operand=operand):
            return _times(_constant(operand), -1.0)
        case syntax.Binary(operator="*", left=left, right=right):
            return _times(_constant(left), _constant(right))
        case syntax.Binary(operator="/", left=left, right=right):
            divisor = _constant(right)
            return _times(_constant(left), 1.0 / divisor) if divisor else None
    return None
