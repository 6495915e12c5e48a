"""Forms of other languages that are no mistakes of typing: what was meant, as tokens of this language."""

from __future__ import annotations

import re
from collections.abc import Sequence

from lark import Token

from .automaton import Automaton
from .build_terms import span_of
from .diagnostics import Diagnostic
from .frozen import dataclass
from .source import Source, Span
from .words import TYPES

_IMPORT = re.compile(r"from[ \t]+([\w.]+)[ \t]+import[ \t]+(\w+(?:[ \t]*,[ \t]*\w+)*)")


@dataclass(frozen=True, slots=True)
class Habit:
    """The tokens from index `keep` on are replaced by `feed`; reading goes on at `position`."""

    keep: int
    feed: tuple[Token, ...]
    position: int
    diagnostic: Diagnostic


def habit(source: Source, automaton: Automaton, reads: Sequence[Token], found: Token) -> Habit | None:
    """What is meant by the last of the tokens that were read and the one that does not fit."""
    if found == "from":
        return _from_import(source, automaton, reads, found)
    if found == "{":
        return _counted(source, automaton, reads, found)
    return _type_first(source, automaton, reads, found) if found in (",", ")", "=") else None


def _from_import(source: Source, automaton: Automaton, reads: Sequence[Token], found: Token) -> Habit | None:
    """`from std import rules`."""
    start = found.start_pos or 0
    match = _IMPORT.match(source.text, start)
    if match is None:
        return None
    targets = [f"{match[1]}.{name.strip()}" for name in match[2].split(",")]
    feed: list[Token] = []
    for target in targets:
        feed.append(automaton.token("_IMPORT", "import", start))
        for index, name in enumerate(target.split(".")):
            feed += [automaton.token("DOT", ".", start)] if index else []
            feed.append(automaton.token("NAME", name, start, match.end() - start))
    help = "write `" + "\n".join(f"import {t}" for t in targets) + "`"
    told = Diagnostic("E0001", "an import names what it takes over whole", _span(source, found, match.end()), help=help)
    return Habit(len(reads), tuple(feed), match.end(), told)


def _counted(source: Source, automaton: Automaton, reads: Sequence[Token], found: Token) -> Habit | None:
    """`for i in range(3) {`; of two arguments the second is not reached there."""
    opened = next((i for i in range(len(reads) - 1, 0, -1) if reads[i] == "("), 0)
    if not reads or reads[-1] != ")" or opened < 2 or reads[opened - 1] != "range" or reads[opened - 2] != "in":
        return None
    inside = list(reads[opened + 1 : -1])
    commas = [i for i, t in enumerate(inside) if t == ","]
    if not inside or len(commas) > 1:
        return None
    start, end = reads[opened - 1].start_pos or 0, reads[-1].end_pos or 0
    dots = automaton.token("_DOTS", "..", start)
    first = inside[: commas[0]] if commas else [automaton.token("NUMBER", "1", start)]
    last = inside[commas[0] + 1 :] if commas else inside
    shown = f"{_text(source, first)} .. {_text(source, last)}" if commas else f"1 .. {_text(source, last)}"
    if commas:
        number = str(last[0]) if len(last) == 1 else ""
        until = str(int(number) - 1) if number.isdigit() else f"{_text(source, last)} - 1"
        shown = f"{_text(source, first)} .. {until}"
    told = Diagnostic(
        "E0001", "a range is written with both its ends", _span(source, reads[opened - 1], end), help=f"write `{shown}`"
    )
    return Habit(opened - 1, (*first, dots, *last), found.start_pos or 0, told)


def _type_first(source: Source, automaton: Automaton, reads: Sequence[Token], found: Token) -> Habit | None:
    """`int n` among parameters: two names where a list of parameters has no colon."""
    if len(reads) < 3 or reads[-3] not in ("(", ",") or any(t.type != "NAME" for t in reads[-2:]):
        return None
    type, name = reads[-2], reads[-1]
    if str(name) in TYPES or (str(type) not in TYPES and not type[0].islower()):
        return None  # the name stands first, and only the colon lacks
    start = type.start_pos or 0
    feed = (
        automaton.token("NAME", str(name), start, len(name)),
        automaton.token("COLON", ":", start),
        automaton.token("NAME", str(type), start, len(type)),
    )
    told = Diagnostic(
        "E0003", "the type stands behind the name, after `:`", _span(source, type, name.end_pos or 0),
        help=f"write `{name}: {type}`",
    )  # fmt: skip
    return Habit(len(reads) - 2, feed, found.start_pos or 0, told)


def _text(source: Source, tokens: Sequence[Token]) -> str:
    if tokens[0].start_pos == tokens[0].end_pos:
        return str(tokens[0])
    return source.text[tokens[0].start_pos or 0 : tokens[-1].end_pos or 0]


def _span(source: Source, first: Token, end: int) -> Span:
    whole = span_of(source.path, first)
    return Span(whole.file, whole.start, end, whole.line, whole.column, whole.line, whole.column + end - whole.start)
