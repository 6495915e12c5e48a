"""A canvas that records the commands by which meshcat's viewer draws, without a server."""

from __future__ import annotations

import base64
from typing import Any

from ..geometry.transforms import Array
from .forms import DrawnForm, matrix

LIGHTS = ("PointLightNegativeX", "PointLightPositiveX", "SpotLight")
HIDDEN = ("/Grid", "/Axes", *(f"/Lights/{light}" for light in LIGHTS))


class Recorder:
    """Stands in for meshcat's window: keeps the packed commands instead of sending them to a server."""

    def __init__(self) -> None:
        self.commands: list[str] = []

    def send(self, command: Any) -> None:
        import umsgpack

        self.commands.append(base64.b64encode(umsgpack.packb(command.lower())).decode("ascii"))


class MeshcatCanvas:
    """What is drawn on it, as packed commands."""

    def __init__(self) -> None:
        import meshcat

        self._recorder = Recorder()
        self._viewer: Any = meshcat.Visualizer(window=self._recorder)
        for path in HIDDEN:
            self._viewer[path].set_property("visible", False)

    @property
    def commands(self) -> list[str]:
        return self._recorder.commands

    def draw(self, path: str, form: DrawnForm, colour: str) -> None:
        """Draw a form in its own frame at a path."""
        from meshcat.geometry import Mesh, MeshPhongMaterial

        made = _geometry(form)
        made.uuid = f"{path}/form"
        paint = MeshPhongMaterial(color=int(colour[1:], 16), shininess=18, side=0)
        paint.uuid = f"{path}/paint"
        mesh = Mesh(made, paint)
        mesh.uuid = path
        self._viewer[path].set_object(mesh)

    def place(self, path: str, pose: Array) -> None:
        """Put what is at a path at a pose `(7,)` in the frame of the path above."""
        self._viewer[path].set_transform(matrix(pose))


def _geometry(form: DrawnForm) -> Any:
    from meshcat import geometry

    if form.kind == "box":
        return geometry.Box(list(form.size))
    if form.kind == "ball":
        return geometry.Sphere(form.size[0])
    if form.kind == "tube":
        return geometry.Cylinder(*form.size)
    return geometry.TriangularMeshGeometry(form.corners, form.triangles)
