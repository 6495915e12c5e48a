"""Collects the diagnostics of the checks, each with the span of the exact word it speaks of, one per mistake."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping

from ...langs.diagnostics import Diagnostic, Label, did_you_mean
from ...langs.source import Source, Span
from ..standard import import_hint

FEW = 8
"""How many names a hint lists where none is near."""


class Findings:
    """A growing list of diagnostics. The first message at a place wins: later ones there follow from it."""

    def __init__(self, sources: Iterable[Source]) -> None:
        self._texts: Mapping[str, str] = {s.path: s.text for s in sources}
        self._order = {path: i for i, path in enumerate(self._texts)}
        self._found: dict[tuple[str, Span | None], Diagnostic] = {}

    def add(self, diagnostic: Diagnostic) -> None:
        key = (diagnostic.code if diagnostic.span is None else diagnostic.code[0], diagnostic.span)
        self._found.setdefault(key, diagnostic)

    def report(
        self,
        code: str,
        span: Span | None,
        message: str,
        *,
        help: str | None = None,
        note: str | None = None,
        labels: Iterable[tuple[Span | None, str]] = (),
    ) -> None:
        """Add one diagnostic; labels without a span are left out."""
        kept = tuple(Label(where, text) for where, text in labels if where is not None)
        self.add(Diagnostic(code, message, span, kept, help, note))

    def unknown(self, code: str, what: str, name: str, span: Span, candidates: Iterable[str]) -> None:
        """A name that nothing declares. The hint is the import that would declare it, else the nearest of
        `candidates`, else a few of them."""
        names = list(dict.fromkeys(candidates))
        help = import_hint(code, name) or did_you_mean(name, names)
        if help is None and 0 < len(names) <= FEW:
            help = f"known here: {', '.join(f'`{n}`' for n in names)}"
        self.report(code, span, f"unknown {what} `{name}`", help=help)

    def text(self, span: Span) -> str:
        """The source text of `span`."""
        return self._texts.get(span.file, "")[span.start : span.end]

    def word(self, span: Span, word: str, occurrence: int = 0) -> Span:
        """The span of `word` inside `span`; `span` itself where the word is not found."""
        text = self._texts.get(span.file)
        if text is None:
            return span
        pattern = re.compile(rf"(?<!\w){re.escape(word)}(?!\w)")
        matches = list(pattern.finditer(text, span.start, span.end))
        if len(matches) <= occurrence:
            return span
        start, end = matches[occurrence].span()
        before = text[span.start : start]
        breaks = before.count("\n")
        line = span.line + breaks
        column = span.column + len(before) if not breaks else len(before) - before.rfind("\n")
        return Span(span.file, start, end, line, column, line, column + len(word))

    def __iter__(self) -> Iterator[Diagnostic]:
        return iter(self._found.values())

    @property
    def has_errors(self) -> bool:
        return self.errors > 0

    @property
    def errors(self) -> int:
        """How many errors were found so far."""
        return sum(d.is_error for d in self._found.values())

    def errors_within(self, spans: Iterable[Span]) -> bool:
        """Whether an error lies inside one of `spans`."""
        places = [d.span for d in self._found.values() if d.is_error and d.span is not None]
        return any(s.file == p.file and s.start <= p.start < s.end for s in spans for p in places)

    def sorted(self) -> tuple[Diagnostic, ...]:
        """All diagnostics by file (the main file first), then by place."""
        return tuple(sorted(self._found.values(), key=self._place))

    def _place(self, d: Diagnostic) -> tuple[int, int, str]:
        if d.span is None:
            return -1, 0, d.code
        return self._order.get(d.span.file, len(self._order)), d.span.start, d.code
