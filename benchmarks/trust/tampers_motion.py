"""Changes of the motion: stamps, samples, splines, and false motions whose parts all fit together."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from .checker.frames import Spline
from .draft import Draft
from .kinds import kind, need


def mover(draft: Draft) -> tuple[str, int, int]:
    """A module, a joint of it, and a phase in which something moves."""
    phase = draft.phase(0.3)
    modules = [m for m in draft.data["modules"] if m["joints"]]
    moving = [m for m in modules if draft.moves(m["name"], phase)] or modules
    module = draft.chance.choice(moving)
    return module["name"], draft.chance.randrange(len(module["joints"])), phase


def stamps(draft: Draft, phase: int, shares: Any) -> Any:
    start, end = draft.phases[phase]["start"], draft.phases[phase]["end"]
    stamps = start + (end - start) * np.asarray(shares)
    stamps[0], stamps[-1] = start, end
    return np.round(stamps, 10)


def crowded(draft: Draft, phase: int) -> None:
    """All samples in the first and last fifteenth of a phase."""
    count = len(draft.samples(phase))
    half = np.linspace(0, 0.07, count // 2)
    draft.derive(phase, stamps(draft, phase, [*half, *(1 - np.linspace(0, 0.07, count - count // 2)[::-1])]))


def push(row: list[float], by: list[float]) -> None:
    for axis in range(3):
        row[axis] = round(row[axis] + by[axis], 10)


def direction(draft: Draft) -> Any:
    found = np.array([draft.chance.gauss(0, 1) for _ in range(3)])
    return found / np.linalg.norm(found)


# --- stamps ------------------------------------------------------------------------------------------------------


@kind()
def stamps_uneven(draft: Draft) -> None:
    phase = draft.phase()
    count = len(draft.samples(phase))
    shares = np.sort([0.0, 1.0, *(draft.chance.random() for _ in range(count - 2))])
    need((np.diff(shares) > 1e-7).all())
    draft.derive(phase, stamps(draft, phase, shares))


@kind()
def stampscrowded(draft: Draft) -> None:
    crowded(draft, draft.phase())


@kind()
def stamps_shifted(draft: Draft) -> None:
    here = draft.samples(draft.phase())
    for i in here[1:-1]:
        draft.data["times"][i] = round(draft.data["times"][i] + 0.004, 10)


@kind(false=True)
def stamps_go_back(draft: Draft) -> None:
    here = draft.samples(draft.phase())
    need(len(here) > 4)
    times, i = draft.data["times"], draft.chance.choice(here[1:-2])
    times[i], times[i + 1] = times[i + 1], times[i]


@kind(false=True)
def stamp_twice(draft: Draft) -> None:
    here = draft.samples(draft.phase())
    need(len(here) > 4)
    i = draft.chance.choice(here[1:-2])
    draft.data["times"][i + 1] = draft.data["times"][i]


@kind(false=True)
def phase_ends_elsewhere(draft: Draft) -> None:
    draft.phases[draft.phase()][draft.chance.choice(["start", "end"])] += draft.chance.choice([1e-4, -0.05, 0.3])


@kind()
def samples_thinned(draft: Draft) -> None:
    """Every other sample left out; or all but the ends, as good as none."""
    phase = draft.phase()
    here = draft.samples(phase)
    step = draft.chance.choice([2, 7, len(here)])
    gone = {i for i in here[1:-1] if (i - here.start) % step}
    data = draft.data
    data["times"] = [t for i, t in enumerate(data["times"]) if i not in gone]
    for track in data["tracks"]:
        for field in ("poses", "joints"):
            track[field] = [row for i, row in enumerate(track[field]) if i not in gone]
    for track in data["body_tracks"]:
        first = track.get("first", 0)
        track["poses"] = [row for i, row in enumerate(track["poses"], first) if i not in gone]
        if "first" in track:
            track["first"] -= len([i for i in gone if i < first])


@kind()
def everything_slower(draft: Draft) -> None:
    for phase in range(len(draft.phases)):
        draft.faster(phase, 0.7)


@kind()
def everything_faster(draft: Draft) -> None:
    for phase in range(len(draft.phases)):
        draft.faster(phase, 1.3)


@kind(false=True)
def acceleration_over_its_limit(draft: Draft) -> None:
    """The worst joint of a phase by 1 to 10 % above what it can."""
    phase = draft.chance.choice([k for k, p in enumerate(draft.phases) if p.get("completed", True)])
    worst = 0.0
    for record in draft.data["modules"]:
        if not record["joints"]:
            continue
        spline = draft.spline(record["name"], phase)
        low, high = Spline(spline["knots"], spline["values"]).extremes(2)
        tops = np.array([j["acceleration"] for j in record["joints"]])
        worst = max(worst, float((np.maximum(-low, high) / tops).max()))
    need(worst > 1e-3)
    draft.faster(phase, float(np.sqrt(draft.chance.choice([1.01, 1.1]) / worst)))


@kind(false=True)
def phase_in_a_blink(draft: Draft) -> None:
    """0.1 s for a whole phase, with all its samples."""
    module, _, phase = mover(draft)
    need(draft.moves(module, phase))
    record = draft.phases[phase]
    need(record["end"] - record["start"] > 0.6)
    draft.faster(phase, (record["end"] - record["start"]) / 0.1)


# --- samples -----------------------------------------------------------------------------------------------------


@kind(false=True)
def joint_of_a_sample(draft: Draft) -> None:
    row = draft.chance.choice(draft.track()["joints"])
    row[draft.chance.randrange(len(row))] += draft.chance.choice([1e-4, 0.01, -0.5])


@kind()
def pose_of_a_sample(draft: Draft) -> None:
    poses = draft.chance.choice(draft.data["tracks"])["poses"]
    push(draft.chance.choice(poses), list(draft.chance.choice([4e-3, 0.1]) * direction(draft)))


@kind()
def pose_of_a_sample_turned(draft: Draft) -> None:
    pose = draft.chance.choice(draft.chance.choice(draft.data["tracks"])["poses"])
    turn = Rotation.from_rotvec(draft.chance.choice([0.01, 0.3]) * direction(draft))
    pose[3:] = [float(v) for v in (turn * Rotation.from_quat(pose[3:])).as_quat()]


@kind(false=True)
def quaternion_too_long(draft: Draft) -> None:
    pose = draft.chance.choice(draft.chance.choice(draft.data["tracks"])["poses"])
    factor = draft.chance.choice([1.001, 0.5, 0.0])
    pose[3:] = [factor * v for v in pose[3:]]


@kind()
def quaternion_of_the_other_sign(draft: Draft) -> None:
    for pose in draft.chance.choice(draft.data["tracks"])["poses"][::3]:
        pose[3:] = [-v for v in pose[3:]]


@kind(false=True)
def module_elsewhere(draft: Draft) -> None:
    by = list(0.05 * direction(draft))
    for pose in draft.chance.choice(draft.data["tracks"])["poses"]:
        push(pose, by)


@kind(false=True)
def sample_too_many(draft: Draft) -> None:
    track = draft.track()
    field = draft.chance.choice(["joints", "poses"])
    track[field].append(track[field][-1])


@kind(false=True)
def track_missing(draft: Draft) -> None:
    del draft.data["tracks"][draft.chance.randrange(len(draft.data["tracks"]))]


@kind(false=True)
def track_twice(draft: Draft) -> None:
    draft.data["tracks"].append(copy.deepcopy(draft.chance.choice(draft.data["tracks"])))


# --- splines -----------------------------------------------------------------------------------------------------


@kind()
def spline_between_samples(draft: Draft) -> None:
    module, joint, phase = mover(draft)
    values = draft.spline(module, phase)["values"]
    need(len(values) > 2)
    draft.chance.choice(values[1:-1])[joint] += draft.chance.choice([1e-7, 1e-3, 0.3])


@kind()
def spline_of_other_knots(draft: Draft) -> None:
    module, _, phase = mover(draft)
    draft.finer(draft.spline(module, phase), draft.chance.choice([3, 17, 97]))
    draft.derive(phase)


@kind(false=True)
def knots_uneven(draft: Draft) -> None:
    module, _, phase = mover(draft)
    knots = draft.spline(module, phase)["knots"]
    need(len(knots) > 3)
    knots[1] = (knots[1] + 2 * knots[2]) / 3


@kind()
def spline_missing(draft: Draft) -> None:
    module, _, phase = mover(draft)
    need(draft.moves(module, phase))
    draft.data["splines"].remove(draft.spline(module, phase))


@kind(false=True)
def spline_twice(draft: Draft) -> None:
    draft.data["splines"].append(copy.deepcopy(draft.chance.choice(draft.data["splines"])))


@kind(false=True)
def spline_of_nobody(draft: Draft) -> None:
    made = copy.deepcopy(draft.chance.choice(draft.data["splines"]))
    if draft.chance.random() < 0.5:
        made["module"] = "nobody"
    else:
        for field in {"phase", "until"} & set(made):
            made[field] = len(draft.phases) + draft.chance.choice([0, 1, 10**9])
    draft.data["splines"].append(made)


@kind(false=True)
def spline_too_short(draft: Draft) -> None:
    module, _, phase = mover(draft)
    spline = draft.spline(module, phase)
    middle = (spline["knots"][0] + spline["knots"][-1]) / 2
    spline["knots"] = [(k + middle) / 2 for k in spline["knots"]]


@kind(false=True)
def spline_with_too_few_rows(draft: Draft) -> None:
    draft.chance.choice(draft.data["splines"])["values"].pop()


@kind(false=True)
def spline_with_too_few_joints(draft: Draft) -> None:
    found = [s for s in draft.data["splines"] if s["values"][0]]
    spline = draft.chance.choice(found)
    spline["values"] = [row[:-1] for row in spline["values"]]
