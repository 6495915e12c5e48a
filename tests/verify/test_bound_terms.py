"""Motions in which one term of the bounds decides: without it the bound would lie below the truth."""

from __future__ import annotations

import numpy as np
import pytest

from tamplang.compiler import ir
from tamplang.runtime.planner.plan_assembly import module_record
from tamplang.runtime.verify.bounds import Bounds, Rates
from tamplang.runtime.verify.geometry import Array, Frames, frames
from tamplang.runtime.verify.happenings import Happenings
from tamplang.runtime.verify.kinematics import Kinematics, place
from tamplang.runtime.verify.links import Hold, Links
from tamplang.runtime.verify.sampler import IDENTITY, Grid, Placement, Sampler
from tamplang.runtime.verify.splines import Spline

POSE = tuple(IDENTITY)
KNOTS = np.linspace(0.0, 1.0, 21)
TURN, SLIDE = 1.5, 0.8
"""Radians and metres per second."""
Node = tuple[str, int]


def module(name: str, *kinds: str) -> ir.Module:
    """Joints one after the other, all with their origin at that of the module: turning about z, sliding along x."""
    axes = {"revolute": (0.0, 0.0, 1.0), "prismatic": (1.0, 0.0, 0.0)}
    joints = tuple(
        ir.Joint(f"j{k}", kind, k - 1, POSE, axes[kind], -9.0, 9.0, 0.0, 99.0) for k, kind in enumerate(kinds)
    )
    end = ir.Effector("E", "effector", -1, POSE, None)
    return ir.Module(name, ir.ModuleType(name, joints, (end,), ()), POSE, (0.0,) * len(kinds))


def sampled(values: dict[ir.Module, Array]) -> Sampler:
    """Modules whose frames rest in the world, and whose joints go through `values` `(21, n)` at the KNOTS."""
    modules = {m.name: m for m in values}
    curves = {(m.name, 0): Spline(KNOTS, rows) for m, rows in values.items()}
    holds = {n: Hold(n, f"{n}.E", "", frames(POSE)) for n in modules}
    kinematics = {n: Kinematics(module_record(m)) for n, m in modules.items()}
    ends = np.array([0.0, 1.0])
    poses = {n: np.array([POSE, POSE]) for n in modules}
    motion = place(ends, [(0, 1)], poses, {n: curves[n, 0](ends) for n in modules}, frozenset(modules), kinematics)
    happenings = Happenings({}, (), {})
    return Sampler(ir.World(modules, {}), motion, kinematics, happenings, [Links(holds, (), ())], curves)


def seen(placement: Placement, base: Node | None, node: Node, offset: float = 0.0) -> Array:
    """Where the origin of a frame is, `(T, 3)`, in the world or as seen from a point `offset` along the x of a base."""
    count = len(placement.times)
    there = placement.thing(node[0])[node[1]].spread(count)
    if base is None:
        return there.position
    here = placement.thing(base[0])[base[1]].spread(count)
    seat = Frames(here.position + offset * here.rotation[:, :, 0], here.rotation)
    return there.relative_to(seat).position


def off_the_line(points: Array) -> float:
    """How far points at even times get from the straight line between the first and the last."""
    share = np.linspace(0.0, 1.0, len(points))[:, None]
    return float(np.linalg.norm(points - points[0] - share * (points[-1] - points[0]), axis=1).max())


def decided(
    sampler: Sampler, begin: float, end: float, node: Node, base: Node | None, missing: str
) -> tuple[float, float, float]:
    """In one stretch, in metres: how far a frame truly gets off the line, the bound on that, and what the bound would
    be without its term `missing`."""
    grid = Grid(np.array([begin, end]), np.array([True]))
    placement = sampler.at(0, grid.times)
    bounds = Bounds(sampler, 0, grid, placement)
    truth = off_the_line(seen(sampler.at(0, np.linspace(begin, end, 401)), base, node))
    if base is None:
        rates = bounds.of(node)
        left = rates.acceleration - 2.0 * bounds.of((node[0], node[1] - 1)).turn * SLIDE
    else:
        apart = np.linalg.norm(seen(placement, base, node), axis=1)
        seat, rates = bounds.relative(base, 0.0, node, 0.0, apart)
        own: Rates = bounds.between(base, node)[1]
        term = 2.0 * seat.turn * rates.speed
        kept = term if missing == "turning" else rates.acceleration - term
        left = kept + (own.acceleration if missing == "turning" else 0.0)
    return truth, float(bounds.strayed(rates.acceleration)[0]), float(bounds.strayed(left)[0])


def test_what_slides_on_what_turns() -> None:
    """The slider goes through the axis: it has no centrifugal acceleration there, only that of Coriolis."""
    even = np.stack([TURN * KNOTS, SLIDE * (KNOTS - 0.525)], axis=1)
    sampler = sampled({module("table", "revolute", "prismatic"): even})
    truth, bound, without = decided(sampler, 0.5, 0.55, ("table", 1), None, "slid")
    assert without < 0.5 * truth < truth <= bound


def test_what_slides_past_what_turns() -> None:
    """As seen from the turning frame a point that slides in the world past its axis is bent the same way."""
    sampler = sampled({
        module("table", "revolute"): TURN * KNOTS[:, None],
        module("rail", "prismatic"): SLIDE * (KNOTS[:, None] - 0.525),
    })  # fmt: skip
    truth, bound, without = decided(sampler, 0.5, 0.55, ("rail", 0), ("table", 0), "seen")
    assert without < 0.5 * truth < truth <= bound


def test_what_is_far_from_what_starts_to_turn() -> None:
    """A frame that starts from rest hardly turns yet: only its angular acceleration bends the way of what is far."""
    far = np.full((21, 1), 5.0)
    far[-1] = 5.1
    sampler = sampled({module("table", "revolute"): 2.0 * KNOTS[:, None] ** 2, module("rail", "prismatic"): far})
    truth, bound, without = decided(sampler, 0.0, 0.05, ("rail", 0), ("table", 0), "turning")
    assert without < 0.5 * truth < truth <= bound


@pytest.mark.parametrize("begin", [0.05, 0.3, 0.7, 0.9])
def test_bounds_hold_in_all_of_these(begin: float) -> None:
    turning = np.stack([2.0 * KNOTS**2, np.sin(3.0 * KNOTS)], axis=1)
    sampler = sampled({module("table", "revolute", "prismatic"): turning, module("rail", "prismatic"): KNOTS[:, None]})
    for node, base in ((("table", 1), None), (("rail", 0), ("table", 0)), (("rail", 0), ("table", 1))):
        truth, bound, _ = decided(sampler, begin, begin + 0.05, node, base, "slid" if base is None else "seen")
        assert truth <= bound + 1e-12
