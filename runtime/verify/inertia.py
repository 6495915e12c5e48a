"""Masses of shapes at the density of water, and centres of mass of modules on the samples of a motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np

from ...compiler import ir
from ...compiler.distinct import distinct
from ...compiler.remembering import remembered
from ...langs.frozen import dataclass
from .geometry import Array, Frames, Indices, frames
from .shapes import volume

KILOGRAMS_PER_LITRE = 1.0


def mass_of(shape: ir.Shape) -> float:
    """Kilograms of a solid shape given in metres, at the density of water."""
    if shape.parts:
        boxes = [part for part in shape.parts if part.shape.kind == ir.ShapeKind.BOX]
        others = sum(mass_of(part.shape) for part in shape.parts if part.shape.kind != ir.ShapeKind.BOX)
        return others + 1000.0 * KILOGRAMS_PER_LITRE * _filled(boxes)
    if shape.kind == ir.ShapeKind.CONVEX:
        return 1000.0 * KILOGRAMS_PER_LITRE * volume(shape.size)
    match shape.kind, [10.0 * s for s in shape.size]:
        case ir.ShapeKind.BOX, [x, y, z]:
            litres = x * y * z
        case ir.ShapeKind.SPHERE, [r]:
            litres = 4.0 / 3.0 * np.pi * r**3
        case ir.ShapeKind.CAPSULE, [r, length]:
            litres = np.pi * r * r * (length + 4.0 / 3.0 * r)
        case _, [r, length]:
            litres = np.pi * r * r * length
        case _:
            litres = 0.0
    return float(KILOGRAMS_PER_LITRE * litres)


def _filled(boxes: Sequence[ir.SolidPart]) -> float:
    """Cubic metres that boxes fill together: layer by layer between their ends in z, the cells of each one on the grid
    of the sides of those that it cuts."""
    if not boxes:
        return 0.0
    middles, halves = np.array([b.at for b in boxes]), 0.5 * np.array([b.shape.size for b in boxes])
    low, high, total = middles - halves, middles + halves, 0.0
    levels = distinct(np.concatenate([low[:, 2], high[:, 2]]))
    for bottom, top in pairwise(levels):
        cut = (low[:, 2] <= bottom) & (high[:, 2] >= top)
        across, along = (distinct(np.concatenate([low[cut, k], high[cut, k]])) for k in (0, 1))
        filled = np.zeros((max(len(across) - 1, 0), max(len(along) - 1, 0)), dtype=bool)
        for near, far in zip(low[cut], high[cut], strict=True):
            x, y = (slice(*np.searchsorted(grid, (near[k], far[k]))) for k, grid in ((0, across), (1, along)))
            filled[x, y] = True
        total += (top - bottom) * float(np.diff(across) @ filled @ np.diff(along))
    return float(total)


def moments(shape: ir.Shape, mass: float) -> Array:
    """The inertia (3, 3) of a solid shape about its middle, kg m²; a convex one counts as the box around it, one of
    several parts as these."""
    if shape.parts:
        own = np.array([mass_of(part.shape) for part in shape.parts])
        shares, at = mass * own / own.sum(), np.array([part.at for part in shape.parts])
        turning = sum(moments(part.shape, float(m)) for part, m in zip(shape.parts, shares, strict=True))
        squares = np.einsum("n,ni,nj->ij", shares, at, at)
        return np.asarray(turning + np.trace(squares) * np.eye(3) - squares)
    size = shape.size
    if shape.kind == ir.ShapeKind.SPHERE:
        squares = [size[0] ** 2 / 5.0] * 3
    elif shape.kind in (ir.ShapeKind.BOX, ir.ShapeKind.CONVEX):
        sides = np.ptp(np.reshape(size, (-1, 3)), axis=0) if shape.kind == ir.ShapeKind.CONVEX else np.array(size)
        squares = list(sides**2 / 12.0)
    else:
        radius, length = size
        tube, ball = np.pi * radius**2 * length, 4.0 / 3.0 * np.pi * radius**3 * (shape.kind == ir.ShapeKind.CAPSULE)
        caps = radius**2 / 5.0 + length**2 / 4.0 + 3.0 * radius * length / 8.0
        along = (tube * length**2 / 12.0 + ball * caps) / (tube + ball)
        squares = [(tube * radius**2 / 4.0 + ball * radius**2 / 5.0) / (tube + ball)] * 2 + [along]
    x, y, z = (mass * float(s) for s in squares)
    return np.diag([y + z, x + z, x + y])


def body_mass(body: ir.Body) -> float:
    """Kilograms of a body."""
    return mass_of(body.shape) if body.mass is None else body.mass


def weights(module: ir.ModuleType) -> list[tuple[int, ir.Pose, float, Array]]:
    """What weighs in a module: the joint that carries it, where it sits there, kilograms, stated or of water, and its
    inertia about there."""
    found: list[tuple[int, ir.Pose, float, Array]] = []

    def add(joint: int, placement: ir.Pose, shape: ir.Shape, stated: float | None) -> None:
        mass = mass_of(shape) if stated is None else stated
        alone = [mass_of(part.shape) for part in shape.solids]
        for part, own in zip(shape.solids, alone, strict=True):
            x, y, z = frames(placement).compose(frames(part.placement)).position[0].tolist()
            share = mass * own / sum(alone)
            found.append((joint, (x, y, z, *placement[3:]), share, moments(part.shape, share)))

    for end in module.effectors:
        if end.shape is not None:
            add(end.joint, end.placement, end.shape, end.mass)
    for link in module.links:
        add(link.joint, link.placement, link.shape, link.mass)
    found += [(j.parent, j.placement, j.mass, np.zeros((3, 3))) for j in module.joints if j.mass > 0.0]
    for given in module.inertials:
        xx, xy, xz, yy, yz, zz = given.inertia
        matrix = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        found.append((given.joint, (*given.centre, 0.0, 0.0, 0.0, 1.0), given.mass, matrix))
    return found


@dataclass(frozen=True, slots=True)
class Weight:
    """Kilograms of a rigid part, their `centre` (3,) in its frame, and the `inertia` (3, 3) about that, along the axes
    of its frame, kg m²."""

    mass: float
    centre: Array
    inertia: Array


@remembered(8)
def node_weights(problem: ir.Problem) -> Mapping[tuple[str, int], Weight]:
    """What weighs in each rigid part that may move: the frame of a module's joint (-1: its own), or a body (-1)."""
    found: dict[tuple[str, int], Weight] = {}
    for name, module in problem.world.modules.items():
        parts: dict[int, list[tuple[ir.Pose, float, Array]]] = {}
        for joint, placement, mass, inertia in weights(module.type):
            parts.setdefault(joint, []).append((placement, mass, inertia))
        found |= {(name, joint): _joined(own) for joint, own in parts.items()}
    for name, body in problem.world.bodies.items():
        if body.movable:
            mass = body_mass(body)
            found[name, -1] = Weight(mass, np.zeros(3), moments(body.shape, mass))
    return found


def _joined(parts: Sequence[tuple[ir.Pose, float, Array]]) -> Weight:
    at, masses = frames([placement for placement, _, _ in parts]), np.array([mass for _, mass, _ in parts])
    total = float(masses.sum())
    centre = masses @ at.position / total if total else np.zeros(3)
    whole = np.zeros((3, 3))
    for turn, out, (_, mass, inertia) in zip(at.rotation, at.position - centre, parts, strict=True):
        whole += turn @ inertia @ turn.T + mass * (float(out @ out) * np.eye(3) - np.outer(out, out))
    return Weight(total, centre, whole)


def centre_of(module: ir.ModuleType, joints: Mapping[int, Frames], at: Indices) -> tuple[float, Array]:
    """Mass, and centres of mass `(T, 3)` at samples `at`, of a module whose joint frames are given."""
    total, moment = 0.0, np.zeros((len(at), 3))
    for joint, placement, mass, _ in weights(module):
        moment += mass * joints[joint][at].compose(frames(placement)).position
        total += mass
    return (total, moment / total) if total else (1e-3, joints[-1][at].position)
