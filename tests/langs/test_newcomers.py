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
        (TASK, "goal (held ball)", "goal (held ball), forall k in 1 .. 2 : (held ball)", "E0001"),
        (TASK, "goal (held ball)", "goal forall k: int in 1 .. 2 { (held ball) }", "E0001"),
        (TASK, "goal (held ball)", "goal for all k in 1 .. 2 { (held ball) }", "E0004"),
        (TASK, "A on ground", "A on the ground", "E0001"),
        (TASK, "at (30 cm, 0)", "at (30 cm, 0) facing 90 deg", "E0001"),
        (TASK, "fact (grippable ball)", "fact (grippable ball) (grippable ground)", "E0001"),
        (MODULE, "link 40 cm:", "link 40 cm along x:", "E0001"),
        (MODULE, "link 40 cm:", "link 40 cm along (0, 0, -1):", "E0001"),
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
        (TASK, "base ground: box(2 m, 2 m, 5 cm) at (0, 0, 0)", "base ground: at (0, 0, 0) box(2 m, 2 m, 5 cm)",
         "E0001"),
        (TASK, "ground: box(2 m, 2 m, 5 cm) at (0, 0, 0)", "ground at (0, 0, 0): box(2 m, 2 m, 5 cm)", "E0001"),
        (TASK, "A on ground at", "on ground A at", "E0001"),
        (TASK, "A on ground at", "c.A on ground at", "E0001"),
        (TASK, "A on ground at", "A on top of ground at", "E0001"),
        (TASK, "A on ground at (30 cm, 0)", "A at ground (30 cm, 0)", "E0001"),
        (TASK, "A on ground at (30 cm, 0)", "A on ground at 30 cm, 0", "E0001"),
        (TASK, "A on ground at (30 cm, 0)", "heading 90 deg A on ground at (30 cm, 0)", "E0001"),
        (TASK, "at (0, 40 cm, 50 cm)", "at = (0, 40 cm, 50 cm)", "E0001"),
        (TASK, "at (0, 40 cm, 50 cm)", "at (0, 40, 50) cm", "E0001"),
        (TASK, "at (0, 40 cm, 50 cm)", "position (0, 40 cm, 50 cm)", "E0001"),
        (TASK, "at (0, 40 cm, 50 cm)", "at (0, 40 cm, 50 cm),", "E0001"),
        (TASK, "at (0, 40 cm, 50 cm)", "at (0, 40 cm, 50 cm) color red", "E0001"),
        (TASK, "box(2 m, 2 m, 5 cm)", "box(2 m 2 m 5 cm)", "E0001"),
        (TASK, "box(2 m, 2 m, 5 cm)", "box(2 m x 2 m x 5 cm)", "E0001"),
        (TASK, "box(2 m, 2 m, 5 cm)", "box(2 m; 2 m; 5 cm)", "E0002"),
        (TASK, "box(2 m, 2 m, 5 cm)", "box[2 m, 2 m, 5 cm]", "E0001"),
        (TASK, "box(2 m, 2 m, 5 cm)", "box 2 m, 2 m, 5 cm", "E0001"),
        (TASK, "box(2 m, 2 m, 5 cm)", "box(x=2 m, y=2 m, z=5 cm)", "E0016"),
        (TASK, "sphere(4 cm)", "sphere(radius: 4 cm)", "E0001"),
        (TASK, "sphere(4 cm)", "sphere(.04 m)", "E0001"),
        (TASK, "sphere(4 cm)", "sphere(4 CM)", "E0007"),
        (TASK, "object ball: sphere", "ball: sphere", "E0001"),
        (TASK, "object ball:", "object ball is", "E0001"),
        (TASK, "(grippable ball)", "grippable(ball)", "E0016"),
        (TASK, "(grippable ball)", "(ball grippable)", "E0103"),
        (TASK, "goal (held ball)", "goal { (held ball) }", "E0001"),
        (TASK, "(held ball)", '(held "ball")', "E0001"),
        (TASK, "task take()", 'task "take"()', "E0001"),
        (TASK, "task take()", "task my take()", "E0001"),
        (TASK, "task take()", "def take()", "E0001"),
        (TASK, "task take()", "def task take()", "E0001"),
        (TASK, "take() {", "take() begin", "E0001"),
        (TASK, "5 cm) at (0, 0, 0)\n", "5 cm) at (0, 0, 0)\n}\n", "E0001"),
        (TASK, "(held ball)\n}", "(held ball)\n}\n}", "E0001"),
        (TASK, "import std.rules\nimport std.crawler", "import std.rules, std.crawler", "E0001"),
        (TASK, "import std.rules\nimport std.crawler", "import std.{rules, crawler}", "E0001"),
        (TASK, "import std.rules\nimport std.crawler", "import std::rules\nimport std::crawler", "E0001"),
        (TASK, "import std.crawler", "import std crawler", "E0001"),
        (TASK, "import std.crawler", "use std.crawler", "E0001"),
        (TASK, "import std.crawler", "std.crawler", "E0001"),
        (TASK, "(held ball)\n", "(held ball)\n    options (time = 60 s)\n", "E0001"),
        (TASK, "(held ball)\n", "(held ball)\n    options time = 60 s\n", "E0001"),
        (TASK, "(held ball)\n", '(held ball)\n    options { bound = "path" }\n', "E0210"),
        (TASK, "(held ball)\n", "(held ball)\n    minimize duration\n", "E0001"),
        (TASK, "(held ball)\n", "(held ball)\n    for k in 2 { fact (tray ball) }\n", "E0001"),
        (TASK, "(held ball)\n", "(held ball)\n    for k in 1 .. 2: fact (tray ball)\n", "E0001"),
        (TASK, "(held ball)\n", "(held ball)\n    repeat 2 { fact (tray ball) }\n", "E0001"),
        (TASK, "(held ball)\n", "(held ball)\n    object b(1): sphere(1 cm) at (0, 0, 1 m)\n", "E0001"),
        (TASK, "(held ball)\n", "(held ball)\n    print(ball)\n", "E0001"),
        (RULE, "not (support A), not", "not (support A) and not", "E0001"),
        (RULE, "post  not (support A)", "post  not support(A)", "E0016"),
        (RULE, "post  not (support A)", "post  del (support A)", "E0001"),
        (RULE, "pre   (support A), (on", "pre   (support A), ~(on", "E0002"),
        (MODULE, "A: gripper sphere(5 cm)", "A: sphere(5 cm) gripper", "E0001"),
        (MODULE, "effector A: gripper sphere", "gripper A: sphere", "E0001"),
        (MODULE, "normal (0, 0, -1)", "normal 0, 0, -1", "E0001"),
        (MODULE, "normal (0, 0, -1)", "normal = (0, 0, -1)", "E0001"),
        (MODULE, "arm {", "arm = {", "E0001"),
        (MODULE, "revolute(y)", "revolute y", "E0001"),
        (MODULE, "revolute(y)", "revolute(Y)", "E0508"),
        (MODULE, "-90 deg .. 90 deg", "90 deg .. -90 deg", "E0508"),
        (MODULE, "-90 deg .. 90 deg", "+-90 deg", "E0001"),
        (MODULE, "-90 deg .. 90 deg", "-90 deg, 90 deg", "E0001"),
        (MODULE, "in -90 deg .. 90 deg", "limits -90 deg .. 90 deg", "E0001"),
        (MODULE, "in -90 deg .. 90 deg", "home 0 deg in -90 deg .. 90 deg", "E0001"),
        (MODULE, "in -90 deg .. 90 deg", "speed 2 rad/s in -90 deg .. 90 deg", "E0001"),
        (MODULE, "in -90 deg .. 90 deg", "in -90 deg .. 90 deg torque 3 N m jerk 2 rad/s^3 speed 2 rad/s", "E0001"),
        (MODULE, "link 40 cm: capsule(4 cm)", "link 40 cm mass 3 kg: capsule(4 cm)", "E0001"),
        (TASK, "at (0, 40 cm, 50 cm)", "mass 3 kg at (0, 40 cm, 50 cm)", "E0001"),
        (TASK, "at (0, 40 cm, 50 cm)", "holds grip(force 3 N) heading 3 deg at (0, 40 cm, 50 cm) # here", "E0001"),
        (TASK, "A on ground at (30 cm, 0)", "A on ground heading 90 deg at (30 cm, 0)", "E0001"),
        (MODULE, "link 40 cm: capsule(4 cm)", "link capsule(4 cm) 40 cm", "E0001"),
        (MODULE, "link 40 cm", "link l1 40 cm", "E0001"),
        (MOTION, "at switch gap", "at switch: gap", "E0001"),
        (MOTION, "at switch gap", "always gap", "E0001"),
        (MOTION, "= 0", "= 0 and gap(Y, X) = 0", "E0001"),
        (MOTION, "gap(X, Y) = 0", "1 cm <= gap(X, Y) <= 2 cm", "E0001"),
        (MOTION, "gap(X, Y) = 0", "gap(X, Y) in 1 cm .. 2 cm", "E0001"),
        (MOTION, "[near X Y: object]", "near(X, Y: object)", "E0001"),
        (MOTION, "[near X Y: object]", "[near X, Y: object]", "E0001"),
        (MOTION, "[near X Y: object]", "[near X Y]", "E0003"),
        (FUNCTION, "x: real", "x: float", "E0102"),
        (FUNCTION, "function f", "def f", "E0001"),
        (FUNCTION, "real) =", "real) -> real =", "E0001"),
        (TYPE, "<", "is a", "E0001"),
        (TYPE, "shelf < object", "shelf(object)", "E0001"),
        (PREDICATE, "(near X: object, Y: object)", "(near X, Y)", "E0003"),
        (PREDICATE, "(near X: object, Y: object)", "near X: object, Y: object", "E0001"),
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
        (TASK.replace("A on ground at", "on ground at"), "one of its ends", "A on ground"),
        (TASK.replace("A on ground at", "A on ground"), "`ground` is no function", "behind `at`"),
        (TASK.replace("sphere(4 cm)", "sphere"), "sizes of this shape lack", "sphere(4 cm)"),
        (TASK.replace("object ball:", "object ball, cup:"), "has one name", "object cup: sphere(4 cm)"),
        (TASK.replace("    fact (g", "    not (held ball)\n    fact (g"), "does not hold at the start", "leave it out"),
        (TASK.replace("crawler c:", "crawler[2] c:"), "by `for`", "crawler c[k]"),
        (TASK.replace("    fact (g", "    (g"), "behind `fact` or `goal`", "in front of what is wanted"),
        (TASK.replace("    goal", "    while true { fact (tray ball) }\n    goal"), "no `while`", "for k in"),
        (TASK.replace("    goal", "    options { seed = 3 }\n    goal"), "does not set its seed", "--seed"),
        (TASK.replace("    goal", "    for k in 1 .. 2 { object b: sphere(1 cm) at (0, 0, 1 m * k) }\n    goal"),
         "two things named", "`b[k]`"),
        (RULE.replace("not (support A), not", "not (support A) or not"), "no choice", "a rule for each"),
        (RULE.replace("not (on X A)", "distance(X, A) <= 1 m"), "an effect is a literal", "`where`"),
        (MODULE.replace("joint j1: revolute(y)", "joint revolute(y)"), "a joint has a name", "joint j1"),
        (MODULE.replace("revolute(y)", "revolute(0, 1, 0)"), "one axis", "revolute(y)"),
        (MODULE.replace("90 deg\n", "90 deg home 120 deg\n"), "outside its limits", "-90 deg .. 90 deg"),
        (MODULE.replace("link 40 cm", "link l1"), "a length, and no name", "link 40 cm"),
        (MOTION.replace("= 0", "!= 0"), "not by !=", ">="),
    ],
)
def test_what_a_sign_cannot_repair_is_told_with_the_way_out(text: str, said: str, hint: str) -> None:
    first = found(text)[0]
    assert said in first.message and hint in (first.help or ""), first
    assert len({d.span.line for d in found(text) if d.span and d.code not in ("E0101", "W0016")}) == 1


def test_a_bracket_left_open_at_the_end_of_a_line_is_told_there() -> None:
    text = TASK.replace("(grippable ball)", "(grippable ball")
    (told,) = found(text)
    assert told.code == "E0005" and told.span is not None and told.span.line == 8
    assert not found(repaired(text))


def test_parts_of_a_rule_in_another_order_are_told_once() -> None:
    text = RULE.replace("pre   (support A), (on X A)\n    post  not (support A), not (on X A)",
                        "post  not (support A), not (on X A)\n    pre   (support A), (on X A)")  # fmt: skip
    assert [d.code for d in found(text)] == ["E0001"]


def test_a_urdf_between_braces_is_told_where_it_stands() -> None:
    told = found('module arm {\n    from urdf "none.urdf"\n    fact (linked A B)\n}\n')[0]
    assert "in front of its braces" in told.message and told.help is not None and 'arm from urdf "' in told.help
    assert not any("unexpected" in d.message for d in found('module arm {\n    from urdf "none.urdf"\n}\n'))


def test_a_strange_word_behind_an_import_leaves_the_import_whole() -> None:
    assert [d.code for d in found(TASK.replace("task take()", "hello take()"))] == ["E0001"]
