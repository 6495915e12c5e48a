"""The commands `verify` and `report`: what can be done with a plan file."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from .interrupt import kept_interrupt
from .libraries import needing_libraries
from .limits import limit_options, limited
from .outputs import checked_output
from .sources import SourceFailure, reading_sources
from .status import ExitStatus

if TYPE_CHECKING:
    from ..compiler.ir import Problem
    from ..runtime.plan import Plan, VerdictRecord


AT_REST = "what moves or fails by itself in the task is left out"
MOST_UNMET = 4
"""So many parts of a goal are told in a line."""


@click.command()
@click.argument("file", metavar="PLAN.json", type=click.Path(path_type=Path))
@limit_options
@click.option("--against", metavar="FILE.tamp", type=click.Path(path_type=Path),
              help="Refuse the plan where its task is not the one of this file.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def verify(file: Path, seconds: float, memory: int | None, against: Path | None, as_json: bool) -> int:
    """Check a plan from its file alone, with none of the planner's code.

    Says what it was checked against: the texts that the plan itself holds, or, with --against, a file of yours.
    """
    from ..runtime.verify.provenance import basis

    with limited(seconds, memory, f"checking {file}: there is no verdict", as_json) as guard:
        plan = read(file, as_json)
        own = None if against is None else _own_task(plan, against, as_json)
        verdict = _verdict(plan, guard.remaining, own)
        told = basis(plan)
    if as_json:
        click.echo(json.dumps({
            **verdict_json(verdict, plan.complete), **told, "against": None if against is None else str(against),
        }))  # fmt: skip
    else:
        click.echo("\n".join([*verdict_lines(verdict), *_basis_lines(told, against)]))
    if not verdict.verified:
        click.echo("`tamplang explain S0004` tells what a refusal means", err=True)
        return ExitStatus.REFUSED
    return ExitStatus.DONE if verdict.goal_reached else ExitStatus.UNFINISHED


def _own_task(plan: Plan, file: Path, as_json: bool) -> Problem:
    """The plan's task as a file of the reader's has it, with the same parameters and seed."""
    from ..compiler.pipeline import compile_sources
    from ..langs.reader import read_source
    from ..runtime.plan_parameters import parameter_texts

    with reading_sources(as_json=as_json):
        sources = [read_source(file)]
        return compile_sources(sources, plan.task.name, parameter_texts(plan, sources), plan.task.seed)[0]


def _verdict(plan: Plan, seconds: float, against: Problem | None = None) -> VerdictRecord:
    """The verdict on a plan. Raises OutOfTime when the time is not enough."""
    from ..runtime.budget import Budget

    with needing_libraries(), kept_interrupt() as check:
        from ..runtime.verify import verify as verified

        check()
        verdict = verified(plan, Budget(seconds), against)
        check()
    return verdict


@click.command()
@click.argument("file", metavar="PLAN.json", type=click.Path(path_type=Path))
@click.argument("other", metavar="[OTHER.json]", required=False, type=click.Path(path_type=Path))
@click.option("-o", "--out", type=click.Path(path_type=Path), required=True, help="The HTML file to write.")
@limit_options
@click.option("--unchecked", is_flag=True, help="Show the verdict that stands in the file, and say so.")
def report(
    file: Path, other: Path | None, out: Path, seconds: float, memory: int | None, unchecked: bool
) -> None:
    """Write the report of a plan, or of two beside each other: one HTML file that works offline. Plans are verified
    anew."""
    from msgspec.structs import replace

    files = (file,) if other is None else (file, other)
    checked_output(out, inputs=files)
    with limited(seconds, memory, f"drawing {file}") as guard, needing_libraries():
        plans = [read(f) for f in files]
        if not unchecked:
            plans = [replace(plan, verdict=_verdict(plan, guard.remaining)) for plan in plans]
        if other is None:
            from ..runtime.report import write_report

            write_report(plans[0], out, checked=not unchecked)
        else:
            from ..runtime.report.compare import write_comparison

            write_comparison(plans[0], plans[1], (str(file), str(other)), out, checked=not unchecked)
    for plan in plans:
        if plan.verdict is not None and not unchecked:
            click.echo(headline(plan.verdict), err=True)
    click.echo(f"report: {out}", err=True)


def read(file: Path, as_json: bool = False) -> Plan:
    """The plan in `file`. Raises SourceFailure (status 1) when it is no plan file."""
    from ..runtime.plan_files import PlanFileError, read_plan

    try:
        return read_plan(file)
    except PlanFileError as error:
        raise SourceFailure([error.diagnostic], as_json) from error


def verdict_json(verdict: VerdictRecord, complete: bool) -> dict[str, object]:
    """What `verify --json` tells of a verdict; `complete` is what the plan says of itself."""
    import msgspec

    return {
        **standing(verdict, complete),
        "worst": verdict.worst,
        "failures": msgspec.to_builtins(verdict.failures),
    }


def standing(verdict: VerdictRecord | None, complete: bool) -> dict[str, object]:
    """How a plan stands, as `verify`, `solve` and `run` print it: `verified` only when it reaches its goal, too."""
    motion, reached = (False, False) if verdict is None else (verdict.verified, verdict.goal_reached)
    return {
        "verified": motion and reached,
        "motion_verified": motion,
        "complete": complete,
        "goal_reached": reached,
        "unmet": [] if verdict is None else verdict.unmet,
        "at_rest": verdict is not None and verdict.at_rest,
    }


def headline(verdict: VerdictRecord) -> str:
    """The verdict in a line. Only of a plan that reaches its goal it is called verified, without more."""
    if not verdict.verified:
        return "refused"
    if verdict.goal_reached:
        return "verified" + (f", for the scene at rest: {AT_REST}" if verdict.at_rest else "")
    more = f" and {len(verdict.unmet) - MOST_UNMET} more" if len(verdict.unmet) > MOST_UNMET else ""
    return f"motion verified, goal not reached: {', '.join(verdict.unmet[:MOST_UNMET])}{more}"


def verdict_lines(verdict: VerdictRecord) -> list[str]:
    """The verdict for a terminal: every worst figure with its limit, time and source line, then the failures."""
    lines = [headline(verdict)]
    for measure in verdict.measures:
        where = f" at {measure.time:.2f} s" if measure.time is not None else ""
        between = f" between {' and '.join(measure.between)}" if measure.between else ""
        lines.append(f"  {measure.kind}: {measure.amount:.3g} (limit {measure.limit:.3g}){where}{between}")
    for failure in verdict.failures:
        place = f"{failure.place.file}:{failure.place.line}: " if failure.place is not None else ""
        lines.append(f"  refused: {place}{failure.message}")
    return lines


def _basis_lines(told: dict[str, Any], against: Path | None) -> list[str]:
    """What a verdict rests on, for a terminal. What differs from what is installed is told first, and loudly."""
    lines = [
        f"WARNING: {s['path']} differs from the installed one" for s in told["sources"] if s["installed"] is False
    ]
    values = "".join(f", {name} = {value:g}" for name, value in told["parameters"].items())
    lines.append(f"task {told['task']} of {told['file']}{values}, seed {told['seed']}")
    lines.append(f"goal {told['goal']}")
    for source in told["sources"]:
        lines.append(f"  {source['sha256']}  {source['path']}{', as installed' if source['installed'] else ''}")
    lines += [f"  {file['sha256']}  {file['path']}" for file in told["files"]]
    whose = "these texts, which the plan holds" if against is None else f"these texts, and against {against}"
    return [*lines, f"checked against {whose}"]
