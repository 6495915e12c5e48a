"""Formatting of a text, or of those of its declarations that a stretch touches."""

from __future__ import annotations

from difflib import SequenceMatcher

from lsprotocol import types

from ..langs.diagnostics import SourceError
from ..langs.formatter import format_source
from .documents import Documents


def formatting(documents: Documents, uri: str, within: types.Range | None = None) -> list[types.TextEdit]:
    """The edits to the standard layout, line by line; nothing while the text has errors of syntax."""
    source = documents.source(uri)
    try:
        wanted = format_source(source)
    except SourceError:
        return []
    old, new = source.text.splitlines(keepends=True), wanted.splitlines(keepends=True)
    edits = []
    for tag, i1, i2, j1, j2 in SequenceMatcher(None, old, new, autojunk=False).get_opcodes():
        if tag == "equal" or (within is not None and (i2 <= within.start.line or i1 > within.end.line)):
            continue
        where = types.Range(types.Position(i1, 0), types.Position(i2, 0))
        if i2 == len(old) and old and not old[-1].endswith("\n"):
            where = types.Range(where.start, documents.places(source).position(len(source.text)))
        edits.append(types.TextEdit(where, "".join(new[j1:j2])))
    return edits
