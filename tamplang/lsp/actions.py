"""Quick fixes: the repairs that the hints of diagnostics tell."""

from __future__ import annotations

from collections.abc import Sequence

from lsprotocol import types

from ..langs.diagnostics import Diagnostic
from ..langs.fixes import fixes
from .documents import Documents


def code_actions(
    documents: Documents, uri: str, where: types.Range, found: Sequence[Diagnostic]
) -> list[types.CodeAction]:
    """The repairs of the diagnostics that touch a stretch of the text."""
    source = documents.source(uri)
    places = documents.places(source)
    first, last = places.offset(where.start), places.offset(where.end)
    actions = []
    for diagnostic in found:
        span = diagnostic.span
        if span is None or span.file != source.path or span.start > last or span.end < first:
            continue
        for index, fix in enumerate(fixes(diagnostic, source.text)):
            edits = [types.TextEdit(places.range(start, end), new) for start, end, new in fix.edits]
            actions.append(
                types.CodeAction(
                    title=fix.title,
                    kind=types.CodeActionKind.QuickFix,
                    is_preferred=index == 0,
                    edit=types.WorkspaceEdit(changes={uri: edits}),
                )
            )
    return actions
