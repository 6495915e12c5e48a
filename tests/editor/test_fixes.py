"""Applying the repair that a hint tells removes what the hint is about."""

from __future__ import annotations

import pytest

from tamplang.compiler.pipeline import check_sources
from tamplang.langs.diagnostics import Diagnostic
from tamplang.langs.fixes import fixes
from tamplang.langs.source import Source

RULES = "import std.rules\n\n"
TASK = "import std.rules\n\ntask t() {{\n    object b: sphere(4 cm) at (0, 0, 0)\n    fact (grippable b)\n    {}\n}}\n"
LOOPS = (
    RULES + "task t(n: int) {\n    for i in 1 .. n {\n        for j in 1 .. n {\n"
    "            base s[i][j]: box(1 m, 1 m, 1 m) at (0, 0, 0)\n"
)
CRAWLER = "import std.crawler\nimport std.rules\n\ntask t() {\n    base ground: box(2 m, 2 m, 5 cm) at (0, 0, 0)\n"


def checked(text: str) -> list[Diagnostic]:
    return [d for d in check_sources([Source("t.tamp", text)]) if d.is_error and d.span and d.span.file == "t.tamp"]


@pytest.mark.parametrize(
    ("wrong", "right"),
    [
        (TASK.format("goal (helt b)"), "goal (held b)"),
        (TASK.format("goal (held c)"), None),
        (TASK.format("goal held b"), "goal (held b)"),
        (TASK.format("gaol (held b)"), "goal (held b)"),
        (TASK.format("goal (held b) && (held b)"), "goal (held b) and (held b)"),
        (TASK.format("goal (held b);"), "goal (held b)\n"),
        (TASK.format("goal (held, b)"), "goal (held b)"),
        (TASK.format("goal (held b)\n    options { tme = 60 s }"), "options { time = 60 s }"),
        (TASK.format("goal (held b)\n    options { bound = paths }"), "options { bound = path }"),
        (TASK.format("goal (held b)\n    object c sphere(4 cm) at (1 m, 0, 0)"), "object c: sphere"),
        (TASK.format("goal (held b)\n    object c: sphere(5 inch) at (1 m, 0, 0)"), "sphere(0.127 m)"),
        (TASK.format("goal (held b)\n    object c: sphere(5 cm) at (1 m, 0, 0) heading 90 degrees"), "90 deg"),
        (TASK.format("goal (held b)\n    // a remark"), "# a remark"),
        (TASK.format("goal (held b)\n    object c: sphere(5 cm) at (1 m, 0, 0) heading 90"), "heading 90 "),
        (CRAWLER + "    crawler c: C on ground\n    goal (held ground)\n}\n", "crawler c: A on"),
        (LOOPS + "    }\n    goal (held b)\n}\n\ntype a < object\n", "    }\n    }\n    goal"),
        ("predicate (p A: gripper)\n", "import std.logic"),
        ("import std.rule\n", "import std.rules"),
        ("import rules\n", "import std.rules"),
        (RULES + "rule r(A: gripper) {\n    post  (support A)\n    pre   (free A)\n}\n", "pre   (free A)\n    post"),
        (RULES + "rule r(A: gripper) {\n    pre   (free A),\n}\n", "pre   (free A)\n"),
        (RULES + "rule r(A: gripper) {\n    pre   (free A]\n    post  (support A)\n}\n", None),
        (RULES + "rule r(A: gripper) {\n    pre   [support A]\n    post  (support A)\n}\n", "pre   (support A)"),
        (RULES + "rule r(A: gripper, X: base) {\n    pre   (free A), X == X\n    post  (support A)\n}\n", "X = X"),
        (RULES + "motion [near X Y: object] {\n    at switch gap(X, Y) < 1 cm\n}\n", "<= 1 cm"),
    ],
)  # fmt: skip
def test_a_fix_removes_its_diagnostic(wrong: str, right: str | None) -> None:
    found = checked(wrong)
    assert found
    first = next((d for d in found if fixes(d, wrong)), None)
    if right is None:
        assert first is None or fixes(first, wrong)[0].applied(wrong) != wrong
        return
    assert first is not None, found
    repaired = fixes(first, wrong)[0].applied(wrong)
    assert right in repaired
    again = [(d.code, d.message) for d in checked(repaired)]
    assert (first.code, first.message) not in again


def test_no_fix_writes_a_gap() -> None:
    """Hints that show only the form of what is meant, with `…`, are no text to put in."""
    found = Diagnostic("E0404", "wrong", None, help="write `keep pose(…)`")
    assert fixes(found, "") == []
