"""What parts weigh that state it, and how strong drives are, as a plan tells them or the texts in it do."""

from __future__ import annotations

import msgspec
import numpy as np

from ...langs.diagnostics import SourceError
from ...langs.frozen import dataclass
from ..plan import NO_LIMIT, Plan
from .motion import Pose
from .solids import Array, Solid

Node = tuple[str, int]
"""A module and the joint whose moving frame it is (-1: the module frame), or a body and -1."""


@dataclass(frozen=True, slots=True, eq=False)
class Weights:
    """What is fixed to each node that states a mass or is a body of several parts, in its own frame, and the greatest
    torque of joints that state one, by module and joint, N m (N). The nodes of a module of which any part states one
    are all here, by `modules`."""

    solids: dict[Node, Solid]
    torques: dict[tuple[str, str], float]
    modules: frozenset[str]


def weights_of(plan: Plan) -> Weights:
    """What a plan tells of weights; where it tells nothing of forces, what the texts in it state."""
    if isinstance(plan.statics, msgspec.UnsetType):
        return _stated(plan)
    solids = {}
    for told in plan.statics.weights:
        solids[told.name, told.joint] = Solid(told.mass, np.array(told.centre), symmetric(told.inertia))
    torques = {(d.module, d.joint): d.torque for d in plan.statics.drives if d.torque < NO_LIMIT}
    return Weights(solids, torques, frozenset(m.name for m in plan.modules))


def symmetric(upper: list[float]) -> Array:
    """The matrix whose upper triangle is xx, xy, xz, yy, yz, zz."""
    xx, xy, xz, yy, yz, zz = upper
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _stated(plan: Plan) -> Weights:
    from ...compiler.physics.frames import module_weights, node_weights
    from ...compiler.pipeline import UsageError, compile_sources
    from ...langs.source import Source
    from ..plan_parameters import parameter_texts

    sources = [Source(s.path, s.text) for s in plan.task.sources]
    files = {f.path: f.data for f in plan.task.files}
    try:
        texts = parameter_texts(plan, sources)
        problem, _ = compile_sources(sources, plan.task.name, texts, plan.task.seed, files)
    except (SourceError, UsageError):
        return Weights({}, {}, frozenset())
    solids: dict[Node, Solid] = {}
    torques: dict[tuple[str, str], float] = {}
    named = set()
    for name, module in problem.world.modules.items():
        kind = module.type
        torques |= {(name, j.name): j.torque for j in kind.joints if j.torque < NO_LIMIT}
        masses = [*(e.mass for e in kind.effectors), *(k.mass for k in kind.links)]
        if any(m is not None for m in masses) or any(j.mass for j in kind.joints) or kind.inertials:
            named.add(name)
            for joint, w in module_weights(kind).items():
                solids[name, joint] = Solid(w.mass, w.centre, w.inertia)
    bodies = [(name, -1) for name, b in problem.world.bodies.items() if b.mass is not None or b.shape.parts]
    for node, w in node_weights(problem, bodies).items():
        solids[node] = Solid(w.mass, w.centre, w.inertia)
    return Weights(solids, torques, frozenset(named))


def seen_from(solid: Solid, pose: Pose) -> Solid:
    """A solid in a frame in which its own is at `pose`."""
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_quat(pose[3:]).as_matrix()
    return Solid(solid.mass, turn @ solid.centre + pose[:3], turn @ solid.inertia @ turn.T)
