"""One phase as a forest of joints that hangs from the world.

Through the kept poses of its mode, everything in a phase is at rest, or hangs from what is at rest by a chain of
modules that are entered at one end. A module's joint tree is turned round so that it starts where it is entered. In
the forest a *node* is the frame that a joint moves, with the joint's axis as its z-axis; node -1 is the world.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping
from dataclasses import field
from enum import Enum
from functools import lru_cache
from types import MappingProxyType

import numpy as np

from .....compiler.ir import Function, JointKind, ModuleType, Problem, Var, Vec3
from .....compiler.kept_pairs import keeps_pose
from .....compiler.motion.collision import pose_matrix
from .....langs.frozen import dataclass
from ....geometry.attachments import standing
from ....geometry.drives import braked, ringed
from ....geometry.transforms import quaternions
from ....skeleton import Array, Configuration, Phase, movable
from .resting_shapes import AtRest, Surroundings, places

STILL = 1e-6
"""A robot whose joint values differ by less between two switches stays still."""
ROUND_OFF = 1e-12

Mount = tuple[int, Array]
"""Where a frame sits: its node and its pose `(4, 4)` in that node."""


class Reason(Enum):
    CLOSED = "a robot forms a closed chain while it moves"
    FLOATING = "a robot that moves stands on nothing"
    ROWS = "a motion predicate binds along the whole interval"


class UnsupportedPhase(Exception):
    """The phase is no set of open chains; only the path program over the whole skeleton can treat it."""

    def __init__(self, phase: int, reason: Reason, names: tuple[str, ...]) -> None:
        super().__init__(f"phase {phase}: {reason.value} ({', '.join(names)})")
        self.phase = phase
        self.reason = reason
        self.names = names


@dataclass(slots=True)
class PhaseTree:
    """The forest of a phase. Joint i moves node i: its frame is that of node `parents[i]`, times `before[i]`, then a
    turn or shift by `signs[i]` times the value of joint `variables[columns[i]]` (module, index) about or along z.
    Joints that follow others have a node, but no variable of their own."""

    phase: int
    parents: list[int] = field(default_factory=list)
    kinds: list[JointKind] = field(default_factory=list)
    signs: list[float] = field(default_factory=list)
    before: list[Array] = field(default_factory=list)
    slides: list[float] = field(default_factory=list)
    columns: list[int] = field(default_factory=list)
    variables: list[tuple[str, int]] = field(default_factory=list)
    links: dict[str, dict[int, Mount]] = field(default_factory=dict)
    bodies: dict[str, Mount] = field(default_factory=dict)
    surroundings: Surroundings | None = None


def pose_vector(matrix: Array) -> Array:
    """The pose `(7,)`, or poses `(…, 7)`, of homogeneous matrices; quaternions have w >= 0."""
    return np.concatenate([matrix[..., :3, 3], quaternions(matrix[..., :3, :3])], axis=-1)


def inverse(matrix: Array) -> Array:
    """The inverse of a rigid transform `(4, 4)`."""
    result = np.eye(4)
    result[:3, :3] = matrix[:3, :3].T
    result[:3, 3] = -matrix[:3, :3].T @ matrix[:3, 3]
    return result


def _motion(kind: JointKind, value: float) -> Array:
    """A turn about, or a shift along, the z-axis."""
    result = np.eye(4)
    if kind == JointKind.REVOLUTE:
        c, s = math.cos(value), math.sin(value)
        result[:2, :2] = [[c, -s], [s, c]]
    else:
        result[2, 3] = value
    return result


@lru_cache(maxsize=256)
def _to_axis(axis: Vec3) -> Array:
    """A rotation that takes the z-axis to `axis`, not to be written to; a permutation for the coordinate axes, so that
    zeros stay zeros."""
    z = np.array(axis) / math.hypot(*axis)
    k = int(np.argmax(np.abs(z)))
    result = np.eye(4)
    helper = np.eye(3)[(k + 1) % 3]
    y = np.cross(z, helper)
    y /= np.linalg.norm(y)
    result[:3, 0], result[:3, 1], result[:3, 2] = np.cross(y, z), y, z
    return _clean(result)


def _clean(matrix: Array) -> Array:
    near = np.round(matrix)
    return np.where(np.abs(matrix - near) < ROUND_OFF, near, matrix)


def link_frames(type_: ModuleType, state: Array) -> dict[int, Array]:
    """World poses `(4, 4)` of a module's joint frames, -1 the module frame, from its state `(7 + n,)`."""
    frames = {-1: pose_matrix(state[:7])}
    for i, joint in enumerate(type_.joints):
        align = _to_axis(joint.axis)
        turn = align @ _motion(joint.kind, float(state[7 + i])) @ align.T
        frames[i] = frames[joint.parent] @ pose_matrix(joint.placement) @ turn
    return frames


