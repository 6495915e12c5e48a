"""Which pairs must keep clear in which slice: scene, self, module to module, carried bodies; contacts are exempt."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from ..compiler.collision import Pair, pair, self_pairs
from ..compiler.ir import Problem
from .clearance import ClearanceGroup, Cloud, Obstacles
from .groups import Group, Label
from .layout import Indices, Layout
from .skeleton import Array

Margin = Callable[[Pair], float | None]
"""The distance that two objects must keep in a slice; None when they may touch."""


@dataclass(slots=True)
class _Rows:
    """Pairs of numbers, the distances to keep, and the numbers of their labels."""

    first: list[Indices] = field(default_factory=list)
    second: list[Indices] = field(default_factory=list)
    wanted: list[Array] = field(default_factory=list)
    tags: list[Indices] = field(default_factory=list)

    def group(self, cloud: Cloud, obstacles: Obstacles | None, labels: list[Label]) -> ClearanceGroup | None:
        if not self.first:
            return None
        return ClearanceGroup(
            cloud, obstacles, np.concatenate(self.first), np.concatenate(self.second), np.concatenate(self.wanted),
            np.concatenate(self.tags), labels,
        )  # fmt: skip


class Collisions:
    """Collects the collision rows of a layout's slices."""

    def __init__(self, problem: Problem, layout: Layout) -> None:
        self.problem = problem
        self.layout = layout
        self.cloud = Cloud(problem, layout)
        self.obstacles = Obstacles()
        self._labels: list[Label] = []
        self._against_boxes = _Rows()
        self._against_spheres = _Rows()
        self._grids: dict[tuple[int, int], tuple[Indices, Indices]] = {}

    def add_slice(self, slice_: int, phase: int, margin: Margin, before: int | None = None) -> None:
        """Keep what moves in a slice clear. Slots that are those of slice `before` have been looked at there."""
        layout, world = self.layout, self.problem.world
        names = [
            n for n in layout.names
            if n in world.modules or layout.is_unknown(slice_, n)
        ]  # fmt: skip
        fresh = {
            n for n in names
            if layout.is_unknown(slice_, n)
            and (before is None or layout.slices[before][n] != layout.slices[slice_][n])
        }  # fmt: skip
        for name in names:
            if name in fresh:
                for body in world.bodies.values():
                    if body.name not in names:
                        self._scene(slice_, phase, name, body.name, margin)
                if name in world.modules:
                    self._self(slice_, phase, name, margin)
        for i, a in enumerate(names):
            for b in names[i + 1 :]:
                if a in fresh or b in fresh:
                    self._spheres(slice_, phase, a, b, margin)

    def _tag(self, phase: int, kind: str, a: str, b: str) -> int:
        self._labels.append(Label(phase, (kind, a, b), ("m",)))
        return len(self._labels) - 1

    def _grid(self, a: int, b: int) -> tuple[Indices, Indices]:
        if (a, b) not in self._grids:
            self._grids[a, b] = (np.repeat(np.arange(a), b), np.tile(np.arange(b), a))
        return self._grids[a, b]

    def _runs(self, name: str) -> list[tuple[str, Indices]]:
        """The spheres of a thing by the object that they belong to."""
        owners = self.cloud.owners(name)
        return [
            (owner, np.array([i for i, o in enumerate(owners) if o == owner])) for owner in dict.fromkeys(owners)
        ]

    def _scene(self, slice_: int, phase: int, name: str, body: str, margin: Margin) -> None:
        pose = self.layout.resting.get(body)
        if pose is None:
            pose = self.layout.constants[self.layout.slot(slice_, body)]
        boxes = self.obstacles.add(self.problem.world.bodies[body], pose)
        spheres = self.cloud.spheres(slice_, name)
        for owner, members in self._runs(name):
            self._rows(self._against_boxes, spheres[members], boxes, phase, (owner, body), margin)

    def _spheres(self, slice_: int, phase: int, a: str, b: str, margin: Margin) -> None:
        first, second = self.cloud.spheres(slice_, a), self.cloud.spheres(slice_, b)
        for owner, members in self._runs(a):
            for other, others in self._runs(b):
                self._rows(
                    self._against_spheres, first[members], second[others], phase, (owner, other), margin
                )  # fmt: skip

    def _rows(
        self, rows: _Rows, first: Indices, second: Indices, phase: int, objects: Pair, margin: Margin
    ) -> None:  # fmt: skip
        wanted = margin(pair(*objects))
        if wanted is None:
            return
        left, right = self._grid(len(first), len(second))
        rows.first.append(first[left])
        rows.second.append(second[right])
        rows.wanted.append(np.full(len(left), wanted))
        rows.tags.append(np.full(len(left), self._tag(phase, "collision", *objects)))

    def _self(self, slice_: int, phase: int, name: str, margin: Margin) -> None:
        pairs = np.array(self_pairs(self.problem.world.modules[name].type), dtype=np.int64).reshape(-1, 2)
        wanted = margin((name, name))
        if not len(pairs) or wanted is None:
            return
        spheres = self.cloud.spheres(slice_, name)
        rows = self._against_spheres
        rows.first.append(spheres[pairs[:, 0]])
        rows.second.append(spheres[pairs[:, 1]])
        rows.wanted.append(np.full(len(pairs), wanted))
        rows.tags.append(np.full(len(pairs), self._tag(phase, "self", name, name)))

    def groups(self) -> list[ClearanceGroup]:
        """Sphere–box and sphere–sphere rows; none takes part before the first `refresh`."""
        found = (
            self._against_boxes.group(self.cloud, self.obstacles, self._labels),
            self._against_spheres.group(self.cloud, None, self._labels),
        )
        return [g for g in found if g]


def refresh(groups: list[ClearanceGroup], z: Array) -> bool:
    """Take in the pairs that are near at z; whether one that was left out is violated."""
    return any([group.refresh(z) for group in groups])


__all__ = ["Collisions", "Group", "Margin", "refresh"]
