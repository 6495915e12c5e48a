"""Planner and verifier give the language one meaning: they agree on random tasks in every state that is seen."""

from __future__ import annotations

import random

import pytest

from tamplang.compiler.ir import Action, Fact, Problem
from tamplang.compiler.symbolic.successors import Successors
from tamplang.runtime.planner.search.skeleton_replay import build_skeleton
from tamplang.runtime.planner.search.stepper import Inapplicable, Stepper
from tamplang.runtime.verify.replay import Interpreter

from .random_tasks import compiled, task_text

MOST_STATES = 12
"""States of a task that are compared; more of them find less than more tasks."""


def actions(plain: Interpreter, problem: Problem, facts: frozenset[Fact]) -> dict[str, tuple[frozenset[Fact], float]]:
    """What can be done in a state, with the state after it and its cost, by the verifier."""
    found = {}
    for rule in problem.rules.values():
        for action in plain.applicable(facts, rule):
            found[str(action)] = plain.apply(facts, frozenset(), action).facts, plain.cost(facts, action)
    return found


@pytest.mark.parametrize("seed", range(120))
def test_planner_and_verifier_agree_on_random_tasks(seed: int) -> None:
    problem = compiled(seed)
    fast, plain, chance = Successors(problem), Interpreter(problem), random.Random(seed)
    waiting, seen = [fast.initial], {fast.initial}
    assert fast.facts(fast.initial) == problem.init
    for _ in range(MOST_STATES):
        if not waiting:
            break
        state = waiting.pop(chance.randrange(len(waiting)))
        facts = fast.facts(state)
        assert fast.is_goal(state) == plain.holds(facts, problem.goal), task_text(seed)
        theirs = {str(fast.action(a)): (fast.facts(t), fast.cost(a)) for t, a in fast.expand(state)}
        assert len(theirs) == len(fast.expand(state)), task_text(seed)
        assert theirs == actions(plain, problem, facts), task_text(seed)
        new = [t for t, _ in fast.expand(state) if t not in seen]
        waiting += new
        seen.update(new)


@pytest.mark.parametrize("seed", range(60))
def test_single_steps_leave_what_the_search_and_the_verifier_say(seed: int) -> None:
    problem = compiled(seed)
    fast, plain, stepper, chance = Successors(problem), Interpreter(problem), Stepper(problem), random.Random(seed)
    state, motion = fast.initial, plain.canonical(problem.init_motion)
    before: list[Action] = []
    for _ in range(6):
        facts = fast.facts(state)
        assert stepper.holds(facts, problem.goal) == fast.is_goal(state), task_text(seed)
        assert stepper.fluents(facts) == plain.fluents(facts)
        options = {fast.action(number): (following, fast.cost(number)) for following, number in fast.expand(state)}
        for action, (following, cost) in options.items():
            assert stepper.action(facts, action.rule, [str(a) for a in action.args]) == action
            step, outcome = stepper.step(facts, motion, action), plain.apply(facts, motion, action)
            assert step.facts == fast.facts(following) == outcome.facts, task_text(seed)
            assert (step.motion, step.added) == (outcome.motion, outcome.added_motion), task_text(seed)
            told = outcome.places.keys()
            assert {f: step.places[f] for f in told} == {f: outcome.places[f] for f in told}
            assert stepper.cost(facts, action) == cost
        for action in before:
            if action not in options:
                with pytest.raises(Inapplicable):
                    stepper.step(facts, motion, action)
        if not options:
            return
        before += options
        chosen = chance.choice([*options])
        state, motion = options[chosen][0], stepper.step(facts, motion, chosen).motion


@pytest.mark.parametrize("seed", range(60))
def test_skeletons_hold_the_motion_literals_of_the_verifier(seed: int) -> None:
    problem = compiled(seed)
    fast, plain, chance = Successors(problem), Interpreter(problem), random.Random(seed)
    state, walk = fast.initial, []
    for _ in range(8):
        options = fast.expand(state)
        if not options:
            break
        state, number = chance.choice(options)
        walk.append(fast.action(number))
    skeleton = build_skeleton(problem, walk)
    facts, mode = problem.init, plain.canonical(problem.init_motion)
    for phase in skeleton.phases:
        assert plain.canonical(phase.mode) == mode, task_text(seed)
        outcome = plain.apply(facts, mode, phase.action)
        assert plain.canonical(phase.added) == outcome.added_motion, task_text(seed)
        facts, mode = outcome.facts, outcome.motion
    assert plain.canonical(skeleton.final_mode) == mode, task_text(seed)
