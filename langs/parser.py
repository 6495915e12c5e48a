"""Text to syntax tree."""

from __future__ import annotations

from lark import Tree, UnexpectedInput

from . import syntax
from .build import TreeBuilder
from .build_terms import Branch, NestingError
from .diagnostics import Diagnostic
from .grammar_loader import parser
from .source import Source, Span


def parse(source: Source) -> tuple[syntax.File, tuple[Diagnostic, ...]]:
    """The tree of `source`, and what is wrong with its syntax. Declarations with mistakes are left out."""
    whole = whole_span(source)
    try:
        tree = parser().parse(source.text)
    except UnexpectedInput as e:
        at = Span(source.path, e.pos_in_stream or 0, (e.pos_in_stream or 0) + 1, e.line, e.column, e.line, e.column + 1)
        return syntax.File(source.path, (), span=whole), (Diagnostic("E0001", "unexpected text", at),)
    builder = TreeBuilder(source.path, source.text.split("\n"))
    made: list[syntax.Declaration] = []
    for branch in tree.children:
        if isinstance(branch, Tree):
            made.extend(_declaration(builder, branch))
    return syntax.File(source.path, tuple(made), span=whole), tuple(builder.problems)


def _declaration(builder: TreeBuilder, branch: Branch) -> list[syntax.Declaration]:
    try:
        return [builder.declaration(branch)]
    except NestingError as e:
        builder.problem("E0008", "this is nested too deeply", e.span)
        return []


def whole_span(source: Source) -> Span:
    lines = source.text.split("\n")
    return Span(source.path, 0, len(source.text), 1, 1, len(lines), len(lines[-1]) + 1)
