"""Modules, rules and motion predicates that the standard library does not know solve and verify."""

from __future__ import annotations

from pathlib import Path

import pytest

import tamplang

GOOD = Path(__file__).parents[1] / "programs" / "good"


def test_own_module_with_a_sliding_joint_own_rule_and_own_motion_predicate() -> None:
    task = tamplang.load(GOOD / "own_module.tamp")
    (module,) = task.problem.world.modules.values()
    assert [j.kind for j in module.type.joints].count("prismatic") == 1 and len(module.type.joints) == 5
    result = task.solve(time=60.0)
    assert result.plan is not None
    assert result.plan.actions == ("push(c.tip, b[1])", "push(c.tip, b[2])")
    assert result.plan.verify().verified


def test_module_from_urdf_solves_and_its_plan_stands_alone(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(GOOD)
    result = tamplang.load("arm_from_urdf.tamp").solve(time=60.0)
    assert result.plan is not None
    result.plan.save(tmp_path / "plan.json")
    monkeypatch.chdir(tmp_path)
    plan = tamplang.read_plan("plan.json")
    assert plan.actions == ("grasp(a.tool, ball)",)
    assert plan.verify().verified
