"""URDF files that module types are taken from, and the meshes that they name, read beside the file that names them.

A plan carries URDF and meshes as they are, and a verifier builds the same module without the disk.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from xml.etree import ElementTree

from ..langs import syntax
from ..langs.diagnostics import Diagnostic, Label, SourceError
from ..langs.reader import source_of
from ..langs.source import Source
from .foreign import Files, Missing, beside
from .ir import Vec3
from .mesh_bodies import MeshBody
from .named_meshes import UnreadMesh, named_mesh
from .poses import Quaternion, roll_pitch_yaw
from .xml_texts import XmlError, decoded, read_xml, span_of

MeshName = tuple[str, str, str]
"""A mesh of a URDF: the path of the URDF, its `filename` and its `scale`."""


@dataclass(slots=True)
class UrdfFile:
    """The text of a URDF, None where there is none, the bodies of its meshes, and what is wrong with the files. A mesh
    without a body has None."""

    source: Source | None = None
    meshes: dict[MeshName, MeshBody | None] = field(default_factory=dict)
    diagnostics: list[Diagnostic] = field(default_factory=list)


def urdf_path(importer: str, module: syntax.ModuleDecl) -> str:
    """The path of a module's URDF as the user should see it."""
    assert module.urdf is not None
    return beside(importer, module.urdf.value)


def load_urdf(path: str, module: syntax.ModuleDecl, names: dict[str, str], files: Files) -> UrdfFile:
    """The file at `path`. `names` is told how the meshes are called on any machine."""
    assert module.urdf is not None
    where, found = module.urdf.span, UrdfFile()
    try:
        found.source = source_of(path, decoded(files.read(path)))
    except Missing as reason:
        message = str(reason).replace("there is no file", "there is no URDF file", 1)
        found.diagnostics.append(Diagnostic("E0513", message, where, help=reason.help))
    except SourceError as error:
        found.diagnostics.append(Diagnostic("E0513", f"{path}: {error.diagnostics[0].message}", where))
    if found.source is not None and "<mesh" in found.source.text:
        _load_meshes(found, found.source, Label(where, "read for this module"), names, files)
    return found


def _load_meshes(found: UrdfFile, source: Source, label: Label, names: dict[str, str], files: Files) -> None:
    """The bodies of all meshes among the collision shapes."""
    try:
        root = read_xml(source.text)
    except XmlError:
        return
    for mesh in root.findall("link/collision/geometry/mesh"):
        key = mesh_name(source.path, mesh)
        if key not in found.meshes:
            found.meshes[key] = None
            code, message = _load_mesh(found, key, names, files)
            found.diagnostics.append(Diagnostic(code, message, span_of(source, mesh), (label,)))


def mesh_name(path: str, mesh: ElementTree.Element) -> MeshName:
    """What a mesh of the URDF at `path` is called in `UrdfFile.meshes`."""
    return path, mesh.get("filename", ""), " ".join(mesh.get("scale", "1 1 1").split())


def _load_mesh(found: UrdfFile, key: MeshName, names: dict[str, str], files: Files) -> tuple[str, str]:
    """Reads the body of a mesh into `found`; gives the code and the words of what is to be told."""
    path, name, scale_text = key
    try:
        scale = tuple(map(float, scale_text.split()))
    except ValueError:
        scale = ()
    if len(scale) != 3:
        return "E0515", f'the scale of the mesh "{name}" is not three numbers: `{scale_text[:40]}`'
    try:
        mesh = named_mesh(path, name, scale, files)
    except UnreadMesh as reason:
        return "W0010" if reason.left_out else "E0515", str(reason)
    names[mesh.file] = mesh.seen_from(path, name, names[path])
    found.meshes[key] = mesh.body
    return "W0006", mesh.told


def three(element: ElementTree.Element | None, name: str) -> Vec3:
    """The three numbers of an attribute, 0 where it lacks. Raises ValueError when they are not three numbers."""
    text = None if element is None else element.get(name)
    x, y, z = map(float, (text or "0 0 0").split())
    return x, y, z


def at_least_1_1(robot: ElementTree.Element) -> bool:
    """Whether `quat_xyzw` and `capsule` count; a file that names no version is of 1.0, where they do not."""
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
