"""Of plans of one cost, the one with the most room."""

from __future__ import annotations

from itertools import product

import pytest

from tamplang.compiler.pipeline import compile_text
from tamplang.compiler.symbolic.strain import Strain
from tamplang.compiler.symbolic.successors import Successors
from tamplang.runtime.budget import Budget
from tamplang.runtime.search.best_first import SkeletonSearch
from tamplang.runtime.search.roomy import roomier
from tamplang.runtime.search.surcharge import POWER

WAYS = """
import std.crawler
predicate (at W: base, X: object) functional in W
predicate (painted)
rule go(W: base, X Y: object) { pre (at W X), distance(X, Y) <= 1 m, not (at W Y)   post not (at W X), (at W Y) }
rule paint(W: base, X: object) { pre (at W X), not (painted)   post (painted) }
task ways() {
    base pad: box(0.1 m, 0.1 m, 0.1 m) at (9 m, 9 m, 0)
    crawler c: A on pad
PLACES
    fact (at pad s)
    goal (at pad t)MORE
}
"""
PLACES = {"s": (0, 0), "t": (2, 0), "a": (1.04, 0.2), "b": (0.96, 0.1), "m": (1.02, 0.0), "z": (0.98, -0.25)}


def search(more: str = "") -> SkeletonSearch:
    spheres = "\n".join(f"    object {n}: sphere(5 cm) at ({x} m, {y} m, 0)" for n, (x, y) in PLACES.items())
    problem = compile_text(WAYS.replace("PLACES", spheres).replace("MORE", more), "ways.tamp")[0]
    return SkeletonSearch(problem, Successors(problem), "astar", Budget(None))


def strained(found: SkeletonSearch, numbers: tuple[int, ...]) -> float:
    return sum(s**POWER for s in Strain(found.successors).along(numbers))


@pytest.mark.parametrize("more", ["", ", (painted)"])
def test_the_plan_with_the_least_strain_of_all_of_its_cost_and_kinds_is_found(more: str) -> None:
    found = search(more)
    candidate = found.next()
    assert candidate is not None
    best = roomier(found, Strain(found.successors), candidate)
    rules = [a.rule for a in candidate.actions]
    assert [a.rule for a in best.actions] == rules and best.cost == candidate.cost
    ways = []
    for numbers in product(range(found.successors.action_count), repeat=len(rules)):
        if [found.successors.action(n).rule for n in numbers] != rules:
            continue
        state = found.successors.initial
        for number in numbers:
            state = next((t for t, n in found.successors.expand(state) if n == number), -1)
            if state < 0:
                break
        if state >= 0 and found.successors.is_goal(state):
            ways.append(strained(found, numbers))
    assert len(ways) > 1 and max(ways) > 1.05 * min(ways)
    assert strained(found, best.numbers) == pytest.approx(min(ways))


def test_what_is_forbidden_is_not_taken_for_its_room() -> None:
    found = search()
    candidate = found.next()
    assert candidate is not None
    best = roomier(found, Strain(found.successors), candidate)
    found.forbid_plan(best)
    following = found.next()
    assert following is not None
    again = roomier(found, Strain(found.successors), following)
    assert again.numbers != best.numbers and strained(found, again.numbers) >= strained(found, best.numbers)
