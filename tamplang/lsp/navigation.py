"""From a name to its definition and to all its mentions, in all files; renaming."""

from __future__ import annotations

import re
from collections.abc import Iterator

from lsprotocol import types

from ..compiler.imports import load_sources, on_disk, resolved
from ..compiler.mentions import Mention, mentions_of
from ..compiler.naming import Naming, Place
from ..compiler.standard import STANDARD
from ..langs import syntax
from ..langs.parser import parse
from ..langs.source import Source
from ..langs.words import RESERVED, TYPES
from .documents import Documents

NAME = re.compile(r"[A-Za-z_]\w*")


class CannotRename(Exception):
    """The name belongs to the language or the standard library, or the new one is none."""


def definition(documents: Documents, uri: str, position: types.Position) -> list[types.Location]:
    """Where the name at a place is declared; of an import, the file."""
    source = documents.source(uri)
    mention = documents.mention(uri, position)
    if mention is None:
        return []
    if mention.kind == "import":
        return _imported(documents, source, mention)
    place = documents.naming(uri).meant(source.path, mention)
    return [] if place is None else [documents.location(place)]


def references(
    documents: Documents, uri: str, position: types.Position, with_declaration: bool
) -> list[types.Location]:
    """Every mention of the thing at a place, in every program of the open folders."""
    return [
        types.Location(documents.uri(source.path), documents.places(source).range(m.start, m.end))
        for source, m in mentions(documents, uri, position)
        if with_declaration or not m.defines
    ]


def highlights(documents: Documents, uri: str, position: types.Position) -> list[types.DocumentHighlight]:
    """Every mention of the thing at a place, in the same text."""
    source = documents.source(uri)
    places = documents.places(source)
    naming = documents.naming(uri)
    place = _place(documents, naming, uri, position)
    if place is None:
        return []
    kinds = {True: types.DocumentHighlightKind.Write, False: types.DocumentHighlightKind.Read}
    return [
        types.DocumentHighlight(places.range(m.start, m.end), kinds[m.defines])
        for m in mentions_of(source).all
        if _same(naming, source, m, place)
    ]


def renaming(documents: Documents, uri: str, position: types.Position, name: str) -> types.WorkspaceEdit:
    """The edits that give the thing at a place another name, in all files. Raises CannotRename."""
    if NAME.fullmatch(name) is None or name in RESERVED or name in TYPES:
        raise CannotRename(f"`{name}` is no name of the language's own")
    renamable(documents, uri, position)
    changes: dict[str, list[types.TextEdit]] = {}
    for source, m in mentions(documents, uri, position):
        edit = types.TextEdit(documents.places(source).range(m.start, m.end), name)
        changes.setdefault(documents.uri(source.path), []).append(edit)
    return types.WorkspaceEdit(changes=changes)


def renamable(documents: Documents, uri: str, position: types.Position) -> types.Range:
    """The place of the name, if it can be another. Raises CannotRename."""
    mention = documents.mention(uri, position)
    place = _place(documents, documents.naming(uri), uri, position)
    if mention is None or place is None:
        raise CannotRename("only what a program declares can get another name")
    if place.source.path.startswith(f"{STANDARD}/"):
        raise CannotRename("this name is declared by the standard library")
    return documents.places(documents.source(uri)).range(mention.start, mention.end)


def mentions(documents: Documents, uri: str, position: types.Position) -> Iterator[tuple[Source, Mention]]:
    """The texts and places that speak of the thing at a place."""
    place = _place(documents, documents.naming(uri), uri, position)
    if place is None:
        return
    local = place.definition.mention.home.startswith("@")
    buffers = [documents.source(other) for other in documents.workspace.text_documents]
    for source in [documents.source(uri)] if local else _with_home(documents, place):
        if not local and not _speaks_of(source, place):
            continue
        library = load_sources([source, *(b for b in buffers if b.path != source.path)])[0]
        naming = Naming(library.sources)
        for mention in mentions_of(source).all:
            if _same(naming, source, mention, place):
                yield source, mention


def _with_home(documents: Documents, place: Place) -> Iterator[Source]:
    seen: set[str] = set()
    for source in documents.programs():
        seen.add(source.path)
        yield source
    if place.source.path not in seen:
        yield place.source


def _speaks_of(source: Source, place: Place) -> bool:
    return place.definition.mention.name in source.text


def _place(documents: Documents, naming: Naming, uri: str, position: types.Position) -> Place | None:
    mention = documents.mention(uri, position)
    return None if mention is None else naming.meant(documents.source(uri).path, mention)


def _same(naming: Naming, source: Source, mention: Mention, place: Place) -> bool:
    if mention.name != place.definition.mention.name:
        return False
    found = naming.meant(source.path, mention)
    return found is not None and found.key == place.key


def _imported(documents: Documents, source: Source, mention: Mention) -> list[types.Location]:
    start = types.Range(types.Position(0, 0), types.Position(0, 0))
    for declaration in parse(source)[0].declarations:
        if isinstance(declaration, syntax.Import) and declaration.span.start <= mention.start < declaration.span.end:
            path = resolved(source.path, declaration)
            if on_disk(path).is_file():
                return [types.Location(documents.uri(path), start)]
    return []
