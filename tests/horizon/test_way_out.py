"""What a run does where nothing leads on, and what it foresees so that this seldom happens."""

from __future__ import annotations

import numpy as np
import pytest

from tamplang.compiler import ir
from tamplang.compiler.pipeline import compile_text
from tamplang.runtime.budget import Budget
from tamplang.runtime.planner.lgp import SolveOptions, motion_settings
from tamplang.runtime.seeds import Seed
from tamplang.runtime.simulation.braking import waiting
from tamplang.runtime.simulation.evasion import way_aside
from tamplang.runtime.simulation.failures import Failures
from tamplang.runtime.simulation.monitor import Lookout
from tamplang.runtime.simulation.planning import Planner
from tamplang.runtime.simulation.predicted_clearance import clearances, deepest, nearest
from tamplang.runtime.simulation.route import Route
from tamplang.runtime.simulation.scene_prediction import foreseen_problem
from tamplang.runtime.simulation.sensing import Sensing
from tamplang.runtime.simulation.settings import SIMULATION
from tamplang.runtime.simulation.world import Interval, SimulatedWorld
from tamplang.runtime.skeleton import Phase
from tamplang.runtime.verify.replay import Interpreter

SCENE = """
import std.crawler
import std.rules

task below() {
    base ground: box(2 m, 2 m, 0.05 m) at (0, 0, 0)
    base lid: box(0.4 m, 0.4 m, 0.05 m) at (0, 0, HIGH m)
    moves lid along (0, 0, -10 cm) at 4 mm/s
    object target: sphere(0.04 m) at (0.4 m, 0.3 m, 0.6 m)
    fact (grippable target)
    crawler c: A on ground
    goal (held target)
}
"""


def world_with_a_lid(apart: float) -> SimulatedWorld:
    """A lid that sinks upon the end of a crawler that stands upright, `apart` metres above it."""
    problem = scene(1.5)
    distance = clearances(problem.world, SimulatedWorld(problem).reached.configuration, 2.0)["c", "lid"]
    return SimulatedWorld(scene(1.5 - distance + apart))


def scene(high: float) -> ir.Problem:
    return compile_text(SCENE.replace("HIGH", f"{high:.6f}"), "below.tamp", "below")[0]


def route_in(world: SimulatedWorld) -> Route:
    """With the last second of looks."""
    lookout = Lookout(Sensing(0.0, np.random.default_rng(0)))
    for look in np.arange(0.0, 1.0, SIMULATION.sensing_period):
        lookout.look(world, float(look))
    world.time = 1.0
    action = next(iter(first_actions(world.problem)))
    return Route(world.problem, SolveOptions(), 4, Failures(world.problem), lookout, Budget(30.0), (action,))


def first_actions(problem: ir.Problem) -> list[ir.Action]:
    return list(Interpreter(problem).applicable(problem.init, problem.rules["grasp"]))


@pytest.mark.parametrize(("apart", "seconds", "clear"), [(0.01, 0.5, True), (0.01, 4.0, False), (0.005, 0.5, False)])
def test_a_robot_rests_only_while_nothing_presses_upon_it(apart: float, seconds: float, clear: bool) -> None:
    world = world_with_a_lid(apart)
    route = route_in(world)
    world.reached.configuration.bodies["lid"] = world.at(world.time)["lid"]
    phase = Phase(route.way[0], world.reached.mode, frozenset())
    path = waiting(world.reached.configuration, seconds)
    assert route.is_clear(world, phase, path) is clear
    lid = world.body_poses("lid", np.array([world.time + seconds]))
    own = {"lid": np.tile(lid, (SIMULATION.phase_looks, 1))}
    deep = -nearest(world.problem, world.reached.configuration, phase, path, own)["c", "lid"]
    assert (deep <= SIMULATION.pressed) is clear


def test_what_comes_near_before_the_phase_ends_is_left_where_it_is_seen_from_the_robot() -> None:
    world = world_with_a_lid(0.012)
    now = world.reached.configuration.bodies["lid"]
    sunk = now - np.array([0.0, 0.0, 0.02, 0.0, 0.0, 0.0, 0.0])
    near = foreseen_problem(world.problem, world.reached, {"lid": sunk}, frozenset(), {})
    assert near.world.bodies["lid"].pose[2] == pytest.approx(now[2]) and ("c.B", "lid") in near.touching
    high = now + np.array([0.0, 0.0, 0.02, 0.0, 0.0, 0.0, 0.0])
    far = foreseen_problem(world.problem, world.reached, {"lid": high}, frozenset(), {})
    assert far.world.bodies["lid"].pose[2] == pytest.approx(high[2])
    met = foreseen_problem(world.problem, world.reached, {"lid": sunk}, frozenset({"lid"}), {})
    assert met.world.bodies["lid"].pose[2] == pytest.approx(sunk[2])


def test_a_robot_moves_aside_to_where_it_has_room() -> None:
    world = world_with_a_lid(0.008)
    problem = foreseen_problem(world.problem, world.reached, {}, frozenset(), {})
    skeleton = Planner(SolveOptions()).skeleton(problem, first_actions(problem)[:1])
    assert skeleton is not None
    path = way_aside(skeleton, motion_settings(problem, SolveOptions()), Seed(0), Budget(30.0))
    assert path is not None
    done = world.carry_out(Interval(skeleton.phases[0].action, world.reached.mode, frozenset(), path, False), 21)
    assert done.joints["c"][0] == pytest.approx(problem.world.modules["c"].joints)
    assert ("c", "lid") not in clearances(problem.world, world.reached.configuration, SIMULATION.evasion_room - 5e-3)


def test_what_a_robot_holds_is_looked_at_too() -> None:
    world = world_with_a_lid(0.3)
    now = world.reached.configuration
    tip, lid = now.bodies["lid"].copy(), now.bodies["lid"]
    tip[2] = lid[2] - 0.025 - 0.04 - 0.1  # the target, 10 cm below the lid
    now.bodies["target"] = tip
    mode = world.reached.mode | {("stable", "c.B", "target")}
    phase = Phase(first_actions(world.problem)[0], mode, frozenset())
    sunk = np.linspace(lid, lid - np.array([0.0, 0.0, 0.12, 0.0, 0.0, 0.0, 0.0]), SIMULATION.phase_looks)
    path = waiting(now, 1.0)
    found = nearest(world.problem, now, phase, path, {"lid": sunk})
    assert found["target", "lid"] == pytest.approx(-0.02, abs=1e-6) and ("c", "target") not in found
    assert deepest(world.problem, now, phase, path, {"lid": sunk}) == pytest.approx(0.02, abs=1e-6)


def test_windows_that_failed_are_drawn_anew_a_few_times_with_other_numbers() -> None:
    world = world_with_a_lid(0.3)
    planner = route_in(world).planner

    def drawn() -> np.ndarray:
        window = planner.new_way(world.problem, 1, frozenset(), 0.0, Budget(None))
        assert window is not None
        return window.paths[0].modules["c"]

    first, again = drawn(), drawn()
    assert np.array_equal(first, again), "the same numbers give the same motion"
    assert all(planner.may_redraw() for _ in range(SIMULATION.redraws)) and not planner.may_redraw()
    assert not np.allclose(first, drawn())
    planner.succeeded()
    assert np.array_equal(first, drawn()) and planner.may_redraw()
    planner.status = "infeasible"
    assert not planner.may_redraw(), "what is proved is not tried again"
