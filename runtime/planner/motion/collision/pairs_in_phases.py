"""Which pairs must keep clear in which slice: scene, self, module to module, carried bodies; contacts are exempt."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import field

import numpy as np

from .....compiler.ir import Problem, World
from .....compiler.joint_lines import are_close
from .....compiler.module_parts import own_pairs
from .....compiler.motion.collision import Pair
from .....compiler.part_names import part_names
from .....compiler.remembering import remembered
from .....langs.frozen import dataclass
from ....skeleton import Array, Breach, movable
from ..nlp.row_groups import RowGroup, RowLabel
from ..nlp.unknowns import Indices, UnknownsLayout
from .broad_phase import Blocks, OwnerMargins, Runs
from .clearance_rows import ClearanceGroup, Clearances, Ruler, WishGroup
from .obstacles import Fixed, Obstacles, fixed_obstacles
from .part_frames import Cloud


@dataclass(frozen=True, slots=True)
class Margins:
    """The distance that objects wish to keep in a slice: `usual` metres, but for some pairs another one, or, with None,
    they may touch. What sits next to an effector of a pair in `touching` wishes nothing of the other one of the two,
    or of what sits next to it."""

    usual: float
    special: Mapping[Pair, float | None]
    least: Mapping[Pair, float] = field(default_factory=dict)
    """What some pairs must keep, metres; others must not overlap."""
    touching: frozenset[Pair] = frozenset()


class Labels:
    """The parts of all things, numbered, and labels of collision rows, made when asked for from (phase, part, part)."""

    def __init__(self) -> None:
        self.names: list[str] = []
        """The object that each part belongs to: an effector, or the thing itself."""
        self.of: dict[str, list[int]] = {}
        """The parts of each object …"""
        self.first: dict[str, int] = {}
        """… and the first part of each thing; the others follow."""
        self.parts: list[str] = []
        """How each part is called."""

    def take_in(self, thing: str, objects: list[str], numbered: bool) -> int:
        """The number of the first part of a thing, whose parts belong to `objects`; links are `numbered`."""
        if thing not in self.first:
            self.first[thing] = len(self.names)
            for name in objects:
                self.of.setdefault(name, []).append(len(self.names))
                self.names.append(name)
            self.parts += part_names(thing, objects) if numbered else objects
        return self.first[thing]

    def copy(self) -> Labels:
        """The same, to which more can be added."""
        result = Labels()
        result.names, result.parts, result.first = self.names.copy(), self.parts.copy(), self.first.copy()
        result.of = self.of.copy()
        return result

    def label(self, tag: Indices) -> RowLabel:
        """A pair within one module is a self-collision."""
        phase, a, b = (int(t) for t in tag)
        first, second = self.names[a], self.names[b]
        same = first.partition(".")[0] == second.partition(".")[0]
        kind, parts = Breach.SELF_COLLISION if same else Breach.COLLISION, (self.parts[a], self.parts[b])
        return RowLabel(phase, kind, (first, second), ("m",), parts=parts)


@remembered(4)
def _of_fixed(fixed: Fixed) -> tuple[Labels, Runs]:
    """The labels of bodies that never move, and their parts one by one with them."""
    labels = Labels()
    for name, count in fixed.parts.items():
        labels.take_in(name, [name] * count, False)
    numbers = np.arange(len(labels.names))
    return labels, np.stack([numbers, np.ones_like(numbers), numbers], axis=1)


@remembered(4)
def _solid(world: World) -> tuple[frozenset[str], tuple[str, ...]]:
    """The modules and bodies that can be collided with, and those of the bodies that may move."""
    solid = frozenset([*world.modules, *(b.name for b in world.solids)])
    return solid, tuple(name for name in movable(world) if name in solid)


class Collisions:
    """Collects the collision rows of a layout's slices."""

    def __init__(self, problem: Problem, layout: UnknownsLayout) -> None:
        self.problem = problem
        self.layout = layout
        self.cloud = Cloud(problem, layout)
        self.obstacles = Obstacles(fixed_obstacles(problem.world, layout.resting))
        labels, self._fixed = _of_fixed(self.obstacles.fixed)
        self._labels = labels.copy()
        self._solid, self._loose = _solid(problem.world)
        self._against_rest = Blocks()
        self._among_parts = Blocks()
        self._scenes: dict[tuple[tuple[str, int], ...], Runs] = {}
        self._close: dict[str, list[int]] = {}

    def add_slice(self, slice_: int, phase: int, margins: Margins, before: int | None = None) -> None:
        """Keep what moves in a slice clear. Slots that are those of slice `before` have been looked at there."""
        layout, world = self.layout, self.problem.world
        names = [n for n in layout.names if n in self._solid and (n in world.modules or layout.is_unknown(slice_, n))]
        fresh = [
            n for n in names
            if layout.is_unknown(slice_, n)
            and (before is None or layout.slices[before][n] != layout.slices[slice_][n])
        ]  # fmt: skip
        offsets, taken = layout.slices[slice_], frozenset(names)
        scene = self._scene(tuple((b, offsets[b]) for b in self._loose if b not in taken))
        runs = {name: self._runs(slice_, name) for name in names}
        wanted = self._wanted(margins)
        for name in fresh:
            self._against_rest.grid(phase, runs[name], scene, wanted)
            if name in world.modules:
                self._within(phase, name, runs[name], wanted)
        for i, a in enumerate(names):
            for b in names[i + 1 :]:
                if a in fresh or b in fresh:
                    self._among_parts.grid(phase, runs[a], runs[b], wanted)

    def _runs(self, slice_: int, name: str) -> Runs:
        """The parts of one slot, one by one, and their labels."""
        first, label = self.cloud.first(slice_, name), self._label(name)
        count = len(self.cloud.parts(name))
        ones = np.ones(count, dtype=np.int64)
        return np.stack([first + np.arange(count), ones, label + np.arange(count)], axis=1)

    def _label(self, name: str) -> int:
        """The label of a thing's first part."""
        objects = [f"{name}.{part.effector}" if part.effector else name for part in self.cloud.parts(name)]
        return self._labels.take_in(name, objects, name in self.problem.world.modules)

    def _scene(self, bodies: tuple[tuple[str, int], ...]) -> Runs:
        """The bodies that never move, and those that rest at known places, by their names and places in z."""
        if bodies not in self._scenes:
            found: list[tuple[int, int, int]] = []
            for name, place in bodies:
                pose = self.layout.constants[place : place + 7]
                numbers, label = self.obstacles.add(self.problem.world.bodies[name], place, pose), self._label(name)
                found += [(number, 1, label + k) for k, number in enumerate(numbers)]
            others = np.array(found, dtype=np.int64).reshape(-1, 3)
            self._scenes[bodies] = np.concatenate([self._fixed, others])
        return self._scenes[bodies]

    def _wanted(self, margins: Margins) -> OwnerMargins:
        """The margins of two parts; -inf where they may touch."""
        found: dict[tuple[int, int], tuple[float, float]] = {}
        usual = margins.usual, 0.0
        for one, other in sorted(margins.touching):
            for a in self._next_to(one):
                for b in self._next_to(other):
                    found[a, b] = found[b, a] = 0.0, 0.0
        for (one, other), margin in margins.special.items():
            least = margins.least.get((one, other), 0.0)
            for a in self._labels.of.get(one, ()):
                for b in self._labels.of.get(other, ()):
                    wished = -np.inf if margin is None else min(margin, found.get((a, b), usual)[0])
                    found[a, b] = found[b, a] = wished, least
        return OwnerMargins(margins.usual, found)

    def _next_to(self, name: str) -> list[int]:
        """The labels of the parts at most one joint away from an effector; of a body its own."""
        if name not in self._close:
            found = self.problem.world.effector(name)
            first = self._labels.first.get(found[0].name if found else name)
            if first is None:
                return []
            parts = self.cloud.parts(found[0].name if found else name)
            self._close[name] = [
                first + k for k, p in enumerate(parts)
                if found is None or are_close(found[0].type, found[1].joint, p.joint)
            ]  # fmt: skip
        return self._close[name]

    def _within(self, phase: int, name: str, runs: Runs, wanted: OwnerMargins) -> None:
        """The parts of one module that can meet; they wish no more than they have at home."""
        pairs = own_pairs(self.problem.world.modules[name].type)
        if pairs:
            one, other = (np.array(side) for side in list(zip(*pairs, strict=True))[:2])
            home = np.array([far for _, _, far in pairs])
            first, second = runs[one], runs[other]
            margins = wanted[first[:, 2], second[:, 2]]
            margins[:, 0] = np.minimum(margins[:, 0], home)
            self._among_parts.pairs(phase, first, second, margins)

    def clearances(self) -> list[Clearances]:
        """Of parts and what rests, and among parts; none takes part before the first `refresh`."""
        ruler = Ruler(self.cloud, self.obstacles)
        blocks = ((self._against_rest, self.obstacles.edges()), (self._among_parts, None))
        return [Clearances(ruler, rest, found, self._labels.label) for found, rest in blocks if len(found)]


def rows(clearances: list[Clearances], wish: float | None) -> Iterator[RowGroup]:
    """Their rows, and their wishes of scale `wish`; without, rows hold the margins themselves."""
    for found in clearances:
        yield ClearanceGroup(found, strict=wish is None)
        if wish is not None:
            yield WishGroup(found, wish)


def refresh(clearances: list[Clearances], z: Array) -> bool:
    """Take in the pairs that are near at z; whether one that was left out overlaps."""
    return any([found.refresh(z) for found in clearances])
