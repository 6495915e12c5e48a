"""Joints that turn more than once around: of all whole turns that leave a posture alone, those of the shortest way."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np

from .....compiler.ir import JointKind, Module, Problem
from ....skeleton import Array, Configuration

TURN = 2.0 * math.pi
STILL = 1e-9
"""Radians: a joint that moves less rests."""


def unwound(problem: Problem, switches: Sequence[Configuration]) -> list[Configuration]:
    """The same poses at all switches, the first as it is, with joints that turn as little as they can between them;
    those that rest between two switches still do."""
    found = [c.copy() for c in switches]
    for name, module in problem.world.modules.items():
        for index in _turning(module):
            values = np.array([c.modules[name][7 + index] for c in switches])
            joint = module.type.joints[index]
            for c, turns in zip(found, _turns(values, joint.lower, joint.upper), strict=True):
                if turns:
                    c.modules[name][7 + index] += turns * TURN
    return found


def _turning(module: Module) -> list[int]:
    """The joints that have more than one value for some posture, and that move on their own."""
    joints = module.type.joints
    leaders = {j.follows.leader for j in joints if j.follows is not None}
    return [
        k for k, j in enumerate(joints)
        if j.kind == JointKind.REVOLUTE and j.upper - j.lower >= TURN and j.follows is None and k not in leaders
    ]  # fmt: skip


def _turns(values: Array, lower: float, upper: float) -> list[int]:
    """Whole turns to add to `values` `(K,)`, none to the first, for the least sum of ways from one to the next."""
    best = {0: (0.0, [0])}
    for before, value in itertools.pairwise(values):
        rests = abs(value - before) < STILL
        lo, hi = math.ceil((lower - value) / TURN), math.floor((upper - value) / TURN)
        here: dict[int, tuple[float, list[int]]] = {}
        for turns in {*range(max(lo, -2), min(hi, 2) + 1), 0}:
            came = [
                (cost + abs(value + turns * TURN - before - k * TURN), way) for k, (cost, way) in best.items()
                if not rests or k == turns
            ]  # fmt: skip
            if came:
                cost, way = min(came, key=lambda c: (c[0], c[1]))
                here[turns] = cost, [*way, turns]
        best = here
        if not best:
            return [0] * len(values)
    return min(best.values(), key=lambda c: (c[0], [abs(k) for k in c[1]]))[1]
