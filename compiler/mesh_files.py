"""Files of meshes that bodies are taken from, read beside the text that names them.

What shapes are made of is a list of corners, as text: of a mesh's hull, then of its convex parts. The file itself goes
with a plan, byte by byte, so that a verifier builds the same body without the disk; and the parts with it, where
another program made them.
"""

from __future__ import annotations

import errno
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from ..langs import syntax
from ..langs.diagnostics import Diagnostic
from ..langs.source import Source
from ..langs.trees import parts
from .foreign import Files, Missing
from .named_meshes import FORMATS
from .xml_texts import XmlError, refuse_document_types

if TYPE_CHECKING:
    from tempfile import TemporaryDirectory

    from .hulls import Array

class Empty(ValueError):
    """A mesh without triangles."""


MESH_CALLS = ("mesh", "hull")
LONG = 500_000
"""Bytes of a file that takes a twentieth of a second to read: larger ones are read apart."""
OBJ_LINES = (b"v", b"vt", b"vn", b"f")
"""How the lines of an OBJ begin that tell its shape. Others name files of materials, which nobody shall open."""


def mesh_calls(declaration: syntax.Declaration) -> Iterator[tuple[syntax.Call, syntax.Text]]:
    """The shapes of a declaration that name a file, with its name."""
    for call in _shapes(declaration):
        if call.function in MESH_CALLS and call.args and isinstance(call.args[0], syntax.Text):
            yield call, call.args[0]


def _shapes(declaration: syntax.Declaration) -> Iterator[syntax.Call]:
    if isinstance(declaration, syntax.SceneDecl | syntax.TaskDecl):
        for shape in _shapes_of_bodies(declaration.items):
            yield from (part for part in parts(shape) if isinstance(part, syntax.Call))
    elif isinstance(declaration, syntax.ModuleDecl):
        for item in declaration.flat():
            if isinstance(item, syntax.EffectorItem) and item.shape is not None:
                yield item.shape


def _shapes_of_bodies(items: Sequence[syntax.SceneItem]) -> Iterator[syntax.Call]:
    for item in items:
        if isinstance(item, syntax.BodyItem):
            yield item.shape
        elif isinstance(item, syntax.ForItem | syntax.IfItem):
            yield from _shapes_of_bodies(item.items)


def load_mesh(
    path: str, call: syntax.Call, where: syntax.Text, files: Files
) -> tuple[Source | None, list[Diagnostic]]:
    """The corners of what the mesh at `path` holds, as `mesh_solids.listed` gives them, and what is wrong with the
    file. `mesh` asks for convex parts, `hull` for the hull alone."""
    from .hulls import HullError
    from .mesh_solids import NoParts, listed, mesh_hull, mesh_solid

    if not where.value.strip() or "://" in where.value:
        told, help = ("the mesh has no file", None) if not where.value.strip() else (
            f"{where.value} is no file on this machine", "fetch it first: nothing is read over the network"
        )  # fmt: skip
        return None, [Diagnostic("E0515", told, where.span, help=help)]
    try:
        content = files.read(path)
        points, triangles = read_mesh(path, content)
    except XmlError as reason:
        return None, [Diagnostic("E0515", f"{path}: {reason}", where.span)]
    except Missing as reason:
        message = str(reason).replace("there is no file", "there is no mesh file", 1)
        return None, [Diagnostic("E0515", message, where.span, help=reason.help)]
    except (ValueError, RuntimeError):
        return None, [Diagnostic("E0515", f"the mesh file {path} cannot be read", where.span)]
    try:
        whole = call.function == "hull"
        solid = mesh_hull(points, triangles) if whole else mesh_solid(content, points, triangles, files.made(path))
    except HullError as error:
        return None, [Diagnostic("E0509", f"the mesh file {path} holds no body: {error}", where.span)]
    except NoParts as reason:
        help = f'write `hull("{where.value}")` to take the hull, or build the body of several convex ones'
        help = f"{reason.help}; or {help}" if reason.help else help
        message = f"the mesh of {path} cannot be cut into convex parts: {reason}"
        return None, [Diagnostic("E0518", message, where.span, help=help)]
    text = listed(solid)
    unsound = f"the mesh of {path}: {'; '.join(solid.faults)}"
    warnings = [Diagnostic("W0022", unsound, where.span)] if solid.faults else []
    if solid.grown > 1.0:
        count, grown = len(solid.parts), solid.grown
        message = f"the mesh of {path} is split into {count} convex parts, of {grown:.2f} times its volume"
        warnings.append(Diagnostic("W0006", message, where.span))
        files.make(path, text)
    return Source(path, text), warnings


def read_mesh(path: str, content: bytes, scale: Sequence[float] = (1.0, 1.0, 1.0)) -> tuple[Array, Array]:
    """Points (M, 3) and triangles (T, 3) of the mesh that a file of one of `FORMATS` holds. Raises ValueError or
    RuntimeError when it cannot be read or is empty, XmlError where it declares a document type, and OSError where no
    temporary file can be written."""
    import numpy as np

    from .apart import apart

    ending = Path(path).suffix.lower()
    if ending not in FORMATS:
        raise ValueError(f"it is none of {', '.join(FORMATS)}")
    if _holds_nothing(ending, content):
        raise Empty("it holds no triangles")
    if ending == ".dae":
        refuse_document_types(content)
    with _folder() as folder:
        file = Path(folder) / f"mesh{ending}"
        file.write_bytes(_shape_alone(content) if ending == ".obj" else content)
        loaded = partial(_loaded, file, scale)
        points, triangles = apart(loaded) if len(content) > LONG else loaded()
    if not len(triangles):
        raise Empty("it holds no triangles")
    if not np.isfinite(points).all():
        raise ValueError("a corner is not finite")
    return points, triangles


def _folder() -> TemporaryDirectory[str]:
    """Where a mesh lies while it is loaded. Raises OSError that says what cannot be written."""
    from tempfile import TemporaryDirectory

    try:
        return TemporaryDirectory(prefix="tamplang-")
    except FileNotFoundError as reason:  # what is said where all such folders are full, too
        raise OSError(errno.ENOSPC, reason.strerror, "temporary files") from reason


def _loaded(file: Path, scale: Sequence[float]) -> tuple[Array, Array]:
    import coal
    import numpy as np

    mesh = coal.MeshLoader().load(str(file), np.array(scale, dtype=float))
    triangles = np.array([[t[0], t[1], t[2]] for t in map(mesh.tri_indices, range(mesh.num_tris))])
    return np.array(mesh.vertices(), dtype=float).reshape(-1, 3), triangles


def _holds_nothing(ending: str, content: bytes) -> bool:
    """Whether a file is sound and has no triangle, which the loader tells no other way than that it is broken."""
    if ending == ".stl":
        if content.lstrip().startswith(b"solid") and b"endsolid" in content:
            return b"facet" not in content
        return len(content) >= 80 and not any(content[80:84])  # some write the header alone
    words = [line.split(None, 1)[0] for line in content.splitlines() if line.split()]
    return ending == ".obj" and all(w.startswith(b"#") or (w in (*OBJ_LINES, b"o", b"g") and w != b"f") for w in words)


def _shape_alone(content: bytes) -> bytes:
    lines = content.replace(b"\r\n", b"\n").replace(b"\r", b"\n").replace(b"\\\n", b" ").split(b"\n")
    return b"".join(line + b"\n" for line in lines if line.split(None, 1)[:1] and line.split(None, 1)[0] in OBJ_LINES)
