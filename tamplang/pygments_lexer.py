"""The Pygments lexer of the language, which the installed package makes known: `pygmentize -l tamplang climb.tamp`."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

from pygments.lexer import Lexer
from pygments.token import Comment, Keyword, Name, Number, Operator, String, Text, _TokenType

from .highlight import coloured

TOKENS: dict[str, _TokenType] = {
    "doc": Comment.Special, "comment": Comment.Single, "string": String, "number": Number,
    "declaration": Keyword.Declaration, "keyword": Keyword, "modifier": Keyword.Pseudo, "control": Keyword.Reserved,
    "type": Keyword.Type, "function": Name.Builtin, "predicate": Name.Function, "motion": Name.Function.Magic,
    "property": Name.Attribute, "namespace": Name.Namespace, "operator": Operator, "name": Name,
}  # fmt: skip


class TamplangLexer(Lexer):
    """Colours `.tamp` programs."""

    name = "tamplang"
    aliases: ClassVar[list[str]] = ["tamplang", "tamp"]
    filenames: ClassVar[list[str]] = ["*.tamp"]

    def get_tokens_unprocessed(self, text: str) -> Iterator[tuple[int, _TokenType, str]]:
        position = 0
        for start, end, kind in coloured(text):
            if start > position:
                yield position, Text, text[position:start]
            yield start, TOKENS[kind], text[start:end]
            position = end
        if position < len(text):
            yield position, Text, text[position:]
