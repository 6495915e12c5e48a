"""What a run expects of the bodies around it, and whether they are still where it does."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..skeleton import Array
from .sensing import Sensing
from .world import World


@dataclass(frozen=True, slots=True)
class Expectation:
    """Where bodies are expected: sensed at `time`, moving on with constant velocities."""

    time: float
    positions: dict[str, Array]
    velocities: dict[str, Array]

    def at(self, body: str, time: float) -> Array:
        return np.asarray(self.positions[body] + (time - self.time) * self.velocities[body])


class Lookout:
    """Looks at the bodies of a world that are on courses, and remembers what a window was planned for."""

    def __init__(self, sensing: Sensing) -> None:
        self.sensing = sensing
        self.expectation: Expectation | None = None

    def look(self, world: World, time: float | None = None) -> dict[str, Array]:
        """The poses `(7,)` of the bodies on courses, as sensed now, or at a time soon."""
        when = world.time if time is None else time
        poses = world.at(when)
        sensed = self.sensing.look(when, poses)
        return {body: np.concatenate([sensed[body], pose[3:]]) for body, pose in poses.items()}

    def expect(self, time: float, poses: dict[str, Array]) -> None:
        """From now on bodies are expected to go on as the last looks have it."""
        now = np.array([time])
        positions = {body: self.sensing.foreseen(body, pose, now)[0, :3] for body, pose in poses.items()}
        self.expectation = Expectation(time, positions, {body: self.sensing.velocity(body) for body in poses})

    def strayed(self, bodies: frozenset[str], time: float) -> dict[str, float]:
        """Those of `bodies` that are not where they should be at the last look, and by how many metres."""
        if self.expectation is None:
            return {}
        found = {}
        for body in sorted(bodies & self.expectation.positions.keys()):
            off = float(np.linalg.norm(self.sensing.last(body) - self.expectation.at(body, time)))
            if off > self.sensing.tolerance:
                found[body] = off
        return found
