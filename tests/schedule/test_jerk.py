"""A limit of jerk, from the text of a module to the verifier."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace

from benchmarks.trust.checker import judge, read
from tamplang.api import Plan, loads
from tamplang.cli import run
from tamplang.compiler.pipeline import compile_text
from tamplang.langs.diagnostics import SourceError
from tamplang.runtime.verify import verify

ARM = """
import std.rules
module arm {{
    effector A: gripper sphere(4 cm) normal (0, 0, -1)
    joint j1: revolute(z) in -170 deg .. 170 deg{0}
    link 20 cm: capsule(3 cm)
    joint j2: revolute(y) in -130 deg .. 130 deg home 30 deg{0}
    link 30 cm: capsule(3 cm)
    joint j3: revolute(y) in -130 deg .. 130 deg home 60 deg{0}
    link 30 cm: capsule(3 cm)
    effector B: gripper sphere(4 cm)
    fact (linked A B)
}}
task t() {{
    base stand: box(30 cm, 30 cm, 10 cm) at (0, 0, -5 cm)
    object thing: sphere(4 cm) at (-10 cm, 45 cm, 45 cm)
    fact (grippable thing)
    arm a: A on stand
    goal (held thing)
}}
"""


def greatest(plan: Plan) -> float:
    found = 0.0
    for spline in plan.record.splines:
        knots, values = np.asarray(spline.knots), np.asarray(spline.values)
        from scipy.interpolate import CubicSpline

        found = max(found, float(np.abs(6.0 * CubicSpline(knots, values, bc_type="clamped").c[0]).max()))
    return found


@pytest.mark.parametrize("objective", ["actions", "makespan"])
def test_plans_keep_the_jerk_that_is_stated(objective: str) -> None:
    free = loads(ARM.format("")).solve(time=120, minimise=objective).plan
    kept = loads(ARM.format(" jerk 15 rad/s^3")).solve(time=120, minimise=objective).plan
    assert free is not None and kept is not None
    assert greatest(free) > 20.0 and greatest(kept) <= 15.0 * 1.001
    assert kept.record.times[-1] > free.record.times[-1]
    assert kept.record.needs == ["jerk"] and free.record.needs == []
    assert "joint_jerk_rad_s3" in kept.verify().worst
    assert judge(read(_text(kept))) == []
    fast = [replace(s, knots=[0.7 * k for k in s.knots]) for s in kept.record.splines]
    phases = [replace(p, start=0.7 * p.start, end=0.7 * p.end) for p in kept.record.phases]
    hasty = replace(kept.record, splines=fast, phases=phases, times=[0.7 * t for t in kept.record.times])
    assert "joint_jerk_rad_s3" in {f.kind for f in verify(hasty).failures}


def _text(plan: Plan) -> str:
    import msgspec

    return msgspec.json.encode(plan.record).decode()


@pytest.mark.parametrize(
    ("limit", "code"), [(" jerk 0 rad/s^3", "E0508"), (" jerk 3 m/s^3", "E0203"), (" jerk 5 rad/s^2", "E0203")]
)
def test_a_jerk_that_makes_no_sense_is_told(limit: str, code: str) -> None:
    with pytest.raises(SourceError) as caught:
        compile_text(ARM.format(limit))
    assert code in {d.code for d in caught.value.diagnostics}


@pytest.mark.parametrize("what", ["speed 1e-30 rad/s", "acceleration 1e-20 rad/s^2", "jerk 1e-24 rad/s^3"])
def test_a_limit_that_no_plan_can_keep_is_refused_before_it_is_tried(
    what: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "slow.tamp"
    file.write_text(ARM.format(f" {what}").replace("{{", "{").replace("}}", "}"), encoding="utf-8")
    assert run(["solve", str(file), "--minimise", "makespan", "--out", str(tmp_path / "slow.plan.json")]) == 1
    told = capsys.readouterr().err
    assert "E0508" in told and "116 days or more for 1 rad" in " ".join(told.split())
    assert not (tmp_path / "slow.plan.json").exists()


def test_a_jerk_that_is_kept_only_slowly_is_kept() -> None:
    plan = loads(ARM.format(" jerk 1e-6 rad/s^3")).solve(time=120).plan
    assert plan is not None and plan.record.times[-1] > 300.0
    assert greatest(plan) <= 1e-6 * 1.001


def test_without_a_statement_there_is_no_limit() -> None:
    problem, _ = compile_text(ARM.format(""))
    assert all(math.isinf(j.jerk) for j in problem.world.modules["a"].type.joints)
