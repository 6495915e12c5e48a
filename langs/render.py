"""Diagnostics to text: the full form for people, one line each for editors, JSON and SARIF for programs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from .diagnostics import Diagnostic, Label
from .excerpt import Excerpt, clean
from .severity import severity
from .source import Source, Span

FORMATS = ("full", "concise", "json", "sarif")
MOST_SHOWN = 100
"""How many diagnostics people are shown; programs that read JSON or SARIF get all."""
_COLOURS = {
    "error": "\x1b[1;31m",
    "warning": "\x1b[1;33m",
    "outcome": "\x1b[1;35m",
    "frame": "\x1b[1;34m",
    "help": "\x1b[1;36m",
    "bold": "\x1b[1m",
}


def render(
    diagnostics: Iterable[Diagnostic], sources: Mapping[str, Source], format: str = "full", colour: bool = False
) -> str:
    """The text of the diagnostics, without a newline at its end; `sources` are the read files by path.

    `format` is one of FORMATS (ValueError otherwise); `colour` puts terminal escapes into the full form. The formats
    for people, full and concise, show MOST_SHOWN diagnostics, errors before others, and say how many more there are.
    """
    found = list(diagnostics)
    if format in ("full", "concise"):
        shown = _first(found)
        texts = [_Full(d, sources, colour).text() if format == "full" else _concise(d) for d in shown]
        if len(shown) < len(found):
            texts.append(f"and {len(found) - len(shown)} more")
        return ("\n\n" if format == "full" else "\n").join(texts)
    from .records import json_text, sarif_text

    if format == "json":
        return json_text(found)
    if format == "sarif":
        return sarif_text(found)
    raise ValueError(f"no format {format!r}; one of {', '.join(FORMATS)}")


def _first(found: Sequence[Diagnostic]) -> list[Diagnostic]:
    """The diagnostics to show, in their order; where there are too many, errors go before others."""
    chosen = sorted(range(len(found)), key=lambda i: not found[i].is_error)[:MOST_SHOWN]
    return [found[i] for i in sorted(chosen)]


def _concise(diagnostic: Diagnostic) -> str:
    place = "" if diagnostic.span is None else f"{diagnostic.span}: "
    return clean(f"{place}{diagnostic.code} {diagnostic.message}").replace("\n", " ")


class _Full:
    """One diagnostic in the full form."""

    def __init__(self, diagnostic: Diagnostic, sources: Mapping[str, Source], colour: bool) -> None:
        self._diagnostic = diagnostic
        self._sources = sources
        self._colour = colour
        spans = [s for s in (diagnostic.span, *(label.span for label in diagnostic.labels)) if s is not None]
        self._gutter = " " * max([len(str(s.line)) for s in spans], default=0)

    def text(self) -> str:
        diagnostic = self._diagnostic
        kind = severity(diagnostic)
        lines = [
            self._paint(kind, f"{kind}[{diagnostic.code}]") + self._paint("bold", f": {clean(diagnostic.message)}")
        ]
        if diagnostic.span is not None:
            lines += self._places(diagnostic.span)
        for word, remark in (("help", diagnostic.help), ("note", diagnostic.note)):
            if remark is not None:
                lines += self._remark(word, clean(remark))
        return "\n".join(lines)

    def _places(self, span: Span) -> list[str]:
        """The file of the diagnostic, then every other file that a label points to."""
        own = [label for label in self._diagnostic.labels if label.span.file == span.file]
        lines = [self._frame("-->", span), *self._excerpts(span, own)]
        others = [label for label in self._diagnostic.labels if label.span.file != span.file]
        for label in others:
            lines += [self._frame(":::", label.span), *self._excerpts(None, [label], label.span.file)]
        return lines

    def _excerpts(self, span: Span | None, labels: Sequence[Label], file: str | None = None) -> list[str]:
        source = self._sources.get(span.file if span is not None else file or "")
        if source is None:
            return []
        marked: list[tuple[Span, str, bool]] = [(label.span, clean(label.text), False) for label in labels]
        if span is not None:
            marked.append((span, "", True))
        lines = [self._bar("")]
        last: int | None = None
        shown = ""
        for place, words, main in sorted(marked, key=lambda m: (m[0].line, not m[2], m[0].start)):
            if last is not None and place.line > last + 1:
                lines.append(self._paint("frame", "..."))
            excerpt = Excerpt(source.line(place.line), place)
            if place.line != last:
                number = str(place.line).rjust(len(self._gutter))
                shown = excerpt.text
                lines.append(f"{self._paint('frame', f'{number} |')} {shown}".rstrip())
            marks = excerpt.marks("^" if main else "-") if excerpt.text == shown else ""
            mark = f"{marks} {words}".rstrip()
            lines.append(self._bar(self._paint(severity(self._diagnostic) if main else "frame", mark)))
            last = place.line
        return lines

    def _frame(self, arrow: str, span: Span) -> str:
        return f"{self._gutter}{self._paint('frame', arrow)} {clean(str(span))}"

    def _bar(self, rest: str) -> str:
        return f"{self._gutter} {self._paint('frame', '|')} {rest}".rstrip()

    def _remark(self, word: str, text: str) -> list[str]:
        first, *rest = text.split("\n")
        indent = " " * (len(self._gutter) + 5 + len(word))
        head = f"{self._gutter} {self._paint('frame', '=')} {self._paint('help', word)}: {first}"
        return [head, *(indent + line for line in rest)]

    def _paint(self, name: str, text: str) -> str:
        return f"{_COLOURS[name]}{text}\x1b[0m" if self._colour else text
