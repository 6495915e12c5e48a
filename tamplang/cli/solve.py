"""The command `solve`: a task in, a verified plan out."""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path

import click

from .horizon import checked_horizon
from .interrupt import kept_interrupt
from .libraries import load_libraries, needing_libraries
from .limits import limited, memory_option, total
from .outputs import checked_apart, checked_output, numbered
from .parameters import WholeNumber, parameters_option, planner_option
from .progress import shown_progress, volume_options
from .side import checked_side, needing_cluster, side_options, without_broken_pipes
from .solution import Keeper, result_json, result_lines, write
from .sources import reading_sources, show_diagnostics
from .status import OF_OUTCOME
from .watch import watch_option, watching


@click.command()
@click.argument("file", metavar="FILE", type=click.Path(path_type=Path))
@click.argument("task", required=False)
@parameters_option
@click.option("--seed", type=WholeNumber(0), default=0, show_default=True, help="For the scene and the search.")
@planner_option("bound")
@planner_option("search")
@click.option("--horizon", callback=checked_horizon, metavar="N|auto", help="Plan the motion of N actions at a time.")
@planner_option("solutions", default=1, show_default=True)
@planner_option("minimise", metavar="OBJECTIVE")
@planner_option("gap")
@planner_option("time", "seconds")
@memory_option
@planner_option("nodes")
@side_options
@planner_option("solver")
@click.option("-o", "--out", type=click.Path(path_type=Path),
              help="The plan file.  [default: TASK.plan.json in this folder]")
@click.option("--report", type=click.Path(path_type=Path), help="Write the report too: one HTML file.")
@click.option("--keep-refused", "refused", type=click.Path(path_type=Path), metavar="FILE",
              help="Where to write a plan that the verifier refuses.  [default: nowhere]")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object on standard output.")
@volume_options
@watch_option
def solve(
    file: Path,
    task: str | None,
    parameters: dict[str, str],
    seed: int,
    bound: str | None,
    search: str | None,
    horizon: int | str | None,
    solutions: int,
    minimise: str | None,
    gap: float | None,
    seconds: float | None,
    memory: int | None,
    nodes: int | None,
    jobs: int | None,
    cluster: str | None,
    solver: str | None,
    out: Path | None,
    report: Path | None,
    refused: Path | None,
    as_json: bool,
    volume: int,
    watch: bool,
) -> int:
    """Plan the TASK of FILE: actions, motion, and an independent check of both.

    What is not given here comes from the task's own options.
    """
    if watch:
        return watching([file], sys.argv[1:])
    if horizon is not None and (solutions > 1 or bound == "seq"):
        raise click.UsageError("--horizon gives one plan with motion: it goes neither with --solutions nor --bound seq")
    if horizon is not None and gap is not None:
        raise click.UsageError("--horizon gives the first plan that it finds: leave out --gap")
    if horizon is not None and ((jobs or 1) > 1 or cluster is not None):
        raise click.UsageError("--horizon plans window after window in one process: leave out --jobs and --cluster")
    checked_side(jobs, cluster)
    from ..api import Task
    from ..compiler.objective_terms import spelled
    from ..compiler.objectives import check_energy
    from ..compiler.pipeline import compile_problem
    from ..compiler.scenes.happenings import unseen
    from ..runtime.budget import SECONDS

    started = time.monotonic()
    most = SECONDS if seconds is None else seconds
    with limited(most, memory, f"compiling {file}", as_json, jobs or 1) as guard, needing_libraries():
        with reading_sources(as_json=as_json):
            loaded = Task(*compile_problem(file, task, parameters, seed))
            if minimise is not None:
                check_energy(spelled(minimise), loaded.problem.options.physics)
        compiled = time.monotonic() - started
        later = unseen(loaded.problem.world)
        warnings = (*loaded.warnings, *((later,) if later is not None else ()))
        if warnings and volume >= 0:
            show_diagnostics(warnings, loaded.problem.sources)
        plan_file, report_file = _files(file, loaded.problem.task, solutions, out, report, refused)
        load_libraries()
        guard.seconds = total(seconds, loaded.problem.options.time, SECONDS)
        guard.doing = f"planning {loaded.problem.task}"
        keeper = Keeper(plan_file, solutions)
        with (
            needing_cluster(as_json),
            kept_interrupt() as check,
            without_broken_pipes(),
            shown_progress(check, volume) as progress,
        ):
            result = loaded.solve(
                bound=bound,
                search=search,
                time=guard.left(),
                nodes=nodes,
                solutions=solutions,
                minimise=minimise,
                gap=gap,
                solver=solver,
                horizon=horizon,
                jobs=jobs or 1,
                cluster=cluster,
                progress=progress,
                found=keeper,
            )
        guard.rest()
        keeper.leave(len(result.plans))
        written = write(loaded.problem, result, plan_file, report_file, refused)
    if as_json:
        click.echo(json.dumps(result_json(loaded.problem, result, written, compiled)))
    else:
        click.echo("\n".join(result_lines(loaded.problem, result, written)))
    return OF_OUTCOME[result.status]


def _files(
    source: Path, task: str, solutions: int, out: Path | None, report: Path | None, refused: Path | None
) -> tuple[Path, Path | None]:
    """The plan file and the report file, both, and the file of a refused plan, known to be writable."""
    plan_file = out if out is not None else Path(f"{task}.plan.json")
    for number in range(1, solutions + 1):
        checked_output(numbered(plan_file, number), inputs=(source,))
    checked_apart({"--out": plan_file, "--report": report, "--keep-refused": refused}, inputs=(source,))
    return plan_file, report
