"""What joints and kept pairs bear at rest, by the work of weights: a joint or pair alone bears what would fall without
it. Closed loops share their loads, and are left out; so is inertia."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tamplang.compiler import ir

from .motion import Fact, Keep, Moving
from .rows import volume
from .shapes import solid_of

Matrix = NDArray[np.float64]
Node = tuple[str, int]
Edge = tuple[Node, Node, tuple[str, str], int]
"""Two nodes, the names of what joins them, and the index of a joint, -1 of a kept pair."""
WORLD: Node = ("", -1)
WATER, GRAVITY, LOOKS = 1000.0, 9.81, 13
ROOM = 1.001
"""By which a load may be more than its strength, for rounding."""
STILL = 1e-5


def mass_of(shape: ir.Shape | None, stated: float | None) -> float:
    if shape is None:
        return 0.0
    if stated is not None:
        return stated
    boxes = [(np.subtract(b.at, np.divide(b.shape.size, 2)), np.add(b.at, np.divide(b.shape.size, 2)))
             for b in shape.parts if b.shape.kind == "box"]  # fmt: skip
    others = [p.shape for p in shape.solids if p.shape.kind != "box" or not shape.parts]
    filled = sum(float(np.prod(high - low)) for low, high in _apart(boxes))
    return WATER * (filled + sum(volume(solid_of(s.kind, list(s.size))) for s in others))


def _apart(boxes: Sequence[tuple[Matrix, Matrix]]) -> list[tuple[Matrix, Matrix]]:
    """Boxes, by their least and greatest corners, that fill the same space and do not overlap: each box without those
    before it."""
    made: list[tuple[Matrix, Matrix]] = []
    for box in boxes:
        left = [box]
        for low, high in list(made):
            left = [piece for one in left for piece in _without(one, low, high)]
        made += left
    return made


def _without(box: tuple[Matrix, Matrix], low: Matrix, high: Matrix) -> Iterator[tuple[Matrix, Matrix]]:
    """What is left of a box beside another one, cut along one axis after the other."""
    near, far = box[0].astype(float), box[1].astype(float)
    if (near >= high).any() or (far <= low).any():
        yield near, far
        return
    for axis in range(3):
        for cut, below in ((low[axis], True), (high[axis], False)):
            if near[axis] < cut < far[axis]:
                first, second = near.copy(), far.copy()
                (second if below else first)[axis] = cut
                yield first, second
                (near if below else far)[axis] = cut


def weights(problem: ir.Problem) -> Iterator[tuple[Node, Matrix, float]]:
    """Every weight: its node, its place (3,) there, and kilograms."""
    for name, module in problem.world.modules.items():
        kind = module.type
        for end in kind.effectors:
            yield (name, end.joint), np.array(end.placement[:3]), mass_of(end.shape, end.mass)
        for link in kind.links:
            yield (name, link.joint), np.array(link.placement[:3]), mass_of(link.shape, link.mass)
        for joint in kind.joints:
            yield (name, joint.parent), np.array(joint.placement[:3]), joint.mass
        for given in kind.inertials:
            yield (name, given.joint), np.array(given.centre), given.mass
    for name, body in problem.world.bodies.items():
        if body.movable:
            yield (name, -1), np.zeros(3), mass_of(body.shape, body.mass)


def total(problem: ir.Problem, motion: Moving, name: str) -> tuple[float, Matrix]:
    """Kilograms and the middle of mass (T, 3) of a body or of a whole module."""
    own = [(node, at, mass) for node, at, mass in weights(problem) if node[0] == name]
    whole = sum(mass for _, _, mass in own)
    count = len(motion.times)
    middle = sum((mass * _point(motion, node, at, count) for node, at, mass in own), np.zeros((count, 3)))
    return whole, middle / max(whole, 1e-12)


def _frame(motion: Moving, node: Node, count: int) -> Matrix:
    name, joint = node
    if node == WORLD:
        return np.tile(np.eye(4), (count, 1, 1))
    frames = motion.frames[name]
    frames = frames if name not in motion.parts else frames @ motion.parts[name][joint]
    return np.broadcast_to(frames, (count, 4, 4))


def _point(motion: Moving, node: Node, at: Matrix, count: int) -> Matrix:
    frames = _frame(motion, node, count)
    return np.asarray(frames[:, :3, :3] @ at + frames[:, :3, 3])


def overloads(
    problem: ir.Problem, plan: Mapping[str, Any], number: int, motion: Moving, keeps: Sequence[Keep],
    mode: Sequence[Fact],
) -> Iterator[tuple[str, str, float, float]]:  # fmt: skip
    """Drives, bearings and pairs of a phase that bear more than they can, times the safety of the task; with inertia at
    the end of the phase only, where everything rests. And told torques that are others."""
    if problem.options.physics in (None, "none"):
        return
    safety = 1.5 if problem.options.safety is None else problem.options.safety
    count = len(motion.times)
    still = problem.options.physics == "statics"
    looks = np.unique(np.linspace(0, count - 1, LOOKS).astype(int)) if still else np.array([count - 1])
    manners = {
        frozenset(fact[1:3]): problem.motions[fact[0]].borne for fact in sorted(mode, reverse=True)
        if problem.motions[fact[0]].borne is not None
    }  # fmt: skip
    edges = list(_edges(problem, keeps, manners, motion.standing))
    masses = list(weights(problem))
    for edge in edges:
        far = _beyond(edges, edge)
        if not far:
            continue
        own = [(node, at, mass) for node, at, mass in masses if node in far]
        whole = sum(mass for _, _, mass in own)
        moment = np.zeros((len(looks), 3))
        for node, at, mass in own:
            moment += mass * _point(motion, node, at, count)[looks]
        sign = 1.0 if edge[1] in far else -1.0
        if edge[3] >= 0:
            yield from _joint(problem, plan, number, motion, edge, (whole, moment, sign, safety, looks, still))
        else:
            manner = manners.get(frozenset(edge[2])) or ""
            yield from _pair(problem, motion, edge, manner, (whole, moment, safety, looks))


def _edges(
    problem: ir.Problem, keeps: Sequence[Keep], manners: Mapping[frozenset[str], str | None], standing: set[str]
) -> Iterator[Edge]:
    def base(name: str, joint: int) -> Node:
        return WORLD if joint < 0 and name in standing else (name, joint)

    for name, module in problem.world.modules.items():
        for index, joint in enumerate(module.type.joints):
            yield base(name, joint.parent), (name, index), (name, joint.name), index
    seen = set()
    for keep in keeps:
        near, far = base(*_node(problem, keep.leader)), base(*_node(problem, keep.follower))
        pair = frozenset((keep.leader, keep.follower))
        if near != far and pair not in seen and manners.get(pair) != "nothing":
            seen.add(pair)
            yield near, far, (keep.leader, keep.follower), -1


def _node(problem: ir.Problem, name: str) -> Node:
    end = problem.world.effector(name)
    if end is not None:
        return end[0].name, end[1].joint
    body = problem.world.bodies.get(name)
    return WORLD if body is not None and not body.movable else (name, -1)


def _beyond(edges: Sequence[Edge], without: Edge) -> set[Node]:
    """What falls when an edge is taken away."""

    def reached(left: Sequence[Edge]) -> set[Node]:
        found, waiting = {WORLD}, [WORLD]
        while waiting:
            here = waiting.pop()
            more = {b if a == here else a for a, b, _, _ in left if here in (a, b)} - found
            found |= more
            waiting += more
        return found

    return reached(edges) - reached([e for e in edges if e is not without])


def _joint(
    problem: ir.Problem, plan: Mapping[str, Any], number: int, motion: Moving, edge: Edge,
    load: tuple[float, Matrix, float, float, Matrix, bool],
) -> Iterator[tuple[str, str, float, float]]:  # fmt: skip
    whole, moment, sign, safety, looks, still = load
    name, joint_name = edge[2]
    joint = problem.world.modules[name].type.joints[edge[3]]
    frame = _frame(motion, edge[1], len(motion.times))[looks]
    axis = frame[:, :3, :3] @ (np.asarray(joint.axis) / np.linalg.norm(joint.axis))
    lever = moment - whole * frame[:, :3, 3]
    turning = np.cross(lever, [0.0, 0.0, -GRAVITY])
    revolute = joint.kind == ir.JointKind.REVOLUTE
    along = (turning * axis).sum(axis=1) if revolute else -GRAVITY * whole * axis[:, 2]
    moved = float(np.ptp(motion.joints[name][:, edge[3]])) > STILL
    strength = joint.torque if moved else max(joint.torque, joint.brake)
    where = f"{joint_name} of {name} in phase {number}"
    worst = safety * float(np.abs(along).max())
    if worst > ROOM * strength:
        yield "torque_ratio", where, worst / strength, 1.0
    across = turning - axis * along[:, None] if revolute else turning
    bent = safety * float(np.linalg.norm(across, axis=1).max())
    if bent > ROOM * joint.bearing:
        yield "bearing_ratio", where, bent / joint.bearing, 1.0
    told = [t for t in plan.get("statics", {}).get("torques", ()) if (t["module"], t["phase"]) == (name, number)]
    for record in told if still else ():
        rows = np.array(record["values"], dtype=float)[:, edge[3]]
        share = (motion.times[looks] - motion.times[0]) / (motion.times[-1] - motion.times[0])
        off = np.interp(share, np.linspace(0.0, 1.0, len(rows)), rows) + sign * along
        bend = 0.01 * float(np.abs(rows).max()) + 0.01
        if float(np.abs(off).max()) > bend:
            yield "statics", f"told torque of {where}", float(np.abs(off).max()), bend


def _pair(
    problem: ir.Problem, motion: Moving, edge: Edge, manner: str, load: tuple[float, Matrix, float, Matrix]
) -> Iterator[tuple[str, str, float, float]]:
    """Forces that no direction bears, and of feet the moment: weights turn them about level axes only."""
    (whole, moment, safety, looks), names = load, edge[2]
    holds = [h for n in names for h in _holds(problem, n) if h.manner == manner]
    if not holds:
        return
    force, shear, bending = (min(getattr(h, n) for h in holds) for n in ("force", "shear", "moment"))
    weight = safety * whole * GRAVITY
    if manner in ("bond", "dock", "grip") and weight > ROOM * math.hypot(force, shear):
        yield "dock_ratio", " and ".join(names), weight / math.hypot(force, shear), 1.0
    ends = [n for n in names if problem.world.effector(n) is not None]
    if manner == "pad" and ends and math.isfinite(bending):
        place = motion.frame(ends[0])[looks][:, :3, 3]
        lever = moment - whole * place
        worst = safety * GRAVITY * float(np.hypot(lever[:, 0], lever[:, 1]).max())
        if worst > ROOM * bending:
            yield "foot_ratio", " and ".join(names), worst / bending, 1.0


def _holds(problem: ir.Problem, name: str) -> tuple[ir.Hold, ...]:
    end = problem.world.effector(name)
    if end is not None:
        return end[1].holds
    return problem.world.bodies[name].holds if name in problem.world.bodies else ()
