"""Ground conditions on a packed state, as tests on masks and as Python source over the state `s`."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from ..ir import And, Any_, Fact, Formula, Literal, Not, Object, Or
from .layout import FIELD, Layout
from .normal_form import FALSE, TRUE

Test = tuple[int, int, bool]
"""Mask, value and whether `state & mask` must equal the value (or must differ from it)."""
Check = Callable[[int], bool]


def literal_test(layout: Layout, literal: Literal) -> Test:
    """A ground literal; with ANY in place of a functional value, that there is some value."""
    if any(isinstance(a, Any_) for a in literal.args):
        key = next(a.name for a in literal.args if isinstance(a, Object))
        place = layout.fields[literal.predicate, key]
        return place.mask << place.shift, 0, False
    mask, value = layout.encode(ground(literal))
    return mask, value, True


def ground(literal: Literal) -> Fact:
    """The fact that a literal over objects names."""
    names = tuple(a.name for a in literal.args if isinstance(a, Object))
    if len(names) != len(literal.args):
        raise ValueError(f"{literal} is not ground")
    return (literal.predicate, *names)


def as_test(layout: Layout, formula: Formula) -> Test | None:
    """A literal or its negation as one test; None for anything larger."""
    if isinstance(formula, Literal):
        return literal_test(layout, formula)
    if isinstance(formula, Not) and isinstance(formula.operand, Literal):
        mask, value, same = literal_test(layout, formula.operand)
        if mask == value and mask & (mask - 1) == 0:
            return (mask, 0, True)
        return mask, value, not same
    return None


def merged(tests: Sequence[Test]) -> list[Test] | None:
    """Fewer tests that say the same together; None when they contradict each other."""
    mask = value = 0
    rest: list[Test] = []
    for m, v, same in tests:
        if not same:
            rest.append((m, v, same))
        elif (value ^ v) & mask & m or v & ~m:
            return None
        else:
            mask, value = mask | m, value | v
    left = []
    for m, v, _ in rest:
        if m & mask == m:
            if value & m == v:
                return None
        else:
            left.append((m, v, False))
    return [*([(mask, value, True)] if mask else []), *dict.fromkeys(left)]


def split(layout: Layout, formulas: Sequence[Formula]) -> tuple[list[Test] | None, list[Formula]]:
    """The part of a conjunction that is tests, merged, and the rest."""
    tests: list[Test] = []
    rest: list[Formula] = []
    for formula in formulas:
        for part in formula.operands if isinstance(formula, And) else (formula,):
            test = as_test(layout, part)
            if test is None:
                rest.append(part)
            else:
                tests.append(test)
    return merged(tests), rest


def source(layout: Layout, formula: Formula) -> str:
    """Python source of a ground condition over the state `s`."""
    if formula == TRUE:
        return "True"
    if formula == FALSE:
        return "False"
    test = as_test(layout, formula)
    if test is not None:
        return test_source(test)
    match formula:
        case And():
            tests, rest = split(layout, formula.operands)
            if tests is None:
                return "False"
            parts = [*map(test_source, tests), *(f"({source(layout, f)})" for f in rest)]
            return " and ".join(parts) or "True"
        case Or():
            return _either(layout, formula)
        case _:
            raise ValueError(f"not ground: {formula}")


def test_source(test: Test) -> str:
    mask, value, same = test
    if value == 0:
        return f"not s & {mask}" if same else f"s & {mask}"
    if value == mask and mask & (mask - 1) == 0:
        return f"s & {mask}" if same else f"not s & {mask}"
    return f"s & {mask} {'==' if same else '!='} {value}"


def _either(layout: Layout, formula: Or) -> str:
    """Alternatives for the value of one field become one look-up in a set."""
    by_mask: dict[int, list[int]] = {}
    parts: list[str] = []
    for part in formula.operands:
        if isinstance(part, Literal) and layout.kinds[part.predicate] == FIELD:
            mask, value, same = literal_test(layout, part)
            if same:
                by_mask.setdefault(mask, []).append(value)
                continue
        parts.append(f"({source(layout, part)})")
    for mask, values in by_mask.items():
        listed = ", ".join(map(str, values))
        parts.append(f"s & {mask} in {{{listed}}}" if len(values) > 1 else f"s & {mask} == {listed}")
    return " or ".join(parts) or "False"


def compiled(layout: Layout, formula: Formula) -> Check:
    """A function that tells whether a ground condition holds in a packed state."""
    check: Check = eval(f"lambda s: bool({source(layout, formula)})", {})
    return check
