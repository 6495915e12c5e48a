"""Phases of one structure, stacked: their joint problems, the penalties that keep them clear, and the swept check."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ....compiler.ir import World
from ....compiler.motion.collision import CHECK_MARGIN, PhaseContacts
from ...skeleton import Array, Configuration
from .geometry import NEVER, Geometry, Part
from .kinematics import Indices
from .tree import PhaseTree, joint_values

REFINEMENT = 10
"""Samples of the swept check per slice."""
EXACT_MARGIN = 1e-3
"""The clearance that accepts two whole shapes, metres; covers need CHECK_MARGIN."""
CONTACT_TOLERANCE = 5e-4
"""How deep two things may press into each other next to a contact that begins or ends, metres."""
LIMIT_INSET = 0.02
"""How far inside their limits joints are kept while a path is optimised, radians or metres."""
GREATEST_STEP = 0.5
"""The largest change of a joint between neighbouring slices, radians."""


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
    turns = np.array([[j.kind == "revolute" for j in row] for row in rows]).reshape(len(trees), -1)
    inset = np.minimum(LIMIT_INSET, 0.1 * (upper - lower))
    return Joints(lower, upper, home, speed, inset, np.where(turns, GREATEST_STEP, np.inf))


class Batch:
    """Point-to-point problems of phases of one structure.

    `start`, `end` `(phases, joints)` are fixed; a path `(phases, slices + 1, joints)` joins them. `phases` are
    the numbers of the phases. `coarse` is the geometry that the optimiser sees, at the slices; `fine` the one that
    accepts a path, `REFINEMENT` times as dense in time and covering the true shapes within CHECK_MARGIN.
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
        times = np.arange(slices + 1.0)
        self.coarse = Geometry(coarse, contacts, world, times, slices)
        self.times = np.arange(slices * REFINEMENT + 1) / REFINEMENT
        self._fine, self._rows = Geometry(fine, contacts, world, self.times, slices), np.arange(len(trees))
        if not collisions:
            self.coarse.ignore_collisions()
            self._fine.ignore_collisions()

    def __len__(self) -> int:
        return len(self.phases)

    def take(self, index: Indices) -> Batch:
        """Some of the phases, possibly repeated."""
        result = object.__new__(Batch)
        result.slices, result.margin, result.times = self.slices, self.margin, self.times
        result.variables = [self.variables[i] for i in index]
        result.phases, result.joints = self.phases[index], self.joints.take(index)
        result.start, result.end = self.start[index], self.end[index]
        result.coarse = self.coarse.take(index)
        result._fine, result._rows = self._fine, self._rows[index]
        return result

    def fine(self, columns: slice) -> Geometry:
        """The geometry that accepts a path, at some of its times; made when asked for, as it is large."""
        return self._fine.take(self._rows, columns)

    def fine_shares(self, first: Indices, second: Indices | None, phase: Indices) -> Array:
        """Shares `(m, times)` of sphere and obstacle, or of pairs when there is no `second`, each in one phase."""
        if second is None:
            return self._fine.pair_share[first, self._rows[phase]]
        return self._fine.obstacle_share[first, second, self._rows[phase]]

    def body_shares(self) -> list[Array]:
        """Shares `(spheres, phases, times)` of the carried bodies, at all fine times."""
        return [share[:, self._rows] for share in self._fine.body_shares]

    def with_ends(self, inner: Array) -> Array:
        """The whole path of its inner slices `(phases, slices - 1, joints)`."""
        return np.concatenate([self.start[:, None], inner, self.end[:, None]], axis=1)


def required(share: Array, exact: NDArray[np.bool_]) -> Array:
    """The clearance of the fine spheres that proves the true shapes apart; next to contacts it fades. `exact` tells
    along the first axis where whole shapes are measured."""
    margin = np.where(exact, EXACT_MARGIN, CHECK_MARGIN).reshape(-1, *[1] * (share.ndim - 1))
    return np.asarray(np.where(share < 1.0, margin * share - CONTACT_TOLERANCE, margin))


@dataclass(slots=True)
class Clash:
    """The worst pair of one phase and by how much its clearance is missed, metres."""

    pair: tuple[str, str]
    amount: float


def excess_clearance(batch: Batch, values: Array, columns: slice) -> Array:
    """How much clearance the fine spheres have beyond what is required, the least per phase, for joint values
    `(phases, times, joints)` at the columns of the batch's fine times."""
    return np.asarray(np.min([least for least, _ in _blocks(batch, values, columns)], axis=0))


