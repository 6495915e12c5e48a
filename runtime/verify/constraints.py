"""The motion predicates of a plan, measured anew: rows at switches, rows during intervals, and what stays constant.

What holds during an interval is measured on the motion itself, at instants of the checker's own. How far a value may
stray between two of them is bounded; where the bound is not enough, the stretch between them is halved."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

import numpy as np

from ...compiler import ir
from ...langs.frozen import dataclass
from ..plan import MeasureRecord, Plan
from .bounds import Bounds
from .findings import Findings
from .gauge import LOADS, Gauge
from .geometry import Array, Frames, angles
from .kept_poses import kept
from .kinematics import Motion
from .limits import unit_of
from .replay import Story
from .rows import Evaluator, MeaninglessRow, name_of
from .sampler import Grid, Sampler, Shown
from .settling import Look, Slip, settle
from .strays import Strays


def check_constraints(
    problem: ir.Problem, plan: Plan, story: Story, motion: Motion, sampler: Sampler, findings: Findings
) -> None:
    """Measure every motion literal of the story. What keeps a body to another one means nothing while it goes its own
    way."""
    switches = _Switches(problem, motion, findings)
    for index, added in enumerate(story.added[: len(plan.phases)]):
        after = story.modes[index + 1] if index + 1 < len(story.modes) else story.final
        for literal in sorted(added):
            switches.measure(literal, motion.ranges[index][1], after)
    begun: dict[ir.Fact, dict[ir.Row, _Held]] = {}
    for index, mode in enumerate(story.modes[: len(motion.ranges)]):
        begun = {literal: begun.get(literal, {}) for literal in sorted(mode)}
        phase = _Phase(problem, motion, sampler, index, findings, Gauge(problem, mode))
        for literal, held in begun.items():
            if not _goes_its_way(problem, literal, sampler.happenings.free[index]):
                phase.measure(literal, held)


def _goes_its_way(problem: ir.Problem, literal: ir.Fact, free: frozenset[str]) -> bool:
    return any(own in free and base in problem.world.bodies for base, own in kept(problem, [literal]))


def shapes_of(problem: ir.Problem) -> dict[str, ir.Shape | None]:
    """The shape of every body and effector."""
    found: dict[str, ir.Shape | None] = {b.name: b.shape for b in problem.world.bodies.values()}
    for module in problem.world.modules.values():
        found[module.name] = None
        found |= {f"{module.name}.{e.name}": e.shape for e in module.type.effectors}
    return found


@dataclass(frozen=True, slots=True)
class _Residual:
    kind: str
    amount: float
    time: float
    row: ir.Row


_Held = Frames | Array
"""What a `keep` row holds constant: a pose `(1,)` or a value `(1, rows)`, as it was when the literal began to hold."""


class _Literals:
    """The rows of ground literals, and the findings about them."""

    def __init__(self, problem: ir.Problem, findings: Findings) -> None:
        self._problem = problem
        self._findings = findings

    def _rows(self, literal: ir.Fact, when: str) -> list[ir.Row]:
        return [r for r in self._problem.motions[literal[0]].rows if r.when == when]

    def _loaded(self, literal: ir.Fact) -> bool:
        return any(_loads(row) for row in self._problem.motions[literal[0]].rows)

    def _names(self, literal: ir.Fact) -> dict[str, str]:
        variables = self._problem.motions[literal[0]].variables
        return dict(zip((v.name for v in variables), literal[1:], strict=True))

    def _record(self, literal: ir.Fact, residual: _Residual) -> None:
        self._findings.measure(
            residual.kind, residual.amount, f"[{' '.join(literal)}] does not hold",
            time=residual.time, between=literal[1:], place=self._findings.place_of(residual.row.span),
        )  # fmt: skip

    def _meaningless(self, literal: ir.Fact, row: ir.Row, error: MeaninglessRow) -> None:
        self._findings.fail("constraint", f"[{' '.join(literal)}]: {error}", place=self._findings.place_of(row.span))


class _Switches(_Literals):
    """Rows at switches."""

    def __init__(self, problem: ir.Problem, motion: Motion, findings: Findings) -> None:
        super().__init__(problem, findings)
        self._motion = motion
        self._times = motion.times

    def measure(self, literal: ir.Fact, sample: int, after: frozenset[ir.Fact]) -> None:
        """Measure the switch rows of a literal at the sample where it is added; `after` holds from then on."""
        gauge = Gauge(self._problem, after) if self._loaded(literal) else None
        self._evaluate = Evaluator(shapes_of(self._problem), self._motion, self._problem.world, gauge)

        def relative(residual: _Residual) -> float:
            return residual.amount / self._findings.limit(residual.kind)

        worst: _Residual | None = None
        for row in self._rows(literal, "switch"):
            residual = self._residual(literal, row, sample)
            if residual is not None and (worst is None or relative(residual) > relative(worst)):
                worst = residual
        if worst is not None:
            self._findings.residuals.append(MeasureRecord(
                literal[0], worst.amount, self._findings.limit(worst.kind), unit_of(worst.kind),
                worst.time, list(literal[1:]), self._findings.place_of(worst.row.span),
            ))  # fmt: skip

    def _residual(self, literal: ir.Fact, row: ir.Row, sample: int) -> _Residual | None:
        names, at = self._names(literal), np.array([sample])
        try:
            left, right = (self._evaluate.value(side, names, at) for side in _sides(row))
        except MeaninglessRow as error:
            self._meaningless(literal, row, error)
            return None
        amount = max(0.0, float(_excess(left.values, right.values, row.operator)[0])) / _share(row)
        residual = _Residual(_switch_kind(row, left.unit or right.unit), amount, float(self._times[sample]), row)
        self._record(literal, residual)
        return residual


class _Phase(_Literals):
    """Rows during one phase."""

    def __init__(
        self, problem: ir.Problem, motion: Motion, sampler: Sampler, phase: int, findings: Findings, gauge: Gauge
    ) -> None:  # fmt: skip
        super().__init__(problem, findings)
        self._gauge = gauge
        self._shapes = shapes_of(problem)
        self._motion, self._sampler, self._phase = motion, sampler, phase
        self._first, _ = motion.ranges[phase]
        self._grid: Grid | None = None

    def measure(self, literal: ir.Fact, held: dict[ir.Row, _Held]) -> None:
        """Measure the during and keep rows of a literal; `held` tells what the latter hold constant, and is filled
        in."""
        for row in self._rows(literal, "during"):
            self._measure_row(literal, row)
        for row in self._rows(literal, "keep"):
            try:
                if isinstance(row.left, ir.Function) and row.left.name == "pose":
                    self._keep_pose(literal, row, held)
                else:
                    self._keep_value(literal, row, held)
            except MeaninglessRow as error:
                self._meaningless(literal, row, error)

    def _measure_row(self, literal: ir.Fact, row: ir.Row) -> None:
        names, kinds = self._names(literal), [""]

        def look(grid: Grid) -> Look:
            evaluate, strays = self._posed(grid, names)
            left, right = (evaluate.value(side, names, np.arange(len(grid.times))) for side in _sides(row))
            kinds[0] = "during_m" if (left.unit or right.unit) == "m" else "during"
            if _loads(row):
                kinds[0] = "load_share"
            excess = _excess(left.values, right.values, row.operator) / _share(row)
            stray = np.max(np.add(*(strays.of(side) for side in _sides(row))), axis=1) / _share(row)
            highest = np.maximum(excess[1:], excess[:-1]) + stray
            return Look(np.maximum(excess, 0.0), highest, self._findings.limit(kinds[0]))

        try:
            self._settle(literal, row, look, lambda: kinds[0])
        except MeaninglessRow as error:
            self._meaningless(literal, row, error)

    def _keep_value(self, literal: ir.Fact, row: ir.Row, held: dict[ir.Row, _Held]) -> None:
        names = self._names(literal)
        stored = Evaluator(self._shapes, self._motion, self._problem.world, self._gauge)
        value = stored.value(row.left, names, np.array([self._first]))
        kind = "slip_m" if value.unit == "m" else "slip_rad"
        begin = held.setdefault(row, value.values)
        assert not isinstance(begin, Frames)

        def look(grid: Grid) -> Look:
            evaluate, strays = self._posed(grid, names)
            found = evaluate.value(row.left, names, np.arange(len(grid.times))).values
            off = np.max(np.abs(found - begin), axis=1)
            stray = strays.of(row.left).max(axis=1)
            return Look(off, np.maximum(off[1:], off[:-1]) + stray, self._findings.limit(kind))

        self._settle(literal, row, look, lambda: kind)

    def _keep_pose(self, literal: ir.Fact, row: ir.Row, held: dict[ir.Row, _Held]) -> None:
        assert isinstance(row.left, ir.Function)
        own, base = (name_of(a, self._names(literal)) for a in row.left.args)
        here = slice(self._first, self._first + 1)
        now = self._motion.frames[own][here].relative_to(self._motion.frames[base][here])
        begin = held.setdefault(row, now)
        assert isinstance(begin, Frames)
        time = float(self._motion.times[self._first])
        drift = float(np.linalg.norm(now.position - begin.position)), float(angles(now.rotation, begin.rotation)[0])
        for kind, amount in zip(("slip_m", "slip_rad"), drift, strict=True):
            self._record(literal, _Residual(kind, amount, time, row))
        still = all(self._sampler.rests(self._sampler.mount(n)[0], self._phase) for n in (own, base))
        if still or self._sampler.links[self._phase].explain(base, own):
            return
        limits = self._findings.limit("slip_m"), self._findings.limit("slip_rad")
        slip = Slip(self._sampler, self._phase, own, base, begin, limits)
        self._settle(literal, row, slip.shift, lambda: "slip_m")
        self._settle(literal, row, slip.turn, lambda: "slip_rad")

    def _posed(self, grid: Grid, names: Mapping[str, str]) -> tuple[Evaluator, Strays]:
        placement = self._sampler.at(self._phase, grid.times)
        world = self._problem.world
        shown = Shown(placement, self._sampler.kinematics)
        evaluate = Evaluator(self._shapes, shown, world, self._gauge)
        bounds = Bounds(self._sampler, self._phase, grid, placement)
        return evaluate, Strays(self._sampler, bounds, self._shapes, evaluate, names, world)

    def _settle(
        self, literal: ir.Fact, row: ir.Row, look: Callable[[Grid], Look], kind: Callable[[], str]
    ) -> None:
        """Look closer until the limit is kept or broken for certain."""
        if self._grid is None:
            self._grid = self._sampler.grid(self._phase)
        settled = settle(self._grid, look, self._findings)
        if settled is None:
            time = float(self._motion.times[self._first])
            message = f"whether [{' '.join(literal)}] holds between instants cannot be decided"
            place = self._findings.place_of(row.span)
            self._findings.fail("undecided", message, time=time, between=literal[1:], place=place)
        else:
            self._record(literal, _Residual(kind(), *settled, row))


def _sides(row: ir.Row) -> tuple[ir.Term, ir.Term]:
    return row.left, row.right or ir.Number(0.0)


def _excess(left: Array, right: Array, operator: str) -> Array:
    """By how much a row is broken at each instant `(T,)`, the worst of its components; negative where it holds with
    something to spare."""
    difference = left - right
    if operator == "=":
        difference = np.abs(difference)
    elif operator in (">=", ">"):
        difference = -difference
    return np.asarray(np.max(np.nan_to_num(difference, nan=np.inf), axis=1))


def _switch_kind(row: ir.Row, unit: str) -> str:
    if _loads(row):
        return "load_share"
    functions = set(_functions(row.left)) | (set() if row.right is None else set(_functions(row.right)))
    if unit == "m":
        return "gap_m" if "gap" in functions else "position_m"
    return "orientation_rad" if "axis" in functions else "residual"


def _loads(row: ir.Row) -> bool:
    """Whether a row speaks of loads."""
    return any(name in LOADS for side in _sides(row) for name in _functions(side))


def _share(row: ir.Row) -> float:
    """What the excess of a row about loads is a share of: its bound, where that is a number above 1."""
    bounds = [abs(float(s.value)) for s in _sides(row) if isinstance(s, ir.Number)]
    return max([1.0, *bounds]) if _loads(row) else 1.0


def _functions(node: ir.Term) -> Iterator[str]:
    match node:
        case ir.Function():
            yield node.name
            for argument in node.args:
                yield from _functions(argument)
        case ir.Arith():
            for operand in node.operands:
                yield from _functions(operand)
        case ir.Vector():
            for item in node.items:
                yield from _functions(item)
