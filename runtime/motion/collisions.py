"""Which pairs must keep clear in which slice: scene, self, module to module, carried bodies; contacts are exempt."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ...compiler.ir import Problem
from ...compiler.motion.collision import Pair
from ...compiler.motion.pairs import self_pairs
from ..skeleton import Array
from .clearance import ClearanceGroup, Cloud, Obstacles
from .groups import Label
from .layout import Indices, Layout


@dataclass(frozen=True, slots=True)
class Margins:
    """The distance that objects must keep in a slice: `usual` metres, but for some pairs another one, or, with None,
    they may touch."""

    usual: float
    special: Mapping[Pair, float | None]


@dataclass(slots=True)
class _Rows:
    """Pairs of numbers, the distances to keep, and (phase, object, object) of each."""

    first: list[Indices] = field(default_factory=list)
    second: list[Indices] = field(default_factory=list)
    wanted: list[Array] = field(default_factory=list)
    tags: list[Indices] = field(default_factory=list)


class Labels:
    """Labels of collision rows, made when asked for from (phase, object number, object number)."""

    def __init__(self) -> None:
        self.names: list[str] = []
        self._numbers: dict[str, int] = {}

    def number(self, name: str) -> int:
        """The number of an object."""
        if name not in self._numbers:
            self._numbers[name] = len(self.names)
            self.names.append(name)
        return self._numbers[name]

    def label(self, tag: Indices) -> Label:
        """A pair within one module speaks for "self", any other for "collision"."""
        phase, a, b = (int(t) for t in tag)
        first, second = self.names[a], self.names[b]
        same = first.partition(".")[0] == second.partition(".")[0]
        return Label(phase, ("self" if same else "collision", first, second), ("m",))


class Collisions:
    """Collects the collision rows of a layout's slices."""

    def __init__(self, problem: Problem, layout: Layout) -> None:
        self.problem = problem
        self.layout = layout
        self.cloud = Cloud(problem, layout)
        self.obstacles = Obstacles()
        self._labels = Labels()
        self._against_boxes = _Rows()
        self._against_spheres = _Rows()
        self._owners: dict[str, Indices] = {}
        self._scenes: dict[tuple[tuple[str, int], ...], tuple[Indices, Indices]] = {}

    def add_slice(self, slice_: int, phase: int, margins: Margins, before: int | None = None) -> None:
        """Keep what moves in a slice clear. Slots that are those of slice `before` have been looked at there."""
        layout, world = self.layout, self.problem.world
        names = [n for n in layout.names if n in world.modules or layout.is_unknown(slice_, n)]
        fresh = [
            n for n in names
            if layout.is_unknown(slice_, n)
            and (before is None or layout.slices[before][n] != layout.slices[slice_][n])
        ]  # fmt: skip
        offsets = layout.slices[slice_]
        boxes, box_owners = self._scene(tuple((b, offsets.get(b, -1)) for b in world.bodies if b not in names))
        for name in fresh:
            spheres, owners = self.cloud.spheres(slice_, name), self._owners_of(name)
            self._grid(self._against_boxes, phase, margins, (spheres, owners), (boxes, box_owners))
            if name in world.modules:
                pairs = np.array(self_pairs(world.modules[name].type), dtype=np.int64).reshape(-1, 2)
                first, second = pairs[:, 0], pairs[:, 1]
                self._add(
                    self._against_spheres, phase, margins,
                    (spheres[first], owners[first]), (spheres[second], owners[second]),
                )  # fmt: skip
        for i, a in enumerate(names):
            for b in names[i + 1 :]:
                if a in fresh or b in fresh:
                    self._grid(
                        self._against_spheres, phase, margins,
                        (self.cloud.spheres(slice_, a), self._owners_of(a)),
                        (self.cloud.spheres(slice_, b), self._owners_of(b)),
                    )  # fmt: skip

    def _owners_of(self, name: str) -> Indices:
        if name not in self._owners:
            self._owners[name] = np.array([self._labels.number(o) for o in self.cloud.owners(name)])
        return self._owners[name]

    def _scene(self, bodies: tuple[tuple[str, int], ...]) -> tuple[Indices, Indices]:
        """The rounded boxes of all bodies that rest at known places, by their names and places in z (-1: those that
        never move), and the bodies' numbers."""
        if bodies not in self._scenes:
            numbers, owners = [np.zeros(0, dtype=np.int64)], [np.zeros(0, dtype=np.int64)]
            for name, place in bodies:
                fixed = place < 0
                pose = self.layout.resting[name] if fixed else self.layout.constants[place : place + 7]
                found = self.obstacles.add(self.problem.world.bodies[name], place, pose)
                numbers.append(found)
                owners.append(np.full(len(found), self._labels.number(name)))
            self._scenes[bodies] = (np.concatenate(numbers), np.concatenate(owners))
        return self._scenes[bodies]

    def _grid(
        self, rows: _Rows, phase: int, margins: Margins, a: tuple[Indices, Indices], b: tuple[Indices, Indices]
    ) -> None:
        """Every one of `a` against every one of `b`; each is numbers and owners."""
        left = np.repeat(np.arange(len(a[0])), len(b[0]))
        right = np.tile(np.arange(len(b[0])), len(a[0]))
        self._add(rows, phase, margins, (a[0][left], a[1][left]), (b[0][right], b[1][right]))

    def _add(
        self, rows: _Rows, phase: int, margins: Margins, a: tuple[Indices, Indices], b: tuple[Indices, Indices]
    ) -> None:
        if not len(a[0]):
            return
        wanted = np.full(len(a[0]), margins.usual)
        for (one, other), margin in margins.special.items():
            i, j = self._labels.number(one), self._labels.number(other)
            met = ((a[1] == i) & (b[1] == j)) | ((a[1] == j) & (b[1] == i))
            wanted[met] = -np.inf if margin is None else margin
        kept = np.isfinite(wanted)
        rows.first.append(a[0][kept])
        rows.second.append(b[0][kept])
        rows.wanted.append(wanted[kept])
        rows.tags.append(np.stack([np.full(int(kept.sum()), phase), a[1][kept], b[1][kept]], axis=1))

    def groups(self) -> list[ClearanceGroup]:
        """Sphere–box and sphere–sphere rows; none takes part before the first `refresh`."""
        found = []
        for rows, obstacles in ((self._against_boxes, self.obstacles), (self._against_spheres, None)):
            if rows.first:
                found.append(ClearanceGroup(
                    self.cloud, obstacles, np.concatenate(rows.first), np.concatenate(rows.second),
                    np.concatenate(rows.wanted), np.concatenate(rows.tags), self._labels.label,
                ))  # fmt: skip
        return found


def refresh(groups: list[ClearanceGroup], z: Array) -> bool:
    """Take in the pairs that are near at z; whether one that was left out is violated."""
    return any([group.refresh(z) for group in groups])
