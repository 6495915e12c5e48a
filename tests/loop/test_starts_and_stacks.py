"""Robots whose joints start at a limit, things that lie on things that are taken, and scenery built into itself."""

from __future__ import annotations

import pytest

import tamplang
from tamplang.compiler.pipeline import compile_text
from tamplang.runtime.planner.lgp import Outcome, SolveOptions, solve

HEAD = """
import std.rules

module gantry(home: length = 0.5 m) {
    effector A: gripper sphere(5 cm) normal (0, 0, -1)
    link (0, 0, 1 m)
    joint dx: prismatic(x) in 0 m .. 2 m home home
    joint dy: prismatic(y) in -1 m .. 1 m
    joint dz: prismatic(z) in -0.95 m .. 0 m
    effector B: gripper sphere(1 cm) normal (0, 0, -1)
    fact (linked A B)
}
scene hall() {
    base foot: box(0.2 m, 0.2 m, 0.05 m) at (0, 0, -0.025 m)
    object table: box(0.5 m, 0.5 m, 0.1 m) at (1.5 m, 0, 0.03 m)
    object tray1: box(0.4 m, 0.4 m, 0.1 m) at (0.6 m, 0.5 m, 0.03 m)
    fact (tray tray1)
}
"""
STACK = """
    scene hall()
    object lower: box(10 cm, 10 cm, 4 cm) on table
    object upper: box(3 cm, 3 cm, 8 cm) on lower at (2 cm, 0)
    fact (grippable lower)
    gantry g: A on foot
    goal (on tray1 lower)
"""


def solved(body: str, seed: int) -> Outcome:
    problem, _ = compile_text(f"{HEAD}\ntask t() {{\n{body}\n}}")
    outcome = solve(problem, SolveOptions(seed=seed, time=60.0))
    assert outcome.status == "solved"
    verdict = outcome.plans[0].verdict
    assert verdict is not None and verdict.verified
    return outcome


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("home", ["0 m", "2 m", "0.003 m"])
def test_a_joint_may_start_at_its_limit_and_stay_there(home: str, seed: int) -> None:
    solved(f"""
    scene hall()
    object item: box(4 cm, 4 cm, 4 cm) at ({home}, 0.6 m, 0.5 m)
    fact (grippable item)
    gantry(home = {home}) g: A on foot
    goal (held item)
    """, seed)  # fmt: skip


@pytest.mark.parametrize("seed", range(2))
def test_what_lies_on_a_thing_is_carried_along(seed: int) -> None:
    tracks = {track.name for track in solved(STACK, seed).plans[0].body_tracks}
    assert {"lower", "upper"} <= tracks


@pytest.mark.parametrize("place", ["on upper", "at (1.52 m, 0, 0.21 m)"])
def test_so_is_what_lies_on_that(place: str) -> None:
    third = f"object top: box(2 cm, 2 cm, 2 cm) {place}"
    tracks = {track.name for track in solved(f"{STACK}{third}", 0).plans[0].body_tracks}
    assert {"lower", "upper", "top"} <= tracks


def test_what_lies_on_two_things_keeps_each_of_them_where_it_is() -> None:
    body = """
    scene hall()
    object one: box(4 cm, 4 cm, 4 cm) on table at (0, 0.15 m)
    object other: box(4 cm, 4 cm, 4 cm) on table at (0, -0.15 m)
    object plank: box(4 cm, 40 cm, 2 cm) at (1.5 m, 0, 0.13 m)
    fact [stable one plank]
    fact [stable other plank]
    fact (grippable one)
    gantry g: A on foot
    goal (on tray1 one)
    """
    problem, _ = compile_text(f"{HEAD}\ntask t() {{\n{body}\n}}")
    unsaid, (warning,) = compile_text(f"{HEAD}\ntask t() {{\n{body.replace('fact [', '# ')}\n}}")
    assert unsaid.init_motion == problem.init_motion and warning.code == "W0023"
    outcome = solve(problem, SolveOptions(time=60.0))
    assert outcome.status == "exhausted"
    assert any("[stable other plank]" in d.message or "[stable one plank]" in d.message for d in outcome.explanation)