def node_frames(tree: PhaseTree, values: Array) -> list[Array]:
    """World poses `(4, 4)` of the nodes for joint values `(n,)`."""
    frames: list[Array] = []
    for i, parent in enumerate(tree.parents):
        carrier = frames[parent] if parent >= 0 else np.eye(4)
        frames.append(carrier @ tree.before[i] @ _motion(tree.kinds[i], tree.signs[i] * float(values[tree.columns[i]])))
    return frames


def joint_values(tree: PhaseTree, configuration: Configuration) -> Array:
    """The values `(n,)` of the forest's joints."""
    return np.array([configuration.modules[module][7 + j] for module, j in tree.variables])


def mount_module(
    tree: PhaseTree, module: str, type_: ModuleType, entry: int, mount: Mount,
    held: Mapping[int, float] = MappingProxyType({}),
) -> None:  # fmt: skip
    """Hang a module into the forest by its frame `entry`, and turn its joint tree round to start there. Joints that are
    `held` at a value have no node."""
    links = tree.links[module] = {entry: mount}
    columns: dict[int, int] = {}
    queue = deque([entry])
    while queue:
        at = queue.popleft()
        for index, joint in enumerate(type_.joints):
            ahead = index if joint.parent == at else joint.parent if index == at else None
            if ahead is None or ahead in links:
                continue
            align, placement = _to_axis(joint.axis), pose_matrix(joint.placement)
            node, local = links[at]
            outward = ahead == index
            if index in held:
                moved = placement @ align @ _motion(joint.kind, held[index]) @ align.T
                links[ahead] = (node, local @ (moved if outward else inverse(moved)))
                queue.append(ahead)
                continue
            sign, before = (1.0, local @ placement @ align) if outward else (-1.0, local @ align)
            leader = index
            if joint.follows is not None:
                leader, before = joint.follows.leader, before @ _motion(joint.kind, sign * joint.follows.offset)
                sign *= joint.follows.factor
            if leader not in columns:
                columns[leader] = len(tree.variables)
                tree.variables.append((module, leader))
            tree.parents.append(node)
            tree.kinds.append(joint.kind)
            tree.signs.append(sign)
            tree.before.append(_clean(before))
            tree.slides.append(joint.slide)
            tree.columns.append(columns[leader])
            links[ahead] = (len(tree.parents) - 1, align.T if outward else align.T @ inverse(placement))
            queue.append(ahead)


