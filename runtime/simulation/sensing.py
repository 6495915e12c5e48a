"""What a run knows of the bodies around it: sensed positions, estimated velocities, and what is foreseen from them."""

from __future__ import annotations

from collections import deque
from dataclasses import field, replace

import numpy as np

from ...langs.frozen import dataclass
from ..skeleton import Array
from .settings import SIMULATION

SAME_TIME = 1e-9
"""Seconds that make no difference."""


@dataclass(frozen=True, slots=True)
class FittedLine:
    """The way of a body as some looks have it: from `begin` to `end`, at `position` `(3,)` then, with a `velocity`,
    whose standard deviation is `doubt`, 1/s, times that of a look, of which there are `count`."""

    begin: float
    end: float
    position: Array
    velocity: Array
    doubt: float
    count: int

    def at(self, times: Array) -> Array:
        """Positions `(T, 3)` at times `(T,)`."""
        return np.asarray(self.position + (times - self.end)[:, None] * self.velocity)

    def blur(self, time: float) -> float:
        """The standard deviation, times that of a look, by which a look at a time is off this line."""
        lever = (time - 0.5 * (self.begin + self.end)) * self.doubt
        return float(np.sqrt(1.0 + 1.0 / self.count + lever**2))


@dataclass(slots=True)
class Sighting:
    """The last looks at one body: times and positions `(3,)`; and, of each change of its way, when it was noticed, and
    the last look before."""

    times: deque[float] = field(default_factory=lambda: deque(maxlen=SIMULATION.kept_looks))
    positions: deque[Array] = field(default_factory=lambda: deque(maxlen=SIMULATION.kept_looks))
    changes: deque[tuple[float, float]] = field(default_factory=lambda: deque(maxlen=SIMULATION.kept_looks))

    def line(self, known: float = np.inf) -> FittedLine:
        """By least squares through the looks up to a time, or else the first one; at rest after a single look."""
        begin = max((since for noticed, since in self.changes if noticed <= known + SAME_TIME), default=-np.inf)
        chosen = [k for k, time in enumerate(self.times) if begin <= time <= known + SAME_TIME]
        chosen = chosen[-SIMULATION.memory :] or [0]
        times, positions = (np.array([rows[k] for k in chosen]) for rows in (self.times, self.positions))
        if len(chosen) < 2:
            return FittedLine(times[0], times[0], positions[0], np.zeros(3), np.inf, 1)
        slope, origin = np.polyfit(times - times[-1], positions, 1)
        doubt = 1.0 / float(np.linalg.norm(times - times.mean()))
        return FittedLine(times[0], times[-1], np.asarray(origin), np.asarray(slope), doubt, len(chosen))


class Sensing:
    """Looks at the bodies that may move. Positions are read with normal noise of `sigma` metres per axis, from the
    generator given; orientations without. What is foreseen rests on the looks up to the time `known`."""

    def __init__(self, sigma: float, random: np.random.Generator) -> None:
        self.sigma = sigma
        self.tolerance = SIMULATION.tolerance + SIMULATION.sure * sigma
        self.known = np.inf
        self._random = random
        self._seen: dict[str, Sighting] = {}

    def look(self, time: float, poses: dict[str, Array]) -> dict[str, Array]:
        """Sense the poses `(7,)` of bodies at a time; gives the sensed positions `(3,)`. A body that is not where the
        looks before would have it has changed its way: from then on only the last look before still counts, and not
        even that after a push."""
        found = {}
        for name, pose in poses.items():
            position = pose[:3] + (self._random.normal(0.0, self.sigma, 3) if self.sigma else 0.0)
            sighting = self._seen.setdefault(name, Sighting())
            if sighting.times and time - sighting.times[-1] < SAME_TIME:
                found[name] = sighting.positions[-1]
                continue
            self._check_way(sighting, time, position)
            sighting.times.append(time)
            sighting.positions.append(position)
            found[name] = position
        return found

    def _check_way(self, sighting: Sighting, time: float, position: Array) -> None:
        line = sighting.line() if sighting.times else None
        if line is None or line.begin == line.end:
            return
        off = float(np.linalg.norm(line.at(np.array([time]))[0] - position))
        if off > 0.5 * SIMULATION.tolerance + SIMULATION.rare * self.sigma * line.blur(time):
            sighting.changes.append((time, time if off > SIMULATION.pushed else sighting.times[-1]))
        elif self.sigma:
            turned = self._turned(sighting, line.begin)
            sighting.changes += [] if turned is None else [(time, turned)]

    def _turned(self, sighting: Sighting, begin: float) -> float | None:
        """Since when the looks from `begin` on go another way, which only several of them tell from noise: a line with
        a bend, by least squares, has a bend that is sure."""
        since = [k for k, time in enumerate(sighting.times) if time >= begin][-SIMULATION.memory:]
        times = np.array([sighting.times[k] for k in since])
        positions = np.array([sighting.positions[k] for k in since])
        for ago in SIMULATION.ago:
            if len(since) < SIMULATION.enough + ago:
                break
            bend = times[-ago - 1]
            rows = np.column_stack([np.ones_like(times), times - bend, np.maximum(times - bend, 0.0)])
            inverse = np.linalg.inv(rows.T @ rows)
            change = (inverse @ (rows.T @ positions))[2]
            if float(np.linalg.norm(change)) > SIMULATION.sure * self.sigma * np.sqrt(inverse[2, 2]):
                return float(bend)
        return None

    def last(self, body: str) -> Array:
        """The position `(3,)` at the last look."""
        return self._seen[body].positions[-1]

    def velocity(self, body: str, *, newest: bool = False) -> Array:
        """The estimated velocity `(3,)` in m/s; what is not told apart from noise is zero. With `newest`, all looks
        count."""
        known = np.inf if newest else self.known
        return self._way(body, known).velocity if body in self._seen else np.zeros(3)

    def foreseen(self, body: str, pose: Array, times: Array, *, newest: bool = False) -> Array:
        """The poses `(T, 7)` of a body at some times; `pose` tells its orientation. With `newest`, all looks count."""
        way = self._way(body, np.inf if newest else self.known)
        return np.column_stack([way.at(times), np.tile(pose[3:], (len(times), 1))])

    def _way(self, body: str, known: float) -> FittedLine:
        line = self._seen[body].line(known)
        sure = float(np.linalg.norm(line.velocity)) > max(1e-5, SIMULATION.likely * self.sigma * line.doubt)
        return line if sure else replace(line, velocity=np.zeros(3))
