"""What shapes sweep between neighbouring instants: boxes along the world's axes around it, and how far they move.

Nothing here looks at shapes two by two in earnest; it says which pairs need no look, and when."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...compiler.ir import ShapeKind
from ...langs.frozen import dataclass
from .geometry import Array, Frames, Indices
from .solids import Solid


@dataclass(frozen=True, slots=True)
class Sweep:
    """A solid in one phase, at `T` instants, or at one when it rests.

    `frames` of its shape; `low` and `high` `(T - 1, 3)`: the corners of a box that holds it all the while between
    neighbouring instants. `lowest` and `highest` `(3,)` are those for all of them. Of what rests, `low` and `high` have
    one entry.
    """

    solid: Solid
    frames: Frames
    low: Array
    high: Array
    lowest: Array
    highest: Array

    @property
    def rests(self) -> bool:
        """Whether it keeps its place for the whole phase."""
        return len(self.frames) == 1

    def at(self, instant: int) -> tuple[Array, Array]:
        """Position `(3,)` and rotation `(3, 3)` at an instant."""
        index = 0 if self.rests else instant
        return self.frames.position[index], self.frames.rotation[index]

    def during(self, first: int, last: int) -> Frames:
        """The frames at instants `first` … `last`; one frame of what rests."""
        return self.frames if self.rests else self.frames[slice(first, last + 1)]


def sweep(solid: Solid, frames: Frames, bend: Array) -> Sweep:
    """What a solid sweeps whose points get at most `bend` `(T - 1,)` metres away from the straight line between where
    they are at neighbouring instants."""
    points = _points(solid, frames)
    low, high = points.min(axis=1) - solid.ball, points.max(axis=1) + solid.ball
    if len(frames) == 1:
        return Sweep(solid, frames, low, high, low[0], high[0])
    margin = bend[:, None]
    low, high = np.minimum(low[1:], low[:-1]) - margin, np.maximum(high[1:], high[:-1]) + margin
    return Sweep(solid, frames, low, high, low.min(axis=0), high.max(axis=0))


def edges(sweeps: list[Sweep]) -> tuple[Array, Array]:
    """The corners `(S, 3)` of boxes around the whole phase."""
    low = np.array([s.lowest for s in sweeps]).reshape(-1, 3)
    return low, np.array([s.highest for s in sweeps]).reshape(-1, 3)


def resting_edges(solids: Sequence[Solid], frames: Sequence[Frames]) -> tuple[Array, Array]:
    """The same for solids that rest, each with its frame `(1,)`; those of one shape are looked at together."""
    low, high = np.zeros((len(solids), 3)), np.zeros((len(solids), 3))
    alike: dict[tuple[int, float], list[int]] = {}
    for k, solid in enumerate(solids):
        alike.setdefault((id(solid.points), solid.ball), []).append(k)
    for numbers in alike.values():
        places = Frames(
            np.concatenate([frames[k].position for k in numbers]), np.concatenate([frames[k].rotation for k in numbers])
        )
        solid = solids[numbers[0]]
        points = _points(solid, places)
        low[numbers], high[numbers] = points.min(axis=1) - solid.ball, points.max(axis=1) + solid.ball
    return low, high


def near_pairs(low: Array, high: Array, looked_at: Indices) -> Indices:
    """Which of the pairs `(P, 2)` of boxes, by their corners `(S, 3)`, overlap."""
    first, second = looked_at[:, 0], looked_at[:, 1]
    apart = (low[first] > high[second]) | (low[second] > high[first])
    return np.asarray(np.flatnonzero(~apart.any(axis=1)), dtype=np.intp)


def near_resting(moving: Sweep, low: Array, high: Array) -> list[tuple[int, int] | None]:
    """As `near_instants`, for a solid that moves and boxes `(K, 3)` around others that rest."""
    overlap = np.ones((len(low), len(moving.low)), dtype=bool)
    for k in range(3):
        overlap &= (moving.low[:, k] <= high[:, k, None]) & (low[:, k, None] <= moving.high[:, k])
    first, after = overlap.argmax(axis=1), overlap.shape[1] - overlap[:, ::-1].argmax(axis=1)
    return [(int(first[k]), int(after[k])) if overlap[k].any() else None for k in range(len(low))]


def near_instants(a: Sweep, b: Sweep) -> tuple[int, int] | None:
    """The first and the last instant between which two solids, one of them moving, may come near, if ever."""
    overlap = ((a.low <= b.high) & (b.low <= a.high)).all(axis=1)
    near = np.flatnonzero(overlap)
    return (int(near[0]), int(near[-1]) + 1) if len(near) else None


def lower_bound(a: Sweep, b: Sweep, first: int, last: int) -> Array:
    """A lower bound `(last - first + 1,)` of the distance at instants `first` … `last`, from bounding spheres and
    boxes."""
    frames = a.during(first, last), b.during(first, last)
    between = frames[1].position - frames[0].position
    bound: Array = np.linalg.norm(between, axis=1) - a.solid.radius - b.solid.radius
    for box, other, frame, way in ((a.solid, b.solid, frames[0], between), (b.solid, a.solid, frames[1], -between)):
        if box.kind == ShapeKind.BOX:
            local = np.abs(way[:, None, :] @ frame.rotation)[:, 0, :]
            outside = np.linalg.norm(np.maximum(local - 0.5 * np.asarray(box.size), 0.0), axis=1)
            bound = np.maximum(bound, outside - other.radius)
    return bound


def relative_steps(a: Sweep, b: Sweep, first: int, last: int) -> Array:
    """How far any point of `a` moves, seen from `b`, between neighbouring instants `first` … `last`, in a straight
    line."""
    seen = a.during(first, last)
    if not b.rests:
        seen = seen.relative_to(b.during(first, last))
    return np.zeros(last - first) if len(seen) == 1 else _steps(_points(a.solid, seen))


def _points(solid: Solid, frames: Frames) -> Array:
    """The points whose hull, grown by its ball, holds a solid `(T, M, 3)`."""
    return frames.position[:, None, :] + solid.points @ np.swapaxes(frames.rotation, -1, -2)


def _steps(points: Array) -> Array:
    """How far any of the points `(T, M, 3)` moves between neighbouring instants `(T - 1,)`."""
    way = np.diff(points, axis=0)
    return np.asarray(np.sqrt(np.square(way).sum(axis=2).max(axis=1)))
