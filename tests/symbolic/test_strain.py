"""How close actions are to the limits of their rules, against what a plain reading of the rules says."""

from __future__ import annotations

import random

import pytest

from tamplang.compiler.ir import Fact, Problem
from tamplang.compiler.symbolic.locations import LOWER, length_bounds
from tamplang.compiler.symbolic.strain import Strain
from tamplang.compiler.symbolic.successors import Successors

from .interpreter import Interpreter
from .problems import climb
from .test_hand_over import compiled


def plain_strain(successors: Successors, interpreter: Interpreter, number: int, facts: frozenset[Fact]) -> float:
    """The least strain by a witness, over all values of all variables."""
    action, found = successors.action(number), []
    for flat in successors.domains.rules:
        if flat.rule.name != action.rule:
            continue
        env = {v.name: a for v, a in zip(flat.rule.variables, action.args, strict=True)}
        for witness in interpreter.bindings(tuple(flat.hidden), env, facts):
            if all(interpreter.holds(conjunct, witness, facts) for conjunct in flat.conjuncts):
                ratios = [0.0]
                for compare in length_bounds(flat):
                    left, right = (interpreter.value(t, witness) for t in (compare.left, compare.right))
                    ratios.append(right / left if compare.operator in LOWER else left / right)
                found.append(max(ratios))
    return min(found)


@pytest.mark.parametrize(
    "problem", [compiled("relay"), compiled("hand_over"), compiled("two_lengths"), climb(2, 2, rise=0.2)]
)
def test_the_strain_is_that_of_the_witness_with_most_room(problem: Problem) -> None:
    successors, interpreter, chance = Successors(problem), Interpreter(problem), random.Random(3)
    strain, state, different = Strain(successors), successors.initial, set()
    for _ in range(7):
        for _, number in successors.expand(state):
            told = strain.of(state, number)
            assert told == pytest.approx(plain_strain(successors, interpreter, number, successors.facts(state)))
            different.add(round(told, 6))
        state = chance.choice(successors.expand(state))[0]
    assert len(different) > 2


def test_what_another_hand_holds_is_as_far_as_that_hand_and_not_where_it_lay() -> None:
    successors = Successors(compiled("hand_over"))
    strain, state = Strain(successors), successors.initial
    first = next(n for _, n in successors.expand(state) if successors.action(n).rule == "grasp")
    near = strain.of(state, first)
    state = successors.after(state, first)
    second = next(n for _, n in successors.expand(state) if successors.action(n).rule == "grasp")
    assert strain.of(state, second) > near + 0.1
