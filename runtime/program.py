"""A motion program: unknowns, groups of rows, and their banded Gauss-Newton system, assembled without loops over
slices (thesis section 3.2; Toussaint 2017, k-order motion optimisation)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .groups import Group, Label
from .layout import Indices
from .skeleton import Array, Violation

KINDS = ("cost", "equality", "inequality")


class _Scatter:
    """Flat places in the lower band of the outer products of rows over `places` (N, n)."""

    def __init__(self, places: Indices, first_unknown: int, width: int) -> None:
        unknown = places - first_unknown
        rows, columns = unknown[:, :, None], unknown[:, None, :]
        kept = ((columns >= 0) & (rows >= columns)).ravel()
        self.source = np.flatnonzero(kept)
        self.target = (columns * width + (rows - columns)).reshape(-1)[self.source]
        self.vector_source = np.flatnonzero(unknown.ravel() >= 0)
        self.vector_target = unknown.ravel()[self.vector_source]


class Program:
    """Minimise Σ ½‖cost‖² subject to equalities and inequalities, over x = z[len(constants):].

    Residuals come as three flat vectors: costs, equalities, inequalities (r <= 0), each group after the other.
    """

    def __init__(self, constants: Array, unknowns: int, groups: Sequence[Group]) -> None:
        self.constants = constants
        self.unknowns = unknowns
        self.groups: dict[str, list[Group]] = {
            kind: [g for g in groups if g.kind == kind and g.shape[0]] for kind in KINDS
        }
        self.width = 1 + max((self._reach(g) for gs in self.groups.values() for g in gs), default=0)
        self._scatters = {
            id(g): _Scatter(g.span()[0], len(constants), self.width)
            for kind in ("cost", "equality") for g in self.groups[kind]
        }  # fmt: skip

    def _reach(self, group: Group) -> int:
        low, high = group.span()
        first = len(self.constants)
        lowest = np.where(low >= first, low, np.iinfo(np.int64).max).min(1)
        highest = high.max(1)
        return int(np.where(highest >= first, highest - lowest, 0).max(initial=0))

    def full(self, x: Array) -> Array:
        """z: constants, then unknowns."""
        return np.concatenate([self.constants, x])

    def residuals(self, x: Array) -> tuple[Array, Array, Array]:
        """Scaled costs, equalities, inequalities."""
        z = self.full(x)
        parts = []
        for kind in KINDS:
            values = [g.residuals(z).ravel() for g in self.groups[kind]]
            parts.append(np.concatenate(values) if values else np.zeros(0))
        return parts[0], parts[1], parts[2]

    def normal(
        self, x: Array, residuals: tuple[Array, Array, Array], multipliers: tuple[Array, Array], mu: float,
        costs: bool = True,
    ) -> tuple[Array, Array]:  # fmt: skip
        """Gradient (unknowns,) and lower band (unknowns, width) of the Gauss-Newton model of the augmented
        Lagrangian ½‖c‖² + ½μ‖e + λ/μ‖² + ½μ‖max(i + κ/μ, 0)‖² with `multipliers` (λ, κ)."""
        z = self.full(x)
        values: list[Array] = []
        targets: list[Indices] = []
        gradients: list[Array] = []
        gradient_targets: list[Indices] = []
        cost, equality, inequality = residuals
        always = [("cost", cost, 1.0)] if costs else []
        for kind, pull, weight in [*always, ("equality", mu * equality + multipliers[0], mu)]:
            at = 0
            for group in self.groups[kind]:
                count, rows = group.shape
                jacobian, _ = group.jacobians(z, np.arange(count))
                scatter = self._scatters[id(group)]
                slope = np.matmul(pull[at : at + count * rows].reshape(count, 1, rows), jacobian)
                square = np.matmul(jacobian.transpose(0, 2, 1), weight * jacobian)
                values.append(square.ravel()[scatter.source])
                targets.append(scatter.target)
                gradients.append(slope.ravel()[scatter.vector_source])
                gradient_targets.append(scatter.vector_target)
                at += count * rows
        pull = np.maximum(mu * inequality + multipliers[1], 0.0)
        at = 0
        for group in self.groups["inequality"]:
            count, rows = group.shape
            block = pull[at : at + count * rows].reshape(count, rows)
            at += count * rows
            chosen = np.flatnonzero(block.any(1))
            if not len(chosen):
                continue
            jacobian, places = group.jacobians(z, chosen)
            block = block[chosen]
            scatter = _Scatter(places, len(self.constants), self.width)
            slope = np.matmul(block[:, None, :], jacobian)
            jacobian = jacobian * (block > 0)[:, :, None]
            square = np.matmul(jacobian.transpose(0, 2, 1), mu * jacobian)
            values.append(square.ravel()[scatter.source])
            targets.append(scatter.target)
            gradients.append(slope.ravel()[scatter.vector_source])
            gradient_targets.append(scatter.vector_target)
        band = np.bincount(
            np.concatenate(targets), np.concatenate(values), minlength=self.unknowns * self.width
        ).reshape(self.unknowns, self.width)
        gradient = np.bincount(
            np.concatenate(gradient_targets), np.concatenate(gradients), minlength=self.unknowns
        )
        return gradient, band

    def cost(self, x: Array) -> float:
        costs = self.residuals(x)[0]
        return 0.5 * float(costs @ costs)

    def rows(self, x: Array) -> list[tuple[Label, Array]]:
        """Every constraint instance with the violations (m,) of its rows, unscaled."""
        z = self.full(x)
        found = []
        for kind in ("equality", "inequality"):
            for group in self.groups[kind]:
                raw = group.residuals(z) / group.scale
                amounts = np.abs(raw) if kind == "equality" else np.maximum(raw, 0.0)
                found.extend((group.label(i), amounts[i]) for i in np.flatnonzero(amounts.any(1)))
        return found

    def largest(self, x: Array) -> float:
        """The largest unscaled violation of a single row."""
        z = self.full(x)
        worst = 0.0
        for group in self.groups["equality"]:
            worst = max(worst, float(np.abs(group.residuals(z)).max()) / group.scale)
        for group in self.groups["inequality"]:
            worst = max(worst, float(group.residuals(z).max()) / group.scale)
        return worst

    def violations(self, x: Array, above: float) -> list[Violation]:
        """Rows violated by more than `above`, largest first; for each phase and literal only its worst row."""
        worst: dict[tuple[int, tuple[str, ...]], tuple[float, str]] = {}
        for label, amounts in self.rows(x):
            row = int(amounts.argmax())
            amount = float(amounts[row])
            key = (label.phase, label.literal)
            if amount > above and amount > worst.get(key, (0.0, ""))[0]:
                worst[key] = (amount, label.units[min(row, len(label.units) - 1)])
        found = [Violation(phase, literal, amount, unit) for (phase, literal), (amount, unit) in worst.items()]
        return sorted(found, key=lambda v: (-v.amount, v.phase, v.literal))
