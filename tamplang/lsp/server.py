"""The server itself: which request is answered by what."""

from __future__ import annotations

import asyncio
import traceback
from collections.abc import Callable
from typing import TypeVar

from lsprotocol import types
from pygls.exceptions import JsonRpcInvalidParams
from pygls.lsp.server import LanguageServer

from .. import __version__
from ..langs.source import Source
from . import completion, hover, inlays, layout, navigation, renaming, signatures, symbols, tokens
from .actions import code_actions
from .diagnostics import Published, by_address, found_in
from .documents import Documents, path_of
from .scheduling import Checks

server = LanguageServer("tamplang", __version__)
_published: dict[str, Published] = {}
_checks: list[Checks] = []
T = TypeVar("T")


HALF_TYPED = "import std.rules\ntype shelf < object\nx\n"


def serve() -> None:
    """Serve one client over standard input and output until it leaves."""
    found_in([Source("first.tamp", HALF_TYPED)])  # else the first mistake in a session waits for what reads mistakes
    server.start_io()


def documents() -> Documents:
    return Documents(server.workspace)


def checks() -> Checks:
    """The one queue of checks, made when the loop runs."""
    if not _checks:
        _checks.append(Checks(_check, asyncio.get_running_loop(), _failed))
    return _checks[0]


def _failed(error: Exception) -> None:
    """A fault of ours: told in the client's log, with its place."""
    text = "".join(traceback.format_exception(error))
    server.window_log_message(types.LogMessageParams(types.MessageType.Error, text))


async def _check(uri: str) -> None:
    """Check one text beside the loop, so that requests are answered meanwhile, and tell what was found unless the text
    changed or was closed."""
    here = documents()
    if uri not in server.workspace.text_documents:
        return
    version = here.document(uri).version
    sources = here.buffers(uri)
    found, read = await asyncio.get_running_loop().run_in_executor(None, found_in, sources)
    if uri not in server.workspace.text_documents or here.document(uri).source != sources[0].text:
        return
    before = _published.setdefault(uri, Published())
    shown = by_address(here, sources[0], read, found)
    for address in before.sent - set(shown):
        _send(address, [])
    for address, diagnostics in shown.items():
        _send(address, diagnostics, version if address == uri else None)
    _published[uri] = Published(found, set(shown), frozenset(s.path for s in read))


def _send(uri: str, found: list[types.Diagnostic], version: int | None = None) -> None:
    server.text_document_publish_diagnostics(types.PublishDiagnosticsParams(uri, found, version))


@server.feature(types.TEXT_DOCUMENT_DID_OPEN)
async def _opened(parameters: types.DidOpenTextDocumentParams) -> None:
    checks().touch(parameters.text_document.uri, 0)


@server.feature(types.TEXT_DOCUMENT_DID_CHANGE)
async def _changed(parameters: types.DidChangeTextDocumentParams) -> None:
    touched = parameters.text_document.uri
    checks().touch(touched)
    for uri, known in _published.items():
        if uri != touched and path_of(touched) in known.texts:
            checks().touch(uri)


@server.feature(types.TEXT_DOCUMENT_DID_CLOSE)
async def _closed(parameters: types.DidCloseTextDocumentParams) -> None:
    uri = parameters.text_document.uri
    checks().forget(uri)
    for address in _published.pop(uri, Published()).sent:
        _send(address, [])


@server.feature(types.WORKSPACE_DID_CHANGE_WATCHED_FILES)
async def _watched(_: types.DidChangeWatchedFilesParams) -> None:
    for uri in server.workspace.text_documents:
        checks().touch(uri)


@server.feature(types.TEXT_DOCUMENT_HOVER)
def _hover(p: types.HoverParams) -> types.Hover | None:
    return hover.hover(documents(), p.text_document.uri, p.position)


@server.feature(types.TEXT_DOCUMENT_DEFINITION)
def _definition(p: types.DefinitionParams) -> list[types.Location]:
    return navigation.definition(documents(), p.text_document.uri, p.position)


@server.feature(types.TEXT_DOCUMENT_REFERENCES)
def _references(p: types.ReferenceParams) -> list[types.Location]:
    with_declaration = p.context.include_declaration
    return navigation.references(documents(), p.text_document.uri, p.position, with_declaration)


