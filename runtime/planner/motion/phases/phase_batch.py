"""Phases of one structure, stacked: their joint problems and the clearances that are asked of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .....compiler.ir import World
from .....compiler.motion.collision import PhaseContacts
from ....geometry.splines import spline_weights
from ....skeleton import Array, Configuration
from ..end_conditions import swept_weights
from .batch_kinematics import Indices
from .bearing import PhaseLoads
from .contact_margins import share_table
from .exact_check import ExactGeometry, PhaseParts
from .joint_forest import PhaseTree, joint_values
from .phase_geometry import Geometry, Part
from .settings import PHASES


@dataclass(slots=True)
class Joints:
    """Limits, home and speeds `(phases, joints)` of the joints of stacked phases."""

    lower: Array
    upper: Array
    home: Array
    speed: Array
    inset: Array
    step: Array

    def take(self, index: Indices) -> Joints:
        return Joints(*(getattr(self, n)[index] for n in ("lower", "upper", "home", "speed", "inset", "step")))


def _joints(trees: Sequence[PhaseTree], world: World) -> Joints:
    rows = [[world.modules[m].type.joints[j] for m, j in tree.variables] for tree in trees]
    lower, upper, home, speed = (
        np.array([[getattr(j, name) for j in row] for row in rows]).reshape(len(trees), -1)
        for name in ("lower", "upper", "home", "speed")
    )
    inset = np.minimum(PHASES.limit_inset, 0.1 * (upper - lower))
    return Joints(lower, upper, home, speed, inset, np.full(lower.shape, PHASES.greatest_step))


class Looks:
    """The times, counted in slices, at which paths are kept clear while they are optimised: the inner slices, or
    `count` times per slice on the spline, and once more next to either end, where contacts are come to and left.
    `weights` `(times, slices + 1)` take a path there; None for the slices. `shares` tell, per kind of pair, how much
    of the margin is asked then."""

    def __init__(self, slices: int, count: int) -> None:
        times = np.arange(1, slices * count) / count
        if count > 1:
            times = np.array([PHASES.next_to_ends, *times, slices - PHASES.next_to_ends])
        self.shares = share_table(times, slices)
        self.weights: Array | None = None
        if count > 1:
            self.weights = spline_weights(slices, times)


class Batch:
    """Point-to-point problems of phases of one structure.

    `start`, `end` `(phases, joints)` are fixed; a path `(phases, slices + 1, joints)` joins them. `phases` are
    the numbers of the phases. `coarse` is the geometry that the optimiser sees, at the times of `looks`; `exact` the
    true shapes, which accept a path, on the spline that is stored of it: `stored` takes a path to its instants. With
    `closely` the optimiser sees the true shapes, too. Paths give way to `loads`, one for each phase, where there are
    any.
    """

    def __init__(
        self, parts: Sequence[tuple[Part, PhaseParts]], states: Sequence[tuple[Configuration, Configuration]],
        world: World, contacts: Sequence[PhaseContacts], slices: int, margin: float, collisions: bool = True,
    ) -> None:
        self.slices, self.margin = slices, margin
        trees = [coarse.tree for coarse, _ in parts]
        self.phases = np.array([t.phase for t in trees])
        self.joints = _joints(trees, world)
        self.variables = [t.variables for t in trees]
        self.start = np.array([joint_values(t, s) for t, (s, _) in zip(trees, states, strict=True)])
        self.end = np.array([joint_values(t, e) for t, (_, e) in zip(trees, states, strict=True)])
        self.coarse = Geometry([c for c, _ in parts], contacts, world)
        self.stored = swept_weights(slices, PHASES.refinement)
        self.looks = Looks(slices, 1)
        self.closely = False
        self.loads: tuple[PhaseLoads, ...] = ()
        self.exact = ExactGeometry([e for _, e in parts], contacts, self.coarse.kinematics)
        if not collisions:
            self.coarse.ignore_collisions()
            self.exact.ignore_collisions()

    def __len__(self) -> int:
        return len(self.phases)

    def take(self, index: Indices) -> Batch:
        """Some of the phases, possibly repeated."""
        result = object.__new__(Batch)
        result.slices, result.margin, result.stored = self.slices, self.margin, self.stored
        result.looks, result.closely = self.looks, self.closely
        result.loads = tuple(self.loads[i] for i in index) if self.loads else ()
        result.variables = [self.variables[i] for i in index]
        result.phases, result.joints = self.phases[index], self.joints.take(index)
        result.start, result.end = self.start[index], self.end[index]
        result.coarse, result.exact = self.coarse.take(index), self.exact.take(index)
        return result

    def looking(self, count: int) -> Batch:
        """The same phases, but kept clear at `count` times per slice while they are optimised, and closely."""
        result = self.take(np.arange(len(self)))
        result.looks, result.closely = Looks(self.slices, count), True
        return result

    def inner_limits(self) -> tuple[Array, Array]:
        """Between what values `(phases, joints)` joints are kept on the way: within their limits by an inset, but no
        further in than where they start and end."""
        joints = self.joints
        low = np.minimum(joints.lower + joints.inset, np.minimum(self.start, self.end))
        return low, np.maximum(joints.upper - joints.inset, np.maximum(self.start, self.end))

    def with_ends(self, inner: Array) -> Array:
        """The whole path of its inner slices `(phases, slices - 1, joints)`."""
        return np.concatenate([self.start[:, None], inner, self.end[:, None]], axis=1)
