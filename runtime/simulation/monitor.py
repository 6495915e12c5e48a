"""What a run expects of the bodies around it, and whether they are still where it does."""

from __future__ import annotations

import numpy as np

from ...langs.frozen import dataclass
from ..skeleton import Array
from .sensing import Sensing
from .world import SimulatedWorld


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

    def look(self, world: SimulatedWorld, time: float | None = None) -> dict[str, Array]:
        """The poses `(7,)` of the bodies on courses, as sensed now, or at a time soon."""
        when = world.time if time is None else time
        poses = world.at(when)
        sensed = self.sensing.look(when, poses)
        return {body: np.concatenate([sensed[body], pose[3:]]) for body, pose in poses.items()}

    def expect(self, time: float, poses: dict[str, Array], *, newest: bool = False) -> None:
        """From now on bodies are expected to go on as the last looks have it; with `newest`, all of them count."""
        now, sensing = np.array([time]), self.sensing
        positions = {body: sensing.foreseen(body, pose, now, newest=newest)[0, :3] for body, pose in poses.items()}
        velocities = {body: sensing.velocity(body, newest=newest) for body in poses}
        self.expectation = Expectation(time, positions, velocities)

    def expected(self, time: float, poses: dict[str, Array]) -> dict[str, Array]:
        """The poses `(7,)` at which bodies are expected at a time; `poses` tell how they are turned."""
        expectation = self.expectation
        if expectation is None:
            return poses
        known = expectation.positions
        return {b: np.concatenate([expectation.at(b, time), pose[3:]]) for b, pose in poses.items() if b in known}

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
