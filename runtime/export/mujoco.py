"""The whole scene as MJCF of MuJoCo: bodies, modules, docks as equality constraints, and the motion as key frames.

Modules and movable bodies are free bodies. Masses are those that are stated, else those of the shapes at the density of
water, which is MuJoCo's own default.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from xml.etree import ElementTree as Xml

import numpy as np

from ...compiler.ir import IDENTITY, JointKind, ShapeKind
from ...compiler.poses import compose
from ..plan import ModuleRecord, Plan, ShapeRecord
from .docks import docks
from .motion import Array, moved, pose_of, poses, times, trajectory
from .solids import Solid
from .weights import Weights, weights_of

HALVES = {ShapeKind.BOX: (0.5, 0.5, 0.5), ShapeKind.SPHERE: (1.0,), ShapeKind.CAPSULE: (1.0, 0.5),
          ShapeKind.CYLINDER: (1.0, 0.5)}  # fmt: skip
"""MuJoCo's sizes of a geom are these shares of ours."""
TINY = {"pos": "0 0 0", "mass": "1e-3", "diaginertia": "1e-6 1e-6 1e-6"}
"""Of a moving frame without a shape, which MuJoCo does not take without a mass."""
LEAST = 1e-9
"""kg m²: MuJoCo takes no frame with less, as where all that weighs is the drive of a joint."""


def scene(plan: Plan) -> bytes:
    """The file. Key frame k is the k-th sample, `time` its time; docks that no phase has yet are not active."""
    root = Xml.Element("mujoco", model=plan.task.name)
    Xml.SubElement(root, "compiler", angle="radian", autolimits="true")
    assets, world = Xml.SubElement(root, "asset"), Xml.SubElement(root, "worldbody")
    free = [*(m.name for m in plan.modules), *(b.name for b in plan.bodies if b.movable or b.name in moved(plan))]
    weights = weights_of(plan)
    for module in plan.modules:
        _module(assets, world, module, weights)
    for body in plan.bodies:
        if body.name in free:
            frame = Xml.SubElement(world, "body", {"name": body.name, **_place(body.pose)})
            Xml.SubElement(frame, "freejoint", name=f"{body.name}/free")
            _geom(assets, frame, body.name, body.shape, None)
            _weighed(frame, weights.solids.get((body.name, -1)))
        else:
            _geom(assets, world, body.name, body.shape, body.pose)
    equality = Xml.SubElement(root, "equality")
    for module in plan.modules:
        _couplings(equality, module)
    for dock in docks(plan):
        x, y, z, qx, qy, qz, qw = dock.relative
        relative = _numbers((x, y, z, qw, qx, qy, qz))
        names = {"name": f"{dock.one}-{dock.other}", "body1": dock.one, "body2": dock.other}
        active = str(0 in dock.phases).lower()
        Xml.SubElement(equality, "weld", {**names, "relpose": relative, "active": active})
    keys = Xml.SubElement(root, "keyframe")
    t = times(plan)
    for time, values in zip(t, _positions(plan, free, t), strict=True):
        Xml.SubElement(keys, "key", time=repr(float(time)), qpos=_numbers(values))
    Xml.indent(root)
    text: bytes = Xml.tostring(root, encoding="utf-8")
    return text


