"""URDF files that module types are taken from, read beside the file that names them.

Meshes among the collision shapes are replaced by their hulls when the file is read, so that the text alone
says everything: a plan carries it, and a verifier builds the same module without the disk.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from xml.etree import ElementTree

from ..langs import syntax
from ..langs.diagnostics import Diagnostic, SourceError
from ..langs.reader import read_bytes, source_of
from ..langs.source import Source
from .ir import Vec3
from .mesh_files import read_mesh
from .poses import Quaternion, roll_pitch_yaw, rotate
from .xml_texts import XmlError, decoded, read_xml


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
        source = given[path] if path in given else source_of(path, decoded(read_bytes(path)))
    except SourceError as error:
        found = error.diagnostics[0]
        missing = found.code == "E0010"
        message = f"there is no URDF file {path}" if missing else f"{path}: {found.message}"
        return None, [Diagnostic("E0513", message, where)]
    if "<mesh" not in source.text:
        return source, []
    try:
        root = read_xml(source.text)
    except XmlError:
        return source, []
    newer = quaternions_count(root)
    hulls = (_hull_for_mesh(path, c, newer, module) for c in root.findall("link/collision"))
    diagnostics = [d for d in hulls if d is not None]
    return Source(path, ElementTree.tostring(root, encoding="unicode")), diagnostics


def _hull_for_mesh(
    path: str, collision: ElementTree.Element, newer: bool, module: syntax.ModuleDecl
) -> Diagnostic | None:
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
        place, turn = three(origin, "xyz"), turned(origin, newer)
    except ValueError:
        return None
    shift = rotate(turn, middle)
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


FIRST_WITH_QUATERNIONS = "1.1"
"""The version of URDF from which on `quat_xyzw` counts."""


def quaternions_count(robot: ElementTree.Element) -> bool:
    """Whether a `quat_xyzw` is read; a file that names no version is of 1.0, where it is passed over."""
    version = re.fullmatch(r"([0-9]{1,4})\.([0-9]{1,4})", robot.get("version", "").strip())
    return version is not None and (int(version[1]), int(version[2])) >= (1, 1)


def turned(origin: ElementTree.Element | None, newer: bool) -> Quaternion:
    """The rotation of an origin, by `rpy` or, where quaternions count, by `quat_xyzw`. Raises ValueError when it is
    none."""
    text = origin.get("quat_xyzw") if origin is not None and newer else None
    if origin is None or text is None:
        roll, pitch, yaw = three(origin, "rpy")
        if not all(map(math.isfinite, (roll, pitch, yaw))):
            raise ValueError("`rpy` is not three numbers")
        return roll_pitch_yaw(roll, pitch, yaw)
    if origin.get("rpy") is not None:
        raise ValueError("it has both `rpy` and `quat_xyzw`")
    values = [float(word) for word in text.split()]
    norm = math.hypot(*values)
    if len(values) != 4 or not 0.0 < norm < math.inf:
        raise ValueError("`quat_xyzw` is not four numbers, not all of them 0")
    x, y, z, w = (value / norm for value in values)
    return x, y, z, w


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
