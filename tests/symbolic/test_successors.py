"""The generated successor functions mean what the IR says: they agree with a plain interpreter on random walks."""

from __future__ import annotations

import random
from collections.abc import Callable

import pytest

from tamplang.compiler.ir import Problem
from tamplang.compiler.symbolic.settings import SYMBOLIC
from tamplang.compiler.symbolic.successors import Successors

from . import variants
from .interpreter import Interpreter
from .problems import climb, pick_and_place

PROBLEMS: dict[str, Callable[[], Problem]] = {
    "one crawler": lambda: climb(3, 1, rise=0.6),
    "two crawlers": lambda: climb(2, 2, rise=0.6),
    "three crawlers": lambda: climb(1, 3, rise=0.6),
    "items": lambda: pick_and_place(3, 2),
    **variants.PROBLEMS,
}


@pytest.mark.parametrize("name", PROBLEMS)
def test_agrees_with_the_interpreter_on_random_walks(name: str) -> None:
    problem = PROBLEMS[name]()
    successors, interpreter = Successors(problem), Interpreter(problem)
    chance = random.Random(1)
    budget = 12 if name == "three crawlers" else 60
    state, facts = successors.initial, problem.init
    for _ in range(budget):
        assert successors.facts(state) == facts
        assert successors.is_goal(state) == interpreter.holds(problem.goal, {}, facts)
        expected = interpreter.successors(facts)
        found = {successors.action(a): (t, successors.facts(t)) for t, a in successors.expand(state)}
        assert {action: after for action, (_, after) in found.items()} == expected
        assert len(found) == len(successors.expand(state))
        if not found:
            state, facts = successors.initial, problem.init
            continue
        state, facts = found[chance.choice(sorted(found, key=str))]


@pytest.mark.parametrize("name", ["two crawlers", "three crawlers", "items"])
def test_flags_that_are_met_often_give_the_same_successors_as_before_they_were_compiled(name: str) -> None:
    problem = PROBLEMS[name]()
    successors, chance = Successors(problem), random.Random(2)
    state = successors.initial
    for _ in range(12):
        first = successors.expand(state)
        for _ in range(SYMBOLIC.compiled_from + 1):
            assert successors.expand(state) == first
        state = chance.choice(first)[0] if first else successors.initial
