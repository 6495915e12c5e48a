"""From a name to its definition and to all its mentions, in all files."""

from __future__ import annotations

from collections.abc import Iterator

from lsprotocol import types

from ..compiler.imports import load_sources, on_disk, resolved
from ..compiler.mentions import Mention, mentions_of
from ..compiler.naming import Naming, Place
from ..langs import syntax
from ..langs.parser import parse
from ..langs.source import Source
from .documents import Documents


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
    place = place_at(documents, naming, uri, position)
    if place is None:
        return []
    kinds = {True: types.DocumentHighlightKind.Write, False: types.DocumentHighlightKind.Read}
    return [
        types.DocumentHighlight(places.range(m.start, m.end), kinds[m.defines])
        for m in mentions_of(source).all
        if _same(naming, source, m, place)
    ]


def mentions(documents: Documents, uri: str, position: types.Position) -> Iterator[tuple[Source, Mention]]:
    """The texts and places that speak of the thing at a place."""
    place = place_at(documents, documents.naming(uri), uri, position)
    if place is None:
        return
    local = place.definition.mention.home.startswith("@")
    buffers = [documents.source(other) for other in documents.workspace.text_documents]
    for source in [documents.source(uri)] if local else _with_home(documents, place):
        if not local and not _speaks_of(source, place):
            continue
        naming = Naming(load_sources([source, *(b for b in buffers if b.path != source.path)])[0].sources)
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


def place_at(documents: Documents, naming: Naming, uri: str, position: types.Position) -> Place | None:
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
