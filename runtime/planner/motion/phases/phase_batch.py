"""Phases of one structure, stacked: their joint problems and the clearances that are asked of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .....compiler.ir import World
from .....compiler.motion.collision import PhaseContacts
from ....geometry.splines import spline_weights
from ....skeleton import Array, Configuration
from .batch_kinematics import Indices
from .contact_margins import required_table, share_table
from .joint_forest import PhaseTree, joint_values
from .phase_geometry import Geometry, Part
from .proximity import close

REFINEMENT = 10
"""Samples of the swept check per slice."""
LIMIT_INSET = 0.02
"""How far inside their limits joints are kept while a path is optimised, radians or metres."""
BEYOND = 2e-3
"""How much more clearance than required the fine spheres aim at, metres."""
GREATEST_STEP = 0.5
"""The largest change of a joint between neighbouring slices, radians or metres."""


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
    inset = np.minimum(LIMIT_INSET, 0.1 * (upper - lower))
    return Joints(lower, upper, home, speed, inset, np.full(lower.shape, GREATEST_STEP))


class Looks:
    """The times, counted in slices, at which paths are kept clear while they are optimised: the inner slices, or
    `count` times per slice on the spline. `weights` `(times, slices + 1)` take a path there; None for the slices.
    `shares` and `required` tell, per kind of pair, what is asked of the optimiser's and of the fine spheres then."""

    def __init__(self, slices: int, count: int) -> None:
        times = np.arange(1, slices * count) / count
        self.shares = share_table(times, slices)
        self.required = required_table(times, slices)[0] + BEYOND
        self.weights: Array | None = None
        if count > 1:
            self.weights = spline_weights(slices, times)


class Batch:
    """Point-to-point problems of phases of one structure.

    `start`, `end` `(phases, joints)` are fixed; a path `(phases, slices + 1, joints)` joins them. `phases` are
    the numbers of the phases. `coarse` is the geometry that the optimiser sees, at the times of `looks`; `fine` the one
    that accepts a path, at `times`, `REFINEMENT` per slice, and covering the true shapes within CHECK_MARGIN.
    `required` is the clearance asked of it then, as `shares.required_table`. `fading`, when it is there, holds the fine
    spheres that the optimiser sees, too.
    """

    def __init__(
        self, parts: Sequence[tuple[Part, Part]], states: Sequence[tuple[Configuration, Configuration]],
        world: World, contacts: Sequence[PhaseContacts], slices: int, margin: float, collisions: bool = True,
    ) -> None:
        self.slices, self.margin = slices, margin
        trees = [coarse.tree for coarse, _ in parts]
        self.phases = np.array([t.phase for t in trees])
        self.joints = _joints(trees, world)
        self.variables = [t.variables for t in trees]
        self.start = np.array([joint_values(t, s) for t, (s, _) in zip(trees, states, strict=True)])
        self.end = np.array([joint_values(t, e) for t, (_, e) in zip(trees, states, strict=True)])
        coarse, fine = [c for c, _ in parts], [f for _, f in parts]
        self.coarse = Geometry(coarse, contacts, world)
        self.times = np.arange(slices * REFINEMENT + 1) / REFINEMENT
        self.required = required_table(self.times, slices)
        self.looks = Looks(slices, 1)
        self.fading: Geometry | None = None
        self._fine, self._rows = Geometry(fine, contacts, world), np.arange(len(trees))
        if not collisions:
            self.coarse.ignore_collisions()
            self._fine.ignore_collisions()

    def __len__(self) -> int:
        return len(self.phases)

    def take(self, index: Indices) -> Batch:
        """Some of the phases, possibly repeated."""
        result = object.__new__(Batch)
        result.slices, result.margin, result.times = self.slices, self.margin, self.times
        result.required, result.looks = self.required, self.looks
        result.variables = [self.variables[i] for i in index]
        result.phases, result.joints = self.phases[index], self.joints.take(index)
        result.start, result.end = self.start[index], self.end[index]
        result.coarse = self.coarse.take(index)
        result._fine, result._rows = self._fine, self._rows[index]
        result.fading = None if self.fading is None else self.fading.take(index)
        return result

    def looking(self, count: int) -> Batch:
        """The same phases, but kept clear at `count` times per slice while they are optimised, and with the fine
        spheres of what begins or ends to touch something."""
        result = self.take(np.arange(len(self)))
        result.looks, result.fading = Looks(self.slices, count), self.fine.fading()
        return result

    @property
    def fine(self) -> Geometry:
        """The geometry that accepts a path; made when asked for, as it is large."""
        return self._fine.take(self._rows)

    def with_ends(self, inner: Array) -> Array:
        """The whole path of its inner slices `(phases, slices - 1, joints)`."""
        return np.concatenate([self.start[:, None], inner, self.end[:, None]], axis=1)


@dataclass(slots=True)
class Clash:
    """The worst pair of one phase and by how much its clearance is missed, metres."""

    pair: tuple[str, str]
    amount: float


def blocked(batch: Batch, poses: Array, columns: slice) -> NDArray[np.bool_]:
    """`(phases,)` whether the fine spheres miss what is required, for joint values `(phases, times, joints)` at the
    columns of the batch's fine times."""
    required = batch.required[..., columns]
    result = np.zeros(len(batch), bool)
    for found in close(batch.fine, poses, float(required.max())):
        result[found.phase[found.missed(required) > 0.0]] = True
    return result


def worst_clash(batch: Batch, phase: int, values: Array, columns: slice) -> Clash:
    """The worst pair of one phase for joint values `(times, joints)`; its amount is 0 where nothing is missed."""
    fine, required = batch.take(np.array([phase])).fine, batch.required[..., columns]
    worst = Clash(("", ""), 0.0)
    for found in close(fine, values[None], float(required.max())):
        missed = found.missed(required)
        if missed.max(initial=0.0) > worst.amount:
            entry = int(missed.argmax())
            pair = fine.name_pair(0, found.block, int(found.row[entry]), int(found.column[entry]))
            worst = Clash(pair, float(missed[entry]))
    return worst
