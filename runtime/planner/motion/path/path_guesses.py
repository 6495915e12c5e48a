"""First guesses for paths: joints between switch configurations, everything else carried along by kept relations."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from .....compiler import poses
from .....compiler.ir import Fact, Pose, Problem
from .....compiler.kept_pairs import keeps_pose
from ....geometry.attachments import standing
from ....skeleton import Array, Configuration
from ..keyframes.initial_guesses import effector_pose, put_effector, to_tuple


def object_pose(problem: Problem, name: str, configuration: Configuration) -> Pose:
    """The frame of an effector, module or body in the world."""
    found = problem.world.effector(name)
    if found:
        return effector_pose(found[0], found[1].name, configuration.modules[found[0].name])
    slot = configuration.bodies.get(name)
    return to_tuple((configuration.modules[name] if slot is None else slot)[:7])


class Carried:
    """The relations that a mode keeps, at their values in one configuration."""

    def __init__(self, problem: Problem, mode: Iterable[Fact], reference: Configuration) -> None:
        self.problem = problem
        mode = frozenset(mode)
        self._standing = standing(problem, mode)
        self.links: list[tuple[str, str, Pose]] = []
        for literal in sorted(mode):
            kept = keeps_pose(problem, literal)
            if kept:
                base, follower = (object_pose(problem, name, reference) for name in kept)
                self.links.append((*kept, poses.compose(poses.inverse(base), follower)))

    def _slot(self, name: str) -> str:
        found = self.problem.world.effector(name)
        return found[0].name if found else name

    def settle(self, configuration: Configuration, moving: frozenset[str]) -> None:
        """Move the slots in `moving` as rigid things, in place, so that kept relations hold, outwards from what
        rests or stands still; a relation that closes a loop is left as it comes."""
        placed = ((configuration.modules.keys() | configuration.bodies.keys()) - moving) | self._standing
        grew = True
        while grew:
            grew = False
            for base, follower, relation in self.links:
                a, b = self._slot(base), self._slot(follower)
                if a in placed and b not in placed:
                    target = poses.compose(object_pose(self.problem, base, configuration), relation)
                    self._put(follower, configuration, target)
                    placed = placed | {b}
                    grew = True
                elif b in placed and a not in placed:
                    target = poses.compose(object_pose(self.problem, follower, configuration), poses.inverse(relation))
                    self._put(base, configuration, target)
                    placed = placed | {a}
                    grew = True

    def _put(self, name: str, configuration: Configuration, target: Pose) -> None:
        found = self.problem.world.effector(name)
        if found:
            put_effector(found[0], found[1].name, configuration.modules[found[0].name], target)
        elif name in configuration.modules:
            configuration.modules[name][:7] = target
        else:
            configuration.bodies[name][:] = target


def interpolate(
    problem: Problem, mode: Iterable[Fact], moving: frozenset[str], first: Configuration, last: Configuration,
    slices: int, bump: dict[str, Array] | None = None,
) -> list[Configuration]:  # fmt: skip
    """Configurations 1 … `slices` of a phase: joints along a smooth step from `first` to `last`, plus `bump` times a
    half sine; poses by the kept relations. The last one is `last` itself."""
    carried = Carried(problem, mode, first)
    result = []
    for u in range(1, slices):
        s = u / slices
        weight = s * s * (3 - 2 * s)
        current = first.copy()
        for name, slot in current.modules.items():
            slot[7:] += weight * (last.modules[name][7:] - slot[7:])
            if bump and name in moving:
                slot[7:] += np.sin(np.pi * s) * bump[name]
        carried.settle(current, moving)
        result.append(current)
    return [*result, last]
