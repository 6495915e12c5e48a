"""Things that are too heavy for what alone holds them, whatever came before."""

import pytest

from tamplang.compiler.ir import Action
from tamplang.compiler.pipeline import compile_text
from tamplang.runtime.planner.lgp import SolveOptions, solve
from tamplang.runtime.planner.statics.lone_holds import lone_holders
from tamplang.runtime.skeleton import Phase

TEXT = """
import std.rules

module arm {{
    effector A: gripper sphere(0.05 m) normal (0, 0, -1) mass 350 g holds grip(force 50 N, friction 0.5)
    joint j1: revolute(z) in -3 rad .. 3 rad torque 500 N m mass 0.5 kg
    joint j2: revolute(y) in -2 rad .. 2 rad home 0.2 rad torque 500 N m mass 0.5 kg
    link 0.5 m: capsule(0.04 m) mass 1 kg
    joint j3: revolute(y) in -2.5 rad .. 2.5 rad home 0.2 rad torque 500 N m mass 0.5 kg
    link 0.4 m: capsule(0.04 m) mass 1 kg
    effector B: gripper sphere(0.05 m) mass 350 g holds grip(force 50 N, friction 0.5)
    fact (linked A B)
}}

rule share(A: gripper, X Y: object) {{
    pre   (free A), (grippable X), (on Y X)
    post  not [stable Y X], (grasped A X), [stable A X], [touch A X]
}}
{more}

task t() {{
    base ground: box(2 m, 2 m, 5 cm) at (0, 0, 0)
    object shelf: box(40 cm, 40 cm, 5 cm) at (0.5 m, 0, 0.3 m)
    object item: box(6 cm, 6 cm, 6 cm) on shelf mass 30 kg
    fact (grippable item)
    arm c: A on ground at (0, 0)
    goal (held item)
    options {{ physics = statics }}
}}
"""
GLUE = "rule glue(X: object, B: effector) { pre (free B), (grippable X) post (on X B), [stable X B] }"


def holders(rule: str, more: str = "") -> tuple[str, ...]:
    text = TEXT.format(more=more)
    problem, _ = compile_text(text, "t.tamp")
    args = {"grasp": ("c.B", "item"), "share": ("c.B", "item", "shelf")}[rule]
    added = frozenset({("stable", "c.B", "item"), ("touch", "c.B", "item")})
    return lone_holders(problem, Phase(Action(rule, args), problem.init_motion, added), "item")


@pytest.mark.parametrize(
    ("rule", "more", "found"),
    [("grasp", "", ("c.B",)), ("share", "", ()), ("grasp", GLUE, ())],
)
def test_what_alone_holds_is_known_where_all_else_lets_go_and_nothing_hangs_it_up(
    rule: str, more: str, found: tuple[str, ...]
) -> None:
    assert holders(rule, more) == found


def test_a_thing_too_heavy_for_its_lone_grip_ends_the_search() -> None:
    text = TEXT.format(more="")
    text = text[: text.index("rule share")] + text[text.index("task t") :]
    outcome = solve(compile_text(text, "t.tamp")[0], SolveOptions(time=60.0, nodes=2000))
    assert outcome.status == "exhausted"
