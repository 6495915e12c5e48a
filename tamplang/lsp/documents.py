"""The texts that the editor has open, those on the disk, and what their names stand for."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from lsprotocol import types
from pygls.uris import from_fs_path, to_fs_path
from pygls.workspace import TextDocument, Workspace

from ..compiler.imports import load_sources, on_disk
from ..compiler.mentions import Mention, mentions_of
from ..compiler.naming import Naming, Place
from ..compiler.standard import EXTENSION, STANDARD, STANDARD_FOLDER
from ..langs.diagnostics import SourceError
from ..langs.reader import read_source
from ..langs.source import Source
from .places import Places, places_of

MOST_FILES = 2000
"""How many files of a folder are looked through for mentions of a name."""


class Documents:
    """Texts by address. A buffer of the editor goes before the file of the same path."""

    def __init__(self, workspace: Workspace) -> None:
        self.workspace = workspace

    @property
    def unit(self) -> str:
        return types.PositionEncodingKind(self.workspace.position_encoding).value

    def document(self, uri: str) -> TextDocument:
        return self.workspace.get_text_document(uri)

    def source(self, uri: str) -> Source:
        """The text at an address, under the path by which imports know it."""
        return Source(path_of(uri), self.document(uri).source)

    def buffers(self, uri: str) -> list[Source]:
        """The text at an address, then all other open buffers, which serve its imports."""
        others = [self.source(other) for other in self.workspace.text_documents if other != uri]
        return [self.source(uri), *others]

    def naming(self, uri: str) -> Naming:
        return Naming(load_sources(self.buffers(uri))[0].sources)

    def places(self, source: Source) -> Places:
        return places_of(source.text, self.unit)

    def mention(self, uri: str, position: types.Position) -> Mention | None:
        source = self.source(uri)
        return mentions_of(source).at(self.places(source).offset(position))

    def uri(self, path: str) -> str:
        """The address of a text of an import; that of the buffer where it is open."""
        for open_uri in self.workspace.text_documents:
            if path_of(open_uri) == path:
                return str(open_uri)
        return from_fs_path(str(on_disk(path).resolve())) or path

    def location(self, place: Place) -> types.Location:
        mention = place.definition.mention
        found = self.places(place.source).range(mention.start, mention.end)
        return types.Location(self.uri(place.source.path), found)

    def programs(self) -> Iterator[Source]:
        """Every program of the open folders and every open buffer."""
        seen: set[str] = set()
        for uri in self.workspace.text_documents:
            seen.add(path_of(uri))
            yield self.source(uri)
        for folder in self.workspace.folders.values():
            root = to_fs_path(folder.uri)
            for path in sorted(Path(root).rglob(f"*{EXTENSION}"))[:MOST_FILES] if root else ():
                shown = path_of(path.as_uri())
                if shown in seen or any(part.startswith(".") for part in path.parts[1:]):
                    continue
                seen.add(shown)
                try:
                    yield Source(shown, read_source(path).text)
                except SourceError:
                    continue


def path_of(uri: str) -> str:
    """The path of a text: `std/NAME.tamp` for those of the standard library, as imports call them."""
    path = to_fs_path(uri)
    if path is None:
        return uri
    try:
        inside = Path(path).resolve().relative_to(STANDARD_FOLDER.resolve())
    except (ValueError, OSError):
        return path
    return f"{STANDARD}/{inside}"
