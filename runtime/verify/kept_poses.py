"""Whose relative poses a mode keeps, and what stands where it is because nothing carries it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from ...compiler import ir
from ...compiler.remembering import remembered

Mode = Iterable[ir.Fact]


def kept(problem: ir.Problem, mode: Mode) -> Iterator[tuple[str, str]]:
    """Pairs (carrying, carried) of objects whose relative pose a mode keeps."""
    for literal in sorted(mode):
        predicate = problem.motions[literal[0]]
        bound = dict(zip((v.name for v in predicate.variables), literal[1:], strict=True))
        for row in predicate.rows:
            if row.when == "keep" and isinstance(row.left, ir.Function) and row.left.name == "pose":
                own, base = (_bound(bound, a) for a in row.left.args)
                yield base, own


def bolted(problem: ir.Problem, mode: Mode) -> list[str]:
    """The modules that nothing carries, neither at the start nor while a mode holds: their frames rest."""
    loose = _loose(problem)
    carried = _carried(problem, mode) if loose else set()
    return [name for name in loose if name not in carried]


@remembered(8)
def _loose(problem: ir.Problem) -> tuple[str, ...]:
    """The modules that nothing carries at the start."""
    carried = _carried(problem, problem.init_motion)
    return tuple(name for name in problem.world.modules if name not in carried)


def _carried(problem: ir.Problem, mode: Mode) -> set[str]:
    """What follows something that takes its frame along; a fixed body always leads."""
    bodies, found, pairs = problem.world.bodies, set[str](), [*kept(problem, mode)]
    fixed = {name for pair in pairs for name in pair if name in bodies and not bodies[name].movable}
    for base, own in pairs:
        leader, follower = (own, base) if own in fixed else (base, own)
        lifted = leader in fixed or (leader not in problem.world.bodies and _steady(problem, leader))
        if _at_frame(problem, follower) or (lifted and _driven(problem, follower)):
            found.add(thing_of(problem, follower))
    return found


def _steady(problem: ir.Problem, leader: str) -> bool:
    """Whether no joints without drives alone lie between an end and what carries its module."""
    return _at_frame(problem, leader) or _driven(problem, leader)


def _at_frame(problem: ir.Problem, name: str) -> bool:
    end = problem.world.effector(name)
    return end is None or end[1].joint == -1


def _driven(problem: ir.Problem, name: str) -> bool:
    end = problem.world.effector(name)
    return end is not None and not all(j.passive for j in end[0].type.joints)


def _bound(bound: Mapping[str, str], node: ir.Term) -> str:
    return bound[node.name] if isinstance(node, ir.Var) else node.name if isinstance(node, ir.Object) else ""


def thing_of(problem: ir.Problem, name: str) -> str:
    """The module of an effector, else the thing itself."""
    end = problem.world.effector(name)
    return name if end is None else end[0].name
