"""What a run knows of the bodies around it: sensed positions, estimated velocities, and what is foreseen from them."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

import numpy as np

from ..skeleton import Array

PERIOD = 0.05
"""Seconds between two looks at the scene."""
MEMORY = 20
"""Looks from which a velocity is estimated."""
TOLERANCE = 5e-4
"""Metres by which a body may be off where a window expects it."""
SURE = 5.0
"""Standard deviations of the noise that make no difference."""


@dataclass(slots=True)
class Sighting:
    """The last looks at one body: times and positions `(3,)`."""

    times: deque[float] = field(default_factory=lambda: deque(maxlen=MEMORY))
    positions: deque[Array] = field(default_factory=lambda: deque(maxlen=MEMORY))

    def line(self) -> tuple[Array, Array]:
        """Position at the last look, and velocity, by least squares; at rest after a single look."""
        if len(self.times) < 2:
            return self.positions[-1], np.zeros(3)
        times = np.array(self.times) - self.times[-1]
        slope, origin = np.polyfit(times, np.array(self.positions), 1)
        return np.asarray(origin), np.asarray(slope)


class Sensing:
    """Looks at the bodies that may move. Positions are read with normal noise of `sigma` metres per axis, from the
    generator given; orientations without."""

    def __init__(self, sigma: float, random: np.random.Generator) -> None:
        self.sigma = sigma
        self.tolerance = TOLERANCE + SURE * sigma
        self._random = random
        self._seen: dict[str, Sighting] = {}

    def look(self, time: float, poses: dict[str, Array]) -> dict[str, Array]:
        """Sense the poses `(7,)` of bodies at a time; gives the sensed positions `(3,)`. A body that is not where the
        looks before would have it has changed its way: only the last look before still counts."""
        found = {}
        for name, pose in poses.items():
            position = pose[:3] + (self._random.normal(0.0, self.sigma, 3) if self.sigma else 0.0)
            sighting = self._seen.setdefault(name, Sighting())
            if sighting.times and time - sighting.times[-1] < 1e-9:
                found[name] = sighting.positions[-1]
                continue
            self._check_way(sighting, time, position)
            sighting.times.append(time)
            sighting.positions.append(position)
            found[name] = position
        return found

    def _check_way(self, sighting: Sighting, time: float, position: Array) -> None:
        if len(sighting.times) < 2:
            return
        here, velocity = sighting.line()
        off = float(np.linalg.norm(here + velocity * (time - sighting.times[-1]) - position))
        if off > 0.5 * self.tolerance:
            while len(sighting.times) > 1:
                sighting.times.popleft()
                sighting.positions.popleft()

    def last(self, body: str) -> Array:
        """The position `(3,)` at the last look."""
        return self._seen[body].positions[-1]

    def velocity(self, body: str) -> Array:
        """The estimated velocity `(3,)` in m/s; what is not told apart from noise is zero."""
        sighting = self._seen.get(body)
        if sighting is None or len(sighting.times) < 2:
            return np.zeros(3)
        _, velocity = sighting.line()
        span = sighting.times[-1] - sighting.times[0]
        certain = max(1e-5, SURE * self.sigma / span)
        return velocity if float(np.linalg.norm(velocity)) > certain else np.zeros(3)

    def foreseen(self, body: str, pose: Array, seconds: float) -> Array:
        """The pose `(7,)` of a body some seconds after the last look; `pose` tells its orientation."""
        position, _ = self._seen[body].line()
        result = pose.copy()
        result[:3] = position + seconds * self.velocity(body)
        return result
