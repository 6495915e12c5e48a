"""Whether a scene plainly bears itself at the start: sums of weights in plain numbers, as what only checks a text does
without loading numerical libraries. What is not plain is left to `statics`."""

from __future__ import annotations

import math
from collections.abc import Mapping

from .. import ir
from ..poses import compose, joint_frames, orientation, position, rotate
from .masses import GRAVITY, body_mass, module_masses
from .outlines import foot_radius
from .records import CONTACTS, Vec3
from .safety import safety_of
from .structure import WORLD, Edge, Node, driven, structure


def plainly_borne(problem: ir.Problem) -> bool:
    """Whether every load at the start, times the safety, is surely within what is stated, however its moment is
    turned. False where it may not be, and where loops leave loads open."""
    found = structure(problem, problem.init_motion)
    if found.loops:
        return False
    world = problem.world
    frames = {name: joint_frames(m.type, m.pose, m.joints) for name, m in world.modules.items()}
    masses: dict[Node, float] = {}
    moments: dict[Node, Vec3] = {}

    def add(node: Node, mass: float, moment: Vec3) -> None:
        x, y, z = moments.get(node, (0.0, 0.0, 0.0))
        masses[node] = masses.get(node, 0.0) + mass
        moments[node] = x + moment[0], y + moment[1], z + moment[2]

    for node in (e.child for e in found.edges):
        for mass, at in _weights(problem, node, frames):
            add(node, mass, (mass * at[0], mass * at[1], mass * at[2]))
    for edge in reversed(found.edges):
        mass, moment = masses.get(edge.child, 0.0), moments.get(edge.child, (0.0, 0.0, 0.0))
        if not _borne(problem, edge, mass, moment, frames):
            return False
        add(edge.parent, mass, moment)
    return True


Frames = Mapping[str, Mapping[int, ir.Pose]]


def _weights(problem: ir.Problem, node: Node, frames: Frames) -> list[tuple[float, Vec3]]:
    """The weights of a node, and where their centres are."""
    name, joint = node
    module = problem.world.modules.get(name)
    if module is None:
        body = problem.world.bodies[name]
        return [(body_mass(body), position(body.pose))]
    own = [(placement, mass) for carrier, placement, mass in module_masses(module.type) if carrier == joint]
    return [(mass, position(compose(frames[name][joint], placement))) for placement, mass in own]


def _borne(problem: ir.Problem, edge: Edge, mass: float, moment: Vec3, frames: Frames) -> bool:
    safety, weight = safety_of(problem.options), GRAVITY * mass

    def turning(at: Vec3) -> Vec3:
        """The moment about a place: that of what hangs beyond it, which points down."""
        return -GRAVITY * (moment[1] - mass * at[1]), GRAVITY * (moment[0] - mass * at[0]), 0.0

    if edge.is_joint:
        name, index = edge.names[0], edge.joint
        joint, frame = problem.world.modules[name].type.joints[index], frames[name][index]
        axis, bent = rotate(orientation(frame), joint.axis), turning(position(frame))
        length = math.hypot(*joint.axis)
        slides = joint.kind != ir.JointKind.REVOLUTE
        along = abs(weight * axis[2] if slides else axis[0] * bent[0] + axis[1] * bent[1]) / length
        return safety * along <= joint.strength(still=True) and safety * math.hypot(*bent) <= joint.bearing
    hold = edge.hold
    if hold is None:
        return True
    if edge.manner not in CONTACTS:
        shear = min(hold.shear, hold.friction * hold.force) if edge.manner == "grip" else hold.shear
        bent = turning(_joined(problem, edge.place, frames))
        return safety * weight <= min(hold.force, shear) and safety * math.hypot(*bent) <= min(hold.moment, hold.twist)
    if edge.turned or edge.parent != WORLD:
        return False
    bent = turning(_standing(problem, edge.place, frames))
    sticks = hold.force if edge.manner == "pad" else 0.0
    if math.isfinite(hold.moment) or not math.isfinite(sticks):
        return safety * math.hypot(*bent) <= hold.moment
    return safety * math.hypot(*bent) <= foot_radius(problem, edge.place) * (sticks + weight)


def _joined(problem: ir.Problem, name: str, frames: Frames) -> Vec3:
    """Where two things hold each other: before a round end."""
    found = problem.world.effector(name)
    if found is None:
        return position(problem.world.bodies[name].pose)
    module, end = found
    pose = compose(frames[module.name][end.joint], end.placement)
    far = end.shape.size[0] if end.shape is not None and end.shape.kind == ir.ShapeKind.SPHERE else 0.0
    x, y, z = rotate(orientation(pose), (0.0, 0.0, far))
    return pose[0] + x, pose[1] + y, pose[2] + z


def _standing(problem: ir.Problem, name: str, frames: Frames) -> Vec3:
    """Where what stands on something does, as far as its moment is concerned."""
    found = problem.world.effector(name)
    if found is None:
        return position(problem.world.bodies[name].pose)
    module, end = found
    under = driven(module.type, end.joint)
    own = frames[module.name]
    return position(own[under] if under != end.joint else compose(own[end.joint], end.placement))
