"""What notebooks show of tasks, plans and results: HTML that works offline."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .api import Result, RunResult, Task
    from .langs.diagnostics import Diagnostic
    from .plans import Plan
    from .runtime.plan import Plan as PlanRecord
    from .runtime.plan import VerdictRecord

HEIGHT = 720
"""Pixels of the frame of a replay: the picture, its controls, and a few lanes of the timeline."""


def task_html(task: Task) -> str:
    """What there is, the goal, and the scene at the start."""
    from .runtime.plan import StatisticsRecord, TimingRecord
    from .runtime.planner.plan_assembly import scene_at_rest

    record = scene_at_rest(task.problem, StatisticsRecord(), TimingRecord())
    given = ", ".join(f"{name} = {value:g}" for name, value in record.task.parameters.items())
    goal = f"<p>goal <code>{escape(record.task.goal)}</code></p>"
    return _head(repr(task), given) + goal + diagnostics_html(task.warnings) + replay_html(record)


def plan_html(plan: Plan) -> str:
    """The actions in order, the verdict, and the replay."""
    record = plan.record
    rows = "".join(
        f"<tr><td>{number}</td><td>{p.start:.2f} s</td><td style='text-align:left'><code>{escape(p.action)}</code>"
        f"{'' if p.completed else ' (broken off)'}</td></tr>"
        for number, p in enumerate(record.phases, 1)
    )
    table = f"<table><tr><th></th><th>from</th><th style='text-align:left'>action</th></tr>{rows}</table>"
    return _head(repr(plan), verdict_text(record.verdict, plan.fresh)) + table + replay_html(record)


def result_html(result: Result) -> str:
    """The best plan, or what refused the task."""
    shown = result.plan or result.refused
    head = _head(repr(result), "") + diagnostics_html(result.explanation)
    return head + ("" if shown is None else plan_html(shown))


def run_html(result: RunResult) -> str:
    """How it ended, and what was carried out."""
    return _head(repr(result), "") + diagnostics_html(result.explanation) + plan_html(result.plan)


def diagnostics_html(diagnostics: Sequence[Diagnostic]) -> str:
    """Messages as they stand on a terminal, where there are some."""
    return "".join(d._repr_html_() for d in diagnostics)


def verdict_text(verdict: VerdictRecord | None, fresh: bool) -> str:
    """The verdict in words; one from a file is told as what it is."""
    if verdict is None:
        return "not verified"
    told = "refused: " + "; ".join(f.message for f in verdict.failures[:3])
    if verdict.verified:
        told = "verified" if verdict.goal_reached else "motion verified, goal not reached"
    return told if fresh else f"{told} (as the file says; plan.verify() checks it)"


def replay_html(record: PlanRecord) -> str:
    """The replay in a frame of its own, which needs no network and cannot reach the notebook."""
    from .runtime.report.render import render_replay

    page = escape(render_replay(record), quote=True)
    style = f"width:100%;height:{HEIGHT}px;border:1px solid #8884"
    return f'<iframe title="replay" sandbox="allow-scripts" style="{style}" srcdoc="{page}"></iframe>'


def _head(title: str, told: str) -> str:
    more = f": {escape(told)}" if told else ""
    return f"<p><b>{escape(title[1:-1])}</b>{more}</p>"
