"""Whether what a plan tells of weights, strengths and torques is what its texts and its motion say."""

from __future__ import annotations

from collections.abc import Mapping

import msgspec
import numpy as np

from ...compiler import ir
from ..plan import NO_LIMIT, Plan, StaticsRecord
from .findings import Findings
from .geometry import Array, Frames, frames
from .inertia import body_mass, moments, weights
from .strengths import Joined

EQUAL = 1e-9
"""Share by which weights and strengths may differ: rounding."""
APART = 0.02
"""Share of the greatest torque of its module in the phase by which a told torque may be off, for what the accelerations
of two ways of differentiating differ by: 0.004 was met."""
SLACK = 1e-3
"""N m (N) by which it may be off besides."""


def told(plan: Plan) -> StaticsRecord | None:
    """What a plan tells of forces."""
    return None if isinstance(plan.statics, msgspec.UnsetType) else plan.statics


def check_weights(plan: Plan, problem: ir.Problem, findings: Findings) -> None:
    """Weights and strengths are those of the texts, each told once."""
    given = told(plan)
    if given is None:
        return
    wanted = _weights(problem)
    stored = {(w.name, w.joint): w for w in given.weights}
    if stored.keys() != wanted.keys() or len(stored) != len(given.weights):
        findings.fail("scene", "the plan's weights are not those of the parts of its scene")
    for node in stored.keys() & wanted.keys():
        record = stored[node]
        numbers = [record.mass, *record.centre, *record.inertia]
        if not _near(numbers, wanted[node]):
            findings.fail("scene", f"a weight of {node[0]} differs from the scene", between=[node[0]])
    joints = {
        (name, joint.name): [min(joint.torque, NO_LIMIT), min(joint.bearing, NO_LIMIT), joint.rotor]
        for name, module in problem.world.modules.items()
        for joint in module.type.joints
    }
    drives = {(d.module, d.joint): [d.torque, d.bearing, d.rotor] for d in given.drives}
    if drives.keys() != joints.keys() or len(drives) != len(given.drives):
        findings.fail("scene", "the plan's strengths are not those of the joints of its scene")
    for key in drives.keys() & joints.keys():
        if not _near(drives[key], joints[key]):
            message = f"the strength of joint {key[1]} of {key[0]} differs from the scene"
            findings.fail("scene", message, between=list(key))


def _near(numbers: list[float], wanted: list[float]) -> bool:
    scale = 1.0 + max(map(abs, wanted))
    return len(numbers) == len(wanted) and all(
        abs(a - b) <= EQUAL * scale for a, b in zip(numbers, wanted, strict=True)
    )


def _weights(problem: ir.Problem) -> dict[tuple[str, int], list[float]]:
    """Of each rigid part that weighs: its mass, centre and inertia about that, upper triangle row by row."""
    found = {}
    for name, module in problem.world.modules.items():
        parts = weights(module.type)
        for joint in {p[0] for p in parts}:
            own = [(mass, frames(place), tensor) for at, place, mass, tensor in parts if at == joint]
            found[name, joint] = _joined(own)
    for name, body in problem.world.bodies.items():
        if body.movable:
            mass = body_mass(body)
            found[name, -1] = [mass, 0.0, 0.0, 0.0, *moments(body.shape, mass)[np.triu_indices(3)].tolist()]
    return found


def _joined(parts: list[tuple[float, Frames, Array]]) -> list[float]:
    total = sum(mass for mass, _, _ in parts)
    moment = sum((mass * at.position[0] for mass, at, _ in parts), np.zeros(3))
    centre = moment / total if total else moment
    whole = np.zeros((3, 3))
    for mass, at, tensor in parts:
        turn, out = at.rotation[0], at.position[0] - centre
        whole += turn @ tensor @ turn.T + mass * (float(out @ out) * np.eye(3) - np.outer(out, out))
    return [total, *centre.tolist(), *whole[np.triu_indices(3)].tolist()]


def torque_times(plan: Plan, phase: int) -> Array | None:
    """The times for which torques of a phase are told; None where none are, or not all alike."""
    given = told(plan)
    lengths = {len(t.values) for t in (given.torques if given is not None else ()) if t.phase == phase}
    if len(lengths) != 1 or not 2 <= next(iter(lengths)) <= 1000:
        return None
    record = plan.phases[phase]
    return np.linspace(record.start, record.end, next(iter(lengths)))


def check_torques(
    plan: Plan, problem: ir.Problem, phase: int, torques: Mapping[Joined, Array], findings: Findings
) -> None:
    """The torques of a phase are those of its motion. Of joints in closed loops nothing is asked: their share is open.
    At the first and the last instant accelerations jump; there what inertia adds is left out."""
    given = told(plan)
    for record in (t for t in (given.torques if given is not None else ()) if t.phase == phase):
        module = problem.world.modules.get(record.module)
        if module is None or any(len(row) != len(module.type.joints) for row in record.values):
            findings.fail("structure", f"torques of {record.module} do not fit its joints")
            continue
        names = [j.name for j in module.type.joints]
        own = {edge: rows for edge, rows in torques.items() if edge.names[0] == record.module}
        most = max((float(np.abs(rows).max()) for rows in own.values()), default=0.0)
        for edge, rows in own.items():
            stored = np.array([row[names.index(edge.names[1])] for row in record.values])
            off = float(np.abs(stored - rows)[1:-1].max(initial=0.0))
            if not off <= APART * most + SLACK:
                message = f"the told torque of joint {edge.names[1]} of {record.module} is not that of its motion"
                findings.fail("statics", message, amount=off, unit="N m", between=list(edge.names))
