"""The command `simulate`: a plan carried out in a physics engine."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING

import click

from .limits import limit_options, limited
from .parameters import Real
from .plans import read
from .sources import reading_sources
from .status import ExitStatus

if TYPE_CHECKING:
    from ..runtime.engine import Simulated

MOST_BROKEN = 5


@click.command()
@click.argument("file", metavar="PLAN.json", type=click.Path(path_type=Path))
@limit_options
@click.option("--noise", type=Real(0.0, 1.0), default=0.0, metavar="SHARE",
              help="Weights, drives and friction are off by random factors of this deviation, such as 0.05.")
@click.option("--seed", type=click.IntRange(0), default=0, help="Of the noise.", show_default=True)
@click.option("--contact", is_flag=True, help="Feet and things stand by friction and adhesion, not by welds.")
@click.option("--view", is_flag=True, help="Show it live, where there is a display.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def simulate(
    file: Path, seconds: float, memory: int | None, noise: float, seed: int, contact: bool, view: bool, as_json: bool
) -> int:  # fmt: skip
    """Carry out a plan in MuJoCo: free modules, drives clamped at their torque, docks and feet that break.

    Needs the extra `sim`. Says how well the plan was followed, what broke, and whether its goal holds at the end.
    """
    from ..compiler.pipeline import compile_sources
    from ..langs.source import Source
    from ..runtime.native import MissingLibrary
    from ..runtime.plan_parameters import parameter_texts

    with limited(seconds, memory, f"simulating {file}", as_json) as guard:
        plan = read(file)
        with reading_sources(as_json=as_json):
            sources = [Source(s.path, s.text) for s in plan.task.sources]
            files = {f.path: f.data for f in plan.task.files}
            texts = parameter_texts(plan, sources)
            problem, _ = compile_sources(sources, plan.task.name, texts, plan.task.seed, files)
        from ..runtime.budget import Budget
        from ..runtime.engine import Conditions, NoDisplay, carry_out

        try:
            carried = carry_out(
                problem, plan, Budget(guard.remaining).check, Conditions(noise, seed, contact, view)
            )
        except NoDisplay as error:
            help = "leave out --view, or set DISPLAY"
            raise click.ClickException(f"S0014: there is no display: {error}\n  help: {help}") from error
        except MissingLibrary as error:
            raise no_engine(error) from error
    click.echo(json.dumps(carried_json(carried)) if as_json else "\n".join(_lines(carried)))
    return ExitStatus.DONE if carried.reached else ExitStatus.REFUSED


def no_engine(error: Exception) -> click.ClickException:
    """That MuJoCo is missing, in words."""
    help = "install the extra: pip install 'tamplang[sim]'"
    return click.ClickException(f"S0012: the simulation needs MuJoCo: {error}\n  help: {help}")


def carried_json(carried: Simulated) -> dict[str, object]:
    """Metres, radians, N m, and N of what slides; strengths that are not stated are null."""
    return {
        "reached": carried.reached,
        "seconds": carried.seconds,
        "tracking": carried.tracking,
        "base_m": carried.base,
        "droop_m": carried.droop,
        "peaks": [
            {"module": module, "joint": joint, "peak": peak, "strength": most if math.isfinite(most) else None}
            for (module, joint), (peak, most) in carried.peaks.items()
        ],
        "loads": [{"between": list(names), "ratio": ratio} for names, ratio in carried.loads.items()],
        "broken": [{"time": time, "what": what, "ratio": ratio} for time, what, ratio in carried.broken],
        "diverged": carried.diverged,
    }


def _lines(carried: Simulated) -> list[str]:
    """The outcome for a terminal."""
    if carried.diverged is not None:
        lines = [f"S0013: the simulation broke down at {carried.diverged:.2f} s; figures of later mean nothing"]
    elif carried.reached:
        lines = ["carried out: the goal holds at the end"]
    else:
        lines = ["carried out: the goal does not hold at the end"]
    return lines + carried_lines(carried)


def carried_lines(carried: Simulated) -> list[str]:
    """The figures for a terminal."""
    joints, robots = 1e3 * carried.tracking, 1e3 * carried.base
    lines = [f"  joints followed within {joints:.3g} mrad or mm, robots within {robots:.3g} mm"]
    lines.append(f"  welds gave by {1e3 * carried.droop:.3g} mm")
    stated = {k: v for k, v in carried.peaks.items() if math.isfinite(v[1])} or carried.peaks
    if stated:
        (module, joint), (peak, most) = max(stated.items(), key=lambda item: (item[1][0] / item[1][1], item[1][0]))
        of = f" of {most:.3g}" if math.isfinite(most) else ""
        unit = "N" if (module, joint) in carried.sliding else "N m"
        lines.append(f"  hardest drive: {joint} of {module}, {peak:.3g}{of} {unit}")
    if carried.loads:
        names, ratio = max(carried.loads.items(), key=lambda item: item[1])
        lines.append(f"  most loaded pair: {names[0]} and {names[1]}, {ratio:.2f} of its strength")
    for time, what, ratio in carried.broken[:MOST_BROKEN]:
        lines.append(f"  gave way: {what} at {time:.2f} s, {ratio:.2f} times what holds")
    return lines
