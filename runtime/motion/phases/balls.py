"""The spheres that move in a phase, and which of them can meet."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ....compiler.ir import World
from ....compiler.motion.collision import ON_AXIS, PATH_MARGIN, Sphere, body_spheres, module_spheres, shape_distance
from ...skeleton import Array
from .tree import Mount, Obstacle, PhaseTree


@dataclass(frozen=True, slots=True)
class Ball:
    """A sphere fixed to a node; `owner` is its module or body, `tag` the effector or body that contacts name. An
    `exact` one is a whole shape, no part of a cover."""

    node: int
    centre: tuple[float, float, float]
    radius: float
    owner: str
    tag: str | None
    exact: bool


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
        self.root = [-1] * count
        for i, parent in enumerate(tree.parents):
            self.root[i] = i if parent < 0 else self.root[parent]

    @cached_property
    def spans(self) -> dict[tuple[int, int], tuple[float, int, int]]:
        """Per pair of nodes: the length of the joints between them below their common node, and the uppermost
        joints on both sides (-1 when that side is the common node)."""
        result = {}
        count = len(self.tree.parents)
        for a, b in itertools.product(range(-1, count), repeat=2):
            length, tops = 0.0, []
            for node, other in ((a, b), (b, a)):
                top = -1
                while node >= 0 and not self.above[other + 1, node]:
                    if top >= 0:
                        length += math.hypot(*self.tree.before[top][:3, 3])
                    length += self.tree.slides[node]
                    top, node = node, self.tree.parents[node]
                tops.append(top)
            result[a, b] = (length, tops[0], tops[1])
        return result

    def length_between(self, a: Ball, b: Ball) -> float:
        """An upper bound of the distance of two spheres' centres."""
        length, *tops = self.spans[a.node, b.node]
        ends = []
        for ball, top in zip((a, b), tops, strict=True):
            ends.append(self.tree.before[top][:3, 3] if top >= 0 else np.array(ball.centre))
            length += math.hypot(*ball.centre) if top >= 0 else 0.0
        return length + math.dist(ends[0], ends[1])

    def lengths_between(self, balls: tuple[Ball, ...], first: NDArray[np.intp], second: NDArray[np.intp]) -> Array:
        """The bound of `length_between` for many pairs of spheres, given by their indices `(m,)`: `(m,)`."""
        nodes = np.array([b.node for b in balls]) + 1
        centres = np.array([b.centre for b in balls])
        result = np.empty(len(first))
        kinds = nodes[first] * (len(self.tree.parents) + 1) + nodes[second]
        for kind in np.unique(kinds):
            rows = np.flatnonzero(kinds == kind)
            i, k = first[rows], second[rows]
            length, *tops = self.spans[balls[i[0]].node, balls[k[0]].node]
            ends = []
            for ball, top in zip((i, k), tops, strict=True):
                ends.append(self.tree.before[top][:3, 3] if top >= 0 else centres[ball])
                length = length + (np.linalg.norm(centres[ball], axis=1) if top >= 0 else 0.0)
            result[rows] = length + np.linalg.norm(ends[0] - ends[1], axis=-1)
        return result

    def held_still(self, ball: Ball) -> Array:
        """`(joints,)`: joints outward of a sphere that turn about an axis through it, one after the other."""
        result = np.zeros(len(self.tree.parents), bool)
        points = {ball.node: np.array([*ball.centre, 1.0])}
        for i, parent in enumerate(self.tree.parents):
            if parent in points and self.tree.kinds[i] == "revolute":
                local = np.linalg.solve(self.tree.before[i], points[parent])
                if math.hypot(local[0], local[1]) <= ON_AXIS:
                    points[i] = local
                    result[i] = True
        return result


def hoist(tree: PhaseTree, node: int, centre: Array) -> tuple[int, Array]:
    """The same point in the node nearest to the world that carries it."""
    while node >= 0 and tree.kinds[node] == "revolute" and math.hypot(centre[0], centre[1]) <= ON_AXIS:
        centre = (tree.before[node] @ np.array([0.0, 0.0, centre[2], 1.0]))[:3]
        node = tree.parents[node]
    return node, centre


def moving_balls(tree: PhaseTree, world: World, margin: float) -> tuple[Ball, ...]:
    """Spheres that cover, within `margin`, the modules and bodies that move in a phase."""

    def ball(mount: Mount, sphere: Sphere, owner: str, tag: str | None) -> Ball:
        node, point = hoist(tree, mount[0], (mount[1] @ np.array([*sphere.centre, 1.0]))[:3])
        x, y, z = point.tolist()
        return Ball(node, (x, y, z), sphere.radius, owner, tag, sphere.exact)

    found = []
    for module, links in tree.links.items():
        for s in module_spheres(world.modules[module].type, margin):
            tag = None if s.effector is None else f"{module}.{s.effector}"
            found.append(ball(links[s.joint], s, module, tag))
    for name, mount in tree.bodies.items():
        for s in body_spheres(world.bodies[name], margin):
            found.append(ball(mount, s, name, name))
    return tuple(found)


def meeting_pairs(lineage: Lineage, balls: tuple[Ball, ...], bodies: bool) -> tuple[tuple[int, int], ...]:
    """Pairs of spheres of a phase that can meet: of two robots, all; of one robot, those whose distance two joints
    change (one, when a body is carried there), far enough apart along the joints. Without `bodies`, spheres of
    carried bodies are left out."""
    tree = lineage.tree
    if not balls:
        return ()
    still = np.array([lineage.held_still(b) for b in balls])
    above = lineage.above[[b.node + 1 for b in balls]]
    between = (above[:, None] ^ above[None]) & ~still[:, None] & ~still[None]
    carried = np.array([b.owner in tree.bodies for b in balls])
    owners = np.array([b.owner for b in balls])
    fixed = np.array([b.node < 0 for b in balls])
    same_owner = owners[:, None] == owners[None]
    own_base = same_owner & (fixed[:, None] | fixed[None])
    one_robot = np.logical_or((above[:, None] & above[None]).any(axis=2), own_base)
    needed = np.where(one_robot & ~(carried[:, None] | carried[None]), 2, 1)
    wanted = between.sum(axis=2) >= needed
    wanted &= ~(same_owner & carried[:, None])
    if not bodies:
        wanted &= ~(carried[:, None] | carried[None])
    first, second = np.nonzero(np.triu(wanted, 1))
    radius = np.array([b.radius for b in balls])
    touch = radius[first] + radius[second] + PATH_MARGIN
    far = lineage.lengths_between(balls, first, second) >= 2 * touch
    kept = ~one_robot[first, second] | far
    return tuple(zip(first[kept].tolist(), second[kept].tolist(), strict=True))


def obstacles_near(tree: PhaseTree, lineage: Lineage, balls: tuple[Ball, ...], margin: float) -> list[Obstacle]:
    """The obstacles that a moving sphere can come to within `margin`, by the lengths of the joints that carry it."""
    reach: dict[int, float] = {}
    for b in balls:
        if b.node >= 0:
            origin = Ball(lineage.root[b.node], (0.0, 0.0, 0.0), 0.0, b.owner, None, False)
            slide = tree.slides[lineage.root[b.node]]
            length = lineage.length_between(origin, b) + b.radius + slide
            reach[lineage.root[b.node]] = max(reach.get(lineage.root[b.node], 0.0), length)
    found = []
    for o in tree.obstacles:
        near = (shape_distance(o.shape, o.pose, tree.before[r][:3, 3]) <= d + margin for r, d in reach.items())
        if any(near):
            found.append(o)
    return found
