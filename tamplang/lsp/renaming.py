"""Another name for a thing, in all files, where every name still means what it did."""

from __future__ import annotations

import re

from lsprotocol import types

from ..compiler.builtins import FUNCTIONS
from ..compiler.imports import load_sources
from ..compiler.mentions import Mention
from ..compiler.naming import Naming, Place
from ..compiler.standard import STANDARD
from ..langs.source import Source
from ..langs.words import JOINTS, RESERVED, SHAPES, TYPES
from .documents import Documents
from .navigation import mentions, place_at

NAME = re.compile(r"[A-Za-z_]\w*")


class CannotRename(Exception):
    """The name belongs to the language or the standard library, or the new one is none or is taken."""


def renaming(documents: Documents, uri: str, position: types.Position, name: str) -> types.WorkspaceEdit:
    """The edits that give the thing at a place another name, in all files. Raises CannotRename."""
    renamable(documents, uri, position)
    place = place_at(documents, documents.naming(uri), uri, position)
    assert place is not None
    _check_name(place, name)
    found: dict[Source, list[Mention]] = {}
    for source, mention in mentions(documents, uri, position):
        found.setdefault(source, []).append(mention)
    if name != place.definition.mention.name:
        _check_meanings(documents, found, place, name)
    changes = {
        documents.uri(source.path): [
            types.TextEdit(documents.places(source).range(m.start, m.end), name) for m in several
        ]
        for source, several in found.items()
    }
    return types.WorkspaceEdit(changes=changes)


def renamable(documents: Documents, uri: str, position: types.Position) -> types.Range:
    """The place of the name, if it can be another. Raises CannotRename."""
    mention = documents.mention(uri, position)
    place = place_at(documents, documents.naming(uri), uri, position)
    if mention is None or place is None:
        raise CannotRename("only what a program declares can get another name")
    if place.source.path.startswith(f"{STANDARD}/"):
        raise CannotRename("this name is declared by the standard library")
    return documents.places(documents.source(uri)).range(mention.start, mention.end)


def _check_name(place: Place, name: str) -> None:
    if NAME.fullmatch(name) is None:
        raise CannotRename(f"`{name}` is no name: one begins with a letter, and has letters, digits and _")
    taken = {*FUNCTIONS, *SHAPES, *JOINTS} if place.definition.mention.kind == "function" else set[str]()
    if name in RESERVED or name in TYPES or name in taken:
        raise CannotRename(f"`{name}` is no name for it: it is a word of the language")


def _check_meanings(documents: Documents, found: dict[Source, list[Mention]], place: Place, name: str) -> None:
    """That nothing else is called so where the thing is in sight, and that no name means another thing afterwards."""
    buffers = [documents.source(uri) for uri in documents.workspace.text_documents]
    for main in found:
        sources = load_sources([main, *(b for b in buffers if b.path != main.path)])[0].sources
        before = Naming(sources)
        after = Naming([_renamed(s, found.get(s, []), name) for s in sources])
        taken = _other(before, place, name) or _changed(before, after)
        if taken is not None:
            line = taken.source.text.count("\n", 0, taken.definition.mention.start) + 1
            raise CannotRename(f"`{name}` is taken: see line {line} of {taken.source.path}")


def _renamed(source: Source, mentioned: list[Mention], name: str) -> Source:
    text = source.text
    for mention in sorted(mentioned, key=lambda m: -m.start):
        text = text[: mention.start] + name + text[mention.end :]
    return Source(source.path, text)


def _other(naming: Naming, place: Place, name: str) -> Place | None:
    """What has that name already, beside the thing."""
    mention = place.definition.mention
    same = (
        Place(file.source, d)
        for file in naming.files.values()
        for d in file.definitions
        if (d.mention.kind, d.mention.name, d.mention.home) == (mention.kind, name, mention.home)
    )
    return next(same, None)


def _changed(before: Naming, after: Naming) -> Place | None:
    """What some name means afterwards, where that is not what it meant before."""
    moved = {
        (path, old.mention.start): (path, new.mention.start)
        for path, file in before.files.items()
        for old, new in zip(file.definitions, after.files[path].definitions, strict=False)
    }
    for path, file in before.files.items():
        for old, new in zip(file.all, after.files[path].all, strict=False):
            meant, means = before.meant(path, old), after.meant(path, new)
            if means is not None and (meant is None or moved.get(meant.key) != means.key):
                return means
    return None