class Scene:
    """What holds to what in one phase, read from the kept poses of its mode."""

    def __init__(self, problem: Problem, index: int, phase: Phase, start: Configuration, end: Configuration) -> None:
        self.problem, self.index = problem, index
        self.world = problem.world
        self.frames = {m: link_frames(self.world.modules[m].type, s) for m, s in start.modules.items()}
        self.start = start
        self._poses: dict[str, Array] = {}
        self.moves = {
            m: bool(np.abs(end.modules[m][7:] - s[7:]).max(initial=0.0) > STILL) for m, s in start.modules.items()
        }
        self.standing = standing(problem, phase.mode)
        self.edges: dict[str, list[tuple[str, str, str]]] = {}
        """Per module or body: own object, other object, other module or body."""
        self._read(phase)
        self.kept = self._kept_rings(phase, start, end)
        """By module, the joints that keep their values since they lie on rings that keep theirs."""
        self.rest = self._find_rest()

    def _read(self, phase: Phase) -> None:
        seen = set()
        for literal in sorted(phase.mode):
            for row in self.problem.motions[literal[0]].rows:
                left = row.left
                pose = isinstance(left, Function) and left.name == "pose" and all(
                    isinstance(a, Var) for a in left.args
                )
                if row.when == "during" or (row.when == "keep" and not pose):
                    raise UnsupportedPhase(self.index, Reason.ROWS, literal)
            kept = keeps_pose(self.problem, literal)
            if kept is None or frozenset(kept) in seen:
                continue
            seen.add(frozenset(kept))
            a, b = kept
            self.edges.setdefault(self.owner(a), []).append((a, b, self.owner(b)))
            self.edges.setdefault(self.owner(b), []).append((b, a, self.owner(a)))

    def _kept_rings(self, phase: Phase, start: Configuration, end: Configuration) -> Mapping[str, frozenset[int]]:
        if not any(self.moves.values()):
            return {}
        rings = ringed(self.problem, phase.mode)
        return {
            name: joints for name, joints in rings.items()
            if all(abs(end.modules[name][7 + i] - start.modules[name][7 + i]) <= STILL for i in joints)
        }

    def owner(self, name: str) -> str:
        """The module or body that an object belongs to."""
        found = self.world.effector(name)
        return name if found is None else found[0].name

    def joint(self, name: str) -> int:
        """The joint frame of its module that carries an object."""
        found = self.world.effector(name)
        return -1 if found is None else found[1].joint

    def frame(self, name: str) -> Array:
        """World pose at the start of the phase of the frame that carries an object."""
        owner = self.owner(name)
        return self.pose(owner) if owner in self.world.bodies else self.frames[owner][self.joint(name)]

    def pose(self, body: str) -> Array:
        """World pose of a body at the start of the phase."""
        if body not in self._poses:
            self._poses[body] = pose_matrix(self.start.bodies[body])
        return self._poses[body]

    def _find_rest(self) -> AtRest:
        """Everything that rests: bodies fixed to the scene, robots whose joints keep their values."""
        rest = AtRest(self.world, {name for name in movable(self.world) if name not in self.edges})
        self._spread(rest)
        self._spread(rest)
        while any(still := [self._still_part(robot, rest) for robot in self._robots(rest)]):
            rest.others.update(*still)
            self._spread(rest)
        return rest

    def _spread(self, rest: AtRest) -> None:
        """Bodies that hold to bodies at rest are at rest."""
        queue = deque(sorted(name for name in self.edges if name in rest and name in self.world.bodies))
        while queue:
            for _, _, other in self.edges.get(queue.popleft(), []):
                if other in self.world.bodies and other not in rest:
                    rest.others.add(other)
                    queue.append(other)

    def _robots(self, rest: AtRest) -> list[list[str]]:
        """The connected parts of what does not rest, in declaration order."""
        parts: list[list[str]] = []
        seen = set(rest.others)
        for name in [*self.world.modules, *movable(self.world)]:
            if name in seen:
                continue
            part, queue = [], deque([name])
            seen.add(name)
            while queue:
                part.append(queue.popleft())
                for _, _, other in self.edges.get(part[-1], []):
                    if other not in seen and other not in rest:
                        seen.add(other)
                        queue.append(other)
            parts.append(part)
        return parts

    def _still_part(self, robot: list[str], rest: AtRest) -> set[str]:
        """The part of a robot that rests: all of it when no joint moves, or the loops of a closed chain."""
        if not any(self.moves.get(name, False) for name in robot):
            return set(robot)
        degree = {name: len(self.edges.get(name, [])) + (name in self.standing) for name in robot}
        anchors = sum(other in rest for name in robot for _, _, other in self.edges.get(name, []))
        anchors += len(self.standing.intersection(robot))
        modules = tuple(name for name in robot if name in self.frames)
        if not anchors:
            raise UnsupportedPhase(self.index, Reason.FLOATING, modules)
        if (sum(degree.values()) + anchors) // 2 <= len(robot):
            return set()
        core = set(robot)
        while leaves := [name for name in robot if name in core and degree[name] <= 1]:
            for name in leaves:
                core.discard(name)
                for _, _, other in self.edges.get(name, []):
                    if other in core:
                        degree[other] -= 1
        moving = [name for name in core if self.moves.get(name, False)]
        if moving and self.kept.keys() >= set(moving):
            return set()
        if moving:
            raise UnsupportedPhase(self.index, Reason.CLOSED, tuple(n for n in modules if n in core))
        return core


