"""The motion of a plan as arrays: joints from the splines, poses from the samples."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ...compiler.ir import JointKind
from ...langs.diagnostics import UsageError, did_you_mean
from ...langs.frozen import dataclass
from ..plan import ModuleRecord, Plan

Array = NDArray[np.float64]
LONGEST = 10_000_000
"""Samples of an export: days of motion at a rate of 100 Hz."""


@dataclass(frozen=True, slots=True)
class Trajectory:
    """Joint motion of one module: `joints` by name, times `t` (T,) in seconds, strictly increasing, and for each time
    values `q`, rates `dq` and accelerations `ddq`, all (T, joints), in rad or m and seconds."""

    joints: tuple[str, ...]
    t: Array
    q: Array
    dq: Array
    ddq: Array

    def __repr__(self) -> str:
        return f"<Trajectory of {', '.join(self.joints) or 'no joint'}: {len(self.t)} samples, {self.t[-1]:.2f} s>"


def times(plan: Plan, rate: float | None = None) -> Array:
    """Strictly increasing times: those of the samples of the plan, or so many a second, the end included."""
    own = np.array(plan.times)
    if rate is None:
        return own[_first_of_each(own)]
    if isinstance(rate, bool | str) or not isinstance(rate, int | float | np.number) or not 0.0 < rate < math.inf:
        raise UsageError(f"a rate is a number of hertz above 0, not {rate!r}")
    end = float(own[-1])
    if end * rate > LONGEST:
        raise UsageError(f"{rate:g} samples a second are more than {LONGEST} in all")
    made = np.arange(math.floor(end * rate + 1e-9) + 1) / rate
    return made if end - made[-1] < 1e-9 else np.append(made, end)


def trajectory(plan: Plan, name: str, at: Array | None = None) -> Trajectory:
    """The joint motion of the module called `name` at times `at` (None: those of the samples). Raises UsageError when
    there is no such module."""
    from scipy.interpolate import CubicSpline

    module = module_of(plan, name)
    t = times(plan) if at is None else at
    shape = len(t), len(module.joints)
    q, dq, ddq = (np.zeros(shape) for _ in range(3))
    q[:] = module.start
    for spline in (s for s in plan.splines if s.module == name):
        knots, values = np.array(spline.knots), np.array(spline.values).reshape(len(spline.knots), shape[1])
        inside = (t >= knots[0]) & (t <= knots[-1])
        if inside.any():
            curve = CubicSpline(knots, values, bc_type="clamped")
            q[inside], dq[inside], ddq[inside] = (curve(t[inside], nu) for nu in range(3))
        q[t > knots[-1]], dq[t > knots[-1]], ddq[t > knots[-1]] = values[-1], 0.0, 0.0
    return Trajectory(tuple(j.name for j in module.joints), t, q, dq, ddq)


def torques(plan: Plan, name: str, at: Array) -> Array | None:
    """What the drives of a module give, N m (N), at times `at` (T, joints), zero where the plan tells none; None where
    it tells of no forces at all."""
    import msgspec

    if isinstance(plan.statics, msgspec.UnsetType):
        return None
    found = np.zeros((len(at), len(module_of(plan, name).joints)))
    for record in (t for t in plan.statics.torques if t.module == name and t.phase < len(plan.phases)):
        phase, rows = plan.phases[record.phase], np.asarray(record.values)
        own = np.linspace(phase.start, phase.end, len(rows))
        inside = (at >= phase.start) & (at <= phase.end)
        found[inside] = np.stack([np.interp(at[inside], own, column) for column in rows.T], axis=1)
    return found


def poses(plan: Plan, name: str, at: Array | None = None) -> Array:
    """Poses (T, 7) in the world, x, y, z, qx, qy, qz, qw, of a module, a body or an effector such as "c[1].A", at times
    `at` (None: those of the samples); between samples they are interpolated. Raises UsageError for an unknown name."""
    t = times(plan) if at is None else at
    module, _, end = name.rpartition(".")
    record = next((m for m in plan.modules if m.name == module), None)
    if record is not None and any(e.name == end for e in record.effectors):
        return _effector_poses(plan, record, end, t)
    given = _samples(plan, name)
    if given is None:
        known = [*(m.name for m in plan.modules), *(b.name for b in plan.bodies)]
        known += [f"{m.name}.{e.name}" for m in plan.modules for e in m.effectors]
        raise UsageError(f"the plan has no `{name}`", help=did_you_mean(name, known))
    return _interpolated(np.array(plan.times), given, t)


def module_of(plan: Plan, name: str) -> ModuleRecord:
    """The module called `name`. Raises UsageError."""
    found = next((m for m in plan.modules if m.name == name), None)
    if found is None:
        known = [m.name for m in plan.modules]
        listing = "it has " + ", ".join(f"`{n}`" for n in known[:8]) if known else "it has none"
        raise UsageError(f"the plan has no module `{name}`", help=did_you_mean(str(name), known) or listing)
    return found


def moved(plan: Plan) -> list[str]:
    """The bodies that move, by name."""
    return list(dict.fromkeys(t.name for t in plan.body_tracks))


def _first_of_each(t: Array) -> NDArray[np.bool_]:
    """Which time stamps are no repetitions of those before them."""
    return np.concatenate([[True], np.diff(t) > 0])


def _samples(plan: Plan, name: str) -> Array | None:
    """Poses of a module or body at every sample."""
    track = next((t for t in plan.tracks if t.name == name), None)
    if track is not None:
        return np.array(track.poses)
    body = next((b for b in plan.bodies if b.name == name), None)
    if body is None:
        return None
    made = np.tile(np.array(body.pose, dtype=float), (len(plan.times), 1))
    for piece in (t for t in plan.body_tracks if t.name == name):
        end = piece.first + len(piece.poses)
        made[piece.first : end] = piece.poses
        made[end:] = piece.poses[-1]
    return made


def _interpolated(stamps: Array, given: Array, t: Array) -> Array:
    """Positions on straight lines, rotations by the shorter way, between samples."""
    kept = _first_of_each(stamps)
    stamps, given = stamps[kept], given[kept].copy()
    apart = np.sum(given[1:, 3:] * given[:-1, 3:], axis=1) < 0
    given[1:, 3:] *= np.cumprod(np.where(apart, -1.0, 1.0))[:, None]
    made = np.column_stack([np.interp(t, stamps, column) for column in given.T])
    made[:, 3:] /= np.linalg.norm(made[:, 3:], axis=1, keepdims=True)
    return made


def _effector_poses(plan: Plan, module: ModuleRecord, end: str, t: Array) -> Array:
    from ...compiler.poses import compose

    effector = next(e for e in module.effectors if e.name == end)
    place = pose_of(effector.placement)
    base, q = poses(plan, module.name, t), trajectory(plan, module.name, t).q
    carriers = [frames_of(module, pose_of(b), row)[effector.joint] for b, row in zip(base, q, strict=True)]
    return np.array([compose(carrier, place) for carrier in carriers])


def frames_of(module: ModuleRecord, base: Pose, values: Array) -> dict[int, Pose]:
    """The moving frames of the joints, by index, and -1 for the module frame at `base`."""
    from ...compiler.poses import about, compose, make, unit

    found = {-1: base}
    for index, (joint, value) in enumerate(zip(module.joints, map(float, values), strict=True)):
        x, y, z = unit(joint.axis) or (0.0, 0.0, 1.0)
        turns = joint.kind == JointKind.REVOLUTE
        shift, turn = (x * value, y * value, z * value), (0.0, 0.0, 0.0, 1.0)
        motion = make((0.0, 0.0, 0.0), about((x, y, z), value)) if turns else make(shift, turn)
        found[index] = compose(compose(found[joint.parent], pose_of(joint.placement)), motion)
    return found


Pose = tuple[float, float, float, float, float, float, float]


def pose_of(values: object) -> Pose:
    """Seven numbers as a pose."""
    x, y, z, qx, qy, qz, qw = (float(v) for v in np.asarray(values, dtype=float))
    return x, y, z, qx, qy, qz, qw


