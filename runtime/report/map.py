"""The search tree as a picture: dots in rows by their depth, each above the middle of what hangs below it."""

from __future__ import annotations

from collections.abc import Sequence

from ...langs.frozen import dataclass
from .tree import Branch

WIDTH = 1000.0
MOST_DOTS = 600
"""More cannot be told apart on a page."""
LEAST_ROW, MOST_ROW, MOST_HEIGHT = 14.0, 60.0, 420.0


@dataclass(frozen=True, slots=True)
class Dot:
    x: float
    y: float
    kind: str
    text: str


@dataclass(frozen=True, slots=True)
class Stroke:
    x: float
    y: float
    to_x: float
    to_y: float
    kind: str


@dataclass(frozen=True, slots=True)
class TreeMap:
    """In units of `WIDTH` across; `kind` is `chosen`, `refused` or nothing."""

    dots: list[Dot]
    lines: list[Stroke]
    height: float
    radius: float
    left_out: int


def picture(branches: Sequence[Branch]) -> TreeMap:
    """Of the first branches, which stand depth first."""
    kept = branches[:MOST_DOTS]
    parents = _parents(kept)
    places: list[list[float]] = [[] for _ in kept]
    leaves = sum(not (i + 1 < len(kept) and parents[i + 1] == i) for i in range(len(kept)))
    column, x = leaves, [0.0] * len(kept)
    for i in reversed(range(len(kept))):
        if not places[i]:
            column -= 1
            places[i].append(WIDTH * (column + 0.5) / leaves)
        x[i] = sum(places[i]) / len(places[i])
        if parents[i] >= 0:
            places[parents[i]].append(x[i])
    deepest = max((b.depth for b in kept), default=0)
    row = min(MOST_ROW, max(LEAST_ROW, MOST_HEIGHT / max(deepest, 1)))
    dots = [Dot(x[i], row * b.depth, _kind(b), _text(b)) for i, b in enumerate(kept)]
    lines = [
        Stroke(dots[k].x, dots[k].y, dot.x, dot.y, "chosen" if dot.kind == "chosen" else "")
        for dot, k in zip(dots, parents, strict=True)
        if k >= 0
    ]
    radius = min(5.0, max(1.5, 0.3 * WIDTH / max(leaves, 1)))
    return TreeMap(dots, lines, row * max(deepest, 1), radius, len(branches) - len(kept))


def _parents(branches: Sequence[Branch]) -> list[int]:
    """The place of the node above each, -1 of a root."""
    above: list[int] = []
    found = []
    for i, branch in enumerate(branches):
        del above[branch.depth :]
        found.append(above[-1] if above else -1)
        above.append(i)
    return found


def _kind(branch: Branch) -> str:
    if branch.reasons:
        return "refused"
    return "chosen" if branch.chosen and branch.depth > 0 else ""


def _text(branch: Branch) -> str:
    told = [branch.node.action or "start", branch.node.status, *(f"{r.bound}: {r.reason}" for r in branch.reasons)]
    return "; ".join(filter(None, told))
