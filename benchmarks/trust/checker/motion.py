"""The motion of a plan file at and between its samples: what each phase does, by splines and by what rests."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tamplang.compiler import ir

from .frames import Chain, Spline, frames_of, inverse
from .scene import centre_of
from .shapes import Solid, solid_of

Matrix = NDArray[np.float64]
Fact = tuple[str, ...]
STEP = 0.004
"""Seconds between the checker's own instants: joints at 2 rad/s move an arm of 1 m by 8 mm, and what lies between is
a part of a smooth curve, 0.02 mm off a line at the accelerations of the module types."""
MOST = 4000


class Recording:
    """The arrays of a plan file, by name."""

    def __init__(self, plan: dict[str, Any], problem: ir.Problem) -> None:
        self.plan, self.problem = plan, problem
        self.times = np.asarray(plan["times"], dtype=float)
        self.modules = {m["name"]: m for m in plan["modules"]}
        self.bodies = {b["name"]: b for b in plan["bodies"]}
        self.chains = {name: Chain(record) for name, record in self.modules.items()}
        self.joints: dict[str, Matrix] = {}
        self.bases: dict[str, Matrix] = {}
        for track in plan["tracks"]:
            count = len(self.chains[track["name"]].joints)
            self.joints[track["name"]] = np.asarray(track["joints"], dtype=float).reshape(len(self.times), count)
            self.bases[track["name"]] = frames_of(np.asarray(track["poses"], dtype=float).reshape(len(self.times), 7))
        if set(self.joints) != set(self.modules):
            raise ValueError("not every module has a track")
        self.ranges = self._ranges()

    def standing(self, keeps: Iterable[tuple[str, str]]) -> set[str]:
        """The modules that nothing carries, neither at the start nor by `keeps`, pairs of leader and follower."""
        first = self.plan["phases"][0]["mode"] if self.plan["phases"] else []
        pairs = [*keeps, *(p for m in first for p in self._kept((m["predicate"], *m["args"])))]
        carried = set()
        for pair in pairs:
            leader, follower = pair[::-1] if self._is_still(pair[1]) else pair
            joint, drives = self._end(follower)
            if joint < 0 or (drives and self._can_carry(leader)):
                carried.add(follower)
        return {n for n in self.modules if not any(c == n or c.rpartition(".")[0] == n for c in carried)}

    def _is_still(self, name: str) -> bool:
        return name in self.bodies and not self.bodies[name]["movable"]

    def _can_carry(self, leader: str) -> bool:
        """Whether a robot that is held behind its joints may hang on this: on the scene, a frame, or drives."""
        joint, drives = self._end(leader)
        return self._is_still(leader) or (leader not in self.bodies and (joint < 0 or drives))

    def _end(self, name: str) -> tuple[int, bool]:
        """The joint behind which a thing lies in its module, -1 for none, and whether that one has drives."""
        module, _, end = name.rpartition(".")
        record = self.modules.get(name) or self.modules.get(module)
        if record is None:
            return -1, False
        joint = next((e["joint"] for e in record["effectors"] if e["name"] == end and name != record["name"]), -1)
        return joint, any(not j.get("passive", False) for j in record["joints"])

    def _kept(self, fact: Fact) -> Iterator[tuple[str, str]]:
        motion = self.problem.motions[fact[0]]
        names = dict(zip((v.name for v in motion.variables), fact[1:], strict=True))
        for row in motion.rows:
            if row.when == "keep" and isinstance(row.left, ir.Function) and row.left.name == "pose":
                follower, leader = (names[a.name] for a in row.left.args if isinstance(a, ir.Var))
                yield leader, follower

    def _ranges(self) -> list[tuple[int, int]]:
        """First and last sample of every phase."""
        twice = np.flatnonzero(np.diff(self.times) == 0)
        starts, ends = [0, *(int(i) + 1 for i in twice)], [*(int(i) for i in twice), len(self.times) - 1]
        phases = len(self.plan["phases"])
        if phases and len(starts) != phases and not (len(starts) == phases + 1 and starts[-1] == ends[-1]):
            raise ValueError(f"{len(starts)} stretches of samples for {phases} phases")
        return list(zip(starts, ends, strict=True))[:phases]

    @cached_property
    def body_frames(self) -> dict[str, Matrix]:
        """Stored frames of the bodies at every sample: those of their tracks, else where they are at the start."""
        found = {n: np.tile(frames_of(b["pose"]), (len(self.times), 1, 1)) for n, b in self.bodies.items()}
        free = dict.fromkeys(found, 0)
        for track in self.plan["body_tracks"]:
            name, first, count = track["name"], track["first"], len(track["poses"])
            stop = first + count
            firsts, lasts = {f for f, _ in self.ranges} | {0}, {last for _, last in self.ranges} | {len(self.times) - 1}
            if first < free[name] or first not in firsts or stop - 1 not in lasts:
                raise ValueError(f"a piece of {name} does not fit the phases")
            found[name][first:stop] = frames_of(np.asarray(track["poses"], dtype=float).reshape(count, 7))
            found[name][stop:] = found[name][stop - 1]
            free[name] = stop
        return found

    def stored(self, sample: int) -> Callable[[str], Matrix]:
        """Frames (1, 4, 4) of all objects at a sample, as the file has them."""
        one = slice(sample, sample + 1)

        def frame(name: str) -> Matrix:
            if name in self.bodies:
                return self.body_frames[name][one]
            module, dot, end = (name, "", "") if name in self.modules else name.rpartition(".")
            base = self.bases[module][one]
            if not dot:
                return base
            return base @ self.chains[module].end(end, self.chains[module].frames(self.joints[module][one]))

        return frame

    def solid(self, name: str) -> Solid | None:
        if name in self.bodies:
            shape = self.bodies[name]["shape"]
        else:
            module, _, end = name.rpartition(".")
            shape = next(e["shape"] for e in self.modules[module]["effectors"] if e["name"] == end)
        return None if shape is None else solid_of(shape["kind"], shape["size"])

    @cached_property
    def splines(self) -> dict[tuple[str, int], Spline]:
        """By module and phase. Raises ValueError where they do not fit the phases."""
        found: dict[tuple[str, int], Spline] = {}
        phases = self.plan["phases"]
        for record in self.plan["splines"]:
            first, last = record["from"], record["until"]
            if not 0 <= first <= last < len(phases) or record["module"] not in self.modules:
                raise ValueError("a spline of no phase or module")
            spline = Spline(record["knots"], record["values"])
            ends = phases[first]["start"], phases[last]["end"]
            if max(abs(spline.knots[0] - ends[0]), abs(spline.knots[-1] - ends[1])) > 1e-9:
                raise ValueError(f"a spline of {record['module']} does not span its phases")
            if spline.rows.shape[1] != len(self.chains[record["module"]].joints):
                raise ValueError(f"a spline of {record['module']} has other joints")
            for phase in range(first, last + 1):
                if (record["module"], phase) in found:
                    raise ValueError(f"{record['module']} has two splines in phase {phase}")
                found[record["module"], phase] = spline
        return found


@dataclass(slots=True)
class Keep:
    """A literal whose `keep pose(follower, leader)` row holds, and what it holds constant: set at its first sample."""

    fact: Fact
    follower: str
    leader: str
    held: Matrix


@dataclass(slots=True)
class Moving:
    """One phase at the checker's instants. `frames` are those of modules and bodies, `floating` names modules whose
    place nothing says but the samples, `unheld` what follows nothing, `standing` modules that never did."""

    times: Matrix
    samples: NDArray[np.int64]
    """Which instants are those of the phase's samples."""
    joints: dict[str, Matrix]
    frames: dict[str, Matrix] = field(default_factory=dict)
    ends: dict[str, Matrix] = field(default_factory=dict)
    parts: dict[str, list[Matrix]] = field(default_factory=dict)
    unheld: set[str] = field(default_factory=set)
    floating: set[str] = field(default_factory=set)
    standing: set[str] = field(default_factory=set)

    def frame(self, name: str) -> Matrix:
        if name in self.frames:
            return self.frames[name]
        return self.frames[name.rpartition(".")[0]] @ self.ends[name]


