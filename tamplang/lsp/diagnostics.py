"""From the compiler's diagnostics to those of the editor, in the text itself and in what it imports."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from lsprotocol import types

from ..compiler.imports import load_sources, resolved
from ..compiler.pipeline import check_sources
from ..langs import syntax
from ..langs.diagnostics import Diagnostic
from ..langs.parser import parse
from ..langs.source import Source, Span
from .codes_page import page_uri
from .documents import Documents

SEVERITIES = {"E": types.DiagnosticSeverity.Error, "W": types.DiagnosticSeverity.Warning}


@dataclass(slots=True)
class Published:
    """What was last sent for a text: `sent` are the addresses that hold diagnostics because of it,
    `texts` the paths of it and all that it imports."""

    found: tuple[Diagnostic, ...] = ()
    sent: set[str] = field(default_factory=set)
    texts: frozenset[str] = frozenset()


def found_in(sources: Sequence[Source]) -> tuple[tuple[Diagnostic, ...], tuple[Source, ...]]:
    """Everything that is wrong with the first source and what it imports, and all these texts."""
    return check_sources(sources), load_sources(sources)[0].sources


def by_address(
    documents: Documents, main: Source, read: Sequence[Source], found: Sequence[Diagnostic]
) -> dict[str, list[types.Diagnostic]]:
    """The diagnostics for every text that has some; of an imported text also one at its import. An open text gets its
    own from its own check."""
    texts = {s.path: s for s in read}
    uri = documents.uri(main.path)
    shown: dict[str, list[types.Diagnostic]] = {uri: []}
    foreign: dict[str, list[Diagnostic]] = {}
    for diagnostic in found:
        span = diagnostic.span
        if span is None or span.file == main.path or span.file not in texts:
            shown[uri].append(_shown(documents, texts, diagnostic, main))
            continue
        foreign.setdefault(span.file, []).append(diagnostic)
        address = documents.uri(span.file)
        if address not in documents.workspace.text_documents:
            shown.setdefault(address, []).append(_shown(documents, texts, diagnostic, texts[span.file]))
    ways = _ways(main, texts)
    for path, several in foreign.items():
        shown[uri].append(_at_import(documents, texts, ways.get(path), path, several, main))
    return shown


def _ways(main: Source, texts: Mapping[str, Source]) -> dict[str, Span]:
    """For every imported text the import of the main one that leads to it."""
    ways: dict[str, Span] = {}
    for declaration in parse(main)[0].declarations:
        if not isinstance(declaration, syntax.Import):
            continue
        waiting = [resolved(main.path, declaration)]
        while waiting:
            path = waiting.pop()
            if path in ways or path not in texts:
                continue
            ways[path] = declaration.span
            inside = parse(texts[path])[0].declarations
            waiting += [resolved(path, d) for d in inside if isinstance(d, syntax.Import)]
    return ways


def _at_import(
    documents: Documents, texts: Mapping[str, Source], way: Span | None, path: str, found: Sequence[Diagnostic],
    main: Source,
) -> types.Diagnostic:  # fmt: skip
    errors = [d for d in found if d.is_error] or list(found)
    first = errors[0]
    many = f"{len(errors)} errors" if len(errors) > 1 else "an error" if first.is_error else "a warning"
    start, end = (0, 0) if way is None else (way.start, way.end)
    related = [
        types.DiagnosticRelatedInformation(_location(documents, texts, d.span), f"{d.code} {d.message}")
        for d in errors[:20]
        if d.span is not None
    ]
    return types.Diagnostic(
        range=documents.places(main).range(start, end),
        message=f"`{path}` has {many}: {first.message}",
        severity=SEVERITIES[first.code[0]],
        code=first.code,
        code_description=types.CodeDescription(page_uri(first.code)),
        source="tamplang",
        related_information=related,
    )


def _shown(
    documents: Documents, texts: Mapping[str, Source], diagnostic: Diagnostic, source: Source
) -> types.Diagnostic:
    span = diagnostic.span
    start, end = (0, 0) if span is None or span.file != source.path else (span.start, span.end)
    lines = [diagnostic.message, *(f"{w}: {t}" for w, t in _remarks(diagnostic) if t is not None)]
    related = [
        types.DiagnosticRelatedInformation(_location(documents, texts, label.span), label.text)
        for label in diagnostic.labels
        if label.span.file in texts
    ]
    unused = diagnostic.code in ("W0002", "W0005")
    return types.Diagnostic(
        range=documents.places(source).range(start, end),
        message="\n".join(lines),
        severity=SEVERITIES.get(diagnostic.code[0], types.DiagnosticSeverity.Information),
        code=diagnostic.code,
        code_description=types.CodeDescription(page_uri(diagnostic.code)),
        source="tamplang",
        tags=[types.DiagnosticTag.Unnecessary] if unused else None,
        related_information=related or None,
    )


def _remarks(diagnostic: Diagnostic) -> list[tuple[str, str | None]]:
    return [("help", diagnostic.help), ("note", diagnostic.note)]


def _location(documents: Documents, texts: Mapping[str, Source], span: Span) -> types.Location:
    return types.Location(documents.uri(span.file), documents.places(texts[span.file]).range(span.start, span.end))
