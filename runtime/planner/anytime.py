"""Behind a first plan: better ones, until the gap is as small as was asked for, or nothing promises more."""

from __future__ import annotations

import math
from collections.abc import Callable

from ...langs.frozen import dataclass
from ..budget import Budget
from .schedule.clocked_search import Clocked
from .schedule.settings import SCHEDULE
from .search.best_first import Candidate


@dataclass(frozen=True, slots=True)
class Steps:
    """What a run lets one do: `propose` the next candidate by the cost of actions, `take` one through the bounds
    (whether it is accepted), ask whether it `repeats` a plan that stands, but for a detour, and what the best plan is
    `worth`; and search for the candidate that is most `promising`, below a value (None: enough below those met), with
    at most so many nodes, or for one whose postures are `nearer` to each other."""

    propose: Callable[[], Candidate | None]
    take: Callable[[Candidate], bool]
    repeats: Callable[[Candidate], bool]
    worth: Callable[[], float]
    promising: Callable[[float | None, int], Clocked]
    nearer: Callable[[int], Clocked]


def cheaper(steps: Steps, gap: float | None, least: float) -> None:
    """Plans of cheaper actions, as long as some may cost less by more than the gap; none costs less than `least`."""
    for _ in range(SCHEDULE.detours):
        best = steps.worth()
        if gap is None or best - least <= gap:
            return
        candidate = steps.propose()
        if candidate is None or candidate.cost >= best or candidate.lower_bound >= best - gap:
            return
        steps.take(candidate)


def better(steps: Steps, gap: float | None, budget: Budget) -> None:
    """Plans that are better by the objective. Without a gap, what promises most, until one is not better. Raises
    OutOfTime."""
    if gap is not None:
        _closer(steps, gap, budget)
        return
    left = _followed(steps, lambda: steps.promising(None, SCHEDULE.clocked_nodes), SCHEDULE.better)
    taken = SCHEDULE.better - left
    if _followed(steps, lambda: steps.nearer(SCHEDULE.nearer_nodes), left + 1) <= left or taken:
        steps.promising(None, SCHEDULE.clocked_nodes)


def _followed(steps: Steps, search: Callable[[], Clocked], most: int) -> int:
    """Take what a search gives, until nothing is better, at most so many candidates; how many are left of them."""
    while most:
        best, candidate = steps.worth(), search().candidate
        if candidate is None:
            break
        most -= 1
        if steps.take(candidate) and steps.worth() >= best:
            break
    return most


def _closer(steps: Steps, gap: float, budget: Budget) -> None:
    """What promises most; while that takes too many nodes to find, what is cheapest by its actions."""
    nodes, cut = SCHEDULE.clocked_nodes, math.inf
    while True:
        budget.check()
        best, found = steps.worth(), None
        if best < cut:
            clocked = steps.promising(best - gap, nodes)
            found, cut = clocked.candidate, best if clocked.cut else math.inf
            if found is None and not clocked.cut:
                return
        found = steps.propose() if found is None else found
        if found is None:
            nodes, cut = 2 * nodes, math.inf
        elif not steps.repeats(found):
            steps.take(found)
