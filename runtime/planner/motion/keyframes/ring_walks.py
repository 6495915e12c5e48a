"""Postures of closed rings with joints that have no drives, found by walking along the ring from a posture in which it
is closed: what is shaken seldom closes again, and when it does, often in a posture to which no path leads."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from .....compiler.ir import Fact, Problem
from ....budget import Budget
from ....geometry.drives import ringed
from ....skeleton import Array, Configuration, Skeleton
from ..nlp.augmented_lagrangian import project
from ..settings import MotionSettings
from .keyframe_program import SwitchProgram
from .settings import KEYFRAMES


def passive_rings(problem: Problem, mode: frozenset[Fact]) -> Mapping[str, frozenset[int]]:
    """The joints on closed rings, by module, where some of them has no drive."""
    rings = ringed(problem, mode)
    modules = problem.world.modules
    passive = any(modules[name].type.joints[i].passive for name, joints in rings.items() for i in joints)
    return rings if passive else {}


class _Ring(SwitchProgram):
    """What a phase keeps, without what its switch asks for."""

    def _literals(self) -> None:
        phase = self.phases[0]
        for literal in sorted(self.skeleton.phases[phase].mode):
            self._features.add(literal, "keep", (0, 1), phase)
            self._features.add(literal, "during", (1,), phase)


def walked(
    skeleton: Skeleton, first: int, slices: Sequence[Configuration], settings: MotionSettings,
    random: np.random.Generator, budget: Budget,
) -> list[Configuration]:  # fmt: skip
    """Guesses for the switches of the phases from `first` on, the state before included, with the modules of rings
    where a random walk along these has led. Raises OutOfTime."""
    found = list(slices)
    for at in range(len(found) - 1):
        phase = first + at
        rings = passive_rings(skeleton.problem, skeleton.phases[phase].mode)
        if not rings:
            continue
        there = _walk(_Ring(skeleton, phase, phase, found[at], settings), rings, found[at], random, budget)
        for later in range(at + 1, len(found)):
            found[later] = found[later].copy()
            found[later].modules.update({name: there.modules[name].copy() for name in rings})
    return found


def _walk(
    ring: _Ring, rings: Mapping[str, frozenset[int]], start: Configuration, random: np.random.Generator, budget: Budget
) -> Configuration:
    program, x = ring.loose, ring.pack([start, start])
    ahead = _direction(ring, rings, random)
    for _ in range(int(random.integers(1, KEYFRAMES.walk_steps + 1))):
        there = project(program, x + KEYFRAMES.walk_step * ahead, KEYFRAMES.walk_open / 10, budget)
        moved = there - x
        length = float(np.linalg.norm(moved))
        if program.largest(there) > KEYFRAMES.walk_open or length < KEYFRAMES.walk_slow * KEYFRAMES.walk_step:
            break
        x, ahead = there, moved / length
    return ring.unpack(x)[-1]


def _direction(ring: _Ring, rings: Mapping[str, frozenset[int]], random: np.random.Generator) -> Array:
    """A random direction of the joints of the rings."""
    ahead = np.zeros(ring.layout.unknowns)
    for name, joints in sorted(rings.items()):
        places = ring.layout.slot(1, name)[[7 + i for i in sorted(joints)]] - ring.layout.first_unknown
        own = places[places >= 0]
        ahead[own] = random.normal(size=len(own))
    return np.asarray(ahead / max(float(np.linalg.norm(ahead)), 1e-12))
