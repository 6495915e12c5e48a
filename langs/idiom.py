"""A form that is no part of the language, as a pattern of text, and how the language says the same."""

from __future__ import annotations

import re
from collections.abc import Callable

from .frozen import dataclass

Writer = Callable[[re.Match[str]], str]
NAME = r"[A-Za-z_]\w*"
ITEM = r"[^,\[\]()\n]"
LITERAL = r"\([^()\n]*\)"


@dataclass(frozen=True, slots=True)
class Idiom:
    """`write` gives what is meant: a template, a function of the match, or None where it is left out. `help` is said
    where there is more to say than `write`."""

    pattern: re.Pattern[str]
    message: str
    write: str | Writer | None = None
    help: str | None = None
    code: str = "E0001"

    @property
    def several_lines(self) -> bool:
        return r"\s" in self.pattern.pattern

    def meant(self, match: re.Match[str]) -> str:
        if self.write is None:
            return ""
        return match.expand(self.write) if isinstance(self.write, str) else self.write(match)

    def hint(self, match: re.Match[str]) -> str:
        return self.help or (f"write `{self.meant(match).strip()}`" if self.write is not None else "leave it out")

    def stretch(self, match: re.Match[str]) -> tuple[int, int]:
        """What is replaced."""
        return match.span("x") if "x" in self.pattern.groupindex else match.span()


def idiom(pattern: str, message: str, write: str | Writer | None = None, help: str | None = None,
           code: str = "E0001") -> Idiom:  # fmt: skip
    return Idiom(re.compile(pattern, re.MULTILINE), message, write, help, code)
