"""Usual mistakes of people who come from Python, PDDL or URDF: each is told once, and its repair repairs it."""

from __future__ import annotations

import pytest

from tamplang.compiler.pipeline import check_sources
from tamplang.langs.diagnostics import Diagnostic
from tamplang.langs.fixes import fixes
from tamplang.langs.source import Source

HEAD = "import std.rules\nimport std.crawler\n\n"
TASK = HEAD + """task take() {
    base ground: box(2 m, 2 m, 5 cm) at (0, 0, 0)
    object ball: sphere(4 cm) at (0, 40 cm, 50 cm)
    crawler c: A on ground at (30 cm, 0)
    fact (grippable ball)
    goal (held ball)
}
"""
GUIDED = "import std.heuristics\n" + TASK.replace("goal (held", "guide climb(ball)\n    goal (held")
RULE = """import std.rules

rule lift(A: gripper, X: base) {
    pre   (support A), (on X A)
    post  not (support A), not (on X A)
}
"""
MODULE = """import std.logic

module arm {
    effector A: gripper sphere(5 cm) normal (0, 0, -1)
    joint j1: revolute(y) in -90 deg .. 90 deg
    link 40 cm: capsule(4 cm)
    effector B: gripper sphere(5 cm)
}
"""
MOTION = "import std.logic\n\nmotion [near X Y: object] {\n    at switch gap(X, Y) = 0\n}\n"
FUNCTION = "function f(x: real) = x + 1\n"
TYPE = "type shelf < object\n"
PREDICATE = "predicate (near X: object, Y: object)\n"


def found(text: str) -> list[Diagnostic]:
    return list(check_sources([Source("t.tamp", text)]))


def repaired(text: str) -> str:
    """The text after the first fix of every diagnostic, one after the other."""
    for _ in range(8):
        fix = next((f for d in found(text) for f in fixes(d, text)), None)
        if fix is None:
            return text
        text = fix.applied(text)
    return text


