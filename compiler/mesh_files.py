"""Files of meshes that bodies are taken from, read beside the text that names them.

What is kept of a file is the list of the corners of its hull, as text: it goes with a plan, and a verifier builds the
same body without the disk.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ..langs import syntax
from ..langs.diagnostics import Diagnostic
from ..langs.source import Source

if TYPE_CHECKING:
    from .hulls import Array

MESH_CALLS = ("mesh", "hull")
BULGE = 0.01
"""A mesh whose hull is larger by less than this share passes for convex."""


def mesh_path(importer: str, name: str) -> str:
    """The path of a mesh as the user should see it, relative to the file that names it."""
    return os.path.normpath(os.path.join(os.path.dirname(importer), name))


def mesh_calls(declaration: syntax.Declaration) -> Iterator[tuple[syntax.Call, syntax.Text]]:
    """The shapes of a declaration that name a file, with its name."""
    for call in _shapes(declaration):
        if call.function in MESH_CALLS and call.args and isinstance(call.args[0], syntax.Text):
            yield call, call.args[0]


def _shapes(declaration: syntax.Declaration) -> Iterator[syntax.Call]:
    if isinstance(declaration, syntax.SceneDecl | syntax.TaskDecl):
        yield from _shapes_of_bodies(declaration.items)
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
    path: str, call: syntax.Call, where: syntax.Text, given: Mapping[str, Source]
) -> tuple[Source | None, list[Diagnostic]]:
    """The corners of the mesh at `path`, from `given` or the disk, and what is wrong with the file. `mesh` asks for a
    convex one."""
    if path in given:
        return given[path], []
    from .hulls import HullError, corners_of, fill

    if not Path(path).is_file():
        return None, [Diagnostic("E0515", f"there is no mesh file {path}", where.span)]
    try:
        points, triangles = read_mesh(Path(path))
    except (ValueError, RuntimeError):
        return None, [Diagnostic("E0515", f"the mesh file {path} cannot be read", where.span)]
    source = Source(path, "".join(f"{x!r} {y!r} {z!r}\n" for x, y, z in corners_of(points).tolist()))
    try:
        inside, around = fill(points, triangles)
    except HullError as error:
        return None, [Diagnostic("E0509", f"the mesh file {path} holds no body: {error}", where.span)]
    if call.function == "mesh" and not (1 - BULGE) * around <= inside <= (1 + BULGE) * around:
        message = f"the mesh of {path} is not convex: it fills {inside / around:.0%} of its hull"
        help = f'write `hull("{where.value}")` to take the hull, or build the body of several convex ones'
        return None, [Diagnostic("E0518", message, where.span, help=help)]
    return source, []


def read_mesh(file: Path, scale: Sequence[float] = (1.0, 1.0, 1.0)) -> tuple[Array, Array]:
    """Points (M, 3) and triangles (T, 3) of a mesh in any format that coal reads (STL, OBJ, DAE, …). Raises ValueError
    or RuntimeError when it cannot be read or is empty."""
    import coal
    import numpy as np

    mesh = coal.MeshLoader().load(str(file), np.array(scale, dtype=float))
    triangles = [[t[0], t[1], t[2]] for t in map(mesh.tri_indices, range(mesh.num_tris))]
    points = np.array(mesh.vertices(), dtype=float).reshape(-1, 3)
    if not triangles or not np.isfinite(points).all():
        raise ValueError("it holds no triangles" if not triangles else "a corner is not finite")
    return points, np.array(triangles)


def corner_list(source: Source) -> list[tuple[float, ...]]:
    """The corners that the text of a mesh lists."""
    return [tuple(map(float, line.split())) for line in source.text.splitlines()]
