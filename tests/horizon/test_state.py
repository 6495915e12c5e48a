"""Tasks begun anew from a state in mid-run."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tamplang.compiler.ir import Fact, Literal, Object, Problem
from tamplang.compiler.pipeline import compile_problem, compile_text
from tamplang.compiler.poses import joint_frames
from tamplang.compiler.symbolic.geometry import SceneLengths
from tamplang.compiler.symbolic.successors import Successors
from tamplang.runtime.budget import Budget
from tamplang.runtime.planner.lgp import SolveOptions
from tamplang.runtime.planner.receding.mid_run_state import Reached, after, reached_problem, start
from tamplang.runtime.planner.receding.subgoals import ordered, parts_of
from tamplang.runtime.planner.receding.window import plan_window, remember
from tamplang.runtime.simulation.breakdowns import frozen, without
from tamplang.runtime.skeleton import start_configuration

EXAMPLES = Path(__file__).parent.parent.parent / "examples"


def _problem(name: str, **parameters: str) -> Problem:
    return compile_problem(EXAMPLES / f"{name}.tamp", None, parameters, 0)[0]


@pytest.fixture(scope="module")
def grasped() -> tuple[Problem, Reached]:
    """A box is in the gripper."""
    problem = _problem("pick_and_place", objects="2")
    options, budget = SolveOptions(time=None), Budget(None)
    memory = remember(problem, options, budget)
    window = plan_window(problem, start(problem), options, 1, budget, memory)
    assert window.status == "planned" and len(window.paths) == 1
    again = after(problem, window.skeleton, window.paths)
    assert again.facts == window.reached.facts and again.mode == window.reached.mode
    return problem, window.reached


def test_the_start_is_a_state_too() -> None:
    problem = _problem("pick_and_place", objects="2")
    begun = reached_problem(problem, start(problem))
    assert begun.init == problem.init and begun.init_motion == problem.init_motion
    assert begun.world == problem.world
    assert ("c.A", "pedestal") in begun.touching


def test_what_is_held_stays_in_the_hand(grasped: tuple[Problem, Reached]) -> None:
    problem, reached = grasped
    begun = reached_problem(problem, reached)
    held = next(fact for fact in begun.init if fact[0] == "grasped")
    assert held in begun.init and ("stable", *held[1:]) in begun.init_motion
    assert not any(fact[0] == "on" and fact[2] == held[2] for fact in begun.init)
    configuration = start_configuration(begun)
    for name, values in reached.configuration.modules.items():
        assert np.array_equal(configuration.modules[name], values)


def test_lengths_are_measured_where_things_are_now(grasped: tuple[Problem, Reached]) -> None:
    problem, reached = grasped
    moved = reached.configuration.copy()
    moved.bodies["item[2]"][:3] = (5.0, 0.0, 0.5)
    begun = reached_problem(problem, replace(reached, configuration=moved))
    before, now = SceneLengths(problem), SceneLengths(begun)
    pair = now.index["pedestal"], now.index["item[2]"]
    assert before.distance(*pair) < 1.0 < 4.0 < now.distance(*pair)


def test_a_window_begins_in_mid_air(grasped: tuple[Problem, Reached]) -> None:
    """Half-way through a motion nothing has changed for the rules, and the next motion begins there."""
    problem, _ = grasped
    options, budget = SolveOptions(time=None), Budget(None)
    memory = remember(problem, options, budget)
    window = plan_window(problem, start(problem), options, 1, budget, memory)
    begin, path = start(problem), window.paths[0]
    half = start(problem).configuration.copy()
    middle = len(path.modules["c"]) // 2
    half.modules["c"] = path.modules["c"][middle].copy()
    again = plan_window(problem, replace(begin, configuration=half), options, 2, budget, memory)
    assert again.status == "planned"
    assert np.allclose(again.paths[0].modules["c"][0], half.modules["c"], atol=1e-9)


def test_stuck_joints_keep_the_shape_of_a_module() -> None:
    problem = _problem("climb", n="4", crawlers="2")
    stuck = frozen(problem, "c[1]")
    before, now = problem.world.modules["c[1]"], stuck.world.modules["c[1]"]
    assert not now.type.joints and now.joints == ()
    frames = joint_frames(before.type, before.pose, before.joints)
    rigid = joint_frames(now.type, now.pose, now.joints)
    assert set(rigid) == {-1} and frames[-1] == rigid[-1]
    assert SceneLengths(stuck).distance(0, 1) == SceneLengths(problem).distance(0, 1)
    for name in ("c[1].A", "c[1].B", "c[1]"):
        there = SceneLengths(problem), SceneLengths(stuck)
        ends = [g.distance(g.index[name], g.index["target"]) for g in there]
        assert ends[0] == pytest.approx(ends[1], abs=1e-9)
    assert stuck.world.modules["c[2]"] == problem.world.modules["c[2]"]


def test_a_module_that_is_gone_is_named_nowhere() -> None:
    problem = _problem("climb", n="4", crawlers="2")
    goal = Literal("grasped", (Object("c[1].A"), Object("target")))
    gone = without(replace(problem, goal=goal), "c[1]")
    assert "c[1]" not in gone.objects and "c[1].A" not in gone.objects

    def names(facts: frozenset[Fact]) -> set[str]:
        return {name.rpartition(".")[0] or name for fact in facts for name in fact[1:]}

    assert "c[1]" not in names(gone.init) | names(gone.init_motion)
    successors = Successors(gone)
    assert not successors.is_goal(successors.initial)
    assert successors.expand(successors.initial)
    options, budget = SolveOptions(time=None), Budget(None)
    window = plan_window(gone, start(gone), options, 2, budget, remember(gone, options, budget))
    assert window.status == "infeasible"


WORKSHOP = """
import std.crawler
import std.logic

predicate (cleaned X: object)
predicate (painted X: object)
predicate (polished X: object)

rule clean(A: gripper, X: object)  { pre (support A), (grippable X) post (cleaned X) }
rule polish(A: gripper, X: object) { pre (support A), (cleaned X)   post (polished X) }
rule paint(A: gripper, X: object)  { pre (support A), (grippable X) post not (cleaned X), (painted X) }

task workshop {
    base ground: box(1 m, 1 m, 0.05 m) at (0, 0, 0)
    object item: box(0.06 m, 0.06 m, 0.06 m) at (0.3 m, 0.2 m, 0.1 m)
    fact (grippable item)
    crawler c: A on ground
    goal  GOAL
}
"""


@pytest.mark.parametrize(("goal", "order"), [
    ("(polished item), (cleaned item)", ["cleaned", "polished"]),
    ("(cleaned item), (painted item)", ["painted", "cleaned"]),
    ("(painted item), (cleaned item)", ["painted", "cleaned"]),
])  # fmt: skip
def test_parts_of_the_goal_are_ordered_by_what_achieves_them(goal: str, order: list[str]) -> None:
    """First what another part needs; last what another part destroys."""
    problem, _ = compile_text(WORKSHOP.replace("GOAL", goal), "workshop.tamp")
    found = ordered(Successors(problem), parts_of(problem))
    assert [part.predicate for part in found if isinstance(part, Literal)] == order
