"""Ways among samples, and what is near: looked at in boxes first, and the same as looked at one by one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tamplang.runtime.budget import Budget, OutOfTime
from tamplang.runtime.planner.motion.keyframes.sequence import solve_sequence
from tamplang.runtime.planner.motion.phases import proximity, solve_sequence_path
from tamplang.runtime.planner.motion.phases.contact_margins import NEVER
from tamplang.runtime.planner.motion.phases.phase_geometry import Geometry
from tamplang.runtime.planner.motion.phases.proximity import close
from tamplang.runtime.planner.motion.phases.rrt_connect import connect, sampled_starts
from tamplang.runtime.planner.motion.phases.settings import PHASES
from tamplang.runtime.seeds import Seed
from tamplang.runtime.skeleton import Configuration, Skeleton

from .fixtures import box, pick_and_place
from .test_phases_repair import SETTINGS, cart_scene, group_of


@pytest.mark.parametrize("margin", [0.01, 0.2])
def test_nothing_near_is_passed_over(margin: float, monkeypatch: pytest.MonkeyPatch) -> None:
    skeleton = pick_and_place(2)
    sequence = solve_sequence(skeleton, SETTINGS, Seed(0), Budget(20.0))
    batch = group_of(skeleton, sequence.configurations, [1, 3]).batch
    geometry = batch.coarse
    values = batch.start[:, None] + np.random.default_rng(0).normal(0.0, 0.5, (2, 7, batch.start.shape[1]))
    obstacles, pairs = close(geometry, values, margin)
    expected = to_obstacles(geometry, values)
    found = np.zeros(expected.shape, bool)
    found[obstacles.row, obstacles.column, obstacles.phase, obstacles.time] = True
    assert found.any() and np.array_equal(found, expected < margin)
    assert obstacles.clearance == pytest.approx(expected[found][np.argsort(np.argsort(flat(obstacles, found.shape)))])
    assert (pairs.kind != NEVER).all() and (pairs.clearance < margin).all()
    monkeypatch.setattr(proximity, "PHASES", replace(PHASES, many_pairs=0))
    _, by_nodes = close(geometry, values, margin)
    assert len(pairs.row) > 20 or margin < 0.1
    for side in ("row", "phase", "time", "clearance", "kind"):
        assert np.array_equal(getattr(pairs, side), getattr(by_nodes, side))


def flat(found: object, shape: tuple[int, ...]) -> np.ndarray:
    return np.ravel_multi_index((found.row, found.column, found.phase, found.time), shape)


def to_obstacles(geometry: Geometry, values: np.ndarray) -> np.ndarray:
    """All clearances `(spheres, obstacles, phases, times)`; infinite where none is asked for."""
    points = geometry.points.placed(geometry.kinematics.frames(values))
    kinds = geometry.obstacle_kinds
    result = np.full((*kinds.shape, values.shape[1]), np.inf)
    for a, o, k in zip(*np.nonzero(kinds != NEVER), strict=True):
        distance = geometry.shapes.distance_at(points[a : a + 1, :, k], np.array([o]), np.array([k]))[0]
        result[a, o, k] = distance[0] - geometry.radius[a, 0]
    return result


def ring() -> tuple[Skeleton, list[Configuration]]:
    """A long wall with posts on both sides between a cart and its goal."""
    walls = [box("wall", (0.1, 4.0, 0.3), (0.0, 0.0, 0.0))]
    places = [(0.3 * x, 0.3 * y, 0.0) for x in (-2, -1, 1, 2) for y in range(-5, 6)]
    posts = [box(f"post{k}", (0.1, 0.1, 0.3), place) for k, place in enumerate(places)]
    return cart_scene([*walls, *posts], (-1.0, 0.1), (1.0, 0.1))


def test_a_long_way_round_a_wall_among_many_bodies_is_found_soon() -> None:
    soon = solve_sequence_path(*ring(), SETTINGS, Seed(0), Budget(20.0), thorough=False)
    assert soon.feasible, soon.violations
    track = soon.paths[0].modules["arm"][:, 7:]
    assert np.abs(track[:, 1]).max() > 2.0
    again = solve_sequence_path(*ring(), SETTINGS, Seed(0), Budget(20.0), thorough=False)
    assert np.array_equal(track, again.paths[0].modules["arm"][:, 7:])


def test_no_way_leads_out_of_what_is_closed_or_into_what_is_blocked() -> None:
    long, across = (0.8, 0.02, 0.3), (0.02, 0.8, 0.3)
    cage = [box(f"x{at}", across, (at, 0.0, 0.0)) for at in (-0.4, 0.4)]
    cage += [box(f"y{at}", long, (0.0, at, 0.0)) for at in (-0.4, 0.4)]
    closed = group_of(*cart_scene(cage, (0.0, 0.0), (1.0, 0.0)), [0]).batch
    assert sampled_starts(closed, 0, np.random.default_rng(0), Budget(20.0), 5, (3,)) == []
    blocked = group_of(*cart_scene(cage, (0.7, 0.0), (0.4, 0.0)), [0]).batch
    random = np.random.default_rng(0)
    assert sampled_starts(blocked, 0, random, Budget(20.0), 1000, (3,)) == []
    assert random.random() == np.random.default_rng(0).random()


def test_a_spent_budget_ends_the_search_for_a_way() -> None:
    with pytest.raises(OutOfTime):
        sampled_starts(group_of(*ring(), [0]).batch, 0, np.random.default_rng(0), Budget(0.0), 60, (3,))


class Sheet:
    """A square with a wall across it that is so thin that edges pass through it unseen; it ends at y = 1.5."""

    lower, upper = np.full(2, -2.0), np.full(2, 2.0)

    def near(self, goals: np.ndarray) -> np.ndarray:
        return goals

    def ways(self, root: np.ndarray) -> list[np.ndarray]:
        return []

    def advance(self, starts: np.ndarray, goals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return goals, np.ones(len(goals), bool)

    @staticmethod
    def sound(line: np.ndarray) -> np.ndarray:
        before, after = line[:-1], line[1:]
        share = before[:, 0] / np.where(before[:, 0] == after[:, 0], 1.0, before[:, 0] - after[:, 0])
        height = before[:, 1] + share * (after[:, 1] - before[:, 1])
        return np.asarray((before[:, 0] * after[:, 0] > 0.0) | (height > 1.5))


def test_trees_lose_what_hangs_on_edges_that_are_none() -> None:
    ends = np.array([-1.0, 0.0]), np.array([1.0, 0.0])
    blind = connect(Sheet(), *ends, np.random.default_rng(0), Budget(20.0), 400)
    assert blind is not None and not Sheet.sound(blind).all()
    line = connect(Sheet(), *ends, np.random.default_rng(0), Budget(20.0), 400, Sheet.sound)
    assert line is not None and Sheet.sound(line).all()
    assert np.array_equal(line[[0, -1]], ends)


class Hall:
    """A hall of 4 m with three walls, in which a point drives that has limits of 20 m."""

    lower, upper = np.full(2, -20.0), np.full(2, 20.0)

    def near(self, goals: np.ndarray) -> np.ndarray:
        return goals

    def ways(self, root: np.ndarray) -> list[np.ndarray]:
        return []

    def advance(self, starts: np.ndarray, goals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        shares = np.linspace(0.0, 1.0, 41)
        poses = starts[:, None] + shares[:, None] * (goals - starts)[:, None]
        blocked = (np.abs(poses) > 2.0).any(axis=2)
        for at, side in ((-1.0, 1.0), (0.0, -1.0), (1.0, 1.0)):
            blocked |= (np.abs(poses[..., 0] - at) < 0.05) & (side * poses[..., 1] < 1.6)
        until = np.where(blocked.any(axis=1), blocked.argmax(axis=1) - 1, 40)
        return poses[np.arange(len(poses)), until], until == 40


@pytest.mark.parametrize("seed", range(5))
def test_limits_far_wider_than_a_hall_hide_no_way_through_it(seed: int) -> None:
    ends = np.array([-1.5, -1.5]), np.array([1.5, -1.5])
    assert connect(Hall(), *ends, np.random.default_rng(seed), Budget(20.0), 300) is not None


def test_more_slices_find_a_long_way_through_three_walls() -> None:
    walls = [box(f"wall{k}", (0.04, 3.3, 0.3), (k, 0.35 * (-1.0) ** k, 0.0)) for k in (-1, 0, 1)]
    sides = [box(f"side{s}", (4.2, 0.1, 0.3), (0.0, 2.05 * s, 0.0)) for s in (-1, 1)]
    ends = [box(f"end{s}", (0.1, 4.2, 0.3), (2.05 * s, 0.0, 0.0)) for s in (-1, 1)]
    scene = cart_scene([*walls, *sides, *ends], (-1.5, 1.5), (1.5, 1.5))
    finer = solve_sequence_path(*scene, replace(SETTINGS, slices=80), Seed(0), Budget(60.0))
    assert finer.feasible, finer.violations
    track = finer.paths[0].modules["arm"][:, 7:]
    assert np.abs(np.diff(track, axis=0)).sum() > 8.0
