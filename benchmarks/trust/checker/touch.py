"""Whether shapes run into each other, from one instant to the next."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .frames import Chain
from .shapes import Solid, distance, solid_of

Matrix = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Part:
    """A shape of something in the scene with its frames (T, 4, 4)."""

    owner: str
    name: str
    solid: Solid
    frames: Matrix
    moves: bool


def parts_of(chain: Chain) -> list[tuple[str, int, Matrix, Solid]]:
    """The shapes of a module: name, joint that carries it (-1: the module frame), frame in that joint's, shape."""
    from .frames import frames_of

    found = []
    record = chain.record
    for number, link in enumerate(record["links"]):
        shape = link["shape"]
        found.append((f"link {number}", link["joint"], frames_of(link["placement"]), _solid(shape)))
    for end in record["effectors"]:
        if end["shape"] is not None:
            found.append((end["name"], end["joint"], frames_of(end["placement"]), _solid(end["shape"])))
    return found


def _solid(shape: dict[str, object]) -> Solid:
    size = shape["size"]
    assert isinstance(size, list)
    return solid_of(str(shape["kind"]), size)


def neighbours(chain: Chain) -> set[tuple[str, str]]:
    """Pairs of parts of one module that are not asked for: next to each other along the joints (joints that carry
    nothing do not count), or overlapping when all joints are at zero."""
    parts = parts_of(chain)
    carriers = {joint for _, joint, _, _ in parts}

    def carrier(joint: int) -> int:
        """The nearest joint above that carries something."""
        joint = chain.joints[joint]["parent"]
        while joint >= 0 and joint not in carriers:
            joint = chain.joints[joint]["parent"]
        return joint

    zero = [f[0] for f in chain.frames(np.zeros((1, len(chain.joints))))]
    left_out = set()
    for (one, i, a, first), (other, j, b, second) in itertools.combinations(parts, 2):
        near = i == j or (i >= 0 and carrier(i) == j) or (j >= 0 and carrier(j) == i)
        if not near and i >= 0 and j >= 0 and carrier(i) == carrier(j) and carrier(i) not in carriers:
            near = True
        if near or distance((first, zero[i] @ a), (second, zero[j] @ b)) < 0:
            left_out.add((one, other))
    return left_out


def overlaps(
    parts: Sequence[Part], skipped: set[tuple[str, str, str]], limit: float
) -> Iterator[tuple[int, str, float]]:
    """For every pair that overlaps by more than `limit` somewhere: the instant, the pair, and the deepest overlap.
    Between instants at which a pair is farther apart than both may have moved meanwhile, nothing is measured."""
    steps = [_steps(p) for p in parts]
    for (i, one), (j, other) in itertools.combinations(enumerate(parts), 2):
        if not (one.moves or other.moves):
            continue
        if one.owner == other.owner and (one.owner, one.name, other.name) in skipped:
            continue
        gaps = np.linalg.norm(one.frames[:, :3, 3] - other.frames[:, :3, 3], axis=1)
        if gaps.min() > one.solid.extent + other.solid.extent:
            continue
        found = _deepest(one, other, steps[i] + steps[j])
        if found[1] > limit:
            yield found[0], f"{one.owner} {one.name} and {other.owner} {other.name}", found[1]


def _steps(part: Part) -> Matrix:
    """How far any point of the part may move from an instant to the next, summed up from the start."""
    shift = np.linalg.norm(np.diff(part.frames[:, :3, 3], axis=0), axis=1)
    turn = np.linalg.norm(np.diff(part.frames[:, :3, :3], axis=0), axis=(1, 2))
    return np.concatenate([[0.0], np.cumsum(shift + turn * part.solid.extent)])


def _deepest(one: Part, other: Part, moved: Matrix) -> tuple[int, float]:
    at, deepest, where = 0, -np.inf, 0
    while at < len(moved):
        gap = distance((one.solid, one.frames[at]), (other.solid, other.frames[at]))
        if -gap > deepest:
            deepest, where = -gap, at
        if gap > 0:
            at = max(at + 1, int(np.searchsorted(moved, moved[at] + gap)) - 1)
        else:
            at += 1
    return where, float(deepest)
