"""What a recovery may do to a text, and the repairs that the idioms of other languages give."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from lark import Token

from .automaton import Automaton, Stack
from .build_terms import span_of
from .diagnostics import Diagnostic
from .frozen import dataclass
from .idiom import Idiom
from .idioms import WORDS, idioms
from .source import Source, Span


@dataclass(frozen=True, slots=True)
class Read:
    """A token that fits, and the stack before it."""

    token: Token
    before: Stack


@dataclass(frozen=True, slots=True)
class Repair:
    """Keep the first `keep` tokens, then feed `feed`, then read on from `position`. Kind 0 corrects a word, 1 puts in
    or leaves out a sign, 2 leaves out lines. At least `needs` tokens must be readable after it."""

    kind: int
    keep: int
    feed: tuple[Token, ...]
    position: int
    diagnostic: Diagnostic
    needs: int = 2


def idiomatic(
    source: Source, automaton: Automaton, reads: Sequence[Read], stack: Stack, at: int
) -> Iterator[Repair]:
    """The repairs around the mistake `at`: what is read as its replacement reaches beyond it."""
    line = automaton.place(at)[0]
    if source.text[at : at + 1] in ("", "\n"):
        return
    first = automaton.line_start(max(1, line - 1))  # a mistake may show only in the line below it
    for idiom, match in idioms(source.text, first, automaton.line_start(line + 1), at):
        start, end = idiom.stretch(match)
        keep = next((i for i, r in enumerate(reads) if (r.token.start_pos or 0) >= start), len(reads))
        before = stack if keep == len(reads) else reads[keep].before
        word = match[0].strip()
        meant = idiom.meant(match) if idiom.message else WORDS[word]
        feed = _tokens(automaton, before, meant, start)
        if feed is not None:
            yield Repair(0, keep, feed, end, _told(source, automaton, idiom, match, word), 1)


COLON_FOR = {"=": ("COLON", ":"), ":": ("EQUAL", "=")}
PARTS = ("pre", "where", "post", "cost")


def exchanged(
    source: Source, automaton: Automaton, reads: Sequence[Read], stack: Stack, found: Token
) -> Iterator[Repair]:
    """`=` where `:` is meant and the other way round, `:` where a block begins, and a part of a rule that comes late or
    again."""
    kind, sign = COLON_FOR.get(str(found), ("", ""))
    here, end = span_of(source.path, found), found.end_pos or 0
    accepted = automaton.accepts(stack)
    if kind in accepted:
        told = Diagnostic("E0003", f"`{sign}` stands here, not `{found}`", here, help=f"write `{sign}`")
        yield Repair(0, len(reads), (automaton.token(kind, sign, found.start_pos or 0, 1),), end, told)
    ends_line = source.text[end : end + 1] in ("\n", "\r", "")
    if found == ":" and "LBRACE" in accepted and ends_line:
        told = Diagnostic("E0003", "a block stands between `{` and `}`", here, help="put `{` here and `}` at its end")
        yield Repair(0, len(reads), (automaton.token("LBRACE", "{", found.start_pos or 0, 1),), end, told)
    if found in PARTS and "COMMA" in accepted:
        help = "the parts of a rule stand in the order pre, where, post, cost, each at most once"
        told = Diagnostic("E0001", f"unexpected `{found}`", here, help=help)
        yield Repair(0, len(reads), (automaton.token("COMMA", ",", found.start_pos or 0),), end, told)


def _told(source: Source, automaton: Automaton, idiom: Idiom, match: re.Match[str], word: str) -> Diagnostic:
    start, end = idiom.stretch(match)
    if not idiom.message:
        start = end - len(word)
        message, help = f"`{word}` is no keyword", f"did you mean `{WORDS[word]}`?"
    else:
        message, help = idiom.message, idiom.hint(match)
    (line, column), (last, behind) = automaton.place(start), automaton.place(end)
    return Diagnostic(idiom.code, message, Span(source.path, start, end, line, column, last, behind), help=help)


def _tokens(automaton: Automaton, stack: Stack, text: str, start: int) -> tuple[Token, ...] | None:
    """The tokens of a replacement, all of them at `start`; None where they do not fit there."""
    inner = automaton.other(text)
    found: list[Token] = []
    position = 0
    while (token := inner.read(stack, position)) is not None:
        after = inner.step(stack, token.type) if isinstance(token, Token) else None
        if not isinstance(token, Token) or after is None:
            return None
        found.append(automaton.token(token.type, str(token), start, len(token)))
        stack, position = after, token.end_pos or position + 1
    return tuple(found)
