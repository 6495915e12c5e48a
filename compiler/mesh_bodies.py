"""Convex bodies that stand for meshes of robots, remembered on the disk by what the files hold: to find the hull of a
large mesh takes seconds."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import Any

from ..langs.frozen import dataclass
from ..langs.grammar_loader import cache_folder
from ..langs.writer import write_atomically
from .collada import asset
from .ir import Vec3

METHOD = "1"
"""Told apart in the cache: how bodies are made of meshes. To be counted up with every change of it."""


class NoBody(Exception):
    """The file holds nothing that has a volume; the message says why."""


@dataclass(frozen=True, slots=True)
class MeshBody:
    """A convex body around a mesh: the corners of its shape, x, y, z, x, …; where the middle of the box around it lies
    in the frame of the mesh; what share of its hull the mesh fills (0: it is not closed); how many times as large as
    the hull the body is; and the unit (metres) and upward axis that the file itself names."""

    size: tuple[float, ...]
    middle: Vec3
    filled: float
    grown: float
    unit: float = 1.0
    up: str = ""

    def told(self) -> str:
        """What the body is, with the size of the simplification."""
        if self.grown > 1.0:
            words = [f"a body around it, of {self.grown:.2f} times the volume of its hull"]
        else:
            words = ["its hull" + (f", which it fills to {self.filled:.0%}" if 0.005 < self.filled < 0.995 else "")]
        if self.unit != 1.0:
            words.append(f"its unit of {self.unit:g} m counts")
        if self.up in ("X_UP", "Y_UP"):
            words.append(f"its axes are kept, though it says {self.up}, as other readers do")
        return "; ".join(words)


def mesh_body(path: str, content: bytes, scale: Sequence[float]) -> MeshBody:
    """The body of the mesh that a file of this name holds, `scale` times as large. Raises NoBody, and ValueError or
    RuntimeError when it cannot be read."""
    ending = os.path.splitext(path)[1].lower()
    told = json.dumps([METHOD, ending, list(scale)]).encode()
    file = cache_folder() / f"mesh-{hashlib.sha256(told + content).hexdigest()[:32]}.json"
    found = _recalled(file)
    if found is None:
        found = _made(path, content, scale)
        with suppress(OSError):
            file.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
            write_atomically(file, json.dumps(asdict(found)).encode())
    return found


def _recalled(file: Path) -> MeshBody | None:
    """The remembered body, where this user wrote it and it is whole."""
    try:
        if hasattr(os, "getuid") and file.stat().st_uid != os.getuid():
            return None
        told: dict[str, Any] = json.loads(file.read_bytes())
        size, (x, y, z) = tuple(map(float, told["size"])), map(float, told["middle"])
        numbers = float(told["filled"]), float(told["grown"]), float(told["unit"])
        whole = len(size) % 3 == 0 and len(size) >= 12
        return MeshBody(size, (x, y, z), *numbers, str(told["up"])) if whole else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _made(path: str, content: bytes, scale: Sequence[float]) -> MeshBody:
    from .hulls import HullError, convex_shape, fill, hull
    from .mesh_files import Empty, read_mesh

    unit, up = asset(content) if path.lower().endswith(".dae") else (1.0, "")
    try:
        points, triangles = read_mesh(path, content, [unit * s for s in scale])
        inside, around = fill(points, triangles)
        shape, middle, simpler = convex_shape(points)
    except (Empty, HullError) as reason:
        raise NoBody(str(reason)) from None
    filled = inside / around if 0 < inside <= around * (1 + 1e-9) else 0.0
    return MeshBody(shape.size, middle, filled, hull(shape).volume / around if simpler else 1.0, unit, up)
