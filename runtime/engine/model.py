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
from ...compiler.poses import compose
from ..native import load_native
from ..seeds import Seed
from ..skeleton import Array

STEP = 1e-3
"""Seconds of a step."""
STIFFNESS, SLIDE_STIFFNESS = 4000.0, 2e5
"""Of drives, N m/rad and N/m; damping is critical for the inertia that follows."""
INERTIA, SLIDE_INERTIA = 0.3, 20.0
CLAMPED = 0.25
"""Drives give at the end of a step what they are told, and are clamped at what that would be at its start, off by what
stiffness makes of the way of the step: at greatest speed by no more than this share of their strength. With 4000 N m
per rad drives of 4 N m were clamped at 0.7 rad/s and shook; with a quarter those of 38 N m keep that."""
ROTOR = 0.02
"""kg m² of a drive that states none."""
WELD_TIME, WELD_FIRM = 0.004, (0.99, 0.999, 0.001, 0.5, 2.0)
LEAST_SHARE = 0.1
"""Of what is stated, however great the noise."""
FIRM_FRICTION = 10.0
"""How much firmer friction is than what presses: feet of a crawler that carries another crept by 5 mm with 1."""
SUPPORT = 1
"""The bit of what bears something that stands."""
TORQUE_SCALE = 10.0
"""Of the rotation rows of welds, which are too soft as they come."""
UNLIMITED = 1e9
"""N m or N that stands for a drive without a limit."""
LIGHTEST = 0.02
"""Kilograms that a moving frame without any weight gets: the engine has none without."""


def load_mujoco() -> PythonModule:
    """MuJoCo. Its warnings, which it would print and write to a file here, are found in its data. Raises
    MissingLibrary."""
    mujoco = load_native("mujoco", "'tamplang[sim]'")
    mujoco.set_mju_user_warning(lambda _: None)
    return mujoco


@dataclass(slots=True)
class EngineWorld:
    """The engine's model and state, and how it calls things. `bodies` maps a node to its body, `joints` a joint to the
    place of its value, of its rate and of its drive, `welds` a pair of nodes to its constraint, `pads` a node to what
    it stands on. `rubbing` is by how many times friction is greater than stated."""

    engine: PythonModule
    model: Any
    data: Any
    bodies: dict[Node, int]
    joints: dict[tuple[str, int], tuple[int, int, int]]
    welds: dict[tuple[Node, Node], int]
    pads: dict[Node, int]
    rubbing: float = 1.0


def build(
    problem: ir.Problem, pairs: Iterable[tuple[Node, Node]], noise: float = 0.0, seed: Seed | None = None
) -> EngineWorld:  # fmt: skip
    """The scene at its start, with a weld for each of the pairs. Weights, drives and friction differ from what is
    stated by random factors of the deviation `noise`. Raises MissingLibrary."""
    mujoco = load_mujoco()
    spec = mujoco.MjSpec()
    spec.option.timestep, spec.option.impratio = STEP, FIRM_FRICTION
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_DISCRETE
    spec.option.enableflags |= int(mujoco.mjtEnableBit.mjENBL_DIAGEXACT)
    # Boxes around the geoms of a body are made once, and pads are laid later.
    spec.option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_MIDPHASE)
    names: dict[Node, str] = {WORLD: "world"}
    for name, body in problem.world.bodies.items():
        if body.movable:
            made = _free(spec.worldbody, f"b.{name}", body.pose)
            mass = body_mass(body)
            _weigh(made, Weight(mass, np.zeros(3), shape_moments(body.shape, mass)))
            names[name, -1] = f"b.{name}"
            for number, part in enumerate(body.shape.solids):
                _shown(mujoco, made, part.shape, part.placement, SUPPORT, "" if number else f"p.{name}.-1")
        else:
            for part in body.shape.solids:
                _shown(mujoco, spec.worldbody, part.shape, compose(body.pose, part.placement), SUPPORT)
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
    pads = {n: int(model.geom(f"p.{n[0]}.{n[1]}").id) for n in names if n != WORLD}
    welds = {pair: int(model.equality(f"w{number}").id) for number, pair in enumerate(listed)}
    world = EngineWorld(mujoco, model, data, bodies, joints, welds, pads)
    if noise > 0.0 and seed is not None:
        _disturbed(world, noise, seed.child("engine").random())
    return world


