"""Whether joints that follow others do so, at all times and not only at samples."""

from __future__ import annotations

import numpy as np

from ...compiler.ir import JointKind
from ..plan import ModuleRecord, Plan
from .findings import Findings
from .geometry import Array
from .kinematics import Motion
from .splines import Spline


def check_couplings(plan: Plan, motion: Motion, findings: Findings) -> None:
    """Measure every joint against its multiple of the leader: on the stored samples, and exactly on the splines, as
    the difference of clamped splines over the same knots is one too."""
    modules = {m.name: m for m in plan.modules if any(j.follows is not None for j in m.joints)}
    for module in modules.values():
        off = _off(module, motion.joints[module.name])
        _measure(module, off, np.broadcast_to(motion.times[:, None], off.shape), findings)
    for spline in plan.splines:
        if spline.module in modules:
            rows = _off(modules[spline.module], np.asarray(spline.values))
            times, off = Spline(np.asarray(spline.knots), rows).extrema()
            _measure(modules[spline.module], off, times, findings)


def _off(module: ModuleRecord, rows: Array) -> Array:
    """How far the followers are from where joint values `(T, n)` put their leaders, `(T, followers)`."""
    return np.column_stack([
        rows[:, index] - joint.follows.factor * rows[:, joint.follows.leader] - joint.follows.offset
        for index, joint in enumerate(module.joints) if joint.follows is not None
    ])  # fmt: skip


def _measure(module: ModuleRecord, off: Array, times: Array, findings: Findings) -> None:
    for column, joint in enumerate(j for j in module.joints if j.follows is not None):
        assert joint.follows is not None
        at = int(np.argmax(np.abs(off[:, column])))
        kind = "coupling_m" if joint.kind == JointKind.PRISMATIC else "coupling_rad"
        leader = module.joints[joint.follows.leader].name
        message = f"joint {joint.name} of {module.name} does not follow {leader}"
        findings.measure(
            kind, float(np.abs(off[at, column])), message, time=float(times[at, column]),
            between=[module.name, joint.name, leader],
        )  # fmt: skip
