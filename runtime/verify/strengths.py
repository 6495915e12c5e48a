"""What joins rigid nodes while a mode holds, what of it closes loops, and how near its loads come to its strength."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping

import numpy as np

from ...compiler import ir
from ...langs.frozen import dataclass
from ...langs.source import Span
from .geometry import Array, Frames, crossed, frames
from .kept_poses import bolted
from .shapes import heights

Node = tuple[str, int]
Wrench = tuple[Array, Array]
"""A force and a moment about the world's origin `(T, 3)`."""
WORLD: Node = ("", -1)
STRENGTHS = ("force", "shear", "moment", "twist", "friction")
STILL = 1e-5
"""Radians or metres by which a joint may change that does not move: planners keep a tenth of it."""
UNBEARABLE = 1e3
"""Stands for the ratio of what nothing holds."""


@dataclass(frozen=True, slots=True)
class Joined:
    """Two nodes that a joint or a kept pair joins: the wrench of an edge is what `far` puts on `near`. `names` are a
    module and its joint, or the two objects; `strength` what of a pair is bounded, by name; `manner` how it holds."""

    near: Node
    far: Node
    joint_of: str
    names: tuple[str, str]
    manner: str = ""
    strength: tuple[float, ...] = ()
    span: Span | None = None


@dataclass(frozen=True, slots=True)
class Figure:
    """A ratio `(T,)`, or metres, of a kind of `LIMITS`."""

    kind: str
    amounts: Array
    message: str
    span: Span | None


@dataclass(frozen=True, slots=True)
class Loads:
    """Force and moment about the world's origin `(T, 3)` that each node puts on what bears it."""

    forces: Mapping[Node, Array]
    moments: Mapping[Node, Array]


@dataclass(frozen=True, slots=True)
class Looked:
    """Instants `(T,)` of a phase, where everything is at them, what it weighs there, and what is joined."""

    times: Array
    nodes: Mapping[Node, Frames]
    loads: Loads
    edges: tuple[Joined, ...]


def joined(problem: ir.Problem, mode: frozenset[ir.Fact], pairs: Iterable[tuple[str, str]]) -> tuple[Joined, ...]:
    """All joints, and the `pairs` that the mode keeps, but for those that bear nothing."""
    rest = {(name, -1): WORLD for name in bolted(problem, mode)}
    found = [
        Joined(rest.get((name, j.parent), (name, j.parent)), (name, i), name, (name, j.name), span=j.stated)
        for name, module in problem.world.modules.items()
        for i, j in enumerate(module.type.joints)
    ]
    manners: dict[frozenset[str], str] = {}
    upper: dict[frozenset[str], str] = {}
    for literal in sorted(mode):
        borne = problem.motions[literal[0]].borne
        if borne is not None and frozenset(literal[1:3]) not in manners:
            manners[frozenset(literal[1:3])] = borne
            upper[frozenset(literal[1:3])] = literal[1]
    seen: set[frozenset[str]] = set()
    for base, own in pairs:
        key = frozenset((base, own))
        manner = manners.get(key, "")
        low, high = (rest.get(node, node) for node in (_node(problem, base), _node(problem, own)))
        if key in seen or manner == "nothing" or low == high:
            continue
        seen.add(key)
        names = (base, own)
        if high == WORLD or (low != WORLD and manner in ("pad", "rest") and upper[key] == base):
            low, high, names = high, low, (own, base)
        sides = [h for n in names for h in _holds(problem, n) if h.manner == manner]
        strength = tuple(min(getattr(h, s) for h in sides) for s in STRENGTHS) if sides else ()
        found.append(Joined(low, high, "", names, manner, strength, sides[0].span if sides else None))
    return tuple(found)


def _node(problem: ir.Problem, name: str) -> Node:
    end = problem.world.effector(name)
    if end is not None:
        return end[0].name, end[1].joint
    body = problem.world.bodies.get(name)
    return WORLD if body is not None and not body.movable else (name, -1)


def _holds(problem: ir.Problem, name: str) -> tuple[ir.Hold, ...]:
    end = problem.world.effector(name)
    if end is not None:
        return end[1].holds
    return problem.world.bodies[name].holds if name in problem.world.bodies else ()


