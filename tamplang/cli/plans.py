"""The commands `verify` and `report`: what can be done with a plan file."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING

import click

from .interrupt import kept_interrupt
from .libraries import needing_libraries
from .outputs import checked_output
from .parameters import Seconds
from .status import ExitStatus

if TYPE_CHECKING:
    from ..runtime.plan import Plan, VerdictRecord


class Unchecked(click.ClickException):
    """The time was not enough for a verdict."""

    exit_code = ExitStatus.NO_PLAN


@click.command()
@click.argument("file", metavar="PLAN.json", type=click.Path(path_type=Path))
@click.option("--time", "seconds", type=Seconds(), default=math.inf, help="Budget in seconds.  [default: none]")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def verify(file: Path, seconds: float, as_json: bool) -> int:
    """Check a plan from its file alone, with none of the planner's code."""
    from ..runtime.budget import Budget, OutOfTime

    plan = read(file)
    with needing_libraries(), kept_interrupt() as check:
        from ..runtime.verify import verify as verified

        check()
        try:
            verdict = verified(plan, Budget(seconds))
        except OutOfTime as error:
            raise Unchecked(f"{seconds:g} s are spent, and the plan is not checked to its end") from error
        check()
    if as_json:
        click.echo(json.dumps(verdict_json(verdict)))
    else:
        click.echo("\n".join(verdict_lines(verdict)))
    return ExitStatus.DONE if verdict.verified else ExitStatus.REFUSED


@click.command()
@click.argument("file", metavar="PLAN.json", type=click.Path(path_type=Path))
@click.option("-o", "--out", type=click.Path(path_type=Path), required=True, help="The HTML file to write.")
def report(file: Path, out: Path) -> None:
    """Write the report of a plan: one HTML file that works offline."""
    plan = read(file)
    checked_output(out, inputs=(file,))
    with needing_libraries():
        from ..runtime.report import write_report

        write_report(plan, out)
    click.echo(f"report: {out}", err=True)


def read(file: Path) -> Plan:
    """The plan in `file`. Raises click.ClickException (status 1) when it is no plan file."""
    from ..runtime.plan_files import PlanFileError, read_plan

    try:
        return read_plan(file)
    except PlanFileError as error:
        raise click.ClickException(str(error)) from error


def verdict_json(verdict: VerdictRecord) -> dict[str, object]:
    """The object that `verify --json` prints."""
    import msgspec

    return {
        "verified": verdict.verified,
        "worst": verdict.worst,
        "failures": msgspec.to_builtins(verdict.failures),
    }


def verdict_lines(verdict: VerdictRecord) -> list[str]:
    """The verdict for a terminal: every worst figure with its limit, time and source line, then the failures."""
    lines = ["verified" if verdict.verified else "refused"]
    for measure in verdict.measures:
        where = f" at {measure.time:.2f} s" if measure.time is not None else ""
        between = f" between {' and '.join(measure.between)}" if measure.between else ""
        lines.append(f"  {measure.kind}: {measure.amount:.3g} (limit {measure.limit:.3g}){where}{between}")
    for failure in verdict.failures:
        place = f"{failure.place.file}:{failure.place.line}: " if failure.place is not None else ""
        lines.append(f"  refused: {place}{failure.message}")
    return lines
