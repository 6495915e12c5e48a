"""What a plan does between its samples is checked on the motion itself, however its file is stamped."""

from __future__ import annotations

from typing import Any

import msgspec
import numpy as np
import pytest

from tamplang.runtime.budget import Budget, OutOfTime
from tamplang.runtime.plan import Plan
from tamplang.runtime.verify import verify

from .motions import Maker
from .stamping import HIDING, Stamps, crowded, even, random_stamps, sampler_of, stamped, uneven

Data = dict[str, Any]

STAMPS: dict[str, Stamps] = {
    "two": even(2), "sparse": even(7), "dense": even(400), "uneven": uneven, "crowded": crowded, "random": random_stamps
}  # fmt: skip
OWN = {"sample_m", "sample_rad", "spline_rad", "quaternion", "jump_m", "jump_rad", "time_s", "rest_m", "rest_rad"}
"""Figures about the samples themselves."""


@pytest.mark.parametrize("stamps", STAMPS.values(), ids=list(STAMPS))
def test_a_good_plan_is_good_however_it_is_stamped(hop: Plan, stamps: Stamps) -> None:
    expected, verdict = verify(hop), verify(stamped(hop, stamps))
    assert verdict.verified, verdict.failures
    for kind in expected.worst.keys() - OWN:
        assert verdict.worst[kind] == pytest.approx(expected.worst[kind], rel=1e-6, abs=1e-7), kind


# --- what samples hide ---------------------------------------------------------------------------------------------

PLATE = """
import std.crawler
import std.motion
predicate (waved c: module)
rule wave(c: module, k: 1 .. 2) {
    pre   k = 1 or (waved c)
    post  (waved c)
}
task wave() {
    object slab: box(0.2 m, 0.2 m, 0.05 m) at (0, 0, 0)
    object plate: box(0.3 m, 0.05 m, 0.4 m) at (0.6 m, WHERE, 0.225 m)
    crawler c: A on slab
    goal (waved c)
}
"""
LEVEL = np.array([0.0, np.pi / 2, 0.0, 0.0, 0.0, 0.0, 0.0])
TURN = np.eye(7)[0]


def swing(samples: int, where: str = "0.3 m", seconds: float = 12.0) -> Plan:
    """A stretched arm turns there and back again by 1 rad; where = 0.3 m puts a plate of 5 cm into its way."""
    maker = Maker(PLATE.replace("WHERE", where), "wave")
    maker.phase("wave", ("c", "1"), [LEVEL])
    ways = 0.5 - 0.5 * np.cos(np.linspace(0.0, 2.0 * np.pi, 201)[1:])
    maker.phase("wave", ("c", "2"), [LEVEL + way * TURN for way in ways], seconds=seconds, samples=samples)
    return maker.plan()


@pytest.mark.parametrize("stamps", HIDING.values(), ids=list(HIDING))
@pytest.mark.parametrize("samples", [2, 20, 300])
def test_a_swing_through_a_plate_is_seen_whatever_the_samples_show(stamps: Stamps, samples: int) -> None:
    verdict = verify(stamped(swing(samples), stamps))
    assert {f.kind for f in verdict.failures} == {"penetration_m"}, verdict.failures
    assert max(f.amount for f in verdict.failures) > 0.01
    assert all("plate" in f.between for f in verdict.failures)


@pytest.mark.parametrize("samples", [2, 20, 300])
def test_the_same_swing_beside_the_plate_is_good(samples: int) -> None:
    assert verify(stamped(swing(samples, "-0.3 m"), HIDING["crowded"])).verified


def test_a_short_phase_of_ten_thousand_samples(hop: Plan) -> None:
    """Nothing but the time is too short for the way."""
    plan = swing(20, seconds=0.1)
    kinds = {f.kind for f in verify(stamped(plan, [even(5), even(10_000)])).failures}
    assert kinds == {"penetration_m", "joint_speed_rad_s", "joint_acceleration_rad_s2"}
    slow = swing(20, "-0.3 m")
    verdict = verify(stamped(slow, [even(5), even(10_000)]))
    assert verdict.verified
    assert verdict.worst["joint_speed_rad_s"] == pytest.approx(verify(slow).worst["joint_speed_rad_s"])


