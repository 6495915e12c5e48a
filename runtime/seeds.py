"""The random numbers of a run: one tree of NumPy seed sequences, grown from the user's seed."""

from __future__ import annotations

import zlib
from typing import TYPE_CHECKING

from ..langs.frozen import dataclass

if TYPE_CHECKING:
    import numpy as np


@dataclass(frozen=True, slots=True)
class Seed:
    """A node of the tree: the user's seed and the way from the root. A value: equal nodes give equal numbers in any
    process and in any order of asking, nodes with different ways give independent ones."""

    root: int
    way: tuple[int, ...] = ()

    def child(self, *names: str | int) -> Seed:
        """The node below this one that is reached by `names`: what the numbers are for, or counts from 0."""
        return Seed(self.root, (*self.way, *map(_step, names)))

    def random(self) -> np.random.Generator:
        """The numbers of this node, from their beginning."""
        import numpy as np

        return np.random.default_rng(np.random.SeedSequence(self.root, spawn_key=self.way))


def _step(name: str | int) -> int:
    return zlib.crc32(name.encode()) if isinstance(name, str) else name
