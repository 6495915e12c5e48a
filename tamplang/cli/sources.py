"""Programs and what is wrong with them: from files to diagnostics, and from diagnostics to text."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, TextIO

import click

from ..langs.render import render
from .status import ExitStatus

if TYPE_CHECKING:
    from ..langs.diagnostics import Diagnostic
    from ..langs.source import Source


class SourceFailure(click.ClickException):
    """A program with errors; shown as its diagnostics."""

    exit_code = ExitStatus.SOURCE_ERRORS

    def __init__(self, diagnostics: Sequence[Diagnostic], as_json: bool) -> None:
        super().__init__("the program has errors")
        self.diagnostics = diagnostics
        self.as_json = as_json

    def show(self, file: IO[Any] | None = None) -> None:
        """Print the diagnostics on standard error, and with `as_json` one object on standard output too."""
        show_diagnostics(self.diagnostics)
        if self.as_json:
            click.echo(json.dumps({"status": "error", "diagnostics": as_objects(self.diagnostics)}))


class UsageFailure(SourceFailure):
    """A task or a parameter that does not fit the program."""

    exit_code = ExitStatus.USAGE


@contextmanager
def reading_sources(as_json: bool = False) -> Iterator[None]:
    """Around code that reads programs: turns their errors into `SourceFailure`, `UsageFailure` and
    `click.UsageError`."""
    from ..langs.diagnostics import SourceError, UsageError

    try:
        yield
    except SourceError as error:
        raise SourceFailure(error.diagnostics, as_json) from error
    except UsageError as error:
        if error.diagnostic is not None:
            raise UsageFailure([error.diagnostic], as_json) from error
        raise click.UsageError(str(error)) from error


def diagnostics_in(files: Sequence[Path]) -> list[Diagnostic]:
    """All errors and warnings of the files, in that order; what several of them import is told once."""
    from ..compiler.pipeline import check

    return list(dict.fromkeys(diagnostic for file in files for diagnostic in check(file)))


def diagnostics_of(source: Source) -> list[Diagnostic]:
    """All errors and warnings of a text that is no file."""
    from ..compiler.pipeline import check_sources

    return list(check_sources([source]))


def as_text(diagnostics: Sequence[Diagnostic], form: str, given: Sequence[Source] = (), colour: bool = False) -> str:
    """The diagnostics in one of `langs.render.FORMATS`. `given` holds sources that need not be read again."""
    return render(diagnostics, sources_of(diagnostics, given), form, colour)


def as_objects(diagnostics: Sequence[Diagnostic]) -> list[dict[str, object]]:
    """The diagnostics as `check --format json` prints them."""
    objects: list[dict[str, object]] = json.loads(render(diagnostics, {}, "json"))
    return objects


def show_diagnostics(diagnostics: Sequence[Diagnostic], given: Sequence[Source] = ()) -> None:
    """Print the diagnostics, in full, on standard error."""
    click.echo(as_text(diagnostics, "full", given, wants_colour(sys.stderr)), err=True)


def wants_colour(stream: TextIO) -> bool:
    """Whether to print colours there: on a terminal, unless the user set NO_COLOR (https://no-color.org)."""
    return stream.isatty() and not os.environ.get("NO_COLOR")


def sources_of(diagnostics: Sequence[Diagnostic], given: Sequence[Source]) -> dict[str, Source]:
    """By path, the sources that the diagnostics point into; those that can no longer be read are left out."""
    from ..compiler.imports import on_disk
    from ..langs.diagnostics import SourceError
    from ..langs.reader import read_source
    from ..langs.source import Source

    sources = {source.path: source for source in given}
    for diagnostic in diagnostics:
        for span in (diagnostic.span, *(label.span for label in diagnostic.labels)):
            if span is None or span.file in sources:
                continue
            try:
                sources[span.file] = Source(span.file, read_source(on_disk(span.file)).text)
            except SourceError:
                continue
    return sources
