"""The simulated world, and what the checker says of it: each has its own evaluation of courses."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamplang.compiler import ir
from tamplang.compiler.pipeline import compile_text
from tamplang.runtime.simulation.actuators import Noise
from tamplang.runtime.simulation.braking import braked, first_part, reversed_path, stopped, waiting, within_limits
from tamplang.runtime.simulation.predicted_clearance import signed_distance
from tamplang.runtime.simulation.sensing import Sensing
from tamplang.runtime.simulation.world import Interval, SimulatedWorld, carried, spline_values
from tamplang.runtime.skeleton import PhasePath
from tamplang.runtime.verify.happenings import Course

SCENE = """
import std.crawler
import std.rules

task drifting() {
    base ground: box(2 m, 2 m, 0.05 m) at (0, 0, 0)
    base plate: box(0.4 m, 0.4 m, 0.05 m) at (0, 0, 0.3 m)
    object target: sphere(0.04 m) at (0.2 m, 0.3 m, 1.1 m)
    fact (grippable target)
    moves plate along (10 cm, 0, 0), (0, 10 cm, 0) at 2 cm/s and back
    disturb target by (0, 0, 5 cm) at 3 s
    crawler c: A on plate
    goal (held target)
}
"""


@pytest.fixture(scope="module")
def problem() -> ir.Problem:
    return compile_text(SCENE, "drifting.tamp", "drifting")[0]


points = st.tuples(*[st.floats(-1.0, 1.0)] * 3)


@given(
    ways=st.lists(st.tuples(st.lists(points, min_size=1, max_size=3), st.floats(0.0, 0.5), st.booleans()), max_size=3),
    times=st.lists(st.floats(0.0, 30.0), min_size=1, max_size=8),
)
@settings(max_examples=40, deadline=None)
def test_planner_and_checker_agree_on_courses(
    problem: ir.Problem, ways: list[tuple[list[tuple[float, float, float]], float, bool]], times: list[float]
) -> None:
    courses = tuple(
        ir.Course("plate", 5.0 * k, tuple(way), round(speed, 3), returns)
        for k, (way, speed, returns) in enumerate(ways)
    )
    world = SimulatedWorld(replace(problem, world=replace(problem.world, courses=courses)))
    if not courses:
        assert world.at(1.0) == {}
        return
    own = Course(np.array(problem.world.bodies["plate"].pose[:3]), courses)
    assert world.body_poses("plate", np.array(times))[:, :3] == pytest.approx(own.at(np.array(times)), abs=1e-9)


def test_back_and_forth_and_jumps(problem: ir.Problem) -> None:
    world = SimulatedWorld(problem)
    assert world.at(5.0)["plate"][:3] == pytest.approx([0.1, 0.0, 0.3])
    turn = (0.1 + math.hypot(0.1, 0.1)) / 0.02  # every point is measured from where the plate starts
    assert world.at(turn)["plate"][:3] == pytest.approx([0.0, 0.1, 0.3])
    assert world.at(2.0 * turn)["plate"][:3] == pytest.approx([0.0, 0.0, 0.3])
    assert world.at(2.999)["target"][2] == pytest.approx(1.1)
    assert world.at(3.0)["target"][2] == pytest.approx(1.15)


def test_a_robot_goes_where_its_plate_goes(problem: ir.Problem) -> None:
    world = SimulatedWorld(problem)
    now = world.reached.configuration
    joints = {"c": now.modules["c"][None, 7:]}
    poses = carried(problem, world.reached.mode, joints, now, {"plate": world.body_poses("plate", np.array([4.0]))})
    assert poses["c"][0, :3] - now.modules["c"][:3] == pytest.approx([0.08, 0.0, 0.0])


def swing(problem: ir.Problem, seconds: float) -> PhasePath:
    state = SimulatedWorld(problem).reached.configuration.modules["c"]
    share = np.linspace(0.0, 1.0, 21)[:, None]
    rows = np.tile(state, (21, 1))
    rows[:, 7:] += (3 * share**2 - 2 * share**3) * np.array([0.6, -0.4, 0.3, 0.5, 0.0, 0.2, 0.1])
    return PhasePath({"c": rows}, {}, seconds)


@pytest.mark.parametrize("seconds", [0.3, 1.0, 1.7])
def test_braking_stays_on_the_way_and_within_limits(problem: ir.Problem, seconds: float) -> None:
    path = swing(problem, 2.0)
    assert within_limits(problem.world, path)
    slowed = braked(problem.world, path, seconds)
    assert within_limits(problem.world, slowed)
    start, step = path.modules["c"][0, 7:], path.modules["c"][-1, 7:] - path.modules["c"][0, 7:]
    along = (slowed.modules["c"][:, 7:] - start) @ step / (step @ step)
    assert np.all(np.diff(along) > -1e-9) and 0.0 < along[-1] < 1.0
    assert slowed.modules["c"][:, 7:] == pytest.approx(start + along[:, None] * step, abs=1e-6)
    assert slowed.duration > seconds


@pytest.mark.parametrize("seconds", [0.02, 0.1, 0.3, 1.0, 1.9])
def test_a_robot_rests_when_something_breaks_down_within_all_limits(problem: ir.Problem, seconds: float) -> None:
    path = swing(problem, 2.0)
    found = stopped(problem.world, path, seconds)
    assert found.duration == pytest.approx(seconds)
    assert within_limits(problem.world, found)
    start, step = path.modules["c"][0, 7:], path.modules["c"][-1, 7:] - path.modules["c"][0, 7:]
    along = (found.modules["c"][:, 7:] - start) @ step / (step @ step)
    assert np.all(np.diff(along) > -1e-9)
    assert along[-1] > 0.3 * seconds**2 / 4.0 or seconds < 0.2
    speeds = spline_values(found.modules["c"][:, 7:], seconds, np.array([0.0, seconds]), 1)
    assert speeds == pytest.approx(np.zeros((2, 7)), abs=1e-9)


def test_going_back_and_going_again(problem: ir.Problem) -> None:
    path = swing(problem, 2.0)
    back = reversed_path(problem.world, path, 0.5)
    assert back.modules["c"][0] == pytest.approx(path.modules["c"][-1])
    assert back.modules["c"][-1] == pytest.approx(first_part(path, 0.5).modules["c"][-1])
    assert within_limits(problem.world, back)


def test_velocities_are_read_off_the_last_looks() -> None:
    sensing = Sensing(0.0, np.random.default_rng(0))
    pose = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
    sensing.look(0.0, {"b": pose})
    assert not sensing.velocity("b").any()
    for k in range(1, 5):
        pose = pose + np.array([0.002, 0, 0, 0, 0, 0, 0])
        sensing.look(0.1 * k, {"b": pose})
    assert sensing.velocity("b") == pytest.approx([0.02, 0.0, 0.0])
    assert sensing.foreseen("b", pose, np.array([1.4]))[0, 0] == pytest.approx(0.028)
    sensing.look(0.5, {"b": pose + np.array([0.3, 0, 0, 0, 0, 0, 0])})  # someone pushed it
    sensing.look(0.6, {"b": pose + np.array([0.3, 0, 0, 0, 0, 0, 0])})
    sensing.look(0.7, {"b": pose + np.array([0.3, 0, 0, 0, 0, 0, 0])})
    assert sensing.velocity("b") == pytest.approx(np.zeros(3), abs=1e-9)


def test_planning_knows_only_what_was_seen_before_it_began() -> None:
    sensing = Sensing(0.0, np.random.default_rng(0))
    pose = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
    for k in range(11):  # to and fro: it turns at 0.5 s
        at = pose + np.array([0.02 * min(0.1 * k, 1.0 - 0.1 * k), 0, 0, 0, 0, 0, 0])
        sensing.look(0.1 * k, {"b": at})
    assert sensing.foreseen("b", pose, np.array([1.0, 2.0]))[:, 0] == pytest.approx([0.0, -0.02])
    sensing.known = 0.4
    assert sensing.foreseen("b", pose, np.array([1.0, 2.0]))[:, 0] == pytest.approx([0.02, 0.04])
    assert sensing.foreseen("b", pose, np.array([2.0]), newest=True)[:, 0] == pytest.approx([-0.02])


def test_noise_is_seeded() -> None:
    def read(seed: int) -> float:
        pose = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
        return float(Sensing(1e-3, np.random.default_rng(seed)).look(0.0, {"b": pose})["b"][0])

    assert read(1) == read(1) != read(2)


@pytest.mark.parametrize(
    ("shape", "point", "distance"),
    [
        (ir.Shape("box", (2.0, 2.0, 2.0)), (2.0, 2.0, 0.0), math.sqrt(2.0)),
        (ir.Shape("box", (2.0, 2.0, 2.0)), (0.9, 0.0, 0.0), -0.1),
        (ir.Shape("sphere", (0.5,)), (1.0, 0.0, 0.0), 0.5),
        (ir.Shape("capsule", (0.5, 2.0)), (0.0, 0.0, 2.0), 0.5),
        (ir.Shape("cylinder", (0.5, 2.0)), (1.5, 0.0, 0.0), 1.0),
        (ir.Shape("cylinder", (0.5, 2.0)), (0.0, 0.0, 0.8), -0.2),
    ],
)
def test_signed_distances(shape: ir.Shape, point: tuple[float, float, float], distance: float) -> None:
    assert float(signed_distance(shape, np.array(point))) == pytest.approx(distance)


def test_the_next_motion_starts_where_the_drives_came_to(problem: ir.Problem) -> None:
    world = SimulatedWorld(problem, Noise(0.0, 1e-3, 2.0), 5)
    path = swing(problem, 2.0)
    action, mode = ir.Action("grasp", ()), world.reached.mode
    first = world.carry_out(Interval(action, mode, frozenset(), path, False), 101)
    came_to = world.reached.configuration.modules["c"][7:]
    off = came_to - path.modules["c"][-1, 7:]
    assert 1e-5 < np.abs(off).max() < 2e-3
    assert first.driven["c"][-1] == pytest.approx(came_to) and first.joints["c"][-1] == pytest.approx(came_to)
    assert first.joints["c"][0] == pytest.approx(first.commanded["c"][0])
    assert within_limits(problem.world, first.interval.path)
    back = reversed_path(problem.world, path, 1.0)
    second = world.carry_out(Interval(action, mode, frozenset(), back, False), 101)
    assert second.joints["c"][0] == pytest.approx(came_to, abs=1e-12)
    assert np.abs(second.driven["c"] - second.commanded["c"]).max() < 5e-3
    done = world.carry_out(Interval(action, mode, frozenset(), path, True), 101)
    assert done.joints["c"][-1] == pytest.approx(path.modules["c"][-1, 7:]) != pytest.approx(done.driven["c"][-1])
    rest = world.carry_out(Interval(action, mode, frozenset(), waiting(world.reached.configuration, 1.0), False), 21)
    assert np.ptp(rest.joints["c"], axis=0).max() == 0.0
