"""Clearances of parts as rows, in metres: that they do not overlap, and the wish that they keep a margin.

Distances are exact. The points of two parts that are nearest to each other are taken for fixed to these, which gives
the derivatives of their distance; they are made of rows that push only.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from ....geometry.exact_distances import Distances, Pairing, Posed
from ....skeleton import Array
from ..nlp.row_groups import Chosen, RowLabel
from ..nlp.unknowns import Indices
from .broad_phase import NO_PAIRS, Blocks, Edges, Pairs
from .obstacles import Obstacles
from .part_frames import Cloud
from .settings import COLLISION


class _Sides:
    """Pairs of parts, or of parts and what rests, one after the other: what is the same wherever the parts are."""

    def __init__(self, cloud: Cloud, rest: Posed, pairs: Sequence[Pairs], among: Sequence[bool]) -> None:
        self._cloud = cloud
        second = np.concatenate([p.second for p in pairs])
        still = ~np.repeat(np.array(among, dtype=bool), [len(p.second) for p in pairs])
        near, at = np.unique(second[still], return_inverse=True)
        second[still] = cloud.count + at
        self.wanted = np.concatenate([p.wanted for p in pairs])
        self._position = np.concatenate([np.zeros((cloud.count, 3)), rest.position[near]])
        self._rotation = np.concatenate([np.zeros((cloud.count, 3, 3)), rest.rotation[near]])
        forms = cloud.forms.joined(rest.forms)
        form = np.concatenate([np.arange(cloud.count), len(cloud.forms) + rest.form[near]])
        self._pairing = Pairing(forms, form, np.concatenate([p.first for p in pairs]), second)

    def distances(self, z: Array, beyond: float = 0.0) -> Distances:
        """Their distances; lower bounds of what is more than `beyond` metres farther apart than it wishes."""
        posed = self._cloud.posed(z)
        self._position[: len(posed.position)], self._rotation[: len(posed.position)] = posed.position, posed.rotation
        return self._pairing.distances(self._position, self._rotation, self.wanted + beyond)


class Ruler:
    """Distances of pairs of parts, and of parts and what rests, all at once: many small looks take longer."""

    def __init__(self, cloud: Cloud, obstacles: Obstacles) -> None:
        self.cloud, self.rest = cloud, obstacles.posed()
        self.sides: list[Clearances] = []
        self._last: tuple[Array, list[Distances]] | None = None
        self._together: tuple[_Sides, list[slice]] | None = None

    def forget(self) -> None:
        """The pairs have changed."""
        self._last = self._together = None

    def of(self, side: Clearances, z: Array) -> Distances:
        """The distances of the pairs of one side."""
        if self._last is None or not (self._last[0] is z or np.array_equal(self._last[0], z)):
            if self._together is None:
                ends = np.cumsum([0, *(len(s.pairs.first) for s in self.sides)]).tolist()
                among = [s.among for s in self.sides]
                sides = _Sides(self.cloud, self.rest, [s.pairs for s in self.sides], among)
                self._together = sides, [slice(a, b) for a, b in pairwise(ends)]
            found = self._together[0].distances(z)
            self._last = z, [found.part(part) for part in self._together[1]]
        return self._last[1][self.sides.index(side)]

    def measure(self, z: Array, pairs: Pairs, among: bool, beyond: float) -> Distances:
        """The distances of pairs, `among` parts or of parts and what rests; lower bounds of what is more than `beyond`
        metres farther apart than it wishes."""
        return _Sides(self.cloud, self.rest, [pairs], [among]).distances(z, beyond)


class Clearances:
    """Pairs of parts, or of parts and bodies at rest, that take part in a program, and their distances."""

    def __init__(
        self, ruler: Ruler, rest: Edges | None, blocks: Blocks, label_of: Callable[[Indices], RowLabel]
    ) -> None:
        """`blocks` hold all pairs and the margins wished for, with `rest` of parts and what lies between those edges;
        `label_of` turns the tag of a pair into a label."""
        self.ruler, self.cloud = ruler, ruler.cloud
        self.among = rest is None
        self._edges = rest
        self._blocks = blocks
        self.label_of = label_of
        ruler.sides.append(self)
        self._use(NO_PAIRS)

    def _use(self, pairs: Pairs) -> None:
        self.pairs = pairs
        parts = [self.cloud.places(pairs.first)]
        if self.among:
            parts.append(self.cloud.places(pairs.second))
        self.places = np.concatenate(parts, axis=1)
        self._slopes: tuple[Distances, Indices, Array] | None = None
        self.ruler.forget()

    def refresh(self, z: Array, near: float = COLLISION.near) -> bool:
        """Let the pairs that are now closer than `near` beyond their margin take part, besides those that already do.
        Returns whether one of the new ones overlaps."""
        pairs, taking_part = self.pairs.joined(self._near(z, near))
        value = self.ruler.measure(z, pairs, self.among, near).value
        close = taking_part | (value < near + pairs.wanted)
        broken = bool((value[close & ~taking_part] < -COLLISION.broken).any())
        self._use(pairs[np.flatnonzero(close)])
        return broken

    def _near(self, z: Array, near: float) -> Pairs:
        edges = self.cloud.edges(z)
        return self._blocks.near(edges, self._edges or edges, near)

    def near(self, z: Array) -> tuple[Pairs, Array]:
        """The pairs that may be closer than their margins, whether or not they take part, and their distances."""
        pairs = self._near(z, 0.0)
        return pairs, self.ruler.measure(z, pairs, self.among, 0.0).value

    def measured(self, z: Array) -> Distances:
        """The distances of all pairs that take part."""
        return self.ruler.of(self, z)

    def slopes(self, z: Array, chosen: Chosen) -> Array:
        """The derivatives (len, n) of the distances of chosen pairs by what `places` name. Those of pairs that miss
        their margin are made together, as their rows and their wishes ask for them."""
        found = self.measured(z)
        if self._slopes is None or self._slopes[0] is not found:
            missing = found.value < self.pairs.wanted
            pushing = missing.nonzero()[0]
            where = np.where(missing, missing.cumsum() - 1, -1)
            self._slopes = found, where, self._made(z, pushing)
        _, where, made = self._slopes
        at = where[chosen]
        return np.asarray(made[at]) if (at >= 0).all() else self._made(z, chosen)

    def _made(self, z: Array, chosen: Chosen) -> Array:
        normal, ends = self.measured(z).normal[chosen], self._ends(z, chosen)
        numbers, shares = (np.concatenate(side) for side in zip(*ends, strict=True))
        pull = np.concatenate([normal, -normal]) if self.among else normal
        slopes = self.cloud.slopes(z, numbers, shares, pull)
        return np.concatenate([slopes[: len(normal)], slopes[len(normal) :]], axis=1) if self.among else slopes

    def _ends(self, z: Array, chosen: Chosen) -> list[tuple[Indices, Array]]:
        """The parts, and the shares of their anchors in the nearest points: of the first ones and the second ones."""
        found, posed = self.measured(z), self.cloud.posed(z)
        first, second = self.pairs.first[chosen], self.pairs.second[chosen]
        ends = [(first, self.cloud.shares(first, found.on_first[chosen], posed))]
        if self.among:
            ends.append((second, self.cloud.shares(second, found.on_second[chosen], posed)))
        return ends

    def curvature(self, z: Array, weights: Array) -> list[tuple[Array, Indices]]:
        """Hessians of weights (N,) · distances as far as they come from the motion of the nearest points."""
        chosen = np.flatnonzero(weights)
        if not len(chosen):
            return []
        pull = weights[chosen, None] * self.measured(z).normal[chosen]
        signed = (pull, -pull)
        return self.cloud.curvature(z, [(*end, p) for end, p in zip(self._ends(z, chosen), signed, strict=False)])


class ClearanceGroup:
    """Rows least − distance <= 0 of the pairs of `clearances`; with `strict` the margin is the least distance."""

    kind = "inequality"
    scale: float = 1.0

    def __init__(self, clearances: Clearances, strict: bool = False) -> None:
        self.clearances, self.strict = clearances, strict

    @property
    def shape(self) -> tuple[int, int]:
        return len(self.clearances.pairs.first), 1

    def label(self, instance: int) -> RowLabel:
        pairs = self.clearances.pairs
        return replace(self.clearances.label_of(pairs.tags[instance]), asked=float(self._asked[instance]))

    @property
    def _asked(self) -> Array:
        return self.clearances.pairs.wanted if self.strict else self.clearances.pairs.least

    def residuals(self, z: Array) -> Array:
        return np.asarray((self._asked - self.clearances.measured(z).value)[:, None])

    def jacobians(self, z: Array, chosen: Chosen) -> tuple[Array, Indices]:
        return -self.clearances.slopes(z, chosen)[:, None, :], self.span()[chosen]

    def curvature(self, z: Array, weights: Array) -> list[tuple[Array, Indices]]:
        return self.clearances.curvature(z, -weights[:, 0])

    def span(self) -> Indices:
        return self.clearances.places


class WishGroup(ClearanceGroup):
    """½ scale² Σ max(0, margin − distance)² of the same pairs."""

    kind = "wish"

    def __init__(self, clearances: Clearances, scale: float) -> None:
        super().__init__(clearances)
        self.scale = scale

    def residuals(self, z: Array) -> Array:
        missing = self.clearances.pairs.wanted - self.clearances.measured(z).value
        return np.asarray(self.scale * np.maximum(missing, 0.0)[:, None])

    def jacobians(self, z: Array, chosen: Chosen) -> tuple[Array, Indices]:
        return -self.scale * self.clearances.slopes(z, chosen)[:, None, :], self.span()[chosen]
