"""The plain interpreter against the generated successor functions, on random walks; and its error messages."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from tamplang.compiler.ir import Action, And, Exists, Literal, Not, ObjectType, Problem, Var, Variable
from tamplang.compiler.pipeline import compile_problem
from tamplang.compiler.symbolic.successors import Successors
from tamplang.runtime.verify.formulas import ReplayError, holds
from tamplang.runtime.verify.replay import Inapplicable, Interpreter

EXAMPLES = Path(__file__).parents[2] / "examples"


def example(name: str, **parameters: int) -> Problem:
    return compile_problem(EXAMPLES / name, None, {k: str(v) for k, v in parameters.items()}, 0)[0]


def successors(problem: Problem, interpreter: Interpreter, facts: frozenset[tuple[str, ...]]) -> dict[str, Action]:
    return {str(a): a for rule in problem.rules.values() for a in interpreter.applicable(facts, rule)}


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(
    ("name", "parameters"),
    [
        ("climb.tamp", {"n": 8, "crawlers": 1}),
        ("climb.tamp", {"n": 6, "crawlers": 2}),
        ("climb.tamp", {"n": 3, "crawlers": 3}),
        ("pick_and_place.tamp", {"objects": 3}),
    ],
)
def test_agrees_with_successor_functions(name: str, parameters: dict[str, int], seed: int) -> None:
    problem = example(name, **parameters)
    fast, plain = Successors(problem), Interpreter(problem)
    draw = random.Random(seed)
    state, facts, motion = fast.initial, problem.init, problem.init_motion
    for _ in range(10):
        assert fast.facts(state) == facts
        assert fast.is_goal(state) == plain.holds(facts, problem.goal)
        theirs = {str(fast.action(number)): after for after, number in fast.expand(state)}
        ours = successors(problem, plain, facts)
        assert set(theirs) == set(ours)
        outcomes = {name: plain.apply(facts, motion, action) for name, action in ours.items()}
        assert all(fast.facts(theirs[name]) == outcome.facts for name, outcome in outcomes.items())
        if not theirs:
            return
        # Prefer whatever docks or splits, which a fair draw seldom meets.
        name = draw.choice(sorted(n for n in theirs if "connect" in n) or sorted(theirs))
        state, facts, motion = theirs[name], outcomes[name].facts, outcomes[name].motion


def test_what_exists_is_asked_of_facts_whatever_names_mean_outside() -> None:
    problem = example("climb.tamp", n=2, crawlers=1)
    state = Interpreter(problem).state(problem.init)
    bearer, foot = next(f[1:] for f in sorted(problem.init) if f[0] == "on")
    other = next(o for o in problem.of_type("effector") if all(o not in f for f in problem.init if f[0] == "on"))
    x, a = Variable("X", ObjectType("object")), Variable("A", ObjectType("effector"))
    on = Literal("on", (Var("X"), Var("A")))
    assert holds(state, Exists((x,), on), {"A": foot}) and not holds(state, Exists((x,), on), {"A": other})
    assert holds(state, Exists((x, a), on), {"X": other, "A": other})
    both = And((Literal("held", (Var("X"),)), on))
    assert not holds(state, Exists((x, a), both), {})
    assert holds(state, Exists((a,), And((on, Not(Literal("held", (Var("X"),)))))), {"X": bearer})
    assert not holds(state, Exists((a,), Literal("on", (Var("A"), Var("A")))), {})


def test_chains_run_from_foot_to_free_end() -> None:
    problem = example("climb.tamp", n=4, crawlers=2)
    interpreter = Interpreter(problem)
    joined = interpreter.action(problem.init, "connect", ["[c[1].A c[1].B]", "[c[2].B c[2].A]"])
    outcome = interpreter.apply(problem.init, interpreter.canonical(problem.init_motion), joined)
    assert ("stable", "c[2].B", "c[1].B") in outcome.motion
    assert ("stable", "ground", "c[1].A") not in outcome.motion
    assert {("connected", "c[1].B", "c[2].B"), ("connected", "c[2].B", "c[1].B")} <= outcome.facts
    chain = "[c[2].A c[2].B c[1].B c[1].A]"
    step = interpreter.action(outcome.facts, "stepTogether", [chain, "ground", "stair[2]"])
    after = interpreter.apply(outcome.facts, outcome.motion, step)
    assert {f for f in after.motion if f[0] == "stable"} == {
        ("stable", "stair[2]", "c[1].A"), ("stable", "c[1].B", "c[2].B"),
    }  # fmt: skip


def test_impossible_actions_say_why() -> None:
    problem = example("climb.tamp", n=8, crawlers=1)
    interpreter = Interpreter(problem)
    for rule, arguments, message in [
        ("fly", [], "no rule `fly`"),
        ("step", ["c[1].A"], "takes 4 arguments"),
        ("step", ["c[1].A", "c[1].B", "ground", "moon"], "moon is no possible value of Y"),
        ("connect", ["[c[1].A c[1].B]", "[c[2].A c[2].B]"], "no possible value of q"),
    ]:
        with pytest.raises(ReplayError, match=message.replace("`", ".")):
            interpreter.action(problem.init, rule, arguments)
    far = interpreter.action(problem.init, "step", ["c[1].A", "c[1].B", "ground", "stair[8]"])
    with pytest.raises(Inapplicable) as caught:
        interpreter.apply(problem.init, problem.init_motion, far)
    assert caught.value.place is not None and caught.value.place.file == "std/rules.tamp"
