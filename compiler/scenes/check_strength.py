"""With `physics` on: parts without a mass, and what does not bear itself at the start."""

from __future__ import annotations

from .. import ir
from ..checks.findings import Findings
from ..options import OPTIONS
from ..physics.masses import DENSITY, unstated

SLACK = 1e-9
"""Share by which a load that is exactly the strength may be more by rounding."""


def safety_of(options: ir.Options) -> float:
    """How many times its load everything must bear."""
    return float(OPTIONS["safety"].default if options.safety is None else options.safety)


def check_strength(findings: Findings, problem: ir.Problem) -> None:
    """Reports W0018 and E0523 where the task has `physics` on."""
    if problem.options.physics in (None, "none"):
        return
    _warn(findings, problem)
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
    module = world.owner(worst.edge.names[0])
    thing = world.modules.get(module) or world.bodies.get(module)
    if thing is not None and thing.span is not None:
        stated = stated_at(problem, worst.edge)
        findings.report(
            "E0523",
            thing.span,
            f"the scene does not bear itself at the start: {worst.told(safety)}",
            help="lean less at the start (`home` of joints), or state more strength",
            labels=[(stated, "stated here")] if stated is not None else [],
        )


def _warn(findings: Findings, problem: ir.Problem) -> None:
    world = problem.world
    kinds = {m.type.name: m for m in world.modules.values() if unstated(m.type)}
    things = [b for b in world.bodies.values() if b.movable and b.mass is None]
    for name, module in kinds.items():
        if module.span is not None:
            message = f"parts of `{name}` state no mass: they count with {DENSITY:g} kg/m^3"
            findings.report("W0018", module.span, message, help="add `mass` or `density` to its links and effectors")
    if things and things[0].span is not None:
        named = ", ".join(f"`{b.name}`" for b in things[:3]) + (", …" if len(things) > 3 else "")
        message = f"{named} state no mass: they count with {DENSITY:g} kg/m^3"
        findings.report("W0018", things[0].span, message, help="add `mass` or `density`")
