"""The language server: diagnostics while typing, hover, go to definition, formatting. Needs the library pygls."""

from __future__ import annotations

import re

from lsprotocol import types
from pygls.lsp.server import LanguageServer
from pygls.uris import from_fs_path, to_fs_path
from pygls.workspace import TextDocument

from . import __version__
from .compiler.builtins import FUNCTIONS
from .compiler.imports import load_sources, on_disk
from .compiler.library import Library, Named
from .langs import syntax
from .langs.diagnostics import Diagnostic, SourceError
from .langs.source import Source, Span

NAME = re.compile(r"[^\W\d]\w*")

server = LanguageServer("tamplang", __version__)


def serve() -> None:
    """Serve one client over standard input and output until it leaves."""
    server.start_io()


@server.feature(types.TEXT_DOCUMENT_DID_OPEN)
@server.feature(types.TEXT_DOCUMENT_DID_CHANGE)
def publish(parameters: types.DidOpenTextDocumentParams | types.DidChangeTextDocumentParams) -> None:
    """Send the diagnostics of the document; those of an imported file are shown at the import."""
    document = server.workspace.get_text_document(parameters.text_document.uri)
    source = _source(document)
    found = [_shown(d, document, source.path) for d in diagnostics_of(source)]
    server.text_document_publish_diagnostics(
        types.PublishDiagnosticsParams(uri=document.uri, version=document.version, diagnostics=found)
    )


@server.feature(types.TEXT_DOCUMENT_HOVER)
def hover(parameters: types.HoverParams) -> types.Hover | None:
    """The declaration of the name under the cursor, with its `##` text."""
    document = server.workspace.get_text_document(parameters.text_document.uri)
    text = hover_text(_source(document), _offset(document, parameters.position))
    if text is None:
        return None
    return types.Hover(types.MarkupContent(types.MarkupKind.Markdown, text))


@server.feature(types.TEXT_DOCUMENT_DEFINITION)
def definition(parameters: types.DefinitionParams) -> list[types.Location]:
    """Where the name under the cursor is declared, here or in an imported file."""
    document = server.workspace.get_text_document(parameters.text_document.uri)
    source = _source(document)
    library = load_sources([source])[0]
    name = _name_at(source.text, _offset(document, parameters.position))
    found = declarations(library, name)
    return [types.Location(_uri(d.span, document, source.path), _range(d.span)) for d in found]


@server.feature(types.TEXT_DOCUMENT_FORMATTING)
def formatting(parameters: types.DocumentFormattingParams) -> list[types.TextEdit]:
    """The whole document in the one standard form; nothing while it has errors of syntax."""
    from .langs.formatter import format_source

    document = server.workspace.get_text_document(parameters.text_document.uri)
    source = _source(document)
    try:
        text = format_source(source)
    except SourceError:
        return []
    if text == source.text:
        return []
    whole = types.Range(types.Position(0, 0), types.Position(len(document.lines) + 1, 0))
    return [types.TextEdit(whole, text)]


def diagnostics_of(source: Source) -> tuple[Diagnostic, ...]:
    """All errors and warnings of a text that need not be on disk."""
    from .compiler.pipeline import check_sources

    return check_sources([source])


def declarations(library: Library, name: str) -> list[Named]:
    """What `name` may mean: a predicate and a module type, say, may share one."""
    found: list[Named] = [table[name] for table in library.tables if name in table]
    for file in library.files:
        found += [d for d in file.declarations if isinstance(d, syntax.TypeDecl) and d.name == name]
    return found


def hover_text(source: Source, offset: int) -> str | None:
    """Markdown for the name at `offset`: the head of each declaration and its documentation."""
    name = _name_at(source.text, offset)
    if name in FUNCTIONS:
        return f"`{name}`: {FUNCTIONS[name].doc}"
    library = load_sources([source])[0]
    texts = {s.path: s for s in library.sources}
    parts = []
    for declaration in declarations(library, name):
        head = texts[declaration.span.file].line(declaration.span.line).strip().removesuffix("{").strip()
        parts.append(f"```tamplang\n{head}\n```\n{declaration.doc}".strip())
    return "\n\n".join(parts) or None


def _name_at(text: str, offset: int) -> str:
    """The name that holds the character at `offset`, or ends there; empty where there is none."""
    return next((m.group() for m in NAME.finditer(text) if m.start() <= offset <= m.end()), "")


def _source(document: TextDocument) -> Source:
    return Source(to_fs_path(document.uri) or document.uri, document.source)


def _offset(document: TextDocument, position: types.Position) -> int:
    return document.offset_at_position(position)


def _range(span: Span) -> types.Range:
    return types.Range(
        types.Position(span.line - 1, span.column - 1), types.Position(span.end_line - 1, span.end_column - 1)
    )


def _uri(span: Span, document: TextDocument, path: str) -> str:
    if span.file == path:
        return document.uri
    return from_fs_path(str(on_disk(span.file).resolve())) or document.uri


def _shown(diagnostic: Diagnostic, document: TextDocument, path: str) -> types.Diagnostic:
    span = diagnostic.span
    message = diagnostic.message if diagnostic.help is None else f"{diagnostic.message}\n{diagnostic.help}"
    place = types.Range(types.Position(0, 0), types.Position(0, 0))
    if span is not None and span.file == path:
        place = document.position_codec.range_to_client_units(document.lines, _range(span))
    elif span is not None:
        message = f"{span}: {message}"
    return types.Diagnostic(
        range=place,
        message=message,
        severity=types.DiagnosticSeverity.Error if diagnostic.is_error else types.DiagnosticSeverity.Warning,
        code=diagnostic.code,
        source="tamplang",
    )
