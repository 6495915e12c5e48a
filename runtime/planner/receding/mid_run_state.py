"""The scene in mid-run: what holds and where everything is after some actions, and the same task begun from there.

`rerooted` gives an `ir.Problem` whose start is a state that was reached: everything downstream (successor functions,
bounds, phases, plan files) then works from there. Motion literals that hold are carried as start literals, so that
linked things keep their present relative poses (thesis, section 3.5: free joints of the past become rigid). Functions
of the scene such as `distance` then measure the present poses.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ....compiler import ir
from ....langs.frozen import dataclass
from ...geometry.resampling import resample
from ...geometry.start_contacts import pressed_in, touching
from ...skeleton import Configuration, PhasePath, Skeleton, start_configuration
from ..search.stepper import Stepper


@dataclass(frozen=True, slots=True)
class Reached:
    """A state of a run: logic facts (static ones too, symmetric ones in both orders), motion literals, poses and joint
    values."""

    facts: frozenset[ir.Fact]
    mode: frozenset[ir.Fact]
    configuration: Configuration


def start(problem: ir.Problem) -> Reached:
    """The state before the first action."""
    return Reached(problem.init, problem.init_motion, start_configuration(problem))


def after(
    problem: ir.Problem,
    skeleton: Skeleton,
    paths: Sequence[PhasePath],
    count: int | None = None,
    begin: Reached | None = None,
) -> Reached:
    """The state after the first `count` phases (default: as many as there are paths) of a skeleton that starts at
    `begin` (default: the start of `problem`). Poses follow the joints' splines, as a plan file tells them.

    Raises Inapplicable when an action cannot be done, and MissingLibrary.
    """
    begin = start(problem) if begin is None else begin
    count = len(paths) if count is None else count
    stepper = Stepper(problem)
    facts, mode = begin.facts, begin.mode
    for phase in skeleton.phases[:count]:
        step = stepper.step(facts, mode, phase.action)
        facts, mode = step.facts, step.motion
    return Reached(facts, mode, moved(problem, skeleton, paths[:count], begin.configuration))


def moved(
    problem: ir.Problem, skeleton: Skeleton, paths: Sequence[PhasePath], configuration: Configuration
) -> Configuration:
    """Where everything is after the first `len(paths)` phases, which begin at `configuration`."""
    for phase, path in zip(skeleton.phases, paths, strict=False):
        configuration = resample(problem, phase.mode, path, configuration, 0.0, 1).end(configuration)
    return configuration.copy()


def rerooted(
    problem: ir.Problem,
    facts: frozenset[ir.Fact],
    motion_literals: frozenset[ir.Fact],
    configuration: Configuration,
) -> ir.Problem:
    """The same task, begun from a state: logic facts, motion literals, and where everything is. Joint values are taken
    as they are, also outside of limits and in mid-air."""
    world = placed(problem.world, configuration)
    near, pressed = touching(world), frozenset(pressed_in(world))
    return replace(
        problem, init=facts, init_motion=motion_literals, world=world, touching=near, pressed=pressed,
        scene_motion=problem.motion_of_scene,
    )  # fmt: skip


def placed(world: ir.World, configuration: Configuration) -> ir.World:
    """The world with everything where the configuration has it."""
    modules = {
        name: replace(
            module, pose=_pose(configuration.modules[name]), joints=tuple(configuration.modules[name][7:].tolist())
        )
        for name, module in world.modules.items()
    }
    bodies = {
        name: replace(body, pose=_pose(configuration.bodies[name])) for name, body in world.bodies.items()
    }
    return replace(world, modules=modules, bodies=bodies)


def reached_problem(problem: ir.Problem, reached: Reached) -> ir.Problem:
    """`rerooted` from a `Reached`."""
    return rerooted(problem, reached.facts, reached.mode, reached.configuration)


def _pose(values: np.typing.NDArray[np.float64]) -> ir.Pose:
    x, y, z, a, b, c, w = (float(v) for v in values[:7])
    return x, y, z, a, b, c, w
