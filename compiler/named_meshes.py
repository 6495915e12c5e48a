"""Meshes that files of others name: where they lie on the disk, and the bodies that stand for them."""

from __future__ import annotations

import posixpath
import re
from collections.abc import Iterator, Sequence

from ..langs.frozen import dataclass
from .foreign import Files, Missing, beside
from .mesh_bodies import MeshBody, NoBody, mesh_body
from .xml_texts import XmlError

ABOVE = 32
"""How many folders above a file are searched for a package."""
DEEPEST = 8
"""How many folders of a name are left away at most."""
FORMATS = (".stl", ".obj", ".ply", ".dae")
"""Endings of meshes that are one file: what lies in several cannot go with a plan."""
_SCHEME = re.compile(r"(package|model)://")


class UnreadMesh(Exception):
    """A mesh has no body. The message says why; `left_out` tells whether that is because it has no volume, so that
    nothing can be run into."""

    def __init__(self, message: str, left_out: bool = False) -> None:
        super().__init__(message)
        self.left_out = left_out


@dataclass(frozen=True, slots=True)
class NamedMesh:
    """The body of a mesh, the path of its file, and which of `mesh_places` that is, None where it was searched for.
    `told` says what the body is."""

    body: MeshBody
    file: str
    place: int | None
    told: str

    def seen_from(self, path: str, name: str, to: str) -> str:
        """What the file of the mesh `name`, which lies so beside `path`, is called beside `to`."""
        if self.place is not None:
            return list(mesh_places(to, name))[self.place][0]
        return beside(to, posixpath.relpath(self.file, posixpath.dirname(path) or "."))


def named_mesh(path: str, name: str, scale: Sequence[float], files: Files) -> NamedMesh:
    """The body of the mesh `name` that the file at `path` names, `scale` times as large. Raises UnreadMesh."""
    if not name.strip():
        raise UnreadMesh("a mesh has no file")
    file, place, fits = _found(path, name, files)
    if posixpath.splitext(file)[1].lower() not in FORMATS:
        raise UnreadMesh(f'the mesh file "{name}" cannot be read: it is none of {", ".join(FORMATS)}')
    beside_package = "" if fits else f"; no folder of the name of its package holds it, so {file} is taken"
    try:
        body = mesh_body(file, files.read(file), scale)
    except NoBody as reason:
        raise UnreadMesh(f'the mesh "{name}" is left out: {reason}', left_out=True) from None
    except (Missing, XmlError, ValueError, RuntimeError) as reason:
        help = f": {reason}" if isinstance(reason, Missing | XmlError) else ""
        raise UnreadMesh(f'the mesh file "{name}" cannot be read{help}') from None
    return NamedMesh(body, file, place, f'the mesh "{name}" is replaced by {body.told()}{beside_package}')


def _found(path: str, name: str, files: Files) -> tuple[str, int | None, bool]:
    """The file of a mesh, which of `mesh_places` it is, and whether it is where the name says. What lies in none of
    them is the one file in the folder of the model, or the one above, whose path ends like the name without its
    scheme. Raises UnreadMesh."""
    places = list(mesh_places(path, name))
    chosen = files.first([place for place, _ in places])
    if chosen is not None:
        return places[chosen][0], chosen, places[chosen][1]
    package = _SCHEME.sub("", name, count=1)
    for above in ("", "..") if package != name and ".." not in package.split("/") else ():
        alike = files.ending(beside(path, above), package)
        if len(alike) > 1:
            told = ", ".join(alike[:3]) + (", …" if len(alike) > 3 else "")
            raise UnreadMesh(f'there is no mesh file "{name}", and several are called so: {told}')
        if alike:
            return alike[0], None, False
    raise UnreadMesh(f'there is no mesh file "{name}"')


def mesh_places(path: str, name: str) -> Iterator[tuple[str, bool]]:
    """Where the file of a mesh may be, and whether that is where its name says; `package://NAME/…` is looked for in the
    folders above the file that names it, first under NAME, then without it and without the folders that follow, as
    models are copied out of larger packages."""
    package = _SCHEME.sub("", name, count=1) if _SCHEME.match(name) else None
    if package is None:
        yield beside(path, name.removeprefix("file://")), True
        return
    folders = package.split("/")
    for left in range(max(2, min(len(folders) - 1, DEEPEST))):
        for above in range(ABOVE):
            inside = posixpath.join("../" * above, "/".join(folders[left:]))
            yield posixpath.normpath(beside(path, inside)), left == 0
