"""What a mesh holds, as convex parts, remembered on the disk by what the file holds: to cut a mesh can take seconds."""

from __future__ import annotations

import hashlib
import json
from dataclasses import replace
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..langs.disk_cache import cache_folder, keep_sealed, recalled_sealed
from ..langs.frozen import dataclass
from .apart import apart
from .convex_cuts import cut, hull_volume
from .hulls import Array, HullError, corners_of
from .mesh_surfaces import Surface, surface_of

METHOD = "2"
"""Told apart in the cache: how parts are made of meshes. To be counted up with every change of it."""
BULGE = 0.01
"""A mesh whose hull is larger by less than this share passes for convex."""
CONCAVE = 0.05
"""How far a part may be from convex that coacd makes, its own measure and default."""
FINEST = 100
"""Corners of one of its parts, at most."""
OFF = 0.02
"""Share of the size of a mesh by which its corners may lie outside its parts."""

Points = tuple[tuple[float, float, float], ...]


class NoParts(Exception):
    """A mesh cannot be cut into convex parts; the message says why. `help` tells what to do."""

    def __init__(self, message: str, help: str | None = None) -> None:
        super().__init__(message)
        self.help = help


@dataclass(frozen=True, slots=True)
class MeshSolid:
    """`corners` of the hull of a mesh, in the units of the file, and of the convex `parts` that fill it, none where it
    is convex. `faults` of its surface in words. `grown`: how many times as large as the mesh the parts are together, 1
    where they are exact."""

    corners: Points
    parts: tuple[Points, ...]
    faults: tuple[str, ...]
    grown: float = 1.0


def mesh_hull(points: Array, triangles: NDArray[np.number[Any]]) -> MeshSolid:
    """The hull of a mesh. Raises HullError."""
    surface = _sound(points, triangles)
    return MeshSolid(_points(corners_of(surface.points)), (), tuple(surface.faults()))


def mesh_solid(
    content: bytes, points: Array, triangles: NDArray[np.number[Any]], given: str | None
) -> MeshSolid:
    """What a mesh holds that `content` is the file of; `given` are parts of it that another made, as `listed` gives
    them. Raises HullError and NoParts."""
    file = cache_folder() / f"parts-{hashlib.sha256(METHOD.encode() + content).hexdigest()[:32]}.json"
    found = _recalled(file) if given is None else None
    if found is None:
        found = _made(_sound(points, triangles), given)
        if given is None:
            keep_sealed(file, json.dumps([found.corners, found.parts, found.faults, found.grown]).encode())
    return found


def _recalled(file: Path) -> MeshSolid | None:
    """What is remembered, where this user wrote it and it is whole."""
    content = recalled_sealed(file)
    if content is None:
        return None
    try:
        corners, parts, faults, grown = json.loads(content)
        return MeshSolid(_tuples(corners), tuple(map(_tuples, parts)), tuple(map(str, faults)), float(grown))
    except (ValueError, TypeError):
        return None


def _tuples(rows: Any) -> Points:
    return tuple((float(x), float(y), float(z)) for x, y, z in rows)


def _points(rows: Array) -> Points:
    return _tuples(rows.tolist())


def _sound(points: Array, triangles: NDArray[np.number[Any]]) -> Surface:
    """The surface of a mesh that has a hull. Raises HullError."""
    surface = surface_of(points, triangles)
    if not len(surface.triangles):
        raise HullError("none of its faces has an area")
    if hull_volume(surface.points) <= 0.0:
        raise HullError("the corners lie in a plane")
    return surface


