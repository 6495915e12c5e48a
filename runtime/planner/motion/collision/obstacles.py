"""The bodies at rest of a program, numbered: first those that never move, which all programs of a scene share."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from .....compiler.extents import box_sides
from .....compiler.ir import Body, Shape, SolidPart, World
from .....compiler.motion.collision import pose_matrix
from .....compiler.remembering import remembered
from .....langs.frozen import dataclass
from ....geometry.exact_distances import Forms, Posed
from ....geometry.transforms import rotations
from ....skeleton import Array, fixed_poses
from .broad_phase import Edges


@dataclass(frozen=True, slots=True)
class Fixed:
    """Solid bodies that never move: how many `parts` each has, where they are `(F, 7)`, their parts one after the
    other, and the edges of the boxes around these."""

    parts: dict[str, int]
    poses: Array
    posed: Posed
    edges: Edges


def fixed_obstacles(world: World, resting: Mapping[str, Array]) -> Fixed:
    """The solid ones among the bodies that never move, where they are `resting` `(7,)`."""
    if resting is fixed_poses(world):
        return _fixed(world)
    names = _names(world)
    poses = np.array([resting[name] for name in names]).reshape(-1, 7)
    known = _fixed(world)
    return known if np.array_equal(known.poses, poses) else _placed(world, names, poses)


@remembered(4)
def _names(world: World) -> list[str]:
    return [b.name for b in world.solids if not b.movable]


@remembered(4)
def _fixed(world: World) -> Fixed:
    names = _names(world)
    return _placed(world, names, np.array([world.bodies[name].pose for name in names]).reshape(-1, 7))


def _placed(world: World, names: list[str], poses: Array) -> Fixed:
    found = {name: world.bodies[name].shape.solids for name in names}
    parts = {name: len(solids) for name, solids in found.items()}
    shapes = [part.shape for solids in found.values() for part in solids]
    at = np.array([part.at for solids in found.values() for part in solids]).reshape(-1, 3)
    bodies = np.repeat(poses, list(parts.values()), axis=0)
    turned = rotations(bodies[:, 3:])
    places = bodies[:, :3] + np.einsum("pij,pj->pi", turned, at)
    posed = Posed(Forms(shapes), np.arange(len(shapes)), places, turned)
    return Fixed(parts, poses, posed, _edges(posed))


def _matrices(pose: Array, solids: Sequence[SolidPart]) -> list[Array]:
    frame = pose_matrix(pose)
    return [frame @ pose_matrix(part.placement) for part in solids]


class Obstacles:
    """The fixed bodies, numbered as there, and others at rest at known places."""

    def __init__(self, fixed: Fixed) -> None:
        self.fixed = fixed
        self._shapes: list[Shape] = []
        self._matrices: list[Array] = []
        self._of: dict[tuple[str, int], range] = {}

    def add(self, body: Body, place: int, pose: Array) -> range:
        """The numbers of the parts of a body that rests at `pose`, which `place` stands for."""
        if (body.name, place) not in self._of:
            first, solids = len(self.fixed.posed.form) + len(self._shapes), body.shape.solids
            self._of[body.name, place] = range(first, first + len(solids))
            self._shapes += [part.shape for part in solids]
            self._matrices += _matrices(pose, solids)
        return self._of[body.name, place]

    def posed(self) -> Posed:
        """All of them."""
        fixed, others = self.fixed.posed, _posed(self._shapes, self._matrices)
        return Posed(
            fixed.forms.joined(others.forms), np.arange(len(fixed.form) + len(others.form)),
            np.concatenate([fixed.position, others.position]), np.concatenate([fixed.rotation, others.rotation]),
        )  # fmt: skip

    def edges(self) -> Edges:
        """Least and greatest coordinates of all of them."""
        others = _edges(_posed(self._shapes, self._matrices))
        low, high = (np.concatenate(sides) for sides in zip(self.fixed.edges, others, strict=True))
        return low, high


def _posed(shapes: list[Shape], matrices: list[Array]) -> Posed:
    stack = np.array(matrices).reshape(-1, 4, 4)
    return Posed(Forms(shapes), np.arange(len(stack)), stack[:, :3, 3], stack[:, :3, :3])


def _edges(posed: Posed) -> Edges:
    half = np.array([box_sides(s) for s in posed.forms.shapes]).reshape(-1, 3) / 2
    around = np.einsum("bij,bj->bi", np.abs(posed.rotation), half)
    return posed.position - around, posed.position + around
