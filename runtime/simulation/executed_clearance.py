"""How near an executed motion comes to what its plan keeps clear of, by coal."""

from __future__ import annotations

import numpy as np

from ...compiler.ir import ShapeKind
from ..plan import Plan
from ..verify.geometry import Array, Frames
from ..verify.kinematics import Motion
from ..verify.shapes import Ruler, transform
from ..verify.solids import Solid, pairs, solids
from .settings import SIMULATION


def worst_clearance(plan: Plan, planned: Motion, executed: Motion) -> tuple[float | None, tuple[str, ...]]:
    """The least distance in metres of two shapes in the executed motion that the plan keeps apart, and their names."""
    found = solids(plan)
    looks = np.arange(0, len(planned.times), SIMULATION.clearance_stride)
    before = [_frames(s, planned, looks) for s in found]
    after = [_frames(s, executed, looks) for s in found]
    own = {c.body for c in plan.courses}
    ruler, worst, names = Ruler(), np.inf, ("", "")
    for i, k in pairs(plan, found, own):
        bound = np.linalg.norm(after[i].position - after[k].position, axis=1) - found[i].radius - found[k].radius
        for box, at, other, ball in ((i, after[i], k, after[k]), (k, after[k], i, after[i])):
            bound = np.maximum(bound, _outside(found[box], at, ball) - found[other].radius)
        for t in np.flatnonzero(bound < min(SIMULATION.clearance_far, worst)):
            distance = _distance(ruler, found[i], after[i], found[k], after[k], int(t))
            if distance >= worst:
                continue
            if _distance(ruler, found[i], before[i], found[k], before[k], int(t)) > SIMULATION.clearance_apart:
                worst, names = distance, (found[i].name, found[k].name)
    return (None, ()) if np.isinf(worst) else (float(worst), names)


def _outside(solid: Solid, frames: Frames, other: Frames) -> Array:
    """How far the centre of another shape is outside of a box, `(T,)`; 0 for other shapes."""
    if solid.kind != ShapeKind.BOX:
        return np.full(len(frames), -np.inf)
    local = np.abs(np.einsum("tji,tj->ti", frames.rotation, other.position - frames.position))
    return np.asarray(np.linalg.norm(np.maximum(local - 0.5 * np.asarray(solid.size), 0.0), axis=1))


def _frames(solid: Solid, motion: Motion, looks: np.typing.NDArray[np.intp]) -> Frames:
    if solid.joint is None:
        return motion.frames[solid.thing][looks]
    return motion.joint_frames[solid.thing][solid.joint][looks].compose(solid.placement)


def _distance(ruler: Ruler, first: Solid, a: Frames, second: Solid, b: Frames, at: int) -> float:
    return ruler.distance(
        first.solid, transform(a.position[at], a.rotation[at]), second.solid, transform(b.position[at], b.rotation[at])
    )
