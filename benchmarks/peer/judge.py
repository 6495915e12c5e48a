"""Judges the motions of both sides alike, with kinematics of its own in numpy.

A motion is `crawler` (T + 1, 14): pose of the crawler's frame at its end A (x, y, z, qx, qy, qz, qw) and seven joint
values; and `items` (T + 1, n, 7). Row 0 is the start; with S slices per phase, row k S is the k-th switch.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from . import cases
from .cases import Case

Array = NDArray[np.float64]
ALLOWED = {
    "switch_m": 2e-3, "upright_rad": 5e-3, "slip_m": 1e-3, "slip_rad": 2e-3, "limit_rad": 1e-3, "penetration_m": 1e-3,
}  # fmt: skip
"""What the verifier of tamplang allows, by kind."""
FINER = 10
ALONG = 12
"""Points on the axis of each link."""
SEQUENCE_VELOCITY, SEQUENCE_HOMING = 0.3, 0.1
PATH_ACCELERATION, PATH_HOMING = 0.1, 0.2


def joint_frames(crawler: Array) -> tuple[Array, Rotation]:
    """Positions (T, 8, 3) of the end A and the seven joints, and the orientations (T,) of the end B."""
    turn = Rotation.from_quat(crawler[:, 3:7])
    at = crawler[:, :3]
    positions, last = [at], 0.0
    for column, (height, axis) in enumerate(zip(cases.JOINT_HEIGHTS, cases.AXES, strict=True)):
        at = at + turn.apply([0.0, 0.0, height - last])
        last = height
        positions.append(at)
        turn = turn * Rotation.from_euler(axis, crawler[:, [7 + column]])
    return np.stack(positions, axis=1), turn


def foot(crawler: Array, end: str) -> tuple[Array, Rotation]:
    """Position (T, 3) and orientation (T,) of the end "A" or "B"."""
    if end == "A":
        return crawler[:, :3], Rotation.from_quat(crawler[:, 3:7])
    positions, turn = joint_frames(crawler)
    return positions[:, -1], turn


def _beyond(value: Array, half: float) -> Array:
    return np.maximum(np.abs(value) - half, 0.0)


def _slip(position: Array, turn: Rotation) -> tuple[float, float]:
    moved = float(np.linalg.norm(position - position[0], axis=-1).max())
    return moved, float((turn[0].inv() * turn).magnitude().max())


def _limits(crawler: Array) -> float:
    return float(max(0.0, (np.abs(crawler[:, 7:]) - np.array(cases.LIMITS)).max()))


def _climb(case: Case, crawler: Array, slices: int) -> dict[str, float]:
    switch, slips = 0.0, [(0.0, 0.0)]
    for k in range(case.size):
        part = crawler[k * slices : (k + 1) * slices + 1]
        stance, landing = ("A", "B") if k % 2 == 0 else ("B", "A")
        slips.append(_slip(*foot(part, stance)))
        at = foot(part[-1:], landing)[0][0] - case.places[k + 1]
        switch = max(
            switch,
            abs(float(at[2]) - cases.STAIR[2] / 2 - cases.FOOT),
            float(_beyond(at[0], cases.STAIR[0] / 2 - cases.INSET)),
            float(_beyond(at[1], cases.STAIR[1] / 2 - cases.INSET)),
        )
    moved, turned = (max(values) for values in zip(*slips, strict=True))
    return {"switch_m": switch, "slip_m": moved, "slip_rad": turned}


def _pick(case: Case, crawler: Array, items: Array, slices: int) -> dict[str, float]:
    moved, turned = _slip(*foot(crawler, "A"))
    grip, grip_turn = foot(crawler, "B")
    switch = upright = 0.0
    for i in range(case.size):
        pose = items[:, i]
        taken, put = (2 * i + 1) * slices, (2 * i + 2) * slices
        at, turn = pose[:, :3], Rotation.from_quat(pose[:, 3:])
        local = turn[taken].inv().apply(grip[taken] - at[taken])
        outside = np.linalg.norm(np.maximum(np.abs(local) - cases.ITEM / 2, 0.0))
        inside = min(0.0, float((np.abs(local) - cases.ITEM / 2).max()))
        on_tray = at[put] - cases.TRAY_AT
        switch = max(
            switch,
            abs(float(outside) + inside - cases.FOOT),
            abs(float(on_tray[2]) - cases.TRAY[2] / 2 - cases.ITEM / 2),
            float(_beyond(on_tray[0], cases.TRAY[0] / 2 - cases.TRAY_INSET)),
            float(_beyond(on_tray[1], cases.TRAY[1] / 2 - cases.TRAY_INSET)),
        )
        upright = max(upright, float(np.arccos(np.clip(turn[put].apply([0.0, 0.0, 1.0])[2], -1.0, 1.0))))
        held = slice(taken, put + 1)
        carried = grip_turn[held].inv()
        found = [
            _slip(at[: taken + 1], turn[: taken + 1]),
            _slip(carried.apply(at[held] - grip[held]), carried * turn[held]),
            _slip(at[put:], turn[put:]),
        ]
        moved, turned = max(moved, *(f[0] for f in found)), max(turned, *(f[1] for f in found))
    return {"switch_m": switch, "upright_rad": upright, "slip_m": moved, "slip_rad": turned}


def _swept(part: Array, stance: str) -> Array:
    """One phase, FINER times as dense: joints on a clamped spline, the pose from the foot that stands."""
    count = len(part) - 1
    fine = np.linspace(0, count, FINER * count + 1)
    dense = np.zeros((len(fine), 14))
    dense[:, 6] = 1.0
    dense[:, 7:] = CubicSpline(np.arange(count + 1), part[:, 7:], bc_type="clamped")(fine)
    fixed_at, fixed_turn = foot(part[:1], stance)
    at, turn = foot(dense, stance)
    base = fixed_turn[0] * turn.inv()
    dense[:, :3] = fixed_at[0] - base.apply(at)
    dense[:, 3:7] = base.as_quat()
    return dense


def _penetration(case: Case, crawler: Array, slices: int) -> float:
    """How deep any link or foot is in a stair or in another link, at most; negative when all are apart."""
    deepest = -np.inf
    share = np.linspace(0.0, 1.0, ALONG)[:, None]
    half = np.array(cases.STAIR) / 2
    for k in range(case.size):
        dense = _swept(crawler[k * slices : (k + 1) * slices + 1], "A" if k % 2 == 0 else "B")
        positions = joint_frames(dense)[0][:, 1:]
        links = positions[:, :-1, None] * (1.0 - share) + positions[:, 1:, None] * share
        feet = positions[:, [0, -1]]
        for place in case.places:
            for points, radius in ((links.reshape(-1, 3), cases.LINK_RADIUS), (feet.reshape(-1, 3), cases.FOOT)):
                away = np.abs(points - place) - half
                gap = np.linalg.norm(np.maximum(away, 0.0), axis=1) + np.minimum(away.max(axis=1), 0.0)
                deepest = max(deepest, radius - float(gap.min()))
        for i in range(6):
            for j in range(i + 2, 6):
                apart = np.linalg.norm(links[:, i, :, None] - links[:, j, None], axis=-1).min()
                deepest = max(deepest, 2 * cases.LINK_RADIUS - float(apart))
    return deepest


def judge(
    case: Case, crawler: Array, items: Array | None, slices: int, collisions: bool
) -> tuple[bool, dict[str, float]]:
    """Whether the motion keeps to what ALLOWED says, and its worst figures by kind."""
    if not np.isfinite(crawler).all():
        return False, {}
    if case.kind == "climb":
        worst = _climb(case, crawler, slices)
    else:
        assert items is not None
        worst = _pick(case, crawler, items, slices)
    worst["limit_rad"] = _limits(crawler)
    if collisions and case.kind == "climb":
        worst["penetration_m"] = _penetration(case, crawler, slices)
    return all(value <= ALLOWED[kind] for kind, value in worst.items()), worst


def cost(crawler: Array, phases: int, slices: int) -> float:
    """The cost that both sides minimise: squared joint accelerations, at rest at every switch, and homing; with one
    slice per phase, squared joint steps and homing."""
    joints, home = crawler[:, 7:], np.array(cases.HOME)
    if slices == 1:
        steps = SEQUENCE_VELOCITY * np.diff(joints, axis=0)
        return float(0.5 * np.square(steps).sum() + 0.5 * np.square(SEQUENCE_HOMING * (joints[1:] - home)).sum())
    span, total = 1.0 / slices, 0.0
    for k in range(phases):
        part = joints[k * slices : (k + 1) * slices + 1]
        padded = np.vstack([part[:1], part, part[-1:]])
        accelerations = PATH_ACCELERATION * span**-1.5 * np.diff(padded, n=2, axis=0)
        away = PATH_HOMING * span**0.5 * (part[1:] - home)
        total += 0.5 * float(np.square(accelerations).sum() + np.square(away).sum())
    return total


def nearest_miss(case: Case, starts: int = 64, iterations: int = 60, inset: float = 1e-9) -> float:
    """By how much the single step of `case` misses at best, metres: damped least squares from many starts at once, the
    standing foot fixed and the joint limits pulled in by `inset`. Below 1e-6 the step can be made."""
    random = np.random.default_rng(case.seed)
    place, limits = np.array(case.places[1]), np.array(cases.LIMITS) - inset
    half = np.array(cases.STAIR) / 2
    sides = half[:2] - cases.INSET

    def residual(joints: Array) -> Array:
        rows = np.zeros((len(joints), 14))
        rows[:, 2], rows[:, 6], rows[:, 7:] = half[2] + cases.FOOT, 1.0, joints
        at = joint_frames(rows)[0][:, -1] - place
        aside = np.sign(at[:, :2]) * np.maximum(np.abs(at[:, :2]) - sides, 0.0)
        return np.column_stack([aside, at[:, 2] - half[2] - cases.FOOT])

    joints = np.clip(random.normal(0.0, 0.8, (starts, 7)), -limits, limits)
    joints[:, 0] = np.arctan2(place[1], place[0]) * 0.98
    least = np.inf
    for _ in range(iterations):
        now = residual(joints)
        least = min(least, float(np.abs(now).max(axis=1).min()))
        if least < 1e-7:
            break
        moved = [(residual(joints + 1e-6 * unit) - now) / 1e-6 for unit in np.eye(7)]
        slope = np.stack(moved, axis=2)
        normal = slope.transpose(0, 2, 1) @ slope + 1e-4 * np.eye(7)
        step = np.linalg.solve(normal, -(slope.transpose(0, 2, 1) @ now[:, :, None]))[:, :, 0]
        joints = np.clip(joints + np.clip(step, -0.3, 0.3), -limits, limits)
    return least
