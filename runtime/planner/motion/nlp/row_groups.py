"""Groups of like rows of a motion program, each evaluated for all its instances at once.

A group has N instances of m rows over n places of z. Costs are ½‖r‖², equalities r = 0, inequalities r <= 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from .....compiler.motion.stages import PlacedBatch, Stage
from .....langs.frozen import dataclass
from .....langs.source import Span
from ....skeleton import Array, Breach
from .unknowns import Indices

Chosen = Indices | slice
"""Numbers of instances, or a slice of them."""
ALL = slice(None)


@dataclass(frozen=True, slots=True)
class RowLabel:
    """Whom one instance speaks for: the phase, counted from 0, the kind of row and whom it concerns, the unit of each
    row, where the rows are written, and of clearances what is asked of which parts; all as in a `Violation`."""

    phase: int
    kind: Breach
    names: tuple[str, ...]
    units: tuple[str, ...]
    span: Span | None = None
    asked: float = 0.0
    parts: tuple[str, ...] = ()


class RowGroup(Protocol):
    """N instances of like rows. `scale` multiplies residuals; violations are reported without it."""

    kind: str
    scale: float

    @property
    def shape(self) -> tuple[int, int]:
        """(N, m)."""
        ...

    def label(self, instance: int) -> RowLabel:
        """Whom the instance speaks for."""
        ...

    def residuals(self, z: Array) -> Array:
        """Scaled residuals (N, m), valid until the next call."""
        ...

    def jacobians(self, z: Array, chosen: Chosen) -> tuple[Array, Indices]:
        """Scaled Jacobians (len(chosen), m, n) of the chosen instances, and their places in z (len(chosen), n), valid
        until the next call."""
        ...

    def curvature(self, z: Array, weights: Array) -> list[tuple[Array, Indices]]:
        """Hessians (N, n, n) of weights · r, for weights (N, m), and their places in z (N, n), in parts that add up."""
        ...

    def span(self) -> Indices:
        """The places in z (N, n) of all instances."""
        ...


class StageGroup:
    """Instances of one stage Function."""

    def __init__(
        self, kind: str, stage: Stage, places: Indices, constants: Array, labels: list[RowLabel], scale: float = 1.0
    ) -> None:
        self.kind = kind
        self.scale = scale
        self.stage = stage
        self.places = places
        self.constants = constants
        self.labels = labels
        self._batches: dict[str, PlacedBatch] = {}

    @property
    def shape(self) -> tuple[int, int]:
        return len(self.places), self.stage.rows

    def label(self, instance: int) -> RowLabel:
        return self.labels[instance]

    def _all(self, what: str, z: Array) -> Array:
        batch = self._batches.get(what)
        if batch is None:
            batch = self._batches[what] = self.stage.placed(what, self.places, self.constants)
        found = batch(z)
        return found if self.scale == 1.0 else self.scale * found

    def residuals(self, z: Array) -> Array:
        return self._all("values", z)

    def jacobians(self, z: Array, chosen: Chosen) -> tuple[Array, Indices]:
        if chosen is ALL:
            return self._all("jacobians", z).reshape(-1, self.stage.rows, self.stage.inputs), self.places
        places = self.places[chosen]
        return self.stage.jacobians(z[places], self.constants[chosen], self.scale), places

    def curvature(self, z: Array, weights: Array) -> list[tuple[Array, Indices]]:
        return [(self.stage.hessians(z[self.places], self.constants, self.scale * weights), self.places)]

    def span(self) -> Indices:
        return self.places


class LinearGroup:
    """Rows Σ coefficient · z[place] − target, one row per instance: squared differences, homing, joint limits."""

    def __init__(
        self, kind: str, places: Indices, coefficients: Array, targets: Array, labels: list[RowLabel],
        scale: float = 1.0,
    ) -> None:  # fmt: skip
        self.kind = kind
        self.scale = scale
        self.places = places
        self.coefficients = scale * np.broadcast_to(coefficients, places.shape)
        self.targets = scale * targets
        self.labels = labels

    @property
    def shape(self) -> tuple[int, int]:
        return len(self.places), 1

    def label(self, instance: int) -> RowLabel:
        return self.labels[instance]

    def residuals(self, z: Array) -> Array:
        terms = z[self.places] * self.coefficients
        values: Array = (terms[:, 0] if terms.shape[1] == 1 else terms.sum(1)) - self.targets
        return values[:, None]

    def jacobians(self, z: Array, chosen: Chosen) -> tuple[Array, Indices]:
        return self.coefficients[chosen][:, None, :], self.places[chosen]

    def curvature(self, z: Array, weights: Array) -> list[tuple[Array, Indices]]:
        return []

    def span(self) -> Indices:
        return self.places


class LinearWish(LinearGroup):
    """½ scale² Σ max(0, row)² over the rows of a linear group."""

    def __init__(self, rows: LinearGroup, scale: float) -> None:
        super().__init__("wish", rows.places, rows.coefficients, rows.targets, rows.labels, scale)

    def residuals(self, z: Array) -> Array:
        return np.maximum(super().residuals(z), 0.0)


def merged(groups: Sequence[LinearGroup]) -> list[LinearGroup]:
    """Linear groups without labels as one, none when there are no rows; short rows get terms of no weight."""
    groups = [group for group in groups if group.shape[0]]
    if not groups:
        return []
    width = max(group.places.shape[1] for group in groups)
    places = [np.pad(g.places, ((0, 0), (0, width - g.places.shape[1])), mode="edge") for g in groups]
    coefficients = [np.pad(g.coefficients, ((0, 0), (0, width - g.places.shape[1]))) for g in groups]
    targets = np.concatenate([g.targets for g in groups])
    return [LinearGroup(groups[0].kind, np.concatenate(places), np.concatenate(coefficients), targets, [])]


class NormGroup:
    """Quaternions at `places` (N, 4) have length 1. Only a matter of scale: no literal speaks here."""

    kind = "equality"
    scale = 1.0

    def __init__(self, places: Indices) -> None:
        self.places = places

    @property
    def shape(self) -> tuple[int, int]:
        return len(self.places), 1

    def label(self, instance: int) -> RowLabel:
        return RowLabel(0, Breach.UNIT_QUATERNION, (), ("1",))

    def residuals(self, z: Array) -> Array:
        values: Array = np.square(z[self.places]).sum(1, keepdims=True) - 1.0
        return values

    def jacobians(self, z: Array, chosen: Chosen) -> tuple[Array, Indices]:
        places = self.places[chosen]
        return 2.0 * z[places][:, None, :], places

    def curvature(self, z: Array, weights: Array) -> list[tuple[Array, Indices]]:
        return [(2.0 * weights[:, :, None] * np.eye(4), self.places)]

    def span(self) -> Indices:
        return self.places
