"""A plan that someone changed is refused by a failure that names what is wrong, never by a traceback."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable
from typing import Any

import msgspec
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from tamplang.runtime.plan import Plan
from tamplang.runtime.verify import verify

Data = dict[str, Any]


def changed(plan: Plan, change: Callable[[Data], object]) -> Plan:
    """A copy of the plan after `change` of its plain data; NaN and all."""
    data = msgspec.to_builtins(plan)
    change(data)
    return msgspec.convert(data, Plan)


def track(data: Data) -> Data:
    return data["tracks"][0]


def move_sample(data: Data) -> None:
    track(data)["poses"][40][2] += 0.01


def move_joint(data: Data) -> None:
    track(data)["joints"][40][3] += 0.01


def move_joint_and_spline(data: Data) -> None:
    for spline in data["splines"]:
        for row in spline["values"]:
            row[0] += 0.2
    for row in track(data)["joints"]:
        row[0] += 0.2


def delete_phase(data: Data) -> None:
    del data["phases"][1]


def delete_phase_with_samples(data: Data) -> None:
    """A whole phase cut out, with its samples and splines, and the rest moved up in time."""
    start, end = data["phases"][1]["start"], data["phases"][1]["end"]
    count = data["times"].index(end) + 1
    first = data["times"].index(start) + 1
    del data["phases"][1]
    keep = [*range(first), *range(count, len(data["times"]))]
    data["times"] = [data["times"][i] - (end - start if i >= count else 0.0) for i in keep]
    for item in data["tracks"]:
        for field in ("poses", "joints"):
            item[field] = [item[field][i] for i in keep]
    for piece in data["body_tracks"]:
        piece["first"] -= count - first
    splines = [s for s in data["splines"] if s["from"] != 1]
    for spline in splines:
        if spline["from"] > 1:
            spline["from"] -= 1
            spline["until"] -= 1
            spline["knots"] = [k - (end - start) for k in spline["knots"]]
    data["splines"] = splines
    for phase in data["phases"][1:]:
        phase["start"] -= end - start
        phase["end"] -= end - start


def change_action(data: Data) -> None:
    phase = data["phases"][0]
    phase["args"][3] = "left"
    phase["action"] = "step(c.A, c.B, left, left)"


def change_label(data: Data) -> None:
    data["phases"][0]["action"] = "step(c.A, c.B, left, left)"


def change_place(data: Data) -> None:
    data["phases"][0]["place"]["line"] += 1


def change_format(data: Data) -> None:
    data["format"] = "tamplang-plan/0"


def swap_phases(data: Data) -> None:
    for key in ("action", "rule", "args"):
        a, b = data["phases"][0], data["phases"][1]
        a[key], b[key] = b[key], a[key]


def drop_mode(data: Data) -> None:
    data["phases"][0]["mode"] = []


def drop_literal(data: Data) -> None:
    data["phases"][2]["literals"].pop()


def drop_added(data: Data) -> None:
    data["phases"][0]["added"] = []


def drop_final(data: Data) -> None:
    data["final_mode"] = []


def change_shape(data: Data) -> None:
    data["bodies"][2]["shape"]["size"] = [0.001]


def change_link(data: Data) -> None:
    data["modules"][0]["links"][2]["shape"]["size"][0] = 0.001


def drop_links(data: Data) -> None:
    data["modules"][0]["links"] = []


def change_limits(data: Data) -> None:
    data["modules"][0]["joints"][0]["upper"] = 100.0


def move_body(data: Data) -> None:
    data["bodies"][0]["pose"][0] += 0.05


def rename_module(data: Data) -> None:
    data["modules"][0]["name"] = data["tracks"][0]["name"] = "d"


def change_text(data: Data) -> None:
    data["task"]["sources"][0]["text"] += " "


def change_text_and_hash(data: Data) -> None:
    source = data["task"]["sources"][0]
    source["text"] = source["text"].replace("at (0.5 m, 0, 0)", "at (0.6 m, 0, 0)")
    source["sha256"] = hashlib.sha256(source["text"].encode()).hexdigest()


def break_text_and_hash(data: Data) -> None:
    source = data["task"]["sources"][0]
    source["text"] = source["text"].replace("task hop()", "task hop(")
    source["sha256"] = hashlib.sha256(source["text"].encode()).hexdigest()


def change_goal(data: Data) -> None:
    source = data["task"]["sources"][0]
    source["text"] = source["text"].replace("goal (shown ball)", "goal (on right c.B)")
    data["task"]["goal"] = "(on right c.B)"
    source["sha256"] = hashlib.sha256(source["text"].encode()).hexdigest()


def drop_source(data: Data) -> None:
    data["task"]["sources"].pop()


def drop_sources(data: Data) -> None:
    data["task"]["sources"] = []


def change_task(data: Data) -> None:
    data["task"]["name"] = "hip"


def put_nan(data: Data) -> None:
    track(data)["poses"][10][0] = math.nan


def put_infinity(data: Data) -> None:
    data["splines"][0]["values"][3][2] = math.inf


def drop_row(data: Data) -> None:
    track(data)["joints"].pop()


def short_row(data: Data) -> None:
    track(data)["poses"][7].pop()


def short_pose(data: Data) -> None:
    """Of the ball, which has a track."""
    data["bodies"][2]["pose"].pop()


def drop_track(data: Data) -> None:
    data["tracks"] = []


def drop_body_track(data: Data) -> None:
    data["body_tracks"] = []


def stretch_quaternion(data: Data) -> None:
    track(data)["poses"][3][3:] = [0.0, 0.0, 0.0, 0.0]


def time_backwards(data: Data) -> None:
    data["times"][5] = data["times"][8]


def no_times(data: Data) -> None:
    data["times"] = []


def hurry(data: Data) -> None:
    """The same motion in a tenth of the time."""
    data["times"] = [t / 10 for t in data["times"]]
    for phase in data["phases"]:
        phase["start"] /= 10
        phase["end"] /= 10
    for spline in data["splines"]:
        spline["knots"] = [k / 10 for k in spline["knots"]]


def drop_spline(data: Data) -> None:
    data["splines"].pop()


def change_spline(data: Data) -> None:
    data["splines"][1]["values"][5][1] += 0.05


def move_resting_body(data: Data) -> None:
    """A slab slides away and comes back."""
    poses = [list(data["bodies"][1]["pose"]) for _ in data["times"]]
    for index in range(20, 30):
        poses[index][1] += 0.1
    data["body_tracks"].append({"name": "right", "first": 0, "poses": poses})


def drop_ball_early(data: Data) -> None:
    """The held ball stays behind by a centimetre."""
    for pose in data["body_tracks"][0]["poses"][-50:]:
        pose[2] -= 0.01


def drop_last_phase(data: Data) -> None:
    end = data["phases"].pop()["start"]
    count = data["times"].index(end) + 1
    data["times"] = data["times"][:count]
    for item in data["tracks"]:
        for field in ("poses", "joints"):
            item[field] = item[field][:count]
    data["body_tracks"] = [p for p in data["body_tracks"] if p["first"] < count]
    data["splines"] = [s for s in data["splines"] if s["from"] != 3]


CASES: list[tuple[Callable[[Data], None], str]] = [
    (move_sample, "sample_m"),
    (move_joint, "spline_rad"),
    (move_joint_and_spline, "start_rad"),
    (delete_phase, "times"),
    (delete_phase_with_samples, "action"),
    (change_action, "position_m"),
    (change_label, "action"),
    (change_place, "action"),
    (change_format, "structure"),
    (swap_phases, "action"),
    (drop_mode, "literals"),
    (drop_literal, "literals"),
    (drop_added, "literals"),
    (drop_final, "literals"),
    (change_shape, "scene"),
    (change_link, "scene"),
    (drop_links, "scene"),
    (change_limits, "scene"),
    (move_body, "scene"),
    (rename_module, "scene"),
    (change_text, "source"),
    (change_text_and_hash, "scene"),
    (break_text_and_hash, "source"),
    (change_goal, "goal"),
    (drop_source, "source"),
    (drop_sources, "source"),
    (change_task, "source"),
    (put_nan, "not finite"),
    (put_infinity, "structure"),
    (drop_row, "structure"),
    (short_row, "not finite"),
    (short_pose, "structure"),
    (drop_track, "structure"),
    (drop_body_track, "sample_m"),
    (stretch_quaternion, "quaternion"),
    (time_backwards, "times"),
    (no_times, "times"),
    (hurry, "joint_speed_rad_s"),
    (drop_spline, "spline_rad"),
    (change_spline, "spline_rad"),
    (move_resting_body, "rest"),
    (drop_ball_early, "sample_m"),
    (drop_last_phase, "goal"),
]


@pytest.mark.parametrize(("change", "kind"), CASES, ids=[c.__name__ for c, _ in CASES])
def test_tampered_plan_is_refused(hop: Plan, change: Callable[[Data], None], kind: str) -> None:
    verdict = verify(changed(hop, change))
    assert not verdict.verified
    assert kind in {f.kind for f in verdict.failures}, verdict.failures
    assert all(f.message for f in verdict.failures)


def test_swapped_modules_are_refused(pair: Plan) -> None:
    def swap(data: Data) -> None:
        first, second = data["tracks"]
        first["name"], second["name"] = second["name"], first["name"]

    assert verify(pair).verified
    verdict = verify(changed(pair, swap))
    assert {"start_m"} <= {f.kind for f in verdict.failures}
    assert any("c[1]" in f.between for f in verdict.failures)


def test_failures_name_time_and_things(hop: Plan) -> None:
    failure = next(f for f in verify(changed(hop, move_sample)).failures if f.kind == "sample_m")
    assert failure.time == pytest.approx(hop.times[40])
    assert failure.amount == pytest.approx(0.01, abs=1e-6) and failure.unit == "m"
    assert failure.between == ["left", "c.A"]
    assert "a sample of c is not where left puts it" in failure.message


# --- any number, anywhere ----------------------------------------------------------------------------------------

CHECKED = ("modules", "bodies", "times", "tracks", "body_tracks", "splines")
Keys = tuple[str | int, ...]


def leaves(data: object, path: Keys = ()) -> list[Keys]:
    """Paths to all numbers that the checker has to know better."""
    if isinstance(data, dict):
        return [p for key, value in data.items() for p in leaves(value, (*path, key))]
    if isinstance(data, list):
        return [p for index, value in enumerate(data) for p in leaves(value, (*path, index))]
    return [path] if isinstance(data, int | float) and not isinstance(data, bool) else []


@pytest.fixture(scope="module")
def numbers(hop: Plan) -> dict[str, list[Keys]]:
    data = msgspec.to_builtins(hop)
    return {part: leaves(data[part], (part,)) for part in CHECKED}


@settings(max_examples=50, deadline=None, phases=[Phase.generate], suppress_health_check=list(HealthCheck))
@given(draw=st.data())
def test_any_changed_number_is_refused(hop: Plan, numbers: dict[str, list[Keys]], draw: st.DataObject) -> None:
    data = msgspec.to_builtins(hop)
    part = draw.draw(st.sampled_from(CHECKED))
    path = numbers[part][draw.draw(st.integers(0, len(numbers[part]) - 1))]
    change = draw.draw(st.sampled_from([0.05, -0.05, 3.0, math.nan, math.inf, -1e12]))
    target: Any = data
    for key in path[:-1]:
        target = target[key]
    number = target[path[-1]]
    target[path[-1]] = number + 3 if isinstance(number, int) else number + change
    assert not verify(msgspec.convert(data, Plan)).verified


@settings(max_examples=30, deadline=None, phases=[Phase.generate], suppress_health_check=list(HealthCheck))
@given(draw=st.data())
def test_any_dropped_entry_is_refused(hop: Plan, draw: st.DataObject) -> None:
    data = msgspec.to_builtins(hop)
    lists = [item for part in (*CHECKED, "phases", "final_mode") for item in lists_in(data[part])]
    chosen = draw.draw(st.sampled_from(range(len(lists))))
    del lists[chosen][draw.draw(st.integers(0, len(lists[chosen]) - 1))]
    assert not verify(msgspec.convert(data, Plan)).verified


def lists_in(data: object) -> list[list[Any]]:
    children = data.values() if isinstance(data, dict) else data if isinstance(data, list) else []
    own = [data] if isinstance(data, list) and data else []
    return own + [found for child in children for found in lists_in(child)]
