"""One source line as shown below a diagnostic: tabs as blanks, long lines shortened, columns in terminal cells."""

from __future__ import annotations

import unicodedata

from .source import Span

MAX_CELLS = 100
TAB = "    "
_BEFORE = 40
_NEAR = 1000
"""How many characters of a line are looked at on each side; the rest of a longer one cannot be shown."""


def clean(text: str) -> str:
    """The text without characters that would steer the terminal; newlines stay."""
    if text.isprintable():
        return text
    return "".join(
        c if c == "\n" or unicodedata.category(c) not in ("Cc", "Cf", "Cs") else "\N{REPLACEMENT CHARACTER}"
        for c in text
    )


def cells(text: str) -> int:
    """How many terminal columns the text takes."""
    return sum(_width(c) for c in text)


def _width(character: str) -> int:
    if unicodedata.combining(character):
        return 0
    return 2 if unicodedata.east_asian_width(character) in ("W", "F") else 1


class Excerpt:
    """`text` is the line to show; `marks` underlines the part of the span that lies on it."""

    def __init__(self, line: str, span: Span) -> None:
        begin = min(max(span.column - 1, 0), len(line))
        end = len(line) if span.end_line > span.line else min(max(span.end_column - 1, begin), len(line))
        parts = line[max(0, begin - _NEAR) : begin], line[begin : min(end, begin + _NEAR)], line[end : end + _NEAR]
        before, marked, after = map(_shown, parts)
        if cells(before) + cells(marked) + cells(after) > MAX_CELLS:
            before, marked, after = _shorten(before, marked, after)
        self.text = before + marked + after
        self._before = cells(before)
        self._marked = max(1, cells(marked))

    def marks(self, sign: str) -> str:
        return " " * self._before + sign * self._marked


def _shown(text: str) -> str:
    return clean(text.replace("\t", TAB))


def _shorten(before: str, marked: str, after: str) -> tuple[str, str, str]:
    if cells(before) > _BEFORE:
        before = "…" + _last(before, _BEFORE - 1)
    room = MAX_CELLS - cells(before)
    if cells(marked) > room:
        return before, _first(marked, room - 1) + "…", ""
    room -= cells(marked)
    return before, marked, after if cells(after) <= room else _first(after, max(room - 1, 0)) + "…"


def _first(text: str, room: int) -> str:
    kept = 0
    for character in text:
        room -= _width(character)
        if room < 0:
            break
        kept += 1
    return text[:kept]


def _last(text: str, room: int) -> str:
    return _first(text[::-1], room)[::-1]
