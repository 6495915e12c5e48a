"""Whether the stored samples are a drawing of the motion: at every one of them, everything is where joints and holds
put it."""

from __future__ import annotations

import numpy as np

from .findings import Findings
from .geometry import Frames, angles
from .kinematics import Motion
from .limits import LIMITS
from .links import Hold, Links
from .sampler import Sampler


def check_samples(motion: Motion, sampler: Sampler, findings: Findings) -> None:
    """Measure joints against splines, kept frames against those that keep them, and what must rest."""
    for phase, links in enumerate(sampler.links):
        moving = (links.fixed[name] for name in sorted(motion.moving) if name in links.fixed)
        for hold in (*moving, *links.holds.values()):
            _check_hold(motion, phase, hold, findings)
        _check_rest(motion, sampler, phase, links, findings)
        for name, kinematics in sampler.kinematics.items():
            if kinematics.module.joints:
                _check_joints(motion, sampler, phase, name, findings)


def _check_joints(motion: Motion, sampler: Sampler, phase: int, name: str, findings: Findings) -> None:
    """Stored joint values lie on the spline, or rest where there is none."""
    first, last = motion.ranges[phase]
    rows, curve = motion.joints[name][first : last + 1], sampler.curves.get((name, phase))
    off = np.abs(rows - (rows[0] if curve is None else curve(motion.times[first : last + 1])))
    at, joint = np.unravel_index(int(np.argmax(off)), off.shape)
    named = sampler.kinematics[name].module.joints[int(joint)].name
    message = f"joint {named} of {name} " + ("moves without a spline" if curve is None else "leaves its spline")
    findings.measure(
        "spline_rad", float(off[at, joint]), message, time=float(motion.times[first + at]), between=[name]
    )


def _check_hold(motion: Motion, phase: int, hold: Hold, findings: Findings) -> None:
    """A frame keeps, on the samples of a phase, the pose that it had on the first of them."""
    first, last = motion.ranges[phase]
    if all(motion.rests(name, first, last) for name in (hold.own, hold.base) if name):
        return
    own = motion.frames[hold.own][first : last + 1]
    if hold.base:
        own = own.relative_to(motion.frames[hold.base][first : last + 1])
    shift = np.linalg.norm(own.position - hold.relative.position, axis=1)
    turn = angles(own.rotation, hold.relative.rotation)
    names = [hold.base, hold.own] if hold.base else [hold.own]
    for kind, amounts in (("sample_m", shift), ("sample_rad", turn)):
        at = int(np.argmax(amounts))
        message = f"a sample of {hold.thing} is not where {hold.base or 'what rests'} puts it"
        findings.measure(kind, float(amounts[at]), message, time=float(motion.times[first + at]), between=names)


def _check_rest(motion: Motion, sampler: Sampler, phase: int, links: Links, findings: Findings) -> None:
    """Among things whose relative poses are kept, but which nothing holds to a fixed body, one frame rests."""
    first, _ = motion.ranges[phase]
    time = float(motion.times[first])
    for rest in links.rests:
        if not any(name in motion.moving for name in rest.group):
            continue
        message = f"{', '.join(rest.group)} moves though nothing holds it"
        if findings.measure("rest_m", rest.shift, message, time=time, between=rest.group):
            findings.measure("rest_rad", rest.turn, message, time=time, between=[rest.name])
        _check_others(sampler, phase, rest.name, rest.others, time, findings)


def _check_others(
    sampler: Sampler, phase: int, name: str, others: tuple[str, ...], time: float, findings: Findings
) -> None:
    """Where several frames rest on the samples, the samples say which of them does only if all of them do."""
    moved = [n for n in others if not sampler.rests(sampler.mount(n)[0], phase)]
    if not moved:
        return
    starts: dict[str, Frames] = {}
    for grid in sampler.grid(phase).parts():
        findings.check_time()
        placement = sampler.at(phase, grid.times)
        for other in moved:
            frame = placement.frame(other)
            start = starts.setdefault(other, frame[:1])
            off = float(np.max(np.linalg.norm(frame.position - start.position, axis=1)))
            off = max(off, float(np.max(angles(frame.rotation, start.rotation))))
            if off > LIMITS["rest_m"]:
                message = f"the samples do not tell whether {name} or {other} rests"
                findings.fail("rest", message, amount=off, unit="m", time=time, between=[name, other])
                return
