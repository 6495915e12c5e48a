"""The search: cheapest plans, an estimate that never says too much, replanning around refusals, honest endings."""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterator

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamplang.compiler.ir import And, Body, Chain, Formula, Not, Object, Problem, Shape
from tamplang.compiler.symbolic.strain import Strain
from tamplang.compiler.symbolic.successors import Successors
from tamplang.runtime.budget import Budget
from tamplang.runtime.planner.search.best_first import Candidate, SkeletonSearch, _Run
from tamplang.runtime.planner.search.learned_penalties import LearnedPenalties
from tamplang.runtime.planner.search.skeleton_replay import build_skeleton

from . import variants
from .problems import box, climb, lit, module, pick_and_place, problem

METHODS = ("astar", "wastar", "bfs", "guide")


def started(problem: Problem, method: str = "astar", nodes: int | None = None) -> SkeletonSearch:
    return SkeletonSearch(problem, Successors(problem), method, Budget(20), nodes)


def layers(successors: Successors, most: int) -> Iterator[set[int]]:
    """States by the number of actions that they need, by plain breadth-first search."""
    seen = {successors.initial}
    layer = {successors.initial}
    while layer and len(seen) <= most:
        yield layer
        layer = {t for s in layer for t, _ in successors.expand(s)} - seen
        seen |= layer


def goals(items: int) -> st.SearchStrategy[Formula]:
    held = st.just(lit("held", Object("target")))
    places = ["ground", *(f"stair[{i}]" for i in range(1, items + 1))]
    stands = st.builds(
        lambda place, end: lit("on", Object(place), Object(f"c[1].{end}")),
        st.sampled_from(places),
        st.sampled_from("AB"),
    )
    docked = st.just(lit("connected", Object("c[1].A"), Object("c[2].B")))
    parts = st.one_of(held, stands, docked, st.just(Not(lit("support", Object("c[1].A")))))
    return st.lists(parts, min_size=1, max_size=3).map(lambda found: And(tuple(found)))


@st.composite
def climbs(draw: st.DrawFn) -> Problem:
    stairs, crawlers = draw(st.sampled_from([(4, 1), (3, 2), (4, 2), (1, 3)]))
    goal = draw(goals(stairs).filter(lambda g: crawlers > 1 or "c[2]" not in str(g)))
    return climb(stairs, crawlers, draw(st.integers(0, 50)), goal, draw(st.floats(0.2, 2.5)), draw(st.floats(0, 0.2)))


def check_estimate(problem: Problem, most: int = 1500) -> None:
    """Along breadth-first layers the estimate at the start, and from every state on, is at most the true distance."""
    successors = Successors(problem)
    estimate = started(problem).estimate
    found = list(layers(successors, most))
    states = set().union(*found)
    complete = all(t in states for s in states for t, _ in successors.expand(s))
    before: dict[int, list[int]] = {}
    for s in states:
        for t, _ in successors.expand(s):
            before.setdefault(t, []).append(s)
    left = {s: 0 for s in states if successors.is_goal(s)}
    layer = list(left)
    while layer:
        following = []
        for t in layer:
            for s in before.get(t, ()):
                if s not in left:
                    left[s] = left[t] + 1
                    following.append(s)
        layer = following
    for state in states:
        if state in left:
            assert estimate.value(state) <= left[state] + 1e-9
    if complete and successors.initial not in left:
        assert started(problem).next() is None
    if successors.initial in left:
        search = started(problem)
        candidate = search.next()
        assert candidate is not None and candidate.optimal
        replayed(search, candidate)
        assert candidate.cost == left[successors.initial]


@settings(max_examples=12, deadline=None)
@given(climbs())
def test_the_estimate_never_exceeds_the_true_cost_on_stairs(problem: Problem) -> None:
    check_estimate(problem)


@pytest.mark.parametrize("items, trays", [(1, 1), (2, 2), (4, 1)])
def test_the_estimate_never_exceeds_the_true_cost_on_items(items: int, trays: int) -> None:
    check_estimate(pick_and_place(items, trays))


@pytest.mark.parametrize("name", variants.PROBLEMS)
def test_the_estimate_never_exceeds_the_true_cost_on_variants(name: str) -> None:
    check_estimate(variants.PROBLEMS[name]())


def scattered(modules: int, height: float, apart: float = 0.7) -> Problem:
    """Plates in a row, a module on every third, and a target that only some modules together reach."""
    plates = [box(f"plate[{i}]", "base", (0.4, 0.4, 0.05), (apart * i, 0, 0)) for i in range(3 * modules - 2)]
    target = Body("target", "object", Shape("sphere", (0.04,)), (0, 0, height, 0, 0, 0, 1), True)
    robots = [module(f"c[{k}]", 3 * apart * k, 0, 0.025) for k in range(modules)]
    facts = {fact for k in range(modules) for fact in stands(f"c[{k}]", f"plate[{3 * k}]")}
    return problem([*plates, target], robots, facts | {("grippable", "target")}, lit("held", Object("target")))


