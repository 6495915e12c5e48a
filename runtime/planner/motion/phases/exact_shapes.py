"""Moving shapes that spheres meet as they are, where a cover of small spheres would be many: the carried bodies, and
boxes and cylinders of modules."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .....compiler.ir import Shape, ShapeKind, World
from .....compiler.motion.collision import bounding_radius, pose_matrix
from .....langs.frozen import dataclass
from ....geometry.signed_distances import half_sizes, rounded_box_distance
from ....skeleton import Array
from .batch_kinematics import Indices
from .collision_spheres import Ball
from .joint_forest import PhaseTree
from .settings import PHASES


@dataclass(frozen=True, slots=True)
class MovingShape:
    """A shape in one phase, at `local` `(4, 4)` in its node. `tag` is the object that contacts name; `members` are the
    spheres that cover it, but for those on an axis about which it turns; `meets` those that can meet it."""

    node: int
    local: Array
    shape: Shape
    owner: str
    tag: str | None
    members: tuple[int, ...]
    meets: tuple[int, ...] = ()


def module_shapes(tree: PhaseTree, world: World, balls: Sequence[Ball]) -> list[MovingShape]:
    """Boxes and cylinders of modules whose covers are many spheres."""
    members: dict[tuple[str, int, int], list[int]] = {}
    for k, ball in enumerate(balls):
        members.setdefault((ball.owner, ball.part, ball.node), []).append(k)
    found = []
    for module, links in tree.links.items():
        type_ = world.modules[module].type
        parts = [(e.joint, e.placement, e.shape, f"{module}.{e.name}") for e in type_.effectors]
        for number, (joint, placement, shape, tag) in enumerate(
            [*parts, *((link.joint, link.placement, link.shape, None) for link in type_.links)]
        ):
            node, local = links[joint]
            covers = members.get((module, number, node), [])
            edged = shape is not None and shape.kind in (ShapeKind.BOX, ShapeKind.CYLINDER)
            if shape is not None and edged and len(covers) >= PHASES.many_spheres:
                found.append(MovingShape(node, local @ pose_matrix(placement), shape, module, tag, tuple(covers)))
    return found


@dataclass(slots=True)
class Whole:
    """One such shape per phase of a stack: its node and its pose there `(phases, 4, 4)`, the spheres that can meet it,
    its form as in `shapes`, and the radius `(phases,)` of the sphere around it."""

    meets: Indices
    node: int
    local: Array
    half: Array
    rounding: Array
    turned: NDArray[np.bool_]
    extent: Array

    @classmethod
    def stacked(cls, shapes: Sequence[MovingShape]) -> Whole:
        """The shapes of one place in a structure, one per phase."""
        halves, roundings, turned = zip(*(half_sizes(s.shape) for s in shapes), strict=True)
        extent = np.array([bounding_radius(s.shape) for s in shapes])
        return cls(
            np.array(shapes[0].meets, dtype=np.intp), shapes[0].node, np.array([s.local for s in shapes]),
            np.array(halves), np.array(roundings), np.array(turned), extent,
        )  # fmt: skip

    def take(self, index: Indices) -> Whole:
        return Whole(
            self.meets, self.node, self.local[index],
            self.half[index], self.rounding[index], self.turned[index], self.extent[index],
        )  # fmt: skip

    def origin(self, frames: Array) -> Array:
        """The shape's origin `(3, phases, times)` by the frames `(4, 3, phases, times)` of its node."""
        return np.asarray(np.einsum("aipt,pa->ipt", frames[:3], self.local[:, :3, 3]) + frames[3])

    def distance_at(self, frames: Array, points: Array, phase: Indices) -> Array:
        """Signed distances `(m, times)` of points `(m, 3, times)` to the shape in some phases `(m,)`; `frames`
        `(m, times, 4, 3)` are those of its node."""
        offset = self._offsets(frames, points.transpose(0, 2, 1), phase).transpose(0, 2, 1)[:, :, None]
        half = self.half[phase][:, :, None, None]
        distance = rounded_box_distance(offset, half, self.turned[phase, None, None])[0][:, 0]
        return np.asarray(distance - self.rounding[phase, None])

    def _offsets(self, frames: Array, points: Array, phase: Indices) -> Array:
        """Points `(m, times, 3)` in the axes of the shape."""
        own = self.local[phase]
        origin = (own[:, None, None, :3, 3] @ frames[:, :, :3])[:, :, 0] + frames[:, :, 3]
        within = (frames[:, :, :3] @ (points - origin)[..., None])[..., 0]
        return np.asarray(within @ own[:, :3, :3])

    def distance_and_normal(self, frames: Array, points: Array, phase: Indices) -> tuple[Array, Array]:
        """Signed distances `(m,)` of points `(m, 3)` to the shape in some phases `(m,)`, and the world directions
        `(m, 3)` in which they grow; `frames` `(m, 4, 3)` are those of its node."""
        offset = self._offsets(frames[:, None], points[:, None], phase)[:, 0]
        turned = self.turned[phase]
        across = np.hypot(offset[:, 0], offset[:, 1])
        excess = np.abs(offset)
        excess[:, 0] = np.where(turned, across, excess[:, 0])
        excess -= self.half[phase]
        normal = np.maximum(excess, 0.0)
        length = np.sqrt((normal * normal).sum(axis=1))
        normal /= np.maximum(length, 1e-12)[:, None]
        within = np.flatnonzero(length < 1e-12)
        normal[within] = 0.0
        normal[within, excess[within].argmax(axis=1)] = 1.0
        radial = np.where(turned, normal[:, 0] / np.maximum(across, 1e-12), 0.0)
        normal *= np.where(offset < 0.0, -1.0, 1.0)
        normal[:, :2] = np.where(turned[:, None], radial[:, None] * offset[:, :2], normal[:, :2])
        outward = (self.local[phase][:, :3, :3] @ normal[..., None])[..., 0]
        outward = (outward[:, None] @ frames[:, :3])[:, 0]
        return length + np.minimum(excess.max(axis=1), 0.0) - self.rounding[phase], outward
