"""The command `export`: plans for the tools of others."""

from __future__ import annotations

from pathlib import Path

import click

from .libraries import needing_libraries
from .limits import limit_options, limited
from .outputs import checked_output
from .plans import read
from .sources import reading_sources

ENDINGS = {
    "csv": ".csv", "npz": ".npz", "ros2": ".yaml", "multidof": ".poses.yaml", "mcap": ".mcap", "urdf": ".urdf",
    "mjcf": ".xml", "pddl": ".pddl", "val": ".val", "png": ".png", "gif": ".gif", "mp4": ".mp4",
}  # fmt: skip


@click.command()
@click.argument("file", metavar="PLAN.json", type=click.Path(path_type=Path))
@click.option("--to", "form", type=click.Choice(list(ENDINGS)), required=True, help="The form to write.")
@click.option("-o", "--out", type=click.Path(path_type=Path), help="The file to write; beside the plan unless given.")
@click.option("--rate", type=float,
              help="Samples a second, of csv, npz and the forms of ROS 2; pictures a second, of gif and mp4.")
@click.option("--module", help="Of urdf: a module of the robot to write; the first one of the plan unless given.")
@click.option("--phase", type=int, default=0, show_default=True, help="Of urdf: the phase to write it in.")
@click.option("--at", type=float, help="Of png: the moment to draw, seconds; the end unless given.")
@limit_options
def export(
    file: Path, form: str, out: Path | None, rate: float | None, module: str | None, phase: int,
    at: float | None, seconds: float, memory: int | None,
) -> None:  # fmt: skip
    """Write a plan for other tools: tables, ROS 2, URDF, MuJoCo or PDDL; or as pictures."""
    plain = file.name.removesuffix(".json").removesuffix(".plan")
    target = file.with_name(plain + ENDINGS[form]) if out is None else out
    with limited(seconds, memory, f"exporting {file}"), reading_sources(), needing_libraries():
        plan = read(file)
        checked_output(target)
        from ..plans import Plan

        Plan(plan).export(form, target, rate, module, phase, at)
    click.echo(f"wrote {target}", err=True)
