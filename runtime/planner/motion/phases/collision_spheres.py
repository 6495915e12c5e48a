"""The spheres that move in a phase, and which of them can meet."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from .....compiler.distinct import distinct
from .....compiler.ir import IDENTITY, JointKind, ModuleType, Shape, ShapeKind, World
from .....compiler.motion.collision import (
    ON_AXIS,
    PATH_MARGIN,
    Sphere,
    body_spheres,
    bounding_radius,
    cover,
    module_spheres,
    pose_matrix,
)
from .....langs.frozen import dataclass
from ....skeleton import Array
from .joint_forest import Mount, PhaseTree
from .resting_shapes import Obstacle, Point
from .settings import PHASES

Indices = NDArray[np.intp]


@dataclass(frozen=True, slots=True)
class Ball:
    """A sphere fixed to a node; `owner` is its module or body, `tag` the effector or body that contacts name, `part`
    the shape of its owner that it covers. An `exact` one is a whole shape, no part of a cover."""

    node: int
    centre: tuple[float, float, float]
    radius: float
    owner: str
    tag: str | None
    exact: bool
    part: int = 0


class Lineage:
    """Which joints of a forest carry what."""

    def __init__(self, tree: PhaseTree) -> None:
        self.tree = tree
        count = len(tree.parents)
        self.above = np.zeros((count + 1, count), bool)
        """(node + 1, joint): whether the joint moves the node; node -1 comes first."""
        for i, parent in enumerate(tree.parents):
            self.above[i + 1] = self.above[parent + 1]
            self.above[i + 1, i] = True
        self._spans: dict[tuple[int, int], tuple[float, int, int]] = {}
        self._offsets = [math.hypot(*before[:3, 3]) for before in tree.before]
        self.root = [-1] * count
        for i, parent in enumerate(tree.parents):
            self.root[i] = i if parent < 0 else self.root[parent]

    def span(self, a: int, b: int) -> tuple[float, int, int]:
        """Of two nodes: the length of the joints between them below their common node, and the uppermost joints on
        both sides (-1 when that side is the common node)."""
        if (a, b) not in self._spans:
            length, tops = 0.0, []
            for node, other in ((a, b), (b, a)):
                top = -1
                while node >= 0 and not self.above[other + 1, node]:
                    if top >= 0:
                        length += self._offsets[top]
                    length += self.tree.slides[node]
                    top, node = node, self.tree.parents[node]
                tops.append(top)
            self._spans[a, b] = (length, tops[0], tops[1])
        return self._spans[a, b]

    def lengths_between(self, balls: tuple[Ball, ...], first: NDArray[np.intp], second: NDArray[np.intp]) -> Array:
        """Upper bounds `(m,)` of the distances of the centres of pairs of spheres, given by their indices `(m,)`."""
        nodes = np.array([b.node for b in balls]) + 1
        centres = np.array([b.centre for b in balls])
        result = np.empty(len(first))
        kinds = nodes[first] * (len(self.tree.parents) + 1) + nodes[second]
        for kind in distinct(kinds):
            rows = np.flatnonzero(kinds == kind)
            i, k = first[rows], second[rows]
            length, *tops = self.span(balls[i[0]].node, balls[k[0]].node)
            ends = []
            for ball, top in zip((i, k), tops, strict=True):
                ends.append(self.tree.before[top][:3, 3] if top >= 0 else centres[ball])
                length = length + (np.linalg.norm(centres[ball], axis=1) if top >= 0 else 0.0)
            result[rows] = length + np.linalg.norm(ends[0] - ends[1], axis=-1)
        return result

    def held_still(self, balls: Sequence[Ball]) -> NDArray[np.bool_]:
        """`(spheres, joints)`: joints outward of a sphere that turn about an axis through it, one after the other."""
        result = np.zeros((len(balls), len(self.tree.parents)), bool)
        nodes = np.array([b.node for b in balls])
        centres = np.array([(*b.centre, 1.0) for b in balls])
        held: dict[int, tuple[NDArray[np.intp], Array]] = {}
        for node in range(-1, len(self.tree.parents)):
            index, points = np.flatnonzero(nodes == node), centres[nodes == node]
            if node >= 0 and self.tree.kinds[node] == JointKind.REVOLUTE:
                outer, at = held[self.tree.parents[node]]
                local = np.linalg.solve(self.tree.before[node], at.T).T
                on_axis = np.hypot(local[:, 0], local[:, 1]) <= ON_AXIS
                result[outer[on_axis], node] = True
                index, points = np.append(index, outer[on_axis]), np.append(points, local[on_axis], axis=0)
            held[node] = index, points
        return result


def hoist(tree: PhaseTree, node: int, centre: Array) -> tuple[int, Array]:
    """The same point in the node nearest to the world that carries it."""
    while node >= 0 and tree.kinds[node] == JointKind.REVOLUTE and math.hypot(centre[0], centre[1]) <= ON_AXIS:
        centre = (tree.before[node] @ np.array([0.0, 0.0, centre[2], 1.0]))[:3]
        node = tree.parents[node]
    return node, centre


@lru_cache(maxsize=512)
def seen_whole(shape: Shape) -> bool:
    """Whether the optimiser sees a shape that moves as it is: convex bodies, and boxes and cylinders that would take
    many spheres."""
    if shape.kind in (ShapeKind.BOX, ShapeKind.CYLINDER):
        return len(cover(shape, PATH_MARGIN)) >= PHASES.many_spheres
    return shape.kind == ShapeKind.CONVEX


@lru_cache(maxsize=64)
def _plain(type_: ModuleType) -> tuple[ModuleType, frozenset[int]]:
    """A module with points in place of what is seen whole, and which of its parts, effectors first, these are."""
    shapes = [*(e.shape for e in type_.effectors), *(link.shape for link in type_.links)]
    whole = frozenset(k for k, s in enumerate(shapes) if s is not None and seen_whole(s))
    if not whole:
        return type_, whole
    point, ends = Shape(ShapeKind.SPHERE, (0.0,)), len(type_.effectors)
    effectors = tuple(replace(e, shape=point) if k in whole else e for k, e in enumerate(type_.effectors))
    links = tuple(replace(k, shape=point) if n + ends in whole else k for n, k in enumerate(type_.links))
    return replace(type_, effectors=effectors, links=links), whole


def balls_around(tree: PhaseTree, world: World) -> tuple[Ball, ...]:
    """Spheres around what moves in a phase and is seen whole."""
    found = []
    for module, links in tree.links.items():
        type_ = world.modules[module].type
        shapes = [(e.joint, e.placement, e.shape) for e in type_.effectors if e.shape is not None]
        shapes += [(link.joint, link.placement, link.shape) for link in type_.links]
        found += [(*links[joint], placement, shape, module) for joint, placement, shape in shapes]
    found += [(*mount, IDENTITY, world.bodies[name].shape, name) for name, mount in tree.bodies.items()]
    balls = []
    for node, local, placement, shape, owner in found:
        if seen_whole(shape):
            x, y, z = (local @ pose_matrix(placement))[:3, 3].tolist()
            balls.append(Ball(node, (x, y, z), bounding_radius(shape), owner, None, False))
    return tuple(balls)


def moving_balls(tree: PhaseTree, world: World, margin: float) -> tuple[Ball, ...]:
    """Spheres that cover, within `margin`, the modules and bodies that move in a phase, but for what is seen whole."""

    def balls(mount: Mount, spheres: Sequence[Sphere], owner: str) -> Iterator[Ball]:
        node, local = mount
        points = np.array([s.centre for s in spheres]) @ local[:3, :3].T + local[:3, 3]
        on_axis = np.hypot(points[:, 0], points[:, 1]) <= ON_AXIS
        for sphere, point, maybe in zip(spheres, points, on_axis.tolist(), strict=True):
            at, centre = hoist(tree, node, point) if maybe else (node, point)
            x, y, z = centre.tolist()
            tag = owner if owner in tree.bodies else f"{owner}.{sphere.effector}" if sphere.effector else None
            yield Ball(at, (x, y, z), sphere.radius, owner, tag, sphere.exact, sphere.part)

    found: list[Ball] = []
    for module, links in tree.links.items():
        type_, whole = _plain(world.modules[module].type)
        covering = [s for s in module_spheres(type_, margin) if s.part not in whole]
        for joint, spheres in groupby(covering, lambda s: s.joint):
            found += balls(links[joint], list(spheres), module)
    for name, mount in tree.bodies.items():
        if world.bodies[name].collides and not seen_whole(world.bodies[name].shape):
            found += balls(mount, body_spheres(world.bodies[name], margin), name)
    return tuple(found)


class Meetings:
    """Which spheres of a phase can meet: of two robots, all; of one robot, those whose distance two joints change (one,
    when a body is carried there), far enough apart along the joints."""

    def __init__(self, lineage: Lineage, balls: tuple[Ball, ...]) -> None:
        self._lineage, self._balls = lineage, balls
        joints = len(lineage.tree.parents)
        if not balls:
            return
        above = lineage.above[[b.node + 1 for b in balls]]
        owners, owner = np.unique([b.owner for b in balls], return_inverse=True)
        fixed = [b.node < 0 for b in balls]
        features = np.column_stack([above, lineage.held_still(balls), owner, fixed])
        _, place, self._kind = np.unique([row.tobytes() for row in features], return_index=True, return_inverse=True)
        kinds = features[place]
        carried = np.array([owners[k] in lineage.tree.bodies for k in kinds[:, -2]])
        self._may = _may_meet(kinds, carried, joints)
        self._one_robot = _one_robot(kinds, joints)
        self._radius = np.array([b.radius for b in balls])

    def meet(self, first: Indices, second: Indices) -> NDArray[np.bool_]:
        """Whether pairs of spheres, given by their indices `(m,)`, can meet."""
        result: NDArray[np.bool_] = self._may[self._kind[first], self._kind[second]]
        near = np.flatnonzero(result & self._one_robot[self._kind[first], self._kind[second]])
        first, second = first[near], second[near]
        touch = self._radius[first] + self._radius[second] + PATH_MARGIN
        result[near] = self._lineage.lengths_between(self._balls, first, second) >= 2 * touch
        return result

    def pairs(self) -> Indices:
        """The pairs `(pairs, 2)` that can meet."""
        count, found = len(self._balls), [np.zeros((0, 2), np.intp)]
        for rows in _blocks(count, count):
            first, second = np.nonzero(rows[:, None] < np.arange(count))
            first = rows[first]
            found.append(np.column_stack([first, second])[self.meet(first, second)])
        return np.concatenate(found)


def _blocks(rows: int, width: int) -> Iterator[Indices]:
    """The rows of a table of pairs in blocks of at most `pair_lot`."""
    step = max(1, PHASES.pair_lot // max(1, width))
    return (np.arange(start, min(rows, start + step)) for start in range(0, rows, step))


def _one_robot(kinds: NDArray[np.intp], joints: int) -> NDArray[np.bool_]:
    """Whether spheres of two kinds are of one robot; `kinds` list the joints above, the joints that hold still, the
    owner, and whether the sphere is fixed to the world."""
    above, owner, fixed = kinds[:, :joints].astype(bool), kinds[:, -2], kinds[:, -1].astype(bool)
    own_base = (owner[:, None] == owner[None]) & (fixed[:, None] | fixed[None])
    return np.asarray((above[:, None] & above[None]).any(axis=2) | own_base)


def _may_meet(
    kinds: NDArray[np.intp], carried: NDArray[np.bool_], joints: int
) -> NDArray[np.bool_]:
    """Whether enough joints change the distance of spheres of two kinds."""
    above, still = kinds[:, :joints].astype(bool), kinds[:, joints : 2 * joints].astype(bool)
    owner, body = kinds[:, -2], carried[:, None] | carried[None]
    between = (above[:, None] ^ above[None]) & ~still[:, None] & ~still[None]
    needed = np.where(_one_robot(kinds, joints) & ~body, 2, 1)
    wanted = between.sum(axis=2) >= needed
    wanted &= ~((owner[:, None] == owner[None]) & carried[:, None])
    return np.asarray(wanted)


def obstacles_near(tree: PhaseTree, lineage: Lineage, balls: tuple[Ball, ...], margin: float) -> list[Obstacle]:
    """The obstacles that a moving sphere can come to within `margin`, by the lengths of the joints that carry it."""
    reach: dict[int, float] = {}
    moving = [k for k, b in enumerate(balls) if b.node >= 0]
    roots = sorted({lineage.root[balls[k].node] for k in moving})
    origins = tuple(Ball(root, (0.0, 0.0, 0.0), 0.0, "", None, False) for root in roots)
    number = np.array([len(balls) + roots.index(lineage.root[balls[k].node]) for k in moving], dtype=np.intp)
    lengths = lineage.lengths_between((*balls, *origins), number, np.array(moving, dtype=np.intp))
    for k, length in zip(moving, lengths.tolist(), strict=True):
        root = lineage.root[balls[k].node]
        reach[root] = max(reach.get(root, 0.0), length + balls[k].radius + tree.slides[root])
    reaches: dict[Point, float] = {}
    for root, length in reach.items():
        x, y, z = tree.before[root][:3, 3].tolist()
        reaches[x, y, z] = max(reaches.get((x, y, z), 0.0), length + margin)
    return [] if tree.surroundings is None else tree.surroundings.near(reaches)
