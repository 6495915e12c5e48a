"""Text to syntax tree: the whole text at once when it is sound, else repaired mistake by mistake."""

from __future__ import annotations

import gc
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import lru_cache
from typing import TYPE_CHECKING

from . import syntax
from .diagnostics import Diagnostic
from .source import Source, Span
from .tree_cache import keep_tree, recalled_tree

if TYPE_CHECKING:
    from lark import Lark, Token
    from lark.parsers.lalr_interactive_parser import InteractiveParser

    from .build import TreeBuilder
    from .build_terms import Branch
    from .recovery import Recovery

LONG = 100_000
"""Characters of a text whose grammar's tree is not kept: it takes a hundred times as much memory."""


@lru_cache(maxsize=32)
def parse(source: Source) -> tuple[syntax.File, tuple[Diagnostic, ...]]:
    """The tree of `source`, and all that is wrong with its syntax, in source order.

    A file with mistakes gives the tree of its repaired text: what could not be repaired is left out, and a lacking name
    is `?`. Lark is loaded only where no tree of the same text was kept.
    """
    kept = recalled_tree(source)
    if kept is not None:
        return kept, ()
    file, found = _parsed(source)
    if not found:
        keep_tree(source, file)
    return file, found


def _parsed(source: Source) -> tuple[syntax.File, tuple[Diagnostic, ...]]:
    from lark import Tree

    from .build import TreeBuilder

    with no_garbage():
        tree, mistakes = _parse_tree(source)
        builder = TreeBuilder(source.path, source.text.split("\n"))
        declarations: list[syntax.Declaration] = []
        for branch in tree.children:
            if isinstance(branch, Tree):
                declarations.extend(_declaration(builder, branch))
    lines = {d.span.line for d in mistakes if d.span is not None}
    further = [d for d in builder.problems if d.span is not None and d.span.line not in lines]
    found = sorted((*mistakes, *further), key=_position)
    return syntax.File(source.path, tuple(declarations), span=_whole(source)), tuple(found)


@contextmanager
def no_garbage() -> Iterator[None]:
    """A parser makes many things and no garbage: looking for some takes two thirds of the time of a large text."""
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()


def _parse_tree(source: Source) -> tuple[Branch, list[Diagnostic]]:
    tree, _, recovery = _read(source) if len(source.text) > LONG else _read_lately(source)
    return tree, [] if recovery is None else recovery.diagnostics


@lru_cache(maxsize=2)
def _read_lately(source: Source) -> tuple[Branch, list[Token], Recovery | None]:
    """The same, kept for who asks next: an editor asks for mistakes, and then for colours."""
    return _read(source)


def _read(source: Source) -> tuple[Branch, list[Token], Recovery | None]:
    """The tree and the tokens of `source`, or of what it is repaired to."""
    from lark import UnexpectedInput

    from .grammar_loader import parser

    interactive = parser().parse_interactive(source.text)
    tokens: list[Token] = []
    try:
        tokens.extend(interactive.iter_parse())
        return interactive.feed_token(_end(tokens)), tokens, None
    except UnexpectedInput:
        values = interactive.parser_state.value_stack
        done = values[0].children if values and not hasattr(values[0], "type") else []
        return _recovered(source, tokens, done)


def _end(tokens: Sequence[Token]) -> Token:
    from lark import Token

    return Token.new_borrow_pos("$END", "", tokens[-1]) if tokens else Token("$END", "")


@lru_cache(maxsize=64)
def parse_tokens(source: Source) -> tuple[Branch, tuple[Token, ...]]:
    """The grammar's own tree of `source` with the place of every word, and all its tokens; of a faulty text, those of
    the repaired one."""
    tree, tokens, _ = _read(source) if len(source.text) > LONG else _read_lately(source)
    return tree, tuple(tokens)


def _recovered(
    source: Source, sound: Sequence[Token], done: Sequence[Branch]
) -> tuple[Branch, list[Token], Recovery]:
    """The tree of the repaired text, of which `sound` was read before its first mistake, `done` its declarations. What
    follows the last repair is read like a sound text, in a third of the time."""
    from lark import Tree

    from .grammar_loader import parser
    from .recovery import LOOKAHEAD, Recovery

    lark = parser()
    recovery = Recovery(lark, source, sound)
    tokens = recovery.tokens(LOOKAHEAD)
    known, feeder = _fed(lark, done, sound, tokens)
    tree: Branch | None = None
    if not recovery.finished:
        rest, tree = _read_on(source, feeder, recovery)
        if tree is not None:
            tokens += rest
        else:
            recovery.take(rest)
            tokens = recovery.tokens()
            known, feeder = _fed(lark, done, sound, tokens)
    if tree is None:
        tree = feeder.feed_token(recovery.automaton.token("$END", "", len(source.text)))
    return Tree(tree.data, [*done[:known], *tree.children], tree.meta), tokens, recovery


def _fed(
    lark: Lark, done: Sequence[Branch], sound: Sequence[Token], tokens: Sequence[Token]
) -> tuple[int, InteractiveParser]:
    """How many declarations no repair has reached, and a parser that has read what follows them."""
    known, first = _untouched(done, sound, tokens)
    feeder = lark.parse_interactive("")
    for token in tokens[first:]:
        feeder.feed_token(token)
    return known, feeder


def _read_on(
    source: Source, feeder: InteractiveParser, recovery: Recovery
) -> tuple[list[Token], Branch | None]:
    """What can be read behind the last repair, and the tree where that is all."""
    from lark import UnexpectedInput

    from .automaton import ends_before

    rest: list[Token] = []
    feeder.lexer_thread = recovery.automaton.lexer_at(recovery.position)
    try:
        for token in feeder.iter_parse():
            if ends_before(token) or recovery.automaton.may_be_left_over(token, feeder.parser_state.state_stack):
                return rest, None
            rest.append(token)
        return rest, feeder.feed_token(recovery.automaton.token("$END", "", len(source.text)))
    except UnexpectedInput:
        return rest, None


def _untouched(done: Sequence[Branch], sound: Sequence[Token], repaired: Sequence[Token]) -> tuple[int, int]:
    """How many declarations no repair has reached, and which token follows them: each ends where the next token says
    so, which must be the same."""
    same = 0
    while same < min(len(sound), len(repaired)) and sound[same] is repaired[same]:
        same += 1
    known, first = len(done), same
    while known:
        end = done[known - 1].meta.end_pos
        while first > 0 and (repaired[first - 1].start_pos or 0) >= end:
            first -= 1
        if first < same:
            return known, first
        known -= 1
    return 0, 0


def _declaration(builder: TreeBuilder, branch: Branch) -> list[syntax.Declaration]:
    from .build_terms import NestingError

    try:
        made = builder.declaration(branch)
        unnamed = isinstance(made, syntax.Import) and not made.is_path and made.target.endswith("?")
        return [] if unnamed else [made]
    except NestingError as e:
        builder.problem("E0008", "this is nested too deeply", e.span)
        return []


def _position(diagnostic: Diagnostic) -> tuple[int, str]:
    return (diagnostic.span.start if diagnostic.span is not None else 0, diagnostic.code)


def _whole(source: Source) -> Span:
    lines = source.text.split("\n")
    return Span(source.path, 0, len(source.text), 1, 1, len(lines), len(lines[-1]) + 1)
