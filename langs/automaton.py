"""The LALR automaton without values: cheap enough to try several repairs of a mistake and keep the best.

A stack is a linked list of states, so that keeping the stack before every token costs nothing.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence

from lark import Lark, Token, UnexpectedCharacters
from lark.lexer import ContextualLexer, LexerState, LexerThread, LineCounter

from .frozen import dataclass

DECLARATIONS = (
    "import", "type", "predicate", "derived", "function", "module", "motion", "rule", "placement", "heuristic", "scene",
    "task",
)  # fmt: skip


def declares(token: Token) -> bool:
    """Whether this begins a declaration, though a name fits there too: a faulty text ends what stands before it."""
    return token.column == 1 and str(token) in DECLARATIONS


def ends_before(token: Token) -> bool:
    """Whether a sound text ends before this word, which was read as a name though it begins a declaration."""
    return token.type == "NAME" and declares(token)


@dataclass(frozen=True, slots=True)
class Stack:
    state: int
    below: Stack | None


@dataclass(frozen=True, slots=True)
class Unreadable:
    """No terminal of the language starts at `position`."""

    position: int


class Automaton:
    """Lexing and parsing steps over one text."""

    def __init__(self, parser: Lark, text: str) -> None:
        state = parser.parse_interactive("").parser_state
        lexer = state.lexer.lexer
        assert isinstance(lexer, ContextualLexer)
        self.text = text
        self._lexer = lexer
        self._table = state.parse_conf.states
        self._end = state.parse_conf.end_state
        start = LexerThread.from_text(lexer, text).state
        assert start is not None
        self._text = start.text
        self._parser = parser
        self._line_starts = [0, *(i + 1 for i, c in enumerate(text) if c == "\n")]
        self.bottom = Stack(state.position, None)
        self.keywords = {
            t.name: t.pattern.value.split("(?!")[0]
            for t in parser.terminals
            if t.priority and "|" not in t.pattern.value
        } | {"_NOT": "not"}

    def other(self, text: str) -> Automaton:
        """The same automaton over another text."""
        return Automaton(self._parser, text)

    def accepts(self, stack: Stack) -> list[str]:
        """The terminals that may follow, in a fixed order."""
        return sorted(
            k for k in self._table[stack.state] if k.lstrip("_").isupper() and self.step(stack, k) is not None
        )

    def step(self, stack: Stack, kind: str) -> Stack | None:
        """The stack after a terminal of that kind; None when it does not fit."""
        while True:
            action = self._table[stack.state].get(kind)
            if action is None:
                return None
            if isinstance(action[1], int):
                return Stack(action[1], stack)
            rule = action[1]
            for _ in rule.expansion:
                assert stack.below is not None
                stack = stack.below
            stack = Stack(self._table[stack.state][rule.origin.name][1], stack)
            if kind == "$END" and stack.state == self._end:
                return stack

    def read(self, stack: Stack, position: int) -> Token | Unreadable | None:
        """The next terminal from `position`, one that fits where there is one; None at the end of the text."""
        try:
            try:
                fitting = self._lexer.lexers[stack.state].next_token(self._at(position), None)
                misread = fitting.type == "NAME" and declares(fitting)
                if not misread and self.step(stack, fitting.type) is not None:
                    return fitting
            except UnexpectedCharacters:
                pass
            return self._lexer.root_lexer.next_token(self._at(position), None)
        except UnexpectedCharacters as e:
            return Unreadable(e.pos_in_stream or 0)
        except EOFError:
            return None

    def may_be_left_over(self, token: Token, states: Sequence[int]) -> bool:
        """Whether a token is an indented brace that would end the declaration, with these states on the stack."""
        if token.type != "RBRACE" or (token.column or 0) < 2:
            return False
        stack: Stack | None = None
        for state in states:
            stack = Stack(state, stack)
        after = None if stack is None else self.step(stack, "RBRACE")
        return after is None or self.step(after, "$END") is not None

    def lexer_at(self, position: int) -> LexerThread:
        """What reads the text on from there."""
        return LexerThread(self._lexer, self._at(position))

    def place(self, position: int) -> tuple[int, int]:
        """Line and column of a position, from 1."""
        line = bisect_right(self._line_starts, position)
        return line, position - self._line_starts[line - 1] + 1

    def line_start(self, line: int) -> int:
        """Where that line starts; the end of the text past the last line."""
        return self._line_starts[line - 1] if line <= len(self._line_starts) else len(self.text)

    def token(self, kind: str, value: str, position: int, width: int = 0) -> Token:
        line, column = self.place(position)
        return Token(kind, value, position, line, column, line, column + width, position + width)

    def run(self, stack: Stack, position: int, limit: int) -> int:
        """How many terminals can be read from `position` before one does not fit; `limit` at the end of the text."""
        for count in range(limit):
            token = self.read(stack, position)
            if token is None:
                return limit if self.step(stack, "$END") is not None else count
            after = None if isinstance(token, Unreadable) else self.step(stack, token.type)
            if after is None or isinstance(token, Unreadable):
                return count
            stack, position = after, token.end_pos or position + 1
        return limit

    def _at(self, position: int) -> LexerState:
        line, column = self.place(position)
        counter = LineCounter.__new__(LineCounter)  # a copy of a state takes three times as long
        counter.newline_char = "\n"
        counter.char_pos, counter.line, counter.column, counter.line_start_pos = (
            position,
            line,
            column,
            position - column + 1,
        )
        return LexerState(self._text, counter)
