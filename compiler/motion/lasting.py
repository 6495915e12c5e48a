"""Contacts that last: which objects a motion literal lets touch as long as it holds.

They may touch, but not go into each other: rows hold one face or part of a thing, and it may have others.
"""

from __future__ import annotations

from collections.abc import Iterator

from ..ir import Arith, Fact, Function, MotionPredicate, Number, Problem, Row, Term, Var
from ..remembering import remembered

Places = tuple[tuple[int, int], ...]
Signed = tuple[int, Term]


def lasting(problem: Problem, literal: Fact) -> list[tuple[str, str]]:
    """The pairs of objects that the rows of a literal hold in contact, or of which it is stated that they may touch."""
    motion = problem.motions[literal[0]]
    places = *_implied(motion), *(_places(motion, a, b) for a, b in motion.touching)
    return [(literal[a], literal[b]) for a, b in places]


def _places(motion: MotionPredicate, first: str, second: str) -> tuple[int, int]:
    place = {variable.name: k for k, variable in enumerate(motion.variables, start=1)}
    return place[first], place[second]


@remembered(256)
def _implied(motion: MotionPredicate) -> Places:
    """The places in a literal of the pairs that `during` rows hold in contact, or that `keep` rows leave where switch
    rows have put them."""
    names = {variable.name for variable in motion.variables}
    begun = [_contact(row) for row in motion.rows if row.when == "switch"]
    held = [_contact(row) for row in motion.rows if row.when == "during"]
    held += [_contact(row) for row in motion.rows if row.when == "keep" and _contact(row) in begun]
    return tuple(sorted({_places(motion, *found[1:]) for found in held if found and names.issuperset(found[1:])}))


def _contact(row: Row) -> tuple[str, str, str] | None:
    """What a row makes 0, or keeps: the "gap" between two variables, or the "height" of one over the other."""
    if row.when != "keep" and row.operator != "=":
        return None
    terms = [*_summands(row.left, 1), *(_summands(row.right, -1) if row.right is not None else ())]
    match sorted(terms, key=lambda t: t[1].name if isinstance(t[1], Function) else ""):
        case [(_, Function(name="gap", args=(Var(name=one), Var(name=other))))]:
            return "gap", one, other
        case [
            (low, Function(name="bottom", args=(Var(name=one),))), (high, Function(name="top", args=(Var(name=other),)))
        ] if low != high:  # fmt: skip
            return "height", one, other
    return None


def _summands(term: Term, sign: int) -> Iterator[Signed]:
    """What is added up in a term, with its sign; zeros are nothing."""
    match term:
        case Arith(operator="+" | "-" as operator, operands=(one, other)):
            yield from _summands(one, sign)
            yield from _summands(other, sign if operator == "+" else -sign)
        case Number(value=0):
            return
        case _:
            yield sign, term
