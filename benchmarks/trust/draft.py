"""A plan on its way to be spoilt: its records, and what it takes to make a false motion whose parts fit together."""

from __future__ import annotations

import json
from functools import cached_property
from random import Random
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tamplang.compiler import ir

from .checker.form import upgraded
from .checker.frames import Spline
from .checker.motion import Moving, Recording, moving
from .checker.scene import compiled
from .checker.watch import keeps_of

Matrix = NDArray[np.float64]
Data = dict[str, Any]
PROBLEMS: dict[str, ir.Problem] = {}


class Draft:
    """`data` is the plan to change, `chance` draws where and by how much."""

    def __init__(self, text: str, chance: Random) -> None:
        self.data: Data = json.loads(text)
        self.chance = chance

    @cached_property
    def problem(self) -> ir.Problem:
        """Of the plan as it was: ask before sources are changed."""
        key = json.dumps(self.data["task"], sort_keys=True)
        if key not in PROBLEMS:
            PROBLEMS[key] = compiled(self.data["task"])
        return PROBLEMS[key]

    # --- where ---------------------------------------------------------------------------------------------------

    @property
    def phases(self) -> list[Data]:
        phases: list[Data] = self.data["phases"]
        return phases

    def phase(self, least: float = 0.0) -> int:
        """A phase that lasts at least so long."""
        return self.chance.choice([k for k, p in enumerate(self.phases) if p["end"] - p["start"] >= least])

    def samples(self, phase: int) -> range:
        first, last = Recording(upgraded(self.data), self.problem).ranges[phase]
        return range(first, last + 1)

    def track(self) -> Data:
        """The track of a module with joints."""
        found: Data = self.chance.choice([t for t in self.data["tracks"] if t["joints"][0]])
        return found

    def body(self) -> Data:
        found: Data = self.chance.choice(self.data["bodies"])
        return found

    def moves(self, module: str, phase: int) -> bool:
        """Whether a module moves its joints in a phase."""
        rows = np.array(self.spline(module, phase)["values"])
        return bool(rows.size) and float(np.ptp(rows, axis=0).max()) > 1e-3

    def spline(self, module: str, phase: int) -> Data:
        """The one that belongs to the phase alone; a spline at rest is made where there is none."""
        for spline in self.data["splines"]:
            first, last = span(spline)
            if spline["module"] == module and first <= phase <= last:
                found: Data = spline
                return found
        start, end = self.phases[phase]["start"], self.phases[phase]["end"]
        row = next(t for t in self.data["tracks"] if t["name"] == module)["joints"][self.samples(phase).start]
        made: Data = {"module": module, "from": phase, "until": phase, "knots": [start, end], "values": [row, row]}
        self.data["splines"].append(made)
        return made

    # --- false motions whose parts fit together ------------------------------------------------------------------

    def bump(self, module: str, phase: int, joint: int, by: float, begin: float, end: float) -> None:
        """Adds a smooth hill to a joint's spline between two shares of the phase, and derives the samples anew."""
        spline = self.spline(module, phase)
        self.finer(spline, 48)
        knots = np.array(spline["knots"])
        share = (knots - knots[0]) / (knots[-1] - knots[0])
        inside = np.clip((share - begin) / (end - begin), 0.0, 1.0)
        hill = by * (0.5 - 0.5 * np.cos(2 * np.pi * inside))
        for row, height in zip(spline["values"], hill, strict=True):
            row[joint] = round(row[joint] + float(height), 10)
        self.derive(phase)

    def finer(self, spline: Data, pieces: int) -> None:
        """The same motion, to the accuracy of a spline, with other knots."""
        old = Spline(spline["knots"], spline["values"])
        knots = np.linspace(old.knots[0], old.knots[-1], pieces + 1)
        spline["knots"] = [round(float(k), 10) for k in knots]
        spline["knots"][0], spline["knots"][-1] = float(old.knots[0]), float(old.knots[-1])
        spline["values"] = _rounded(old(knots))

    def moving(self, phase: int, stamps: Matrix | None = None) -> Moving:
        recording = Recording(upgraded(self.data), self.problem)
        stored = recording.stored(recording.ranges[phase][0])
        mode = [(m["predicate"], *m["args"]) for m in self.phases[phase]["mode"]]
        keeps = [k for fact in mode for k in keeps_of(self.problem, fact, stored)]
        taken = {a for p in self.phases[: phase + 1] for m in p["mode"] for a in m["args"][1:]}
        return moving(recording, phase, keeps, taken, set(), stamps)

    def derive(self, phase: int, stamps: Matrix | None = None) -> None:
        """The samples of a phase from its splines and from what rests; at other `stamps` where given."""
        recording = Recording(upgraded(self.data), self.problem)
        first, last = recording.ranges[phase]
        motion = self.moving(phase, stamps)
        here = range(first, last + 1)
        if stamps is not None:
            self.data["times"][first : last + 1] = [float(t) for t in stamps]
        for track in self.data["tracks"]:
            track["joints"][first : last + 1] = _rounded(motion.joints[track["name"]][motion.samples])
            track["poses"][first : last + 1] = poses_of(motion.frames[track["name"]][motion.samples])
        for track in self.data["body_tracks"]:
            if self.covers(track, first):
                at = first - track.get("first", 0)
                track["poses"][at : at + len(here)] = poses_of(motion.frames[track["name"]][motion.samples])

    def faster(self, phase: int, factor: float) -> None:
        """The same way in `1 / factor` of the time; what follows moves up."""
        here, start, end = self.samples(phase), self.phases[phase]["start"], self.phases[phase]["end"]
        shorter = float(end - start) / factor

        def at(time: float) -> float:
            if time >= end:
                return round(time - float(end - start) + shorter, 10)
            return round(float(start) + (time - float(start)) / factor, 10) if time > start else time

        self.data["times"] = [at(t) if i >= here.start else t for i, t in enumerate(self.data["times"])]
        for number, record in enumerate(self.phases):
            if number >= phase:
                record["start"], record["end"] = at(record["start"]), at(record["end"])
        for spline in self.data["splines"]:
            if span(spline)[1] >= phase:
                spline["knots"] = [at(k) for k in spline["knots"]]

    @staticmethod
    def covers(track: Data, sample: int) -> bool:
        """Whether a body track has a pose for a sample."""
        first = track.get("first", 0)
        return bool(first <= sample < first + len(track["poses"]))

    def cut(self, phase: int) -> None:
        """A phase taken out with its samples and splines; what follows moves up in time."""
        here = self.samples(phase)
        start, end = self.phases[phase]["start"], self.phases[phase]["end"]

        def at(time: float) -> float:
            return round(time - (end - start), 10) if time >= end else time

        del self.phases[phase]
        times = self.data["times"]
        self.data["times"] = [at(t) if i >= here.stop else t for i, t in enumerate(times) if i not in here]
        for track in self.data["tracks"]:
            for field in ("poses", "joints"):
                track[field] = [row for i, row in enumerate(track[field]) if i not in here]
        for track in self.data["body_tracks"]:
            first = track.get("first", 0)
            track["poses"] = [row for i, row in enumerate(track["poses"], first) if i not in here]
            if "first" in track and first >= here.start:
                track["first"] = max(here.start, first - len(here))
        self.data["body_tracks"] = [t for t in self.data["body_tracks"] if t["poses"]]
        self.data["splines"] = [s for s in self.data["splines"] if span(s) != (phase, phase)]
        for record in self.phases[phase:]:
            record["start"], record["end"] = at(record["start"]), at(record["end"])
        for spline in self.data["splines"]:
            if span(spline)[0] > phase:
                spline["knots"] = [at(k) for k in spline["knots"]]
            for field in ("phase", "from", "until"):
                if spline.get(field, -1) >= phase:
                    spline[field] -= 1


def span(spline: Data) -> tuple[int, int]:
    """The first and the last phase of a spline, of format 1 or 2."""
    return (spline["phase"],) * 2 if "phase" in spline else (spline["from"], spline["until"])


def poses_of(frames: Matrix) -> list[list[float]]:
    turned = Rotation.from_matrix(frames[:, :3, :3]).as_quat()
    return _rounded(np.hstack([frames[:, :3, 3], turned]))


def _rounded(rows: Matrix) -> list[list[float]]:
    return [[round(float(v), 10) for v in row] for row in rows]