def _module(assets: Xml.Element, world: Xml.Element, module: ModuleRecord, weights: Weights) -> None:
    frames = {-1: Xml.SubElement(world, "body", {"name": module.name, **_place(module.pose)})}
    Xml.SubElement(frames[-1], "freejoint", name=f"{module.name}/free")
    for index, joint in enumerate(module.joints):
        place = {"name": f"{module.name}/{joint.name}", **_place(joint.placement)}
        frame = Xml.SubElement(frames[joint.parent], "body", place)
        kind = "hinge" if joint.kind == JointKind.REVOLUTE else "slide"
        limits = _numbers((joint.lower, joint.upper))
        axis = _numbers(joint.axis)
        Xml.SubElement(frame, "joint", name=f"{module.name}.{joint.name}", type=kind, axis=axis, range=limits)
        frames[index] = frame
    for number, link in enumerate(module.links):
        _geom(assets, frames[link.joint], f"{module.name}/link{number}", link.shape, link.placement)
    for effector in module.effectors:
        name = f"{module.name}.{effector.name}"
        frame = Xml.SubElement(frames[effector.joint], "body", {"name": name, **_place(effector.placement)})
        if effector.shape is not None:
            _geom(assets, frame, name, effector.shape, None)
    for joint_index, frame in frames.items() if module.name in weights.modules else ():
        _weighed(frame, weights.solids.get((module.name, joint_index)))
        for geom in (g for child in (frame, *frame.findall("body")) for g in child.findall("geom")):
            geom.set("mass", "0")
    told = module.name in weights.modules
    for frame in frames.values():
        shaped = not told and any(child.tag == "geom" for child in frame)
        if frame.find("inertial") is None and not shaped:
            Xml.SubElement(frame, "inertial", TINY)


def _weighed(frame: Xml.Element, told: Solid | None) -> None:
    """State what a frame weighs, its shapes aside."""
    if told is None or told.mass <= 0.0:
        return
    least = float(np.linalg.eigvalsh(told.inertia)[0])
    i = told.inertia + max(LEAST - least, 0.0) * np.eye(3)
    whole = _numbers((i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2]))
    own = {"pos": _numbers(told.centre), "mass": repr(float(told.mass)), "fullinertia": whole}
    frame.insert(0, Xml.Element("inertial", own))


def _couplings(equality: Xml.Element, module: ModuleRecord) -> None:
    for joint in module.joints:
        if joint.follows is not None:
            leader = module.joints[joint.follows.leader].name
            names = {"joint1": f"{module.name}.{joint.name}", "joint2": f"{module.name}.{leader}"}
            powers = _numbers((joint.follows.offset, joint.follows.factor, 0, 0, 0))
            Xml.SubElement(equality, "joint", {**names, "polycoef": powers})


def _geom(
    assets: Xml.Element, frame: Xml.Element, name: str, shape: ShapeRecord, pose: Sequence[float] | None
) -> None:
    where = {} if pose is None else _place(pose)
    if shape.parts:
        for number, part in enumerate(shape.parts, start=1):
            at = compose(pose_of(IDENTITY if pose is None else pose), pose_of([*part.at, *IDENTITY[3:]]))
            _geom(assets, frame, f"{name}/part{number}", part.shape, at)
        return
    if shape.kind == ShapeKind.CONVEX:
        Xml.SubElement(assets, "mesh", name=name, vertex=_numbers(shape.size))
        Xml.SubElement(frame, "geom", {"name": name, "type": "mesh", "mesh": name, **where})
        return
    size = _numbers(s * h for s, h in zip(shape.size, HALVES[ShapeKind(shape.kind)], strict=True))
    Xml.SubElement(frame, "geom", {"name": name, "type": shape.kind, "size": size, **where})


def _positions(plan: Plan, free: Sequence[str], t: Array) -> Iterator[Array]:
    """The generalised positions at each time: in the order of the bodies in the file, each free pose with its scalar
    first, then the joints below it, depth first."""
    parts: list[Array] = []
    for name in free:
        parts.append(poses(plan, name, t)[:, [0, 1, 2, 6, 3, 4, 5]])
        module = next((m for m in plan.modules if m.name == name), None)
        if module is not None:
            parts.append(trajectory(plan, name, t).q[:, _depth_first(module, -1)])
    yield from np.hstack(parts) if parts else np.zeros((len(t), 0))


def _depth_first(module: ModuleRecord, parent: int) -> list[int]:
    found: list[int] = []
    for index, joint in enumerate(module.joints):
        if joint.parent == parent:
            found += [index, *_depth_first(module, index)]
    return found


def _place(pose: Sequence[float]) -> dict[str, str]:
    x, y, z, qx, qy, qz, qw = pose
    return {"pos": _numbers((x, y, z)), "quat": _numbers((qw, qx, qy, qz))}


def _numbers(values: Iterable[float]) -> str:
    return " ".join(repr(float(v)) for v in values)
