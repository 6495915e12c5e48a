"""How programs are coloured without a server: one list of patterns, of which the grammars of editors are made.

What a word is depends on where it stands (`on` is a keyword, and the predicate of `(on X A)`), so the patterns look at
the signs around it. `editors/generate.py` writes them out; a test holds them to the server's semantic tokens.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

from .compiler.builtins import FUNCTIONS
from .langs.grammar_loader import grammar_text
from .langs.words import JOINTS, RESERVED, SHAPES, TYPES, WORDS

NAME = r"[A-Za-z_]\w*"


def alternatives(words: Iterable[str]) -> str:
    return "|".join(sorted(words, key=lambda w: (-len(w), w)))


def _number() -> str:
    """The grammar's own pattern of a number with its unit, its groups without marks."""
    line = re.search(r"^NUMBER: /(.*)/$", grammar_text(), re.MULTILINE)
    assert line is not None
    return re.sub(r"(?<!\\)\((?!\?)", "(?:", line[1])


def rules() -> list[tuple[str, tuple[str, ...]]]:
    """Patterns in order of precedence, with the class of each of their groups. None goes beyond a line."""
    groups: dict[str, list[str]] = {}
    for word, told in WORDS.items():
        groups.setdefault(told.group, []).append(word)
    number = _number()
    free = rf"(?!(?:{alternatives(RESERVED)})(?!\w)){NAME}"
    argument = r"(?:[\w.]|\[[^\[\]]*\])+"
    built_in = alternatives({*FUNCTIONS, *SHAPES, *JOINTS})
    types = alternatives(TYPES)
    return [
        (r"(##.*$)", ("doc",)),
        (r"(#.*$)", ("comment",)),
        (r'("[^"\n]*")', ("string",)),
        (rf"(?<!\w)({number})", ("number",)),
        (r"(\.\.)", ("operator",)),
        (rf"(?<=\.)({NAME})", ("property",)),
        (rf"(?<!\w)(import)\s+({NAME}(?:\.{NAME})*)", ("declaration", "namespace")),
        (rf"(?<!\w)(predicate|derived)\s*\(\s*({NAME})", ("declaration", "predicate")),
        (rf"(?<!\w)(motion)\s*\[\s*({NAME})", ("declaration", "motion")),
        (rf"\(\s*({free})(?=(?:\s+{argument})*\s*\))", ("predicate",)),
        (rf"\[\s*({free})(?=(?:\s+{argument})+\s*\])", ("motion",)),
        (rf"(?<!\w)({built_in})(?=\()", ("function",)),
        (rf"(?:(?<=[:<] )|(?<=of )|(?<=in ))({types})(?!\w)(?!\s*\()", ("type",)),
        (rf"(?<!\w)({alternatives(groups['declaration'])})(?![\w(])", ("declaration",)),
        (rf"(?<!\w)({alternatives(groups['modifier'])})(?![\w(])", ("modifier",)),
        (rf"(?<!\w)({alternatives(groups['control'])})(?!\w)", ("control",)),
        (rf"(?<!\w)({alternatives(groups['part'])})(?=\s+[\w(\[\-¬\"]|\s*\{{|\s*$)", ("keyword",)),
        (rf"(?<!\w)({alternatives(groups['clause'])})(?![\w(])", ("keyword",)),
        (rf"({NAME})", ("name",)),
        (r"(<=|>=|!=|[=<>+\-*/¬])", ("operator",)),
    ]


def coloured(text: str) -> Iterator[tuple[int, int, str]]:
    """Start, end and class of what the patterns colour, as an editor finds it: at every place the first that fits."""
    patterns = [(re.compile(pattern, re.MULTILINE), classes) for pattern, classes in rules()]
    position = 0
    while position < len(text):
        for pattern, classes in patterns:
            match = pattern.match(text, position)
            if match is not None:
                for group, kind in enumerate(classes, 1):
                    yield match.start(group), match.end(group), kind
                position = match.end()
                break
        else:
            position += 1
