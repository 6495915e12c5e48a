"""Shapes of rai's frames."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..ir import IDENTITY
from .mesh_forms import MeshReader
from .models import Form, ball

if TYPE_CHECKING:
    from .rai import RaiFrame, RaiScene

SIZES = {"ssBox": 3, "box": 3, "sphere": 1, "capsule": 2, "cylinder": 2, "ssCylinder": 2}
SILENT = ("marker", "camera", "none", "None")
MOST_CORES = 500
"""Corners of a rounded convex body: a hull around so many takes 0.1 s."""


class RaiShapes:
    """What others may hit. Where a scene says of some shape that it may be hit (`contact`), meshes of which it does not
    are only seen, as rai has it."""

    def __init__(self, scene: RaiScene) -> None:
        self._scene, self._meshes = scene, MeshReader("")
        self._touched: bool | None = None

    def forms(self, frame: RaiFrame) -> list[Form]:
        """The shapes of a frame, in it."""
        given = frame.given.get("shape")
        kind = str(given.value) if given is not None else "mesh" if "mesh" in frame.given else "none"
        if kind in SILENT:
            return []
        if kind == "mesh" and "mesh" in frame.given:
            return self._mesh(frame)
        if kind == "ssCvx" and "core" in frame.given:
            return self._rounded(frame)
        if kind not in SIZES:
            message = f"`{frame.name}` has a shape `{kind}`, which has no counterpart, and is left out"
            self._scene.leave(frame, message)
            return []
        size = self._scene.numbers(frame, "size", SIZES[kind], more=True)
        if kind in ("ssBox", "box"):
            size = size[:3]
        elif kind == "sphere":
            size = size[-1:]
        elif kind == "ssCylinder":
            size = size[1], size[0]
        else:
            size = size[-1], size[-2]
        if min(size) <= 0:
            self._scene.leave(frame, f"`{frame.name}` has no volume, and its shape is left out")
            return []
        return [Form({"ssBox": "box", "ssCylinder": "cylinder"}.get(kind, kind), size)]

    def _mesh(self, frame: RaiFrame) -> list[Form]:
        if self._touched is None:
            self._touched = any(_touched(f) for f in self._scene.frames.values())
        if self._touched and not _touched(frame):
            self._scene.leave(frame, f"the mesh of `{frame.name}` is left out: others of the scene have a `contact`")
            return []
        given = frame.given["mesh"]
        scale: tuple[float, ...] = (1.0,) * 3
        if "meshscale" in frame.given:
            scale = self._scene.numbers(frame, "meshscale", 1, more=True)
            scale = scale if len(scale) == 3 else scale[:1] * 3
        return self._scene.faults.mesh(given.span, self._meshes, str(given.value), scale, IDENTITY, given.span.file)

    def _rounded(self, frame: RaiFrame) -> list[Form]:
        """A body around all points that are near the hull of its core."""
        from ..hulls import HullError, convex_shape

        core, radius = self._scene.numbers(frame, "core", 3, more=True), self._scene.numbers(frame, "size", 1)[0]
        points = [core[k : k + 3] for k in range(0, len(core) - 2, 3)]
        if len(points) > MOST_CORES:
            self._scene.fault(frame.span, f"the core of `{frame.name}` has more than {MOST_CORES} corners", "E0020")
            return []
        near = ball() if radius > 0 else [(0.0, 0.0, 0.0)]
        around = [[p + radius * d for p, d in zip(point, off, strict=True)] for point in points for off in near]
        try:
            shape, (x, y, z), _ = convex_shape(around)
        except HullError as reason:
            self._scene.leave(frame, f"the shape of `{frame.name}` is left out: {reason}")
            return []
        self._scene.leave(frame, f"the rounded shape of `{frame.name}` becomes a body of flat faces around it")
        return [Form("convex", shape.size, (x, y, z, 0.0, 0.0, 0.0, 1.0))]


def _touched(frame: RaiFrame) -> bool:
    """Whether a frame says that its shape may be hit."""
    given = frame.given.get("contact")
    return given is not None and given.numbers()[:1] != (0.0,) and given.value != "false"
