"""Plans as data frames and figures, for notebooks; pandas and matplotlib come with the extra `notebook`."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from io import BytesIO
from typing import Any

import numpy as np

from .langs.diagnostics import UsageError
from .runtime.export.motion import module_of, times, trajectory
from .runtime.native import load_extra
from .runtime.plan import NO_LIMIT, Plan

WIDE, HIGH = 8.0, 1.8
"""Inches of a figure, and of each of its rows."""
STILL = 1e-9
"""Radians or metres: joints that move less are not drawn."""


def dataframe(plan: Plan, rate: float | None) -> Any:
    """A pandas.DataFrame of the columns of a CSV file."""
    from .runtime.export.tables import columns

    pandas = load_extra("pandas", "notebook")
    found = columns(plan, rate)
    index = pandas.Index(found.pop("time"), name="time")
    return pandas.DataFrame(found, index=index)


def joints_figure(plan: Plan, names: Sequence[str]) -> Any:
    """Values of joints over time, a row for each module, limits dashed, switches as thin lines."""
    t = times(plan)
    shown = [(module_of(plan, n), trajectory(plan, n, t)) for n in names or [m.name for m in plan.modules]]
    if not names:
        shown = [(m, x) for m, x in shown if x.q.size and np.ptp(x.q, axis=0).max() > STILL]
    if not shown:
        raise UsageError("no joint of the plan moves")
    figure, rows = _rows(plan, [module.name for module, _ in shown])
    for axes, (module, motion) in zip(rows, shown, strict=True):
        for k, joint in enumerate(module.joints):
            (line,) = axes.plot(motion.t, motion.q[:, k], label=joint.name)
            for limit in (joint.lower, joint.upper):
                if abs(limit) < NO_LIMIT:
                    axes.axhline(limit, color=line.get_color(), linestyle=":", linewidth=0.7)
        axes.set_ylabel("rad or m")
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize="small")
    return figure


def clearance_figure(plan: Plan) -> Any:
    """The clearance of each module over time, the least one marked and named."""
    from .runtime.report.clearance import clearances

    shown = [c for c in clearances(plan) if np.isfinite(c.distance).any()]
    if not shown:
        raise UsageError("nothing of the plan is near anything else")
    figure, rows = _rows(plan, [c.module for c in shown])
    for axes, curve in zip(rows, shown, strict=True):
        axes.plot(curve.times, 1000.0 * np.where(np.isfinite(curve.distance), curve.distance, np.nan))
        worst = int(curve.distance.argmin())
        axes.plot(curve.times[worst], 1000.0 * curve.distance[worst], "o")
        first, second = curve.between[worst]
        told = f"{1000.0 * curve.distance[worst]:.1f} mm between {first} and {second}"
        axes.set_title(f"{curve.module}: at least {told}", fontsize="small", loc="left")
        axes.axhline(0.0, color="0.5", linestyle=":")
        axes.set_ylabel("mm")
    return figure


def _rows(plan: Plan, titles: Sequence[str]) -> tuple[Any, list[Any]]:
    """A figure with a row for each title; no window is opened, and nothing global is changed."""
    figure = load_extra("matplotlib.figure", "notebook").Figure(
        figsize=(WIDE, HIGH * len(titles) + 0.5), layout="constrained"
    )
    rows = list(figure.subplots(len(titles), 1, sharex=True, squeeze=False)[:, 0])
    for axes, title in zip(rows, titles, strict=True):
        axes.set_title(title, fontsize="small", loc="left")
        for phase in plan.phases:
            axes.axvline(phase.end, color="0.85", linewidth=0.8)
    rows[-1].set_xlabel("s")
    figure._repr_png_ = partial(_png, figure)
    return figure, rows


def _png(figure: Any) -> bytes:
    """What a notebook shows: of figures that pyplot did not make it would print the name only."""
    content = BytesIO()
    figure.savefig(content, format="png", dpi=100)
    return content.getvalue()
