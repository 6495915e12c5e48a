"""What the motion of a plan must keep: limits, rest, rows of motion literals, and that nothing runs into anything."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

from tamplang.compiler import ir

from .forces import overloads, total
from .frames import apart, frames_of, inverse
from .motion import Keep, Moving, Recording, moving
from .rows import View, excess, functions, is_length, value
from .touch import Part, neighbours, overlaps, parts_of

Wrong = tuple[str, str, float, float]
SLIP, TURN = 1e-3, 2e-3


def watch(problem: ir.Problem, plan: dict[str, Any], recording: Recording) -> Iterator[Wrong]:
    yield from _structure(plan, recording)
    yield from _bound(problem, plan, recording)
    keeps: dict[tuple[str, ...], list[Keep]] = {}
    others: dict[tuple[str, ...], Any] = {}
    leaving: set[str] = set()
    skipped = {(n, *pair) for n, c in recording.chains.items() for pair in neighbours(c)}
    for number, phase in enumerate(plan["phases"]):
        gone = {b["module"] for b in plan["breakdowns"] if b["kind"] == "gone" and b["time"] < phase["end"] - 1e-9}
        mode = [(m["predicate"], *m["args"]) for m in phase["mode"]]
        fresh = {(m["predicate"], *m["args"]) for m in plan["phases"][number - 1]["added"]} if number else set()
        stored = recording.stored(recording.ranges[number][0])
        keeps = {f: keeps[f] if f in keeps and f not in fresh else keeps_of(problem, f, stored) for f in mode}
        held = [k for some in keeps.values() for k in some]
        leaving |= {k.follower for k in held if k.follower in recording.bodies and k.leader not in recording.bodies}
        motion = moving(recording, number, held, leaving, gone)
        where = f"phase {number}"
        yield from _samples(recording, number, motion, gone, where)
        yield from _joints(recording, plan, number, motion, gone)
        yield from _kept(motion, held, where)
        yield from overloads(problem, plan, number, motion, held, mode)
        view = View(motion.frame, recording.solid, partial(_weight, problem, motion))
        others = yield from _held_rows(problem, mode, fresh, others, view, motion, where)
        parts = list(_parts(recording, motion, gone))
        for at, pair, depth in overlaps(parts, skipped, 1e-3):
            yield "penetration_m", f"{pair} at {motion.times[at]:.3f} s", depth, 1e-3
        if phase.get("completed", True):
            yield from _switch(problem, recording, number, phase)


def _structure(plan: dict[str, Any], recording: Recording) -> Iterator[Wrong]:
    """Stamps, quaternions, the start, and the two samples at every switch."""
    times = recording.times
    before = 0.0
    for number, (phase, (first, last)) in enumerate(zip(plan["phases"], recording.ranges, strict=True)):
        off = max(abs(phase["start"] - before), abs(times[first] - phase["start"]), abs(times[last] - phase["end"]))
        before = phase["end"]
        if off > 1e-9 or phase["end"] <= phase["start"] or (np.diff(times[first : last + 1]) <= 0).any():
            yield "times", f"the stamps of phase {number} do not fit", math.inf, 0.0
        if number and first:
            for name, joints in recording.joints.items():
                if joints.size and np.abs(joints[first] - joints[first - 1]).max() > 1e-5:
                    yield "jump_rad", f"{name} jumps before phase {number}", math.inf, 1e-5
            for name, frames in {**recording.bases, **recording.body_frames}.items():
                if max(map(float, apart(frames[first], frames[first - 1]))) > 1.1e-5:
                    yield "jump_m", f"{name} jumps before phase {number}", math.inf, 1e-5
    rows = [p for t in [*plan["tracks"], *plan["body_tracks"]] for p in t["poses"]]
    rows += [x["pose"] for x in [*plan["modules"], *plan["bodies"]]]
    if rows and np.abs(np.linalg.norm(np.asarray(rows, dtype=float)[:, 3:], axis=1) - 1).max() > 1e-6:
        yield "quaternion", "a quaternion is not of length 1", math.inf, 1e-6
    for name, record in recording.modules.items():
        shift = max(map(float, apart(recording.bases[name][0], frames_of(record["pose"]))))
        turned = np.abs(recording.joints[name][0] - np.asarray(record["start"], dtype=float)).max(initial=0.0)
        if max(shift, float(turned)) > 1.1e-6:
            yield "start_m", f"{name} does not start where the scene puts it", max(shift, float(turned)), 1e-6


def keeps_of(problem: ir.Problem, fact: tuple[str, ...], stored: Any) -> list[Keep]:
    """The `keep pose` rows of a literal, with what they hold constant."""
    predicate = problem.motions[fact[0]]
    binding = dict(zip((v.name for v in predicate.variables), fact[1:], strict=True))
    view = View(stored, lambda _: None, lambda _: (0.0, np.zeros((1, 3))))
    found = []
    for row in predicate.rows:
        if row.when == "keep" and isinstance(row.left, ir.Function) and row.left.name == "pose":
            follower, leader = (value(a, binding, view) for a in row.left.args)
            found.append(Keep(fact, follower, leader, inverse(stored(leader)) @ stored(follower)))
    return found


def _samples(recording: Recording, number: int, motion: Moving, gone: set[str], where: str) -> Iterator[Wrong]:
    """Whether the samples lie on the motion: joints on splines, poses where joints and what rests put them."""
    first, last = recording.ranges[number]
    here = slice(first, last + 1)
    for name, joints in recording.joints.items():
        off = float(np.abs(motion.joints[name][motion.samples] - joints[here]).max(initial=0.0))
        if off > 1.1e-6:
            yield "spline_rad", f"samples of {name} in {where} are not on its spline", off, 1e-6
    for name, frames in {**recording.bases, **recording.body_frames}.items():
        if name in gone:
            continue
        shift, turn = (float(a.max()) for a in apart(motion.frames[name][motion.samples], frames[here]))
        rests = name in motion.unheld
        limits = (1.2e-6, 1.2e-6) if rests else (SLIP, TURN)
        if shift > limits[0] or turn > limits[1]:
            kind = "rest_m" if rests else "slip_m"
            yield (
                kind,
                f"{name} in {where} is not where it should be by {shift:.2g} m, {turn:.2g} rad",
                shift,
                limits[0],
            )


def _joints(recording: Recording, plan: dict[str, Any], number: int, motion: Moving, gone: set[str]) -> Iterator[Wrong]:
    """Limits of joints, their rates, and joints that are stuck."""
    phase = plan["phases"][number]
    for name, record in recording.modules.items():
        if name in gone or not record["joints"]:
            continue
        spline = recording.splines.get((name, number))
        if spline is not None:
            for order, what in ((0, "joint_limit"), (1, "joint_speed"), (2, "joint_acceleration")):
                if order and spline.knots[0] < phase["start"] - 1e-9:
                    break
                low, high = spline.extremes(order)
                for joint, least, most in zip(record["joints"], low, high, strict=True):
                    if order == 0:
                        over, limit = max(most - joint["upper"], joint["lower"] - least), 1e-3
                    else:
                        top = joint["speed"] if order == 1 else joint.get("acceleration")
                        if top is None:
                            continue
                        over, limit = max(most, -least), top * 1.001 + 1e-9
                    if over > limit:
                        yield what, f"{name} {joint['name']} in phase {number}", float(over), float(limit)
        for index, joint in enumerate(record["joints"]):
            if joint.get("follows"):
                leader, factor, offset = (joint["follows"][n] for n in ("leader", "factor", "offset"))
                rows = motion.joints[name]
                off = float(np.abs(rows[:, index] - factor * rows[:, leader] - offset).max(initial=0.0))
                if off > 1e-6:
                    yield "coupling", f"{name} {joint['name']} in phase {number}", off, 1e-6
        stuck = [b["time"] for b in plan["breakdowns"] if b["module"] == name and b["kind"] == "locked"]
        after = motion.times >= min(stuck, default=math.inf)
        if after.any():
            spread = float(np.ptp(motion.joints[name][after], axis=0).max(initial=0.0))
            if spread > 1.1e-6:
                yield "stuck_rad", f"{name} moves in phase {number} though it is locked", spread, 1e-6


def _bound(problem: ir.Problem, plan: dict[str, Any], recording: Recording) -> Iterator[Wrong]:
    """Whether every module rests at the switches that bind it."""
    phases = plan["phases"]
    for number, phase in enumerate(phases[:-1]):
        before, after = ({(m["predicate"], *m["args"]) for m in p["mode"]} for p in phases[number : number + 2])
        named = {a for fact in (before ^ after) | _facts(phase["added"]) for a in fact[1:]}
        for mode in (before, after):
            robots = _robots(problem, recording, mode)
            for robot in robots:
                if any(a in robot or a.rpartition(".")[0] in robot for a in named):
                    named |= robot
        for name in set(recording.modules) & (named | {a.rpartition(".")[0] for a in named}):
            one, other = (recording.splines.get((name, k)) for k in (number, number + 1))
            if one is not None and one is other and recording.modules[name]["joints"]:
                rate = float(np.abs(one(np.array([phase["end"]]), 1)).max())
                if rate > 1e-3:
                    yield "rest", f"{name} moves through the switch of phase {number}, which binds it", rate, 1e-3


def _facts(literals: list[dict[str, Any]]) -> set[tuple[str, ...]]:
    return {(m["predicate"], *m["args"]) for m in literals}


def _robots(problem: ir.Problem, recording: Recording, mode: set[tuple[str, ...]]) -> list[set[str]]:
    """Modules that are linked through `keep` rows of two effectors."""
    robots = [{name} for name in recording.modules]
    for fact in mode:
        owners = {a.rpartition(".")[0] for a in fact[1:]} & set(recording.modules)
        if len(owners) == 2 and any(r.when == "keep" for r in problem.motions[fact[0]].rows):
            joined = [r for r in robots if r & owners]
            robots = [r for r in robots if not r & owners] + [set().union(*joined)]
    return robots


def _kept(motion: Moving, keeps: list[Keep], where: str) -> Iterator[Wrong]:
    for keep in keeps:
        relative = inverse(motion.frame(keep.leader)) @ motion.frame(keep.follower)
        shift, turn = (float(a.max()) for a in apart(relative, np.broadcast_to(keep.held, relative.shape)))
        if shift > SLIP or turn > TURN:
            message = f"[{' '.join(keep.fact)}] in {where} by {shift:.2g} m, {turn:.2g} rad"
            yield "slip_m", message, max(shift, turn), SLIP


def _held_rows(
    problem: ir.Problem, mode: list[tuple[str, ...]], fresh: set[tuple[str, ...]], before: dict[tuple[str, ...], Any],
    view: View, motion: Moving, where: str,
) -> Any:  # fmt: skip
    """`during` rows, and `keep` rows of other values than poses; gives what these hold constant, for the next phase."""
    held: dict[tuple[str, ...], Any] = {}
    for fact in mode:
        predicate = problem.motions[fact[0]]
        binding = dict(zip((v.name for v in predicate.variables), fact[1:], strict=True))
        for index, row in enumerate(predicate.rows):
            key = (*fact, str(index))
            if row.when == "during":
                over, limit = float(excess(row, binding, view).max()), 2e-3 if is_length(row) else 5e-3
                if over > limit:
                    yield "during", f"[{' '.join(fact)}] in {where}", over, limit
            elif row.when == "keep" and "pose" not in functions(row.left):
                values = value(row.left, binding, view)
                held[key] = before[key] if key in before and fact not in fresh else values[:1]
                over, limit = float(np.abs(values - held[key]).max()), SLIP if is_length(row) else TURN
                if over > limit:
                    yield "slip_m", f"[{' '.join(fact)}] in {where}", over, limit
    return held


def _switch(problem: ir.Problem, recording: Recording, number: int, phase: dict[str, Any]) -> Iterator[Wrong]:
    stored = recording.stored(recording.ranges[number][1])
    still = Moving(np.zeros(1), np.zeros(1, dtype=np.int64), {})
    for name, chain in recording.chains.items():
        sample = recording.ranges[number][1]
        still.frames[name] = stored(name)
        still.parts[name] = chain.frames(recording.joints[name][sample : sample + 1])
    still.frames |= {name: stored(name) for name in recording.bodies}
    view = View(stored, recording.solid, lambda name: _weight(problem, still, name))
    for literal in phase["added"]:
        fact = (literal["predicate"], *literal["args"])
        predicate = problem.motions[fact[0]]
        binding = dict(zip((v.name for v in predicate.variables), fact[1:], strict=True))
        for row in predicate.rows:
            if row.when != "switch":
                continue
            used = {f for side in (row.left, row.right) if side is not None for f in functions(side)}
            over, limit = (
                float(excess(row, binding, view).max()),
                5e-3 if "axis" in used and not is_length(row) else 2e-3,
            )
            if over > limit:
                yield "position_m", f"[{' '.join(fact)}] at the end of phase {number}", over, limit


def _weight(problem: ir.Problem, motion: Moving, name: str) -> tuple[float, Any]:
    """Mass in kilograms and centre of mass (T, 3) of a body or of a whole module."""
    return total(problem, motion, name if name in motion.frames else name.rpartition(".")[0])


def _parts(recording: Recording, motion: Moving, gone: set[str]) -> Iterator[Part]:
    for name in recording.bodies:
        solid, frames = recording.solid(name), motion.frames[name]
        if solid is not None and recording.bodies[name].get("collides", True):
            yield Part(name, "", solid, frames, bool(np.ptp(frames[:, :3, :], axis=0).max() > 1e-9))
    for name, chain in recording.chains.items():
        if name in gone:
            continue
        for part, joint, at, solid in parts_of(chain):
            frames = motion.frames[name] @ motion.parts[name][joint] @ at
            yield Part(name, part, solid, frames, bool(np.ptp(frames[:, :3, :], axis=0).max() > 1e-9))
