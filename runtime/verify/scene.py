"""Whether the plan's modules and bodies are those of its scene."""

from __future__ import annotations

from collections.abc import Sequence

from ...compiler import ir
from ..plan import NO_LIMIT, BodyRecord, CouplingRecord, ModuleRecord, Plan, ShapeRecord
from ..plan_upgrade import EarlyPlan
from .findings import Findings
from .told_forces import check_weights

TOLERANCE = 1e-9


def check_scene(plan: Plan, problem: ir.Problem, findings: Findings) -> bool:
    """Whether modules and bodies of the plan equal those of the problem, name by name."""
    before = len(findings.failures)
    world = problem.world
    stored = [m.name for m in plan.modules] + [b.name for b in plan.bodies]
    wanted = [*world.modules, *world.bodies]
    if stored != wanted:
        differing = sorted(set(stored) ^ set(wanted)) or "their order"
        findings.fail("scene", f"the plan's things are not those of the scene: {differing}")
        return False
    for module in plan.modules:
        for what in _module_differences(module, world.modules[module.name], isinstance(plan, EarlyPlan)):
            findings.fail("scene", f"{what} of {module.name} differs from the scene", between=[module.name])
    for body in plan.bodies:
        for what in _body_differences(body, world.bodies[body.name]):
            findings.fail("scene", f"{what} of {body.name} differs from the scene", between=[body.name])
    check_weights(plan, problem, findings)
    return len(findings.failures) == before


def _near(first: Sequence[float], second: Sequence[float]) -> bool:
    return len(first) == len(second) and all(
        a == b or abs(a - b) <= TOLERANCE for a, b in zip(first, second, strict=True)
    )


def _same_shape(record: ShapeRecord | None, shape: ir.Shape | None) -> bool:
    if record is None or shape is None:
        return record is None and shape is None
    parts = list(zip(record.parts, shape.parts, strict=False))
    return (
        record.kind == shape.kind and _near(record.size, shape.size) and len(record.parts) == len(shape.parts)
        and all(_near(a.at, b.at) and _same_shape(a.shape, b.shape) for a, b in parts)
    )  # fmt: skip


def _bounded(*values: float) -> list[float]:
    return [min(max(v, -NO_LIMIT), NO_LIMIT) for v in values]


def _module_differences(record: ModuleRecord, module: ir.Module, early: bool) -> list[str]:
    """In which parts a module of the plan is not that of the scene; `early` plans need not state accelerations."""
    kind = module.type
    found = [] if record.type == kind.name else ["the type"]
    if not _near(record.pose, module.pose):
        found.append("the start pose")
    if not _near(record.start, module.joints):
        found.append("a start joint value")
    if [j.name for j in record.joints] != [j.name for j in kind.joints]:
        found.append("the list of joints")
    else:
        for a, b in zip(record.joints, kind.joints, strict=True):
            numbers = _near([a.lower, a.upper, a.speed], _bounded(b.lower, b.upper, b.speed))
            unstated = early and a.acceleration == NO_LIMIT
            numbers = numbers and (unstated or _near([a.acceleration], _bounded(b.acceleration)))
            numbers = numbers and _near([a.jerk], _bounded(b.jerk))
            frame = _near(a.placement, b.placement) and _near(a.axis, b.axis)
            driven = _same_coupling(a.follows, b.follows) and a.passive == b.passive
            if not (numbers and frame and driven and (a.kind, a.parent) == (b.kind, b.parent)):
                found.append(f"joint {a.name}")
    return found + _part_differences(record, kind)


def _same_coupling(record: CouplingRecord | None, coupling: ir.Coupling | None) -> bool:
    if record is None or coupling is None:
        return record is None and coupling is None
    return record.leader == coupling.leader and _near(
        [record.factor, record.offset], [coupling.factor, coupling.offset]
    )


def _part_differences(record: ModuleRecord, kind: ir.ModuleType) -> list[str]:
    found = []
    if [e.name for e in record.effectors] != [e.name for e in kind.effectors]:
        found.append("the list of effectors")
    else:
        for a, b in zip(record.effectors, kind.effectors, strict=True):
            if a.joint != b.joint or not _near(a.placement, b.placement) or not _same_shape(a.shape, b.shape):
                found.append(f"effector {a.name}")
    if len(record.links) != len(kind.links):
        return [*found, "the number of links"]
    for number, (link, wanted) in enumerate(zip(record.links, kind.links, strict=True)):
        same = link.joint == wanted.joint and _near(link.placement, wanted.placement)
        if not same or not _same_shape(link.shape, wanted.shape):
            found.append(f"link {number + 1}")
    return found


def _body_differences(record: BodyRecord, body: ir.Body) -> list[str]:
    found = [] if record.type == body.type else ["the type"]
    if not _same_shape(record.shape, body.shape):
        found.append("the shape")
    if not _near(record.pose, body.pose):
        found.append("the start pose")
    if record.movable != body.movable:
        found.append("whether it can be moved")
    if record.collides != body.collides:
        found.append("whether it can be collided with")
    return found
