"""What the search claims of costs, held against brute force on small random tasks: `optimal`, the bound behind `gap`,
and the estimate as a lower bound in every state.

Each task is compared with its own goal, and with one that is taken from a state that can be reached, as random goals
mostly hold at the start or never.
"""

from __future__ import annotations

import math
import random
from dataclasses import replace

import pytest

from tamplang.compiler.ir import And, Formula, Literal, Not, Object, Problem
from tamplang.compiler.symbolic.successors import Successors
from tamplang.runtime.budget import Budget
from tamplang.runtime.planner.search.best_first import SkeletonSearch

from .brute import Facts, Graph, explored
from .random_tasks import compiled, task_text

TASKS, BLOCK = 300, 20
MOST_STATES = 40


def drawn_goal(graph: Graph, chance: random.Random) -> Formula | None:
    """One or two facts that come to hold, or end, on the way to a state that takes the search some effort."""
    target = chance.choice([*graph.arcs][len(graph.arcs) // 2 :])
    come = [Literal(f[0], tuple(map(Object, f[1:]))) for f in sorted(target - graph.start)]
    gone = [Not(Literal(f[0], tuple(map(Object, f[1:])))) for f in sorted(graph.start - target)]
    parts = [*come, *gone]
    return And(tuple(chance.sample(parts, min(len(parts), 2)))) if parts else None


def holds(goal: Formula, state: Facts) -> bool:
    assert isinstance(goal, And)
    return all((fact_of(p) in state) != isinstance(p, Not) for p in goal.operands)


def fact_of(part: Formula) -> tuple[str, ...]:
    literal = part.operand if isinstance(part, Not) else part
    assert isinstance(literal, Literal)
    return literal.predicate, *(a.name for a in literal.args if isinstance(a, Object))


def compare(problem: Problem, graph: Graph, told: str) -> float | None:
    """Hold every claim against the distances in the graph; the cost of the cheapest plan where it is known."""
    left = graph.left()
    true = left.get(graph.start, math.inf)
    successors = Successors(problem)
    search = SkeletonSearch(problem, successors, "astar", Budget(None), 4000)
    waiting, seen = [successors.initial], {successors.initial}
    while waiting:
        state = waiting.pop()
        facts = successors.facts(state)
        if facts in left or graph.complete:
            assert search.value(state) <= left.get(facts, math.inf) + 1e-9, (told, sorted(facts))
        for following, _ in successors.expand(state) if facts in graph.arcs else ():
            if following not in seen:
                seen.add(following)
                waiting.append(following)
    candidate = search.next()
    if candidate is None:
        assert true == math.inf and (not graph.complete or search.status == "infeasible"), told
        return None
    assert candidate.optimal and candidate.lower_bound == candidate.cost, told
    assert candidate.cost <= true + 1e-9, told
    if not graph.complete:
        return None
    assert candidate.cost == pytest.approx(true), told
    for method in ("wastar", "bfs", "guide"):
        other = SkeletonSearch(problem, successors, method, Budget(None)).next()
        assert other is not None and other.lower_bound <= true + 1e-9 <= other.cost + 2e-9, (method, told)
        assert not other.optimal or other.cost == pytest.approx(true), (method, told)
    following = (search.forbid_plan(candidate), search.next())[1]
    if following is not None:
        assert following.numbers != candidate.numbers and following.cost >= true - 1e-9, told
        assert not following.optimal or following.cost == pytest.approx(true), told
    return true


@pytest.mark.parametrize("block", range(TASKS // BLOCK))
def test_optimal_gap_and_estimate_against_brute_force(block: int) -> None:
    costs: list[float] = []
    for seed in range(block * BLOCK, (block + 1) * BLOCK):
        problem, chance = compiled(seed), random.Random(seed)
        graph = explored(problem, MOST_STATES)
        goals: list[tuple[Formula, Graph]] = [(problem.goal, graph)]
        other = drawn_goal(graph, chance)
        if other is not None:
            goals.append((other, replace(graph, goals=frozenset(s for s in graph.arcs if holds(other, s)))))
        for goal, found in goals:
            true = compare(replace(problem, goal=goal), found, f"seed {seed}, goal {goal}\n{task_text(seed)}")
            costs += [] if true is None else [true]
    assert sum(cost > 0.0 for cost in costs) >= BLOCK // 4 and max(costs) >= 2.0
