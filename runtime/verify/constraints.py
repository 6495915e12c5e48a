"""The motion predicates of a plan, measured anew: rows at switches, rows during intervals, and what stays constant."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from ...compiler import ir
from ..plan import MeasureRecord, Plan
from .findings import Findings, place_of
from .geometry import Array, Indices, angles
from .happenings import Happenings, kept
from .kinematics import Motion
from .limits import LIMITS, unit_of
from .replay import Story
from .rows import Evaluator, MeaninglessRow, Quantity, name_of


def check_constraints(
    problem: ir.Problem, plan: Plan, story: Story, motion: Motion, happenings: Happenings, findings: Findings
) -> None:
    """Measure every motion literal of the story on the samples of the plan. What keeps a body to another one means
    nothing while it goes its own way."""
    checker = _Checker(problem, motion, findings)
    for index, added in enumerate(story.added[: len(plan.phases)]):
        for literal in sorted(added):
            checker.at_switch(literal, motion.ranges[index][1])
    for literal, first, last in intervals(story, motion):
        phase = next(k for k, (_, end) in enumerate(motion.ranges) if first <= end)
        free = happenings.free[phase] if happenings.free else frozenset[str]()
        if not any(own in free and base in problem.world.bodies for base, own in kept(problem, [literal])):
            checker.during(literal, first, last)


def intervals(story: Story, motion: Motion) -> Iterator[tuple[ir.Fact, int, int]]:
    """Every motion literal with the first and last sample of each unbroken interval in which it holds."""
    open_since: dict[ir.Fact, int] = {}
    for index, mode in enumerate(story.modes[: len(motion.ranges)]):
        first, _ = motion.ranges[index]
        for literal in sorted(set(open_since) - mode):
            yield literal, open_since.pop(literal), first - 1
        for literal in sorted(mode):
            open_since.setdefault(literal, first)
    for literal in sorted(open_since):
        yield literal, open_since[literal], len(motion.times) - 1


def shapes_of(problem: ir.Problem) -> dict[str, ir.Shape | None]:
    """The shape of every body and effector."""
    found: dict[str, ir.Shape | None] = {b.name: b.shape for b in problem.world.bodies.values()}
    for module in problem.world.modules.values():
        found[module.name] = None
        found |= {f"{module.name}.{e.name}": e.shape for e in module.type.effectors}
    return found


_KindOf = Callable[[ir.Row, str], str]
"""Names the measure of a row from the row and its unit."""


@dataclass(frozen=True, slots=True)
class _Residual:
    kind: str
    amount: float
    sample: int
    row: ir.Row


class _Checker:
    def __init__(self, problem: ir.Problem, motion: Motion, findings: Findings) -> None:
        self._problem = problem
        self._motion = motion
        self._findings = findings
        self._evaluate = Evaluator(shapes_of(problem), motion, problem.world)

    def at_switch(self, literal: ir.Fact, sample: int) -> None:
        """Measure the switch rows of a literal at the sample where it is added."""
        worst: _Residual | None = None
        for row in self._rows(literal, "switch"):
            residual = self._measure(literal, row, np.array([sample]), _switch_kind)
            if residual is not None and (worst is None or _relative(residual) > _relative(worst)):
                worst = residual
        if worst is not None:
            self._findings.residuals.append(MeasureRecord(
                literal[0], worst.amount, LIMITS[worst.kind], unit_of(worst.kind),
                float(self._motion.times[sample]), list(literal[1:]), place_of(worst.row.span),
            ))  # fmt: skip

    def during(self, literal: ir.Fact, first: int, last: int) -> None:
        """Measure the during and keep rows of a literal on samples `first` … `last`."""
        samples = np.arange(first, last + 1)
        for row in self._rows(literal, "during"):
            self._measure(literal, row, samples, lambda _, unit: "during_m" if unit == "m" else "during")
        for row in self._rows(literal, "keep"):
            self._keep(literal, row, samples)

    def _rows(self, literal: ir.Fact, when: str) -> list[ir.Row]:
        return [r for r in self._problem.motions[literal[0]].rows if r.when == when]

    def _names(self, literal: ir.Fact) -> dict[str, str]:
        variables = self._problem.motions[literal[0]].variables
        return dict(zip((v.name for v in variables), literal[1:], strict=True))

    def _measure(
        self, literal: ir.Fact, row: ir.Row, samples: Indices, kind_of: _KindOf
    ) -> _Residual | None:
        try:
            left = self._evaluate.value(row.left, self._names(literal), samples)
            right = self._evaluate.value(row.right or ir.Number(0.0), self._names(literal), samples)
        except MeaninglessRow as error:
            self._findings.fail("constraint", f"[{' '.join(literal)}]: {error}", place=place_of(row.span))
            return None
        amounts = _excess(left, right, row.operator)
        at = int(np.argmax(amounts))
        kind = kind_of(row, left.unit or right.unit)
        residual = _Residual(kind, float(amounts[at]), int(samples[at]), row)
        self._record(literal, residual)
        return residual

    def _record(self, literal: ir.Fact, residual: _Residual) -> None:
        time = float(self._motion.times[residual.sample])
        message = f"[{' '.join(literal)}] does not hold"
        self._findings.measure(
            residual.kind, residual.amount, message,
            time=time, between=literal[1:], place=place_of(residual.row.span),
        )  # fmt: skip

    def _keep(self, literal: ir.Fact, row: ir.Row, samples: Indices) -> None:
        left, names = row.left, self._names(literal)
        try:
            if isinstance(left, ir.Function) and left.name == "pose":
                if all(self._motion.rests(name_of(a, names), int(samples[0]), int(samples[-1])) for a in left.args):
                    samples = samples[:1]
                own, base = (self._evaluate.frame(a, names, samples) for a in left.args)
                relative = own.relative_to(base)
                shift = np.linalg.norm(relative.position - relative.position[0], axis=1)
                turn = angles(relative.rotation, relative.rotation[:1])
                drifts = {"slip_m": shift, "slip_rad": turn}
            else:
                value = self._evaluate.value(left, names, samples)
                change = np.max(np.abs(value.values - value.values[0]), axis=1)
                drifts = {"slip_m" if value.unit == "m" else "slip_rad": change}
        except MeaninglessRow as error:
            self._findings.fail("constraint", f"[{' '.join(literal)}]: {error}", place=place_of(row.span))
            return
        for kind, drift in drifts.items():
            at = int(np.argmax(drift))
            self._record(literal, _Residual(kind, float(drift[at]), int(samples[at]), row))


def _excess(left: Quantity, right: Quantity, operator: str) -> Array:
    """By how much a row is broken at each sample `(T,)`, the worst of its components."""
    difference = left.values - right.values
    if operator == "=":
        difference = np.abs(difference)
    elif operator in (">=", ">"):
        difference = -difference
    return np.asarray(np.max(np.maximum(np.nan_to_num(difference, nan=np.inf), 0.0), axis=1))


def _switch_kind(row: ir.Row, unit: str) -> str:
    functions = set(_functions(row.left)) | (set() if row.right is None else set(_functions(row.right)))
    if unit == "m":
        return "gap_m" if "gap" in functions else "position_m"
    return "orientation_rad" if "axis" in functions else "residual"


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


def _relative(residual: _Residual) -> float:
    return residual.amount / LIMITS[residual.kind]
