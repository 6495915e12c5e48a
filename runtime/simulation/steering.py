"""Steers the rest of a motion to where what it is to meet will be, while it is carried out.

A motion ends where one thing comes to be at a place relative to another: an end on a body, a body on a body, an end at
an end. When bodies turn out to move otherwise than expected, its last joint values are corrected so that these places
stay the same (Gauss-Newton on the few joints that move), and the correction is blended in over what is left of the
motion, so that speed and acceleration stay continuous. That is a matter of milliseconds; no window is planned for it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from ...compiler import ir
from ...compiler.kept_pairs import kept_pairs
from ..geometry.attachments import carrier
from ..geometry.resampling import effector_poses
from ..geometry.transforms import compose, coupled, inverse
from ..planner.motion.end_conditions import least_jerk, settled
from ..skeleton import Array, Configuration, Phase, PhasePath
from .braking import at_times, within_limits
from .settings import SIMULATION
from .world import carried, moves

CHANGE = 1e-6
"""Step of the differences by which derivatives are found, radians or metres."""


class Steering:
    """Steers one phase, which begins in the configuration `before`: what it lets meet at its end are pairs of names,
    with the poses `(P, 7)` of the second ones as seen from the first ones, as planned."""

    def __init__(
        self, problem: ir.Problem, phase: Phase, path: PhasePath, before: Configuration, expected: Mapping[str, Array]
    ) -> None:  # fmt: skip
        """`expected` are the poses `(7,)` of bodies on courses for which the end of `path` was planned."""
        self._problem = problem
        self._phase = phase
        self._before = before
        self._moving = [name for name, rows in sorted(path.modules.items()) if moves(rows)]
        self._pairs = _pairs(problem, phase)
        self._planned = self._relative(self._pairs, _last(path), expected)

    def off(self, path: PhasePath, foreseen: Mapping[str, Array]) -> float:
        """By how many metres the end of a motion misses what it is to meet, with bodies at `foreseen` poses."""
        return _most(self._errors(_last(path), foreseen)[0, :, :3])

    def steered(self, path: PhasePath, since: float, foreseen: Mapping[str, Array]) -> PhasePath | None:
        """The motion that goes on as `path` until `since`, and then meets what is at `foreseen` poses `(7,)` at its
        end; None where its joints cannot do that within their limits."""
        joints = _last(path)
        for _ in range(SIMULATION.steer_steps):
            joints = self._step(joints, foreseen)
            if _most(self._errors(joints, foreseen)) < SIMULATION.steer_met:
                break
        else:
            return None
        if not self._allowed(joints):
            return None
        result = _blended(path, since, joints)
        return result if within_limits(self._problem.world, result) else None

    def _step(self, joints: dict[str, Array], foreseen: Mapping[str, Array]) -> dict[str, Array]:
        """One damped step of Gauss-Newton on the joints that move."""
        places = [(name, k) for name in self._moving for k in range(joints[name].shape[1])]
        rows = {name: np.tile(values, (len(places) + 1, 1)) for name, values in joints.items()}
        for row, (name, k) in enumerate(places, start=1):
            rows[name][row, k] += CHANGE
        errors = self._errors(rows, foreseen).reshape(len(places) + 1, -1)
        jacobian = (errors[1:] - errors[0]).T / CHANGE
        normal = jacobian.T @ jacobian + SIMULATION.steer_damping**2 * np.eye(len(places))
        change = np.linalg.solve(normal, -jacobian.T @ errors[0])
        result = {name: values.copy() for name, values in joints.items()}
        for (name, k), value in zip(places, change, strict=True):
            result[name][0, k] += value
        types = {name: self._problem.world.modules[name].type for name in result}
        return {name: coupled(types[name].joints, values) for name, values in result.items()}

    def _allowed(self, joints: dict[str, Array]) -> bool:
        """Whether joints are within their limits, and what closes loops is still closed."""
        for name in self._moving:
            limits = np.array([(j.lower, j.upper) for j in self._problem.world.modules[name].type.joints])
            if np.any(joints[name][0] < limits[:, 0]) or np.any(joints[name][0] > limits[:, 1]):
                return False
        pairs = kept_pairs(self._problem, self._phase.mode)
        now = {m: state[None, 7:] for m, state in self._before.modules.items()}
        off = _most(_difference(self._relative(pairs, now, {}), self._relative(pairs, joints, {})))
        return off < 0.1 * SIMULATION.steer_met

    def _errors(self, joints: Mapping[str, Array], foreseen: Mapping[str, Array]) -> Array:
        """How far each pair is from where it is to be, `(T, P, 6)`: metres, and radians times LEVER."""
        return _difference(self._planned, self._relative(self._pairs, joints, foreseen))

    def _relative(
        self, pairs: tuple[tuple[str, str], ...], joints: Mapping[str, Array], bodies: Mapping[str, Array]
    ) -> Array:
        """The poses `(T, P, 7)` of the second of each pair as seen from the first, for joints `(T, n)`."""
        own = {name: pose[None, :] for name, pose in bodies.items()}
        poses = carried(self._problem, self._phase.mode, joints, self._before, own)
        count = max(len(rows) for rows in joints.values())
        found = np.zeros((count, len(pairs), 7))
        for k, (a, b) in enumerate(pairs):
            found[:, k] = compose(inverse(self._frame(a, poses, joints)), self._frame(b, poses, joints))
        return found

    def _frame(self, name: str, poses: Mapping[str, Array], joints: Mapping[str, Array]) -> Array:
        end = self._problem.world.effector(name)
        if end is None:
            return poses[name]
        module, effector = end
        return compose(poses[module.name], effector_poses(module, effector.name, joints[module.name]))


def _pairs(problem: ir.Problem, phase: Phase) -> tuple[tuple[str, str], ...]:
    """The ends and bodies that literals of the switch bring together."""
    found = set()
    for literal in phase.added:
        names = [a for a in literal[1:] if a in problem.world.bodies or problem.world.effector(a) is not None]
        found |= {(a, b) for k, a in enumerate(names) for b in names[k + 1 :]}
    return tuple(sorted((a, b) for a, b in found if carrier(problem, a) != carrier(problem, b)))


def _last(path: PhasePath) -> dict[str, Array]:
    return {name: rows[-1:, 7:].copy() for name, rows in path.modules.items()}


def _difference(planned: Array, found: Array) -> Array:
    """Translations and, for small turns, rotations times LEVER, `(…, 6)`."""
    turn = compose(inverse(planned), found)[..., 3:]
    angles = 2.0 * turn[..., :3] * np.where(turn[..., 3:] < 0.0, -1.0, 1.0)
    return np.concatenate([found[..., :3] - planned[..., :3], SIMULATION.steer_lever * angles], axis=-1)


def _most(errors: Array) -> float:
    """The greatest of some vectors `(…, d)`."""
    return float(np.linalg.norm(errors, axis=-1).max(initial=0.0))


def _blended(path: PhasePath, since: float, joints: dict[str, Array]) -> PhasePath:
    """The motion that leaves `path` after `since` seconds and ends with `joints`, as gently as it begins and ends."""
    count = max(path.samples - 1, math.ceil(path.duration / SIMULATION.brake_knot))
    times = np.linspace(0.0, path.duration, count + 1)
    dense = at_times(path, times, path.duration)
    share = least_jerk(np.clip((times - since) / (path.duration - since), 0.0, 1.0)[:, None])
    modules = {}
    for name, rows in dense.modules.items():
        values = rows[:, 7:] + share * (joints[name] - rows[-1:, 7:])
        modules[name] = np.hstack([rows[:, :7], settled(values)])
    return PhasePath(modules, dense.bodies, path.duration)