def stands(name: str, base: str) -> set[tuple[str, ...]]:
    return {("support", f"{name}.A"), ("on", base, f"{name}.A")}


@pytest.mark.parametrize("modules, height", [(2, 0.9), (2, 1.5), (2, 2.1), (2, 4.0), (3, 1.9), (3, 2.8)])
def test_the_estimate_counts_missing_links(modules: int, height: float) -> None:
    check_estimate(scattered(modules, height), 4000)


def test_links_alone_are_counted_exactly() -> None:
    for modules in (2, 4, 8):
        search = started(scattered(modules, 1.1 * modules - 0.3, 0.0))
        candidate = search.next()
        assert candidate is not None and candidate.cost == modules == search.value(search.successors.initial)
        assert search.expanded_nodes == modules


@pytest.mark.parametrize("method", METHODS)
def test_every_method_finds_a_plan(method: str) -> None:
    search = started(climb(4, 2, rise=0.8), method)
    candidate = search.next()
    assert candidate is not None
    replayed(search, candidate)
    if method in ("astar", "bfs"):
        assert candidate.optimal and candidate.lower_bound == candidate.cost


def replayed(search: SkeletonSearch, candidate: Candidate) -> None:
    state = search.successors.initial
    for action in candidate.actions:
        state = next(t for t, a in search.successors.expand(state) if search.successors.action(a) == action)
    assert search.successors.is_goal(state)
    assert len(build_skeleton(search.problem, candidate.actions)) == len(candidate.actions)


def test_the_estimate_scales_with_the_items() -> None:
    search = started(pick_and_place(64))
    candidate = search.next()
    assert candidate is not None and candidate.cost == 128 == search.value(search.successors.initial)
    assert search.expanded_nodes <= 129


def test_a_forbidden_plan_is_not_proposed_again() -> None:
    search = started(climb(4, 1))
    seen = set()
    for _ in range(20):
        candidate = search.next()
        assert candidate is not None and candidate.actions not in seen
        seen.add(candidate.actions)
        replayed(search, candidate)
        search.forbid_plan(candidate)


def test_a_refusal_ends_the_claim_of_optimality() -> None:
    search = started(climb(6, 1))
    first = search.next()
    assert first is not None and first.optimal and len(first.actions) >= 3
    search.forbid_actions(first, 1, 2, from_start=True)
    second = search.next()
    assert second is not None and not second.optimal
    assert second.numbers[:3] != first.numbers[:3]


def test_candidates_come_in_the_order_of_cost() -> None:
    search = started(climb(3, 2, rise=0.8))
    costs = []
    for _ in range(15):
        candidate = search.next()
        assert candidate is not None
        costs.append(candidate.cost)
        search.forbid_plan(candidate)
    assert costs == sorted(costs)


def test_a_refused_action_is_dropped_for_every_module_of_the_type() -> None:
    search = started(climb(8, 2))
    candidate = search.next()
    assert candidate is not None
    at = next(i for i, a in enumerate(candidate.actions) if a.rule in ("step", "stepTogether"))
    refused = candidate.actions[at]
    search.forbid_actions(candidate, at, at)
    following = search.next()
    assert following is not None
    for action in following.actions:
        same_shape = [len(a.modules) if isinstance(a, Chain) else 0 for a in action.args]
        refused_shape = [len(a.modules) if isinstance(a, Chain) else 0 for a in refused.args]
        assert (action.rule, action.args[-2:], same_shape) != (refused.rule, refused.args[-2:], refused_shape)


def states(search: SkeletonSearch, candidate: Candidate) -> list[int]:
    found = [search.successors.initial]
    for number in candidate.numbers:
        found.append(next(t for t, a in search.successors.expand(found[-1]) if a == number))
    return found


def test_a_refused_pair_is_avoided_anywhere() -> None:
    search = started(climb(4, 1))
    refused: list[object] = []
    for _ in range(8):
        candidate = search.next()
        assert candidate is not None
        pairs = [
            search.no_goods.bare(candidate.numbers[i : i + 2]) for i in range(len(candidate.actions) - 1)
        ]
        assert not set(pairs) & set(refused)
        refused.append(pairs[0])
        search.forbid_actions(candidate, 0, 1)
    assert search.readmit()
    assert not search.readmit()


def test_a_refused_beginning_is_forbidden_to_its_last_action() -> None:
    search = started(climb(6, 1))
    first = search.next()
    assert first is not None and len(first.actions) >= 3
    search.forbid_actions(first, 0, 1, from_start=True)
    second = search.next()
    assert second is not None and second.numbers[:2] != first.numbers[:2]
    search.forbid_actions(second, 0, 0, from_start=True)
    third = search.next()
    assert third is not None and third.numbers[0] != second.numbers[0]


