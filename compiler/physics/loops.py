"""Loads in closed loops: the share of each loop is what makes the worst ratio of load to strength least."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..ir import Problem
from .frames import Array, Poses, crossed
from .least_ratio import Share, least_ratios
from .strength_rows import strength_rows
from .structure import Structure


def shared(
    problem: Problem, found: Structure, at: Poses, known: list[tuple[Array, Array]], safety: float
) -> list[tuple[Array, Array]]:
    """The wrenches of all edges, those of the trees corrected by what the loops take: sample by sample the share with
    the least worst ratio."""
    rows = strength_rows(problem, found, at, known, safety)
    taken = np.stack([share.taken for share in least_ratios(rows)]).reshape(len(rows.hung), -1, 6)
    total = rows.hung + rows.signs @ taken
    forces, moments = total[..., :3], total[..., 3:]
    moments = moments + crossed(np.broadcast_to(rows.about[:, None], forces.shape), forces)
    return [(forces[:, number], moments[:, number]) for number in range(len(found.all))]


def shares(
    problem: Problem, found: Structure, at: Poses, known: list[tuple[Array, Array]], safety: float
) -> list[Share]:
    """The best share of every sample. Where something must lift off to bear itself, that counts a hundredfold."""
    return least_ratios(strength_rows(problem, found, at, known, safety))


def ratios_of(
    problem: Problem, found: Structure, at: Poses, known: list[tuple[Array, Array]], safety: float,
    shared_so: Sequence[Share],
) -> Array:
    """What the worst ratio `(T,)` of samples is to first order beside those whose shares are given, one for each: the
    weighted rows under the same wrenches."""
    rows = strength_rows(problem, found, at, known, safety)
    taken, weights = np.stack([s.taken for s in shared_so]), np.stack([s.weights for s in shared_so])
    return np.asarray((rows.told(taken) * weights).sum(axis=1))
