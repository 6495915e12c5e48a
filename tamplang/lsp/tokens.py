"""Semantic tokens: what every word of a text is, as the server knows it."""

from __future__ import annotations

import re

from lsprotocol import types

from ..compiler.builtins import FUNCTIONS
from ..compiler.mentions import mentions_of
from ..langs.parser import parse_tokens
from ..langs.source import Source
from ..langs.words import TYPES
from .documents import Documents

LEGEND = (
    "keyword", "number", "string", "comment", "type", "class", "function", "macro", "method", "namespace", "event",
    "variable", "parameter", "property", "enumMember", "decorator",
)  # fmt: skip
MODIFIERS = ("declaration", "defaultLibrary")
KINDS = {
    "type": "type", "predicate": "function", "motion": "macro", "function": "function", "rule": "method",
    "heuristic": "decorator", "scene": "namespace", "task": "event", "variable": "parameter", "object": "variable",
    "effector": "property", "joint": "property", "attribute": "property", "option": "property", "word": "enumMember",
    "import": "namespace",
}  # fmt: skip
_COMMENT = re.compile(r"#[^\n]*")


def classified(source: Source) -> list[tuple[int, int, str, int]]:
    """Start, end, kind and modifiers (bits) of every word, number, text and comment, in order. What could not be read
    is left out."""
    found: dict[int, tuple[int, str, int]] = {}
    position = 0
    for token in [*parse_tokens(source)[1], None]:
        start = len(source.text) if token is None else token.start_pos or 0
        for comment in _COMMENT.finditer(source.text, position, start):
            found[comment.start()] = (comment.end(), "comment", 0)
        if token is None:
            break
        position = token.end_pos or start
        kind = {"NUMBER": "number", "STRING": "string"}.get(token.type)
        if kind is None and token.type != "NAME" and str(token)[:1].isalpha():
            kind = "keyword"
        if kind is not None and position > start:
            found[start] = (position, kind, 0)
    for mention in mentions_of(source).all:
        if mention.kind == "import" and source.text[mention.start] == '"':
            continue
        built_in = mention.name in TYPES if mention.kind == "type" else mention.name in FUNCTIONS
        bits = mention.defines + 2 * (built_in and mention.kind in ("type", "function"))
        found[mention.start] = (mention.end, KINDS[mention.kind], bits)
    return [(start, *rest) for start, rest in sorted(found.items())]


def semantic_tokens(documents: Documents, uri: str, within: types.Range | None = None) -> types.SemanticTokens:
    """The words of a text, or of a stretch of it, in the protocol's relative numbers."""
    source = documents.source(uri)
    places = documents.places(source)
    first, last = 0, len(source.text)
    if within is not None:
        first, last = places.offset(within.start), places.offset(within.end)
    data: list[int] = []
    line = column = 0
    for start, end, kind, bits in classified(source):
        if end <= first or start >= last:
            continue
        begin, stop = places.position(start), places.position(end)
        if begin.line != stop.line:
            continue
        behind = begin.character - (column if begin.line == line else 0)
        data += [begin.line - line, behind, stop.character - begin.character, LEGEND.index(kind), bits]
        line, column = begin.line, begin.character
    return types.SemanticTokens(data)