def _disturbed(world: EngineWorld, noise: float, random: np.random.Generator) -> None:
    """Weights, drives and friction that are not as stated."""

    def factors(count: int) -> Array:
        return np.asarray(np.clip(1.0 + noise * random.standard_normal(count), LEAST_SHARE, None))

    model = world.model
    weights = factors(model.nbody)
    model.body_mass *= weights
    model.body_inertia *= weights[:, None]
    gains = factors(model.nu)
    model.actuator_gainprm[:, 0] *= gains
    model.actuator_biasprm[:, 1:3] *= gains[:, None]
    world.rubbing = float(factors(1)[0])
    kept = world.data.qpos.copy()
    world.engine.mj_setConst(model, world.data)
    world.data.qpos[:] = kept
    world.engine.mj_forward(model, world.data)


def _shown(mujoco: PythonModule, body: Any, shape: ir.Shape, pose: ir.Pose, bears: int = 0, name: str = "") -> None:
    """A shape as one sees it; what `bears` carries what stands on it. A convex one is the box around it."""
    kinds, size = mujoco.mjtGeom, [s for s in shape.size]
    match shape.kind:
        case ir.ShapeKind.SPHERE:
            kind, size = kinds.mjGEOM_SPHERE, [size[0], 0.0, 0.0]
        case ir.ShapeKind.CAPSULE:
            kind, size = kinds.mjGEOM_CAPSULE, [size[0], size[1] / 2.0, 0.0]
        case ir.ShapeKind.CYLINDER:
            kind, size = kinds.mjGEOM_CYLINDER, [size[0], size[1] / 2.0, 0.0]
        case ir.ShapeKind.BOX:
            kind, size = kinds.mjGEOM_BOX, [s / 2.0 for s in size]
        case _:
            kind, size = kinds.mjGEOM_BOX, list(np.ptp(np.reshape(size, (-1, 3)), axis=0) / 2.0)
    geom = body.add_geom(name=name, type=kind, size=size, pos=list(pose[:3]), quat=_turn(pose))
    geom.contype, geom.conaffinity, geom.mass = bears, 2 * bears, 0.0
    geom.condim, geom.priority, geom.solref = 4, 1, [WELD_TIME, 1.0]


def _pad(mujoco: PythonModule, body: Any, node: Node) -> None:
    """What an end stands on, once it does: thin, and laid where it meets what bears it."""
    pad = body.add_geom(name=f"p.{node[0]}.{node[1]}", type=mujoco.mjtGeom.mjGEOM_CYLINDER, size=[1e-3, 1e-3, 0.0])
    pad.contype, pad.conaffinity, pad.mass = 0, 0, 0.0
    pad.condim, pad.priority, pad.solref = 4, 2, [WELD_TIME, 1.0]


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
    _pad(mujoco, root, (name, -1))
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
        most = min(joint.torque, UNLIMITED)
        stiffness = min(stiffness, CLAMPED * most / (STEP * joint.speed)) or stiffness
        drive.set_to_position(kp=stiffness, kv=2.0 * math.sqrt(stiffness * inertia))
        drive.forcerange, drive.forcelimited = [-most, most], True
        made[index], names[name, index] = body, f"m.{name}.{index}"
        _pad(mujoco, body, (name, index))
    parts = [(k.joint, k.shape, k.placement) for k in module.type.links]
    parts += [
        (e.joint, part.shape, compose(e.placement, part.placement))
        for e in module.type.effectors if e.shape is not None for part in e.shape.solids
    ]  # fmt: skip
    for carrier, shape, placement in parts:
        _shown(mujoco, made[carrier], shape, placement)
    return names
