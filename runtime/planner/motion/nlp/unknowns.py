"""Where the unknowns of a motion program lie: one slot per slice and moving thing, aliased where nothing can move.

The vector z of a program is its constants followed by its unknowns. A slot is a stretch of z: a module's pose and
joint values `(7 + n,)` or a body's pose `(7,)`. Joints that follow others have no unknowns of their own: where a slot
is unknown, their places are those of their leaders; those of joints that keep their values are the ones of the slice
before. Slice 0 is the state before the first phase.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from .....compiler.distinct import distinct
from .....compiler.ir import ModuleType, World
from ....geometry.transforms import coupled
from ....skeleton import Array, BodyPoses, Configuration, fixed_poses, movable

Indices = NDArray[np.int64]
ORIGIN = -1
"""The slice of the given start, also where slice 0 is unknown."""


def followed(type_: ModuleType) -> bool:
    """Whether some joint of a module follows another one."""
    return any(j.follows is not None for j in type_.joints)


def _leading(type_: ModuleType) -> Indices:
    """For each entry of a module's slot itself, or that of the joint that it follows."""
    joints = [i if j.follows is None else j.follows.leader for i, j in enumerate(type_.joints)]
    return np.array([*range(7), *(7 + i for i in joints)])


class UnknownsLayout:
    """Offsets of every slot in z. Unknowns are ordered by slice, then in the order of `names`. What `pinned` holds in a
    slice is given, not unknown."""

    def __init__(self, world: World, start: Configuration, pinned: Mapping[int, Configuration] | None = None) -> None:
        modules = [(m.name, start.modules[m.name]) for m in world.modules.values()]
        bodies = [(name, start.bodies[name]) for name in movable(world)]
        parts = modules + bodies
        self.names = [name for name, _ in parts]
        self.sizes = {name: len(value) for name, value in parts}
        self._types = {m.name: m.type for m in world.modules.values()}
        self._leaders = {name: _leading(m.type) for name, m in world.modules.items() if followed(m.type)}
        self._places: dict[int, Indices] = {}
        self.modules = [name for name, _ in modules]
        self.bodies = [name for name, _ in bodies]
        self.resting = _resting(world, start)
        self._pinned: dict[int, dict[str, int]] = {}
        values: list[Array] = []
        at = 0
        for slice_, configuration in [(0, start), *sorted((pinned or {}).items())]:
            self._pinned[slice_] = {}
            for name in self.names:
                value = configuration.modules.get(name, configuration.bodies.get(name))
                if value is not None:
                    self._pinned[slice_][name] = at
                    values.append(value)
                    at += self.sizes[name]
        self.constants: Array = np.concatenate([np.zeros(0), *values])
        self.first_unknown = at
        self.end = at
        self.slices: list[dict[str, int]] = [dict(self._pinned[0])]

    def _allocate(
        self, offsets: dict[str, int], free: Iterable[str], held: Mapping[str, frozenset[int]] = MappingProxyType({})
    ) -> None:
        chosen = frozenset(free)
        for name in self.names:
            if name in chosen:
                places = self._spread(name, held.get(name, frozenset()))
                size = self.sizes[name] if places is None else len(distinct(places[places >= self.end]))
                if not size:
                    continue
                offsets[name] = self.end
                if places is not None:
                    self._places[self.end] = places
                self.end += size

    def _spread(self, name: str, held: frozenset[int]) -> Indices | None:
        """The places of a slot that begins at the end of z; None where they follow each other."""
        leaders = self._leaders.get(name)
        if leaders is None and not held:
            return None
        entries = np.arange(self.sizes[name]) if leaders is None else leaders
        kept = np.isin(entries, list(held))
        own = distinct(entries[~kept])
        before = self.slot(len(self.slices) - 1, name)
        return np.where(kept, before[entries], self.end + np.searchsorted(own, entries))

    def joints(self, name: str) -> Indices:
        """The entries of a module's slot that are values of joints which follow no other."""
        leaders = self._leaders.get(name)
        return np.arange(7, self.sizes[name]) if leaders is None else distinct(leaders)[7:]

    def free_start(self, free: Iterable[str], held: Mapping[str, frozenset[int]]) -> None:
        """Make these slots of slice 0 unknowns too, but for the entries that are `held`; before any slice is added."""
        self._allocate(self.slices[0], free, held)

    def add_slice(self, free: Iterable[str], held: Mapping[str, frozenset[int]] = MappingProxyType({})) -> int:
        """Append a slice in which `free` have slots of their own and all else is where it was, as are the entries of
        slots that are `held`. Returns its number."""
        offsets, chosen = dict(self.slices[-1]), frozenset(free)
        pinned = self._pinned.get(len(self.slices), {})
        offsets |= {name: at for name, at in pinned.items() if name in chosen}
        self._allocate(offsets, chosen - pinned.keys(), held)
        self.slices.append(offsets)
        return len(self.slices) - 1

    @property
    def unknowns(self) -> int:
        return self.end - self.first_unknown

    def slot(self, slice_: int, name: str) -> Indices:
        """The places in z of one slot."""
        start = self.offset(slice_, name)
        places = self._places.get(start)
        return np.arange(start, start + self.sizes[name]) if places is None else places

    def offset(self, slice_: int, name: str) -> int:
        """Where in z one slot begins."""
        return (self._pinned[0] if slice_ == ORIGIN else self.slices[slice_])[name]

    def is_unknown(self, slice_: int, name: str) -> bool:
        return self.slices[slice_][name] >= self.first_unknown

    def pack(self, configurations: Mapping[int, Configuration]) -> Array:
        """The unknowns that put the given slices where `configurations` say; an aliased slot takes
        the value of the first slice in which it stands."""
        z = np.zeros(self.end)
        for slice_ in sorted(configurations, reverse=True):
            modules, bodies = configurations[slice_].modules, configurations[slice_].bodies
            for name in self.names:
                leaders, value = self._leaders.get(name), modules[name] if name in modules else bodies[name]
                z[self.slot(slice_, name)] = value if leaders is None else value[leaders]
        return z[self.first_unknown :]

    def unpack(self, unknowns: Array, slice_: int) -> Configuration:
        """Where everything is in one slice, quaternions normalised."""
        z = np.concatenate([self.constants, unknowns])
        values = {name: z[self.slot(slice_, name)] for name in self.names}
        for name, value in values.items():
            value[3:7] /= np.linalg.norm(value[3:7])
            if name in self._leaders:
                value[7:] = coupled(self._types[name].joints, value[7:])
        bodies = BodyPoses({name: values[name] for name in self.bodies}, self.resting)
        return Configuration({name: values[name] for name in self.modules}, bodies)


def _resting(world: World, start: Configuration) -> Mapping[str, Array]:
    """Where what never moves is: what all configurations of the scene share, if those are the poses."""
    fixed = fixed_poses(world)
    if isinstance(start.bodies, BodyPoses) and not start.bodies.own.keys() & fixed.keys():
        return start.bodies.shared
    return {name: start.bodies[name] for name in fixed}
