"""What `solve` found: as files, as JSON and as lines for a terminal."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from ..langs.counting import counted
from ..runtime.budget import Status
from .limits import unfinished_report
from .outputs import numbered
from .plans import standing, verdict_lines
from .sources import as_objects, as_text, show_diagnostics

if TYPE_CHECKING:
    from ..api import Plan, Result
    from ..compiler.ir import Problem
    from ..runtime.plan import ObjectiveRecord, StatisticsRecord, TimingRecord


@dataclass(frozen=True, slots=True)
class Written:
    """The files that stand: a plan file for each plan, best first, the report of the best, and a refused plan that was
    asked for."""

    plans: tuple[Path, ...]
    report: Path | None
    refused: Path | None = None


class Keeper:
    """Writes the best plans as they are found, at most so many, so that none is lost; `write` puts them in order at the
    end. Raises OSError."""

    def __init__(self, plan_file: Path, most: int) -> None:
        self._plan_file, self._most = plan_file, most
        self._kept: list[tuple[float, Plan]] = []

    def __call__(self, plan: Plan) -> None:
        told = objective_of(plan.record.statistics)
        worth = 0.0 if told is None else told.value
        place = bisect_right(self._kept, worth, key=lambda kept: kept[0])
        self._kept.insert(place, (worth, plan))
        del self._kept[self._most :]
        for number, (_, better) in enumerate(self._kept[place:], place + 1):
            better.save(numbered(self._plan_file, number))

    def leave(self, count: int) -> None:
        """Remove the files that were written beyond so many."""
        for number in range(count + 1, len(self._kept) + 1):
            numbered(self._plan_file, number).unlink(missing_ok=True)


def write(
    problem: Problem, result: Result, plan_file: Path, report_file: Path | None, refused_file: Path | None
) -> Written:
    """Write every plan, and the report of the best, or of what was found out where there is none, where there is time
    for it. Raises OSError."""
    files = tuple(numbered(plan_file, number) for number in range(1, len(result.plans) + 1))
    for plan, file in zip(result.plans, files, strict=True):
        plan.save(file)
    if result.refused is not None and refused_file is not None:
        result.refused.save(refused_file)
    kept = refused_file if result.refused is not None else None
    if report_file is None:
        return Written(files, None, kept)
    if result.plan is not None:
        return Written(files, report_in_time(result.plan.report, report_file), kept)
    return Written(files, report_in_time(partial(_report_without_plan, problem, result), report_file), kept)


def _report_without_plan(problem: Problem, result: Result, file: Path) -> None:
    """The report of a solve without a verified plan: the refused one, or the scene at the start. Raises OSError."""
    from ..runtime.planner.plan_assembly import scene_at_rest
    from ..runtime.report import write_report
    from ..runtime.report.ending import ending_of

    if result.refused is not None:
        result.refused.report(file)
        return
    drawn = scene_at_rest(problem, result.statistics, result.timing)
    ending = None
    if result.status != Status.SOLVED:
        ending = ending_of(problem, result.status, result.explanation, result.misses, drawn)
    write_report(drawn, file, ending=ending)


def report_in_time(report: Callable[[Path], None], file: Path) -> Path | None:
    """Write the report, if time and memory are enough; the file, if so. Raises OSError."""
    from ..runtime.budget import unless_spent
    from ..runtime.guard import closing

    def work() -> Path:
        closing()
        report(file)
        return file

    written = unless_spent(work)
    if written is None:
        show_diagnostics([unfinished_report(file)])
    return written


def result_json(problem: Problem, result: Result, written: Written, compile_seconds: float) -> dict[str, object]:
    """The object that `solve --json` prints; `docs/cli.md` lists its fields."""
    statistics = result.statistics
    plan = result.plan or result.refused
    verdict = plan.record.verdict if plan is not None else None
    return {
        "status": result.status,
        "task": problem.task,
        "parameters": dict(problem.parameters),
        "seed": problem.seed,
        "actions": list(result.actions),
        "length": len(result.actions),
        "optimal": True if statistics.optimal else statistics.gap,
        "tree_nodes": statistics.tree_nodes,
        "expanded_nodes": statistics.expanded_nodes,
        "bounds": {b.bound: {"solved": b.solved, "refused": b.refused} for b in statistics.bounds},
        "cost": result.cost,
        "objective": objective_json(plan.record.statistics if plan is not None else None),
        "seconds": _seconds(result.timing, compile_seconds),
        **standing(verdict, plan is not None and plan.record.complete),
        "worst": verdict.worst if verdict is not None else {},
        "plan": str(written.plans[0]) if written.plans else None,
        "plans": [str(file) for file in written.plans],
        "refused": str(written.refused) if written.refused is not None else None,
        "report": str(written.report) if written.report is not None else None,
        "explanation": as_objects(result.explanation),
    }


def objective_of(statistics: StatisticsRecord | None) -> ObjectiveRecord | None:
    """What a plan was to be best at, where it was another thing than the cost of its actions."""
    from ..runtime.plan import ObjectiveRecord

    told = None if statistics is None else statistics.objective
    return told if isinstance(told, ObjectiveRecord) else None


def objective_json(statistics: StatisticsRecord | None) -> dict[str, object] | None:
    """The value of the objective, its measures and bounds, or None without one."""
    told = objective_of(statistics)
    if told is None:
        return None
    gap = {name: told.value - bound for name, bound in told.bounds.items()}
    return {"minimise": told.minimise, "value": told.value, "unit": told.unit, "measures": told.measures,
            "bounds": told.bounds, "gap": gap}  # fmt: skip


def objective_line(told: ObjectiveRecord) -> str:
    """The value, and how far it may be above the least one."""
    unit = f" {told.unit}" if told.unit else ""
    bounds = [f"at least {bound:.4g}{unit} for {name}, gap {told.value - bound:.3g}{unit}"
              for name, bound in told.bounds.items() if bound]  # fmt: skip
    return f"{told.minimise}: {told.value:.4g}{unit}" + (f" ({'; '.join(bounds)})" if bounds else "")


def _seconds(timing: TimingRecord, compile_seconds: float) -> dict[str, float]:
    """Seconds by stage, with the time that reading the program took; every stage is there, 0 where it did not run."""
    stages = dict.fromkeys(("total", "compile", "search", "seq", "seq_path", "path", "verify"), 0.0)
    stages |= {stage.replace("-", "_"): seconds for stage, seconds in timing.seconds.items()}
    stages["total"] += compile_seconds
    stages["compile"] += compile_seconds
    return {stage: round(seconds, 4) for stage, seconds in stages.items()}


HEADLINES = {
    Status.SOLVED: "solved",
    Status.INFEASIBLE: "infeasible: it is proved that there is no plan",
    Status.EXHAUSTED: "exhausted: every candidate was refused",
    Status.BUDGET: "the budget is spent",
    Status.MEMORY: "the memory is spent",
    Status.REFUSED: "the verifier refuses the plan",
    Status.INTERRUPTED: "interrupted",
}


def result_lines(problem: Problem, result: Result, written: Written) -> list[str]:
    """What a person wants to know, on a terminal."""
    lines = [f"{problem.task}: {HEADLINES[result.status]}"]
    lines += [f"  {number:2}  {action}" for number, action in enumerate(result.actions, start=1)]
    if result.status == Status.SOLVED and not result.actions:
        lines.append("  the goal holds at the start: nothing is to be done")
    if result.actions:
        lines.append(f"{counted(len(result.actions), 'action')}, cost {result.cost:g}{_quality(result.statistics)}")
    plan = result.plan or result.refused
    told = objective_of(None if plan is None else plan.record.statistics)
    lines += [] if told is None else [objective_line(told)]
    lines.append(_effort(result.statistics, result.timing))
    if plan is not None and plan.record.verdict is not None:
        lines += verdict_lines(plan.record.verdict)
    if result.explanation:
        lines.append(as_text(result.explanation, "full", problem.sources))
    lines += [f"plan: {file}" for file in written.plans]
    lines += [] if written.refused is None else [f"refused plan: {written.refused}"]
    if written.report is not None:
        lines.append(f"report: {written.report}")
    return lines


def _quality(statistics: StatisticsRecord) -> str:
    """How far the cost may be above the optimum."""
    if statistics.optimal:
        return ", optimal"
    return "" if statistics.gap is None else f", at most {statistics.gap:g} above the optimum"


def _effort(statistics: StatisticsRecord, timing: TimingRecord) -> str:
    """Seconds, nodes and bounds in one line."""
    parts = [f"{timing.seconds.get('total', 0.0):.1f} s", f"{statistics.tree_nodes} tree nodes"]
    parts += [f"{b.bound}: {b.solved} solved, {b.refused} refused" for b in statistics.bounds]
    return "; ".join(parts)
