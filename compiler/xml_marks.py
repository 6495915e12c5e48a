"""What in an XML text is no element: comments, data, instructions. To be found without reading the text."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence

COMMENT, DATA, INSTRUCTION = ("<!--", "-->"), ("<![CDATA[", "]]>"), ("<?", "?>")
"""How what is no element begins and ends."""


def replaced(text: str, kinds: Sequence[tuple[str, str]], by: Callable[[str], str]) -> str:
    """The text with something else for what lies between the marks of these kinds, in one pass; what is not closed, and
    all behind it, stays."""
    opens = re.compile("|".join(re.escape(mark) for mark, _ in kinds))
    found, at = [], 0
    while match := opens.search(text, at):
        close = dict(kinds)[match[0]]
        end = text.find(close, match.end())
        if end < 0:
            break
        found += [text[at : match.start()], by(text[match.start() : end + len(close)])]
        at = end + len(close)
    return "".join([*found, text[at:]])
