"""Things that change hands, are put down and taken up again, and chains that part at any junction, grasp and place."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from tamplang.compiler.ir import Chain, Problem
from tamplang.compiler.pipeline import compile_problem
from tamplang.compiler.symbolic.successors import Successors
from tamplang.runtime.planner.lgp import SolveOptions, solve

from .interpreter import Interpreter
from .test_search import check_estimate, replayed, started

TASKS = Path(__file__).parent / "tasks"


def compiled(name: str, **parameters: str) -> Problem:
    problem, _ = compile_problem(TASKS / f"{name}.tamp", None, parameters)
    return problem


def rules_of(problem: Problem) -> list[str]:
    search = started(problem)
    candidate = search.next()
    assert candidate is not None and candidate.optimal
    replayed(search, candidate)
    return [action.rule for action in candidate.actions]


def solved(problem: Problem) -> list[str]:
    outcome = solve(problem, SolveOptions(time=60.0))
    assert outcome.status == "solved", [e.message for e in outcome.explanation]
    assert outcome.plans[0].verdict is not None and outcome.plans[0].verdict.verified
    return outcome.actions


def test_one_robot_hands_a_thing_to_another_that_puts_it_down_out_of_its_reach() -> None:
    expected = ["grasp(a.B, thing)", "grasp(b.B, thing)", "place(b.B, thing, goal_tray)"]
    assert solved(compiled("hand_over")) == expected


def test_a_thing_is_taken_up_from_where_it_was_put() -> None:
    expected = [
        "grasp(c.B, thing)", "place(c.B, thing, middle)", "step(c.A, c.B, left, right)", "grasp(c.A, thing)",
        "place(c.A, thing, goal_tray)",
    ]  # fmt: skip
    assert solved(compiled("relay")) == expected


def test_nobody_takes_what_is_out_of_reach() -> None:
    search = started(compiled("hand_over", apart="2.7 m"))
    assert search.next() is None and search.status == "infeasible"


def test_what_was_put_down_is_not_where_it_lay_at_the_start() -> None:
    search = started(compiled("relay"))
    successors = search.successors
    state = successors.initial
    for rule in ("grasp", "place", "step"):
        state = next(t for t, a in successors.expand(state) if successors.action(a).rule == rule)
    back = next(t for t, a in successors.expand(state) if successors.action(a).rule == "step"
                and successors.action(a).args[3] == "left")  # fmt: skip
    taken = [str(successors.action(a)) for _, a in successors.expand(back) if successors.action(a).rule == "grasp"]
    assert ("on", "middle", "thing") in successors.facts(back) and len(taken) == 1
    without_middle = compiled("relay", far="1.4 m")
    assert started(without_middle).next() is None


@pytest.mark.parametrize("name", ["hand_over", "relay", "carry"])
def test_estimate_and_successors_agree_with_plain_ones(name: str) -> None:
    problem = compiled(name)
    check_estimate(problem, 400)
    successors, interpreter = Successors(problem), Interpreter(problem)
    chance = random.Random(2)
    state, facts = successors.initial, problem.init
    for _ in range(12):
        found = {str(successors.action(a)): successors.facts(t) for t, a in successors.expand(state)}
        assert len(found) == len(successors.expand(state))
        assert found == {str(action): after for action, after in interpreter.successors(facts).items()}
        state = chance.choice(successors.expand(state))[0]
        facts = successors.facts(state)


@pytest.mark.parametrize("modules", [3, 4])
def test_a_chain_parts_at_any_junction_onto_any_base_in_reach(modules: int) -> None:
    successors = Successors(compiled("carry", modules=str(modules)))
    state = successors.initial
    for _ in range(modules - 1):
        state = next(t for t, a in successors.expand(state) if successors.action(a).rule == "connect")
    parted = [a for t, n in successors.expand(state) if (a := successors.action(n)).rule == "disconnect"]
    bases = {f"plate[{i}]" for i in range(1, modules + 1)} | {"far"}
    assert {(a.args[1], a.args[2]) for a in parted} == {(k, b) for k in range(1, modules) for b in bases}
    assert all(isinstance(a.args[0], Chain) and len(a.args[0].modules) == modules for a in parted)


def test_the_front_of_a_chain_parts_and_stands_where_only_the_whole_chain_reaches() -> None:
    actions = solved(compiled("split"))
    assert actions[-1] == "disconnect([c[2].A c[2].B c[1].B c[1].A c[3].B c[3].A], 2, far)"
    assert started(compiled("split", gap="3.6 m")).next() is None


@pytest.mark.parametrize("modules", [2, 3])
def test_the_free_end_of_a_chain_grasps_and_places(modules: int) -> None:
    problem = compiled("carry", modules=str(modules))
    assert rules_of(problem) == ["connect"] * (modules - 1) + ["grasp", "place"]
    assert solved(problem)[-1].startswith("place(")


@pytest.mark.parametrize("modules, rules", [("3", ["gather", "grasp"]), ("5", ["gather", "gather", "grasp"])])
def test_links_that_are_made_at_a_stroke_cost_one_action(modules: str, rules: list[str]) -> None:
    problem = compiled("gather", modules=modules)
    assert rules_of(problem) == rules
    search = started(problem)
    assert search.value(search.successors.initial) <= len(rules)