def _blocks(batch: Batch, values: Array, columns: slice) -> list[tuple[Array, Array]]:
    """Per kind of pair: the least excess clearance per phase, and all of it."""
    fine = batch.fine(columns)
    obstacles, pairs, bodies = fine.clearances(values)
    exact = fine.exact
    kinds = [
        (obstacles, fine.obstacle_share, exact),
        (pairs, fine.pair_share, exact[fine.pairs].all(axis=1)),
        *zip(bodies, fine.body_shares, (exact[b.meets] for b in fine.bodies), strict=True),
    ]
    result = []
    for clearance, share, whole in kinds:
        excess = clearance - required(share, whole)
        axes = tuple(a for a in range(excess.ndim) if a != excess.ndim - 2)
        result.append((excess.min(axis=axes, initial=np.inf), excess))
    return result


def worst_clash(batch: Batch, phase: int, values: Array, columns: slice) -> Clash:
    """The worst pair of one phase for joint values `(times, joints)`."""
    one = batch.take(np.array([phase]))
    blocks = _blocks(one, values[None], columns)
    kind = int(np.argmin([least[0] for least, _ in blocks]))
    excess = blocks[kind][1]
    entry = tuple(int(i) for i in np.unravel_index(int(excess.argmin()), excess.shape))
    return Clash(one.fine(columns).name_pair(0, kind, entry), float(-excess.min()))


AT_SLICES = slice(None, None, REFINEMENT)


def _departure(points: Array) -> Array:
    """How far points `(…, 3, phases, fine times)` go from where they are at a slice, until another one is nearer:
    `(…, phases, slices + 1)`."""
    times = np.arange(points.shape[-1])
    away = points - points[..., (times + REFINEMENT // 2) // REFINEMENT * REFINEMENT]
    first = np.maximum(times[AT_SLICES] - REFINEMENT // 2, 0)
    return np.asarray(np.sqrt(np.maximum.reduceat((away * away).sum(axis=-3), first, axis=-1)))


def swept_clearance(batch: Batch, values: Array) -> Array:
    """The `excess_clearance` at all fine times. What could not come nearer between the slices than something else
    comes at a slice is measured at the slices only: a distance changes by no more than its spheres move."""
    fine = batch.fine(AT_SLICES)
    points, frames = fine.place(values)
    moved = _departure(points)
    obstacles, pairs = fine.to_others(points[..., AT_SLICES])
    whole, (one, other) = fine.exact[fine.pairs].all(axis=1), fine.pairs.T
    least = np.minimum(
        (obstacles - required(fine.obstacle_share, fine.exact)).min(axis=(0, 1, 3), initial=np.inf),
        (pairs - required(fine.pair_share, whole)).min(axis=(0, 2), initial=np.inf),
    )
    near = (obstacles - moved[:, None]).min(axis=3) - CHECK_MARGIN < least
    a, o, k = np.nonzero(near & (fine.obstacle_share[..., 0] > NEVER))
    excess = fine.shapes.distance_at(points[a, :, k], o, k)[0] - fine.radius[a, 0]
    excess -= required(batch.fine_shares(a, o, k), fine.exact[a])
    np.minimum.at(least, k, excess.min(axis=1))
    near = (pairs - moved[one] - moved[other]).min(axis=2) - CHECK_MARGIN < least
    p, k = np.nonzero(near & (fine.pair_share[..., 0] > NEVER))
    apart = points[one[p], :, k] - points[other[p], :, k]
    excess = np.sqrt((apart * apart).sum(axis=1)) - fine.touching[p, 0]
    np.minimum.at(least, k, (excess - required(batch.fine_shares(p, None, k), whole[p])).min(axis=1))
    for body, clearance, share in zip(fine.bodies, fine.to_bodies(points, frames), batch.body_shares(), strict=True):
        excess = clearance - required(share, fine.exact[body.meets])
        least = np.minimum(least, excess.min(axis=(0, 2), initial=np.inf))
    return np.asarray(least)


@dataclass(slots=True)
class Sweep:
    """The swept check per phase: excess clearance (metres; accepted from 0), how far joint limits are exceeded, and
    how far the largest step between slices exceeds what is allowed (both accepted up to 0)."""

    clearance: Array
    limit: Array
    step: Array

    @property
    def clean(self) -> NDArray[np.bool_]:
        return (self.clearance >= 0.0) & (self.limit <= 0.0) & (self.step <= 0.0)


def sweep(batch: Batch, paths: Array, chunk: int = 4) -> Sweep:
    """Check paths `(phases, slices + 1, joints)` on their clamped cubic splines."""
    from scipy.interpolate import CubicSpline

    values = CubicSpline(np.arange(batch.slices + 1), paths, axis=1, bc_type="clamped")(batch.times)
    joints = batch.joints
    beyond = np.maximum(values - joints.upper[:, None], joints.lower[:, None] - values)
    step = np.abs(np.diff(paths, axis=1)) - joints.step[:, None]
    clearance = np.concatenate([
        swept_clearance(batch.take(index), values[index])
        for index in (np.arange(k, min(k + chunk, len(batch))) for k in range(0, len(batch), chunk))
    ])
    return Sweep(clearance, beyond.max(axis=(1, 2), initial=-np.inf), step.max(axis=(1, 2), initial=-np.inf))
