"""Convex bodies that stand for meshes of robots, remembered on the disk by what the files hold: to find the hull of a
large mesh takes seconds."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from ..langs.disk_cache import cache_folder, keep_sealed, recalled_sealed
from ..langs.frozen import dataclass
from .collada import asset
from .ir import Vec3

METHOD = "2"
"""Told apart in the cache: how bodies are made of meshes. To be counted up with every change of it."""


HOLLOW, MOST_PARTS = 0.7, 8
"""A mesh that fills less of its hull is cut into convex parts, where it has no more than so many: robots with bent or
hollow links of flat faces, not those with castings, the hulls of which are fine."""


class NoBody(Exception):
    """The file holds nothing that has a volume; the message says why."""


@dataclass(frozen=True, slots=True)
class MeshBody:
    """A convex body around a mesh: the corners of its shape, x, y, z, x, …; where the middle of the box around it lies
    in the frame of the mesh; what share of its hull the mesh fills (0: it is not closed); how many times as large as
    the hull the body is; and the unit (metres) and upward axis that the file itself names. `parts` are convex ones that
    fill a hollow mesh, as sizes and middles, and `faults` what is wrong with its surface."""

    size: tuple[float, ...]
    middle: Vec3
    filled: float
    grown: float
    unit: float = 1.0
    up: str = ""
    faults: tuple[str, ...] = ()
    parts: tuple[tuple[tuple[float, ...], Vec3], ...] = ()

    def told(self) -> str:
        """What the body is, with the size of the simplification."""
        if self.grown > 1.0:
            words = [f"a body around it, of {self.grown:.2f} times the volume of its hull"]
        else:
            words = ["its hull" + (f", which it fills to {self.filled:.0%}" if 0.005 < self.filled < 0.995 else "")]
        if self.parts:
            words = [f"{len(self.parts)} convex parts, as the shape of an effector by its hull"]
        if self.unit != 1.0:
            words.append(f"its unit of {self.unit:g} m counts")
        if self.up in ("X_UP", "Y_UP"):
            words.append(f"its axes are kept, though it says {self.up}, as other readers do")
        return "; ".join([*words, *self.faults])


def mesh_body(path: str, content: bytes, scale: Sequence[float]) -> MeshBody:
    """The body of the mesh that a file of this name holds, `scale` times as large. Raises NoBody, and ValueError or
    RuntimeError when it cannot be read."""
    ending = os.path.splitext(path)[1].lower()
    told = json.dumps([METHOD, ending, list(scale)]).encode()
    file = cache_folder() / f"mesh-{hashlib.sha256(told + content).hexdigest()[:32]}.json"
    found = _recalled(file)
    if found is None:
        found = _made(path, content, scale)
        keep_sealed(file, json.dumps(asdict(found)).encode())
    return found


def _recalled(file: Path) -> MeshBody | None:
    """The remembered body, where this user wrote it and it is as it was written."""
    content = recalled_sealed(file)
    if content is None:
        return None
    try:
        told: dict[str, Any] = json.loads(content)
        size, (x, y, z) = tuple(map(float, told["size"])), map(float, told["middle"])
        numbers = float(told["filled"]), float(told["grown"]), float(told["unit"])
        whole = len(size) % 3 == 0 and len(size) >= 12
        parts = tuple((tuple(map(float, s)), (float(a), float(b), float(c))) for s, (a, b, c) in told["parts"])
        rest = str(told["up"]), tuple(map(str, told["faults"])), parts
        return MeshBody(size, (x, y, z), *numbers, *rest) if whole else None
    except (ValueError, KeyError, TypeError):
        return None


def _made(path: str, content: bytes, scale: Sequence[float]) -> MeshBody:
    from .convex_cuts import cut, hull_volume
    from .hulls import HullError, convex_shape, hull
    from .mesh_files import Empty, read_mesh
    from .mesh_surfaces import surface_of

    unit, up = asset(content) if path.lower().endswith(".dae") else (1.0, "")
    try:
        points, triangles = read_mesh(path, content, [unit * s for s in scale])
        shape, middle, simpler = convex_shape(points)
    except (Empty, HullError) as reason:
        raise NoBody(str(reason)) from None
    surface, around = surface_of(points, triangles), hull_volume(points)
    filled = surface.volume / around if surface.even and surface.volume > 0.0 else 0.0
    filled = filled if filled <= 1.0 + 1e-6 else 0.0
    cuts = cut(surface, MOST_PARTS) if 0.0 < filled < HOLLOW else None
    made = [convex_shape(corners) for corners in cuts or ()]
    parts = tuple((part.size, at) for part, at, _ in made)
    grown = hull(shape).volume / around if simpler and not parts else 1.0
    return MeshBody(shape.size, middle, filled, grown, unit, up, tuple(surface.faults()), parts)
