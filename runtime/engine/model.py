"""The scene of a plan as a MuJoCo model: every module a free tree, every pair that is ever kept a weld, off at first.

Settings were found by trial on plans whose loads are known: other integrators diverge with docked arms or prismatic
joints, and welds are soft in rotation unless their torque rows are scaled.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import ModuleType as PythonModule
from typing import Any

import numpy as np

from ...compiler import ir
from ...compiler.physics.frames import Weight, module_weights
from ...compiler.physics.masses import body_mass
from ...compiler.physics.moments import shape_moments
from ...compiler.physics.structure import WORLD, Node
from ..native import load_native

STEP = 1e-3
"""Seconds of a step."""
STIFFNESS, SLIDE_STIFFNESS = 4000.0, 2e5
"""Of drives, N m/rad and N/m; damping is critical for the inertia that follows."""
INERTIA, SLIDE_INERTIA = 0.3, 20.0
ROTOR = 0.02
"""kg m² of a drive that states none."""
WELD_TIME, WELD_FIRM = 0.004, (0.99, 0.999, 0.001, 0.5, 2.0)
TORQUE_SCALE = 10.0
"""Of the rotation rows of welds, which are too soft as they come."""
LIGHTEST = 0.02
"""Kilograms that a moving frame without any weight gets: the engine has none without."""


def load_mujoco() -> PythonModule:
    """MuJoCo. Raises MissingLibrary."""
    return load_native("mujoco", "'tamplang[sim]'")


@dataclass(slots=True)
class EngineWorld:
    """The engine's model and state, and how it calls things. `bodies` maps a node to its body, `joints` a joint to the
    place of its value, of its rate and of its drive, `welds` a pair of nodes to its constraint."""

    engine: PythonModule
    model: Any
    data: Any
    bodies: dict[Node, int]
    joints: dict[tuple[str, int], tuple[int, int, int]]
    welds: dict[tuple[Node, Node], int]


def build(problem: ir.Problem, pairs: Iterable[tuple[Node, Node]]) -> EngineWorld:
    """The scene at its start, with a weld for each of the pairs. Raises MissingLibrary."""
    mujoco = load_mujoco()
    spec = mujoco.MjSpec()
    spec.option.timestep = STEP
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_DISCRETE
    spec.option.enableflags |= int(mujoco.mjtEnableBit.mjENBL_DIAGEXACT)
    names: dict[Node, str] = {WORLD: "world"}
    for name, body in problem.world.bodies.items():
        if body.movable:
            made = _free(spec.worldbody, f"b.{name}", body.pose)
            mass = body_mass(body)
            _weigh(made, Weight(mass, np.zeros(3), shape_moments(body.shape, mass)))
            names[name, -1] = f"b.{name}"
    for name, module in problem.world.modules.items():
        names |= _module(mujoco, spec, name, module)
    listed = list(dict.fromkeys(pairs))
    for number, (below, above) in enumerate(listed):
        weld = spec.add_equality()
        weld.type, weld.objtype = mujoco.mjtEq.mjEQ_WELD, mujoco.mjtObj.mjOBJ_BODY
        weld.name, weld.name1, weld.name2 = f"w{number}", names[below], names[above]
        weld.active, weld.solref, weld.solimp = False, [WELD_TIME, 1.0], list(WELD_FIRM)
    model = spec.compile()
    data = mujoco.MjData(model)
    joints = {}
    for name, module in problem.world.modules.items():
        for index, value in enumerate(module.joints):
            joint = model.joint(f"{name}.{index}")
            place = int(joint.qposadr[0])
            joints[name, index] = place, int(joint.dofadr[0]), int(model.actuator(f"d.{name}.{index}").id)
            data.qpos[place] = value
    mujoco.mj_forward(model, data)
    bodies = {node: int(model.body(called).id) for node, called in names.items()}
    welds = {pair: int(model.equality(f"w{number}").id) for number, pair in enumerate(listed)}
    return EngineWorld(mujoco, model, data, bodies, joints, welds)


def _turn(pose: Iterable[float]) -> list[float]:
    """A quaternion as the engine has it, scalar part first."""
    _, _, _, x, y, z, w = pose
    return [w, x, y, z]


def _free(parent: Any, name: str, pose: ir.Pose) -> Any:
    made = parent.add_body(name=name, pos=list(pose[:3]), quat=_turn(pose))
    made.add_freejoint()
    return made


def _weigh(body: Any, weight: Weight | None) -> None:
    if weight is None or weight.mass < LIGHTEST:
        weight = Weight(LIGHTEST, np.zeros(3), np.eye(3) * LIGHTEST * 1e-2)
    tensor = weight.inertia + np.eye(3) * 1e-6
    body.mass, body.ipos, body.explicitinertial = weight.mass, list(weight.centre), True
    body.fullinertia = [tensor[0, 0], tensor[1, 1], tensor[2, 2], tensor[0, 1], tensor[0, 2], tensor[1, 2]]


def _module(mujoco: PythonModule, spec: Any, name: str, module: ir.Module) -> dict[Node, str]:
    weights: Mapping[int, Weight] = module_weights(module.type)
    root = _free(spec.worldbody, f"m.{name}", module.pose)
    _weigh(root, weights.get(-1))
    made, names = {-1: root}, {(name, -1): f"m.{name}"}
    for index, joint in enumerate(module.type.joints):
        body = made[joint.parent].add_body(
            name=f"m.{name}.{index}", pos=list(joint.placement[:3]), quat=_turn(joint.placement)
        )
        _weigh(body, weights.get(index))
        turning = joint.kind == ir.JointKind.REVOLUTE
        kinds = mujoco.mjtJoint
        moved = body.add_joint(
            name=f"{name}.{index}", axis=list(joint.axis), type=kinds.mjJNT_HINGE if turning else kinds.mjJNT_SLIDE
        )
        moved.armature = (joint.rotor or ROTOR) if turning else 0.0
        drive = spec.add_actuator(
            name=f"d.{name}.{index}", target=f"{name}.{index}", trntype=mujoco.mjtTrn.mjTRN_JOINT
        )
        stiffness, inertia = (STIFFNESS, INERTIA) if turning else (SLIDE_STIFFNESS, SLIDE_INERTIA)
        drive.set_to_position(kp=stiffness, kv=2.0 * math.sqrt(stiffness * inertia))
        if math.isfinite(joint.torque):
            drive.forcerange, drive.forcelimited = [-joint.torque, joint.torque], True
        made[index], names[name, index] = body, f"m.{name}.{index}"
    return names
