"""Whether what a plan tells of weights and strengths is what its texts say."""

from __future__ import annotations

import msgspec
import numpy as np

from ...compiler import ir
from ...compiler.options import OPTIONS
from ..plan import NO_LIMIT, Plan
from ..plan_forces import StaticsRecord
from .findings import Findings
from .inertia import node_weights
from .strengths import STRENGTHS

EQUAL = 1e-9
"""Share by which weights and strengths may differ: rounding."""


def told(plan: Plan) -> StaticsRecord | None:
    """What a plan tells of forces."""
    return None if isinstance(plan.statics, msgspec.UnsetType) else plan.statics


def check_weights(plan: Plan, problem: ir.Problem, findings: Findings) -> None:
    """Weights and strengths are those of the texts, each told once."""
    given = told(plan)
    if given is None:
        return
    wanted = {
        node: [w.mass, *w.centre.tolist(), *w.inertia[np.triu_indices(3)].tolist()]
        for node, w in node_weights(problem).items()
    }
    stored = {(w.name, w.joint): w for w in given.weights}
    if stored.keys() != wanted.keys() or len(stored) != len(given.weights):
        findings.fail("scene", "the plan's weights are not those of the parts of its scene")
    for node in stored.keys() & wanted.keys():
        record = stored[node]
        numbers = [record.mass, *record.centre, *record.inertia]
        if not _near(numbers, wanted[node]):
            findings.fail("scene", f"a weight of {node[0]} differs from the scene", between=[node[0]])
    joints = {
        (name, joint.name): [min(joint.torque, NO_LIMIT), min(joint.bearing, NO_LIMIT), joint.rotor, joint.brake]
        for name, module in problem.world.modules.items()
        for joint in module.type.joints
    }
    drives = {(d.module, d.joint): [d.torque, d.bearing, d.rotor, d.brake] for d in given.drives}
    if drives.keys() != joints.keys() or len(drives) != len(given.drives):
        findings.fail("scene", "the plan's strengths are not those of the joints of its scene")
    for key in drives.keys() & joints.keys():
        if not _near(drives[key], joints[key]):
            message = f"the strength of joint {key[1]} of {key[0]} differs from the scene"
            findings.fail("scene", message, between=list(key))


    _check_holds(given, problem, findings)


def _check_holds(given: StaticsRecord, problem: ir.Problem, findings: Findings) -> None:
    """How ends and bodies hold, and the safety; plans of earlier versions tell of neither."""
    if not given.wrenches and not given.holds:
        return
    safety = float(OPTIONS["safety"].default if problem.options.safety is None else problem.options.safety)
    if not _near([given.safety], [safety]):
        findings.fail("scene", "the plan's safety is not that of its task")
    wanted: dict[tuple[str, str], ir.Hold] = {}
    for name, module in problem.world.modules.items():
        wanted |= {(f"{name}.{e.name}", h.manner): h for e in module.type.effectors for h in e.holds}
    wanted |= {(name, h.manner): h for name, body in problem.world.bodies.items() for h in body.holds}
    stored = {(h.name, h.manner): h for h in given.holds}
    if stored.keys() != wanted.keys() or len(stored) != len(given.holds):
        findings.fail("scene", "the plan does not tell how the ends and bodies of its scene hold")
    for key in stored.keys() & wanted.keys():
        numbers = [min(getattr(wanted[key], s), NO_LIMIT) for s in STRENGTHS]
        if not _near([getattr(stored[key], s) for s in STRENGTHS], numbers):
            message = f"how strongly {key[0]} holds as {key[1]} differs from the scene"
            findings.fail("scene", message, between=[key[0]])


def _near(numbers: list[float], wanted: list[float]) -> bool:
    scale = 1.0 + max(map(abs, wanted))
    return len(numbers) == len(wanted) and all(
        abs(a - b) <= EQUAL * scale for a, b in zip(numbers, wanted, strict=True)
    )
