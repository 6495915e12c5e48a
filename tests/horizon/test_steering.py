"""Motions that are led to what they meet, and how well the way of a body is known from looks."""

from __future__ import annotations

import numpy as np
import pytest

from tamplang.compiler import ir
from tamplang.compiler.pipeline import compile_text
from tamplang.runtime.simulation.braking import within_limits
from tamplang.runtime.simulation.sensing import Sensing
from tamplang.runtime.simulation.settings import SIMULATION
from tamplang.runtime.simulation.steering import Steering
from tamplang.runtime.simulation.world import SimulatedWorld, spline_values
from tamplang.runtime.skeleton import Array, Phase, PhasePath

SCENE = """
import std.crawler
import std.rules

task drifting() {
    base ground: box(2 m, 2 m, 0.05 m) at (0, 0, 0)
    object target: sphere(0.04 m) at (0.2 m, 0.3 m, 0.8 m)
    fact (grippable target)
    moves target along (1 m, 0, 0) at 1 mm/s
    crawler c: A on ground
    goal (held target)
}
"""


@pytest.fixture(scope="module")
def problem() -> ir.Problem:
    return compile_text(SCENE, "drifting.tamp", "drifting")[0]


def steering_of(problem: ir.Problem, turn: Array) -> tuple[Steering, PhasePath]:
    """What steers a grasp, during which the joints of the crawler turn by `turn` `(7,)` in two seconds."""
    world = SimulatedWorld(problem)
    before = world.reached.configuration
    share = np.linspace(0.0, 1.0, 21)[:, None]
    rows = np.tile(before.modules["c"], (21, 1))
    rows[:, 7:] += (10.0 * share**3 - 15.0 * share**4 + 6.0 * share**5) * turn
    path = PhasePath({"c": rows}, {}, 2.0)
    phase = Phase(ir.Action("grasp", ()), world.reached.mode, frozenset({("touch", "c.B", "target")}))
    return Steering(problem, phase, path, before, {"target": before.bodies["target"]}), path


def test_a_motion_is_led_to_where_its_target_will_be(problem: ir.Problem) -> None:
    steering, path = steering_of(problem, np.array([0.6, -0.4, 0.3, 0.5, 0.0, 0.2, 0.1]))
    aim = np.array(problem.world.bodies["target"].pose)
    aim[:3] += [0.003, -0.004, 0.0]
    assert steering.off(path, {"target": aim}) == pytest.approx(0.005)
    led = steering.steered(path, 1.5, {"target": aim})
    assert led is not None and steering.off(led, {"target": aim}) < 1e-4
    assert within_limits(problem.world, led) and led.duration == path.duration
    early, ends = np.linspace(0.0, 1.4, 50), np.array([0.0, 2.0])
    one, other = (p.modules["c"][:, 7:] for p in (path, led))
    assert spline_values(other, 2.0, early) == pytest.approx(spline_values(one, 2.0, early), abs=2e-4)
    assert spline_values(other, 2.0, ends, 1) == pytest.approx(np.zeros((2, 7)), abs=1e-9)
    assert spline_values(other, 2.0, ends, 2) == pytest.approx(np.zeros((2, 7)), abs=1e-6)


def test_joints_that_rest_or_have_no_time_lead_nowhere(problem: ir.Problem) -> None:
    aim = np.array(problem.world.bodies["target"].pose)
    aim[:3] += [0.003, -0.004, 0.0]
    steering, path = steering_of(problem, np.zeros(7))
    assert steering.steered(path, 0.5, {"target": aim}) is None
    steering, path = steering_of(problem, np.array([0.6, -0.4, 0.3, 0.5, 0.0, 0.2, 0.1]))
    assert steering.steered(path, 1.97, {"target": aim}) is None


def looked_at(sensing: Sensing, ways: list[tuple[float, list[float]]], begin: float = 0.0) -> Array:
    """Look at a body that goes for some seconds at each of some velocities; where it comes to."""
    at, time = np.zeros(3), begin
    for seconds, velocity in ways:
        for _ in range(round(seconds / SIMULATION.sensing_period)):
            sensing.look(time, {"b": np.array([*at, 0.0, 0.0, 0.0, 1.0])})
            at, time = at + SIMULATION.sensing_period * np.array(velocity), time + SIMULATION.sensing_period
    return at


@pytest.mark.parametrize("seed", range(5))
def test_slow_ways_and_turns_are_told_from_noise(seed: int) -> None:
    sensing = Sensing(2e-4, np.random.default_rng(seed))
    looked_at(sensing, [(3.0, [1e-3, 0.0, 0.0])])
    assert sensing.velocity("b") == pytest.approx([1e-3, 0.0, 0.0], abs=1.5e-4)
    sensing = Sensing(2e-4, np.random.default_rng(seed))
    at = looked_at(sensing, [(3.0, [0.0, 0.0, 2e-3]), (0.9, [0.0, 0.0, -2e-3])])
    assert sensing.velocity("b")[2] == pytest.approx(-2e-3, abs=5e-4)
    pose = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
    assert sensing.foreseen("b", pose, np.array([4.1]))[0, 2] == pytest.approx(at[2] - 4e-4, abs=3e-4)


def test_no_speed_is_read_off_a_push() -> None:
    sensing = Sensing(0.0, np.random.default_rng(0))
    looked_at(sensing, [(1.0, [0.0, 0.0, 0.0])])
    pushed = np.array([0.3, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
    sensing.look(1.0, {"b": pushed})
    assert not sensing.velocity("b").any() and sensing.last("b")[0] == 0.3
    sensing.look(1.05, {"b": pushed + np.array([0.01, 0, 0, 0, 0, 0, 0])})
    assert sensing.velocity("b") == pytest.approx([0.2, 0.0, 0.0])  # it was no push but a fast body
