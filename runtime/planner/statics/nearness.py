"""How near to each other the frames of kept pairs are: as the scene puts them, or as the rows say that joined them."""

from __future__ import annotations

import math

from ....compiler.ir import Arith, Fact, Function, Number, Problem, Row, Term, Var, Vector
from ....compiler.kept_pairs import kept_pairs
from ....compiler.motion.collision import bounding_radius
from ...skeleton import Phase
from .settings import STATICS

NOWHERE = math.inf
AS_PLACED = -math.inf
"""Stands for the distance of a pair that has been kept from the start on."""
Pair = frozenset[str]
Joined = frozenset[tuple[Pair, float]]
"""Pairs that are kept, each with how far from each other their frames are at most, in metres."""


def joined_pairs(problem: Problem, phases: tuple[Phase, ...]) -> list[Joined]:
    """By phase, the pairs that have been kept since the start or since rows told how near they are."""
    known = dict.fromkeys((frozenset(pair) for pair in kept_pairs(problem, problem.init_motion)), AS_PLACED)
    made, found = dict[Pair, float](), []
    for phase in phases:
        kept = {frozenset(pair) for pair in kept_pairs(problem, phase.mode)}
        known = {pair: apart for pair, apart in (known | made).items() if pair in kept}
        found.append(frozenset(known.items()))
        made = {}
        for literal in phase.added:
            pair, apart = frozenset(literal[1:3]), told_apart(problem, literal)
            if len(literal) > 2 and apart < NOWHERE and pair not in known:
                made[pair] = min(apart, made.get(pair, NOWHERE))
    return found


def told_apart(problem: Problem, literal: Fact) -> float:
    """How far from each other the frames of the first two objects of a literal are at most where it is added."""
    predicate = problem.motions[literal[0]]
    given = {v.name: name for v, name in zip(predicate.variables, literal[1:], strict=True)}
    pair = frozenset(literal[1:3])
    rows = (row for row in predicate.rows if row.when == "switch")
    return min((_apart(problem, row, given, pair) for row in rows), default=NOWHERE) + STATICS.missed


def _apart(problem: Problem, row: Row, given: dict[str, str], pair: Pair) -> float:
    left, right = row.left, row.right
    if right is None:
        return NOWHERE
    if isinstance(left, Function) and left.name == "gap" and row.operator in ("=", "<="):
        if not isinstance(right, Number) or {_name(a, given) for a in left.args} != pair:
            return NOWHERE
        return max(right.value, 0.0) + sum(radius_of(problem, name) for name in pair)
    if row.operator != "=":
        return NOWHERE
    ends, rest = dict[str, int](), 0.0
    for sign, term in [*_summands(left, 1), *_summands(right, -1)]:
        name = _name(term.args[0], given) if isinstance(term, Function) and term.name == "position" else None
        if name is not None:
            ends[name] = ends.get(name, 0) + sign
        else:
            rest += size_of(problem, term, given)
    return rest if frozenset(ends) == pair and sorted(ends.values()) == [-1, 1] else NOWHERE


def _summands(term: Term, sign: int) -> list[tuple[int, Term]]:
    if isinstance(term, Arith) and term.operator in ("+", "-") and len(term.operands) == 2:
        first, second = term.operands
        return [*_summands(first, sign), *_summands(second, sign if term.operator == "+" else -sign)]
    if isinstance(term, Arith) and term.operator == "neg":
        return _summands(term.operands[0], -sign)
    return [(sign, term)]


def _name(term: Term, given: dict[str, str]) -> str | None:
    return given.get(term.name) if isinstance(term, Var) else None


def size_of(problem: Problem, term: Term, given: dict[str, str]) -> float:
    """A bound of the size of a number, or of the length of a vector, wherever robots are; infinite where none is
    known."""
    match term:
        case Number():
            return abs(term.value)
        case Vector():
            return math.hypot(*[size_of(problem, item, given) for item in term.items])
        case Function(name="axis"):
            return 1.0
        case Function(name="radius", args=(Var() as of,)) if of.name in given:
            return radius_of(problem, given[of.name])
        case Arith(operator="+" | "-", operands=(first, second)):
            return size_of(problem, first, given) + size_of(problem, second, given)
        case Arith(operator="*", operands=(first, second)):
            return size_of(problem, first, given) * size_of(problem, second, given)
        case Arith(operator="neg", operands=(first,)):
            return size_of(problem, first, given)
        case _:
            return NOWHERE


def radius_of(problem: Problem, name: str) -> float:
    """How far the shape of an end or a body comes from its frame at most; 0 without a shape."""
    found = problem.world.effector(name)
    body = problem.world.bodies.get(name)
    shape = found[1].shape if found is not None else body.shape if body is not None else None
    if shape is None:
        return 0.0
    return bounding_radius(shape)
