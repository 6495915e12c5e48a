"""Source texts and the places in them. Lines and columns count from 1; offsets count characters from 0."""

from __future__ import annotations

from functools import lru_cache

from .frozen import dataclass

MAX_DEPTH = 100
"""How deep terms, conditions, imports and scenes may be nested."""
PLACEHOLDER = "?"
"""The name that stands where one lacks in a repaired text; no sound text has it as a name."""


@dataclass(frozen=True, slots=True)
class Span:
    """A stretch of one source text: characters `start` (inclusive) to `end` (exclusive)."""

    file: str
    start: int
    end: int
    line: int
    column: int
    end_line: int
    end_column: int

    def __str__(self) -> str:
        return f"{self.file}:{self.line}:{self.column}"


@dataclass(frozen=True, slots=True)
class Source:
    """One source file: `path` as the user should see it, and its whole text."""

    path: str
    text: str

    def line(self, number: int) -> str:
        """The text of line `number`, counted from 1, without its newline; empty past the end."""
        lines = _lines(self.text)
        return lines[number - 1] if 1 <= number <= len(lines) else ""


@lru_cache(maxsize=8)
def _lines(text: str) -> list[str]:
    """The lines of a text, split once for all that is said about it."""
    return text.split("\n")
