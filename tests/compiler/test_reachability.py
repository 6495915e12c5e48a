"""The delete relaxation never refuses what real actions reach, and names what keeps a goal from being reached."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from tamplang.compiler import ir
from tamplang.compiler.checks.relaxation import Relaxation, RelaxedWorld
from tamplang.compiler.pipeline import check_sources, compile_problem, compile_text
from tamplang.compiler.scenes.reachability import possible
from tamplang.compiler.symbolic.successors import Successors
from tamplang.langs.source import Source

ROOT = Path(__file__).parents[2]

STEPPING_STONES = """import std.crawler
import std.rules
type rope < object
predicate (cut X: object)
rule cut_rope(A: effector, X: rope) {
    pre  (grasped A X), not (cut X)
    post (cut X), not (grasped A X), not [stable A X], not [touch A X]
}
task t() {
    for i in 1 .. 3 { base stone[i]: box(0.3 m, 0.3 m, 0.1 m) at (0.4 m * i, 0, 0) }
    rope r: sphere(4 cm) at (0.9 m, 0.5 m, 0.8 m)
    fact (grippable r)
    fact (tray stone[3])
    crawler c: A on stone[1]
    crawler d: A on stone[2]
    goal (cut r)
}
"""


def problems() -> dict[str, ir.Problem]:
    return {
        "climb": compile_problem(ROOT / "examples" / "climb.tamp", parameters={"n": "3"})[0],
        "pick": compile_problem(ROOT / "examples" / "pick_and_place.tamp")[0],
        "stones": compile_text(STEPPING_STONES)[0],
    }


PROBLEMS = problems()


def relaxation(problem: ir.Problem) -> Relaxation:
    return Relaxation(
        RelaxedWorld(problem.types, problem.objects, problem.derived, problem.predicates, problem.rules, problem.init)
    )


@pytest.mark.parametrize("name", PROBLEMS)
def test_what_actions_reach_is_possible(name: str) -> None:
    problem = PROBLEMS[name]
    relaxed, successors, chance = relaxation(problem), Successors(problem), random.Random(3)
    seen: set[ir.Fact] = set()
    for _ in range(12):
        state = successors.initial
        for _ in range(25):
            options = successors.expand(state)
            if not options:
                break
            state, number = chance.choice(options)
            action = successors.action(number)
            variables = problem.rules[action.rule].variables
            for variable, value in zip(variables, action.args, strict=True):
                if isinstance(variable.type, ir.ObjectType):
                    assert value in relaxed.domains[action.rule][variable.name]
            seen |= successors.facts(state)
    assert len(seen) > len(problem.init)
    for fact in seen:
        literal = ir.Literal(fact[0], tuple(ir.Object(n) for n in fact[1:]))
        assert possible(relaxed, literal, {}), fact


GOALS = """import std.crawler
import std.rules
task t() {
    base ground: box(2 m, 2 m, 0.05 m) at (0, 0, 0)
    object shelf: box(0.3 m, 0.3 m, 0.05 m) at (0.5 m, 0, 1 m)
    object cup: sphere(4 cm) on shelf
    FACTS
    crawler c: A on ground
    crawler d: A on ground at (0, 0.5 m)
    goal GOAL
}
"""


@pytest.mark.parametrize(
    ("facts", "goal", "reason"),
    [
        ("", "(on shelf cup)", None),
        ("", "not (on shelf cup)", None),
        ("", "(held cup)", "`grasp` needs `(grippable cup)`, which is no fact"),
        ("fact (grippable cup)", "(held cup)", None),
        ("fact (grippable cup)", "(held shelf)", "`grasp` needs `(grippable shelf)`, which is no fact"),
        ("fact (grippable cup)", "(on ground cup)", "`place` needs `(tray ground)`, which is no fact"),
        ("fact (tray ground)", "(on ground cup)", "`place` needs `(grasped A cup)`, which can never hold"),
        ("fact (tray ground) fact (grippable cup)", "(on ground cup)", None),
        ("", "(connected c.A d.B)", None),
        ("", "(on cup c.B)", "`step` takes only things of type `base` for Y"),
        ("", "exists A: effector { (on ground A) and (grasped A cup) }", "(grippable cup)"),
        ("", "(held cup) or (support c.B)", None),
        ("fact (grippable cup)", "forall X: object { (grippable X) or not (held X) }", None),
    ],
)
def test_goals(facts: str, goal: str, reason: str | None) -> None:
    found = check_sources([Source("goal.tamp", GOALS.replace("FACTS", facts).replace("GOAL", goal))])
    if reason is None:
        assert not found
    else:
        (only,) = found
        assert only.code == "E0503"
        assert only.note is not None
        assert reason in only.note


def test_predicates_that_need_each_other_are_told_soon_and_once() -> None:
    """Each of ten predicates comes from each other one: paths among them are millions, sentences are nine."""
    count = range(10)
    lines = [f"predicate (p{i} X: object)" for i in count]
    lines += [f"rule r{i}_{j}(X: object) {{ pre (p{j} X) post (p{i} X) }}" for i in count for j in count if i != j]
    lines += ["task t() {", "    object f: box(1 m, 1 m, 1 m) at (0, 0, 0)", "    goal (p0 f)", "}"]
    (only,) = check_sources([Source("goal.tamp", "\n".join(lines))])
    assert only.code == "E0503" and only.note is not None
    first, *others = only.note.split("; ")
    assert first == "`r0_1` needs `(p1 f)`, which can never hold: `r1_0` needs `(p0 f)`, which can never hold"
    assert len(others) == 8