def moving(
    recording: Recording,
    phase: int,
    keeps: list[Keep],
    leaving: set[str],
    gone: set[str],
    stamps: Matrix | None = None,
) -> Moving:
    """The motion of a phase. `keeps` hold in it; bodies of `leaving` follow no course any more; `gone` modules count
    for nothing. `stamps` are the times of its samples, unless given those of the file."""
    record = recording.plan["phases"][phase]
    start, end = float(record["start"]), float(record["end"])
    first, last = recording.ranges[phase]
    stamps = recording.times[first : last + 1] if stamps is None else stamps
    count = int(min(MOST, max(50, np.ceil((end - start) / STEP))))
    times = np.unique(np.concatenate([np.linspace(start, end, count + 1), np.clip(stamps, start, end)]))
    joints = {
        m: _values(recording.splines.get((m, phase)), times, recording.joints[m][first]) for m in recording.modules
    }
    found = Moving(times, np.searchsorted(times, np.clip(stamps, start, end)), joints)
    for name, chain in recording.chains.items():
        found.parts[name] = chain.frames(joints[name])
        for end_name in chain.ends:
            found.ends[f"{name}.{end_name}"] = chain.end(end_name, found.parts[name])
    _place(found, recording, first, keeps, leaving, gone)
    return found


def _values(spline: Spline | None, times: Matrix, before: Matrix) -> Matrix:
    """Joint values at `times`; without a spline those of the phase's first sample."""
    if spline is None or not before.size:
        return np.tile(before, (len(times), 1))
    return spline(times)


