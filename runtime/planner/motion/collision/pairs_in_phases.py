"""Which pairs must keep clear in which slice: scene, self, module to module, carried bodies; contacts are exempt."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from .....compiler.ir import Problem
from .....compiler.motion.collision import Pair
from .....compiler.motion.pairs import self_pairs
from ....skeleton import Array, Breach
from ..nlp.row_groups import RowLabel
from ..nlp.unknowns import Indices, UnknownsLayout
from .broad_phase import Blocks, Runs
from .clearance_rows import ClearanceGroup, Cloud, Obstacles


@dataclass(frozen=True, slots=True)
class Margins:
    """The distance that objects must keep in a slice: `usual` metres, but for some pairs another one, or, with None,
    they may touch."""

    usual: float
    special: Mapping[Pair, float | None]


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

    def label(self, tag: Indices) -> RowLabel:
        """A pair within one module is a self-collision."""
        phase, a, b = (int(t) for t in tag)
        first, second = self.names[a], self.names[b]
        same = first.partition(".")[0] == second.partition(".")[0]
        return RowLabel(phase, Breach.SELF_COLLISION if same else Breach.COLLISION, (first, second), ("m",))


class Collisions:
    """Collects the collision rows of a layout's slices."""

    def __init__(self, problem: Problem, layout: UnknownsLayout) -> None:
        self.problem = problem
        self.layout = layout
        self.cloud = Cloud(problem, layout)
        self.obstacles = Obstacles()
        self._labels = Labels()
        self._against_boxes = Blocks()
        self._against_spheres = Blocks()
        self._owners: dict[str, Runs] = {}
        self._scenes: dict[tuple[tuple[str, int], ...], Runs] = {}

    def add_slice(self, slice_: int, phase: int, margins: Margins, before: int | None = None) -> None:
        """Keep what moves in a slice clear. Slots that are those of slice `before` have been looked at there."""
        layout, world = self.layout, self.problem.world
        names = [n for n in layout.names if n in world.modules or layout.is_unknown(slice_, n)]
        fresh = [
            n for n in names
            if layout.is_unknown(slice_, n)
            and (before is None or layout.slices[before][n] != layout.slices[slice_][n])
        ]  # fmt: skip
        offsets, taken = layout.slices[slice_], frozenset(names)
        scene = self._scene(tuple((b, offsets.get(b, -1)) for b in world.bodies if b not in taken))
        runs = {name: self._runs(slice_, name) for name in names}
        wanted = self._wanted(margins)
        for name in fresh:
            self._against_boxes.grid(phase, runs[name], scene, wanted)
            if name in world.modules:
                self._within(slice_, phase, name, wanted)
        for i, a in enumerate(names):
            for b in names[i + 1 :]:
                if a in fresh or b in fresh:
                    self._against_spheres.grid(phase, runs[a], runs[b], wanted)

    def _runs(self, slice_: int, name: str) -> Runs:
        """The spheres of one slot, and whom they belong to."""
        if name not in self._owners:
            owners = [self._labels.number(owner) for owner in self.cloud.owners(name)]
            begins = [k for k, owner in enumerate(owners) if k == 0 or owner != owners[k - 1]]
            ends = [*begins[1:], len(owners)]
            found = [(k, end - k, owners[k]) for k, end in zip(begins, ends, strict=False)]
            self._owners[name] = np.array(found, dtype=np.int64).reshape(-1, 3)
        return self._owners[name] + (self.cloud.first(slice_, name), 0, 0)

    def _scene(self, bodies: tuple[tuple[str, int], ...]) -> Runs:
        """The rounded boxes of all bodies that rest at known places, by their names and places in z (-1: those that
        never move)."""
        if bodies not in self._scenes:
            found = []
            for name, place in bodies:
                fixed = place < 0
                pose = self.layout.resting[name] if fixed else self.layout.constants[place : place + 7]
                numbers = self.obstacles.add(self.problem.world.bodies[name], place, pose)
                found.append((numbers[0], len(numbers), self._labels.number(name)))
            self._scenes[bodies] = np.array(found, dtype=np.int64).reshape(-1, 3)
        return self._scenes[bodies]

    def _wanted(self, margins: Margins) -> Array:
        """The distance to keep by the numbers of both owners; -inf where they may touch."""
        special = [(self._labels.number(a), self._labels.number(b), m) for (a, b), m in margins.special.items()]
        count = len(self._labels.names)
        wanted = np.full((count, count), margins.usual)
        for a, b, margin in special:
            wanted[a, b] = wanted[b, a] = -np.inf if margin is None else margin
        return wanted

    def _within(self, slice_: int, phase: int, name: str, wanted: Array) -> None:
        """The spheres of one module that can meet."""
        ends = np.array(self_pairs(self.problem.world.modules[name].type), dtype=np.int64).reshape(-1, 2)
        owners, first = self._owners[name], self.cloud.first(slice_, name)
        each = np.repeat(owners[:, 2], owners[:, 1])
        one, other = (np.stack([first + e, np.ones_like(e), each[e]], axis=1) for e in (ends[:, 0], ends[:, 1]))
        self._against_spheres.pairs(phase, one, other, wanted)

    def groups(self) -> list[ClearanceGroup]:
        """Sphere–box and sphere–sphere rows; none takes part before the first `refresh`."""
        blocks = ((self._against_boxes, self.obstacles), (self._against_spheres, None))
        return [ClearanceGroup(self.cloud, o, found, self._labels.label) for found, o in blocks if len(found)]


def refresh(groups: list[ClearanceGroup], z: Array) -> bool:
    """Take in the pairs that are near at z; whether one that was left out is violated."""
    return any([group.refresh(z) for group in groups])
