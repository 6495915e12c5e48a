"""Joint motion as `trajectory_msgs/JointTrajectory` of ROS 2, one message per module and phase, in YAML.

Within the rules of the ROS 2 joint trajectory controller: times from the start of the phase, above 0 and strictly
increasing, the same joints in each point, and no rate at the end.
"""

from __future__ import annotations

import json
from collections.abc import Iterator

import numpy as np

from ..plan import Plan
from .motion import Array, times, trajectory


def trajectories(plan: Plan, rate: float | None) -> bytes:
    """YAML documents, each with `phase`, `action`, `module`, `start` (seconds) and `trajectory`, the message."""
    return "".join(_documents(plan, rate)).encode()


def _documents(plan: Plan, rate: float | None) -> Iterator[str]:
    stamps = times(plan, rate)
    for index, phase in enumerate(plan.phases):
        inside = stamps[(stamps > phase.start + 1e-9) & (stamps < phase.end - 1e-9)]
        at = np.append(inside, phase.end)
        for module in plan.modules:
            splines = [s for s in plan.splines if s.module == module.name and s.first <= index <= s.until]
            if not splines or not module.joints:
                continue
            motion = trajectory(plan, module.name, at)
            names = json.dumps([f"{module.name}.{j}" for j in motion.joints])
            lines = [f"---\nphase: {index}\naction: {json.dumps(phase.action)}\nmodule: {json.dumps(module.name)}"]
            lines.append(f"start: {phase.start!r}\ntrajectory:\n  header: {{frame_id: ''}}")
            lines.append(f"  joint_names: {names}\n  points:")
            last = splines[-1].until == index
            for k, time in enumerate(at):
                still = last and k == len(at) - 1
                dq = np.zeros_like(motion.dq[k]) if still else motion.dq[k]
                lines.append(_point(float(time - phase.start), motion.q[k], dq, motion.ddq[k]))
            yield "\n".join(lines) + "\n"


def _point(time: float, q: Array, dq: Array, ddq: Array) -> str:
    seconds, nanoseconds = divmod(round(time * 1e9), 1_000_000_000)
    rows = ("positions", q), ("velocities", dq), ("accelerations", ddq)
    told = ", ".join(f"{name}: {json.dumps(values.tolist())}" for name, values in rows)
    return f"  - {{{told}, time_from_start: {{sec: {seconds}, nanosec: {nanoseconds}}}}}"