@server.feature(types.TEXT_DOCUMENT_DOCUMENT_HIGHLIGHT)
def _highlights(p: types.DocumentHighlightParams) -> list[types.DocumentHighlight]:
    return navigation.highlights(documents(), p.text_document.uri, p.position)


@server.feature(types.TEXT_DOCUMENT_RENAME)
def _rename(p: types.RenameParams) -> types.WorkspaceEdit:
    return _told(lambda: renaming.renaming(documents(), p.text_document.uri, p.position, p.new_name))


@server.feature(types.TEXT_DOCUMENT_PREPARE_RENAME)
def _prepare_rename(p: types.PrepareRenameParams) -> types.Range:
    return _told(lambda: renaming.renamable(documents(), p.text_document.uri, p.position))


_STARTS = [".", "(", "[", ":", " ", '"', "/"]


@server.feature(types.TEXT_DOCUMENT_COMPLETION, types.CompletionOptions(trigger_characters=_STARTS))
def _completion(p: types.CompletionParams) -> types.CompletionList:
    return completion.completion(documents(), p.text_document.uri, p.position)


@server.feature(types.TEXT_DOCUMENT_SIGNATURE_HELP, types.SignatureHelpOptions(trigger_characters=["(", "[", ",", " "]))
def _signature(p: types.SignatureHelpParams) -> types.SignatureHelp | None:
    return signatures.signature_help(documents(), p.text_document.uri, p.position)


@server.feature(types.TEXT_DOCUMENT_CODE_ACTION, types.CodeActionOptions([types.CodeActionKind.QuickFix]))
def _actions(p: types.CodeActionParams) -> list[types.CodeAction]:
    here, uri = documents(), p.text_document.uri
    known = _published.get(uri)
    found = found_in(here.buffers(uri))[0] if known is None else known.found
    return code_actions(here, uri, p.range, found)


@server.feature(types.TEXT_DOCUMENT_DOCUMENT_SYMBOL)
def _symbols(p: types.DocumentSymbolParams) -> list[types.DocumentSymbol]:
    return symbols.document_symbols(documents(), p.text_document.uri)


@server.feature(types.WORKSPACE_SYMBOL)
def _workspace_symbols(p: types.WorkspaceSymbolParams) -> list[types.WorkspaceSymbol]:
    return symbols.workspace_symbols(documents(), p.query)


@server.feature(types.TEXT_DOCUMENT_FOLDING_RANGE)
def _folding(p: types.FoldingRangeParams) -> list[types.FoldingRange]:
    return symbols.folding(documents(), p.text_document.uri)


@server.feature(types.TEXT_DOCUMENT_CODE_LENS)
def _lenses(p: types.CodeLensParams) -> list[types.CodeLens]:
    return symbols.code_lenses(documents(), p.text_document.uri)


_LEGEND = types.SemanticTokensLegend(list(tokens.LEGEND), list(tokens.MODIFIERS))


@server.feature(types.TEXT_DOCUMENT_SEMANTIC_TOKENS_FULL, _LEGEND)
def _tokens(p: types.SemanticTokensParams) -> types.SemanticTokens:
    return tokens.semantic_tokens(documents(), p.text_document.uri)


@server.feature(types.TEXT_DOCUMENT_SEMANTIC_TOKENS_RANGE, _LEGEND)
def _tokens_within(p: types.SemanticTokensRangeParams) -> types.SemanticTokens:
    return tokens.semantic_tokens(documents(), p.text_document.uri, p.range)


@server.feature(types.TEXT_DOCUMENT_INLAY_HINT)
def _inlays(p: types.InlayHintParams) -> list[types.InlayHint]:
    return inlays.inlay_hints(documents(), p.text_document.uri, p.range)


@server.feature(types.TEXT_DOCUMENT_FORMATTING)
def _formatting(p: types.DocumentFormattingParams) -> list[types.TextEdit]:
    return layout.formatting(documents(), p.text_document.uri)


@server.feature(types.TEXT_DOCUMENT_RANGE_FORMATTING)
def _range_formatting(p: types.DocumentRangeFormattingParams) -> list[types.TextEdit]:
    return layout.formatting(documents(), p.text_document.uri, p.range)


def _told(asked: Callable[[], T]) -> T:
    """The answer, or an error of the protocol that tells why there is none."""
    try:
        return asked()
    except renaming.CannotRename as error:
        raise JsonRpcInvalidParams(str(error)) from error