def _made(surface: Surface, given: str | None) -> MeshSolid:
    faults, around = tuple(surface.faults()), hull_volume(surface.points)
    corners = _points(corners_of(surface.points))
    if surface.even and surface.volume >= (1.0 - BULGE) * around:
        return MeshSolid(corners, (), _closed(surface))
    exact = cut(surface)
    if exact is not None:
        return MeshSolid(corners, tuple(map(_points, exact)), _closed(surface))
    if surface.gaps and _lies_on_hull(surface):
        return MeshSolid(corners, (), faults)
    if surface.gaps:
        raise NoParts(f"{faults[0]}, so that nobody can tell what it holds", "close its holes")
    if given is not None:
        parts = parts_of(given)[1:]
    else:
        parts = [np.array(p) for p in _by_coacd(surface, f"it fills {surface.volume / around:.0%} of its hull")]
    _check_cover(surface, parts)
    grown = sum(map(hull_volume, parts)) / surface.volume
    return MeshSolid(corners, tuple(map(_points, parts)), faults, max(1.001, grown))


def _closed(surface: Surface) -> tuple[str, ...]:
    """The faults of a surface that is closed, though edges of it may meet others half-way."""
    return tuple(replace(surface, gaps=0).faults())


def _lies_on_hull(surface: Surface) -> bool:
    from scipy.spatial import ConvexHull

    planes = ConvexHull(surface.points).equations
    middles = surface.points[surface.triangles].mean(axis=1)
    size = float(np.linalg.norm(np.ptp(surface.points, axis=0)))
    return bool((planes[:, :3] @ middles.T + planes[:, 3:]).max(axis=0).min() >= -BULGE * size)


def _by_coacd(surface: Surface, why: str) -> list[list[tuple[float, float, float]]]:
    """Convex parts that are nearly the mesh. Raises NoParts."""
    why = f"{why}, and has too many faces to be cut along them"
    try:
        return apart(partial(_coacd, surface.points, surface.triangles))
    except ImportError:
        help = "install the extra: pip install 'tamplang[meshes]'"
        raise NoParts(f"{why}; `coacd` could split it, but is not installed", help) from None
    except (MemoryError, RuntimeError, ValueError):
        raise NoParts(f"{why}, and `coacd` does not split it") from None


def _coacd(points: Array, triangles: NDArray[np.int64]) -> list[list[tuple[float, float, float]]]:
    coacd = import_module("coacd")
    coacd.set_log_level("off")
    parts = coacd.run_coacd(
        coacd.Mesh(points, triangles), threshold=CONCAVE, max_ch_vertex=FINEST, decimate=True, seed=0
    )  # fmt: skip
    solid = [np.asarray(corners, dtype=float) for corners, _ in parts]
    return [corners_of(corners).tolist() for corners in solid if hull_volume(corners) > 0.0]


def _check_cover(surface: Surface, parts: list[Array]) -> None:
    """That parts hold a mesh. Raises NoParts."""
    from scipy.spatial import ConvexHull, QhullError

    points = np.concatenate([surface.points, surface.points[surface.triangles].mean(axis=1)])
    off = np.full(len(points), np.inf)
    try:
        for corners in parts:
            planes = ConvexHull(corners).equations
            off = np.minimum(off, (points @ planes[:, :3].T + planes[:, 3]).max(axis=1))
    except (QhullError, ValueError):
        raise NoParts("one of the parts that it is split into is no body") from None
    size = float(np.linalg.norm(np.ptp(surface.points, axis=0)))
    if off.max(initial=-np.inf) > OFF * size:
        raise NoParts("the parts that it is split into leave something of it out")


def listed(solid: MeshSolid) -> str:
    """Corners as text: those of the hull, then those of the parts, with an empty line before each."""
    blocks = ("".join(f"{x!r} {y!r} {z!r}\n" for x, y, z in corners) for corners in (solid.corners, *solid.parts))
    return "\n".join(blocks)


def parts_of(text: str) -> list[Array]:
    """The corners (N, 3) of what `listed` gives: the hull, then the parts. Raises NoParts."""
    try:
        blocks = [[tuple(map(float, line.split())) for line in block.splitlines()] for block in text.split("\n\n")]
        return [np.array(block, dtype=float).reshape(-1, 3) for block in blocks]
    except ValueError:
        raise NoParts("what it is split into cannot be read") from None
