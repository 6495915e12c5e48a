"""Which objects a motion literal keeps where they are to each other."""

from __future__ import annotations

from .ir import Fact, Function, MotionPredicate, Problem, Var
from .remembering import remembered


def keeps_pose(problem: Problem, literal: Fact) -> tuple[str, str] | None:
    """The objects `(fixed to, follows)` whose relative pose a motion literal keeps, or None."""
    places = places_kept(problem.motions[literal[0]])
    return (literal[1 + places[0]], literal[1 + places[1]]) if places else None


@remembered(256)
def places_kept(predicate: MotionPredicate) -> tuple[int, int] | None:
    """The places among the arguments of a literal of the objects `(fixed to, follows)` whose relative pose it keeps."""
    places = {variable.name: place for place, variable in enumerate(predicate.variables)}
    for row in predicate.rows:
        left = row.left
        if row.when == "keep" and isinstance(left, Function) and left.name == "pose":
            follows, fixed = left.args
            if isinstance(follows, Var) and isinstance(fixed, Var):
                return places[fixed.name], places[follows.name]
    return None


@remembered(8)
def kept_pairs(problem: Problem, mode: frozenset[Fact]) -> tuple[tuple[str, str], ...]:
    """Pairs of objects `(fixed to, follows)` whose relative pose the literals of a mode keep, in a fixed order."""
    return tuple(pair for pair in (keeps_pose(problem, literal) for literal in sorted(mode)) if pair)
