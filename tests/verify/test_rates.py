"""Speeds and accelerations of joints, as the checker measures them."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest

from tamplang.compiler import ir
from tamplang.compiler.pipeline import compile_text
from tamplang.runtime.plan import Plan
from tamplang.runtime.plan_files import read_plan
from tamplang.runtime.plan_upgrade import EarlyPlan
from tamplang.runtime.verify import check, verify

from .motions import Maker

TEXT = """
import std.crawler
predicate (waved c: module)
rule wave(c: module) {
    pre   not (waved c)
    post  (waved c)
}
task wave() {
    object slab: box(0.2 m, 0.2 m, 0.05 m) at (0, 0, 0)
    crawler c: A on slab
    goal (waved c)
}
"""


def wave(joint: int = 6, seconds: float = 8.0, samples: int = 2) -> Plan:
    """One joint turns by 3 rad, by a spline through 0, 1.5 and 3 rad."""
    maker = Maker(TEXT, "wave")
    maker.phase("wave", ("c",), [maker.now.modules["c"][7:] + 3.0 * np.eye(7)[joint]], seconds=seconds, samples=samples)
    return maker.plan()


def limited(**limits: float) -> ir.Problem:
    """The task with other limits of its joints."""
    problem, _ = compile_text(TEXT, "wave.tamp", "wave")
    crawler = problem.world.modules["c"]
    kind = replace(crawler.type, joints=tuple(replace(j, **limits) for j in crawler.type.joints))
    return replace(problem, world=replace(problem.world, modules={"c": replace(crawler, type=kind)}))


def with_limits(plan: Plan, **limits: float) -> Plan:
    """The plan file of the task with these limits."""
    module = plan.modules[0]
    joints = [msgspec.structs.replace(joint, **limits) for joint in module.joints]
    return msgspec.structs.replace(plan, modules=[msgspec.structs.replace(module, joints=joints)])


def test_rates_are_those_of_the_spline() -> None:
    """Half way the speed is 3/4 of 3 rad in 4 s, and the acceleration at the ends is a quarter of twice that."""
    worst = verify(wave()).worst
    assert worst["joint_speed_rad_s"] == pytest.approx(0.5625)
    assert worst["joint_acceleration_rad_s2"] == pytest.approx(0.28125)
    assert "joint_speed_m_s" not in worst and "joint_acceleration_m_s2" not in worst


def test_the_speed_between_two_knots_is_that_of_the_curve_not_of_samples() -> None:
    """A spline with knots at its ends only is fastest half way: 3/2 of 3 rad in 8 s."""
    assert verify(wave(samples=1)).worst["joint_speed_rad_s"] == pytest.approx(0.5625, rel=1e-12)


@pytest.mark.parametrize(("name", "peak"), [("speed", 0.5625), ("acceleration", 0.28125)])
def test_a_limit_is_kept_to_a_thousandth(name: str, peak: float) -> None:
    for limit, kept in ((peak / 1.0005, True), (peak / 1.002, False)):
        verdict = check(with_limits(wave(), **{name: limit}), limited(**{name: limit}))
        assert verdict.verified is kept
        assert [(f.kind.rpartition("_rad")[0], f.between) for f in verdict.failures[:1]] == (
            [] if kept else [(f"joint_{name}", ["c", "j7"])]
        )
        measure = next(m for m in verdict.measures if m.kind.startswith(f"joint_{name}"))
        assert measure.limit == pytest.approx(limit) and measure.unit in ("rad/s", "rad/s²")


def test_a_file_that_states_another_limit_than_the_task_is_refused() -> None:
    verdict = check(with_limits(wave(), acceleration=0.3), limited(acceleration=0.29))
    assert {f.kind for f in verdict.failures} == {"scene"}


def test_a_file_from_before_there_were_accelerations_is_judged_by_the_task() -> None:
    data = msgspec.to_builtins(wave())
    for joint in data["modules"][0]["joints"]:
        del joint["acceleration"]
    old = msgspec.convert(data, EarlyPlan)
    assert check(old, limited(acceleration=0.3)).verified
    assert {f.kind for f in check(old, limited(acceleration=0.2)).failures} == {"joint_acceleration_rad_s2"}
    new = check(msgspec.convert(data, Plan), limited(acceleration=0.3))
    assert ("scene", "joint j7 of c differs from the scene") in [(f.kind, f.message) for f in new.failures]


def test_only_files_of_format_1_may_lack_accelerations(tmp_path: Path) -> None:
    data = json.loads((Path(__file__).parent / "format_1.plan.json").read_text(encoding="utf-8"))
    for early in (False, True):
        for module in data["modules"]:
            for joint in module["joints"]:
                joint.pop("acceleration") if early else None
        (tmp_path / "plan.json").write_text(json.dumps(data), encoding="utf-8")
        plan = read_plan(tmp_path / "plan.json")
        assert isinstance(plan, EarlyPlan) is early and verify(plan).verified


def test_samples_on_the_way_at_another_time_are_refused() -> None:
    """Time stamps squeezed in the middle of the phase."""
    data = msgspec.to_builtins(wave())
    data["times"][5] = data["times"][4] + 1e-3
    failures = verify(msgspec.convert(data, Plan)).failures
    assert {f.kind for f in failures} == {"spline_rad"}