def phase_tree(problem: Problem, index: int, phase: Phase, start: Configuration, end: Configuration) -> PhaseTree:
    """The forest of phase `index` that leads from one switch configuration to the next; constants between modules
    and objects are their poses at its start. Raises UnsupportedPhase."""
    scene = Scene(problem, index, phase, start, end)
    brakes = braked(problem, phase.mode)
    tree = PhaseTree(index)

    def held(module: str) -> dict[int, float]:
        still = brakes.get(module, frozenset()) | scene.kept.get(module, frozenset())
        return {i: float(start.modules[module][7 + i]) for i in still}

    mounts: dict[str, dict[int, Mount]] = {}
    queue: deque[tuple[str, str]] = deque()
    place = places(scene.world)
    for name in sorted(scene.edges, key=place.__getitem__):
        if name in scene.rest:
            queue.extend((own, other) for own, other, owner in scene.edges[name] if owner not in scene.rest)
    for name in scene.world.modules:
        if name in scene.standing and name not in scene.rest:
            mount_module(tree, name, scene.world.modules[name].type, -1, (-1, scene.frames[name][-1]), held(name))
            mounts[name] = tree.links[name]
            queue.extend((own, other) for own, other, to in scene.edges.get(name, []) if to not in scene.rest)
    while queue:
        holder, name = queue.popleft()
        owner, carrier = scene.owner(name), scene.owner(holder)
        if owner in mounts:
            continue
        mount = (-1, scene.frame(name))
        if carrier not in scene.rest:
            node, local = mounts[carrier][scene.joint(holder)]
            mount = (node, local @ inverse(scene.frame(holder)) @ scene.frame(name))
        if owner in scene.world.bodies:
            tree.bodies[owner] = mount
            mounts[owner] = {-1: mount}
        else:
            mount_module(tree, owner, scene.world.modules[owner].type, scene.joint(name), mount, held(owner))
            mounts[owner] = tree.links[owner]
        queue.extend((own, other) for own, other, to in scene.edges[owner] if to not in scene.rest)
    tree.surroundings = Surroundings(scene.world, scene.rest, start, scene.frames)
    return tree


def arrive(tree: PhaseTree, start: Configuration, end: Configuration) -> Configuration:
    """Where everything is at the end of the phase: joint values from `end`, poses by the forest's own kinematics, so
    that what rests stays exactly where it was."""
    result = start.copy()
    frames = [np.eye(4), *node_frames(tree, joint_values(tree, end))]
    for module, links in tree.links.items():
        node, local = links[-1]
        result.modules[module] = np.concatenate([pose_vector(frames[node + 1] @ local), end.modules[module][7:]])
    for body, (node, local) in tree.bodies.items():
        result.bodies[body] = pose_vector(frames[node + 1] @ local)
    return result
