"""The command `run`: a task or a plan is carried out in the simulated world."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..runtime.budget import Status
from .horizon import checked_horizon
from .interrupt import kept_interrupt
from .libraries import load_libraries, needing_libraries
from .limits import limited, memory_option, total
from .outputs import checked_apart
from .parameters import Real, WholeNumber, parameters_option, plain, planner_option
from .plans import read, standing
from .progress import SECONDS_BETWEEN_LINES, volume_options
from .solution import Written, objective_json, objective_line, objective_of, report_in_time
from .sources import reading_sources, show_diagnostics
from .status import ExitStatus

if TYPE_CHECKING:
    from ..api import RunResult, Task
    from ..runtime.plan import Plan
    from ..runtime.simulation.results import RunProgress

STATUS = {
    Status.SOLVED: ExitStatus.DONE,
    Status.REFUSED: ExitStatus.REFUSED,
    Status.INTERRUPTED: ExitStatus.INTERRUPTED,
    Status.INFEASIBLE: ExitStatus.INFEASIBLE,
}
"""The exit status for each status of a run; others mean that the goal was not reached."""
NOISES = ("position", "joint", "drive")


def _noise(context: click.Context, option: click.Parameter, texts: tuple[str, ...]) -> dict[str, float]:
    found = {}
    for text in texts:
        name, _, value = (part.strip() for part in text.partition("="))
        sigma = float(value) if plain(value) else -1.0
        if name not in NOISES or not 0.0 <= sigma < 1e3:
            raise click.BadParameter(f"{text!r} is not of the form KIND=SIGMA, where KIND is {', '.join(NOISES)}")
        found[name] = sigma
    return found


@click.command()
@click.argument("file", metavar="FILE|PLAN.json", type=click.Path(path_type=Path))
@click.argument("task", required=False)
@parameters_option
@click.option("--seed", type=WholeNumber(0), default=0, show_default=True, help="For scene, search and noise.")
@click.option("--horizon", callback=checked_horizon, metavar="N|auto", help="Actions whose motion one window plans.")
@click.option("--noise", multiple=True, metavar="KIND=SIGMA", callback=_noise,
              help="position (m) of sensed bodies, joint (rad) of sensed joints, drive (rad/s²); may be repeated.")
@click.option("--latency", type=Real(0.0, 2.0),
              help="Simulated seconds that planning a window takes.  [default: 0.25]")
@click.option("--engine", type=click.Choice(["mujoco"]),
              help="Let a physics engine carry it out; needs the extra `sim`.  [default: drives with noise]")
@planner_option("minimise", metavar="OBJECTIVE")
@planner_option("time", "seconds")
@memory_option
@click.option("-o", "--out", type=click.Path(path_type=Path),
              help="The plan file.  [default: TASK.run.json in this folder]")
@click.option("--report", type=click.Path(path_type=Path), help="Write the report too: one HTML file.")
@click.option("--keep-refused", "refused", type=click.Path(path_type=Path), metavar="FILE",
              help="Where to write a plan that the verifier refuses.  [default: nowhere]")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object on standard output.")
@volume_options
def run(
    file: Path,
    task: str | None,
    parameters: dict[str, str],
    seed: int,
    horizon: int | str | None,
    noise: dict[str, float],
    latency: float | None,
    engine: str | None,
    minimise: str | None,
    seconds: float | None,
    memory: int | None,
    out: Path | None,
    report: Path | None,
    refused: Path | None,
    as_json: bool,
    volume: int,
) -> int:
    """Carry out a task, planning on the way, or a plan, in the simulated world.

    The scene may move, and modules may fail. What was carried out is a plan file, which is verified.
    """
    from ..compiler.objective_terms import spelled
    from ..compiler.objectives import check_energy
    from ..runtime.budget import SECONDS_OF_RUN
    from ..runtime.simulation.actuators import Noise
    from ..runtime.simulation.execution import StillOnly

    most = SECONDS_OF_RUN if seconds is None else seconds
    with limited(most, memory, f"compiling {file}", as_json) as guard, needing_libraries():
        plan = read(file, as_json) if file.suffix == ".json" else None
        if plan is not None and (task is not None or parameters):
            raise click.UsageError("a plan file says itself which task it solves, with which parameters")
        loaded = _loaded(file, plan, task, parameters, seed, as_json=as_json, quiet=volume < 0)
        if minimise is not None:
            with reading_sources(as_json=as_json):
                check_energy(spelled(minimise), loaded.problem.options.physics)
        out = out if out is not None else Path(f"{loaded.problem.task}.run.json")
        checked_apart({"--out": out, "--report": report, "--keep-refused": refused}, inputs=(file,))
        load_libraries()
        if engine is not None:
            _load_engine()
        guard.seconds = total(seconds, loaded.problem.options.time, SECONDS_OF_RUN)
        guard.doing = f"carrying out {loaded.problem.task}"
        with kept_interrupt() as check:
            try:
                result = loaded.run(
                    plan=plan, horizon=horizon, noise=Noise(**noise), latency=latency, time=guard.left(), seed=seed,
                    engine=engine, minimise=minimise, progress=_told(check, volume),
                )
            except StillOnly as error:
                raise click.UsageError(f"--engine {engine}: {error}; leave it out") from error
        guard.rest()
        written = _write(result, out, report, refused)
    if as_json:
        click.echo(json.dumps(_json(loaded, result, written)))
    else:
        click.echo("\n".join(_lines(loaded, result, written)))
    return STATUS.get(result.status, ExitStatus.NO_PLAN)


def _load_engine() -> None:
    """Load the engine, so that it is not missed after planning."""
    from ..runtime.engine.model import load_mujoco
    from ..runtime.native import MissingLibrary
    from .simulate import no_engine

    try:
        load_mujoco()
    except MissingLibrary as error:
        raise no_engine(error) from error


def _loaded(
    file: Path, plan: Plan | None, task: str | None, parameters: dict[str, str], seed: int, *, as_json: bool,
    quiet: bool,
) -> Task:  # fmt: skip
    from ..api import Task, task_of_plan
    from ..compiler.pipeline import compile_problem

    with reading_sources(as_json=as_json):
        if plan is not None:
            return task_of_plan(plan)
        loaded = Task(*compile_problem(file, task, parameters, seed))
    if loaded.warnings and not quiet:
        show_diagnostics(loaded.warnings, loaded.problem.sources)
    return loaded


def _write(result: RunResult, out: Path, report: Path | None, refused: Path | None) -> Written:
    """Write what was carried out and its report, or, if it is refused, that alone and only where it was asked for.
    Raises OSError."""
    verdict = result.record.verdict
    if verdict is None or not verdict.verified:
        if refused is not None:
            result.plan.save(refused)
        return Written((), None, refused)
    result.plan.save(out)
    return Written((out,), None if report is None else report_in_time(result.plan.report, report))


def _told(check: Callable[[], None], volume: int) -> Callable[[RunProgress], None]:
    """As `shown_progress`: nothing with `volume` -1, every step with 1."""
    last = float("-inf")

    def show(progress: RunProgress) -> None:
        nonlocal last
        check()
        if volume > 0 or (volume == 0 and progress.elapsed - last >= SECONDS_BETWEEN_LINES):
            last = progress.elapsed
            where = f"{progress.time:.1f} s into the run, {progress.done} done, {progress.left} to do"
            print(f"{progress.elapsed:6.1f} s  {where}: {progress.message}", file=sys.stderr, flush=True)

    return show


def _json(loaded: Task, result: RunResult, written: Written) -> dict[str, object]:
    """The object that `run --json` prints; `docs/cli.md` lists its fields."""
    import msgspec

    from .simulate import carried_json
    from .sources import as_objects

    verdict, record = result.plan.record.verdict, result.plan.record
    return {
        "status": result.status,
        "task": loaded.problem.task,
        "parameters": dict(loaded.problem.parameters),
        "seed": record.task.seed,
        "actions": [p.action for p in record.phases if p.completed],
        "broken_off": sum(not p.completed for p in record.phases),
        "seconds": record.times[-1],
        "objective": objective_json(record.statistics),
        "windows": [
            {**msgspec.to_builtins(window), "seconds": seconds}
            for window, seconds in zip(record.windows, result.seconds, strict=True)
        ],
        "replans": result.replans,
        "latency": {"median": result.latency, "worst": result.worst_latency},
        "deviations": msgspec.to_builtins(result.deviations),
        "engine": None if result.carried is None else carried_json(result.carried),
        **standing(verdict, record.complete),
        "worst": verdict.worst if verdict is not None else {},
        "plan": str(written.plans[0]) if written.plans else None,
        "refused": None if written.refused is None else str(written.refused),
        "report": None if written.report is None else str(written.report),
        "explanation": as_objects(result.explanation),
    }


HEADLINES = {
    Status.SOLVED: "the goal is reached",
    Status.STUCK: "nothing leads on to the goal from here",
    Status.INFEASIBLE: "the goal cannot be reached any more: it is proved that no actions lead there",
    Status.LOST: "a module that left took others with it",
    Status.BUDGET: "the budget is spent",
    Status.MEMORY: "the memory is spent",
    Status.REFUSED: "the verifier refuses what was carried out",
    Status.INTERRUPTED: "interrupted",
}


def _lines(loaded: Task, result: RunResult, written: Written) -> list[str]:
    """What a person wants to know, on a terminal."""
    from ..langs.counting import counted
    from .plans import verdict_lines
    from .simulate import carried_lines
    from .sources import as_text

    record = result.plan.record
    lines = [f"{loaded.problem.task}: {HEADLINES[result.status]}"]
    for number, phase in enumerate(record.phases, start=1):
        broken = "" if phase.completed else "  (broken off)"
        lines.append(f"  {number:2}  {phase.start:7.2f} s  {phase.action}{broken}")
    for window, seconds in list(zip(record.windows, result.seconds, strict=True))[1:]:
        lines.append(f"  planned anew at {window.time:.2f} s, in {seconds:.2f} s: {window.reason}")
    if result.replans:
        lines.append(f"{counted(result.replans, 'replanning')}: {result.latency:.2f} s in the median, "
                     f"{result.worst_latency:.2f} s at most")  # fmt: skip
    told = objective_of(record.statistics)
    lines += [] if told is None else [objective_line(told)]
    lines += _deviation_lines(result) if record.phases else []
    lines += [] if result.carried is None else ["in the engine:", *carried_lines(result.carried)]
    if record.verdict is not None:
        lines += verdict_lines(record.verdict)
    if not record.complete:
        stands = "what was carried out until then stands" if record.verdict is not None else "nothing is verified"
        lines.append(f"{stands if record.phases else 'nothing was carried out'}; the goal is not reached")
    if result.explanation:
        lines.append(as_text(result.explanation, "full", loaded.problem.sources))
    lines += [f"plan: {file}" for file in written.plans]
    lines += [] if written.refused is None else [f"refused plan: {written.refused}"]
    return lines if written.report is None else [*lines, f"report: {written.report}"]


def _deviation_lines(result: RunResult) -> list[str]:
    found = result.deviations
    if not found.joints:
        return []
    worst = max(found.joints, key=lambda j: j.worst)
    rms = max(found.joints, key=lambda j: j.rms)
    lines = [
        f"joints off by {worst.worst:.2g} at most ({worst.module} {worst.joint}), {rms.rms:.2g} RMS ({rms.module} "
        f"{rms.joint})",
        f"ends off by {1000 * found.switch:.2f} mm at most at switches",
    ]
    if found.clearance is not None:
        lines.append(f"least clearance {1000 * found.clearance:.1f} mm, of {' and '.join(found.clearance_between)}")
    return lines
