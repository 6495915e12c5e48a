"""The command `new`: a commented starter task."""

from __future__ import annotations

import re
from importlib.resources import files
from pathlib import Path

import click


@click.command()
@click.argument("name")
def new(name: str) -> None:
    """Write NAME.tamp, a small commented task that solves in seconds."""
    target = Path(name if name.endswith(".tamp") else f"{name}.tamp")
    task = target.name.removesuffix(".tamp")
    if not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", task):
        raise click.UsageError(f"{task!r} is not a name: use letters, digits and underscores, a letter first")
    from ..langs.writer import write_new

    text = files(__package__).joinpath("starter.tamp").read_text(encoding="utf-8").replace("starter", task)
    try:
        write_new(target, text.encode())
    except FileExistsError:
        raise click.UsageError(f"{target} exists already; it was not changed") from None
    except OSError as error:
        raise click.UsageError(f"cannot write {target}: {error.strerror}") from error
    click.echo(f"wrote {target}; next: tamplang solve {target} --report {task}.html")
