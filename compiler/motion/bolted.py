"""Modules that nothing carries: their frames stay where the scene puts them, as if they were bolted there."""

from __future__ import annotations

from ..ir import Fact, Module, Problem
from ..kept_pairs import kept_pairs
from ..remembering import remembered


@remembered(8)
def bolted(problem: Problem, mode: frozenset[Fact]) -> frozenset[str]:
    """The modules whose frames stay where they are at the start while `mode` holds: nothing carries them in the scene,
    and nothing does now."""
    loose = frozenset(problem.world.modules) - _carried(problem, problem.motion_of_scene)
    return loose - _carried(problem, mode) if loose else loose


def _carried(problem: Problem, mode: frozenset[Fact]) -> frozenset[str]:
    """What follows something by the poses that a mode keeps; what is fixed to the scene is always the leader."""
    world, bodies, kept = problem.world, problem.world.bodies, kept_pairs(problem, mode)
    fixed = {name for pair in kept for name in pair if name in bodies and not bodies[name].movable}
    pairs = [(b, a) if b in fixed else (a, b) for a, b in kept]
    return frozenset(world.owner(own) for leader, own in pairs if _carries(problem, leader, own, leader in fixed))


def _carries(problem: Problem, leader: str, own: str, fixed: bool) -> bool:
    """Whether what `leader` holds of a module takes its frame along, in whichever order the text names the two. A hand
    at the end of joints may as well hold the leader, and does where that could not carry a robot: a body that moves, or
    a part behind joints without drives. What is held behind such joints itself, as a door is by its knob, stays."""
    end, other = problem.world.effector(own), problem.world.effector(leader)
    if end is None or end[1].joint < 0:
        return True
    if not _drives(end[0]):
        return False
    if other is None:
        return fixed
    return other[1].joint < 0 or _drives(other[0])


def _drives(module: Module) -> bool:
    return any(not joint.passive for joint in module.type.joints)
