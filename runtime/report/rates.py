"""How fast joints move and speed up, beside their limits, from the splines of a plan."""

from __future__ import annotations

import numpy as np

from ...langs.frozen import dataclass
from ..geometry.splines import ClampedSpline
from ..plan import NO_LIMIT, JointRecord, Plan
from ..skeleton import Array

POINTS = 160
"""How many instants of a plan a curve shows: about what a plot is wide on a screen."""


@dataclass(frozen=True, slots=True)
class RatePlot:
    """One quantity of one joint over time in a box of 1000 by 100. `highest` stands at its upper edge, minus that at
    its lower one; `limit_y` and `lower_y` are where plus and minus the limit lie."""

    joint: str
    quantity: str
    unit: str
    path: str
    peak: float
    limit: float
    highest: float
    limit_y: float
    lower_y: float

    @property
    def marks(self) -> list[tuple[float, str]]:
        """Where numbers stand at the axis, in percent from above, and what they say."""
        shown = self.limit if self.limit < NO_LIMIT else self.peak
        return [(self.limit_y, f"{shown:.3g} {self.unit}"), (50.0, "0"), (self.lower_y, f"−{shown:.3g}")]


@dataclass(frozen=True, slots=True)
class ModuleRates:
    name: str
    plots: list[RatePlot]


def build_rates(plan: Plan) -> list[ModuleRates]:
    """Speed and acceleration of every joint that moves, module by module."""
    total = plan.times[-1] if plan.times else 0.0
    if total <= 0.0:
        return []
    times = np.linspace(0.0, total, POINTS)
    found = []
    for module in plan.modules:
        rates = _rates(plan, module.name, times, len(module.joints))
        if rates is None:
            continue
        plots = [
            _plot(joint, quantity, times / total, values[:, column])
            for column, joint in enumerate(module.joints)
            for quantity, values in zip(("speed", "acceleration"), rates, strict=True)
            if np.abs(values[:, column]).max() > 1e-6
        ]
        found += [ModuleRates(module.name, plots)] if plots else []
    return found


def _rates(plan: Plan, module: str, times: Array, joints: int) -> tuple[Array, Array] | None:
    """First and second derivatives `(T, joints)` of the joints of a module, zero where no spline tells of it."""
    splines = [s for s in plan.splines if s.module == module and len(s.knots) > 1]
    if not splines or any(len(row) != joints for s in splines for row in s.values):
        return None
    both = np.zeros((len(times), joints)), np.zeros((len(times), joints))
    for spline in splines:
        curve = ClampedSpline(spline.knots, spline.values)
        inside = (times >= spline.knots[0]) & (times <= spline.knots[-1])
        for order, rows in enumerate(both, start=1):
            rows[inside] = curve(times[inside], order)
    return both


def _plot(joint: JointRecord, quantity: str, across: Array, values: Array) -> RatePlot:
    limit = joint.speed if quantity == "speed" else joint.acceleration
    peak = float(np.abs(values).max())
    shown = limit if limit < NO_LIMIT else peak
    highest = 1.06 * max(shown, peak)

    def height(value: float) -> float:
        return round(50.0 - 50.0 * value / highest, 2)

    unit = ("rad" if joint.kind == "revolute" else "m") + ("/s" if quantity == "speed" else "/s²")
    path = " ".join(f"{1000.0 * x:.1f},{height(float(v))}" for x, v in zip(across, values, strict=True))
    return RatePlot(joint.name, quantity, unit, path, peak, limit, highest, height(shown), height(-shown))