class Support:
    """Which edges bear alone (`bridges`: without them something falls) and which share loads in `rings`."""

    def __init__(self, edges: tuple[Joined, ...]) -> None:
        self._edges = edges
        self._around: dict[Node, list[Joined]] = {}
        for edge in edges:
            self._around.setdefault(edge.near, []).append(edge)
            self._around.setdefault(edge.far, []).append(edge)
        self.supported = self._reached(None)
        standing = [e for e in edges if e.near in self.supported]
        self._beyond = {e: self.supported - self._reached(e) for e in standing}
        self.bridges = [e for e in standing if self._beyond[e]]
        self.rings = list(self._rings([e for e in standing if not self._beyond[e]]))

    def _reached(self, without: Joined | None) -> frozenset[Node]:
        found, waiting = {WORLD}, [WORLD]
        while waiting:
            here = waiting.pop()
            for edge in self._around.get(here, []):
                other = edge.far if edge.near == here else edge.near
                if edge is not without and other not in found:
                    found.add(other)
                    waiting.append(other)
        return frozenset(found)

    def beyond(self, edge: Joined) -> frozenset[Node]:
        """The nodes that fall without the edge."""
        return self._beyond[edge]

    def _rings(self, edges: list[Joined]) -> Iterator[tuple[Joined, ...]]:
        left = list(edges)
        while left:
            ring, nodes = [left.pop(0)], set[Node]()
            grew = True
            while grew:
                nodes = {n for e in ring for n in (e.near, e.far)}
                more = [e for e in left if nodes & {e.near, e.far}]
                ring += more
                left = [e for e in left if e not in more]
                grew = bool(more)
            yield tuple(ring)

    def hanging(self, node: Node, ring: tuple[Joined, ...]) -> list[Joined]:
        """The bridges that bear on a node of a ring and carry what is beyond it."""
        return [e for e in self._around.get(node, []) if e in self.bridges and e not in ring
                and node not in self._beyond[e]]  # fmt: skip

    def root(self, ring: tuple[Joined, ...]) -> Node:
        """The node of a ring by which all of it is supported."""
        nodes = {n for e in ring for n in (e.near, e.far)}
        if WORLD in nodes:
            return WORLD
        return next(n for n in sorted(nodes) for e in self._around[n] if e in self.bridges and n in self._beyond[e])


# --- figures -----------------------------------------------------------------------------------------------------


def meeting_place(problem: ir.Problem, edge: Joined, nodes: Mapping[Node, Frames]) -> tuple[Array, Array, float]:
    """Where a pair meets `(T, 3)`, its axes as columns `(T, 3, 3)`, the third along the normal, and how far from there
    it tips. Contacts lie on level tops: their normal is vertical."""
    near, far = edge.names
    name = near if problem.world.effector(near) is not None and far in problem.world.bodies else far
    end = problem.world.effector(name)
    if end is not None:
        own = nodes[end[0].name, end[1].joint].compose(frames(end[1].placement))
        shape = end[1].shape
    else:
        own, shape = nodes[name, -1], problem.world.bodies[name].shape if name in problem.world.bodies else None
    radius = 0.0
    if shape is not None:
        radius = _half_width(shape)
    if edge.manner in ("pad", "rest"):
        drop = np.zeros(len(own)) if shape is None else heights(shape.kind, shape.size, own.rotation, False)
        if end is not None:
            wheels = _on_wheels(end[0].type, end[1].joint)
            if wheels is not None:
                under = nodes[end[0].name, wheels].position
                own = Frames(np.column_stack([under[:, :2], own.position[:, 2]]), own.rotation)
                parts = [k.shape for k in end[0].type.links if k.joint == wheels]
                radius = max([_half_width(s) for s in parts], default=0.0)
        place = own.position - np.abs(drop)[:, None] * np.array([0.0, 0.0, 1.0])
        return place, np.broadcast_to(np.eye(3), own.rotation.shape), radius
    out = radius if end is not None and shape is not None and shape.kind == ir.ShapeKind.SPHERE else 0.0
    return own.position + out * own.rotation[:, :, 2], own.rotation, radius


def _half_width(shape: ir.Shape) -> float:
    """Half of how wide a shape is along the narrower one of its own two level axes."""
    if shape.kind not in (ir.ShapeKind.BOX, ir.ShapeKind.CONVEX):
        return shape.size[0]
    box = np.ptp(np.reshape(shape.size, (-1, 3)), axis=0) if shape.kind == ir.ShapeKind.CONVEX else np.array(shape.size)
    return float(min(box[:2])) / 2.0


def _on_wheels(kind: ir.ModuleType, node: int) -> int | None:
    """The last of the three joints of a planar one that sits on a node: what drives stands where that has come to."""
    for third in range(2, len(kind.joints)):
        chain = [kind.joints[third - 2], kind.joints[third - 1], kind.joints[third]]
        kinds = ir.JointKind.PRISMATIC, ir.JointKind.PRISMATIC, ir.JointKind.REVOLUTE
        if tuple(j.kind for j in chain) != kinds or chain[0].parent != node:
            continue
        in_line = chain[1].parent == third - 2 and chain[2].parent == third - 1
        if in_line and all(j.placement == ir.IDENTITY for j in chain[1:]) and chain[0].placement[3:] == (0, 0, 0, 1):
            return third
    return None


