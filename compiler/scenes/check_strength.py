"""With `physics` on: parts without a mass, and what does not bear itself at the start."""

from __future__ import annotations

import math

from ...langs.diagnostics import did_you_mean
from ...langs.trees import parts
from .. import ir
from ..checks.findings import Findings
from ..physics.masses import DENSITY, unstated
from ..physics.safety import safety_of, weighed

SLACK = 1e-9
"""Share by which a load that is exactly the strength may be more by rounding."""


def check_joint_names(findings: Findings, problem: ir.Problem) -> None:
    """Reports joints that conditions and rows speak of and no module of the scene has."""
    known = sorted({j.name for m in problem.world.modules.values() for j in m.type.joints})
    asked: list[object] = [row for motion in problem.motions.values() for row in motion.rows]
    asked += [rule.condition for rule in problem.rules.values()]
    asked += [derived.body for derived in problem.derived.values()]
    for part in (p for item in (*asked, problem.goal, problem.heuristic) if item is not None for p in parts(item)):
        if isinstance(part, ir.Function) and part.name == "torque" and isinstance(part.args[1], ir.Letter):
            name = part.args[1].letter
            if known and name not in known and part.span is not None:
                help = did_you_mean(name, known) or f"there are {', '.join(known[:8])}"
                findings.report("E0114", findings.word(part.span, name), f"no module of the scene has a joint `{name}`",
                                help=help)  # fmt: skip


def check_strength(findings: Findings, problem: ir.Problem) -> None:
    """Reports W0018 and E0523 where the task has `physics` on."""
    if not weighed(problem.options):
        return
    _warn(findings, problem)
    from ..physics.start_loads import plainly_borne

    if plainly_borne(problem):
        return
    import numpy as np

    from ..physics.frames import poses
    from ..physics.statics import loads
    from ..physics.structure import stated_at

    world = problem.world
    modules = {n: np.array([[*m.pose, *m.joints]]) for n, m in world.modules.items()}
    at = poses(problem, modules, {n: np.array([b.pose]) for n, b in world.bodies.items()})
    safety = safety_of(problem.options)
    found = [load for load in loads(problem, problem.init_motion, at, safety) if load.ratio[0] > 1.0 + SLACK]
    if not found:
        return
    worst = max(found, key=lambda load: float(load.ratio[0]))
    owners = [world.owner(name) for name in worst.edge.names if name]
    thing = next((world.modules[n] for n in owners if n in world.modules), None) or world.bodies.get(owners[0])
    if thing is not None and thing.span is not None:
        stated = stated_at(problem, worst.edge)
        findings.report(
            "E0523",
            thing.span,
            f"the scene does not bear itself at the start: {worst.told(safety)}",
            help="lean less at the start (`home` of joints), or state more strength",
            labels=[(stated, "stated here")] if stated is not None else [],
        )


def _says_strength(world: ir.World) -> bool:
    """Whether a joint or an end states what it bears."""
    types = {m.type.name: m.type for m in world.modules.values()}.values()
    joints = any(math.isfinite(min(j.torque, j.bearing)) for t in types for j in t.joints)
    return joints or any(e.holds for t in types for e in t.effectors) or any(b.holds for b in world.bodies.values())


def _warn(findings: Findings, problem: ir.Problem) -> None:
    world = problem.world
    first = next((m for m in world.modules.values() if m.span is not None), None)
    if first is not None and not _says_strength(world):
        message = "`physics` is on, but nothing of the scene states a strength: whatever the load, all bear it"
        findings.report("W0024", first.span, message, help="add `torque` to joints, and to ends how they hold")
    kinds = {m.type.name: m for m in world.modules.values() if unstated(m.type)}
    things = [b for b in world.bodies.values() if b.movable and b.mass is None]
    for name, module in kinds.items():
        if module.span is not None:
            message = f"parts of `{name}` state no mass and count with {DENSITY:g} kg/m^3"
            findings.report("W0018", module.span, message, help="add `mass` or `density` to its links and effectors")
    if things and things[0].span is not None:
        named = ", ".join(f"`{b.name}`" for b in things[:3]) + (", …" if len(things) > 3 else "")
        count = "states no mass and counts" if len(things) == 1 else "state no mass and count"
        message = f"{named} {count} with {DENSITY:g} kg/m^3"
        findings.report("W0018", things[0].span, message, help="add `mass` or `density`")
