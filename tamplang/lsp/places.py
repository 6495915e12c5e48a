"""Offsets of characters, lines and columns of editors: those count UTF-16 units unless client and server agree."""

from __future__ import annotations

import re
from bisect import bisect_right
from dataclasses import dataclass
from functools import lru_cache

from lsprotocol import types

_ENDS = re.compile(r"\r\n|\n|\r")


@dataclass(frozen=True, slots=True)
class Places:
    """The lines of one text; `unit` is utf-8, utf-16 or utf-32."""

    text: str
    starts: tuple[int, ...]
    unit: str

    def position(self, offset: int) -> types.Position:
        """Line and column of a character."""
        line = bisect_right(self.starts, min(max(offset, 0), len(self.text))) - 1
        return types.Position(line, self._size(self.text[self.starts[line] : offset]))

    def offset(self, position: types.Position) -> int:
        """The character at a place; the end of the line or text where there is none."""
        if position.line >= len(self.starts):
            return len(self.text)
        start = self.starts[position.line]
        line = _ENDS.split(self.text[start : self._end(position.line)], maxsplit=1)[0]
        size = 0
        for index, character in enumerate(line):
            if size >= position.character:
                return start + index
            size += self._size(character)
        return start + len(line)

    def range(self, start: int, end: int) -> types.Range:
        return types.Range(self.position(start), self.position(end))

    def _end(self, line: int) -> int:
        return self.starts[line + 1] if line + 1 < len(self.starts) else len(self.text)

    def _size(self, text: str) -> int:
        if self.unit == "utf-32" or text.isascii():
            return len(text)
        return len(text.encode("utf-8")) if self.unit == "utf-8" else len(text.encode("utf-16-le")) // 2


@lru_cache(maxsize=64)
def places_of(text: str, unit: str) -> Places:
    return Places(text, (0, *(m.end() for m in _ENDS.finditer(text))), unit)
