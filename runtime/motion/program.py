"""A motion program: unknowns, groups of rows, and their banded Gauss-Newton system, assembled without loops over
slices (thesis section 3.2; Toussaint 2017, k-order motion optimisation)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..skeleton import Array, Violation
from .groups import Group, Label
from .layout import Indices

KINDS = ("cost", "equality", "inequality")
DIVERGED = 1e9
"""Stands for a violation that is no number: JSON has none, and no comparison would tell it."""


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


class _Sums:
    """Contributions to a gradient and to a lower band, added up in one go."""

    def __init__(self, unknowns: int, width: int) -> None:
        self.shape = (unknowns, width)
        self._values: list[Array] = []
        self._targets: list[Indices] = []
        self._slopes: list[Array] = []
        self._slope_targets: list[Indices] = []

    def add(self, scatter: _Scatter, slope: Array, square: Array) -> None:
        self._values.append(square.ravel()[scatter.source])
        self._targets.append(scatter.target)
        self.pull(scatter, slope)

    def pull(self, scatter: _Scatter, slope: Array) -> None:
        self._slopes.append(slope.ravel()[scatter.vector_source])
        self._slope_targets.append(scatter.vector_target)

    @staticmethod
    def _sum(targets: list[Indices], values: list[Array], size: int) -> Array:
        if not targets:
            return np.zeros(size)
        sums = np.bincount(np.concatenate(targets), np.concatenate(values), minlength=size)
        return np.asarray(sums, dtype=np.float64)

    def gradient(self) -> Array:
        return self._sum(self._slope_targets, self._slopes, self.shape[0])

    def band(self) -> Array:
        return self._sum(self._targets, self._values, self.shape[0] * self.shape[1]).reshape(self.shape)


class Program:
    """Minimise Σ ½‖cost‖² subject to equalities and inequalities, over x = z[len(constants):].

    Residuals come as three flat vectors: costs, equalities, inequalities (r <= 0), each group after the other. Costs
    are linear rows, so that their part of the system is made once.
    """

    def __init__(self, constants: Array, unknowns: int, groups: Sequence[Group]) -> None:
        self.constants = constants
        self.unknowns = unknowns
        self.groups: dict[str, list[Group]] = {
            kind: [g for g in groups if g.kind == kind and g.shape[0]] for kind in KINDS
        }
        self.width = 1 + max((self._reach(g) for gs in self.groups.values() for g in gs), default=0)
        self._scatters = {
            id(g): _Scatter(g.span(), len(constants), self.width)
            for kind in ("cost", "equality") for g in self.groups[kind]
        }  # fmt: skip

        z = self.full(np.zeros(unknowns))
        self._cost_jacobians = [g.jacobians(z, np.arange(g.shape[0]))[0] for g in self.groups["cost"]]
        sums = _Sums(unknowns, self.width)
        for group, jacobian in zip(self.groups["cost"], self._cost_jacobians, strict=True):
            square = np.matmul(jacobian.transpose(0, 2, 1), jacobian)
            sums.add(self._scatters[id(group)], np.zeros((len(jacobian), 1, jacobian.shape[2])), square)
        self._cost_band = sums.band()

    def _reach(self, group: Group) -> int:
        places = group.span()
        first = len(self.constants)
        lowest = np.where(places >= first, places, np.iinfo(np.int64).max).min(1)
        highest = places.max(1)
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
        sums = _Sums(self.unknowns, self.width)
        cost, equality, inequality = residuals
        if costs:
            self._pull_costs(cost, sums)
        self._add_always("equality", z, mu * equality + multipliers[0], mu, sums)
        self._add_pushing(z, np.maximum(mu * inequality + multipliers[1], 0.0), mu, sums)
        band = sums.band()
        return sums.gradient(), band + self._cost_band if costs else band

    def _pull_costs(self, cost: Array, sums: _Sums) -> None:
        at = 0
        for group, jacobian in zip(self.groups["cost"], self._cost_jacobians, strict=True):
            count, rows = group.shape
            block = cost[at : at + count * rows].reshape(count, 1, rows)
            at += count * rows
            sums.pull(self._scatters[id(group)], np.matmul(block, jacobian))

    def _add_always(self, kind: str, z: Array, pull: Array, weight: float, sums: _Sums) -> None:
        at = 0
        for group in self.groups[kind]:
            count, rows = group.shape
            jacobian, _ = group.jacobians(z, np.arange(count))
            block = pull[at : at + count * rows].reshape(count, 1, rows)
            at += count * rows
            square = np.matmul(jacobian.transpose(0, 2, 1), weight * jacobian)
            sums.add(self._scatters[id(group)], np.matmul(block, jacobian), square)

    def _add_pushing(self, z: Array, pull: Array, weight: float, sums: _Sums) -> None:
        """Inequalities: only instances with a row that pushes are differentiated."""
        at = 0
        for group in self.groups["inequality"]:
            count, rows = group.shape
            block = pull[at : at + count * rows].reshape(count, rows)
            at += count * rows
            chosen = np.flatnonzero(block.any(1))
            if len(chosen):
                jacobian, places = group.jacobians(z, chosen)
                slope = np.matmul(block[chosen][:, None, :], jacobian)
                jacobian = jacobian * (block[chosen] > 0)[:, :, None]
                square = np.matmul(jacobian.transpose(0, 2, 1), weight * jacobian)
                sums.add(_Scatter(places, len(self.constants), self.width), slope, square)

    def hessian(self, x: Array, cost_weight: float, multipliers: tuple[Array, Array]) -> Array:
        """Lower band (unknowns, width) of the Hessian of cost_weight · ½‖c‖² + λ·e + κ·i; costs are linear rows."""
        z = self.full(x)
        sums = _Sums(self.unknowns, self.width)
        for kind, weights in (("equality", multipliers[0]), ("inequality", multipliers[1])):
            at = 0
            for group in self.groups[kind]:
                count, rows = group.shape
                block = weights[at : at + count * rows].reshape(count, rows)
                at += count * rows
                for hessians, places in group.curvature(z, block):
                    slope = np.zeros((len(places), 1, places.shape[1]))
                    sums.add(_Scatter(places, len(self.constants), self.width), slope, hessians)
        return sums.band() + cost_weight * self._cost_band

    def jacobian(self, x: Array) -> tuple[Array, Indices, Indices]:
        """Values, rows and columns of the Jacobian of equalities, then inequalities, by the unknowns. The pattern
        does not depend on x; a place may occur twice and then adds up."""
        z = self.full(x)
        values, rows_at, columns = [np.zeros(0)], [np.zeros(0, dtype=np.int64)], [np.zeros(0, dtype=np.int64)]
        at = 0
        for kind in ("equality", "inequality"):
            for group in self.groups[kind]:
                count, rows = group.shape
                jacobian, places = group.jacobians(z, np.arange(count))
                unknown = np.broadcast_to((places - len(self.constants))[:, None, :], jacobian.shape)
                row = np.broadcast_to(np.arange(at, at + count * rows).reshape(count, rows, 1), jacobian.shape)
                kept = unknown >= 0
                values.append(jacobian[kept])
                rows_at.append(row[kept])
                columns.append(unknown[kept])
                at += count * rows
        return np.concatenate(values), np.concatenate(rows_at), np.concatenate(columns)

    def cost(self, x: Array) -> float:
        costs = self.residuals(x)[0]
        return 0.5 * float(costs @ costs)

    def rows(self, x: Array) -> list[tuple[Label, Array]]:
        """Every constraint instance with the violations (m,) of its rows, unscaled."""
        z = self.full(x)
        found: list[tuple[Label, Array]] = []
        for kind in ("equality", "inequality"):
            for group in self.groups[kind]:
                raw = group.residuals(z) / group.scale
                amounts = np.abs(raw) if kind == "equality" else np.maximum(raw, 0.0)
                found.extend((group.label(int(i)), amounts[i]) for i in np.flatnonzero(amounts.any(1)))
        return found

    def largest(self, x: Array) -> float:
        """The largest unscaled violation of a single row; `DIVERGED` where a row is no number."""
        z = self.full(x)
        worst = [0.0]
        worst += [float(np.abs(group.residuals(z)).max()) / group.scale for group in self.groups["equality"]]
        worst += [float(group.residuals(z).max()) / group.scale for group in self.groups["inequality"]]
        return DIVERGED if np.isnan(worst).any() else max(worst)

    def violations(self, x: Array, above: float) -> list[Violation]:
        """Rows violated by more than `above`, largest first; for each phase and literal only its worst row."""
        worst: dict[tuple[int, tuple[str, ...]], Violation] = {}
        for label, amounts in self.rows(x):
            row = int(amounts.argmax())
            amount = DIVERGED if np.isnan(amounts[row]) else float(amounts[row])
            key = (label.phase, label.literal)
            if amount > above and (key not in worst or amount > worst[key].amount):
                unit = label.units[min(row, len(label.units) - 1)]
                worst[key] = Violation(label.phase, label.literal, amount, unit, label.span)
        return sorted(worst.values(), key=lambda v: (-v.amount, v.phase, v.literal))
