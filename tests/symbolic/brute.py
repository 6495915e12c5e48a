"""Distances by brute force: Dijkstra over the states that the verifier's plain interpreter finds, none of the planner's
code in it."""

from __future__ import annotations

import heapq
import math
from dataclasses import dataclass

from tamplang.compiler.ir import Fact, Problem
from tamplang.runtime.verify.replay import Interpreter

Facts = frozenset[Fact]


@dataclass(frozen=True)
class Graph:
    """The states that were visited, cheapest first, with what follows each and at which cost. `complete` when these
    are all that can be reached."""

    start: Facts
    arcs: dict[Facts, list[tuple[Facts, float]]]
    goals: frozenset[Facts]
    complete: bool

    def left(self) -> dict[Facts, float]:
        """The cost from every state to its nearest goal, through states that were visited."""
        before: dict[Facts, list[tuple[Facts, float]]] = {}
        for state, arcs in self.arcs.items():
            for following, cost in arcs:
                before.setdefault(following, []).append((state, cost))
        found: dict[Facts, float] = {}
        queue = [(0.0, number, state) for number, state in enumerate(self.goals)]
        heapq.heapify(queue)
        while queue:
            cost, _, state = heapq.heappop(queue)
            if state in found:
                continue
            found[state] = cost
            for earlier, more in before.get(state, ()):
                if earlier not in found:
                    heapq.heappush(queue, (cost + more, len(found) * 1000 + len(queue), earlier))
        return found


def explored(problem: Problem, most: int) -> Graph:
    """At most so many states, in the order of their cost from the start."""
    plain = Interpreter(problem)
    arcs: dict[Facts, list[tuple[Facts, float]]] = {}
    queue: list[tuple[float, int, Facts]] = [(0.0, 0, problem.init)]
    goals: set[Facts] = set()
    pushed = 1
    while queue and len(arcs) < most:
        cost, _, state = heapq.heappop(queue)
        if state in arcs:
            continue
        if plain.holds(state, problem.goal):
            goals.add(state)
        arcs[state] = []
        for rule in problem.rules.values():
            for action in plain.applicable(state, rule):
                following = plain.apply(state, frozenset(), action).facts
                step = plain.cost(state, action)
                arcs[state].append((following, step))
                if following not in arcs:
                    heapq.heappush(queue, (cost + step, pushed, following))
                    pushed += 1
    complete = all(following in arcs for found in arcs.values() for following, _ in found)
    return Graph(problem.init, arcs, frozenset(goals), complete)


def cheapest(graph: Graph) -> float:
    """The cost of the cheapest plan; infinite where none was found."""
    return graph.left().get(graph.start, math.inf)
