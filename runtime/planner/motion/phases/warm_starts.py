"""Paths that phases keep when others of their skeleton are solved anew between other switches."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from .....compiler.ir import World
from ....skeleton import Array, BoundResult, Configuration, PhasePath, may_differ
from .joint_forest import PhaseTree
from .settings import PHASES
from .smoothing import cost_matrix


def taken_over(
    known: BoundResult | None, trees: Sequence[PhaseTree], configurations: Sequence[Configuration]
) -> dict[int, Array]:
    """The joint values `(times, joints)` of the phases that have a path in `known` between the same switches.
    `known` may be of fewer phases."""
    if known is None or not known.paths:
        return {}
    same = [_alike(a, b) for a, b in zip(known.configurations, configurations, strict=False)]
    failed = {v.phase for v in known.violations}
    return {
        tree.phase: _values(known, tree)
        for tree in trees[: len(known.paths)]
        if same[tree.phase] and same[tree.phase + 1] and tree.phase not in failed
        if _ends_at(known.paths[tree.phase], configurations[tree.phase + 1])
    }


def _ends_at(path: PhasePath, end: Configuration) -> bool:
    """Whether a path was made at all: phases that come after one that has failed may have none."""
    apart = (rows[-1, 7:] - end.modules[name][7:] for name, rows in path.modules.items())
    return all(np.abs(joints).max(initial=0.0) < PHASES.made for joints in apart)


def _alike(one: Configuration, other: Configuration) -> bool:
    """Whether all joints have the same values, and all bodies the same poses but for what poses drift."""
    joints = all(np.array_equal(slot[7:], other.modules[name][7:]) for name, slot in one.modules.items())
    apart = (np.abs(one.bodies[name] - other.bodies[name]).max() for name in may_differ(one, other))
    return joints and all(distance < PHASES.same_pose for distance in apart)


def _values(known: BoundResult, tree: PhaseTree) -> Array:
    modules = known.paths[tree.phase].modules
    rows = len(next(iter(modules.values()))) if modules else 1
    return np.array([modules[module][:, 7 + joint] for module, joint in tree.variables]).reshape(-1, rows).T


def cost_of(world: World, trees: Sequence[PhaseTree], motions: Mapping[int, Array]) -> float:
    """The cost of joint values by phase, as `smoothing.path_cost`."""
    total = 0.0
    for phase, values in motions.items():
        home = [world.modules[module].type.joints[joint].home for module, joint in trees[phase].variables]
        away = values - np.array(home)
        total += 0.5 * float((away * (cost_matrix(len(values) - 1) @ away)).sum()) if home else 0.0
    return total
