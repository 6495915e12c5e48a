"""What drives and feet bear, and where the mass is, in the report."""

from __future__ import annotations

import re

import pytest
from msgspec.structs import replace

from tamplang.runtime.report import render_report
from tamplang.runtime.report.loads import build_loads
from tamplang.runtime.report.support import build_support

from ..verify.loaded import MOMENT, reaching


def test_loads_stand_beside_their_limits_and_the_weakest_part_is_named() -> None:
    plan = reaching(hoist="torque 2.5 N m", holds="holds pad(force 1 kN, moment 20 N m, friction 0.8)")
    loads = build_loads(plan)
    assert loads is not None and loads.weakest is not None
    assert loads.weakest.name == "the drive of lift of a"
    assert loads.weakest.share == pytest.approx(MOMENT / 2.5, rel=1e-6)
    (lift,) = [p for m in loads.drives for p in m.plots if p.name == "lift"]
    assert lift.peak == f"{MOMENT:.3g} N m" and lift.limit == "of 2.5 N m" and len(lift.limits) == 2
    assert [text for _, text in lift.marks] == ["2.5 N m", "0", "−2.5"]
    assert [y for y, _ in lift.marks[::2]] == lift.limits
    (foot,) = loads.pairs
    assert [text for _, text in foot.marks] == ["100 %", "0"]
    assert foot.name == "a.foot and slab" and foot.share == pytest.approx(MOMENT / 20.0, rel=1e-6)
    (picture,) = build_support(plan)
    (robot,) = picture.robots
    # 1 kg of 4 goes from 10 to 20 cm beside a foot of 5 cm, and so the middle of mass from 2.5 cm to its edge.
    assert robot.mass[0] == pytest.approx((0.025, 0.0), abs=1e-4) and robot.mass[-1] == pytest.approx((0.05, 0.0))
    assert robot.inside == pytest.approx(0.0, abs=2e-3)
    section = render_report(plan).split('id="loads"')[1].split("</section>")[0]
    assert "Weakest part:" in section and "the drive of lift of a" in section
    assert "<span>pad</span>" in section  # one piece, which is not broken
    told = re.findall(r'class="mass" data-way="([^"]+)"', section)
    assert len(told) == 1 and len(told[0].split()) == 13


def test_without_physics_nothing_is_said_of_loads_and_nonsense_is_left_out() -> None:
    plain = reaching(physics="none")
    assert build_loads(plain) is None and build_support(plain) == [] and 'id="loads"' not in render_report(plain)
    plan = reaching(hoist="torque 2.5 N m", holds="holds pad(force 1 kN, moment 20 N m)")
    bad = [replace(w, phase=7, at="nobody", values=[[1.0]]) for w in plan.statics.wrenches]
    odd = [replace(w, at="nobody", values=[[1.0]], between=["a", "b"]) for w in plan.statics.wrenches]
    torques = [replace(t, values=[[1.0]]) for t in plan.statics.torques]
    spoilt = replace(plan, statics=replace(plan.statics, wrenches=[*bad, *odd], torques=torques))
    assert "<html" in render_report(spoilt)
