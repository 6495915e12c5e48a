"""Of plans of one cost, the one with the most room."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import pytest

from tamplang.compiler.pipeline import compile_text
from tamplang.compiler.symbolic.strain import Strain
from tamplang.compiler.symbolic.successors import Successors
from tamplang.runtime.budget import Budget
from tamplang.runtime.planner.search.best_first import Candidate, SkeletonSearch
from tamplang.runtime.planner.search.settings import SEARCH
from tamplang.runtime.planner.search.slack_maximisation import maximise_slack

WAYS = """
import std.crawler
predicate (at W: base, X: object) functional in W
predicate (painted)
predicate (spot X: object)
rule go(W: base, X Y: object) {
    pre  (at W X), distance(X, Y) <= 1 m, not (at W Y)
    post not (at W X), (at W Y)
    cost COST
}
rule run(W: base, X Y: object) { pre (at W X), distance(X, Y) <= 2 m, not (at W Y)   post not (at W X), (at W Y) }
rule paint(W: base, X: object) { pre (at W X), not (painted)   post (painted), (spot X) }
task ways() {
    base pad: box(0.1 m, 0.1 m, 0.1 m) at (9 m, 9 m, 0)
    crawler c: A on pad
PLACES
    fact (at pad s)
    goal GOAL
}
"""
PLACES = {"s": (0, 0), "t": (2, 0), "a": (1.04, 0.2), "b": (0.96, 0.1), "m": (1.02, 0.0), "z": (0.98, -0.25),
          "u": (1.9, 0.3)}  # fmt: skip
FAR = "if distance(X, Y) >= 0.9 m then 1 else 3"
"""Less strained moves cost more."""


def search(goal: str, cost: str = "1") -> SkeletonSearch:
    spheres = "\n".join(f"    object {n}: sphere(5 cm) at ({x} m, {y} m, 0)" for n, (x, y) in PLACES.items())
    problem = compile_text(
        WAYS.replace("PLACES", spheres).replace("GOAL", goal).replace("COST", cost), "ways.tamp"
    )[0]
    return SkeletonSearch(problem, Successors(problem), "astar", Budget(None))


def strained(found: SkeletonSearch, numbers: Sequence[int]) -> float:
    return sum(s**SEARCH.penalty_power for s in Strain(found.successors).along(numbers))


def flags(found: SkeletonSearch, numbers: Sequence[int]) -> list[int]:
    """What holds after each action, but for values of functional predicates."""
    state, seen = found.successors.initial, []
    for number in numbers:
        state = found.successors.after(state, number)
        seen.append(state & found.successors.layout.flag_mask)
    return seen


def ways(found: SkeletonSearch, rules: Sequence[str]) -> Iterator[tuple[int, ...]]:
    """Every plan of these rules, by trying all."""
    waiting: list[tuple[int, tuple[int, ...]]] = [(found.successors.initial, ())]
    for rule in rules:
        waiting = [
            (following, (*numbers, number))
            for state, numbers in waiting
            for following, number in found.successors.expand(state)
            if found.successors.action(number).rule == rule
        ]
    return (numbers for state, numbers in waiting if found.successors.is_goal(state))


def cost(found: SkeletonSearch, numbers: Sequence[int]) -> float:
    return sum(found.successors.cost(n) for n in numbers)


@pytest.mark.parametrize(
    ("goal", "price", "rules"),
    [
        ("(at pad t)", "1", ("go", "go")),
        ("(at pad t), (painted)", "1", ("go", "paint", "go")),
        ("((at pad t) or (at pad u))", "1", ("go", "go")),
        ("(at pad t)", FAR, ("go", "go")),
        ("(at pad t), (painted)", "1", ("run", "paint")),
    ],
)
def test_the_plan_with_the_least_strain_of_all_that_are_alike_is_found(
    goal: str, price: str, rules: tuple[str, ...]
) -> None:
    """Alike: as dear, with the same rules, and with the same facts but for values of functional predicates."""
    found = search(goal, price)
    known = sorted(ways(found, rules), key=lambda w: (cost(found, w), -strained(found, w)))
    worst = known[0]
    alike = [w for w in known if cost(found, w) == cost(found, worst) and flags(found, w) == flags(found, worst)]
    best = maximise_slack(found, Strain(found.successors), by_hand(found, worst))
    assert best.numbers in alike and best.cost == cost(found, best.numbers)
    assert strained(found, best.numbers) == pytest.approx(min(strained(found, w) for w in alike))


def by_hand(found: SkeletonSearch, numbers: tuple[int, ...]) -> Candidate:
    actions = tuple(found.successors.action(n) for n in numbers)
    return Candidate(numbers, actions, cost(found, numbers), True, 0.0)


def test_what_is_forbidden_is_not_taken_for_its_room() -> None:
    found = search("(at pad t)")
    known = sorted(ways(found, ("go", "go")), key=lambda w: strained(found, w))
    found.forbid_plan(by_hand(found, known[0]))
    again = maximise_slack(found, Strain(found.successors), by_hand(found, known[-1]))
    assert again.numbers == known[1]


TWO = """
import std.crawler
predicate (used c: module)
rule use(c: module, X Y: object) {
    pre  (of c X), distance(X, Y) <= 1 m, X != Y, not (used c)
    post (used c)
}
predicate (of c: module, X: object) static
task two() {
    base one: box(0.1 m, 0.1 m, 0.1 m) at (9 m, 9 m, 0)
    base other: box(0.1 m, 0.1 m, 0.1 m) at (9 m, 12 m, 0)
    object x: sphere(5 cm) at (0, 0, 0)
    object y: sphere(5 cm) at (1.05 m, 0, 0)
    object z: sphere(5 cm) at (0.5 m, 5 m, 0)
    object w: sphere(5 cm) at (0, 5 m, 0)
    crawler c: A on one
    crawler d: A on other
    fact (of c x)
    fact (of d z)
    goal (used c) or (used d)
}
"""


def test_what_another_robot_would_do_with_more_room_is_another_plan() -> None:
    problem = compile_text(TWO, "two.tamp")[0]
    found = SkeletonSearch(problem, Successors(problem), "astar", Budget(None))
    known = {str(found.successors.action(w[0])): w for w in ways(found, ("use",))}
    bold, tame = known["use(c, x, y)"], known["use(d, z, w)"]
    assert strained(found, tame) < strained(found, bold) and flags(found, tame) != flags(found, bold)
    best = maximise_slack(found, Strain(found.successors), by_hand(found, bold))
    assert found.successors.action(best.numbers[0]).args[0] == "c"
