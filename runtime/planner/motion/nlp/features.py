"""Rows of a skeleton to groups of a program: motion literals, joint limits, norms and costs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import field
from typing import Any

import numpy as np

from .....compiler import ir
from .....compiler.ir import Fact, Problem, ShapeKind
from .....compiler.motion.constraints import BodyKind, EffectorKind, Kind, RestKind, arguments, stage, units
from .....compiler.motion.loaded_rows import speaks_of_loads
from .....compiler.motion.stages import Stage
from .....langs.frozen import dataclass
from ....skeleton import Array, Breach
from .row_groups import LinearGroup, LinearWish, NormGroup, RowGroup, RowLabel, StageGroup
from .settings import SOLVER
from .unknowns import Indices, UnknownsLayout


@dataclass(slots=True)
class _Instances:
    """Instances of one stage Function that await batching."""

    kind: str
    stage: Stage
    scale: float
    places: list[Indices] = field(default_factory=list)
    constants: list[Array] = field(default_factory=list)
    labels: list[RowLabel] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class _Argument:
    """A resolved argument: its key for caching, its slot's name ("" for none), kind without slot, constants."""

    key: tuple[str | ir.Shape, ...]
    slot: str
    kind: Kind
    constants: Array


class Features:
    """Collects the rows that bind on a layout's slices and batches like ones."""

    def __init__(self, problem: Problem, layout: UnknownsLayout) -> None:
        self.problem = problem
        self.layout = layout
        self._instances: dict[Any, _Instances] = {}
        self._arguments: dict[str, _Argument] = {}
        self._rows: dict[str, list[tuple[ir.Row, tuple[str, ...], tuple[str, ...]]]] = {}
        self._done: set[tuple[Any, ...]] = set()

    def _resolve(self, name: str) -> _Argument:
        if name not in self._arguments:
            self._arguments[name] = self._argument(name)
        return self._arguments[name]

    def _argument(self, name: str) -> _Argument:
        world = self.problem.world
        found = world.effector(name)
        if found:
            module, effector = found
            kind = EffectorKind(module.type, effector.name, 0)
            return _Argument(("effector", module.type.name, effector.name), module.name, kind, np.zeros(0))
        if name in world.modules:
            module = world.modules[name]
            return _Argument(("module", module.type.name), name, EffectorKind(module.type, "", 0), np.zeros(0))
        body = world.bodies[name]
        whole = body.shape.kind == ShapeKind.CONVEX
        shape = body.shape if whole else body.shape.kind
        size = np.array(() if whole else body.shape.size)
        weight = () if body.mass is None else (str(body.mass),)
        if body.movable:
            return _Argument(("body", shape, *weight), name, BodyKind(shape, 0, body.mass), size)
        pose = self.layout.resting[name]
        return _Argument(("rest", shape, *weight), "", RestKind(shape, body.mass), np.concatenate([pose, size]))

    def _rows_of(self, predicate: str) -> list[tuple[ir.Row, tuple[str, ...], tuple[str, ...]]]:
        if predicate not in self._rows:
            motion = self.problem.motions[predicate]
            self._rows[predicate] = [(row, arguments(row, motion.variables), units(row)) for row in motion.rows]
        return self._rows[predicate]

    def add(self, literal: Fact, when: str, slices: tuple[int, ...], phase: int, scale: float = 1.0) -> None:
        """Bind the rows of `literal` of one kind ("switch", "during", "keep") on the given slices: one slice, or for
        keep rows the earlier and the later."""
        motion = self.problem.motions[literal[0]]
        binding = {v.name: o for v, o in zip(motion.variables, literal[1:], strict=True)}
        for number, (row, names, row_units) in enumerate(self._rows_of(literal[0])):
            if row.when == when and not speaks_of_loads(row):
                objects = tuple(binding.get(n, n) for n in names)
                label = RowLabel(phase, Breach.ROW, literal, row_units, row.span)
                self._bind(literal, number, row, names, objects, slices, label, scale)

    def _bind(
        self, literal: Fact, number: int, row: ir.Row, names: tuple[str, ...], objects: tuple[str, ...],
        slices: tuple[int, ...], label: RowLabel, scale: float,
    ) -> None:  # fmt: skip
        arguments_ = [self._resolve(o) for o in objects]
        slots = list(dict.fromkeys(a.slot for a in arguments_ if a.slot))
        if row.when == "keep" and all(len({self.layout.offset(t, s) for t in slices}) == 1 for s in slots):
            return
        same = (literal[0], number, frozenset(objects) if row.when == "keep" else objects, slices)
        if same in self._done:
            return
        self._done.add(same)
        places = [np.concatenate([self.layout.slot(t, s) for s in slots]) for t in slices if slots]
        numbers = tuple(slots.index(a.slot) if a.slot else -1 for a in arguments_)
        key = (literal[0], number, tuple(a.key for a in arguments_), numbers, scale)
        if key not in self._instances:
            kinds = tuple(self._numbered(a.kind, n) for a, n in zip(arguments_, numbers, strict=True))
            kind = "inequality" if row.operator in ("<=", ">=") else "equality"
            self._instances[key] = _Instances(kind, stage(row, names, kinds), scale)
        instances = self._instances[key]
        instances.places.append(np.concatenate(places) if places else np.zeros(0, dtype=np.int64))
        instances.constants.append(np.concatenate([a.constants for a in arguments_]))
        instances.labels.append(label)

    @staticmethod
    def _numbered(kind: Kind, slot: int) -> Kind:
        match kind:
            case EffectorKind(type=module, effector=effector):
                return EffectorKind(module, effector, slot)
            case BodyKind(shape=shape, mass=mass):
                return BodyKind(shape, slot, mass)
        return kind

    def groups(self) -> list[RowGroup]:
        """All literals' rows, batched."""
        return [
            StageGroup(i.kind, i.stage, np.array(i.places), np.array(i.constants), i.labels, i.scale)
            for i in self._instances.values()
        ]


