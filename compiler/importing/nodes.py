"""Texts in brackets, as PDDL and rai's rules have them: to words and groups with their places."""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import field

from ...langs.diagnostics import Diagnostic, SourceError, did_you_mean
from ...langs.frozen import dataclass
from ...langs.source import Source, Span
from .faults import FaultList

DEEPEST = 100
"""How deep groups may be nested, as in the language itself."""
_TOKEN = re.compile(r";[^\n]*|[()]|\??[^\s();?]+|\?")  # variables need no blank before them


@dataclass(frozen=True, slots=True)
class Token:
    """A word, in small letters: PDDL knows no others."""

    text: str
    start: int
    end: int


@dataclass(slots=True)
class Group:
    """What stands between two brackets."""

    start: int
    end: int = 0
    items: list[Token | Group] = field(default_factory=list)

    @property
    def head(self) -> str:
        """The first word, or nothing."""
        first = self.items[0] if self.items else None
        return first.text if isinstance(first, Token) else ""

    @property
    def rest(self) -> list[Token | Group]:
        """What follows the head."""
        return self.items[1:]

    def groups(self) -> Iterator[Group]:
        """The groups inside."""
        return (item for item in self.items if isinstance(item, Group))


Node = Token | Group


class Faults(FaultList):
    """All that is to be said of one text in brackets."""

    def __init__(self, source: Source) -> None:
        super().__init__()
        self.source = source
        self._starts = [0, *(m.end() for m in re.finditer("\n", source.text))]

    def span(self, start: int, end: int) -> Span:
        """The place of some characters."""
        first, last = (bisect_right(self._starts, offset) for offset in (start, max(start, end)))
        columns = start - self._starts[first - 1] + 1, max(start, end) - self._starts[last - 1] + 1
        return Span(self.source.path, start, end, first, columns[0], last, columns[1])

    def tell(self, code: str, node: Node, message: str, help: str | None = None) -> None:
        """Note a fault. Of a group over several lines its head is shown. Raises SourceError when there are too many."""
        end = node.end
        if isinstance(node, Group) and "\n" in self.source.text[node.start : node.end]:
            end = node.items[0].end if node.items and isinstance(node.items[0], Token) else node.start + 1
        self.add(code, self.span(node.start, end), message, help)

    def unknown(self, node: Token, what: str, known: Sequence[str]) -> None:
        """A name that nothing declares."""
        self.tell("E0022", node, f"unknown {what} `{node.text}`", did_you_mean(node.text, known))


def read_groups(faults: Faults) -> list[Group]:
    """The groups of a text, outermost. Raises SourceError (E0019) where brackets do not fit or words stand outside."""
    source = faults.source
    made: list[Group] = []
    open_: list[Group] = []
    for match in _TOKEN.finditer(source.text):
        text, start, end = match.group(), match.start(), match.end()
        if text.startswith(";"):
            continue
        if text == "(":
            open_.append(Group(start))
            if len(open_) > DEEPEST:
                raise _broken(faults, start, f"brackets are nested more than {DEEPEST} deep")
        elif text == ")":
            if not open_:
                raise _broken(faults, start, "`)` closes nothing", "take it out, or look for a `(` that is missing")
            group = open_.pop()
            group.end = end
            (open_[-1].items if open_ else made).append(group)
        elif not open_:
            raise _broken(faults, start, f"`{text[:40]}` stands outside all brackets", end=end)
        else:
            open_[-1].items.append(Token(text.lower(), start, end))
    if open_:
        help = "the file may be cut off; add what is missing behind the end"
        raise _broken(faults, open_[-1].start, "`(` is never closed", help)
    return made


def _broken(faults: Faults, start: int, message: str, help: str | None = None, end: int | None = None) -> SourceError:
    return SourceError([Diagnostic("E0019", message, faults.span(start, end or start + 1), help=help)])
