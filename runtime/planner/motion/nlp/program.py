"""A motion program: unknowns, groups of rows, and their banded Gauss-Newton system, assembled without loops over
slices (thesis section 3.2; Toussaint 2017, k-order motion optimisation)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np

from .....langs.frozen import dataclass
from ....skeleton import Array, Breach, Violation
from .dense_rows import DenseRows
from .normal_equations import Scatter, Sums, Together
from .row_groups import ALL, LinearGroup, RowGroup, RowLabel, merged
from .settings import SOLVER
from .systems import BandedSystem, DenseSystem, System
from .unknowns import Indices

KINDS = ("cost", "equality", "inequality")
WISH = "wish"
"""The kind of rows max(0, r) that cost what is missing of them, and are nothing to be refused for."""
DIVERGED = 1e9
"""Stands for a violation that is no number: JSON has none, and no comparison would tell it."""


def _bounds(groups: Sequence[RowGroup]) -> Indices:
    return np.cumsum([0, *(count * rows for count, rows in (g.shape for g in groups))])


def _linear(group: RowGroup) -> LinearGroup:
    if not isinstance(group, LinearGroup):
        raise TypeError("the costs of a motion program are linear rows")
    return group


@dataclass(frozen=True, slots=True)
class Pushing:
    """The instances `chosen` of a group of inequalities or wishes in which some row pushes, what it pulls `(N, m)`, and
    their Jacobians `(N, m, n)` over `places` `(N, n)`, 0 in rows that do not."""

    number: tuple[str, int]
    group: RowGroup
    chosen: Indices
    places: Indices
    pull: Array
    jacobian: Array


class Program:
    """Minimise Σ ½‖cost‖² subject to equalities and inequalities, over x = z[len(constants):].

    Residuals come as three flat vectors: costs, equalities, inequalities (r <= 0), each group after the other. Costs
    are linear groups, so that their part of the system is made once, and behind them wishes, r >= 0. The groups must
    stay as they are while systems are asked for. Raises TypeError for other costs.
    """

    def __init__(self, constants: Array, unknowns: int, groups: Sequence[RowGroup]) -> None:
        self.constants = constants
        self.unknowns = unknowns
        self.groups: dict[str, list[RowGroup]] = {
            kind: [g for g in groups if g.kind == kind and g.shape[0]] for kind in (*KINDS[1:], WISH)
        }
        self._linear = merged([_linear(group) for group in groups if group.kind == "cost"])
        self.groups["cost"] = [*self._linear]
        self.width = 1 + max((self._reach(g) for gs in self.groups.values() for g in gs), default=0)
        self._shape = (unknowns, self.width)
        self._scatters: dict[tuple[str, int], Scatter] = {}
        self._last = (constants, constants)

    @cached_property
    def _always(self) -> Together:
        return Together(self.groups["equality"], len(self.constants), self._shape)

    @cached_property
    def _dense(self) -> DenseRows:
        return DenseRows(self.groups["equality"], len(self.constants), self.unknowns)

    @cached_property
    def _dense_costs(self) -> tuple[Array, Array]:
        """The rows of costs, and their square."""
        rows = DenseRows(self._linear, len(self.constants), self.unknowns).matrix(np.zeros(0), ())
        return rows, rows.T @ rows

    @cached_property
    def _costs(self) -> list[tuple[Array, Scatter]]:
        return [(g.coefficients, Scatter(g.places, len(self.constants), self._shape)) for g in self._linear]

    @cached_property
    def _cost_band(self) -> Array:
        sums = Sums(self._shape)
        for coefficients, scatter in self._costs:
            square = coefficients[:, :, None] * coefficients[:, None, :]
            sums.add(scatter.band.ravel(), square.ravel())
        return sums.band()

    @cached_property
    def _bounds(self) -> Indices:
        """Where each group of inequalities begins in their residuals, and where the last one ends."""
        return _bounds(self.groups["inequality"])

    @cached_property
    def _wished(self) -> Indices:
        """The same of wishes."""
        return _bounds(self.groups[WISH])

    def _reach(self, group: RowGroup) -> int:
        places = group.span()
        first = len(self.constants)
        lowest = np.where(places >= first, places, np.iinfo(np.int64).max).min(1)
        highest = places.max(1)
        return int(np.where(highest >= first, highest - lowest, 0).max(initial=0))

    def full(self, x: Array) -> Array:
        """z: constants, then unknowns. An x that was asked for last gives the same z: whoever knows what holds there
        need not look closer."""
        if self._last[0] is not x:
            self._last = x, np.concatenate([self.constants, x])
        return self._last[1]

    def residuals(self, x: Array) -> tuple[Array, Array, Array]:
        """Scaled costs, equalities, inequalities."""
        z = self.full(x)
        parts = []
        for kind in KINDS:
            wishes = self.groups[WISH] if kind == "cost" else []
            values = [g.residuals(z).ravel() for g in (*self.groups[kind], *wishes)]
            parts.append(np.concatenate(values) if values else np.zeros(0))
        return parts[0], parts[1], parts[2]

    def system(
        self, x: Array, residuals: tuple[Array, Array, Array], multipliers: tuple[Array, Array], mu: float,
        costs: bool = True,
    ) -> System:  # fmt: skip
        """What `normal` tells, ready to be solved; of small programs as a dense matrix."""
        if self.unknowns > SOLVER.dense:
            return BandedSystem(*self.normal(x, residuals, multipliers, mu, costs))
        z = self.full(x)
        cost, equality, inequality = residuals
        found = [*self._pushing("inequality", z, np.maximum(mu * inequality + multipliers[1], 0.0))]
        pulls = [mu * equality + multipliers[0], *(f.pull.ravel() for f in found)]
        parts = [(f.jacobian, f.places) for f in found]
        rows = sum(map(len, pulls))
        if costs:
            wishes = [*self._pushing(WISH, z, cost[len(cost) - self._wished[-1] :])]
            pulls += [f.pull.ravel() for f in wishes]
            parts += [(f.jacobian, f.places) for f in wishes]
        matrix = self._dense.matrix(z, parts)
        gradient = np.concatenate(pulls) @ matrix
        one, other = matrix[:rows], matrix[rows:]
        square = mu * (one.T @ one)
        if costs:
            gradient += cost[: len(cost) - self._wished[-1]] @ self._dense_costs[0]
            square += self._dense_costs[1]
            if len(other):
                square += other.T @ other
        return DenseSystem(gradient, square)

    def normal(
        self, x: Array, residuals: tuple[Array, Array, Array], multipliers: tuple[Array, Array], mu: float,
        costs: bool = True,
    ) -> tuple[Array, Array]:  # fmt: skip
        """Gradient (unknowns,) and lower band (unknowns, width) of the Gauss-Newton model of the augmented
        Lagrangian ½‖c‖² + ½μ‖e + λ/μ‖² + ½μ‖max(i + κ/μ, 0)‖² with `multipliers` (λ, κ)."""
        z = self.full(x)
        sums = Sums(self._shape)
        cost, equality, inequality = residuals
        if costs:
            for coefficients, scatter in self._costs:
                sums.pull(scatter.gradient.ravel(), (cost[: len(coefficients), None] * coefficients).ravel())
            self._add_pushing(WISH, z, cost[len(cost) - self._wished[-1] :], 1.0, sums)
        self._always.add(z, mu * equality + multipliers[0], mu, sums)
        self._add_pushing("inequality", z, np.maximum(mu * inequality + multipliers[1], 0.0), mu, sums)
        band = sums.band()
        return sums.gradient(), band + self._cost_band if costs else band

    def violated(self, x: Array, residuals: tuple[Array, Array, Array]) -> System:
        """The system of the rows that are violated at x alone, where `residuals` are those."""
        none = (np.zeros_like(residuals[1]), np.zeros_like(residuals[2]))
        return self.system(x, residuals, none, 1.0, costs=False)

    def _pushing(self, kind: str, z: Array, pull: Array) -> Iterator[Pushing]:
        """Inequalities or wishes: only instances with a row that pushes are differentiated."""
        pushing = pull.nonzero()[0]
        if not len(pushing):
            return
        bounds = self._wished if kind == WISH else self._bounds
        among = pushing.searchsorted(bounds).tolist()
        for number, group in enumerate(self.groups[kind]):
            if among[number] == among[number + 1]:
                continue
            if group.shape[1] == 1:
                at = pushing[among[number] : among[number + 1]]
                chosen, block = at - bounds[number], pull[at][:, None]
                jacobian, places = group.jacobians(z, chosen)
            else:
                block = pull[bounds[number] : bounds[number + 1]].reshape(group.shape)
                chosen = np.flatnonzero(block.any(1))
                block = block[chosen]
                jacobian, places = group.jacobians(z, chosen)
                jacobian = jacobian * (block > 0)[:, :, None]
            yield Pushing((kind, number), group, chosen, places, block, jacobian)

    def _add_pushing(self, kind: str, z: Array, pull: Array, weight: float, sums: Sums) -> None:
        for found in self._pushing(kind, z, pull):
            block, jacobian = found.pull, found.jacobian
            if jacobian.shape[1] == 1:
                slope, square = block * jacobian[:, 0], jacobian.transpose(0, 2, 1) * (weight * jacobian)
            else:
                slope = np.matmul(block[:, None, :], jacobian)
                square = np.matmul(jacobian.transpose(0, 2, 1), weight * jacobian)
            band, gradient = self._targets(found.number, found.group, found.chosen, found.places)
            sums.add(band, square.ravel())
            sums.pull(gradient, slope.ravel())

    def _targets(
        self, number: tuple[str, int], group: RowGroup, chosen: Indices, places: Indices
    ) -> tuple[Indices, Indices]:
        """Where the products of chosen instances go; those of a small group are all found at once."""
        if group.shape[0] * places.shape[1] ** 2 > SOLVER.batched_products:
            scatter = Scatter(places, len(self.constants), self._shape)
            return scatter.band.ravel(), scatter.gradient.ravel()
        if number not in self._scatters:
            self._scatters[number] = Scatter(group.span(), len(self.constants), self._shape)
        scatter = self._scatters[number]
        return scatter.band[chosen].ravel(), scatter.gradient[chosen].ravel()

    def hessian(self, x: Array, cost_weight: float, multipliers: tuple[Array, Array]) -> Array:
        """Lower band (unknowns, width) of the Hessian of cost_weight · ½‖c‖² + λ·e + κ·i; costs are linear rows, wishes
        are taken for such."""
        z = self.full(x)
        sums = Sums(self._shape)
        for kind, weights in (("equality", multipliers[0]), ("inequality", multipliers[1])):
            at = 0
            for group in self.groups[kind]:
                count, rows = group.shape
                block = weights[at : at + count * rows].reshape(count, rows)
                at += count * rows
                for hessians, places in group.curvature(z, block):
                    scatter = Scatter(places, len(self.constants), self._shape)
                    sums.add(scatter.band.ravel(), hessians.ravel())
        wishes = Sums(self._shape)
        cost = self.residuals(x)[0]
        self._add_pushing(WISH, z, cost[len(cost) - self._wished[-1] :], 1.0, wishes)
        return sums.band() + cost_weight * (self._cost_band + wishes.band())

    def jacobian(self, x: Array) -> tuple[Array, Indices, Indices]:
        """Values, rows and columns of the Jacobian of equalities, then inequalities, by the unknowns. The pattern
        does not depend on x; a place may occur twice and then adds up."""
        z = self.full(x)
        values, rows_at, columns = [np.zeros(0)], [np.zeros(0, dtype=np.int64)], [np.zeros(0, dtype=np.int64)]
        at = 0
        for kind in ("equality", "inequality"):
            for group in self.groups[kind]:
                count, rows = group.shape
                jacobian, places = group.jacobians(z, ALL)
                unknown = np.broadcast_to((places - len(self.constants))[:, None, :], jacobian.shape)
                row = np.broadcast_to(np.arange(at, at + count * rows).reshape(count, rows, 1), jacobian.shape)
                kept = unknown >= 0
                values.append(jacobian[kept])
                rows_at.append(row[kept])
                columns.append(unknown[kept])
                at += count * rows
        return np.concatenate(values), np.concatenate(rows_at), np.concatenate(columns)

    def cost(self, x: Array) -> float:
        """What the costs come to, wishes apart."""
        z = self.full(x)
        return 0.5 * sum(float(np.square(g.residuals(z)).sum()) for g in self.groups["cost"])

    def objective(self, x: Array) -> float:
        """What costs and wishes come to."""
        costs = self.residuals(x)[0]
        return 0.5 * float(costs @ costs)

    def rows(self, x: Array) -> list[tuple[RowLabel, Array]]:
        """Every constraint instance with the violations (m,) of its rows, unscaled."""
        z = self.full(x)
        found: list[tuple[RowLabel, Array]] = []
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
        worst: dict[tuple[int, Breach, tuple[str, ...]], Violation] = {}
        for label, amounts in self.rows(x):
            row = int(amounts.argmax())
            amount = DIVERGED if np.isnan(amounts[row]) else float(amounts[row])
            key = (label.phase, label.kind, label.names)
            if amount > above and (key not in worst or amount > worst[key].amount):
                unit = label.units[min(row, len(label.units) - 1)]
                worst[key] = Violation(
                    label.phase, label.kind, label.names, amount, unit, label.span, label.asked, label.parts
                )
        return sorted(worst.values(), key=lambda v: (-v.amount, v.phase, v.kind, v.names))