def _place(
    found: Moving, recording: Recording, first: int, keeps: list[Keep], leaving: set[str], gone: set[str]
) -> None:
    """Frames of bodies and modules, one from the other, from those that nothing carries."""
    followers = {k.follower for k in keeps}
    still = len(found.times), 1, 1
    for name, body in recording.bodies.items():
        if name in followers:
            continue
        found.unheld.add(name)
        frames = np.tile(recording.body_frames[name][first], still)
        courses = [c for c in recording.plan["courses"] if c["body"] == name]
        if courses and name not in leaving:
            frames[:, :3, 3] = centre_of(body, courses, found.times)
        found.frames[name] = frames
    standing = recording.standing((k.leader, k.follower) for k in keeps)
    for name in gone | standing:
        found.frames[name] = np.tile(recording.bases[name][first], still)
    found.unheld |= standing - gone
    found.standing = standing
    _spread(found, keeps)
    for name in recording.modules:
        if name in found.frames:
            continue
        ends = {name, *(f"{name}.{e}" for e in recording.chains[name].ends)}
        if any(k.follower in ends or k.leader in ends for k in keeps):
            found.floating.add(name)
            _root(found, recording, name, first)
        else:
            found.unheld.add(name)
            found.frames[name] = np.tile(recording.bases[name][first], still)
        _spread(found, keeps)
    for name in recording.bodies:
        if name not in found.frames:
            found.unheld.add(name)
            found.frames[name] = np.tile(recording.body_frames[name][first], still)
            _spread(found, keeps)


def _spread(found: Moving, keeps: list[Keep]) -> None:
    """From frames that are known to those that are kept to them."""
    changed = True
    while changed:
        changed = False
        for keep in keeps:
            for one, other, held in (
                (keep.leader, keep.follower, keep.held),
                (keep.follower, keep.leader, inverse(keep.held)),
            ):
                owner = other if other in found.frames or other not in found.ends else other.rpartition(".")[0]
                base = one if one not in found.ends else one.rpartition(".")[0]
                if base in found.frames and owner not in found.frames:
                    frame = found.frame(one) @ held
                    found.frames[owner] = frame if owner == other else frame @ inverse(found.ends[other])
                    changed = True


def _root(found: Moving, recording: Recording, name: str, first: int) -> None:
    """A module of a group in which nothing rests by itself: by a frame of it whose samples are all the same, else as
    its samples say."""
    here = slice(first, first + len(found.samples))
    bases, parts = recording.bases[name][here], recording.chains[name].frames(recording.joints[name][here])
    for end in recording.chains[name].ends:
        there = bases @ recording.chains[name].end(end, parts)
        if np.ptp(there, axis=0).max() < 1e-6:
            found.frames[name] = there[0] @ inverse(found.ends[f"{name}.{end}"])
            return
    found.frames[name] = _between(found, recording, name, first)


def _between(found: Moving, recording: Recording, name: str, first: int) -> Matrix:
    """The stored frames of a module, drawn straight between the samples."""
    from scipy.spatial.transform import Rotation, Slerp

    stored = recording.bases[name][first : first + len(found.samples)]
    stamps, kept = np.unique(found.times[found.samples], return_index=True)
    frames = np.tile(np.eye(4), (len(found.times), 1, 1))
    if len(kept) < 2:
        return np.tile(stored[0], (len(found.times), 1, 1))
    frames[:, :3, :3] = Slerp(stamps, Rotation.from_matrix(stored[kept, :3, :3]))(found.times).as_matrix()
    for k in range(3):
        frames[:, k, 3] = np.interp(found.times, stamps, stored[kept, k, 3])
    return frames
