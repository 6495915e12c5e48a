"""Modules in the manner of RoFI and SMORES dock, walk and carry each other; in the engine their weak drives follow."""

from __future__ import annotations

from pathlib import Path

import pytest

from tamplang.compiler.ir import Problem
from tamplang.compiler.pipeline import compile_problem
from tamplang.runtime.engine import carry_out
from tamplang.runtime.planner.lgp import Outcome, SolveOptions, solve

SCENES = """
import std.real
import std.rules
task over(drive: torque = 4 N m) {
    base floor: box(1 m, 1 m, 2 cm) at (0, 0, -1 cm)
    object fence: box(2 cm, 30 cm, 4 cm) at (0, 0, 2 cm)
    base far: box(20 cm, 20 cm, 2 cm) at (60 cm, 0, 0)
    rofiLike(drive = drive) a: A on floor at (12 cm, 0)
    rofiLike(drive = drive) b: A on floor at (-10 cm, 0)
    goal exists B: gripper { (on far B) }
    options { physics = statics }
}
task meet(drive: torque = 4 N m) {
    base floor: box(1 m, 1 m, 2 cm) at (0, 0, -1 cm)
    rofiLike(drive = drive) a: A on floor at (-15 cm, 0)
    rofiLike(drive = drive) b: A on floor at (15 cm, 0)
    goal (connected a.B b.B)
    options { physics = statics, time = 3 s }
}
task walk() {
    base floor: box(30 cm, 30 cm, 2 cm) at (0, 0, -1 cm)
    base ledge: box(20 cm, 20 cm, 2 cm) at (24 cm, 0, 0)
    rofiLike a: A on floor at (8 cm, 0)
    goal (on ledge a.B)
    options { physics = statics }
}
task cubes() {
    base floor: box(1 m, 1 m, 2 cm) at (0, 0, -1 cm)
    smoresLike a: A on floor at (-5 cm, 0)
    smoresLike b: A on floor at (5 cm, 0)
    goal (connected a.B b.B)
    options { physics = statics }
}
"""


def _outcome(
    folder: Path, task: str, parameters: dict[str, str] | None = None, time: float = 60.0
) -> tuple[Problem, Outcome]:
    (folder / "docks.tamp").write_text(SCENES)
    problem = compile_problem(folder / "docks.tamp", task, parameters or {})[0]
    return problem, solve(problem, SolveOptions(time=time))


@pytest.mark.parametrize("task", ["over", "meet", "walk", "cubes"])
def test_small_modules_work_and_their_drives_follow(tmp_path: Path, task: str) -> None:
    problem, outcome = _outcome(tmp_path, task)
    assert outcome.status == "solved"
    plan = outcome.plans[0]
    assert plan.verdict is not None and plan.verdict.verified
    carried = carry_out(problem, plan)
    assert carried.reached and not carried.broken and carried.tracking < 5e-4


def test_what_holds_another_one_out_needs_stronger_drives(tmp_path: Path) -> None:
    _, outcome = _outcome(tmp_path, "meet", {"drive": "2Nm"}, time=4.0)
    assert not outcome.plans
    assert any("joint alpha of" in d.message and "too weak" in d.message for d in outcome.explanation)
