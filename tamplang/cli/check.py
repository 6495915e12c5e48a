"""The commands `check` and `fmt`."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..langs.counting import counted
from ..langs.render import FORMATS
from .limits import Spent, limit_options, limited, out_of_memory, out_of_time
from .outputs import UnwritableFile
from .sources import as_text, diagnostics_in, diagnostics_of, reading_sources, wants_colour
from .status import ExitStatus
from .watch import watch_option, watching

if TYPE_CHECKING:
    from ..langs.diagnostics import Diagnostic
    from ..langs.source import Source

STANDARD_INPUT = Path("-")
FILES = click.argument("files", metavar="FILE...", nargs=-1, required=True, type=click.Path(path_type=Path))


@click.command()
@FILES
@limit_options
@click.option("--format", "form", type=click.Choice(FORMATS), default="full", show_default=True, help="How to print.")
@click.option("-q", "--quiet", is_flag=True, help="Tell errors only.")
@watch_option
def check(
    files: tuple[Path, ...], form: str, seconds: float, memory: int | None, quiet: bool, watch: bool
) -> int:
    """Print all errors and warnings of each FILE; `-` is the program on standard input."""
    if watch:
        if STANDARD_INPUT in files:
            raise click.UsageError("--watch looks at files, not at standard input")
        return watching(files, sys.argv[1:])
    given = {STANDARD_INPUT: _standard_input()} if STANDARD_INPUT in files else {}
    diagnostics, spent = _found(files, seconds, memory, given)
    if quiet:
        diagnostics = [d for d in diagnostics if d.is_error]
    if diagnostics or form in ("json", "sarif"):
        click.echo(as_text(diagnostics, form, [*given.values()], wants_colour(sys.stdout)))
    errors = sum(d.is_error for d in diagnostics)
    counts = (len(files), "file"), (errors, "error"), (len(diagnostics) - errors, "warning")
    if not quiet:
        click.echo(", ".join(counted(*count) for count in counts), err=True)
    if spent is not None:
        raise spent
    return ExitStatus.SOURCE_ERRORS if errors else ExitStatus.DONE


def _standard_input() -> Source:
    """The program on standard input. Raises SourceFailure when it is no text."""
    from ..langs.reader import MAX_BYTES, source_of

    with reading_sources():
        return source_of("<stdin>", sys.stdin.buffer.read(MAX_BYTES + 1))


def _found(
    files: Sequence[Path], seconds: float, memory: int | None, given: Mapping[Path, Source]
) -> tuple[list[Diagnostic], Spent | None]:
    """The diagnostics of the files, and what ended the reading before the last of them."""
    found: dict[Diagnostic, None] = {}
    reading = files[0]
    try:
        with limited(seconds, memory, "checking") as guard:
            for reading in files:
                here = diagnostics_of(given[reading]) if reading in given else diagnostics_in([reading])
                found |= dict.fromkeys(here)
    except Spent as error:
        told = out_of_memory if error.status == "memory" else partial(out_of_time, guard.seconds)
        return list(found), Spent(told(f"while checking {reading}"))
    return list(found), None


@click.command()
@FILES
@limit_options
@click.option("--check", "only_check", is_flag=True, help="Change nothing; end with status 1 if a file would change.")
@click.option("--diff", is_flag=True, help="Print what would change, and change nothing.")
def fmt(files: tuple[Path, ...], only_check: bool, diff: bool, seconds: float, memory: int | None) -> int:
    """Lay out each FILE in the one standard way; `-` is the program on standard input, laid out on standard output."""
    changed: list[Path] = []
    try:
        with limited(seconds, memory, "laying out files") as guard:
            for file in files:
                guard.doing = f"laying out {file}"
                changed += [file] if _format(file, only_check, diff) else []
    finally:
        for file in changed:
            if not diff and (only_check or file != STANDARD_INPUT):
                click.echo(f"{'would change' if only_check else 'changed'}: {file}", err=True)
    return ExitStatus.SOURCE_ERRORS if changed and (only_check or diff) else ExitStatus.DONE


def _format(file: Path, only_check: bool, diff: bool) -> bool:
    """Whether the file differs from its standard form; unless it is only asked for, it is rewritten."""
    from ..langs.formatter import format_source
    from ..langs.reader import read_source

    with reading_sources():
        source = _standard_input() if file == STANDARD_INPUT else read_source(file)
        text = format_source(source)
    if diff:
        import difflib

        before, after = source.text.splitlines(keepends=True), text.splitlines(keepends=True)
        for line in difflib.unified_diff(before, after, str(file), f"{file} (laid out)"):
            click.echo(line if line.endswith("\n") else f"{line}\n\\ No newline at end of file\n", nl=False)
    elif file == STANDARD_INPUT and not only_check:
        click.echo(text, nl=False)
    if text == source.text:
        return False
    if not (only_check or diff or file == STANDARD_INPUT):
        from ..langs.writer import rewrite

        try:
            rewrite(file, text)
        except OSError as error:
            raise UnwritableFile(file, error.strerror or "the write failed") from error
    return True
