"""Meshes that models of others name, as forms: convex parts, a hull, or a body around it, as URDFs have them."""

from __future__ import annotations

from collections.abc import Sequence

from ..foreign import Files
from ..ir import Pose, Vec3
from ..named_meshes import NamedMesh, named_mesh
from ..poses import compose, make
from .models import STRAIGHT, Form


class MeshReader:
    """Reads the meshes that one file names, each once."""

    def __init__(self, path: str) -> None:
        self._path, self._files = path, Files()
        self._known: dict[tuple[str, tuple[float, ...]], NamedMesh] = {}

    def forms(self, name: str, scale: Sequence[float], place: Pose, path: str | None = None) -> tuple[list[Form], str]:
        """The forms of a mesh at `place`, `scale` times as large, and what is to be told of them. `path` is the file
        that names it where that is another one. Raises UnreadMesh."""
        key = (f"{path}\n{name}", tuple(scale))
        if key not in self._known:
            self._known[key] = named_mesh(path or self._path, name, scale, self._files)
        mesh = self._known[key]
        pieces = mesh.body.parts or ((mesh.body.size, mesh.body.middle),)
        return [_form(size, middle, place) for size, middle in pieces], mesh.told


def _form(size: tuple[float, ...], middle: Vec3, place: Pose) -> Form:
    return Form("convex", size, compose(place, make(middle, STRAIGHT)))
