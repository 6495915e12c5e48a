"""The clearance of modules over time, against distances of spheres that are known."""

from __future__ import annotations

import re
from itertools import pairwise

import numpy as np
import pytest
from msgspec.structs import replace

from tamplang.runtime.plan import BodyRecord, Plan, ShapeRecord
from tamplang.runtime.report import render_report
from tamplang.runtime.report.clearance import build_clearance, clearances

from .sample import climb_plan, dock_plan, tip


def with_ball(plan: Plan, at: list[float]) -> Plan:
    ball = BodyRecord("ball", "object", ShapeRecord("sphere", [0.01]), [*at, 0.0, 0.0, 0.0, 1.0], False)
    return replace(plan, bodies=[*plan.bodies, ball])


def test_a_ball_beside_the_way_is_told_with_its_distance_and_moment() -> None:
    plan = climb_plan()
    free = clearances(plan)[0]
    assert "ball" not in {name for pair in free.between for name in pair}
    k = int(free.distance.argmax())
    moment = float(free.times[k])
    assert free.distance[k] > 0.004
    module, track, sample = plan.modules[0], plan.tracks[0], plan.times.index(moment)
    end = next(e for e in module.effectors if e.name == "B")
    assert end.shape is not None and end.shape.kind == "sphere"
    at = tip(module, np.array([track.poses[sample]]), np.array([track.joints[sample]]))[0, :3]
    near = clearances(with_ball(plan, [at[0], at[1], at[2] + end.shape.size[0] + 0.01 + 0.003]))[0]
    assert "ball" in near.between[k] and near.distance[k] <= 0.003 + 1e-9
    inside = clearances(with_ball(plan, at.tolist()))[0]
    assert inside.distance[k] == pytest.approx(-end.shape.size[0] - 0.01, abs=1e-6)
    assert inside.between[k] == (f"c[1].{end.name}", "ball")


def test_joined_modules_are_no_obstacles_to_each_other() -> None:
    plan = dock_plan()
    found = clearances(plan)
    last = plan.phases[-1].start
    for curve in found:
        pairs = [p for t, p in zip(curve.times, curve.between, strict=True) if t > last + 1e-6]
        assert pairs and not any({"c[1]", "c[2]"} <= {re.split(r"[.,]", n)[0] for n in p} for p in pairs)


def test_the_page_tells_where_and_when() -> None:
    page = render_report(climb_plan())
    section = page.split('id="clearance"')[1].split("</section>")[0]
    assert "between c[1]" in section and "data-seek" in section
    points = re.findall(r'points="([^"]+)"', section)[0].split()
    assert all(float(b.split(",")[0]) >= float(a.split(",")[0]) for a, b in pairwise(points))
    for plot in build_clearance(climb_plan()):
        numbers = {text: y for y, text in plot.marks}
        heights = [float(point.split(",")[1]) for point in plot.path.split()]
        (top,) = (text for text in numbers if text.endswith(" m"))
        assert numbers["0"] == plot.zero_y and numbers[top] == min(heights) and top in section