def _unknown_slots(layout: UnknownsLayout, names: list[str], slices: range) -> list[tuple[int, str]]:
    """The distinct unknown slots, each with the first slice in which it stands."""
    seen: dict[int, tuple[int, str]] = {}
    for t in slices:
        for name in names:
            if layout.is_unknown(t, name):
                seen.setdefault(layout.slices[t][name], (t, name))
    return list(seen.values())


def norms(layout: UnknownsLayout) -> NormGroup:
    """Unit quaternions of all unknown slots."""
    slots = _unknown_slots(layout, layout.names, range(len(layout.slices)))
    places = [layout.slot(t, name)[3:7] for t, name in slots]
    return NormGroup(np.array(places, dtype=np.int64).reshape(-1, 4))


def limits(problem: Problem, layout: UnknownsLayout, margin: float, phase_of: list[int]) -> LinearGroup:
    """Joint limits, pulled in by `margin` (rad; of a prismatic joint by a hundredth of its range, if that is less), but
    no further than where a joint is at the start. `phase_of` maps a slice to its phase."""
    places, signs, targets, labels = [], [], [], []
    for t, name in _unknown_slots(layout, layout.modules, range(len(layout.slices))):
        slot, module = layout.slot(t, name), problem.world.modules[name]
        for entry in layout.joints(name).tolist():
            joint, start = module.type.joints[entry - 7], module.joints[entry - 7]
            pull = min(margin, 0.01 * (joint.upper - joint.lower))
            lower = max(joint.lower, min(joint.lower + pull, start))
            upper = min(joint.upper, max(joint.upper - pull, start))
            label = RowLabel(phase_of[t], Breach.JOINT_LIMIT, (name, joint.name), (joint.unit,))
            places += [slot[entry], slot[entry]]
            signs += [1.0, -1.0]
            targets += [upper, -lower]
            labels += [label, label]
    columns = np.array(places, dtype=np.int64).reshape(-1, 1)
    return LinearGroup("inequality", columns, np.array(signs).reshape(-1, 1), np.array(targets), labels)


def kept_limits(
    problem: Problem, layout: UnknownsLayout, margin: float, phase_of: list[int], least: float = 0.0
) -> list[LinearGroup]:
    """Joint limits as rows, `least` within them, and the wish that joints keep `margin` from them: what can be reached
    at a limit alone is done there."""
    wished = limits(problem, layout, margin, phase_of)
    return [limits(problem, layout, least, phase_of), LinearWish(wished, SOLVER.limit_wish)]


def homing(problem: Problem, layout: UnknownsLayout, scale: float) -> LinearGroup:
    """½ scale² Σ (q − home)² over the joints of all unknown slots."""
    places, targets = [], []
    for t, name in _unknown_slots(layout, layout.modules, range(len(layout.slices))):
        places.append(layout.slot(t, name)[layout.joints(name)])
        targets += [j.home for j in problem.world.modules[name].type.joints if j.follows is None]
    columns = np.concatenate(places).reshape(-1, 1) if places else np.zeros((0, 1), dtype=np.int64)
    return LinearGroup("cost", columns, np.ones((1, 1)), np.array(targets), [], scale)


def differences(
    layout: UnknownsLayout, names: Sequence[str], slices: Sequence[tuple[int, ...]], coefficients: tuple[float, ...],
    scale: float,
) -> LinearGroup:  # fmt: skip
    """½ scale² Σ (Σ coefficient · joint values)² over tuples of slices: velocities (−1, 1), accelerations
    (1, −2, 1)."""
    rows = []
    for group in slices:
        for name in names:
            if any(layout.is_unknown(t, name) for t in group):
                rows.append(np.stack([layout.slot(t, name)[layout.joints(name)] for t in group], axis=1))
    width = len(coefficients)
    places = np.concatenate(rows) if rows else np.zeros((0, width), dtype=np.int64)
    return LinearGroup("cost", places, np.array([coefficients]), np.zeros(len(places)), [], scale)
