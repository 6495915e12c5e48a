"""Collects the diagnostics of the checks, each with the span of the exact word it speaks of, one per mistake."""

from __future__ import annotations

import math
from bisect import bisect_left, insort
from collections.abc import Iterable, Iterator, Mapping
from itertools import islice

from ...langs.diagnostics import Diagnostic, Label, did_you_mean
from ...langs.source import PLACEHOLDER, Source, Span
from ..standard import import_hint

MOST_HINTS = 100
"""How many unknown names get a hint, which looks through all the known ones: as many as people are shown."""
FEW = 8
"""How many names a hint lists where none is near."""
SAME_TYPES = {"float": "real", "double": "real", "number": "real", "distance": "length", "meters": "length",
              "degrees": "angle", "radians": "angle", "seconds": "time", "robot": "module", "body": "object",
              "thing": "object", "hand": "gripper", "tool": "effector"}  # fmt: skip
"""Types by the names of other languages."""


class Findings:
    """A growing list of diagnostics. The first message at a place wins: later ones there follow from it."""

    def __init__(self, sources: Iterable[Source]) -> None:
        self._texts: Mapping[str, str] = {s.path: s.text for s in sources}
        self._order = {path: i for i, path in enumerate(self._texts)}
        self._found: dict[tuple[str, Span | None], Diagnostic] = {}
        self._starts: dict[str, list[int]] = {}
        self.hints = 0
        self._words: dict[tuple[str, int, int, str, int], Span] = {}
        self.errors = 0
        """How many errors were found so far."""

    def add(self, diagnostic: Diagnostic) -> None:
        key = (diagnostic.code if diagnostic.span is None else diagnostic.code[0], diagnostic.span)
        if key in self._found:
            return
        self._found[key] = diagnostic
        if diagnostic.is_error:
            self.errors += 1
            if diagnostic.span is not None:
                insort(self._starts.setdefault(diagnostic.span.file, []), diagnostic.span.start)

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
        if name == PLACEHOLDER:
            return
        self.hints += 1
        help = self._hint(code, name, candidates) if self.hints <= MOST_HINTS else None
        self.report(code, span, f"unknown {what} `{name}`", help=help)

    def _hint(self, code: str, name: str, candidates: Iterable[str]) -> str | None:
        names = list(dict.fromkeys(candidates))
        help = import_hint(code, name) or did_you_mean(name, names)
        if code == "E0102" and help is None and name.lower() in SAME_TYPES:
            help = f"did you mean `{SAME_TYPES[name.lower()]}`?"
        if help is None and 0 < len(names) <= FEW:
            help = f"known here: {', '.join(f'`{n}`' for n in names)}"
        return help

    def text(self, span: Span) -> str:
        """The source text of `span`."""
        return self._texts.get(span.file, "")[span.start : span.end]

    def word(self, span: Span, word: str, occurrence: int = 0) -> Span:
        """The span of `word` inside `span`; `span` itself where the word is not found."""
        key = span.file, span.start, span.end, word, occurrence
        if key not in self._words:
            self._words[key] = self._found_word(span, word, occurrence)
        return self._words[key]

    def _found_word(self, span: Span, word: str, occurrence: int) -> Span:
        text = self._texts.get(span.file)
        if text is None:
            return span
        start = next(islice(_places(text, word, span.start, span.end), occurrence, None), None)
        if start is None:
            return span
        end = start + len(word)
        breaks = text.count("\n", span.start, start)
        line = span.line + breaks
        column = span.column + start - span.start if not breaks else start - text.rfind("\n", span.start, start)
        return Span(span.file, start, end, line, column, line, column + len(word))

    def __iter__(self) -> Iterator[Diagnostic]:
        return iter(self._found.values())

    @property
    def has_errors(self) -> bool:
        return self.errors > 0

    def errors_within(self, spans: Iterable[Span]) -> bool:
        """Whether an error lies inside one of `spans`."""
        return any(self._first_from(span) < span.end for span in spans)

    def errors_in(self, files: Iterable[str]) -> bool:
        """Whether an error lies in one of `files`."""
        return any(self._starts.get(file) for file in files)

    def _first_from(self, span: Span) -> float:
        """Where the first error behind the start of `span` starts."""
        starts = self._starts.get(span.file, [])
        index = bisect_left(starts, span.start)
        return starts[index] if index < len(starts) else math.inf

    def sorted(self) -> tuple[Diagnostic, ...]:
        """All diagnostics by file (the main file first), then by place."""
        return tuple(sorted(self._found.values(), key=self._place))

    def _place(self, d: Diagnostic) -> tuple[int, int, str]:
        if d.span is None:
            return -1, 0, d.code
        return self._order.get(d.span.file, len(self._order)), d.span.start, d.code


def _places(text: str, word: str, start: int, end: int) -> Iterator[int]:
    """Where `word` stands as a whole word in a stretch of `text`."""
    while word and (start := text.find(word, start, end)) >= 0:
        behind = start + len(word)
        if not (start > 0 and _in_word(text[start - 1])) and not (behind < len(text) and _in_word(text[behind])):
            yield start
        start = behind


def _in_word(character: str) -> bool:
    return character.isalnum() or character == "_"
