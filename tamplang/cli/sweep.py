"""The command `sweep`: many instances of a task, side by side, with results that are kept as they come."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..langs.counting import counted
from .interrupt import kept_interrupt
from .libraries import load_libraries, needing_libraries
from .limits import limited, memory_option
from .outputs import UnwritableFile, checked_output
from .parameters import parameters_option, planner_option
from .side import checked_side, needing_cluster, side_options, without_broken_pipes
from .sources import reading_sources
from .status import ExitStatus

if TYPE_CHECKING:
    from concurrent.futures import Future

    from ..runtime.parallel import Side
    from .instances import Instance
    from .results import Results


FEW = 8
"""How many lines a warning lists."""


@click.command()
@click.argument("file", metavar="FILE", type=click.Path(path_type=Path))
@click.argument("task", required=False)
@parameters_option
@click.option("--seeds", default="0", show_default=True, help="Seeds, such as 0..9 or 1,5,7.")
@side_options
@planner_option("bound")
@planner_option("search")
@planner_option("time", help="Seconds for each; inf for no limit.")
@memory_option
@planner_option("nodes", help="How large each search tree may grow.")
@planner_option("solver")
@click.option("-o", "--out", type=click.Path(path_type=Path),
              help="The results.  [default: TASK.sweep.jsonl in this folder]")
@click.option("--plans", type=click.Path(path_type=Path), help="A folder for the plan files.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object on standard output.")
def sweep(
    file: Path,
    task: str | None,
    parameters: dict[str, str],
    seeds: str,
    jobs: int | None,
    cluster: str | None,
    memory: int | None,
    out: Path | None,
    plans: Path | None,
    as_json: bool,
    **options: Any,
) -> int:
    """Solve the TASK of FILE for all combinations of parameters and seeds.

    Parameters take several values: -p n=8,16,32 -p width=1m,2m. Instances whose results are in the results file
    already are not solved again.
    """
    checked_side(jobs, cluster)
    from ..runtime.budget import SECONDS

    most = SECONDS if options["time"] is None else options["time"]
    with limited(most, memory, f"reading {file}", as_json), reading_sources(as_json=as_json):
        todo = _instances(file, task, parameters, seeds, options, plans is not None)
    path = out if out is not None else Path(f"{todo[0].program.task}.sweep.jsonl")
    checked_output(path, inputs=(file,))
    if plans is not None:
        _make_folder(plans)
    from .results import Results, groups

    with closing(Results(path)) as results:
        _warn(results)
        interrupted = not _finished(todo, results, plans, jobs or 1, cluster, memory, as_json)
        found = groups(todo, results)
    _show(found, path, interrupted, as_json)
    if interrupted:
        return ExitStatus.INTERRUPTED
    return ExitStatus.DONE if all(g["solved"] == g["instances"] for g in found) else ExitStatus.NO_PLAN


def _instances(
    file: Path, task: str | None, parameters: Mapping[str, str], seeds: str, options: Mapping[str, Any], with_plan: bool
) -> list[Instance]:
    from . import instances as every

    texts = {name: every.listed(name, text) for name, text in parameters.items()}
    numbers = every.seeds_of(seeds)
    if len(numbers) * math.prod(len(several) for several in texts.values()) > every.MAX_INSTANCES:
        raise every.too_many()
    program = every.read_program(file, task)
    return every.instances(program, every.read_values(program, texts), numbers, options, with_plan)


def _make_folder(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UnwritableFile(folder, error.strerror or "the folder cannot be made") from error
    checked_output(folder / "plan.json")


def _warn(results: Results) -> None:
    """Tell of lines that are passed over."""
    from ..langs.diagnostics import Diagnostic
    from .sources import show_diagnostics

    if results.damaged:
        few = ", ".join(map(str, results.damaged[:FEW])) + (", …" if len(results.damaged) > FEW else "")
        message = f"{results.path}: {counted(len(results.damaged), 'line')} passed over that hold no result: {few}"
        show_diagnostics([Diagnostic("W0011", message, help="what they may have held is solved again")])


def _finished(
    todo: list[Instance], results: Results, plans: Path | None, jobs: int, cluster: str | None, memory: int | None,
    as_json: bool,
) -> bool:  # fmt: skip
    """Solve what is not solved yet. False after Ctrl-C."""
    from ..runtime.guard import memory_limit
    from ..runtime.parallel import as_finished
    from .instances import solve_instance

    left = [instance for instance in todo if results.of(instance, plans) is None]
    if len(left) < len(todo):
        click.echo(f"{counted(len(todo) - len(left), 'instance')} of {len(todo)} stand in {results.path}", err=True)
    if not left:
        return True
    most = memory_limit(memory, jobs) if cluster is None else None
    solve = partial(solve_instance, memory=most)
    try:
        with (
            needing_cluster(as_json),
            kept_interrupt() as check,
            without_broken_pipes(),
            _executor(jobs, cluster) as executor,
            _shown(len(left)) as show,
        ):
            for instance, future in as_finished(executor, solve, left):
                record = _record(instance, future, plans)
                results.add(record)
                show(instance, record)
                check()
    except KeyboardInterrupt:
        return False
    return True


def _executor(jobs: int, cluster: str | None) -> Side:
    from ..runtime.parallel import open_executor

    if cluster is None:
        with needing_libraries():
            load_libraries()
    return open_executor(jobs, cluster)


def _record(
    instance: Instance, future: Future[tuple[dict[str, Any], bytes | None]], plans: Path | None
) -> dict[str, Any]:
    """The result of the instance; its plan is written first. Raises KeyboardInterrupt when it was interrupted, and
    ClusterUnavailable when the cluster is gone."""
    from ..langs.diagnostics import Diagnostic
    from ..runtime.parallel import ClusterUnavailable, WorkerLost
    from .instances import failed
    from .sources import as_objects

    error = future.exception()
    if isinstance(error, ClusterUnavailable):
        raise error
    if isinstance(error, WorkerLost):
        lost = Diagnostic("S0007", f"the work was lost: {error}", help="the next sweep into this file tries it again")
        return failed(instance, "lost", as_objects([lost]))
    if error is not None:
        return failed(instance, "crashed", []) | {"message": str(error), "trace": getattr(error, "trace", "")}
    record, plan = future.result()
    if record["status"] == "interrupted":
        raise KeyboardInterrupt
    if plan is not None and plans is not None:
        _write_plan(plans, instance, plan)
    return record


def _write_plan(folder: Path, instance: Instance, plan: bytes) -> None:
    from ..langs.writer import write_atomically
    from .results import plan_file

    path = plan_file(folder, instance)
    try:
        write_atomically(path, plan)
    except OSError as error:
        raise UnwritableFile(path, error.strerror or "the write failed") from error


@contextmanager
def _shown(total: int) -> Iterator[Callable[[Instance, Mapping[str, Any]], None]]:
    """Give the callback for a finished instance: a bar on a terminal, a line each elsewhere."""
    if sys.stderr.isatty():
        from .bar import counting_bar

        with counting_bar() as bar:
            task = bar.add_task("sweep", total=total, detail="")
            yield lambda instance, record: bar.update(task, advance=1, detail=f"{instance}: {_said(record)}")
        return
    done = 0

    def show(instance: Instance, record: Mapping[str, Any]) -> None:
        nonlocal done
        done += 1
        print(f"{done}/{total}  {instance}: {_said(record)}", file=sys.stderr, flush=True)

    yield show


def _said(record: Mapping[str, Any]) -> str:
    """The result in a few words."""
    first = next(iter(record["explanation"]), None)
    reason = "" if first is None else f"{first['code']}: {first['message']}"
    if "seconds" in record:
        told = f"{record['status']}, {counted(record['length'], 'action')}, {record['seconds']['total']:.1f} s"
        return f"{told}; {reason}" if reason else told
    return f"{record['status']}: {record.get('message') or reason}"


def _show(found: list[dict[str, Any]], path: Path, interrupted: bool, as_json: bool) -> None:
    solved = all(group["solved"] == group["instances"] for group in found)
    status = "interrupted" if interrupted else "solved" if solved else "unsolved"
    if as_json:
        total = {name: sum(group[name] for group in found) for name in ("instances", "finished", "solved")}
        click.echo(json.dumps({"status": status, **total, "groups": found, "out": str(path)}))
        return
    from .table import print_groups

    print_groups(found)
    click.echo(f"results: {path}")
