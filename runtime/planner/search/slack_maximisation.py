"""Among plans as cheap as a candidate, one whose numeric conditions hold with more room.

A* is blind to how close a condition such as `stride(X, Y) <= reach(c)` is to its limit, and goes through plans at the
limit first, which motion mostly refuses. The plan with the least sum of high powers of its strains is found layer by
layer.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from ....compiler.symbolic.strain import Strain
from ....langs.frozen import dataclass
from ..conflicts.forbidden_sequences import EMPTY
from .settings import SEARCH

if TYPE_CHECKING:
    from .best_first import Candidate, SkeletonSearch

EQUAL = 1e-9


@dataclass(frozen=True, slots=True)
class _Node:
    """A way to a state: its strain and cost so far, what no-goods remember, and the way before."""

    strain: float
    cost: float
    state: int
    history: int
    place: int
    number: int
    before: _Node | None


def maximise_slack(search: SkeletonSearch, strain: Strain, candidate: Candidate) -> Candidate:
    """A candidate of the same cost and with the same kinds of actions, with the least strain that a search of bounded
    width finds; the candidate itself where there is none. No-goods are respected. Raises OutOfTime."""
    successors, no_goods = search.successors, search.no_goods
    flags = successors.layout.flag_mask
    state = successors.initial
    layer = [_Node(0.0, 0.0, state, EMPTY, no_goods.root, -1, None)]
    for number in candidate.numbers:
        search.budget.check()
        wanted = successors.action(number).rule
        state = successors.after(state, number)
        best: dict[tuple[int, int, int], _Node] = {}
        for node in layer:
            for following, action in successors.expand(node.state):
                if following & flags != state & flags or successors.action(action).rule != wanted:
                    continue
                cost = node.cost + successors.cost(action)
                if cost + search.value(following) > candidate.cost + EQUAL:
                    continue
                if no_goods.active and not no_goods.allows(node.state, action):
                    continue
                then = no_goods.advance(node.history, node.place, node.state, action)
                if then is None:
                    continue
                key = (following, *then)
                known = best.get(key)
                if known is not None and node.strain >= known.strain:
                    continue
                total = node.strain + strain.of(node.state, action) ** SEARCH.penalty_power
                if known is None or total < known.strain:
                    best[key] = _Node(total, cost, following, *then, action, node)
        layer = sorted(best.values(), key=lambda n: n.strain)[:SEARCH.slack_width]
    ends = [node for node in layer if successors.is_goal(node.state)]
    own = sum(s**SEARCH.penalty_power for s in strain.along(candidate.numbers))
    if not ends or ends[0].strain >= own - EQUAL:
        return candidate
    numbers = _numbers(ends[0])
    actions = tuple(successors.action(n) for n in numbers)
    return replace(candidate, numbers=numbers, actions=actions)


def _numbers(node: _Node) -> tuple[int, ...]:
    numbers = []
    current: _Node | None = node
    while current is not None and current.before is not None:
        numbers.append(current.number)
        current = current.before
    return tuple(reversed(numbers))