def judge(
    problem: ir.Problem, edge: Joined, nodes: Mapping[Node, Frames], force: Array, moment: Array, safety: float,
    *, resting: bool = False,
) -> list[Figure]:  # fmt: skip
    """The figures of an edge under a wrench about the origin, times `safety`. Brakes bear where joints do not move over
    the instants, or everything is `resting`."""
    if edge.joint_of:
        still = resting or not moves(edge, nodes)
        return _judge_joint(problem, edge, nodes, force, moment, safety, still)
    if not edge.strength:
        return []
    place, axes, radius = meeting_place(problem, edge, nodes)
    push = np.einsum("tij,ti->tj", axes, force)
    turn = np.einsum("tij,ti->tj", axes, moment - crossed(place, force))
    across, bend, twist = np.hypot(push[:, 0], push[:, 1]), np.hypot(turn[:, 0], turn[:, 1]), np.abs(turn[:, 2])
    most, shear, bending, twisting, friction = edge.strength
    contact = edge.manner in ("pad", "rest")
    sticks = (most if edge.manner == "pad" else 0.0) if contact else math.inf
    found = [(across, shear), (bend, bending), (twist, twisting)]
    if not contact:
        found.append((np.abs(push[:, 2]), most))
        if edge.manner == "grip" and math.isfinite(friction * most):
            found.append((across, friction * most))
    ratios = [safety * amount / strength for amount, strength in found if math.isfinite(strength)]
    pair, figures = f"{edge.names[0]} and {edge.names[1]}", []
    if contact and math.isfinite(sticks):
        pull = np.maximum(push[:, 2], 0.0)
        if sticks > 0.0:
            ratios.append(safety * pull / sticks)
        held = np.maximum(sticks - push[:, 2], 1e-9)
        if math.isfinite(friction):
            ratios.append(np.minimum(safety * across / (friction * held), UNBEARABLE))
        if not math.isfinite(bending):
            out = np.maximum(np.minimum(bend / held, UNBEARABLE) - radius / safety, 0.0)
            figures.append(Figure("tip_m", out, f"{pair}: the load leans out over the edge", edge.span))
    if ratios:
        kind = "foot_ratio" if contact else "dock_ratio"
        figures.append(Figure(kind, np.max(ratios, axis=0), f"{pair} are loaded beyond their strength", edge.span))
    return figures


def along_axis(
    problem: ir.Problem, edge: Joined, nodes: Mapping[Node, Frames], force: Array, moment: Array
) -> Array:
    """What a joint bears along its axis `(T,)`, N m of a revolute one, N of a prismatic one."""
    joint, axis, about = _at_joint(problem, edge, nodes, force, moment)
    borne: Array = np.sum((about if joint.kind == ir.JointKind.REVOLUTE else force) * axis, axis=1)
    return borne


def _at_joint(
    problem: ir.Problem, edge: Joined, nodes: Mapping[Node, Frames], force: Array, moment: Array
) -> tuple[ir.Joint, Array, Array]:
    """The joint of an edge, its axis `(T, 3)` in the world, and the moment `(T, 3)` about its place."""
    name, joint_name = edge.names
    joint = next(j for j in problem.world.modules[name].type.joints if j.name == joint_name)
    frame = nodes[edge.far]
    axis = frame.rotation @ (np.asarray(joint.axis) / np.linalg.norm(joint.axis))
    return joint, axis, moment - crossed(frame.position, force)


def moves(edge: Joined, nodes: Mapping[Node, Frames]) -> bool:
    """Whether a joint moves over the instants: then its brake bears nothing."""
    far = nodes[edge.far]
    if edge.near == WORLD:
        return bool(max(np.ptp(far.rotation, axis=0).max(), np.ptp(far.position, axis=0).max()) > STILL)
    near = nodes[edge.near]
    turned = np.swapaxes(near.rotation, 1, 2) @ far.rotation
    shift = np.einsum("tji,tj->ti", near.rotation, far.position - near.position)
    return bool(max(np.ptp(turned, axis=0).max(), np.ptp(shift, axis=0).max()) > STILL)


def _judge_joint(
    problem: ir.Problem, edge: Joined, nodes: Mapping[Node, Frames], force: Array, moment: Array, safety: float,
    still: bool,
) -> list[Figure]:  # fmt: skip
    name, joint_name = edge.names
    joint, axis, about = _at_joint(problem, edge, nodes, force, moment)
    rest = about
    if joint.kind == ir.JointKind.REVOLUTE:
        rest = about - axis * np.sum(about * axis, axis=1)[:, None]
    figures, what = [], f"joint {joint_name} of {name}"
    strength = max(joint.torque, joint.brake) if still else joint.torque
    if math.isfinite(strength):
        drive = np.abs(along_axis(problem, edge, nodes, force, moment))
        figures.append(
            Figure("torque_ratio", safety * drive / strength, f"the drive of {what} is too weak", edge.span)
        )
    if math.isfinite(joint.bearing):
        bent = np.linalg.norm(rest, axis=1)
        figures.append(
            Figure("bearing_ratio", safety * bent / joint.bearing, f"{what} is bent beyond its strength", edge.span)
        )
    return figures
