"""The task after a module has failed: its joints are stuck, or it has left the scene."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from ...compiler import ir
from ...compiler.poses import compose, joint_frames

FALSE = ir.Or(())


def frozen(problem: ir.Problem, module: str) -> ir.Problem:
    """The task with a module's joints stuck where `problem` starts: it has none any more, and its effectors and links
    are fixed to its frame."""
    failed = problem.world.modules[module]
    kind = failed.type
    frames = joint_frames(kind, ir.IDENTITY, failed.joints)
    rigid = ir.ModuleType(
        f"{kind.name} stuck as {module}",
        (),
        tuple(replace(e, joint=-1, placement=compose(frames[e.joint], e.placement)) for e in kind.effectors),
        tuple(replace(k, joint=-1, placement=compose(frames[k.joint], k.placement)) for k in kind.links),
    )
    modules = {**problem.world.modules, module: replace(failed, type=rigid, joints=())}
    return replace(problem, world=replace(problem.world, modules=modules))


def without(problem: ir.Problem, module: str) -> ir.Problem:
    """The task without a module that has left the scene: no fact speaks of it, and what it held stays where it is. A
    goal that names it is false there; a guide that does is dropped."""
    gone = names_of(problem, module)
    modules = {name: m for name, m in problem.world.modules.items() if name != module}
    heuristic = problem.heuristic
    return replace(
        problem,
        objects={name: kind for name, kind in problem.objects.items() if name not in gone},
        init=silent_of(problem.init, gone),
        init_motion=silent_of(problem.init_motion, gone),
        rules={name: _rule(rule, gone) for name, rule in problem.rules.items()},
        derived={name: replace(d, body=formula_without(d.body, gone)) for name, d in problem.derived.items()},
        goal=formula_without(problem.goal, gone),
        heuristic=None if heuristic is not None and _names(heuristic, gone) else heuristic,
        world=replace(problem.world, modules=modules),
        touching=frozenset(p for p in problem.touching if not gone.intersection(p)),
    )


def names_of(problem: ir.Problem, module: str) -> frozenset[str]:
    """A module and its effectors."""
    return frozenset({module, *(f"{module}.{e.name}" for e in problem.world.modules[module].type.effectors)})


def silent_of(facts: frozenset[ir.Fact], gone: frozenset[str]) -> frozenset[ir.Fact]:
    """The facts that name none of the objects."""
    return frozenset(f for f in facts if not gone.intersection(f[1:]))


def _rule(rule: ir.Rule, gone: frozenset[str]) -> ir.Rule:
    """A rule whose effects name what is gone can never be done."""
    if _names(rule.effects, gone):
        return replace(rule, condition=FALSE, effects=())
    return replace(rule, condition=formula_without(rule.condition, gone))


def formula_without(formula: ir.Formula, gone: frozenset[str]) -> ir.Formula:
    """The formula with every literal and comparison that names a gone object false."""
    match formula:
        case ir.Literal() | ir.Compare() | ir.Previous():
            return FALSE if _names(formula, gone) else formula
        case ir.Not():
            return ir.Not(formula_without(formula.operand, gone))
        case ir.And():
            return ir.And(tuple(formula_without(f, gone) for f in formula.operands))
        case ir.Or():
            return ir.Or(tuple(formula_without(f, gone) for f in formula.operands))
        case ir.Exists() | ir.Forall():
            return replace(formula, body=formula_without(formula.body, gone))


def _names(part: object, gone: frozenset[str]) -> bool:
    """Whether a part of a formula or rule names one of the objects."""
    if isinstance(part, ir.Object):
        return part.name in gone
    if isinstance(part, tuple | list):
        return any(_names(p, gone) for p in part)
    if isinstance(part, Mapping):
        return any(_names(p, gone) for p in part.values())
    fields = getattr(part, "__dataclass_fields__", None)
    if fields is None:
        return False
    return any(_names(getattr(part, name), gone) for name in fields if name != "span")
