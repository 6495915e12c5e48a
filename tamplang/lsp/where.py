"""What is being written at a place: read from the words before it, in a text that need not be whole."""

from __future__ import annotations

import re
from dataclasses import dataclass

from lark import Token

from ..langs.automaton import Automaton, Unreadable
from ..langs.grammar_loader import parser
from ..langs.source import Source

_HEAD = re.compile(
    r"^(import|type|predicate|derived|function|module|motion|rule|placement|heuristic|scene|task)(?!\w)", re.MULTILINE
)
_OPENING = {"(": ")", "[": "]", "{": "}"}


@dataclass(frozen=True, slots=True)
class Use:
    """A call, literal or use whose arguments are being written; `argument` counts from 0."""

    kind: str
    name: str
    argument: int


@dataclass(frozen=True, slots=True)
class Context:
    """`before` are the tokens of the declaration up to the word that is being written, `word` what of it stands
    already, `expected` the terminals that may follow, `declaration` the word and name of the declaration."""

    before: tuple[Token, ...]
    word: str
    expected: frozenset[str]
    declaration: tuple[str, str]
    opened: tuple[int, ...]
    use: Use | None

    def last(self, back: int = 1) -> str:
        """The token so many places back; empty where there is none."""
        return str(self.before[-back]) if len(self.before) >= back else ""

    def block(self) -> str:
        """What stands before the innermost open brace: `options`, `post` of a rule, the word of the declaration …"""
        braces = [i for i in self.opened if self.before[i] == "{"]
        if not braces:
            return ""
        before = str(self.before[braces[-1] - 1]) if braces[-1] > 0 else ""
        return before if before == "options" else self.declaration[0]


def context_at(source: Source, offset: int) -> Context:
    start = max((m.start() for m in _HEAD.finditer(source.text, 0, offset)), default=0)
    word = re.search(r"\w*$", source.text[start:offset])
    written = word[0] if word is not None else ""
    before, expected = _read(source.text[start : offset - len(written)])
    opened = _opened(before)
    name = next((str(t) for t in before[1:] if t.type == "NAME"), "")
    declaration = (str(before[0]) if before else "", name)
    return Context(before, written, expected, declaration, opened, _use(before, opened))


def _read(text: str) -> tuple[tuple[Token, ...], frozenset[str]]:
    """The tokens of a beginning of a declaration, without those that do not fit, and what may follow."""
    automaton = Automaton(parser(), text)
    stack, position, found = automaton.bottom, 0, list[Token]()
    while True:
        token = automaton.read(stack, position)
        if token is None:
            return tuple(found), frozenset(automaton.accepts(stack))
        if isinstance(token, Unreadable):
            position = token.position + 1
            continue
        after = automaton.step(stack, token.type)
        if after is not None:
            stack = after
            found.append(token)
        position = max(token.end_pos or 0, position + 1)


def _opened(tokens: tuple[Token, ...]) -> tuple[int, ...]:
    """Where the brackets are that are still open."""
    stack: list[int] = []
    for index, token in enumerate(tokens):
        if token in _OPENING:
            stack.append(index)
        elif token in _OPENING.values() and stack:
            stack.pop()
    return tuple(stack)


def _use(tokens: tuple[Token, ...], opened: tuple[int, ...]) -> Use | None:
    if not opened or tokens[opened[-1]] == "{":
        return None
    place = opened[-1]
    inside = tokens[place + 1 :]
    before = tokens[place - 1] if place > 0 else None
    commas = sum(t == "," and _depth(tokens, place, i) == 1 for i, t in enumerate(tokens) if i > place)
    if tokens[place] == "[" and before is not None and before.type == "NAME":
        return None
    if tokens[place] == "(" and before is not None and before.type == "NAME":
        leading = str(tokens[place - 2]) if place > 1 else ""
        kind = {"scene": "scene", "guide": "heuristic"}.get(leading, "function")
        fresh_line = place > 1 and tokens[place - 2].line != before.line and str(tokens[0]) in ("task", "scene")
        return Use("module" if fresh_line and kind == "function" else kind, str(before), commas)
    if inside and inside[0].type == "NAME":
        kind = "motion" if tokens[place] == "[" else "predicate"
        return Use(kind, str(inside[0]), max(0, _arguments(inside[1:])))
    return None


def _depth(tokens: tuple[Token, ...], start: int, end: int) -> int:
    return sum((t in _OPENING) - (t in _OPENING.values()) for t in tokens[start:end])


def _arguments(tokens: tuple[Token, ...]) -> int:
    """How many arguments of a literal are whole: names that no point or bracket joins to the one before."""
    count, previous, depth = 0, "", 0
    for token in tokens:
        depth += (token == "[") - (token == "]")
        if depth == 0 and token.type in ("NAME", "NUMBER", "_ANY") and previous != ".":
            count += 1
        previous = str(token)
    return count
