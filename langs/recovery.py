"""Repair of a text that does not parse: every mistake gives one diagnostic, and the rest is read on.

At a mistake several repairs are tried on the automaton, the surest kind first: a misspelt keyword or a wrong unit, then
one sign that lacks or is too many, then leaving out the line. Within a kind the repair after which most can be read
wins, and as few lines as possible are left out; where none works, the text up to the next declaration is skipped.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from difflib import get_close_matches

from lark import Lark, Token

from . import complaints
from .automaton import DECLARATIONS, Automaton, Stack, Unreadable, ends_before
from .diagnostics import Diagnostic
from .habits import habit
from .repairs import Read, Repair, exchanged, idiomatic
from .source import PLACEHOLDER, Source

MAX_ERRORS = 50
LOOKAHEAD = 40
RECENT = 12
SURE = 20
SKIP = 2
_SIGNS = {
    "COMMA": ",",
    "COLON": ":",
    "LPAR": "(",
    "RPAR": ")",
    "LBRACE": "{",
    "RBRACE": "}",
    "LSQB": "[",
    "RSQB": "]",
    "EQUAL": "=",
    "_DOTS": "..",
}
_OPENING = {"LPAR", "LBRACE", "LSQB"}
_LINKS = {"_ON", "_IN", "_AT", "_THEN", "_ELSE", "_OF", "_BY", "_IS", "_SWITCH"}
_DECLARATION = re.compile(rf"^({'|'.join(DECLARATIONS)})(?!\w)", re.MULTILINE)


class Recovery:
    def __init__(self, parser: Lark, source: Source, sound: Sequence[Token] = ()) -> None:
        """`sound` are the tokens of the text before its first mistake, as far as they are known."""
        self.automaton = Automaton(parser, source.text)
        self.source = source
        self.reads: list[Read] = []
        self.stack = self.automaton.bottom
        self.position = 0
        self.diagnostics: list[Diagnostic] = []
        self._sure = 0
        self.finished = False
        self.take(sound)

    def take(self, sound: Sequence[Token]) -> None:
        """Go on behind tokens that were read without a repair, as far as a name does not declare anything."""
        for token in sound:
            if ends_before(token) or not self._feed(token):
                break

    def tokens(self, settled: int | None = None) -> list[Token]:
        """The tokens of the repaired text, so far as it was read: to its end, or until so many of them follow the last
        repair that fit; what was wrong is in `diagnostics`."""
        while len(self.diagnostics) < MAX_ERRORS:
            token = self.automaton.read(self.stack, self.position)
            if token is None and self.automaton.step(self.stack, "$END") is not None:
                self.finished = True
                return [r.token for r in self.reads]
            if isinstance(token, Token) and self._left_over(token):
                self.position = token.end_pos or 0
            elif not isinstance(token, Token) or not self._feed(token):
                self._repair(token)
                self._sure = 0
            else:
                self._sure += 1
                if settled is not None and self._sure >= settled and self.diagnostics:
                    return [r.token for r in self.reads]
        self._forget(self._declaration_start())
        self.finished = True
        return [r.token for r in self.reads]

    def _left_over(self, token: Token) -> bool:
        """Whether this is the indented closing brace of a block whose head was left out as unfinished: it would end the
        declaration."""
        if token.type != "RBRACE" or not self.diagnostics or not self.reads:
            return False
        after = self.automaton.step(self.stack, "RBRACE")
        if after is not None and self.automaton.step(after, "$END") is None:
            return False
        started = self.reads[self._declaration_start()].token
        told = self.diagnostics[-1].span
        within = told is not None and told.start >= (started.start_pos or 0)
        first = self.reads[-1].token.line != token.line
        return within and first and (token.column or 0) > (started.column or 0)

    def _feed(self, token: Token) -> bool:
        after = self.automaton.step(self.stack, token.type)
        if after is None:
            return False
        self.reads.append(Read(token, self.stack))
        self.stack, self.position = after, token.end_pos or self.position
        return True

    def _forget(self, keep: int) -> None:
        if keep < len(self.reads):
            self.stack = self.reads[keep].before
            del self.reads[keep:]

    # --- repairs -------------------------------------------------------------------------------------------------

    def _repair(self, found: Token | Unreadable | None) -> None:
        repairs = list(self._repairs(found))
        for kind in range(SKIP + 1):
            tried = [(self._reach(r), r) for r in repairs if r.kind == kind]
            good = [(reach, r) for reach, r in tried if reach >= r.needs]
            if good:
                self._apply(good[0][1] if kind == SKIP else max(good, key=lambda t: t[0])[1])
                return
        self._skip_declaration(found)

    def _apply(self, repair: Repair) -> None:
        opened = {d.span for d in self.diagnostics if d.code == "E0003"}
        follows = any(label.span in opened for label in repair.diagnostic.labels)
        if not follows and (not self.diagnostics or self.diagnostics[-1].span != repair.diagnostic.span):
            self.diagnostics.append(repair.diagnostic)
        self._forget(repair.keep)
        for token in repair.feed:
            self._feed(token)
        self.position = repair.position

    def _reach(self, repair: Repair) -> int:
        """How many tokens beyond the mistake can be read after the repair; negative when the repair does not fit."""
        stack = self.stack if repair.keep == len(self.reads) else self.reads[repair.keep].before
        for token in repair.feed:
            after = self.automaton.step(stack, token.type)
            if after is None:
                return -1
            stack = after
        again = sum((r.token.start_pos or 0) >= repair.position for r in self.reads[repair.keep :])
        reached = self.automaton.run(stack, repair.position, LOOKAHEAD + again)
        return min(reached - again, LOOKAHEAD)

    def _repairs(self, found: Token | Unreadable | None) -> Iterator[Repair]:
        if found is not None:
            yield from idiomatic(self.source, self.automaton, self.reads, self.stack, _start(found))
        if isinstance(found, Unreadable):
            yield from self._unreadable(found)
        else:
            if found is not None:
                yield from exchanged(self.source, self.automaton, self.reads, self.stack, found)
            yield from self._habits(found)
            yield from self._keywords(found)
            yield from self._bare_literal(found)
            insertions = list(self._insertions(found))
            here = [r for r in insertions if r.keep == len(self.reads)]
            yield from here
            yield from self._corrections(found)
            yield from self._half_typed(found)
            yield from (r for r in insertions if r.keep < len(self.reads))
            yield from self._omissions(found)
        yield from self._skipped_lines(found)

    def _habits(self, found: Token | None) -> Iterator[Repair]:
        """What is usual in other languages."""
        tokens = [r.token for r in self.reads]
        meant = None if found is None else habit(self.source, self.automaton, tokens, found)
        if meant is not None:
            yield Repair(0, meant.keep, meant.feed, meant.position, meant.diagnostic)

    def _recent(self, found: Token | None) -> Iterator[tuple[int, Token, Stack]]:
        """The mistake and the tokens before it, nearest first."""
        if found is not None:
            yield len(self.reads), found, self.stack
        for index in range(len(self.reads) - 1, max(-1, len(self.reads) - RECENT), -1):
            yield index, self.reads[index].token, self.reads[index].before

    def _keywords(self, found: Token | None) -> Iterator[Repair]:
        for index, token, before in self._recent(found):
            if token.type != "NAME" or len(token) < 2:
                continue
            if str(token) in self.automaton.keywords.values():
                yield from self._shadowed(index, token, before)
                continue
            fitting = {
                self.automaton.keywords[k]: k for k in self.automaton.accepts(before) if k in self.automaton.keywords
            }
            for near in get_close_matches(str(token), sorted(fitting), n=2, cutoff=0.6):
                keyword = self._replaced(token, fitting[near], near)
                yield Repair(0, index, (keyword,), token.end_pos or 0, complaints.misspelt(self.source, token, near))

    def _shadowed(self, index: int, token: Token, before: Stack) -> Iterator[Repair]:
        """A keyword read as a name, because a name or value lacks before it, or a comma is too many."""
        start = token.start_pos or 0
        if index > 0 and self.reads[index - 1].token == ",":
            comma = self.reads[index - 1].token
            yield Repair(0, index - 1, (), start, complaints.dangling(self.source, comma), 3)
        if index < len(self.reads):
            name = self.automaton.token("NAME", PLACEHOLDER, start)
            yield Repair(0, index, (name,), start, self._unexpected_at(token, index, before), 3)

    def _bare_literal(self, found: Token | None) -> Iterator[Repair]:
        """`goal held target`: a literal without its parentheses, where only a condition can stand."""
        for index, name, stack in self._recent(found):
            opened = index > 0 and self.reads[index - 1].token == "("
            if name.type == "NAME" and not opened and self._takes_literal(stack):
                break
        else:
            return
        words = [self.automaton.token("LPAR", "(", name.start_pos or 0), name]
        token = self.automaton.read(self._after(stack, words), name.end_pos or 0)
        while isinstance(token, Token) and token.type == "NAME" and token.line == name.line:
            words.append(token)
            token = self.automaton.read(self._after(stack, words), token.end_pos or 0)
        if len(words) > 2 and token != ")":
            end = words[-1].end_pos or 0
            closed = (*words, self.automaton.token("RPAR", ")", end))
            yield Repair(0, index, closed, end, complaints.bare_literal(self.source, words[1:]))

    def _takes_literal(self, stack: Stack) -> bool:
        fitting = self.automaton.accepts(stack)
        return "_NOT" in fitting or set(fitting) == {"LPAR", "LSQB"}

    def _after(self, stack: Stack, tokens: list[Token]) -> Stack:
        """The stack after as many of the tokens as fit."""
        for token in tokens:
            stack = self.automaton.step(stack, token.type) or stack
        return stack

    def _insertions(self, found: Token | None) -> Iterator[Repair]:
        """Put one sign or small word before the mistake, one or two tokens earlier, or at the end of a line above."""
        end = len(self.source.text)
        for back, (index, token, before) in enumerate(self._recent(found) if found is not None else self._at_end()):
            line_starts = index > 0 and self.reads[index - 1].token.line != token.line
            if back > 2 and not line_starts:
                continue
            position = end if token.start_pos is None else token.start_pos
            for kind in self.automaton.accepts(before):
                if kind in _SIGNS or kind in _LINKS:
                    text = _SIGNS.get(kind) or self.automaton.keywords[kind]
                    sign = self.automaton.token(kind, text, position)
                    needs = SURE if kind in _OPENING else 3
                    yield Repair(1, index, (sign,), position, self._lacking(text, index, token), needs)

    def _at_end(self) -> Iterator[tuple[int, Token, Stack]]:
        yield len(self.reads), self.automaton.token("$END", "", len(self.source.text)), self.stack

    def _corrections(self, found: Token | None) -> Iterator[Repair]:
        """A word that is no unit, or a comma that nothing follows."""
        before = self.reads[-1].token if self.reads else None
        if found is None:
            return
        words = [(len(self.reads), found), *((i, self.reads[i].token) for i in range(len(self.reads) - 1, -1, -1)[:1])]
        for index, word in words:
            number = self.reads[index - 1].token if index > 0 else None
            unit = None if number is None else complaints.unknown_unit(self.source, number, word)
            if unit is not None:
                yield Repair(0, index, (), word.end_pos or 0, unit)
        if before is not None and before == ",":
            yield Repair(1, len(self.reads) - 1, (), found.start_pos or 0, complaints.dangling(self.source, before), 3)

    def _omissions(self, found: Token | None) -> Iterator[Repair]:
        if found is None:
            return
        if self.reads and self.reads[-1].token == "}" and found != "}":
            brace = self.reads[-1].token
            early = complaints.ended_early(self.source, brace)
            yield Repair(1, len(self.reads) - 1, (), found.start_pos or 0, early, 3)
        in_literal = found == "," and "_ANY" in self.automaton.accepts(self.stack)
        unexpected = self._unexpected(found)
        yield Repair(0 if in_literal else 1, len(self.reads), (), found.end_pos or 0, unexpected, 3)
        name = self.automaton.token("NAME", PLACEHOLDER, found.start_pos or 0)
        yield Repair(1, len(self.reads), (name,), found.start_pos or 0, unexpected, 3)

    def _half_typed(self, found: Token | None) -> Iterator[Repair]:
        """Leave out the unfinished statement above the line of the mistake, and read that line in its place; where the
        head of a declaration is unfinished, go on with the next declaration."""
        if found is None or not self.reads:
            return
        first = len(self.reads)
        while first > 0 and self.reads[first - 1].token.line == found.line:
            first -= 1
        start = self._declaration_start()
        if first <= start or self._whole_before(first):
            return
        position = found.start_pos or 0 if first == len(self.reads) else self.reads[first].token.start_pos or 0
        told = self._unfinished(first, position)
        yield from self._closed_above(first, position)
        as_name = first < len(self.reads) and str(self.reads[first].token) in self.automaton.keywords.values()
        kind = 0 if as_name and self.reads[first].token.type == "NAME" else 1
        for keep in range(first - 1, start - 1, -1):
            before = self.reads[keep].before
            if keep > start and self.reads[keep - 1].token.line == self.reads[keep].token.line:
                continue
            if self.automaton.run(before, position, 1) == 1:
                yield Repair(kind, keep, (), position, told, 3)
                return
        if self.reads[first - 1].token.line == self.reads[start].token.line:
            yield Repair(1, start, (), self._next_declaration(position), told, 3)

    def _closed_above(self, index: int, position: int) -> Iterator[Repair]:
        """The bracket that lacks at the end of the line above the token at `index`, whose words would go on in it."""
        before = self.stack if index == len(self.reads) else self.reads[index].before
        for kind in ("RPAR", "RSQB"):
            if kind in self.automaton.accepts(before):
                sign = self.automaton.token(kind, _SIGNS[kind], position)
                yield Repair(0, index, (sign,), position, self._lacking(_SIGNS[kind], index, sign), 3)

    def _whole_before(self, index: int) -> bool:
        """Whether the text before that token could end there, at a brace or the end of the file."""
        before = self.stack if index == len(self.reads) else self.reads[index].before
        ends = self.automaton.step(before, "RBRACE") or self.automaton.step(before, "$END")
        return ends is not None or self.reads[index - 1].token == "{"

    def _unfinished(self, index: int, position: int) -> Diagnostic:
        """What lacks behind the last token before `index`, where another line starts at `position`."""
        before = self.stack if index == len(self.reads) else self.reads[index].before
        return complaints.unfinished(
            self.source, self.reads[index - 1].token, self.automaton.accepts(before), self.automaton.keywords
        )

    def _next_declaration(self, position: int) -> int:
        following = _DECLARATION.search(self.source.text, position)
        return following.start() if following is not None else len(self.source.text)

    def _unreadable(self, found: Unreadable) -> Iterator[Repair]:
        strange = complaints.unreadable(self.source, found.position, self.automaton)
        position = found.position + strange.width
        if strange.meant is not None:
            word = self.automaton.token(*strange.meant, found.position, strange.width)
            yield Repair(0, len(self.reads), (word,), position, strange.diagnostic, 0)
        yield Repair(1, len(self.reads), (), position, strange.diagnostic, 1)

    def _skipped_lines(self, found: Token | Unreadable | None) -> Iterator[Repair]:
        """Leave out the whole line of the mistake, or it and one or two more."""
        if found is None:
            return
        line = found.line or 1 if isinstance(found, Token) else self.automaton.place(found.position)[0]
        keep = len(self.reads)
        while keep > 0 and self.reads[keep - 1].token.line == line:
            keep -= 1
        for more in (1, 2, 3):
            yield Repair(2, keep, (), self.automaton.line_start(line + more), self._complaint(found))

    def _skip_declaration(self, found: Token | Unreadable | None) -> None:
        self.diagnostics.append(self._complaint(found))
        start = self.position if found is None else _start(found)
        self._forget(self._declaration_start())
        following = self._next_declaration(start)
        if following == start and not self._reads_anything(start):
            following = self._next_declaration(start + 1)
        self.position = following

    def _reads_anything(self, position: int) -> bool:
        return self.automaton.run(self.stack, position, 1) > 0

    def _declaration_start(self) -> int:
        """The index of the first token of the declaration that is being read."""
        for index in range(len(self.reads) - 1, -1, -1):
            before, token = self.reads[index].before, self.reads[index].token
            begins = str(token) in DECLARATIONS and self.automaton.step(before, "$END") is not None
            if before.below is None or begins:
                return index
        return 0

    # --- what to say ---------------------------------------------------------------------------------------------

    def _complaint(self, found: Token | Unreadable | None) -> Diagnostic:
        if isinstance(found, Unreadable):
            return complaints.unreadable(self.source, found.position, self.automaton).diagnostic
        return self._unexpected(found)

    def _unexpected(self, found: Token | None) -> Diagnostic:
        token = found or self.automaton.token("$END", "", len(self.source.text))
        return self._unexpected_at(token, len(self.reads), self.stack)

    def _unexpected_at(self, token: Token, index: int, before: Stack) -> Diagnostic:
        previous = self.reads[index - 1].token if index > 0 else None
        return complaints.unexpected(
            self.source, token, previous, self.automaton.accepts(before), self.automaton.keywords
        )

    def _lacking(self, text: str, index: int, token: Token) -> Diagnostic:
        before = [r.token for r in self.reads[:index]]
        return complaints.lacking(self.source, text, before, token)

    def _replaced(self, token: Token, kind: str, text: str) -> Token:
        return Token(
            kind, text, token.start_pos, token.line, token.column, token.end_line, token.end_column, token.end_pos
        )


def _start(found: Token | Unreadable) -> int:
    return found.position if isinstance(found, Unreadable) else found.start_pos or 0
