"""Brakes bear while their joint does not move: for the verifier, the planner, the report and in MuJoCo."""

from __future__ import annotations

import pytest

from tamplang.compiler.pipeline import compile_text
from tamplang.runtime.engine import carry_out
from tamplang.runtime.plan import Plan
from tamplang.runtime.planner.statics.bearing import exceeded
from tamplang.runtime.report.loads import build_loads
from tamplang.runtime.verify import verify

from .loaded import MOMENT, reaching

WEAK, HELD = "torque 1 N m", "torque 1 N m brake 3 N m"


def exceeded_joints(plan: Plan) -> set[str]:
    """What the planner finds too heavily loaded over the instants of a plan's only phase."""
    import numpy as np

    problem, _ = compile_text(plan.task.sources[0].text)
    (track,) = plan.tracks
    rows = np.hstack([np.array(track.poses), np.array(track.joints)])
    mode = frozenset((m.predicate, *m.args) for m in plan.phases[0].mode)
    bodies = {b.name: np.repeat([b.pose], len(rows), axis=0) for b in plan.bodies}
    found = exceeded(problem, mode, {"a": rows}, bodies, 0, ["then"] * len(rows))
    return {v.names[1] for v in found}


def test_a_brake_bears_what_the_drive_does_not_while_its_joint_rests() -> None:
    held = reaching(hoist=HELD)
    verdict = verify(held)
    assert verdict.verified and verdict.worst["torque_ratio"] == pytest.approx(MOMENT / 3.0, rel=1e-6)
    assert exceeded_joints(held) == set()
    loads = build_loads(held)
    assert loads is not None and loads.weakest is not None and loads.weakest.share == pytest.approx(MOMENT / 3.0)
    moving = reaching(lift=0.1, hoist=HELD)
    for plan in (moving, reaching(hoist=WEAK)):
        verdict = verify(plan)
        assert {f.kind for f in verdict.failures} == {"torque_ratio"} and verdict.worst["torque_ratio"] > 1.8
        assert exceeded_joints(plan) == {"lift"}


def test_in_the_engine_the_brake_holds_and_the_drive_alone_gives_way() -> None:
    for hoist, follows in ((HELD, True), (WEAK, False)):
        plan = reaching(hoist=hoist)
        carried = carry_out(compile_text(plan.task.sources[0].text)[0], plan)
        assert (carried.tracking < 5e-3) == follows
        peak, strength = carried.peaks["a", "lift"]
        assert peak == pytest.approx(MOMENT if follows else 1.0, rel=0.05) and strength == (3.0 if follows else 1.0)
