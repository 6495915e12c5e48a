"""The share of loads among closed loops that makes the worst ratio of load to strength least.

A convex program: least s + 1e-7/2 |x|² with f · (hung + signs x) <= s, where rows that do not grow give way, dearly.
Its dual active-set method (Goldfarb and Idnani, A numerically stable dual method for solving strictly convex quadratic
programs, Mathematical Programming 27, 1983) is begun with the rows that bind in the sample before; all samples in which
just these bind are found at once.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ...langs.frozen import dataclass
from .frames import Array
from .strength_rows import StrengthRows

Indices = NDArray[np.intp]
PRICES = np.array([1.0, 100.0])
"""What the ratio costs, and beside it by how much a row that does not grow gives way."""
SMALL = 1e-7
"""Weight of the squares of wrenches, 1/N² and 1/(N m)²: keeps what strengths leave open small."""
STIFF = 1e-5
"""Weight of the squares of the ratio and of what gives way: makes the program strictly convex."""
EXACT = 1e-9
"""By how much a row may be missed."""
MISSED = 1e-6
"""The same of rows that are to bind: more tells that they depend on each other."""
DEPENDENT = 1e-12
"""What of a squared normal is left beside others of which it is made up: rounding."""
STEPS = 20
"""Steps for each unknown, at most: some twenty are taken from nothing, four from the sample before."""


@dataclass(frozen=True, slots=True)
class Share:
    """How loops share their loads: the wrenches (6 L,) that close them, about the middle of the structure; the worst
    ratio of load to strength; and what each row weighs in that, negative where its lower side binds."""

    taken: Array
    ratio: float
    weights: Array


def least_ratios(rows: StrengthRows) -> list[Share]:
    """The best share of every sample; no wrenches where nothing states a strength. Those behind a sample in which just
    the same binds are found at once, twice as many whenever all of them were."""
    count = len(rows.hung)
    if not len(rows.edges):
        return [Share(np.zeros(rows.unknowns), 0.0, np.zeros(0))] * count
    found = list[Share]()
    program = _RatioProgram(rows)
    binding, ahead = program.nothing, 1
    while len(found) < count:
        binding, share = program.solved(len(found), binding)
        found.append(share)
        ahead = max(1, ahead // 2)
        while len(found) < count:
            wanted = slice(len(found), min(len(found) + ahead, count))
            more = program.bound_by(binding, wanted)
            found += more
            if len(more) < wanted.stop - wanted.start:
                break
            ahead *= 2
    return found


class _RatioProgram:
    """The program of all samples: normals · unknowns <= bounds, in unknowns scaled so that the weight of every square
    is 1: the wrenches, the ratio, and where some rows do not grow, what these give way. What binds is told by number:
    rows, then their lower sides, then what keeps the ratio and what gives way from falling below 0."""

    def __init__(self, rows: StrengthRows) -> None:
        self._width, self._count = rows.unknowns, len(rows.edges)
        self._eases = 1 if rows.grows.all() else 2
        self._free = np.concatenate([np.zeros(self._width), -PRICES[: self._eases] / math.sqrt(STIFF)])
        self._slopes = rows.slopes() / math.sqrt(SMALL)
        self._hung = rows.told(np.zeros((len(rows.hung), self._width)))
        every, last = np.arange(self._count), np.arange(self._eases)
        self._own = np.where(rows.grows, 0, 1)
        self._above = np.where(rows.both, 0.0, np.inf)
        self._sides = np.concatenate([np.ones(self._count), -np.ones(self._count), np.zeros(self._eases)])
        self._rows = np.concatenate([every, every, 0 * last])
        self._give = np.zeros((len(self._rows), self._eases))
        self._give[np.arange(len(self._rows)), np.concatenate([self._own, self._own, last])] = -1.0 / math.sqrt(STIFF)
        self.nothing = 2 * self._count + last

    def _bounds(self, samples: slice, binding: Indices) -> tuple[Array, Array]:
        """Of what binds the normals `(S, K, n)` and the bounds `(S, K)`."""
        sides, rows = self._sides[binding], self._rows[binding]
        normals = np.empty((samples.stop - samples.start, len(binding), len(self._free)))
        normals[:, :, : self._width] = self._slopes[samples, rows] * sides[:, None]
        normals[:, :, self._width :] = self._give[binding]
        return normals, -sides * self._hung[samples, rows]

    def bound_by(self, binding: Indices, samples: slice) -> list[Share]:
        """The shares of some samples up to the first in which more or less than this binds."""
        normals, bounds = self._bounds(samples, binding)
        try:
            weights = np.linalg.solve(normals @ np.swapaxes(normals, 1, 2), (normals @ self._free - bounds)[..., None])
        except np.linalg.LinAlgError:
            return []
        unknowns, weights = self._free - (np.swapaxes(weights, 1, 2) @ normals)[:, 0], weights[..., 0]
        told = self._hung[samples] + (self._slopes[samples] @ unknowns[:, : self._width, None])[..., 0]
        missed = np.maximum(self._beyond(told, unknowns).max(axis=1) - EXACT, -weights.min(axis=1))
        leading = next((k for k, far in enumerate(missed) if far > 0.0), len(missed))
        return [self._share(binding, unknowns[k], weights[k]) for k in range(leading)]

    def _beyond(self, told: Array, unknowns: Array) -> Array:
        """By how much each side of each row, and each of the last `(…, 2 R + eases)`, is missed where the left sides
        of rows are those `told`."""
        eases = unknowns[..., self._width :] / math.sqrt(STIFF)
        give = eases[..., self._own]
        return np.concatenate([told - give, -told - give - self._above, -eases], axis=-1)

    def solved(self, sample: int, binding: Indices) -> tuple[Indices, Share]:
        """What binds in a sample, and its share, from what may bind. Where rounding ends the steps, the wrenches
        balance all the same: their worst ratio is then not quite the least."""
        binding, unknowns, weights = self._begun(sample, binding)
        for _ in range(STEPS * len(self._free)):
            beyond = self._beyond(self._hung[sample] + self._slopes[sample] @ unknowns[: self._width], unknowns)
            worst = int(beyond.argmax())
            if beyond[worst] <= EXACT:
                break
            try:
                binding, unknowns, weights = self._added(
                    sample, binding, unknowns, weights, worst, float(beyond[worst])
                )
            except np.linalg.LinAlgError:
                break
        return binding, self._share(binding, unknowns, weights)

    def _begun(self, sample: int, binding: Indices) -> tuple[Indices, Array, Array]:
        """From what may bind, those left when one of negative weight after another is taken away."""
        while True:
            held, bounds = (part[0] for part in self._bounds(slice(sample, sample + 1), binding))
            try:
                weights = np.linalg.solve(held @ held.T, held @ self._free - bounds)
            except np.linalg.LinAlgError:
                binding = self.nothing
                continue
            worst, unknowns = int(weights.argmin()), self._free - weights @ held
            if np.abs(held @ unknowns - bounds).max() > MISSED:
                binding = self.nothing
                continue
            if weights[worst] >= 0.0:
                return binding, unknowns, weights
            binding = binding[np.arange(len(binding)) != worst] if len(binding) > 1 else self.nothing

    def _added(
        self, sample: int, binding: Indices, unknowns: Array, weights: Array, new: int, beyond: float
    ) -> tuple[Indices, Array, Array]:
        """One step of the method: what is missed by `beyond` comes to bind, and what it drives out leaves."""
        normals = self._bounds(slice(sample, sample + 1), np.concatenate([binding, [new]]))[0][0]
        held, normal, own = normals[:-1], normals[-1], 0.0
        dependent = DEPENDENT * float(normal @ normal)
        while True:
            back = np.linalg.solve(held @ held.T, held @ normal)
            step = normal - back @ held
            slope = float(step @ normal)
            full = beyond / slope if slope > dependent else math.inf
            leaves, far = _first_out(weights, back, full)
            if full < math.inf:
                unknowns, beyond = unknowns - far * step, beyond - far * slope
            weights, own = weights - far * back, own + far
            if leaves < 0:
                return np.concatenate([binding, [new]]), unknowns, np.concatenate([weights, [own]])
            kept = np.arange(len(binding)) != leaves
            binding, weights, held = binding[kept], weights[kept], held[kept]

    def _share(self, binding: Indices, unknowns: Array, weights: Array) -> Share:
        told = np.zeros(len(self._rows))
        told[binding] = weights
        upper, lower = told[: self._count], told[self._count : 2 * self._count]
        eases = unknowns[self._width :] / math.sqrt(STIFF)
        return Share(unknowns[: self._width] / math.sqrt(SMALL), float(eases @ PRICES[: self._eases]), upper - lower)


def _first_out(weights: Array, back: Array, most: float) -> tuple[int, float]:
    """Which multiplier comes to 0 first along a step, and after how much of it; -1 and `most` where none does
    before."""
    first = -1
    for number, (weight, falls) in enumerate(zip(weights.tolist(), back.tolist(), strict=True)):
        if falls > DEPENDENT and weight < most * falls:
            first, most = number, max(weight / falls, 0.0)
    return first, most
