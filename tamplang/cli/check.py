"""The commands `check` and `fmt`."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..langs.render import FORMATS
from .limits import Spent, limit_options, limited, out_of_memory, out_of_time
from .outputs import UnwritableFile
from .progress import counted
from .sources import as_text, diagnostics_in, reading_sources, wants_colour
from .status import ExitStatus

if TYPE_CHECKING:
    from ..langs.diagnostics import Diagnostic

FILES = click.argument("files", metavar="FILE...", nargs=-1, required=True, type=click.Path(path_type=Path))


@click.command()
@FILES
@limit_options
@click.option("--format", "form", type=click.Choice(FORMATS), default="full", show_default=True, help="How to print.")
def check(files: tuple[Path, ...], form: str, seconds: float, memory: int | None) -> int:
    """Print all errors and warnings of each FILE."""
    diagnostics, spent = _found(files, seconds, memory)
    if diagnostics or form in ("json", "sarif"):
        click.echo(as_text(diagnostics, form, colour=wants_colour(sys.stdout)))
    errors = sum(d.is_error for d in diagnostics)
    counts = (len(files), "file"), (errors, "error"), (len(diagnostics) - errors, "warning")
    click.echo(", ".join(counted(*count) for count in counts), err=True)
    if spent is not None:
        raise spent
    return ExitStatus.SOURCE_ERRORS if errors else ExitStatus.DONE


def _found(files: Sequence[Path], seconds: float, memory: int | None) -> tuple[list[Diagnostic], Spent | None]:
    """The diagnostics of the files, and what ended the reading before the last of them."""
    found: dict[Diagnostic, None] = {}
    reading = files[0]
    try:
        with limited(seconds, memory, "checking") as guard:
            for reading in files:
                found |= dict.fromkeys(diagnostics_in([reading]))
    except Spent as error:
        told = out_of_memory if error.status == "memory" else partial(out_of_time, guard.seconds)
        return list(found), Spent(told(f"while checking {reading}"))
    return list(found), None


@click.command()
@FILES
@limit_options
@click.option("--check", "only_check", is_flag=True, help="Change nothing; end with status 1 if a file would change.")
def fmt(files: tuple[Path, ...], only_check: bool, seconds: float, memory: int | None) -> int:
    """Lay out each FILE in the one standard way."""
    changed = []
    try:
        with limited(seconds, memory, "laying out files") as guard:
            for file in files:
                guard.doing = f"laying out {file}"
                changed += [file] if _format(file, only_check) else []
    finally:
        for file in changed:
            click.echo(f"{'would change' if only_check else 'changed'}: {file}", err=True)
    return ExitStatus.SOURCE_ERRORS if changed and only_check else ExitStatus.DONE


def _format(file: Path, only_check: bool) -> bool:
    """Whether the file differs from its standard form; unless `only_check` it is rewritten."""
    from ..langs.formatter import format_source
    from ..langs.reader import read_source

    with reading_sources():
        source = read_source(file)
        text = format_source(source)
    if text == source.text:
        return False
    if not only_check:
        from ..langs.writer import rewrite

        try:
            rewrite(file, text)
        except OSError as error:
            raise UnwritableFile(file, error.strerror or "the write failed") from error
    return True
