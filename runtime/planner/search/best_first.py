"""Search for skeletons: best-first on packed states with duplicate detection, replanning around refused sequences.

Traps that this avoids: a child that a guard prunes is not marked as seen; a refused skeleton does not close its states,
since every call searches anew; costs and conflicts that read earlier actions are part of a node's key.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from ....compiler.ir import Action, Problem
from ....compiler.symbolic.costs import CostToGo
from ....compiler.symbolic.estimate import Estimate
from ....compiler.symbolic.renaming import renamed_action, renaming
from ....compiler.symbolic.successors import Successors
from ....langs.frozen import dataclass
from ...budget import Budget, Status
from ...plan import SearchNode
from ..conflicts.forbidden_sequences import EMPTY, OFF, NoGoods
from .settings import SEARCH

if TYPE_CHECKING:
    from .learned_penalties import LearnedPenalties

EQUAL = 1e-9

Past = tuple[int, int, int | None]
"""What no-goods and guide remember of the way here: number of the history, place in the tree of prefixes, previous
action."""
NOTHING: Past = (EMPTY, OFF, None)
Parent = tuple[Any, int, int, int]
"""The key before, the action that led on from a state that has it, that state, and where it led."""
Key = Any
"""A state, up to renaming of modules; with what is remembered, where something is."""


@dataclass(frozen=True, slots=True)
class Candidate:
    """A plan of the symbolic layer: action numbers and actions, its cost, a lower bound on the cost of any plan that
    the no-goods leave, and whether it is proved to be cheapest."""

    numbers: tuple[int, ...]
    actions: tuple[Action, ...]
    cost: float
    optimal: bool
    lower_bound: float


@dataclass(frozen=True, slots=True)
class Aside:
    """A search from another state than the start, in which only these movers act."""

    state: int
    movers: frozenset[str]


class SkeletonSearch:
    """Candidates in the order of their cost. `next` gives None when there is none, and `status` says why: `infeasible`
    (proved: every reachable state was seen), `exhausted` (only no-goods made it so) or `budget`.

    Methods: `astar` (cheapest first; hurried by a weight once one search has expanded HURRY nodes), `wastar` (weighted
    from the start), `bfs` (no estimate), `guide` (best-first by the task's own cost-to-go, as in the thesis).
    """

    def __init__(
        self, problem: Problem, successors: Successors, method: str, budget: Budget, node_limit: int | None = None
    ) -> None:
        self.problem = problem
        self.successors = successors
        self.method = method
        self.budget = budget
        self.node_limit = node_limit
        self.guide = CostToGo(problem, successors)
        self.estimate = Estimate(successors)
        self.no_goods = NoGoods(problem, successors)
        self.renaming = renaming(successors)
        self.surcharge: Callable[[int, int], float] | None = None
        """What an action costs in a state beyond its own cost, never below 0: it leads the search, and candidates still
        tell their own cost."""
        self._values: dict[int, float] = {}
        self._priced: Callable[[int], float] | None = None
        self._priced_values: dict[int, float] = {}
        self.tree: list[SearchNode] = []
        self.tree_nodes = 0
        self.expanded_nodes = 0
        self.hurried = False
        self.status = Status.RUNNING

    def next(self) -> Candidate | None:
        """The next candidate, or None; see `status`."""
        weights = {"astar": 1.0, "wastar": SEARCH.hurried_weight, "bfs": 0.0, "guide": 0.0}
        if self.no_goods.forbids_all:
            self.status = Status.EXHAUSTED
            return None
        weight = SEARCH.hurried_weight if self.hurried and self.method == "astar" else weights[self.method]
        return _Run(self, weight).run()

    def within(self, state: int, movers: frozenset[str]) -> tuple[int, ...] | None:
        """The cheapest way from a state to the goal on which only these movers act, none of which has acted before;
        None where a short search finds none."""
        found = _Run(self, 1.0, Aside(state, movers), self.expanded_nodes + SEARCH.repair_nodes).run()
        self.status = Status.RUNNING
        return None if found is None else found.numbers

    def forbid_plan(self, candidate: Candidate) -> None:
        """Do not propose exactly this plan again, nor any that begins with it."""
        self.no_goods.forbid_prefix(candidate.numbers)

    def forbid_orders(self, numbers: tuple[int, ...], before: tuple[frozenset[int], ...]) -> None:
        """Do not propose these actions again in any order in which each comes behind those `before` it, by place."""
        self.no_goods.forbid_orders(numbers, before)

    def forbid_actions(
        self, candidate: Candidate, first: int, last: int, from_start: bool = False, survives: float = 0
    ) -> None:
        """Do not propose actions `first` … `last` of a candidate one after the other again, from where their robots
        are, until refusals are readmitted; with `from_start` only when they open the plan, after the actions before
        them, and over so many readmissions."""
        if from_start:
            self.no_goods.forbid_prefix(candidate.numbers[: last + 1], survives)
        else:
            before = self._state_before(candidate, first)
            self.no_goods.forbid_sequence(candidate.numbers[first : last + 1], before)

    def forbid_beside(self, candidate: Candidate, index: int, names: frozenset[str]) -> None:
        """Do not propose this plan up to an action again, nor that action from where its robots are while nothing is
        said otherwise of what is named, until refusals are readmitted."""
        self.no_goods.forbid_beside(candidate.numbers[index], self._state_before(candidate, index), names)
        self.no_goods.forbid_prefix(candidate.numbers[: index + 1], 0)

    def _state_before(self, candidate: Candidate, index: int) -> int:
        state = self.successors.initial
        for number in candidate.numbers[:index]:
            state = self.successors.after(state, number)
        return state

    def readmit(self) -> bool:
        """Give refused sequences a second chance, and modules that stand for each other a chance each; False when
        there were none."""
        self.renaming = None
        return self.no_goods.readmit()

    def value(self, state: int) -> float:
        """The automatic estimate of the cost that is left; remembered from search to search."""
        known = self._values.get(state)
        if known is None:
            known = self._values[state] = self.estimate.value(state)
        return known

    def charge(self, surcharge: LearnedPenalties) -> None:
        """From now on actions cost what `surcharge` says on top; the estimate knows."""
        self.surcharge = surcharge.of
        self._priced = self.estimate.priced(surcharge.price)
        self._priced_values.clear()

    @property
    def expect(self) -> Callable[[int], float]:
        """The estimate of the cost that is left, surcharges included."""
        return self.value if self._priced is None else self._expected

    def _expected(self, state: int) -> float:
        """As `value`, with surcharges; remembered until they change."""
        assert self._priced is not None
        known = self._priced_values.get(state)
        if known is None:
            known = self._priced_values[state] = self._priced(state)
        return known

    def out_of_budget(self) -> bool:
        """Whether time or nodes are spent; sets `status`."""
        spent = self.budget.remaining <= 0.0 or self.budget.full
        if spent or (self.node_limit is not None and self.expanded_nodes >= self.node_limit):
            self.status = Status.BUDGET
            return True
        return False


class _Run:
    """One search from the start. Entries of the queue: priority, estimate, guide, age, key, state, cost, past."""

    def __init__(
        self, search: SkeletonSearch, weight: float, aside: Aside | None = None, limit: float = math.inf
    ) -> None:
        """With `aside` names stay, since others keep theirs. `limit` bounds the nodes that are expanded in all."""
        self.search = search
        self.limit = limit if search.node_limit is None else min(limit, search.node_limit)
        self.start = search.successors.initial if aside is None else aside.state
        self.movers = None if aside is None else aside.movers
        self.place = search.no_goods.root if aside is None else search.no_goods.aside
        self.renaming = search.renaming if aside is None else None
        self.weight = weight
        self.guided = search.method == "guide"
        self.expect = search.expect
        self.queue: list[tuple[float, float, float, int, Key, int, float, Past]] = []
        self.cheapest: dict[Key, float] = {}
        self.parents: dict[Key, Parent] = {}
        self.records: dict[Key, int] = {}
        self.age = 0
        self.cut = False
        self.order = 1 if search.method == "bfs" else -1
        no_goods = search.no_goods
        self.remembers = no_goods.watches or self.place >= 0 or (self.guided and search.guide.reads_previous)
        self.representative = False
        """Whether the search goes through renamed states; the plan gets its names at the end."""

    def run(self) -> Candidate | None:
        search = self.search
        self._push(self.start, 0.0, search.guide.start, (EMPTY, self.place, None), None, None)
        search.tree_nodes += 1
        budget = search.budget
        budget.grown += 1
        pops = 0
        while self.queue:
            spent = search.expanded_nodes >= self.limit
            look = spent or pops % SEARCH.clock_period == 0 or budget.full
            if look and (search.out_of_budget() or spent):
                return None
            if pops == SEARCH.hurry_after and search.method == "astar" and not search.hurried:
                self._hurry()
            pops += 1
            if pops == SEARCH.renaming_from and self.renaming is not None and not self.remembers:
                self.representative = True
            _, estimate, guide, _, key, state, cost, past = heapq.heappop(self.queue)
            if cost > self.cheapest[key]:
                continue
            if search.successors.is_goal(state):
                self._record(key, cost + estimate, "goal")
                return self._candidate(key, cost)
            self._record(key, cost + estimate, "expanded")
            search.expanded_nodes += 1
            self._expand(key, state, cost, guide, past)
        search.status = Status.EXHAUSTED if self.cut else Status.INFEASIBLE
        return None

    def _expand(self, key: Key, state: int, cost: float, guide: float, past: Past) -> None:
        search, no_goods = self.search, self.search.no_goods
        allowed = no_goods.allows if no_goods.active else None
        children = search.successors.expand(state)
        if self.movers is not None:
            children = [child for child in children if no_goods.acting(child[1]) <= self.movers]
        search.tree_nodes += len(children)
        search.budget.grown += len(children)
        action_cost, cheapest, surcharge = search.successors.cost, self.cheapest, search.surcharge
        for following, action in children:
            if allowed is not None and not allowed(state, action):
                self.cut = True
                continue
            then: Past | None = self._advance(past, state, action) if self.remembers else past
            if then is None:
                self.cut = True
                continue
            child_key = self._key(following, then)
            child_cost = cost + action_cost(action)
            if surcharge is not None:
                child_cost += surcharge(state, action)
            known = cheapest.get(child_key)
            if known is not None and (known <= child_cost or self.guided):
                continue
            value = guide + search.guide.change(state, action, self.parents[key][1] if key in self.parents else None)
            if self.guided and value == math.inf:
                continue
            kept = child_key if self.representative else following
            self._push(kept, child_cost, value, then, child_key, (key, action, state, following))

    def _push(
        self, state: int, cost: float, guide: float, past: Past, key: Key, parent: Parent | None
    ) -> None:
        """Queue a state, unless it is known that no way leads from it to the goal."""
        estimate = self.expect(state)
        if estimate == math.inf:
            return
        if parent is None:
            key = self._key(state, past)
        else:
            self.parents[key] = parent
        self.cheapest[key] = cost
        self.age += self.order
        priority = guide if self.guided else cost + self.weight * estimate
        shown = 0.0 if self.weight == 0.0 else estimate
        tie = 0.0 if self.order > 0 else guide
        heapq.heappush(self.queue, (priority, shown, tie, self.age, key, state, cost, past))

    def _key(self, state: int, past: Past) -> Key:
        """States that differ only in names are one, unless names are remembered."""
        if self.remembers and past != NOTHING:
            return state, past
        renaming = self.renaming
        return state if renaming is None else renaming.canonical(state)

    def _advance(self, past: Past, state: int, action: int) -> Past | None:
        """What must be remembered after one more action; None when a no-good forbids it."""
        then = self.search.no_goods.advance(past[0], past[1], state, action)
        if then is None:
            return None
        return *then, action if self.guided and self.search.guide.reads_previous else None

    def _hurry(self) -> None:
        """Weigh the estimate more from now on, in the searches after this one too."""
        more, self.weight, self.search.hurried = SEARCH.hurried_weight - self.weight, SEARCH.hurried_weight, True
        self.queue = [(e[0] + more * e[1], *e[1:]) for e in self.queue]
        heapq.heapify(self.queue)

    def _candidate(self, key: Key, cost: float) -> Candidate:
        search = self.search
        path: list[tuple[int, int, int]] = []
        while key in self.parents:
            key, number, state, following = self.parents[key]
            path.append((state, number, following))
        numbers = self._numbers(path[::-1])
        actions = tuple(search.successors.action(n) for n in numbers)
        bound = self._lower_bound(cost)
        if search.surcharge is not None:
            cost = sum(search.successors.cost(n) for n in numbers)
            bound = min(cost, search.value(search.successors.initial))
        search.status = Status.RUNNING
        return Candidate(tuple(numbers), actions, cost, bound >= cost - EQUAL and not self.cut, bound)

    def _numbers(self, path: list[tuple[int, int, int]]) -> list[int]:
        """The actions of a path from the start itself. Where a state on the path only stands for the one that is
        reached, what follows gets the names that modules have there."""
        successors, renaming = self.search.successors, self.renaming
        if all(state == before[2] for before, (state, _, _) in pairwise(path)):
            return [number for _, number, _ in path]
        state = met = self.start
        names: dict[str, str] = {}
        numbers = []
        for kept, chosen, led in path:
            if kept != met and renaming is not None:
                back = {new: names.get(old, old) for old, new in renaming.names(met).items()}
                alike = kept != renaming.canonical(met)
                names = {old: back.get(new, new) for old, new in renaming.names(kept).items()} if alike else back
            action = renamed_action(successors.action(chosen), names)
            state, number = next((t, a) for t, a in successors.expand(state) if successors.action(a) == action)
            met = led
            numbers.append(number)
        return numbers

    def _lower_bound(self, cost: float) -> float:
        """No plan that the no-goods leave is cheaper than this."""
        if self.guided:
            return min(self.search.value(self.search.successors.initial), cost)
        waiting = (e[6] + e[1] for e in self.queue if e[6] <= self.cheapest[e[4]])
        return min(cost, min(waiting, default=cost))

    def _record(self, key: Key, estimate: float, status: str) -> None:
        tree = self.search.tree
        if len(tree) >= SEARCH.recorded_nodes:
            return
        parent = self.parents.get(key)
        action = "" if parent is None else str(self.search.successors.action(parent[1]))
        self.records[key] = len(tree)
        above = -1 if parent is None else self.records.get(parent[0], -1)
        tree.append(SearchNode(len(tree), above, action, float(estimate), status))
