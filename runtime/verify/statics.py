"""Whether everything bears its loads, times the safety that the task asks for.

Loads are found in another way than the planner's: what an edge bears is the sum of what lies beyond it, found by taking
the edge away. Where that leaves nothing without support, the edge is part of a closed loop, whose share is open: it is
the one that the plan tells, put into balance, or where that does not do, the wrenches of all edges of the loop at once,
by the balance of every node, from HiGHS; either is measured anew. Joint torques are repeated by Pinocchio's recursion,
module by module, under the wrenches found for its ends.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from ...compiler import ir
from ...compiler.options import OPTIONS
from ..plan import Plan
from .findings import Findings
from .geometry import Array, Frames, Indices, crossed
from .inertia import node_weights
from .kept_poses import kept
from .rigid_model import RigidModel
from .rows import Posed
from .sampler import Sampler, Shown
from .shared_loads import shared
from .strengths import Joined, Loads, Looked, Support, Wrench, joined, judge
from .told_wrenches import check_forces, told_pairs, told_rows

LOOKS = 24
"""Instants of a phase at which loads are measured: they find the worst within a thousandth."""
STEP = 1e-3
"""Seconds before and after an instant, for accelerations."""
GRAVITY = 9.81
AGREEMENT = 1e-6
"""N m by which Pinocchio may find another torque: rounding."""


def check_statics(problem: ir.Problem, plan: Plan, modes: tuple[frozenset[ir.Fact], ...], final: frozenset[ir.Fact],
                  sampler: Sampler, findings: Findings) -> None:  # fmt: skip
    """Measure torque_ratio, bearing_ratio, dock_ratio, foot_ratio and tip_m along every phase, and on the far side of
    every switch. Raises OutOfTime."""
    if problem.options.physics in (None, "none"):
        return
    safety = float(OPTIONS["safety"].default if problem.options.safety is None else problem.options.safety)
    moving = problem.options.physics == "dynamics"
    for index, record in enumerate(plan.phases[: len(modes)]):
        findings.check_time()
        times = np.linspace(record.start, record.end, LOOKS + 1)
        at = _looked(problem, modes[index], sampler, index, times, moving)
        _measure(problem, at, safety, moving, findings, told_pairs(plan, problem, index, at))
        _compare(problem, plan, index, modes[index], at, sampler, moving, findings)
        after = modes[index + 1] if index + 1 < len(modes) else final
        if record.completed:
            at = _looked(problem, after, sampler, index, times[-1:], False)
            _measure(problem, at, safety, False, findings, told_pairs(plan, problem, index + 1, at))
        if index + 1 == len(plan.phases):
            at = _looked(problem, final, sampler, index, times[-1:], False)
            _compare(problem, plan, index + 1, final, at, sampler, False, findings)


def _compare(
    problem: ir.Problem, plan: Plan, phase: int, mode: frozenset[ir.Fact], at: Looked, sampler: Sampler, moving: bool,
    findings: Findings,
) -> None:  # fmt: skip
    """Compare what the plan tells of a phase with what is measured; where it tells more instants, at those."""
    rows = told_rows(plan, phase)
    if rows > len(at.times) > 1:
        times = np.linspace(at.times[0], at.times[-1], rows)
        at = _looked(problem, mode, sampler, phase, times, moving)
    support = Support(at.edges)
    check_forces(plan, problem, phase, at, support, _bridged(support, at.nodes, at.loads), moving, findings)


def _looked(
    problem: ir.Problem, mode: frozenset[ir.Fact], sampler: Sampler, phase: int, times: Array, moving: bool
) -> Looked:
    nodes = node_frames(problem, Shown(sampler.at(phase, times), sampler.kinematics))
    loads = node_loads(problem, nodes, _accelerated(problem, sampler, phase, times) if moving else None)
    return Looked(times, nodes, loads, joined(problem, mode, kept(problem, mode)))


def _measure(
    problem: ir.Problem, at: Looked, safety: float, moving: bool, findings: Findings, told: Mapping[Joined, Wrench]
) -> None:
    wrenches = wrenches_of(problem, at.edges, at.nodes, at.loads, safety, told)
    for edge, (force, moment) in wrenches.items():
        for figure in judge(problem, edge, at.nodes, force, moment, safety):
            worst = int(np.argmax(figure.amounts))
            findings.measure(
                figure.kind, float(figure.amounts[worst]), figure.message, time=float(at.times[worst]),
                between=edge.names, place=findings.place_of(figure.span),
            )  # fmt: skip
    if not moving:
        _repeat(problem, at.edges, at.nodes, wrenches, float(at.times[-1]), findings)


def node_frames(problem: ir.Problem, shown: Posed, at: Indices | slice = slice(None)) -> dict[tuple[str, int], Frames]:
    """The frames `(T,)` of everything that is rigid and may move, at instants `at`."""
    found: dict[tuple[str, int], Frames] = {}
    for name in problem.world.modules:
        found |= {(name, joint): frame[at] for joint, frame in (shown.parts(name) or {}).items()}
    for name in problem.world.bodies:
        found[name, -1] = shown.frame(name)[at]
    return found


def node_loads(
    problem: ir.Problem, nodes: Mapping[tuple[str, int], Frames],
    around: tuple[Mapping[tuple[str, int], Frames], Mapping[tuple[str, int], Frames]] | None,
) -> Loads:  # fmt: skip
    """Weights, and with the frames `STEP` before and after also inertia."""
    forces: dict[tuple[str, int], Array] = {}
    turning: dict[tuple[str, int], Array] = {}
    for node, weight in node_weights(problem).items():
        here, out = nodes[node].rotation, nodes[node].rotation @ weight.centre
        force = np.tile([0.0, 0.0, -GRAVITY * weight.mass], (len(here), 1))
        moment = np.zeros((len(here), 3))
        if around is not None:
            before, after = (side[node] for side in around)
            shift = before.position - 2.0 * nodes[node].position + after.position
            turned = (before.rotation - 2.0 * here + after.rotation) @ weight.centre
            force = force - weight.mass * (shift + turned) / STEP**2
            spun = []
            for one, other in ((before.rotation, here), (here, after.rotation)):
                middle = (one + other) / 2.0
                rate = (other - one) @ np.swapaxes(middle, 1, 2) / STEP
                spin = np.stack([rate[:, 2, 1], rate[:, 0, 2], rate[:, 1, 0]], axis=1)
                tensor = middle @ weight.inertia @ np.swapaxes(middle, 1, 2)
                spun.append((tensor @ spin[:, :, None])[:, :, 0])
            moment = moment - (spun[1] - spun[0]) / STEP
        forces[node] = force
        turning[node] = moment + crossed(nodes[node].position + out, force)
    return Loads(forces, turning)


def _accelerated(
    problem: ir.Problem, sampler: Sampler, phase: int, times: Array
) -> tuple[Mapping[tuple[str, int], Frames], Mapping[tuple[str, int], Frames]]:
    """The frames shortly before and after each time. At the ends everything rests: there both are as inside."""
    inner = np.clip(times, times[0] + STEP, times[-1] - STEP)
    sides = []
    for step in (-STEP, STEP):
        shown = Shown(sampler.at(phase, inner + step), sampler.kinematics)
        sides.append(node_frames(problem, shown))
    return sides[0], sides[1]


Wrenches = Mapping[Joined, Wrench]


def wrenches_of(
    problem: ir.Problem, edges: tuple[Joined, ...], nodes: Mapping[tuple[str, int], Frames], loads: Loads,
    safety: float, told: Wrenches | None = None,
) -> dict[Joined, Wrench]:  # fmt: skip
    """What the far side of every edge puts on the near one, force and moment about the origin. Loops share their loads
    as is `told` of their pairs where that keeps all strengths, else so that they strain the least."""
    support = Support(edges)
    found = _bridged(support, nodes, loads)
    for ring in support.rings:
        found |= shared(problem, ring, nodes, loads, found, support, safety, told or {})
    return found


def _bridged(
    support: Support, nodes: Mapping[tuple[str, int], Frames], loads: Loads
) -> dict[Joined, Wrench]:
    """The same of the edges without which something is without support."""
    count = max(len(f) for f in nodes.values())
    found: dict[Joined, Wrench] = {}
    for edge in support.bridges:
        force, moment = np.zeros((count, 3)), np.zeros((count, 3))
        for node in sorted(support.beyond(edge)):
            if node in loads.forces:
                force, moment = force + loads.forces[node], moment + loads.moments[node]
        sign = -1.0 if edge.near in support.beyond(edge) else 1.0
        found[edge] = sign * force, sign * moment
    return found


def _repeat(
    problem: ir.Problem, edges: tuple[Joined, ...], nodes: Mapping[tuple[str, int], Frames], wrenches: Wrenches,
    time: float, findings: Findings,
) -> None:  # fmt: skip
    """Compare the joint torques at the last instant with Pinocchio's."""
    for name, module in problem.world.modules.items():
        own = [e for e in edges if not e.joint_of and name in (e.near[0], e.far[0]) and e in wrenches]
        if not own or not module.type.joints:
            continue
        off = RigidModel.of(module.type).disagreement(name, nodes, wrenches, own)
        if off is not None and not math.isclose(off, 0.0, abs_tol=AGREEMENT * (1.0 + RigidModel.of(module.type).mass)):
            message = f"Pinocchio finds other torques for {name}"
            findings.fail("statics", message, amount=off, unit="N m", time=time, between=[name])