def test_samples_on_the_spline_at_their_stamps_only(hop: Plan) -> None:
    """A spline of three times as many knots that swings out between the stamps of the file."""
    data = msgspec.to_builtins(swing(20, "-0.3 m"))
    spline = data["splines"][1]
    times = np.linspace(spline["knots"][0], spline["knots"][-1], 61)
    start, end = times[0], times[-1]
    plan = msgspec.convert(data, Plan)
    at = sampler_of(plan).curves["c", 1](times)
    at[:, 0] += np.where(np.arange(61) % 3 == 1, 0.5, 0.0)
    spline["knots"], spline["values"] = times.tolist(), at.tolist()
    wild = msgspec.convert(data, Plan)
    assert "spline_rad" in {f.kind for f in verify(wild).failures}
    curve = sampler_of(wild).curves["c", 1]
    fine = np.linspace(start, end, 20_001)
    same = fine[np.abs(curve(fine) - sampler_of(plan).curves["c", 1](fine)).max(axis=1) < 1e-3]
    agreeing = np.unique(np.concatenate([[start], same, [end]]))
    kinds = {f.kind for f in verify(stamped(wild, [even(10), lambda *_: agreeing])).failures}
    assert kinds == {"joint_speed_rad_s", "joint_acceleration_rad_s2"}


def test_samples_do_not_tell_what_rests() -> None:
    """Both ends of a robot that nothing holds any more rest on all samples, and only there."""
    fall = "rule fall(A: gripper) { post not [stable ANY A], not [stand A ANY], not (support A) }"
    maker = Maker(PLATE.replace("WHERE", "-0.3 m") + fall, "wave")
    home = maker.now.modules["c"][7:]
    maker.phase("fall", ("c.A",), [home + 0.1 * np.eye(7)[1], home])
    ways = np.sin(np.linspace(0.0, np.pi, 100))
    maker.phase("wave", ("c", "1"), [home + 0.5 * way * np.eye(7)[1] for way in ways], seconds=20.0)
    plan = maker.plan()
    assert verify(plan).verified, verify(plan).failures
    verdict = verify(stamped(plan, even(2)))
    assert {f.kind for f in verdict.failures} == {"rest"}
    assert "do not tell whether" in verdict.failures[0].message


# --- splines through switches --------------------------------------------------------------------------------------

SEEN = """
import std.crawler
import std.motion
predicate (waved c: module)
motion [seen X: effector] { at switch bottom(X) >= 0 m }
rule wave(c: module, X: effector) {
    pre   not (waved c)
    post  (waved c), [seen X]
}
task wave() {
    object slab: box(2 m, 2 m, 0.05 m) at (0, 0, 0)
    for k in 1 .. 2 {
        crawler c[k]: A on slab at (0, 0.8 m * k - 1.2 m)
    }
    goal forall k in 1 .. 2 { (waved c[k]) }
}
"""


def through(module: int, back: bool) -> Plan:
    """Module c[1] is bound by the first switch, c[2] by the second; one of them moves on through the first, or is just
    about to turn back there."""
    maker = Maker(SEEN, "wave")
    home = maker.now.modules["c[1]"][7:]
    maker.phase("wave", ("c[1]", "c[1].B"), [home])
    maker.phase("wave", ("c[2]", "c[2].B"), [home])
    data = msgspec.to_builtins(maker.plan())
    end = data["phases"][1]["end"]
    knots, shares = np.linspace(0.0, end, 41), np.linspace(0.0, 1.0, 41)
    way = 0.5 - 0.5 * np.cos((2.0 if back else 1.0) * np.pi * shares)
    start = np.array(data["modules"][module - 1]["start"])
    values = start + 0.3 * way[:, None] * np.eye(7)[1]
    data["splines"] = [{
        "module": f"c[{module}]", "from": 0, "until": 1, "knots": knots.tolist(), "values": values.tolist()
    }]  # fmt: skip
    return stamped(msgspec.convert(data, Plan), even(30))


def test_a_spline_goes_through_switches_that_do_not_bind_its_module() -> None:
    verdict = verify(through(2, back=False))
    assert verdict.verified, verdict.failures


def test_a_module_rests_at_switches_that_bind_it() -> None:
    failures = verify(through(1, back=False)).failures
    assert {f.kind for f in failures} == {"switch_rad_s"} and failures[0].between == ["c[1]"]
    assert verify(through(1, back=True)).verified


@pytest.mark.parametrize(("first", "until"), [(-1, 1), (0, 2), (1, 0), (1, 1)])
def test_a_spline_of_other_phases_than_its_knots_is_refused(first: int, until: int) -> None:
    data = msgspec.to_builtins(through(2, back=False))
    data["splines"][0] |= {"from": first, "until": until}
    assert {f.kind for f in verify(msgspec.convert(data, Plan)).failures} & {"structure", "times"}


def test_two_splines_of_one_module_at_once_are_refused() -> None:
    data = msgspec.to_builtins(through(2, back=False))
    spline = data["splines"][0]
    data["splines"].append({**spline, "from": 1, "knots": np.linspace(4.0, 8.0, 41).tolist()})
    assert {f.kind for f in verify(msgspec.convert(data, Plan)).failures} == {"structure"}


# --- scenes that move ----------------------------------------------------------------------------------------------