def test_a_refusal_holds_only_where_the_robot_stands() -> None:
    search = started(climb(6, 2, rise=1.3))
    bases = set()
    for _ in range(4):
        candidate = search.next()
        assert candidate is not None
        last = len(candidate.actions) - 1
        assert candidate.actions[last].rule == "grasp"
        place = search.no_goods.context(states(search, candidate)[last], candidate.numbers[last])
        bases.add(tuple(fact[2] for fact in place))
        search.forbid_actions(candidate, last, last)
    assert len(bases) == 4


def test_a_goal_out_of_reach_is_proved_infeasible() -> None:
    search = started(climb(3, 1, rise=9.0))
    assert search.next() is None
    assert search.status == "infeasible"
    assert math.isinf(search.value(search.successors.initial))


def test_refusals_alone_make_the_search_exhausted() -> None:
    search = started(climb(1, 1, rise=0.5))
    while (candidate := search.next()) is not None:
        for at in range(len(candidate.actions)):
            search.forbid_actions(candidate, at, at)
    assert search.status == "exhausted"


def test_node_and_time_limits_end_the_search() -> None:
    search = started(climb(16, 2), "bfs", nodes=50)
    assert search.next() is None
    assert search.status == "budget"
    assert search.expanded_nodes == 50
    problem = climb(4, 1)
    spent = SkeletonSearch(problem, Successors(problem), "astar", Budget(0.0))
    assert spent.next() is None
    assert spent.status == "budget"


@pytest.mark.parametrize("crawlers, rise", [(3, 2.6), (4, 1.0)])
def test_plans_through_renamed_states_get_their_names_back(crawlers: int, rise: float) -> None:
    search = started(climb(8, crawlers, rise=rise))
    for _ in range(3):
        candidate = search.next()
        assert candidate is not None
        replayed(search, candidate)
        search.forbid_actions(candidate, len(candidate.actions) - 1, len(candidate.actions) - 1)


def test_the_search_is_deterministic() -> None:
    plans = [started(climb(6, 2)).next() for _ in range(2)]
    assert plans[0] == plans[1]


@pytest.mark.parametrize("stairs, crawlers, weight", [(24, 2, 1.5), (6, 3, 1.0)])
def test_plans_stay_whole_when_refusals_make_actions_dearer(stairs: int, crawlers: int, weight: float) -> None:
    search = started(climb(stairs, crawlers, rise=0.2))
    surcharge = LearnedPenalties(Strain(search.successors))
    for _ in range(6):
        candidate = _Run(search, weight).run()
        assert candidate is not None
        replayed(search, candidate)
        strains = surcharge.strain.along(candidate.numbers)
        at = max(range(len(strains) - 1), key=lambda i: strains[i] + strains[i + 1])
        search.forbid_actions(candidate, at, at + 1)
        surcharge.refused(candidate.numbers, at, at + 1)
        search.charge(surcharge)


def test_the_estimate_knows_what_strained_actions_cost_and_never_says_too_much() -> None:
    search = started(climb(8, 2, rise=0.2))
    successors, surcharge = search.successors, LearnedPenalties(Strain(search.successors))
    states = set().union(*layers(successors, 3000))
    candidate = search.next()
    assert candidate is not None
    for _ in range(4):
        surcharge.refused(candidate.numbers, 0, len(candidate.numbers) - 1)
    search.charge(surcharge)
    before: dict[int, list[tuple[int, float]]] = {}
    for s in states:
        for t, number in successors.expand(s):
            before.setdefault(t, []).append((s, successors.cost(number) + surcharge.of(s, number)))
    left: dict[int, float] = {}
    queue = [(0.0, s) for s in states if successors.is_goal(s)]
    while queue:
        cost, t = heapq.heappop(queue)
        if t not in left:
            left[t] = cost
            for s, more in before.get(t, ()):
                heapq.heappush(queue, (cost + more, s))
    for s, cost in left.items():
        assert search.expect(s) <= cost + 1e-9
    assert search.expect(successors.initial) > search.value(successors.initial) + 0.1


def test_a_search_with_dearer_actions_goes_straight_to_its_goal() -> None:
    search = started(climb(60, 2, rise=0.2))
    surcharge = LearnedPenalties(Strain(search.successors))
    candidate = search.next()
    assert candidate is not None
    surcharge.refused(candidate.numbers, 0, len(candidate.numbers) - 1)
    search.charge(surcharge)
    expanded = search.expanded_nodes
    following = search.next()
    assert following is not None
    assert search.expanded_nodes - expanded <= 4 * len(following.actions)