@pytest.mark.parametrize(("at", "found"), [
    ("at (1.52 m, 0, 0.16 m)", ["W0023"]),
    ("at (1.52 m, 0, 0.17 m)", []),
    ("at (1.54 m, 0, 0.16 m)\n object block: box(20 cm, 20 cm, 4 cm) at (1.651 m, 0, 0.1 m)", ["W0023"]),
    ("at (1.56 m, 0, 0.16 m)\n object block: box(20 cm, 20 cm, 4 cm) at (1.651 m, 0, 0.1 m)", []),
    ("at (1.52 m, 0, 0.16 m)\n fact [stable table upper]", []),
])  # fmt: skip
def test_it_is_told_what_lies_on_a_thing_by_where_it_is_alone(at: str, found: list[str]) -> None:
    body = STACK.replace("on lower at (2 cm, 0)", at)
    problem, warnings = compile_text(f"{HEAD}\ntask t() {{\n{body}\n}}")
    assert [w.code for w in warnings] == found and problem.world.bodies["upper"].movable == bool(found)


def test_what_a_rule_takes_that_lets_go_of_nothing_is_not_kept_where_it_lies() -> None:
    text = f"{HEAD}\ntask t() {{\n{STACK.replace('on lower at (2 cm, 0)', 'at (1.52 m, 0, 0.16 m)')}\n}}"
    rules = "import std.motion\nrule take(A: gripper, X: object) { pre (free A) post (grasped A X), [stable A X] }"
    body = text.replace("import std.rules", rules).replace("goal (on tray1 lower)", "goal (held upper)")
    problem, warnings = compile_text(body)
    assert "W0023" not in {w.code for w in warnings} and ("stable", "lower", "upper") not in problem.init_motion


def test_scenery_that_never_moves_may_be_built_into_itself() -> None:
    body = """
    scene hall()
    object wall: box(5 cm, 2 m, 1 m) at (1.9 m, 0, 0.4 m)
    object sill: box(20 cm, 1 m, 10 cm) at (1.85 m, 0, 0.5 m)
    object item: box(4 cm, 4 cm, 4 cm) at (1 m, 0.3 m, 0.5 m)
    fact (grippable item)
    gantry g: A on foot
    goal (held item)
    """
    _, found = compile_text(f"{HEAD}\ntask t() {{\n{body}\n}}")
    assert [d.code for d in found] == ["W0012"]
    solved(body, 0)


def test_a_base_that_is_sunk_as_far_as_check_lets_it_pass_refuses_no_switch() -> None:
    problem, _ = compile_text("""
import std.rules
module arm {
    effector A: gripper box(10 cm, 10 cm, 1 cm) at (0, 0, 5 mm) normal (0, 0, -1)
    branch {
        link (0, 12 cm, -0.6 mm)
        link 5 cm: box(6 cm, 6 cm)
    }
    link 30 cm: cylinder(3 cm)
    joint q1: revolute(z) in -170 deg .. 170 deg
    joint q2: revolute(y) in -100 deg .. 100 deg
    link 25 cm: capsule(2 cm)
    joint q3: revolute(y) in -150 deg .. 150 deg home 60 deg
    link 25 cm: capsule(2 cm)
    effector B: gripper sphere(2 cm)
    fact (linked A B)
}
task t {
    base pad: box(50 cm, 50 cm, 4 cm) at (0, 0, -2 cm)
    object ball: sphere(3 cm) at (40 cm, 10 cm, 30 cm)
    fact (grippable ball)
    arm a: A on pad
    goal (held ball)
}
""")
    outcome = solve(problem, SolveOptions(time=60.0))
    assert outcome.status == "solved"
    verdict = outcome.plans[0].verdict
    assert verdict is not None and verdict.verified


def test_a_foot_that_starts_in_what_check_lets_pass_gets_away() -> None:
    """The free foot of a planar inchworm is 0.9 mm deep in the next step."""
    text = """import std.motion
import std.rules
module worm {
    effector A: gripper sphere(3 cm) normal (0, 0, -1)
    link 5 cm: capsule(2 cm)
    joint a: revolute(y) in -110 deg .. 110 deg home 30 deg
    link 22 cm: capsule(2 cm)
    joint b: revolute(y) in -130 deg .. 130 deg home 100 deg
    link 22 cm: capsule(2 cm)
    joint c: revolute(y) in -110 deg .. 110 deg home 50 deg
    link 5 cm: capsule(2 cm)
    effector B: gripper sphere(3 cm)
    fact (linked A B)
}
task hill() {
    base s[0]: box(16 cm, 16 cm, 4 cm) at (0, 0, 0)
    base s[1]: box(16 cm, 16 cm, 4 cm) at (22 cm, 0, 5 cm)
    worm w: A on s[0]
    goal (on s[1] w.B)
}"""
    result = tamplang.loads(text).solve(time=60.0)
    assert result.plan is not None and result.status == "solved", result.explanation
