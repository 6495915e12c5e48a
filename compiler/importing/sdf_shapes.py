"""Shapes and poses of SDF."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

from ..ir import IDENTITY, Pose
from ..poses import compose, make, roll_pitch_yaw
from .mesh_forms import MeshReader
from .models import FAR, STRAIGHT, Form, ball
from .xml_trees import Element, XmlFaults

ROUND = ("radius", "length")
SIZES = {"box": ("size",), "sphere": ("radius",), "cylinder": ROUND, "capsule": ROUND, "ellipsoid": ("radii",)}
THREE = ("size", "radii", "scale")


class SdfShapes:
    """What others may hit, of one file."""

    def __init__(self, faults: XmlFaults) -> None:
        self.faults, self.meshes = faults, MeshReader(faults.source.path)

    def forms(self, link: Element, frame: Callable[[str], Pose | None]) -> list[Form]:
        """The collision shapes of a link in its frame. `frame` gives that of a name there, None where there is none."""
        return [
            Form(found.kind, found.size, compose(place, found.place))
            for collision in link.findall("collision")
            for place in self._places(collision.find("pose"), frame)
            for geometry in collision.findall("geometry")[:1]
            for shape in geometry
            for found in self._form(shape)
        ]

    def _places(self, pose: Element | None, frame: Callable[[str], Pose | None]) -> Iterator[Pose]:
        own = pose_of(self.faults, pose)
        name = "" if pose is None else pose.get("relative_to", "")
        base = frame(name) if name else IDENTITY
        if base is None and pose is not None:
            self.faults.fault(pose, f"a pose is relative to `{name}`, which is not there")
        elif base is not None and own is not None:
            yield compose(base, own)

    def _form(self, shape: Element) -> list[Form]:
        if shape.tag == "plane":
            self.faults.leave(shape, f"a plane becomes a plate of {2 * FAR:g} m")
            return [Form("box", (2 * FAR, 2 * FAR, 0.1), make((0.0, 0.0, -0.05), STRAIGHT))]
        if shape.tag == "mesh":
            return self._mesh(shape)
        if shape.tag not in SIZES:
            if shape.tag != "empty":
                self.faults.leave(shape, f"a shape `{shape.tag}` has no counterpart, and is left out")
            return []
        found: list[float] = []
        for key in SIZES[shape.tag]:
            values = self._numbers(shape, key, shape.findtext(key))
            if values is None:
                return []
            found += values
        if min(found) <= 0:
            self.faults.leave(shape, f"a {shape.tag} without volume is left out")
            return []
        if shape.tag == "ellipsoid":
            self.faults.leave(shape, "an ellipsoid becomes a body around it, of up to 1.3 times its volume")
            x, y, z = found
            return [Form("convex", tuple(v for a, b, c in ball() for v in (a * x, b * y, c * z)))]
        return [Form(shape.tag, tuple(found))]

    def _numbers(self, shape: Element, key: str, text: str | None) -> tuple[float, ...] | None:
        return self.faults.numbers(shape, text, 3 if key in THREE else 1, f"`{key}`")

    def _mesh(self, shape: Element) -> list[Form]:
        scale = self._numbers(shape, "scale", shape.findtext("scale") or "1 1 1")
        part = (shape.findtext("submesh/name") or "").strip()
        if part:
            self.faults.leave(shape, f"the mesh is taken as a whole: its part `{part}` has no counterpart")
        if scale is None:
            return []
        name = (shape.findtext("uri") or "").strip()
        return self.faults.mesh(self.faults.span(shape), self.meshes, name, scale, IDENTITY)


def pose_of(faults: XmlFaults, element: Element | None) -> Pose | None:
    """A pose in metres, and roll, pitch and yaw or a quaternion; None after a fault."""
    if element is None or not (element.text or "").strip():
        return IDENTITY
    quaternion = element.get("rotation_format") == "quat_xyzw"
    values = faults.numbers(element, element.text, 7 if quaternion else 6, "a pose")
    if values is None:
        return None
    if quaternion:
        norm = math.hypot(*values[3:])
        if norm == 0:
            faults.fault(element, "the quaternion of a pose is 0")
            return None
        x, y, z, w = (v / norm for v in values[3:])
        return make((values[0], values[1], values[2]), (x, y, z, w))
    scale = math.pi / 180 if element.get("degrees") in ("true", "1") else 1.0
    return make((values[0], values[1], values[2]), roll_pitch_yaw(*(scale * v for v in values[3:])))
