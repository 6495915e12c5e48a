"""Hands that must come from the free side: to a thing in a box whose cover is put aside first."""

from __future__ import annotations

from pathlib import Path

from tamplang.compiler.pipeline import compile_problem
from tamplang.runtime.planner.lgp import SolveOptions, solve

COVERED = """
import std.crawler
import std.rules
task t {
    base pedestal: box(30 cm, 30 cm, 5 cm) at (0, 0, 0)
    object table: box(40 cm, 80 cm, 5 cm) at (50 cm, 0, 2.5 cm)
    fact (tray table)
    object chest: union(box(16 cm, 16 cm, 1 cm) at (0, 0, 0), box(1 cm, 16 cm, 8 cm) at (-7.5 cm, 0, 4.5 cm),
        box(1 cm, 16 cm, 8 cm) at (7.5 cm, 0, 4.5 cm), box(16 cm, 1 cm, 8 cm) at (0, 7.5 cm, 4.5 cm),
        box(16 cm, 1 cm, 8 cm) at (0, -7.5 cm, 4.5 cm)) on table at (0, -15 cm)
    object item: box(4 cm, 4 cm, 4 cm) on chest at (jitter(1 cm), jitter(1 cm))
    object cover: box(17 cm, 17 cm, 1 cm) at (50 cm, -15 cm, 14.55 cm)
    fact (on chest cover)
    fact (grippable cover)
    fact (grippable item)
    crawler c: A on pedestal
    goal (held item) and (on table cover)
}
"""


def test_a_thing_is_taken_out_of_a_box_when_its_cover_is_put_aside(tmp_path: Path) -> None:
    (tmp_path / "box.tamp").write_text(COVERED)
    outcome = solve(compile_problem(tmp_path / "box.tamp", "t")[0], SolveOptions(time=60.0))
    assert outcome.status == "solved"
    verdict = outcome.plans[0].verdict
    assert verdict is not None and verdict.verified
