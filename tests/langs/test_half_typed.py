"""A line that is being typed has its mistake on itself, and the lines around it keep their meaning."""

import random
import re

import pytest

from tamplang.langs.parser import parse
from tamplang.langs.source import Source

from .programs import REAL, source_of

WORD = re.compile(r"\w+|[^\w\s]")


def lines_with_errors(text: str) -> set[int]:
    return {n for d in parse(Source("t", text))[1] if d.span for n in range(d.span.line, d.span.end_line + 1)}


@pytest.mark.parametrize(
    ("half", "line"),
    [
        ("module m() {\n    link 0.1 *\n    link 1 m\n}\n", 2),
        ("module m() {\n    link 0.1 *\n}\n", 2),
        ("import std.\n\nmodule m() {\n    link 1 m\n}\n", 1),
        ("function f()\n\nfunction g(x: real) = x\n", 1),
        ("motion [\n    at switch gap(X, Y) = 0\n}\n\ntype a < object\n", 1),
        ("task t() {\n    for k in\n        base b[k]: sphere(1 m) at (0, 0, 0)\n    }\n    goal (held b)\n}\n", 2),
        ("task t() {\n    scene stairs\n    fail c at 2 s: locked\n}\n", 2),
    ],
)
def test_the_mistake_is_on_the_line_that_is_typed(half: str, line: int) -> None:
    assert lines_with_errors(half) == {line}


def test_what_follows_a_half_typed_line_is_read() -> None:
    text = "task t() {\n    object b: \n    fact (on b b)\n    goal (held b)\n}\n\nrule\n\ntype plate < base\n"
    file, mistakes = parse(Source("t", text))
    assert {d.span.line for d in mistakes if d.span} == {2, 7}
    task, kind = file.declarations
    assert [type(item).__name__ for item in task.items] == ["FactItem", "GoalItem"]
    assert kind.name == "plate"


def test_half_typed_lines_of_real_programs() -> None:
    """Words of several lines cannot always be told from what follows: nine of ten must be right."""
    draw = random.Random(7)
    right = wrong = 0
    while right + wrong < 60:
        source = source_of(draw.choice(REAL))
        lines = source.text.split("\n")
        number = draw.randrange(len(lines))
        ends = [m.end() for m in WORD.finditer(lines[number])][:-1]
        if not ends or lines[number].lstrip().startswith("#"):
            continue
        lines[number] = lines[number][: draw.choice(ends)]
        found = lines_with_errors("\n".join(lines))
        right += not found or number + 1 in found
        wrong += bool(found) and number + 1 not in found
    assert wrong <= 6
