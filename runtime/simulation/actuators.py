"""Simulated drives: joints that follow commanded values with seeded noise.

Every joint is a drive that is told position, speed and acceleration of the command at each step and corrects what its
sensor shows (feed-forward and a critically damped PD law). Its acceleration misses the command by normal noise; its
sensor reads with normal noise. Inertia and load are taken to be fed forward exactly. A joint that rests is braked.
"""

from __future__ import annotations

import math

import numpy as np

from ...langs.diagnostics import UsageError
from ...langs.frozen import dataclass
from ..skeleton import Array
from .settings import SIMULATION


@dataclass(frozen=True, slots=True)
class Noise:
    """Standard deviations: `position` of sensed bodies (m), `joint` of sensed joints (rad or m), `drive` of the
    accelerations that drives give (rad/s² or m/s²)."""

    position: float = 0.0
    joint: float = 5e-4
    drive: float = 0.5

    def __post_init__(self) -> None:
        for name, value in (("position", self.position), ("joint", self.joint), ("drive", self.drive)):
            number = isinstance(value, int | float | np.number) and not isinstance(value, bool)
            if not number or not 0.0 <= value < math.inf:
                raise UsageError(f"`{name}` of a noise is a number from 0, not {value!r}")


EXACT = Noise(0.0, 0.0, 0.0)


def missed(noise: Noise, random: np.random.Generator, error: Array, times: Array) -> Array:
    """How far joints are from their commanded values at increasing `times`, `(T, n)`, while they move: `error` `(n,)`
    at the first one, at which they rest."""
    steps = max(1, int(np.ceil((times[-1] - times[0]) / SIMULATION.drive_step)))
    length = (times[-1] - times[0]) / steps
    misses = random.normal(0.0, noise.drive, (steps, len(error)))
    reads = random.normal(0.0, noise.joint, (steps, len(error)))
    errors = np.empty((steps + 1, len(error)))
    errors[0], rate = error, np.zeros(len(error))
    gain, damping = SIMULATION.drive_frequency**2, 2.0 * SIMULATION.drive_frequency
    for k in range(steps):
        rate = rate + length * (misses[k] - gain * (errors[k] + reads[k]) - damping * rate)
        errors[k + 1] = errors[k] + length * rate
    grid = np.linspace(times[0], times[-1], steps + 1)
    return np.array([np.interp(times, grid, column) for column in errors.T]).reshape(len(error), -1).T
