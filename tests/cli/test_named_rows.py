"""A motion predicate may be called whatever the planner calls its own limits: it is explained as the user's literal."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from .conftest import Tamplang

TEXT = """
import std.crawler
import std.rules
predicate (lifted X: object)
## X is high above Y.
motion [NAME X Y: object] {
    at switch bottom(X) >= top(Y) + 5 m
}
rule lift(A: gripper, X: object) {
    pre  (grasped A X)
    post (lifted X), [NAME X A]
}
task lift() {
    base ground: box(2 m, 2 m, 0.05 m) at (0, 0, 0)
    object target: sphere(0.04 m) at (0.5 m, 0, 0.4 m)
    fact (grippable target)
    crawler c: A on ground at (0, 0)
    goal (lifted target)
}
"""


@pytest.mark.parametrize("name", ["limit", "collision", "self", "step", "drift"])
def test_the_users_own_literal_is_named(tamplang: Tamplang, program: Callable[[str], Path], name: str) -> None:
    ran = tamplang("solve", program(TEXT.replace("NAME", name)), "--json", "--time", "30")
    assert ran.returncode == 4
    wanted = f"[{name} target c.B] is missed by"
    told = [entry for entry in json.loads(ran.stdout)["explanation"] if wanted in entry["message"]]
    assert told and told[0]["line"] == 7
