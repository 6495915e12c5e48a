"""Rows that keep loads in closed loops within strengths: the worst ratio of the best share of loads is at most 1."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from .....compiler.ir import Fact, Joint, Problem
from .....compiler.physics.frames import Poses, poses
from .....compiler.physics.least_ratio import Share
from .....compiler.physics.loops import ratios_of, shares
from .....compiler.physics.statics import hanging
from .....compiler.physics.structure import structure
from ....geometry.transforms import coupled
from ....skeleton import Array
from .row_groups import Chosen, RowLabel
from .settings import SOLVER
from .unknowns import Indices, UnknownsLayout


class LoopGroup:
    """One row for each of some slices with the same mode, whose joints move: its worst ratio, which a small convex
    program finds, less 1. It changes as its rows do under the share that is best (envelope theorem)."""

    kind = "inequality"
    scale = 1.0

    def __init__(
        self, problem: Problem, mode: frozenset[Fact], layout: UnknownsLayout, slices: Sequence[int], safety: float,
        labels: Sequence[RowLabel],
    ) -> None:  # fmt: skip
        self._problem, self._safety, self._labels = problem, safety, labels
        self._built = structure(problem, mode)
        self._names = list(dict.fromkeys(e.child[0] for e in self._built.edges))
        self._sizes = np.cumsum([layout.sizes[name] for name in self._names])[:-1]
        self._resting = {e.place: layout.resting[e.place] for e in self._built.all if e.place in layout.resting}
        self._places = np.stack([np.concatenate([layout.slot(t, name) for name in self._names]) for t in slices])
        self._last: tuple[bytes, list[Share]] = (b"", [])

    @property
    def shape(self) -> tuple[int, int]:
        return len(self._places), 1

    def label(self, instance: int) -> RowLabel:
        return self._labels[instance]

    def residuals(self, z: Array) -> Array:
        return np.array([[share.ratio - 1.0] for share in self._shares(z)])

    def jacobians(self, z: Array, chosen: Chosen) -> tuple[Array, Indices]:
        found = np.arange(len(self._places))[chosen]
        known, places = self._shares(z), self._places[chosen]
        values, width = z[places], places.shape[1]
        varied = values[:, None] + SOLVER.load_difference * np.concatenate([np.zeros((1, width)), np.eye(width)])
        at = self._poses(varied.reshape(-1, width))
        best = [known[k] for k in found for _ in range(width + 1)]
        hung = hanging(self._problem, self._built, at)
        ratios = ratios_of(self._problem, self._built, at, hung, self._safety, best).reshape(len(found), width + 1)
        return (ratios[:, None, 1:] - ratios[:, None, :1]) / SOLVER.load_difference, places

    def curvature(self, z: Array, weights: Array) -> list[tuple[Array, Indices]]:
        return []

    def span(self) -> Indices:
        return self._places

    def _shares(self, z: Array) -> list[Share]:
        values = z[self._places]
        if self._last[0] != values.tobytes():
            at = self._poses(values)
            hung = hanging(self._problem, self._built, at)
            self._last = values.tobytes(), shares(self._problem, self._built, at, hung, self._safety)
        return self._last[1]

    def _poses(self, values: Array) -> Poses:
        world, count = self._problem.world, len(values)
        slots = dict(zip(self._names, np.split(values, self._sizes, axis=1), strict=True))
        modules = {n: _led(world.modules[n].type.joints, rows) for n, rows in slots.items() if n in world.modules}
        bodies = {n: np.repeat(pose[None], count, axis=0) for n, pose in self._resting.items()}
        bodies |= {n: rows for n, rows in slots.items() if n not in modules}
        at = poses(self._problem, modules, bodies)
        moved = frozenset((n, k) for n in modules for k in range(len(world.modules[n].type.joints)))
        return replace(at, moved=moved)


def _led(joints: Sequence[Joint], rows: Array) -> Array:
    """Slots `(T, 7 + n)` in which joints that follow others do so."""
    return np.concatenate([rows[:, :7], coupled(joints, rows[:, 7:])], axis=1)
