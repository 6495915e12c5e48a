"""How near each module, with what it holds, comes to what is not of its robot: least distance, where and when.

What a module stands on, holds or is docked to in a phase, or in the one before, or takes hold of at its end, is left
out for the parts that move with that effector, and for those a joint away: there contact is meant, and links begin as
far from it as the module is built.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from ...compiler.ir import BreakdownKind, Shape, ShapeKind
from ...langs.frozen import dataclass
from ..geometry.exact_distances import Distances, Forms, Posed, distances
from ..geometry.transforms import Array, compose, rotate
from ..plan import LiteralRecord, Plan, ShapeRecord
from ..tracks import body_rows
from .kinematics import joint_frames, pose_rows
from .replay import joint_rows
from .robots import effector_owners, group_modules

MOST_POINTS, FEWEST_POINTS = 120, 24
"""Instants of a curve: what a plot shows, and what large scenes get."""
MOST_PAIRS = 400_000
"""Distances that are looked at for the curves of a plan."""
SIZES = {ShapeKind.BOX: 3, ShapeKind.SPHERE: 1, ShapeKind.CAPSULE: 2, ShapeKind.CYLINDER: 2}
Node = tuple[str, int]
"""What literals join: the parts that a joint of a module moves, by the module's name, or a body, with -2."""
BODY = -2


@dataclass(frozen=True, slots=True)
class Clearance:
    """Of one module: `distance` (T,) metres at `times` (T,) seconds, negative in an overlap and infinite where nothing
    else is there, and `between` which two things it is."""

    module: str
    times: Array
    distance: Array
    between: list[tuple[str, str]]


@dataclass(frozen=True, slots=True)
class _Moving:
    """A shape that moves as one: its poses (T, 7), and whether it is there at each time (T,)."""

    name: str
    node: Node
    shape: Shape
    poses: Array
    there: NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class ClearancePlot:
    """A clearance over time in a box of 1000 by 100, `zero_y` where things touch; and the least one."""

    module: str
    path: str
    zero_y: float
    least: float
    time: float
    first: str
    second: str
    marks: list[tuple[float, str]]
    """Where numbers stand at the axis, in percent from above, and what they say."""


def build_clearance(plan: Plan) -> list[ClearancePlot]:
    """The curve of every module that something else is near to."""
    return [_plot(c, plan.times[-1]) for c in clearances(plan) if np.isfinite(c.distance).any()]


def _plot(found: Clearance, total: float) -> ClearancePlot:
    known = np.flatnonzero(np.isfinite(found.distance))
    low, high = min(0.0, float(found.distance[known].min())), max(1e-9, float(found.distance[known].max()))

    def height(value: float) -> float:
        return round(4.0 + 92.0 * (high - value) / (high - low), 2)

    across = 1000.0 * found.times / max(total, 1e-9)
    path = " ".join(f"{across[k]:.1f},{height(float(found.distance[k]))}" for k in known)
    worst = int(known[found.distance[known].argmin()])
    least, time = float(found.distance[worst]), float(found.times[worst])
    marks = [(height(high), f"{high:.3g} m"), (height(0.0), "0")]
    return ClearancePlot(found.module, path, height(0.0), least, time, *found.between[worst], marks)


