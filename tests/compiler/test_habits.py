"""What people bring from other languages, and what they forget, is told in words of this one."""

from __future__ import annotations

from pathlib import Path

import pytest

from tamplang.compiler.pipeline import check, check_sources
from tamplang.langs.fixes import fixes
from tamplang.langs.source import Source

TASK = "import std.rules\n\ntask t({}) {{\n    {}\n    goal (held b)\n}}\n"
MORE = "object c[i]: sphere(1 cm) at (1 m * i, 0, 0)"
BALL = "object b: sphere(4 cm) at (0, 0, 1 m)"


@pytest.mark.parametrize(
    ("text", "code", "written", "repaired"),
    [
        (TASK.format("int n = 3", BALL), "E0003", "write `n: int`", "(n: int = 3)"),
        (TASK.format("n: int = 3, length x = 1 m", BALL), "E0003", "write `x: length`", "x: length = 1 m"),
        ("import std.rules\nrule r(gripper A, base X) {\n    pre (on X A)\n    post not (support A)\n}\n", "E0003",
         "write `A: gripper`", "r(A: gripper,"),
        (TASK.format("", f"{BALL}\n    for i in range(3) {{ {MORE} }}"), "E0001",
         "write `1 .. 3`", "for i in 1 .. 3 {"),
        (TASK.format("n: int = 3", f"{BALL}\n    for i in range(2, n) {{ {MORE} }}"),
         "E0001", "write `2 .. n - 1`", "for i in 2 .. n - 1 {"),
        (TASK.format("", BALL).replace("import std.rules", "from std import rules"), "E0001",
         "write `import std.rules`", "import std.rules\n"),
        (TASK.format("", BALL).replace("import std.rules", "from std import logic, rules"), "E0001",
         "write `import std.logic\nimport std.rules`", "import std.logic\nimport std.rules\n"),
    ],
)  # fmt: skip
def test_one_error_with_the_right_form(text: str, code: str, written: str, repaired: str) -> None:
    errors = [d for d in check_sources([Source("t.tamp", text)]) if d.is_error]
    assert errors[0].code == code and errors[0].help == written
    assert {d.code for d in errors} == {code}
    fixed = fixes(errors[0], text)[0].applied(text)
    assert repaired in fixed


@pytest.mark.parametrize(
    ("text", "code", "word"),
    [
        (TASK.format("", BALL.replace("4 cm", "0.04")), "W0014", "0.04 m"),
        (TASK.format("", BALL.replace("1 m", "1")), "W0014", "1 m"),
        ("import std.rules\nrule r(A: gripper) {\n    pre (free A)\n}\n", "W0015", "post"),
        ("# nothing yet\n", "W0016", "tamplang new"),
        ("import std.logic\nmodule m() {\n    effector A: gripper sphere(5 cm)\n    joint j: revolute(y)\n"
         "    link 1 m\n    effector B: gripper sphere(5 cm)\n}\n", "W0017", "normal (0, 0, -1)"),
    ],
)  # fmt: skip
def test_what_is_forgotten_is_a_warning(text: str, code: str, word: str) -> None:
    (found,) = [d for d in check_sources([Source("t.tamp", text)]) if d.code == code]
    assert found.help is not None and word in found.help


@pytest.mark.parametrize(
    "text",
    [
        TASK.format("", BALL.replace("1 m", "0")),
        "import std.logic\nmodule m() {\n    effector A: sphere(5 cm) normal (0, 0, -1)\n    link 1 m\n"
        "    effector B: sphere(5 cm)\n}\n",
        "import std.logic\nmodule m() {\n    effector A: sphere(5 cm)\n    link (1 m, 0, 0)\n"
        "    effector B: sphere(5 cm)\n}\n",
    ],
)
def test_what_is_right_is_none(text: str) -> None:
    codes = {d.code for d in check_sources([Source("t.tamp", text)])}
    assert not codes & {"W0014", "W0015", "W0016", "W0017"}


def test_a_plan_is_no_program(tmp_path: Path) -> None:
    plan = tmp_path / "climb.plan.json"
    plan.write_text('{\n  "format": 3\n}\n')
    (found,) = check(plan)
    assert found.code == "E0018" and found.help is not None and "tamplang verify" in found.help
