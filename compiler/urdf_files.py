"""URDF files that module types are taken from, read beside the file that names them.

Meshes among the collision shapes are replaced by their hulls when the file is read, so that the text alone
says everything: a plan carries it, and a verifier builds the same module without the disk.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from xml.etree import ElementTree

from ..langs import syntax
from ..langs.diagnostics import Diagnostic, SourceError
from ..langs.reader import read_source
from ..langs.source import Source
from .ir import Vec3
from .mesh_files import read_mesh
from .poses import roll_pitch_yaw, rotate


def urdf_path(importer: str, module: syntax.ModuleDecl) -> str:
    """The path of a module's URDF as the user should see it, relative to the file that names it."""
    assert module.urdf is not None
    return os.path.normpath(os.path.join(os.path.dirname(importer), module.urdf.value))


def load_urdf(
    path: str, module: syntax.ModuleDecl, given: Mapping[str, Source]
) -> tuple[Source | None, list[Diagnostic]]:
    """The text at `path`, from `given` or the disk, with hulls for meshes, and what is wrong with the files."""
    assert module.urdf is not None
    where = module.urdf.span
    try:
        source = given[path] if path in given else Source(path, read_source(path).text)
    except SourceError as error:
        found = error.diagnostics[0]
        missing = found.code == "E0010"
        message = f"there is no URDF file {path}" if missing else f"{path}: {found.message}"
        return None, [Diagnostic("E0513", message, where)]
    if "<mesh" not in source.text:
        return source, []
    try:
        root = ElementTree.fromstring(source.text)
    except ElementTree.ParseError:
        return source, []
    diagnostics = [d for c in root.iter("collision") if (d := _hull_for_mesh(path, c, module)) is not None]
    return Source(path, ElementTree.tostring(root, encoding="unicode")), diagnostics


def _hull_for_mesh(path: str, collision: ElementTree.Element, module: syntax.ModuleDecl) -> Diagnostic | None:
    """Put the hull in place of a mesh, and move the element's origin to the middle of the box around it."""
    from .hulls import HullError, convex_shape

    assert module.urdf is not None
    geometry = collision.find("geometry")
    mesh = None if geometry is None else geometry.find("mesh")
    if geometry is None or mesh is None:
        return None
    name = mesh.get("filename", "")
    file = _mesh_file(path, name)
    if file is None:
        return Diagnostic("E0515", f'there is no mesh file "{name}" for {path}', module.urdf.span)
    try:
        points, _ = read_mesh(file, three(mesh, "scale") if mesh.get("scale") else (1.0, 1.0, 1.0))
        made, middle, simpler = convex_shape(points)
    except (ValueError, RuntimeError, HullError):
        return Diagnostic("E0515", f'the mesh file "{name}" of {path} cannot be read', module.urdf.span)
    geometry.remove(mesh)
    geometry.append(ElementTree.Element("convex", points=_text(made.size)))
    origin = collision.find("origin")
    if origin is None:
        origin = ElementTree.SubElement(collision, "origin")
    try:
        place, turn = three(origin, "xyz"), three(origin, "rpy")
    except ValueError:
        return None
    shift = rotate(roll_pitch_yaw(*turn), middle)
    origin.set("xyz", _text(p + s for p, s in zip(place, shift, strict=True)))
    how = "by a simple body around it" if simpler else "by its hull"
    return Diagnostic("W0006", f'the mesh "{name}" is replaced {how}', module.urdf.span)


def _text(values: Iterable[float]) -> str:
    return " ".join(map(repr, values))


def three(element: ElementTree.Element | None, name: str) -> Vec3:
    """The three numbers of an attribute, 0 where it lacks. Raises ValueError when they are not three numbers."""
    text = None if element is None else element.get(name)
    x, y, z = map(float, (text or "0 0 0").split())
    return x, y, z


def _mesh_file(path: str, name: str) -> Path | None:
    """The file of a mesh; `package://NAME/…` is looked for in the folders above the URDF."""
    folder = Path(path).resolve().parent
    package = name.removeprefix("package://")
    if package == name:
        places = [folder / name.removeprefix("file://")]
    else:
        places = [above / package for above in (folder, *folder.parents)]
        places += [above / package.partition("/")[2] for above in (folder, *folder.parents)]
    return next((p for p in places if p.is_file()), None)
