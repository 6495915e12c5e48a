"""URDF files that module types are taken from, read beside the file that names them.

Meshes among the collision shapes are replaced by their hulls when the file is read, so that the text alone says
everything. A plan carries URDF and meshes as they are, and a verifier builds the same module without the disk.
"""

from __future__ import annotations

import math
import posixpath
import re
from collections.abc import Iterable, Iterator
from xml.etree import ElementTree

from ..langs import syntax
from ..langs.diagnostics import Diagnostic, SourceError
from ..langs.reader import source_of
from ..langs.source import Source
from .foreign import Files, Missing, beside
from .ir import Vec3
from .mesh_files import read_mesh
from .poses import Quaternion, roll_pitch_yaw, rotate
from .xml_texts import XmlError, decoded, read_xml

ABOVE = 32
"""How many folders above a URDF are searched for a package."""


def urdf_path(importer: str, module: syntax.ModuleDecl) -> str:
    """The path of a module's URDF as the user should see it."""
    assert module.urdf is not None
    return beside(importer, module.urdf.value)


def load_urdf(
    path: str, module: syntax.ModuleDecl, names: dict[str, str], files: Files
) -> tuple[Source | None, list[Diagnostic]]:
    """The text at `path`, with hulls for meshes, and what is wrong with the files. `names` is told how the meshes are
    called on any machine."""
    assert module.urdf is not None
    where = module.urdf.span
    try:
        source = source_of(path, decoded(files.read(path)))
    except Missing as reason:
        message = str(reason).replace("there is no file", "there is no URDF file", 1)
        return None, [Diagnostic("E0513", message, where, help=reason.help)]
    except SourceError as error:
        return None, [Diagnostic("E0513", f"{path}: {error.diagnostics[0].message}", where)]
    if "<mesh" not in source.text:
        return source, []
    try:
        root = read_xml(source.text)
    except XmlError:
        return source, []
    newer = quaternions_count(root)
    hulls = (_hull_for_mesh(path, c, newer, module, names, files) for c in root.findall("link/collision"))
    diagnostics = [d for d in hulls if d is not None]
    return Source(path, ElementTree.tostring(root, encoding="unicode")), diagnostics


def _hull_for_mesh(
    path: str, collision: ElementTree.Element, newer: bool, module: syntax.ModuleDecl, names: dict[str, str],
    files: Files,
) -> Diagnostic | None:  # fmt: skip
    """Put the hull in place of a mesh, and move the element's origin to the middle of the box around it."""
    from .hulls import HullError, convex_shape

    assert module.urdf is not None
    geometry = collision.find("geometry")
    mesh = None if geometry is None else geometry.find("mesh")
    if geometry is None or mesh is None:
        return None
    name = mesh.get("filename", "")
    places = list(_mesh_places(path, name))
    chosen = files.first(places)
    if chosen is None:
        return Diagnostic("E0515", f'there is no mesh file "{name}" for {path}', module.urdf.span)
    file, names[places[chosen]] = places[chosen], list(_mesh_places(names[path], name))[chosen]
    try:
        scale = three(mesh, "scale") if mesh.get("scale") else (1.0, 1.0, 1.0)
        points, _ = read_mesh(file, files.read(file), scale)
        made, middle, simpler = convex_shape(points)
    except XmlError as reason:
        return Diagnostic("E0515", f'the mesh file "{name}" of {path}: {reason}', module.urdf.span)
    except (Missing, ValueError, RuntimeError, HullError):
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


def _mesh_places(path: str, name: str) -> Iterator[str]:
    """Where the file of a mesh may be; `package://NAME/…` is looked for in the folders above the URDF."""
    package = name.removeprefix("package://")
    if package == name:
        yield beside(path, name.removeprefix("file://"))
        return
    for inside in (package, package.partition("/")[2]):
        for above in range(ABOVE):
            yield posixpath.normpath(beside(path, posixpath.join("../" * above, inside)))