@pytest.mark.parametrize(
    ("program", "right", "wrong", "code"),
    [
        (TASK, "box(2 m, 2 m, 5 cm)", "box(2, 2, 0.05)", "W0014"),
        (TASK, "at (0, 40 cm, 50 cm)", "at (0, ４０ cm, 50 cm)", "E0002"),
        (TASK, "sphere(4 cm)", "sphere(٤ cm)", "E0002"),
        (TASK, "(0, 40 cm, 50 cm)", "(0, 0.4, 0.5)", "W0014"),
        (TASK, "at (30 cm, 0)", "at (30 cm, 0) heading 90", "E0203"),
        (TASK, "at (30 cm, 0)", "at (30 cm, 0) heading 90°", "E0002"),
        (TASK, "50 cm)", "50 centimeters)", "E0007"),
        (TASK, "sphere(4 cm)", "sphere(0,04 m)", "E0509"),
        (TASK, "sphere(4 cm)", "ball(4 cm)", "E0509"),
        (TASK, "crawler c:", "c: crawler", "E0003"),
        (TASK, "object ball: sphere", "ball: object sphere", "E0003"),
        (TASK, "object ball:", "object ball =", "E0003"),
        (TASK, "A on ground at (30 cm, 0)", "at (30 cm, 0) A on ground", "E0001"),
        (TASK, "at (0, 40 cm, 50 cm)", "at [0, 40 cm, 50 cm]", "E0001"),
        (TASK, "sphere(4 cm)", "sphere(1 cm * 2**2)", "E0001"),
        (TASK, "task take", "Task take", "E0004"),
        (GUIDED, "guide climb", "heuristic climb", "E0001"),
        (GUIDED, "guide climb", "guided by climb", "E0001"),
        (TASK, "fact (", "init (", "E0004"),
        (TASK, "goal (held", "goals (held", "E0004"),
        (TASK, "goal (held", "goal: (held", "E0001"),
        (TASK, "goal (held ball)", "goal held(ball)", "E0016"),
        (TASK, "goal (held ball)", "goal (and (held ball) (on ground c.A))", "E0001"),
        (TASK, "goal (held ball)", "goal (held ball) && (on ground c.A)", "E0002"),
        (TASK, "goal (held ball)", "goal (grasped c ball)", "E0202"),
        (TASK, "(grippable ball)", "(grippable ball) = true", "E0001"),
        (TASK, "(grippable ball)", "(grippable ball), (tray ground)", "E0001"),
        (TASK, "    fact (grippable ball)\n", "", "E0503"),
        (TASK, "import std.rules\nimport std.crawler", "from std import rules, crawler", "E0001"),
        (TASK, "import std.rules", "import std/rules", "E0001"),
        (TASK, "import std.rules", "import std.rules as r", "E0001"),
        (TASK, "import std.rules", 'import "std.rules"', "E0111"),
        (TASK, "import std.rules", "import std.rules.tamp", "E0111"),
        (TASK, "import std.rules\n", '#include "std/rules.tamp"\n', "E0503"),
        (TASK, "import std.crawler\n", "", "E0108"),
        (TASK, "import std.rules", '"""My task."""\nimport std.rules', "E0002"),
        (TASK, "    goal", "    // hello\n    goal", "E0002"),
        (TASK, "(held ball)\n", "(held ball)\n    /* the\n       end */\n", "E0002"),
        (TASK, "(held ball)", "(held ball)\n    options { time: 60 s }", "E0003"),
        (TASK, "(held ball)", "(held ball)\n    for i = 1 .. 2 { fact (tray ball) }", "E0003"),
        (TASK, "(held ball)", "(held ball)\n    for i in [1, 2] { fact (tray ball) }", "E0001"),
        (TASK, "(held ball)", "(held ball)\n    for i in range(2) { fact (tray ball) }", "E0001"),
        (TASK, "(held ball)", "(held ball)\n    if 1 < 2 { fact (tray c.A) } else { fact (tray c.B) }", "E0001"),
        (RULE, "(A: gripper, X: base)", "(?A - gripper ?X - base)", "E0003"),
        (RULE, "(A: gripper, X: base)", "(A - gripper, X - base)", "E0003"),
        (RULE, "(A: gripper, X: base)", " A: gripper, X: base", "E0003"),
        (RULE, "(support A), (on", "(and (support A) (on X A)), (on", "E0001"),
        (RULE, "not (on X A)", "(not (on X A))", "E0001"),
        (RULE, "not (on X A)", "when (on X A) (not (on X A))", "E0001"),
        (RULE, "(support A), (on X A)", "(support ?A), (on X A)", "E0002"),
        (RULE, "rule lift", "action lift", "E0004"),
        (RULE, "rule lift", "rule lift-foot", "E0001"),
        (RULE, "    pre   (", "    precondition (", "E0004"),
        (RULE, "    pre   (", "    where distance(X, A) <= 1 m\n    pre   (", "E0001"),
        (MODULE, "-90 deg .. 90 deg", "-90 .. 90", "E0203"),
        (MODULE, "-90 deg .. 90 deg", "-pi .. pi", "E0101"),
        (MODULE, "-90 deg .. 90 deg", "(-90 deg, 90 deg)", "E0001"),
        (MODULE, "-90 deg .. 90 deg", "[-90 deg, 90 deg]", "E0001"),
        (MODULE, "in -90 deg .. 90 deg", "from -90 deg to 90 deg", "E0001"),
        (MODULE, "revolute(y)", "continuous(y)", "E0508"),
        (MODULE, " normal (0, 0, -1)", "", "W0017"),
        (MODULE, "effector A", "efector A", "E0004"),
        (MODULE, "B: gripper sphere(5 cm)", "B: gripper sphere(5 cm) holds grip(force = 90 N)", "E0001"),
        (MOTION, "= 0", "== 0", "E0001"),
        (MOTION, "= 0", "< 1 cm", "E0402"),
        (MOTION, "at switch gap", "gap", "E0001"),
        (MOTION, "at switch gap", "at_switch gap", "E0001"),
        (MOTION, "gap(X, Y) = 0", "dot(position(X), (0, 0, 1)) = position(Y).z", "E0001"),
        (TASK, "5 cm) at", "5 cm), at", "E0001"),
        (MOTION, "at switch gap", "on switch gap", "E0001"),
        (MOTION, "at switch gap", "atSwitch: gap", "E0001"),
        (MOTION, "[near X Y: object]", "(near X Y: object)", "E0001"),
        (MOTION, "[near X Y: object]", "near[X Y: object]", "E0001"),
        (FUNCTION, "= x + 1", "{ return x + 1 }", "E0001"),
        (TYPE, "<", ":", "E0001"),
        (TYPE, "<", "extends", "E0001"),
        (PREDICATE, "(near X: object, Y: object)", "near(X: object, Y: object)", "E0001"),
    ],
)  # fmt: skip
def test_a_usual_mistake_has_one_message_and_a_repair(program: str, right: str, wrong: str, code: str) -> None:
    assert right in program and not found(program)
    text = program.replace(right, wrong, 1)
    told = found(text)
    assert {d.code for d in told} == {code}, told
    assert all(d.span is not None and d.span.file == "t.tamp" and d.help for d in told)
    last = repaired(text)
    assert not [d for d in found(last) if d.is_error], last


@pytest.mark.parametrize(
    ("text", "said", "hint"),
    [
        ('<?xml version="1.0"?>\n<robot name="arm">\n  <link name="base"/>\n</robot>\n', "XML", "from urdf"),
        ("; blocks\n(define (domain blocks)\n  (:predicates (on ?x ?y)))\n", "PDDL", "`rule`"),
        (TASK.replace("import std.rules", 'import "arm.urdf"\nimport std.rules'), "arm.urdf", "from urdf"),
        (TASK.replace("task take() {", "task take():"), "`{` and `}`", "`{` here"),
        (TASK.replace("    goal", "    let h = 1 m\n    goal"), "no variables", "parameter"),
        (TASK.replace("    goal", "    h = 1 m\n    goal"), "no variables", "parameter"),
        (TASK.replace("50 cm)", "50 cm) rpy (0, 0, 1 rad)"), "about the vertical", "heading"),
        (MODULE.replace("joint j1: revolute(y) in -90 deg .. 90 deg", "joint j1: fixed"), "a joint moves", "link"),
        (TASK.replace("sphere(4 cm)", "sphere(2 cm * 2^3)"), "no powers", "x * x"),
        (TASK.replace("import std.rules", "import std.*"), "one file", "import std.rules"),
        (TASK.replace("import std.rules", "import std"), "nothing to import under std", "std.rules"),
        (TASK.replace("object ball:", "object red ball:"), "a name is one word", "red_ball"),
        (TASK.replace("object ball:", "object 2ball:"), "starts with a letter", "ball2"),
    ],
)
def test_what_a_sign_cannot_repair_is_told_with_the_way_out(text: str, said: str, hint: str) -> None:
    first = found(text)[0]
    assert said in first.message and hint in (first.help or ""), first
    assert len({d.span.line for d in found(text) if d.span and d.code not in ("E0101", "W0016")}) == 1
