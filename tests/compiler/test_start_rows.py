"""Rows of motion literals at the start: `during` rows are measured before any search, `at switch` rows never."""

from __future__ import annotations

import re

import pytest

from tamplang.compiler.pipeline import check_sources, compile_text
from tamplang.langs.source import Source
from tamplang.runtime.planner.lgp import SolveOptions, solve

TEXT = """import std.crawler
import std.rules
motion [marked A: object, B: object] {
    ROW
}
task t() {
    base pedestal: box(0.3 m, 0.3 m, 0.05 m) at (0, 0, 0)
    object ball: sphere(4 cm) at (0.4 m, 0.4 m, 0.3 m)
    object stone: hull((0, 0, 0), (10 cm, 0, 0), (0, 10 cm, 0), (0, 0, 10 cm)) at (2 m, 0, 0)
    fact (grippable ball)
    FACT
    crawler c: A on pedestal
    goal (held ball)
}
"""


def found(row: str, fact: str) -> list[tuple[str, int, str]]:
    text = TEXT.replace("ROW", row).replace("FACT", f"fact {fact}")
    told = check_sources([Source("t.tamp", text)])
    return [(d.code, d.span.line if d.span else 0, d.message) for d in told if d.code.startswith("E")]


@pytest.mark.parametrize(
    ("row", "fact", "miss"),
    [
        ("during top(A) <= 0.2 m", "[marked ball pedestal]", 0.14),
        ("during top(A) <= 0.34 m", "[marked ball pedestal]", None),
        ("during top(A) <= 0.3391 m", "[marked ball pedestal]", None),
        ("during top(A) = 1 m", "[marked ball pedestal]", 0.66),
        ("during position(A) = position(B) + (0.4 m, 0, 0.3 m)", "[marked ball pedestal]", 0.4),
        ("during gap(A, B) <= 1 m", "[marked stone pedestal]", 0.8),
        ("during dot(axis(A, z), (0, 0, 1)) <= 0.5", "[marked c.B ball]", 0.5),
        ("during norm(position(A) - position(B)) >= 50 cm", "[marked c.A ball]", None),
        ("at switch top(A) <= 0.2 m", "[marked ball pedestal]", None),
        ("keep pose(B, A)", "[marked pedestal ball]", None),
    ],
)
def test_check_measures_the_start(row: str, fact: str, miss: float | None) -> None:
    told = found(row, fact)
    if miss is None:
        assert not told
        return
    (only,) = told
    assert only[:2] == ("E0520", 4)
    figure = re.search(r"missed there by ([\d.]+)", only[2])
    assert figure is not None and float(figure[1]) == pytest.approx(miss, abs=0.06)


def test_switch_rows_ask_nothing_of_the_start_in_planner_and_verifier() -> None:
    text = TEXT.replace("ROW", "at switch top(A) <= 0.2 m").replace("FACT", "fact [marked ball pedestal]")
    outcome = solve(compile_text(text)[0], SolveOptions(time=60.0))
    assert outcome.status == "solved"
    assert outcome.plans[0].verdict is not None and outcome.plans[0].verdict.verified
