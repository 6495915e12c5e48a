"""The bounds on what moves between two instants, against many instants in between."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tamplang.compiler import ir
from tamplang.runtime.planner.plan_assembly import module_record
from tamplang.runtime.verify.bounds import Bounds, Rates
from tamplang.runtime.verify.geometry import Array, Frames, angles, frames
from tamplang.runtime.verify.happenings import Course, Happenings
from tamplang.runtime.verify.kinematics import Kinematics, place
from tamplang.runtime.verify.links import Hold, Links
from tamplang.runtime.verify.sampler import Grid, Sampler
from tamplang.runtime.verify.settling import Slip
from tamplang.runtime.verify.splines import Spline

from .test_measures import random_module

FINE = 30
"""Instants in each stretch."""
END = 1.0


def make(seed: int) -> Sampler:
    """Three trees of joints: `a` stands with an end on a sledge that slides along its course, `b` and `c` are held by
    ends of the one before; all joints move."""
    draw = np.random.default_rng([seed, 11])
    modules = {n: replace(random_module(draw), name=n) for n in "abc"}
    sledge = ir.Body("sledge", "body", ir.Shape("box", (1.0, 1.0, 0.1)), (0.0,) * 6 + (1.0,), False, None)
    world = ir.World(modules, {"sledge": sledge})
    knots, curves = np.linspace(0.0, END, 5), {}
    for name in modules:
        curves[name, 0] = Spline(knots, draw.uniform(-1.0, 1.0, size=(5, 6)))
    holds = {}
    for name, base in zip("abc", ("sledge", *(f"{n}.E{draw.integers(6)}" for n in "ab")), strict=True):
        pose = (*draw.normal(size=3), *Rotation.random(rng=draw).as_quat())
        holds[name] = Hold(name, f"{name}.E{draw.integers(6)}", base, frames(pose))
    kinematics = {n: Kinematics(module_record(m)) for n, m in modules.items()}
    rows = {n: np.array([m.pose, m.pose]) for n, m in modules.items()}
    values = {n: curves[n, 0](np.array([0.0, END])) for n in modules}
    poses = rows | {"sledge": np.array([sledge.pose, sledge.pose])}
    motion = place(np.array([0.0, END]), [(0, 1)], poses, values, frozenset(modules), kinematics)
    way = ir.Course("sledge", 0.1, ((1.0, 0.0, 0.0), (1.0, 1.0, 0.0)), 3.0, True, None)
    happenings = Happenings({"sledge": Course(np.zeros(3), [way])}, (frozenset({"sledge"}),), {})
    return Sampler(world, motion, kinematics, happenings, [Links(holds, (), ())], curves)


def finely(grid: Grid) -> Array:
    """`FINE + 1` instants `(C, FINE + 1)` from each instant to the next."""
    share = np.linspace(0.0, 1.0, FINE + 1)
    return grid.times[:-1, None] + grid.lengths[:, None] * share


def nodes(draw: np.random.Generator) -> tuple[tuple[str, int], tuple[str, int]]:
    one, other = (("abc"[draw.integers(3)], int(draw.integers(-1, 6))) for _ in range(2))
    return one, other


@pytest.mark.parametrize("seed", range(8))
def test_points_stay_near_straight_lines_as_seen_from_any_frame(seed: int) -> None:
    sampler, draw = make(seed), np.random.default_rng(seed)
    grid = sampler.grid(0)
    placement = sampler.at(0, grid.times)
    bounds = Bounds(sampler, 0, grid, placement)
    times = finely(grid)
    between = sampler.at(0, times.ravel())
    share = np.linspace(0.0, 1.0, FINE + 1)[:, None]
    for _ in range(30):
        base, node = nodes(draw)
        seat, point = draw.normal(size=3), draw.normal(size=3)
        if base == node:
            continue

        def seen(placed: Frames, origin: Frames, seat: Array = seat, point: Array = point) -> tuple[Array, Array]:
            here = Frames(origin.position + origin.rotation @ seat, origin.rotation)
            there = placed.position + placed.rotation @ point
            apart = np.linalg.norm(there - here.position, axis=1)
            return Frames(there, placed.rotation).relative_to(here).position, apart

        ends = (placement.thing(name)[joint].spread(len(grid.times)) for name, joint in (node, base))
        _, apart = seen(*ends)
        reach, offset = float(np.linalg.norm(point)), float(np.linalg.norm(seat))
        _, rates = bounds.relative(base, offset, node, reach, apart)
        points, _ = seen(*(between.thing(name)[joint].spread(times.size) for name, joint in (node, base)))
        points = points.reshape(*times.shape, 3)
        line = points[:, :1] + share * (points[:, -1:] - points[:, :1])
        strayed = np.linalg.norm(points - line, axis=2).max(axis=1)
        allowed = np.broadcast_to(bounds.strayed(rates.acceleration), strayed.shape)
        assert (strayed <= allowed + 1e-9)[grid.joined].all()
        speeds = np.linalg.norm(np.diff(points, axis=1), axis=2) / np.diff(times, axis=1)
        assert (speeds.max(axis=1) <= np.broadcast_to(rates.speed, strayed.shape) + 1e-6)[grid.joined].all()


@pytest.mark.parametrize("seed", range(8))
def test_frames_turn_no_faster_than_bounded(seed: int) -> None:
    sampler, draw = make(seed), np.random.default_rng(seed)
    grid = sampler.grid(0)
    bounds = Bounds(sampler, 0, grid, sampler.at(0, grid.times))
    times = finely(grid)
    between = sampler.at(0, times.ravel())
    for _ in range(20):
        node, _ = nodes(draw)
        rates: Rates = bounds.of(node)
        found = between.thing(node[0])[node[1]].spread(times.size).rotation.reshape(*times.shape, 3, 3)
        turned = angles(found[:, 1:].reshape(-1, 3, 3), found[:, :-1].reshape(-1, 3, 3)).reshape(len(times), FINE)
        speeds = turned / np.diff(times, axis=1)
        assert (speeds.max(axis=1) <= np.broadcast_to(rates.turn, len(times)) + 1e-6)[grid.joined].all()


@pytest.mark.parametrize("seed", range(8))
def test_slips_between_instants_are_within_what_is_said(seed: int) -> None:
    sampler = make(seed)
    grid = sampler.grid(0)
    begin = sampler.at(0, grid.times[:1])
    fine = Grid(finely(grid).ravel(), np.ones(finely(grid).size - 1, dtype=bool))
    for own, base in (("c.E2", "a.E4"), ("b.E0", "sledge"), ("a.E1", "c.E5")):
        slip = Slip(sampler, 0, own, base, begin.frame(own).relative_to(begin.frame(base)), (1e-3, 2e-3))
        for measure in (slip.shift, slip.turn):
            most = measure(fine).amounts.reshape(len(grid.lengths), -1).max(axis=1)
            assert (most <= measure(grid).highest + 1e-9)[grid.joined].all()


def test_a_grid_knows_all_knots_and_corners() -> None:
    grid = make(0).grid(0)
    for time in (0.0, 0.1, 0.1 + 1 / 3, 0.1 + 2 / 3, 0.25, 0.5, 0.75, END):
        assert np.abs(grid.times - time).min() < 1e-9
    assert np.diff(grid.times).max() <= 0.25 / 8 + 1e-9 and grid.joined.all()


def test_chains_of_hundreds_of_joints_are_followed() -> None:
    sampler, length = make(0), 300
    module = sampler.kinematics["a"]
    names = [f"m{k}" for k in range(length)]
    world = ir.World({n: replace(random_module(np.random.default_rng(0)), name=n) for n in names}, {})
    holds = {n: Hold(n, n, f"m{k - 1}.E5" if k else "", frames((0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 1.0)))
             for k, n in enumerate(names)}  # fmt: skip
    still = np.zeros((2, 6))
    rows = {n: np.tile((0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0), (2, 1)) for n in names}
    kinematics = {n: module for n in names}
    times = np.array([0.0, END])
    motion = place(times, [(0, 1)], rows, {n: still for n in names}, frozenset(names), kinematics)
    curves = {("m0", 0): sampler.curves["a", 0]}
    links = [Links(dict(reversed(holds.items())), (), ())]
    long = Sampler(world, motion, kinematics, Happenings({}, (frozenset(),), {}), links, curves)
    grid = long.grid(0)
    placement = long.at(0, grid.times)
    assert not long.rests(names[-1], 0) and len(placement.frame(names[-1])) == len(grid.times)
    assert Bounds(long, 0, grid, placement).of((names[-1], 5)).speed.max() > 0.0
