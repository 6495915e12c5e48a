"""False motions whose parts all fit together: detours, slips, things that lag, and motion through a switch."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from .checker.frames import Spline
from .draft import Draft, span
from .kinds import kind, need
from .tampers_motion import crowded, direction, mover, push

# --- false motions whose parts fit together ----------------------------------------------------------------------


def _detour(draft: Draft, least: float, most: float) -> int:
    module, joint, phase = mover(draft)
    by = draft.chance.choice([-1, 1]) * draft.chance.uniform(least, most)
    draft.bump(module, phase, joint, by, draft.chance.uniform(0.0, 0.2), draft.chance.uniform(0.8, 1.0))
    return phase


@kind()
def detour_small(draft: Draft) -> None:
    _detour(draft, 0.005, 0.05)


@kind()
def detour(draft: Draft) -> None:
    _detour(draft, 0.1, 1.2)


@kind()
def detour_taken_slowly(draft: Draft) -> None:
    """Slow enough for the drives, so that only what stands in the way tells."""
    draft.faster(_detour(draft, 0.3, 1.5), 0.2)


@kind()
def detour_between_crowded_samples(draft: Draft) -> None:
    module, joint, phase = mover(draft)
    by = draft.chance.choice([-1, 1]) * draft.chance.uniform(0.2, 1.5)
    draft.bump(module, phase, joint, by, 0.1, 0.9)
    draft.faster(phase, 0.2)
    crowded(draft, phase)


@kind()
def swing_between_crowded_samples(draft: Draft) -> None:
    """Quick, and over before the next sample."""
    module, joint, phase = mover(draft)
    begin = draft.chance.uniform(0.1, 0.7)
    draft.bump(module, phase, joint, draft.chance.uniform(-0.4, 0.4), begin, begin + 0.2)
    crowded(draft, phase)


@kind()
def joint_over_its_limit(draft: Draft) -> None:
    module, joint, phase = mover(draft)
    record = next(m for m in draft.data["modules"] if m["name"] == module)["joints"][joint]
    need(record["upper"] < 1e3)
    draft.finer(draft.spline(module, phase), 48)
    most = max(row[joint] for row in draft.spline(module, phase)["values"])
    draft.bump(module, phase, joint, record["upper"] - most + draft.chance.choice([5e-3, 0.2]), 0.0, 1.0)
    draft.faster(phase, 0.2)


def _slip(draft: Draft, by: float, turn: float = 0.0) -> None:
    """A module drifts smoothly away from what it stands on or is docked to, and back."""
    track = draft.chance.choice(draft.data["tracks"])
    here, way, axis = draft.samples(draft.phase(0.3)), by * direction(draft), direction(draft)
    count = len(here)
    for i in here:
        share = float(0.5 - 0.5 * np.cos(2 * np.pi * (i - here.start) / (count - 1)))
        pose = track["poses"][i]
        push(pose, list(share * way))
        turned = Rotation.from_rotvec(share * turn * axis) * Rotation.from_quat(pose[3:])
        pose[3:] = [round(float(v), 10) for v in turned.as_quat()]


@kind()
def foot_slips(draft: Draft) -> None:
    _slip(draft, draft.chance.choice([2.2e-3, 0.01, 0.05]))


@kind()
def foot_slips_less_than_the_limit(draft: Draft) -> None:
    _slip(draft, 4e-4)


@kind()
def foot_turns(draft: Draft) -> None:
    _slip(draft, 0.0, draft.chance.choice([5e-3, 0.1]))


@kind()
def dock_opens(draft: Draft) -> None:
    """A module that is docked or stands drifts off by 2 mm for the rest of the plan."""
    track = draft.chance.choice(draft.data["tracks"])
    phase = draft.phase()
    way = 2.2e-3 * direction(draft)
    for i in range(draft.samples(phase).start, len(track["poses"])):
        share = min(1.0, (i - draft.samples(phase).start) / max(1, len(draft.samples(phase)) - 1))
        push(track["poses"][i], list(share * way))


# --- bodies ------------------------------------------------------------------------------------------------------


def _body_track(draft: Draft) -> dict[str, Any]:
    need(draft.data["body_tracks"])
    chosen: dict[str, Any] = draft.chance.choice(draft.data["body_tracks"])
    return chosen


@kind()
def body_track_missing(draft: Draft) -> None:
    draft.data["body_tracks"].remove(_body_track(draft))


@kind(false=True)
def body_track_twice(draft: Draft) -> None:
    draft.data["body_tracks"].append(copy.deepcopy(_body_track(draft)))


@kind()
def body_lags(draft: Draft) -> None:
    """What is held is where it was some samples before."""
    poses = _body_track(draft)["poses"]
    lag = draft.chance.choice([1, 3, 10])
    need(len(poses) > 3 * lag)
    begin = draft.chance.randrange(0, len(poses) - lag)
    end = min(len(poses), begin + draft.chance.choice([20, len(poses)]))
    old = copy.deepcopy(poses)
    for i in range(max(begin, lag), end):
        poses[i] = old[i - lag]


@kind()
def body_jumps(draft: Draft) -> None:
    poses = _body_track(draft)["poses"]
    push(draft.chance.choice(poses), list(draft.chance.choice([1e-4, 3e-3, 0.1]) * direction(draft)))


@kind()
def body_drifts(draft: Draft) -> None:
    poses = _body_track(draft)["poses"]
    way = draft.chance.choice([3e-3, 0.05]) * direction(draft)
    for i, pose in enumerate(poses):
        push(pose, list(way * i / len(poses)))


@kind()
def body_turns(draft: Draft) -> None:
    poses = _body_track(draft)["poses"]
    axis = draft.chance.choice([0.02, 0.5]) * direction(draft)
    for i, pose in enumerate(poses):
        turned = Rotation.from_rotvec(axis * i / len(poses)) * Rotation.from_quat(pose[3:])
        pose[3:] = [round(float(v), 10) for v in turned.as_quat()]


@kind(false=True)
def body_at_rest_drifts(draft: Draft) -> None:
    moving = {t["name"] for t in draft.data["body_tracks"]}
    still = [b for b in draft.data["bodies"] if b["name"] not in moving]
    need(still)
    body = draft.chance.choice(still)
    way = draft.chance.choice([1e-4, 0.05]) * direction(draft)
    count = len(draft.data["times"])
    poses = [[*(p + w * i / count for p, w in zip(body["pose"], way, strict=False)), *body["pose"][3:]]
             for i in range(count)]  # fmt: skip
    made = {"name": body["name"], "poses": poses}
    if draft.data["format"] != "tamplang-plan/1":
        made["first"] = 0
    draft.data["body_tracks"].append(made)


@kind()
def spline_through_a_switch(draft: Draft) -> None:
    """Two splines of a module made one, which goes through the switch without rest."""
    need(len(draft.phases) > 1 and draft.data["format"] != "tamplang-plan/1")
    phase = draft.chance.randrange(len(draft.phases) - 1)
    module = draft.chance.choice([m for m in draft.data["modules"] if m["joints"]])["name"]
    one, other = draft.spline(module, phase), draft.spline(module, phase + 1)
    need(span(one) == (phase, phase) and span(other) == (phase + 1, phase + 1))
    first, second = (Spline(s["knots"], s["values"]) for s in (one, other))
    knots = np.linspace(first.knots[0], second.knots[-1], 97)
    rows = np.where((knots < first.knots[-1])[:, None], first(knots), second(knots))
    one.update({"until": phase + 1, "knots": [round(float(k), 10) for k in knots], "values": rows.tolist()})
    one["knots"][0], one["knots"][-1] = float(first.knots[0]), float(second.knots[-1])
    draft.data["splines"].remove(other)
    draft.derive(phase)
    draft.derive(phase + 1)
