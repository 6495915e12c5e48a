"""A refused candidate with other actions for those of its robots that were refused.

Robots that have nothing to do with each other make the orders of their actions many, and a search from the start goes
through all of them. Here each group of actions that share what they move is searched alone, as if the others were done.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

from ..conflicts.forbidden_sequences import EMPTY
from .best_first import Candidate, SkeletonSearch

Group = tuple[list[int], frozenset[str]]
"""Places of actions in a candidate, and what they move."""


def repaired(search: SkeletonSearch, candidate: Candidate, refused: Collection[int]) -> Candidate | None:
    """The candidate in which each group of actions, some of which were `refused`, is replaced by the cheapest other way
    of the same movers; None where there is only one group, or no such way. It is not proved to be cheapest."""
    groups = _groups(search, candidate)
    if len(groups) < 2:
        return None
    numbers: list[int] = []
    for places, movers in groups:
        way: Sequence[int] | None = [candidate.numbers[k] for k in places]
        if any(k in refused for k in places):
            others = [n for k, n in enumerate(candidate.numbers) if k not in places]
            state = _after(search, others)
            way = None if state is None else search.within(state, movers)
        if way is None:
            return None
        numbers += way
    return _candidate(search, numbers, candidate.lower_bound)


def _groups(search: SkeletonSearch, candidate: Candidate) -> list[Group]:
    """In the order of their first actions."""
    groups: list[Group] = []
    for k, number in enumerate(candidate.numbers):
        movers = search.no_goods.acting(number)
        joined = [group for group in groups if group[1] & movers]
        places = sorted([k, *(place for group in joined for place in group[0])])
        together: Group = places, movers.union(*(group[1] for group in joined))
        groups = sorted([*(group for group in groups if group not in joined), together])
    return groups


def _after(search: SkeletonSearch, numbers: Sequence[int]) -> int | None:
    """The state after actions from the start; None where they cannot follow each other."""
    state = search.successors.initial
    for number in numbers:
        following = search.successors.following(state, number)
        if following is None:
            return None
        state = following
    return state


def _candidate(search: SkeletonSearch, numbers: Sequence[int], bound: float) -> Candidate | None:
    """A candidate of these actions, if they reach the goal and nothing forbids them."""
    successors, no_goods = search.successors, search.no_goods
    state, past = successors.initial, (EMPTY, no_goods.root)
    for number in numbers:
        following = successors.following(state, number)
        then = None if following is None else no_goods.advance(*past, state, number)
        if following is None or then is None or (no_goods.active and not no_goods.allows(state, number)):
            return None
        state, past = following, then
    if not successors.is_goal(state):
        return None
    cost = sum(successors.cost(n) for n in numbers)
    actions = tuple(successors.action(n) for n in numbers)
    return Candidate(tuple(numbers), actions, cost, False, bound)