def clearances(plan: Plan) -> list[Clearance]:
    """The clearance of every module at instants of the plan. Raises MissingLibrary."""
    if not plan.times or not plan.phases or not plan.modules:
        return []
    count = sum(len(m.links) + len(m.effectors) for m in plan.modules) * (len(plan.bodies) + 1)
    points = min(MOST_POINTS, max(FEWEST_POINTS, MOST_PAIRS // max(count, 1)))
    chosen = np.unique(np.linspace(0, len(plan.times) - 1, points).astype(int))
    times = np.asarray(plan.times, dtype=float)[chosen]
    parts = [*_module_parts(plan, chosen, times), *_body_parts(plan, chosen)]
    forms = Forms(list(dict.fromkeys(p.shape for p in parts)))
    form = {shape: k for k, shape in enumerate(forms.shapes)}
    found = {m.name: (np.full(len(times), math.inf), [("", "")] * len(times)) for m in plan.modules}
    for index, inside in _phases(plan, times):
        joined = _joined(plan, index)
        held = _held(plan, index)
        robots = group_modules(plan, plan.phases[index].mode)
        for robot in robots:
            names = {plan.modules[k].name for k in robot.modules}
            own = [p for p in parts if held.get(p.node[0], p.node[0]) in names]
            rest = [p for p in parts if held.get(p.node[0], p.node[0]) not in names]
            for name in names:
                mine = [p for p in own if held.get(p.node[0], p.node[0]) == name]
                pairs = [(a, b) for a in mine for b in rest if frozenset((a.node, b.node)) not in joined]
                _least(pairs, inside, forms, form, *found[name])
    return [Clearance(name, times, *found[name]) for name in found]


def _least(
    pairs: Sequence[tuple[_Moving, _Moving]], inside: NDArray[np.intp], forms: Forms, form: dict[Shape, int],
    distance: Array, between: list[tuple[str, str]],
) -> None:  # fmt: skip
    """Enter the least distance of the pairs at each of the instants `inside`."""
    if not pairs or not len(inside):
        return
    posed = [_posed([pair[k] for pair in pairs], inside, forms, form) for k in range(2)]
    shape = len(pairs), len(inside)
    there = np.array([a.there[inside] & b.there[inside] for a, b in pairs])
    bounds = distances(posed[0], posed[1], np.full(there.size, -math.inf)).value.reshape(shape)
    bounds[~there] = math.inf
    nearest = bounds.argmin(axis=0), np.arange(shape[1])
    flat = np.ravel_multi_index(nearest, shape)
    least = _measured(posed, flat).value
    looked = np.flatnonzero((bounds <= least) & there)
    values = np.full(there.size, math.inf)
    values[looked] = _measured(posed, looked).value
    values = values.reshape(shape)
    for k, best in enumerate(values.argmin(axis=0)):
        if values[best, k] < math.inf:
            distance[inside[k]] = values[best, k]
            between[inside[k]] = pairs[best][0].name, pairs[best][1].name


def _measured(posed: Sequence[Posed], which: NDArray[np.intp]) -> Distances:
    return distances(posed[0][which], posed[1][which], np.full(len(which), math.inf))


def _posed(parts: Sequence[_Moving], inside: NDArray[np.intp], forms: Forms, form: dict[Shape, int]) -> Posed:
    poses = np.concatenate([p.poses[inside] for p in parts])
    turned = rotate(poses[:, None, 3:], np.eye(3)[None]).transpose(0, 2, 1)
    kinds = np.repeat([form[p.shape] for p in parts], len(inside))
    return Posed(forms, kinds, poses[:, :3], turned)


def _phases(plan: Plan, times: Array) -> Iterator[tuple[int, NDArray[np.intp]]]:
    """Each phase with the instants in it; a switch belongs to the phase that it ends."""
    ends = np.array([p.end for p in plan.phases])
    index = np.minimum(np.searchsorted(ends, times - 1e-9), len(ends) - 1)
    for phase in range(len(ends)):
        yield phase, np.flatnonzero(index == phase)


def _joined(plan: Plan, phase: int) -> set[frozenset[Node]]:
    """Pairs of nodes that the literals around a phase name together."""
    nodes: dict[str, set[Node]] = {b.name: {(b.name, BODY)} for b in plan.bodies}
    for module in plan.modules:
        parents = [j.parent for j in module.joints]
        for effector in module.effectors:
            near = {effector.joint, *(k for k, parent in enumerate(parents) if parent == effector.joint)}
            near |= {parents[effector.joint]} if 0 <= effector.joint < len(parents) else set()
            nodes[f"{module.name}.{effector.name}"] = {(module.name, k) for k in near}
    told: list[LiteralRecord] = []
    for record in plan.phases[max(0, phase - 1) : phase + 1]:
        told += [*record.mode, *record.added]
    found: set[frozenset[Node]] = set()
    for literal in told:
        named = [nodes[a] for a in literal.args if a in nodes]
        found |= {frozenset((a, b)) for one in named for other in named if one is not other for a in one for b in other}
    return found


def _held(plan: Plan, phase: int) -> dict[str, str]:
    """Movable bodies that an effector holds in a phase, and the module whose it is."""
    owners, movable = effector_owners(plan), {b.name for b in plan.bodies if b.movable}
    found: dict[str, str] = {}
    for literal in plan.phases[phase].mode:
        ends = [plan.modules[owners[a]].name for a in literal.args if a in owners]
        found |= {a: ends[0] for a in literal.args if ends and a in movable}
    return found


def _module_parts(plan: Plan, chosen: NDArray[np.intp], times: Array) -> Iterator[_Moving]:
    tracks = {t.name: t for t in plan.tracks}
    for module in plan.modules:
        track = tracks.get(module.name)
        picked = [min(int(i), len(track.poses) - 1) for i in chosen] if track and track.poses else []
        base = pose_rows([track.poses[i] for i in picked] if track and picked else [module.pose] * len(chosen))
        rows = [track.joints[min(i, len(track.joints) - 1)] for i in picked] if track and track.joints else []
        joints = joint_rows(rows or [module.start] * len(chosen), module.start, len(module.joints))
        frames = joint_frames(module, base, joints)
        left = [b.time for b in plan.breakdowns if b.module == module.name and b.kind == BreakdownKind.GONE]
        there = times <= min(left, default=math.inf)
        named = [(f"{module.name}, link {k + 1}", x.joint, x.shape, x.placement) for k, x in enumerate(module.links)]
        named += [(f"{module.name}.{e.name}", e.joint, e.shape, e.placement) for e in module.effectors if e.shape]
        for name, joint, record, placement in named:
            frame = frames[min(max(joint + 1, 0), len(frames) - 1)]
            place = compose(frame, np.broadcast_to(pose_rows([placement])[0], frame.shape))
            for part in record.solids:
                shape = _shape(part.shape)
                if shape is not None and len(part.at) == 3:
                    local = np.broadcast_to([*part.at, 0.0, 0.0, 0.0, 1.0], place.shape)
                    yield _Moving(name, (module.name, joint), shape, compose(place, local), there)


def _body_parts(plan: Plan, chosen: NDArray[np.intp]) -> Iterator[_Moving]:
    tracks, there = body_rows(plan), np.ones(len(chosen), dtype=bool)
    for body in plan.bodies:
        for part in body.shape.solids if body.collides else []:
            shape = _shape(part.shape)
            if shape is not None and len(part.at) == 3:
                rows = tracks.get(body.name) or [body.pose]
                poses = pose_rows([rows[min(int(i), len(rows) - 1)] for i in chosen])
                local = np.broadcast_to([*part.at, 0.0, 0.0, 0.0, 1.0], poses.shape)
                yield _Moving(body.name, (body.name, BODY), shape, compose(poses, local), there)


def _shape(record: ShapeRecord | None) -> Shape | None:
    """The shape, unless the file holds what is none."""
    if record is None or record.kind not in set(ShapeKind) or not all(map(math.isfinite, record.size)):
        return None
    kind, size = ShapeKind(record.kind), tuple(record.size)
    if kind == ShapeKind.CONVEX:
        return Shape(kind, size) if len(size) >= 12 and len(size) % 3 == 0 else None
    return Shape(kind, size) if len(size) == SIZES[kind] and min(size) > 0.0 else None
