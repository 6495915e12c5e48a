"""Closed chains: four crawlers mount a plate and stand up on four feet (`examples/quadruped.tamp`)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import tamplang
from tamplang.compiler.ir import Function, Number, Row, Var, Vector
from tamplang.compiler.motion.constraints import EffectorKind, stage
from tamplang.compiler.symbolic.successors import Successors
from tamplang.runtime.budget import Budget
from tamplang.runtime.geometry.attachments import looped
from tamplang.runtime.planner.motion.keyframes.initial_guesses import guess
from tamplang.runtime.planner.plan_assembly import module_record
from tamplang.runtime.planner.search.best_first import SkeletonSearch
from tamplang.runtime.planner.search.skeleton_replay import build_skeleton
from tamplang.runtime.skeleton import start_configuration
from tamplang.runtime.verify.inertia import centre_of
from tamplang.runtime.verify.kinematics import Kinematics

QUADRUPED = Path(__file__).resolve().parents[2] / "examples" / "quadruped.tamp"


@pytest.mark.parametrize("seed", [0, 3])
def test_four_crawlers_mount_a_plate_and_stand_up(seed: int) -> None:
    result = tamplang.load(QUADRUPED, seed=seed).solve(time=120.0)
    assert result.status == "solved" and result.plan is not None
    refused = {record.bound: record.refused for record in result.plan.record.statistics.bounds}
    assert refused["path"] == 0 and refused["seq-path"] <= 2, "loops are closed where a path leads to"
    assert [action.split("(")[0] for action in result.actions] == ["mount"] * 4 + ["standUp"]
    verdict = result.plan.verify()
    assert verdict.verified and verdict.worst["slip_m"] <= 2e-4
    plate = next(t for t in result.plan.record.tracks if t.name == "p")
    assert plate.poses[-1][2] - plate.poses[0][2] > 0.17


def test_first_guesses_leave_a_closed_loop_as_it_is_and_shake_what_is_open() -> None:
    problem = tamplang.load(QUADRUPED).problem
    search = SkeletonSearch(problem, Successors(problem), "astar", Budget(None))
    candidate = search.next()
    assert candidate is not None
    skeleton = build_skeleton(problem, candidate.actions, search.successors)
    start = start_configuration(problem)

    def moved(phase: int, steady: bool) -> set[str]:
        random = np.random.default_rng(0)
        before, after = guess(skeleton, range(phase + 1), start, random, 0.3, steady=steady)[-2:]
        return {name for name in before.modules if not np.allclose(before.modules[name][7:], after.modules[name][7:])}

    rising = len(skeleton) - 1
    legs = {name for name, module in problem.world.modules.items() if module.type.joints}
    assert moved(rising, False) >= legs and not moved(rising, True)
    assert moved(1, True) >= legs - looped(problem, skeleton.phases[1].mode)


def test_planner_and_verifier_agree_on_the_centre_of_mass() -> None:
    module = tamplang.load(QUADRUPED).problem.world.modules["c[1]"]
    row = Row("switch", Function("centre", (Var("X"),)), "=", Vector((Number(0.0),) * 3), 3)
    random = np.random.default_rng(0)
    slots = random.uniform(-1.0, 1.0, (5, 7 + len(module.type.joints)))
    slots[:, 3:7] /= np.linalg.norm(slots[:, 3:7], axis=1, keepdims=True)
    ours = stage(row, ("X",), (EffectorKind(module.type, "B", 0),)).values(slots, np.zeros((5, 0)))
    frames = Kinematics(module_record(module)).joint_frames(slots[:, :7], slots[:, 7:])
    mass, theirs = centre_of(module.type, frames, np.arange(5))
    assert np.abs(ours - theirs).max() < 1e-9
    assert 4.0 < mass < 10.0


def test_three_legs_are_too_few() -> None:
    assert tamplang.load(QUADRUPED, crawlers=3).solve(time=20.0).status == "infeasible"
