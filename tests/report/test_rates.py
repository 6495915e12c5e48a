"""Curves of speeds and accelerations are those of the plan's splines, and stand beside the limits of joints."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from tamplang.runtime.plan import Plan, SplineRecord
from tamplang.runtime.report.rates import build_rates
from tamplang.runtime.report.render import render_report

from .sample import climb_plan


def splined() -> Plan:
    """A plan whose first module goes through five knots."""
    plan = climb_plan()
    module, end = plan.modules[0], plan.times[-1]
    values = np.outer([0.0, 0.2, 0.5, 0.4, 0.1], np.linspace(0.5, 1.0, len(module.joints)))
    spline = SplineRecord(module.name, 0, len(plan.phases) - 1, np.linspace(0.0, end, 5).tolist(), values.tolist())
    return msgspec.structs.replace(plan, splines=[spline])


def test_peaks_are_those_of_the_splines() -> None:
    plan = splined()
    (module, *_) = build_rates(plan)
    splines = [s for s in plan.splines if s.module == module.name]
    joints = [j.name for j in next(m for m in plan.modules if m.name == module.name).joints]
    assert splines and {p.quantity for p in module.plots} == {"speed", "acceleration"}
    for plot in module.plots:
        column, order = joints.index(plot.joint), 1 if plot.quantity == "speed" else 2
        exact = 0.0
        for spline in splines:
            curve = CubicSpline(spline.knots, np.array(spline.values)[:, column], bc_type="clamped")
            times = np.linspace(spline.knots[0], spline.knots[-1], 2000)
            exact = max(exact, float(np.abs(curve(times, order)).max()))
        assert plot.peak == pytest.approx(exact, rel=0.1) and plot.peak <= exact + 1e-9
        assert plot.limit_y < 50.0 < plot.lower_y


def test_the_page_has_the_curves_with_limits() -> None:
    page = render_report(splined())
    assert 'id="rates"' in page and "acceleration of j" in page
    first = build_rates(splined())[0].plots[0]
    assert [text for _, text in first.marks] == [f"{first.limit:.3g} rad/s", "0", f"−{first.limit:.3g}"]
    section = page.split('id="rates"')[1].split("</section>")[0]
    for y, text in first.marks:
        assert f'<span style="top:{y}%">{text}</span>' in section
    assert f"<span>0</span><span>{splined().times[-1]:.3g} s</span>" in section
