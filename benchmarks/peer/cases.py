"""The scenes of the common motion benchmark as plain numbers, the same for both sides. Metres, radians.

Imported by the peer's process too, so it needs numpy alone.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

FOOT = 0.05
"""Radius of the spheres at both ends of the crawler."""
JOINT_HEIGHTS = (0.0, 0.15, 0.325, 0.5, 0.675, 0.85, 1.0)
AXES = "zyzyzyz"
LIMITS = (3.1, 2.1, 3.1, 2.1, 3.1, 2.1, 3.1)
HOME = (0.0, 0.3, 0.0, -0.6, 0.0, 0.3, 0.0)
LINK_RADIUS = 0.04
STAIR = (0.30, 0.80, 0.05)
JITTER = 0.03
INSET = 0.03
"""How far from the edge of a stair a foot stands at least."""
BASE = (0.30, 0.30, 0.05)
TRAY = (0.50, 0.30, 0.04)
TRAY_AT = (0.0, -0.6, 0.02)
TRAY_INSET = 0.02
ITEM = 0.06
ITEM_RADIUS = 0.6
SLICES = 20


@dataclass(frozen=True)
class Case:
    """One problem: `kind` is "climb" or "pick"; `places` are the centres of the stairs 0 … K, or of the items."""

    kind: str
    size: int
    seed: int
    places: list[list[float]] = field(default_factory=list)

    @property
    def phases(self) -> int:
        return self.size if self.kind == "climb" else 2 * self.size

    def record(self) -> dict[str, Any]:
        return asdict(self)


def climb(steps: int, seed: int) -> Case:
    """Stairs 0 … K at (0.35 i, 0, 0.20 i), each but the first moved by up to 3 cm along and up."""
    random = np.random.default_rng([seed, steps])
    places = [[0.0, 0.0, 0.0]]
    for i in range(1, steps + 1):
        along, up = random.uniform(-JITTER, JITTER, 2)
        places.append([round(0.35 * i + along, 5), 0.0, round(0.20 * i + up, 5)])
    return Case("climb", steps, seed, places)


def too_far(steps: int, seed: int, distance: float = 1.5) -> Case:
    """The same, but the last stair is `distance` away from the one before."""
    case = climb(steps, seed)
    x, y, z = case.places[-2]
    case.places[-1] = [round(x + distance, 5), y, z]
    return case


def single_step(seed: int) -> Case:
    """One step onto a box anywhere around that leaves room for the crawler as it stands at the start."""
    random = np.random.default_rng([seed, 999])
    while True:
        distance, angle, height = random.uniform((0.35, -np.pi, -0.4), (1.5, np.pi, 0.6))
        x, y = distance * np.cos(angle), distance * np.sin(angle)
        if abs(x) > 0.4 or abs(y) > 0.85:
            return Case("climb", 1, seed, [[0.0, 0.0, 0.0], [round(float(v), 5) for v in (x, y, height)]])


def pick(items: int, seed: int) -> Case:
    """Items on the floor on a half circle around the base; the tray lies opposite."""
    random = np.random.default_rng([seed, items])
    places = []
    for i in range(items):
        angle = np.pi * (i + 0.5) / items
        radius = ITEM_RADIUS + random.uniform(-0.02, 0.02)
        places.append([round(radius * np.cos(angle), 5), round(radius * np.sin(angle), 5), ITEM / 2])
    return Case("pick", items, seed, places)
