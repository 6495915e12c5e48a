"""Frames as matrices (…, 4, 4), splines and kinematics of a plan file. Metres, radians, world frame."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline, PPoly
from scipy.spatial.transform import Rotation

Matrix = NDArray[np.float64]


def frames_of(poses: Any) -> Matrix:
    """Poses `[x, y, z, qx, qy, qz, qw]`, one or a list, as matrices."""
    rows = np.asarray(poses, dtype=float)
    found = np.zeros((*rows.shape[:-1], 4, 4))
    found[..., :3, :3] = Rotation.from_quat(rows[..., 3:].reshape(-1, 4)).as_matrix().reshape(*rows.shape[:-1], 3, 3)
    found[..., :3, 3], found[..., 3, 3] = rows[..., :3], 1.0
    return found


def inverse(frames: Matrix) -> Matrix:
    found = np.zeros_like(frames)
    turned = np.swapaxes(frames[..., :3, :3], -1, -2)
    found[..., :3, :3], found[..., 3, 3] = turned, 1.0
    found[..., :3, 3] = -np.einsum("...ij,...j->...i", turned, frames[..., :3, 3])
    return found


def apart(one: Matrix, other: Matrix) -> tuple[Matrix, Matrix]:
    """Distance of origins and angle between two stacks of frames."""
    shift = np.linalg.norm(one[..., :3, 3] - other[..., :3, 3], axis=-1)
    chord = np.linalg.norm(one[..., :3, :3] - other[..., :3, :3], axis=(-2, -1)) / np.sqrt(8.0)
    return shift, 2 * np.arcsin(np.clip(chord, 0.0, 1.0))


class Chain:
    """The kinematics of one module record: frames of joints from joint values and the module frame."""

    def __init__(self, record: dict[str, Any]) -> None:
        self.record = record
        self.joints = record["joints"]
        self.placed = [frames_of(j["placement"]) for j in self.joints]
        self.ends = {e["name"]: (e["joint"], frames_of(e["placement"])) for e in record["effectors"]}

    def frames(self, joints: Matrix) -> list[Matrix]:
        """The moving frame of every joint in the module frame, (T, 4, 4) each; the last entry, -1, is the module's."""
        count = len(joints)
        found: list[Matrix] = []
        still = np.broadcast_to(np.eye(4), (count, 4, 4))
        for number, joint in enumerate(self.joints):
            if not -1 <= joint["parent"] < number:
                raise ValueError("a joint comes before its parent")
            base = still if joint["parent"] < 0 else found[joint["parent"]]
            axis, moved = _unit(joint["axis"]), np.zeros((count, 4, 4))
            moved[:, 3, 3] = 1.0
            if joint["kind"] == "revolute":
                moved[:, :3, :3] = Rotation.from_rotvec(joints[:, number, None] * axis).as_matrix()
            elif joint["kind"] == "prismatic":
                moved[:, :3, :3] = np.eye(3)
                moved[:, :3, 3] = joints[:, number, None] * axis
            else:
                raise ValueError(f"no kind of joint: {joint['kind']}")
            found.append(base @ self.placed[number] @ moved)
        return [*found, still]

    def end(self, name: str, frames: Sequence[Matrix]) -> Matrix:
        """An effector in the module frame."""
        joint, placed = self.ends[name]
        return np.asarray(frames[joint] @ placed)


def _unit(axis: Any) -> Matrix:
    found: Matrix = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    return found


class Spline:
    """The joint motion of one module in a stretch of time."""

    def __init__(self, knots: Sequence[float], values: Sequence[Sequence[float]]) -> None:
        self.knots = np.asarray(knots, dtype=float)
        rows = np.asarray(values, dtype=float)
        self.rows = rows.reshape(len(self.knots), -1)
        steps = np.diff(self.knots)
        if len(self.knots) < 2 or (steps <= 0).any() or np.abs(steps - steps.mean()).max() > 1e-6:
            raise ValueError("the knots of a spline are not equidistant")
        self.curve = CubicSpline(self.knots, self.rows, bc_type="clamped")

    def __call__(self, times: Matrix, order: int = 0) -> Matrix:
        found: Matrix = self.curve(np.clip(times, self.knots[0], self.knots[-1]), order)
        return found

    def extremes(self, order: int) -> tuple[Matrix, Matrix]:
        """Least and largest value of the motion or one of its derivatives, over all times, per joint."""
        curve = self.curve.derivative(order) if order else self.curve
        low, high = curve(self.knots).min(axis=0), curve(self.knots).max(axis=0)
        for joint in range(self.rows.shape[1]):
            one = PPoly(np.ascontiguousarray(curve.c[:, :, joint]), curve.x)
            if len(one.c) < 2:
                continue
            turns = one.derivative().roots(extrapolate=False)
            turns = turns[np.isfinite(turns)]
            if len(turns):
                values = one(turns)
                low[joint], high[joint] = min(low[joint], values.min()), max(high[joint], values.max())
        return low, high
