"""A robot as it is assembled in one phase, as URDF: its modules with their docks as fixed joints, with inertias.

A URDF is a tree: of docks that close a loop those are left out that are met last. The tree begins at the frame of one
module; joints that are passed from their far end turn the other way about the same axis. Masses are those that are
stated, else those of the shapes at the density of water. Capsules are a cylinder and two spheres, which every reader
knows.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from xml.etree import ElementTree as Xml

from ...compiler.ir import ShapeKind
from ...langs.diagnostics import UsageError
from ..plan import ModuleRecord, Plan, ShapeRecord
from .docks import docks
from .motion import Pose, module_of, pose_of
from .solids import Solid, solid, stl, together
from .weights import seen_from, weights_of

HERE: Pose = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
Node = tuple[str, int]
"""A frame: the module, and the joint that moves it, or -1 for the module frame."""


def robot(plan: Plan, path: Path, module: str | None, phase: int) -> dict[Path, bytes]:
    """The URDF, and the meshes of convex shapes beside it, of the robot that `module` is part of. Raises UsageError."""
    if not 0 <= phase <= len(plan.phases):
        raise UsageError(f"the plan has phases 0 to {len(plan.phases)}, the last for what is there at the end")
    if not plan.modules:
        raise UsageError("the plan has no module")
    first = module_of(plan, module) if module is not None else plan.modules[0]
    return _UrdfWriter(plan, path, phase).files(first)


class _UrdfWriter:
    def __init__(self, plan: Plan, path: Path, phase: int) -> None:
        self.modules = {m.name: m for m in plan.modules}
        self.docks = [d for d in docks(plan) if phase in d.phases]
        self.path = path
        self.weights = weights_of(plan)
        self.root = Xml.Element("robot", name=plan.task.name)
        self.joints: list[Xml.Element] = []
        self.links: dict[Node, Xml.Element] = {}
        self.meshes: dict[Path, bytes] = {}

    def files(self, first: ModuleRecord) -> dict[Path, bytes]:
        waiting: list[tuple[Node, Pose]] = [((first.name, -1), HERE)]
        self._link((first.name, -1), HERE)
        while waiting:
            node, offset = waiting.pop()
            waiting += self._along_joints(node, offset)
            waiting += self._along_docks(node, offset)
        self.root.extend(self.joints)
        Xml.indent(self.root)
        return {**self.meshes, self.path: Xml.tostring(self.root, encoding="utf-8")}

    def _along_joints(self, node: Node, offset: Pose) -> list[tuple[Node, Pose]]:
        """The frames that a joint joins to `node`, whose frame is at `offset` in its link."""
        from ...compiler.poses import compose, inverse

        name, own = node
        found = []
        for index, joint in enumerate(self.modules[name].joints):
            place = pose_of(joint.placement)
            if joint.parent == own and (name, index) not in self.links:
                found.append(((name, index), HERE, compose(offset, place), 1.0))
            elif index == own and (name, joint.parent) not in self.links:
                found.append(((name, joint.parent), inverse(place), offset, -1.0))
            else:
                continue
            child, inside, origin, sign = found[-1]
            self._link(child, inside)
            element = self._joint(f"{name}.{joint.name}", node, child, origin)
            element.set("type", joint.kind)
            Xml.SubElement(element, "axis", xyz=_numbers([sign * a for a in joint.axis]))
            torque = self.weights.torques.get((name, joint.name))
            effort = "1000" if torque is None else repr(torque)
            limits = {"lower": repr(joint.lower), "upper": repr(joint.upper)}
            Xml.SubElement(element, "limit", {**limits, "velocity": repr(joint.speed), "effort": effort})
            if joint.follows is not None:
                leader = self.modules[name].joints[joint.follows.leader].name
                told = {"multiplier": repr(joint.follows.factor), "offset": repr(joint.follows.offset)}
                Xml.SubElement(element, "mimic", {"joint": f"{name}.{leader}", **told})
        return [(child, inside) for child, inside, _, _ in found]

    def _along_docks(self, node: Node, offset: Pose) -> list[tuple[Node, Pose]]:
        from ...compiler.poses import compose, inverse

        found = []
        for dock in self.docks:
            for one, other, relative in (
                (dock.one, dock.other, dock.relative),
                (dock.other, dock.one, inverse(dock.relative)),
            ):
                here, there = self._end(one), self._end(other)
                if here[0] != node or there[0] in self.links:
                    continue
                self._link(there[0], HERE)
                at = compose(compose(compose(offset, here[1]), relative), inverse(there[1]))
                self._joint(f"{one}-{other}", node, there[0], at).set("type", "fixed")
                found.append((there[0], HERE))
        return found

    def _end(self, name: str) -> tuple[Node, Pose]:
        module, _, end = name.rpartition(".")
        effector = next(e for e in self.modules[module].effectors if e.name == end)
        return (module, effector.joint), pose_of(effector.placement)

    def _joint(self, name: str, parent: Node, child: Node, origin: Pose) -> Xml.Element:
        element = Xml.Element("joint", name=name)
        self.joints.append(element)
        Xml.SubElement(element, "parent", link=_called(self.modules, parent))
        Xml.SubElement(element, "child", link=_called(self.modules, child))
        Xml.SubElement(element, "origin", _origin(origin))
        return element

    def _link(self, node: Node, offset: Pose) -> None:
        """The link of a frame that is at `offset` in it, and a link for each of its effectors."""
        from ...compiler.poses import compose

        name, own = node
        module = self.modules[name]
        link = self.links[node] = Xml.SubElement(self.root, "link", name=_called(self.modules, node))
        placed = [(pose_of(k.placement), k.shape) for k in module.links if k.joint == own]
        ends = [e for e in module.effectors if e.joint == own]
        placed += [
            (compose(pose_of(e.placement), pose_of([*part.at, *HERE[3:]])), part.shape)
            for e in ends if e.shape is not None for part in e.shape.solids
        ]  # fmt: skip
        solids = [self._shape(link, compose(offset, place), shape) for place, shape in placed]
        told = self.weights.solids.get(node)
        if told is not None and told.mass > 0.0:
            _inertial(link, seen_from(told, offset))
        elif solids and name not in self.weights.modules:
            _inertial(link, together(solids))
        for effector in ends:
            end = f"{name}.{effector.name}"
            Xml.SubElement(self.root, "link", name=end)
            joint = Xml.Element("joint", name=f"{end}/frame", type="fixed")
            Xml.SubElement(joint, "parent", link=_called(self.modules, node))
            Xml.SubElement(joint, "child", link=end)
            Xml.SubElement(joint, "origin", _origin(compose(offset, pose_of(effector.placement))))
            self.joints.append(joint)

    def _shape(self, link: Xml.Element, place: Pose, shape: ShapeRecord) -> Solid:
        from ...compiler.poses import compose

        parts: list[tuple[Pose, str, dict[str, str]]] = []
        if shape.kind == ShapeKind.CONVEX:
            file = self.path.with_name(f"{self.path.stem}-{len(self.meshes) + 1}.stl")
            self.meshes[file] = stl(shape)
            parts.append((place, "mesh", {"filename": file.name}))
        elif shape.kind == ShapeKind.BOX:
            parts.append((place, "box", {"size": _numbers(shape.size)}))
        elif shape.kind == ShapeKind.SPHERE:
            parts.append((place, "sphere", {"radius": repr(shape.size[0])}))
        else:
            radius, length = shape.size
            parts.append((place, "cylinder", {"radius": repr(radius), "length": repr(length)}))
            if shape.kind == ShapeKind.CAPSULE:
                ends = [compose(place, (0.0, 0.0, z, *HERE[3:])) for z in (-length / 2, length / 2)]
                parts += [(end, "sphere", {"radius": repr(radius)}) for end in ends]
        for at, tag, attributes in parts:
            for use in ("visual", "collision"):
                element = Xml.SubElement(link, use)
                Xml.SubElement(element, "origin", _origin(at))
                Xml.SubElement(Xml.SubElement(element, "geometry"), tag, attributes)
        return solid(shape, place)


def _called(modules: dict[str, ModuleRecord], node: Node) -> str:
    return node[0] if node[1] < 0 else f"{node[0]}/{modules[node[0]].joints[node[1]].name}"


def _inertial(link: Xml.Element, whole: Solid) -> None:
    element = Xml.SubElement(link, "inertial")
    Xml.SubElement(element, "origin", xyz=_numbers(whole.centre.tolist()), rpy="0 0 0")
    Xml.SubElement(element, "mass", value=repr(whole.mass))
    i = whole.inertia.tolist()
    names = {"ixx": i[0][0], "ixy": i[0][1], "ixz": i[0][2], "iyy": i[1][1], "iyz": i[1][2], "izz": i[2][2]}
    Xml.SubElement(element, "inertia", {name: repr(value) for name, value in names.items()})


def _origin(pose: Pose) -> dict[str, str]:
    return {"xyz": _numbers(pose[:3]), "rpy": _numbers(_roll_pitch_yaw(pose))}


def _roll_pitch_yaw(pose: Pose) -> tuple[float, float, float]:
    """Turns about the fixed x-, y- and z-axes, in this order; where the second is a quarter turn, the third is 0."""
    from scipy.spatial.transform import Rotation

    r = Rotation.from_quat(pose[3:]).as_matrix()
    level = math.hypot(r[0, 0], r[1, 0])
    if level < 1e-9:
        return math.atan2(-r[1, 2], r[1, 1]), math.atan2(-r[2, 0], level), 0.0
    return math.atan2(r[2, 1], r[2, 2]), math.atan2(-r[2, 0], level), math.atan2(r[1, 0], r[0, 0])


def _numbers(values: Sequence[float]) -> str:
    return " ".join(repr(float(v)) for v in values)