MOVING = """
import std.crawler
import std.motion
predicate (waved c: module)
rule wave(c: module) {
    pre   not (waved c)
    post  (waved c)
}
task wave() {
    object slab: box(2 m, 2 m, 0.05 m) at (0, 0, 0)
    object sledge: box(0.1 m, 0.1 m, 0.1 m) at (1.5 m, 0, 0.6 m)
    crawler c: A on slab
    EVENT
    goal (waved c)
}
"""


def moving(event: str) -> Plan:
    """A robot stands, for 8 s, in the way of a sledge, or near it; the joints of another event are stuck."""
    maker = Maker(MOVING.replace("EVENT", event), "wave")
    maker.phase("wave", ("c",), [maker.now.modules["c"][7:]], seconds=8.0)
    data, world = msgspec.to_builtins(maker.plan()), maker.problem.world
    data["courses"] = [
        {"body": c.body, "start": c.start, "points": c.points, "speed": c.speed, "returns": c.returns}
        for c in world.courses
    ]
    data["breakdowns"] = [{"module": b.module, "time": b.time, "kind": b.kind} for b in world.breakdowns]
    if world.courses:
        pose = list(world.bodies["sledge"].pose)
        data["body_tracks"] = [{"name": "sledge", "first": 0, "poses": [pose for _ in data["times"]]}]
    return stamped(msgspec.convert(data, Plan), even(2))


@pytest.mark.parametrize(("way", "hit"), [
    ("(-3 m, 0, 0) at 1 m/s from 1 s and back", True),
    ("(-1.2 m, 0, 0), (0, 0, 0) at 2 m/s from 1 s", False),
    ("(-1.5 m, 0, 0), (0, 0, 0) at 2 m/s from 1 s", True),
])  # fmt: skip
def test_a_body_that_comes_and_goes_between_two_samples_is_seen(way: str, hit: bool) -> None:
    verdict = verify(moving(f"moves sledge along {way}"))
    assert {f.kind for f in verdict.failures} == ({"penetration_m"} if hit else set()), verdict.failures


def test_a_body_that_jumps_there_and_back_between_two_samples_is_seen() -> None:
    jumps = "disturb sledge by (-1.5 m, 0, 0) at 3 s\n    disturb sledge by (1.5 m, 0, 0) at 3.001 s"
    assert {f.kind for f in verify(moving(jumps)).failures} == {"penetration_m"}
    assert verify(moving(jumps.replace("-1.5 m", "-1.2 m"))).verified


def test_a_body_that_turns_too_often_is_refused() -> None:
    verdict = verify(moving("moves sledge along (0, 0, 1 mm) at 20 m/s and back"))
    assert {f.kind for f in verdict.failures} == {"undecided"}


def test_stuck_joints_move_not_even_between_samples() -> None:
    plan = moving("fail c at 2 s: locked")
    assert verify(plan).verified, verify(plan).failures
    data = msgspec.to_builtins(plan)
    knots, start = np.linspace(0.0, 8.0, 41), np.array(data["modules"][0]["start"])
    way = 0.5 - 0.5 * np.cos(2.0 * np.pi * np.linspace(0.0, 1.0, 41))
    data["splines"] = [{
        "module": "c", "from": 0, "until": 0, "knots": knots.tolist(),
        "values": (start + 0.3 * way[:, None] * np.eye(7)[1]).tolist(),
    }]  # fmt: skip
    failures = verify(stamped(msgspec.convert(data, Plan), even(2))).failures
    assert "stuck_rad" in {f.kind for f in failures}


# --- sizes ---------------------------------------------------------------------------------------------------------


def test_absurd_sizes_are_refused_at_once(hop: Plan) -> None:
    data = msgspec.to_builtins(hop)
    data["splines"][0]["knots"] = np.linspace(0.0, data["phases"][0]["end"], 10_001).tolist()
    data["splines"][0]["values"] = [data["splines"][0]["values"][0]] * 10_001
    (failure,) = verify(msgspec.convert(data, Plan)).failures
    assert failure.kind == "structure" and "10001 knots" in failure.message
    data = msgspec.to_builtins(hop)
    data["times"] = np.linspace(0.0, 1.0, 500_000).tolist()
    (failure,) = verify(msgspec.convert(data, Plan)).failures
    assert failure.kind == "structure" and "500000 samples" in failure.message


def test_a_hostile_plan_ends_with_the_budget() -> None:
    """Ten thousand knots of a joint that trembles where the arm touches a plate."""
    data = msgspec.to_builtins(stamped(swing(20, "-0.3 m"), [even(10), even(5_000)]))
    spline = data["splines"][1]
    knots = np.linspace(spline["knots"][0], spline["knots"][-1], 10_000)
    values = np.tile(spline["values"][0], (10_000, 1))
    values[1:-1, 0] += 1e-3 * np.random.default_rng(0).uniform(size=9_998)
    spline |= {"knots": knots.tolist(), "values": values.tolist()}
    with pytest.raises(OutOfTime):
        verify(msgspec.convert(data, Plan), Budget(0.3))
