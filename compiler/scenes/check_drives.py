"""Joints without drives that no action could ever have something hold and move."""

from __future__ import annotations

from .. import ir
from ..checks.findings import Findings


def check_drives(findings: Findings, problem: ir.Problem) -> None:
    """Warn of each module whose joints have no drive and which nothing can take hold of: no rule, by the types of its
    variables, makes anything that drives move, or anything that can be carried, hold one of its effectors. A module
    that has drives too may move its other joints by standing on something."""
    world = problem.world
    waiting = [m for m in world.modules.values() if any(j.passive for j in m.type.joints)]
    if not waiting:
        return
    drivers = {b.name for b in world.bodies.values() if b.movable}
    for module in world.modules.values():
        if any(not j.passive for j in module.type.joints):
            drivers |= {f"{module.name}.{e.name}" for e in module.type.effectors}
    held = [pair for rule in problem.rules.values() for pair in _holds(problem, rule)]
    for module in waiting:
        own = {f"{module.name}.{e.name}" for e in module.type.effectors} | {module.name}
        driven = any(not j.passive for j in module.type.joints)
        others = (problem.objects.keys() if driven else drivers) - own
        moved = any((a & own and b & others) or (b & own and a & others) for a, b in held)
        still = _endless(module.type)
        if still:
            why, help = "no effector lies behind by which it could be held", "write an `effector` behind the joint"
        elif not moved:
            still = [j.name for j in module.type.joints if j.passive]
            why = "no rule has anything with drives hold it"
            help = "a rule that takes hold adds a motion literal with a `keep` row, such as `[stable A H]`"
        else:
            continue
        names = ", ".join(f"`{name}`" for name in still)
        findings.report("W0013", module.span, f"nothing can move {names} of `{module.name}`: {why}", help=help)


def _endless(type_: ir.ModuleType) -> list[str]:
    """The joints without drives that carry no effector, and are coupled to none that do."""
    behind: set[int] = set()
    for end in type_.effectors:
        index = end.joint
        while index >= 0:
            behind.add(index)
            index = type_.joints[index].parent
    leaders = {k: j.follows.leader if j.follows is not None else k for k, j in enumerate(type_.joints)}
    moved = {leaders[index] for index in behind}
    return [j.name for k, j in enumerate(type_.joints) if j.passive and leaders[k] not in moved]


def _holds(problem: ir.Problem, rule: ir.Rule) -> list[tuple[frozenset[str], frozenset[str]]]:
    """Of each two arguments of a literal by which the rule has things hold each other, the objects that they can be."""
    types = {v.name: v.type for v in rule.variables}
    found = []
    for effect, loops in ir.effects_with_loops(rule.effects):
        literal = effect.literal
        if effect.negated or not literal.motion or not _keeps(problem.motions[literal.predicate]):
            continue
        here = types | {v.name: v.type for v in loops}
        sets = [_objects(problem, here, term) for term in literal.args]
        found += [(a, b) for k, a in enumerate(sets) for b in sets[k + 1 :]]
    return found


def _objects(problem: ir.Problem, types: dict[str, ir.Type], term: ir.Term) -> frozenset[str]:
    """The objects that a term can stand for, or more."""
    kind = types.get(term.name) if isinstance(term, ir.Var) else None
    if isinstance(kind, ir.ObjectType):
        return frozenset(problem.of_type(kind.name))
    return frozenset({term.name}) if isinstance(term, ir.Object) else frozenset(problem.objects)


def _keeps(motion: ir.MotionPredicate) -> bool:
    return any(row.when == "keep" or (row.when == "during" and row.operator == "=") for row in motion.rows)
