"""Resampling of phase motions: joints by the clamped spline, poses by chaining kinematics from what stands still."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..compiler.ir import Fact, Function, Joint, Module, Object, Problem, Term, Var
from .skeleton import Configuration, PhasePath

Array = NDArray[np.float64]


# --- poses `(T, 7)` ----------------------------------------------------------------------------------------------


def product(first: Array, second: Array) -> Array:
    """Quaternion products `(T, 4)`, order x, y, z, w."""
    a, b = first[:, :3], second[:, :3]
    v, w = first[:, 3:], second[:, 3:]
    vector = v * b + w * a + np.cross(a, b)
    return np.hstack([vector, v * w - np.sum(a * b, axis=1, keepdims=True)])


def rotate(quaternions: Array, vectors: Array) -> Array:
    """Vectors `(T, 3)` turned by unit quaternions `(T, 4)`."""
    turn = 2 * np.cross(quaternions[:, :3], vectors)
    return np.asarray(vectors + quaternions[:, 3:] * turn + np.cross(quaternions[:, :3], turn))


def compose(first: Array, second: Array) -> Array:
    """Poses `second`, given relative to `first`, in the frame that `first` is given in."""
    first, second = np.broadcast_arrays(np.atleast_2d(first), np.atleast_2d(second))
    turned = product(first[:, 3:], second[:, 3:])
    turned = turned / np.linalg.norm(turned, axis=1, keepdims=True)
    return np.hstack([first[:, :3] + rotate(first[:, 3:], second[:, :3]), turned])


def inverse(poses: Array) -> Array:
    """The inverses of poses `(T, 7)`."""
    poses = np.atleast_2d(poses)
    back = poses[:, 3:] * np.array([-1.0, -1.0, -1.0, 1.0])
    return np.hstack([-rotate(back, poses[:, :3]), back])


def joint_motion(joint: Joint, values: Array) -> Array:
    """Poses `(T, 7)` of a joint's moving frame where it is placed, for its values `(T,)`."""
    axis = np.asarray(joint.axis) / np.linalg.norm(joint.axis)
    motion = np.zeros((len(values), 7))
    motion[:, 6] = 1.0
    if joint.kind == "prismatic":
        motion[:, :3] = values[:, None] * axis
    else:
        motion[:, 3:6] = np.sin(values[:, None] / 2) * axis
        motion[:, 6] = np.cos(values / 2)
    return motion


def effector_poses(module: Module, effector: str, joints: Array) -> Array:
    """Poses `(T, 7)` of an effector in its module frame for joint values `(T, n)`."""
    end = module.type.effector(effector)
    line: list[int] = []
    index = end.joint
    while index >= 0:
        line.append(index)
        index = module.type.joints[index].parent
    pose = np.zeros((len(joints), 7))
    pose[:, 6] = 1.0
    for index in reversed(line):
        joint = module.type.joints[index]
        pose = compose(compose(pose, np.asarray(joint.placement)), joint_motion(joint, joints[:, index]))
    return compose(pose, np.asarray(end.placement))


# --- what is fixed to what ---------------------------------------------------------------------------------------


def kept_pairs(problem: Problem, mode: frozenset[Fact]) -> list[tuple[str, str]]:
    """Pairs of objects whose relative pose the literals of a mode keep, in a fixed order."""
    found = []
    for literal in sorted(mode):
        predicate = problem.motions[literal[0]]
        bound = dict(zip((v.name for v in predicate.variables), literal[1:], strict=True))
        for row in predicate.rows:
            if row.when == "keep" and isinstance(row.left, Function) and row.left.name == "pose":
                names = [_object_name(a, bound) for a in row.left.args]
                if names[0] is not None and names[1] is not None:
                    found.append((names[1], names[0]))
    return found


def _object_name(term: Term, bound: Mapping[str, str]) -> str | None:
    if isinstance(term, Object):
        return term.name
    return bound.get(term.name) if isinstance(term, Var) else None


@dataclass(slots=True)
class Resampled:
    """One phase: `times` `(T,)`, per module poses `(T, 7)` and joints `(T, n)`, per moving body poses `(T, 7)`."""

    times: Array
    poses: dict[str, Array]
    joints: dict[str, Array]
    bodies: dict[str, Array]

    def end(self, start: Configuration) -> Configuration:
        """Where everything is at the end."""
        modules = {m: np.concatenate([self.poses[m][-1], self.joints[m][-1]]) for m in self.poses}
        return Configuration(modules, {**start.bodies, **{b: p[-1] for b, p in self.bodies.items()}})


