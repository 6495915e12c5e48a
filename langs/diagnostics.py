"""Errors and warnings as data: a code, one sentence, a span and a hint. Every code is declared in `codes.py`."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

from .frozen import dataclass
from .source import Source, Span


@dataclass(frozen=True, slots=True)
class Label:
    """A second place that explains the first, such as a declaration."""

    span: Span
    text: str


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """One message to the user.

    `code` is a key of `codes.CODES`; codes that start with E are errors, with W warnings, with S solver outcomes.
    `span` is None only where no source text is involved (an unreadable file, a missing library).
    """

    code: str
    message: str
    span: Span | None = None
    labels: tuple[Label, ...] = ()
    help: str | None = None
    note: str | None = None

    @property
    def is_error(self) -> bool:
        return self.code.startswith("E")

    def _repr_html_(self) -> str:
        """What a notebook shows: the message as on a terminal, with its lines where the file can be read."""
        from html import escape

        from .render import render

        return f"<pre>{escape(render([self], sources_of([self])))}</pre>"


class Error(Exception):
    """The base of all that tamplang raises for what a user can mend."""


class SourceError(Error):
    """The source has errors; `diagnostics` holds all that were found, errors and warnings, in source order."""

    def __init__(self, diagnostics: Iterable[Diagnostic]) -> None:
        self.diagnostics = tuple(diagnostics)
        super().__init__("; ".join(f"{d.code} {d.message}" for d in self.diagnostics))


def sources_of(diagnostics: Iterable[Diagnostic]) -> dict[str, Source]:
    """The texts that diagnostics speak of, by path, as far as they can be read."""
    from .reader import read_source

    spans = [span for d in diagnostics for span in (d.span, *(x.span for x in d.labels)) if span is not None]
    sources = {}
    for file in {span.file for span in spans}:
        try:
            sources[file] = read_source(file)
        except Error:
            continue
    return sources


class UsageError(Error):
    """The command asks for what cannot be, such as a task or parameter that the file does not have, or an unfit value;
    `diagnostic`, if any, says the same with code, place and hint."""

    def __init__(
        self, message: str, code: str | None = None, span: Span | None = None, help: str | None = None
    ) -> None:
        super().__init__(message if help is None else f"{message}; {help}")
        self.diagnostic = None if code is None else Diagnostic(code, message, span, help=help)


MOST_COMPARED = 300
"""How many names an unknown one is compared with: those of the most similar length."""


def did_you_mean(name: str, candidates: Iterable[str]) -> str | None:
    """The hint `did you mean …?` for the nearest of `candidates`, or None when none is near."""
    names = sorted(set(candidates))
    if len(names) > MOST_COMPARED:
        names = sorted(names, key=lambda n: abs(len(n) - len(name)))[:MOST_COMPARED]
    near = get_close_matches(name, names, n=3, cutoff=0.6)
    if not near:
        return None
    return "did you mean " + " or ".join(f"`{n}`" for n in near) + "?"
