"""The outline of a text, symbols of all programs, folding, and what can be solved."""

from __future__ import annotations

from lsprotocol import types

from ..compiler.mentions import GLOBAL, Definition, Mentions, mentions_of
from ..langs.parser import parse_tokens
from ..langs.source import Source
from .documents import Documents

SYMBOLS = {
    "type": types.SymbolKind.Interface,
    "predicate": types.SymbolKind.Boolean,
    "derived predicate": types.SymbolKind.Boolean,
    "function": types.SymbolKind.Function,
    "motion predicate": types.SymbolKind.Operator,
    "rule": types.SymbolKind.Method,
    "heuristic": types.SymbolKind.Constant,
    "module": types.SymbolKind.Class,
    "scene": types.SymbolKind.Namespace,
    "task": types.SymbolKind.Event,
    "body": types.SymbolKind.Object,
    "robot": types.SymbolKind.Object,
    "effector": types.SymbolKind.Field,
    "joint": types.SymbolKind.Property,
}
MOST_SYMBOLS = 1000


def document_symbols(documents: Documents, uri: str) -> list[types.DocumentSymbol]:
    """The declarations of a text, each with its parts: effectors and joints, bodies and robots."""
    source = documents.source(uri)
    found = mentions_of(source)
    tops = [d for d in found.definitions if d.mention.home == ""]
    return [_symbol(documents, source, top, _inner(found, top)) for top in tops]


def _inner(found: Mentions, top: Definition) -> list[Definition]:
    parts = [d for d in found.definitions if d.what in SYMBOLS and d.mention.home == top.mention.name]
    return [d for d in parts if top.start <= d.start and d.end <= top.end]


def _symbol(documents: Documents, source: Source, made: Definition, inner: list[Definition]) -> types.DocumentSymbol:
    places = documents.places(source)
    return types.DocumentSymbol(
        name=made.mention.name,
        kind=SYMBOLS[made.what],
        range=places.range(made.start, made.end),
        selection_range=places.range(made.mention.start, made.mention.end),
        detail=made.what + (f": {made.type}" if made.type else ""),
        children=[_symbol(documents, source, d, []) for d in inner],
    )


def workspace_symbols(documents: Documents, query: str) -> list[types.WorkspaceSymbol]:
    """The declarations of all programs whose names hold the letters of `query` in this order."""
    found: list[types.WorkspaceSymbol] = []
    for source in documents.programs():
        places = documents.places(source)
        for d in mentions_of(source).definitions:
            if d.mention.home == "" and _fits(query.lower(), d.mention.name.lower()):
                where = types.Location(documents.uri(source.path), places.range(d.mention.start, d.mention.end))
                found.append(types.WorkspaceSymbol(where, d.mention.name, SYMBOLS[d.what], container_name=source.path))
                if len(found) == MOST_SYMBOLS:
                    return found
    return found


def _fits(query: str, name: str) -> bool:
    letters = iter(name)
    return all(letter in letters for letter in query)


def folding(documents: Documents, uri: str) -> list[types.FoldingRange]:
    """Braces over several lines, comments of several lines, and the imports."""
    source = documents.source(uri)
    found: list[types.FoldingRange] = []
    opened: list[int] = []
    imports: list[int] = []
    for token in parse_tokens(source)[1]:
        line = (token.line or 1) - 1
        if token == "{":
            opened.append(line)
        elif token == "}" and opened:
            start = opened.pop()
            if line > start + 1:
                found.append(types.FoldingRange(start, line - 1))
        elif token.type == "_IMPORT":
            imports.append(line)
    if len(imports) > 1:
        found.append(types.FoldingRange(imports[0], imports[-1], kind=types.FoldingRangeKind.Imports))
    return [*found, *_comments(source)]


def _comments(source: Source) -> list[types.FoldingRange]:
    found: list[types.FoldingRange] = []
    start: int | None = None
    for number, line in enumerate([*source.text.split("\n"), ""]):
        if line.lstrip().startswith("#"):
            start = number if start is None else start
        elif start is not None:
            if number - start > 1:
                found.append(types.FoldingRange(start, number - 1, kind=types.FoldingRangeKind.Comment))
            start = None
    return found


def code_lenses(documents: Documents, uri: str) -> list[types.CodeLens]:
    """`solve` and `run` above every task. The client runs the commands in a terminal."""
    source = documents.source(uri)
    places = documents.places(source)
    lenses = []
    for made in mentions_of(source).definitions:
        if (made.mention.kind, made.what) == GLOBAL["task_decl"]:
            where = places.range(made.start, made.start)
            for title in ("solve", "run"):
                command = types.Command(title, f"tamplang.{title}", arguments=[uri, made.mention.name])
                lenses.append(types.CodeLens(where, command))
    return lenses