def resample(
    problem: Problem, mode: frozenset[Fact], path: PhasePath, start: Configuration, begin: float, factor: int
) -> Resampled:
    """Sample one phase `factor` times as densely. Poses begin at `start` and follow the joints through whatever
    the mode holds fixed; only what nothing holds is interpolated."""
    from scipy.interpolate import CubicSpline

    count = len(next(iter(path.modules.values()), np.zeros((2, 0)))) - 1
    knots = np.linspace(0.0, path.duration, count + 1)
    times = np.linspace(0.0, path.duration, factor * count + 1)
    joints = {m: _spline(CubicSpline, knots, rows[:, 7:], times) for m, rows in path.modules.items()}
    linker = _Linker(problem, joints, start, set(path.bodies), len(times))
    linker.follow(kept_pairs(problem, mode))
    poses = {m: linker.poses.get(m) for m in path.modules}
    bodies = {b: linker.poses.get(b) for b in path.bodies}
    return Resampled(
        begin + times,
        {m: p if p is not None else _between(knots, path.modules[m][:, :7], times) for m, p in poses.items()},
        joints,
        {b: p if p is not None else _between(knots, path.bodies[b], times) for b, p in bodies.items()},
    )


def _spline(kind: type, knots: Array, values: Array, times: Array) -> Array:
    if values.shape[1] == 0:
        return np.zeros((len(times), 0))
    return np.asarray(kind(knots, values, bc_type="clamped")(times))


def _between(knots: Array, poses: Array, times: Array) -> Array:
    """Positions linear, quaternions linear and normalised, between samples of what nothing holds."""
    signs = np.cumprod(np.where(np.sum(poses[1:, 3:] * poses[:-1, 3:], axis=1) < 0, -1.0, 1.0))
    rows = poses.copy()
    rows[1:, 3:] *= signs[:, None]
    result = np.column_stack([np.interp(times, knots, column) for column in rows.T])
    result[:, 3:] /= np.linalg.norm(result[:, 3:], axis=1, keepdims=True)
    return result


class _Linker:
    """Finds the poses of everything that is linked, through kept poses, to something at rest."""

    def __init__(
        self, problem: Problem, joints: Mapping[str, Array], start: Configuration, moving: set[str], count: int
    ) -> None:
        self._problem = problem
        self._joints = joints
        self._start = start
        self._count = count
        self.poses: dict[str, Array] = {
            b: pose[None, :] for b, pose in start.bodies.items() if b not in moving
        }

    def follow(self, pairs: Sequence[tuple[str, str]]) -> None:
        """Take each pair of which one side is known, and find the other side's thing, until nothing is new."""
        progress = True
        while progress:
            progress = False
            for pair in pairs:
                for known, other in (pair, pair[::-1]):
                    if self._thing(known) in self.poses and self._thing(other) not in self.poses:
                        self._attach(known, other)
                        progress = True

    def _thing(self, name: str) -> str:
        end = self._problem.world.effector(name)
        return name if end is None else end[0].name

    def _local(self, name: str, joints: Array) -> Array:
        end = self._problem.world.effector(name)
        if end is None:
            return np.array([[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]])
        return effector_poses(end[0], end[1].name, joints)

    def _at_start(self, name: str) -> Array:
        thing = self._thing(name)
        if thing in self._start.bodies:
            return self._start.bodies[thing][None, :]
        row = self._start.modules[thing]
        return compose(row[None, :7], self._local(name, row[None, 7:]))

    def _attach(self, known: str, other: str) -> None:
        relative = compose(inverse(self._at_start(known)), self._at_start(other))
        thing, base = self._thing(other), self._thing(known)
        carrier = self.poses[base]
        if base in self._joints:
            carrier = compose(carrier, self._local(known, self._joints[base]))
        held = compose(carrier, relative)
        if thing in self._joints:
            held = compose(held, inverse(self._local(other, self._joints[thing])))
        self.poses[thing] = np.broadcast_to(held, (self._count, 7)).copy()
