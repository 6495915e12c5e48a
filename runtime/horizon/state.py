"""The scene in mid-run: what holds and where everything is after some actions, and the same task begun from there.

`rerooted` gives an `ir.Problem` whose start is a state that was reached: everything downstream (successor functions,
bounds, phases, plan files) then works from there. Motion literals that hold are carried as start literals, so that
linked things keep their present relative poses (thesis, section 3.5: free joints of the past become rigid). Functions
of the scene such as `distance` then measure the present poses.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...compiler import ir
from ...compiler.motion.collision import Pair, bounding_radius, pair
from ...compiler.poses import compose, joint_frames
from ...compiler.symbolic.geometry import Placed, shape_distance
from ..resampling import resample
from ..skeleton import Configuration, PhasePath, Skeleton, start_configuration
from ..verify.replay import Interpreter

TOUCHING = 0.02
"""Metres: what is nearer when a phase starts may be so, and is not asked for the margin of paths at once."""
DENSER = 5
"""Samples of the executed motion per sample of the planner, as in plan files."""


@dataclass(frozen=True, slots=True)
class Reached:
    """A state of a run: logic facts (static ones too, symmetric ones in both orders), motion literals, poses and joint
    values, and the action before, which `previous` in rules asks for."""

    facts: frozenset[ir.Fact]
    mode: frozenset[ir.Fact]
    configuration: Configuration
    previous: ir.Action | None = None


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

    Raises ReplayError when an action cannot be done, and MissingLibrary.
    """
    begin = start(problem) if begin is None else begin
    count = len(paths) if count is None else count
    interpreter = Interpreter(problem)
    facts, mode, previous = begin.facts, begin.mode, begin.previous
    for phase in skeleton.phases[:count]:
        outcome = interpreter.apply(facts, interpreter.canonical(mode), phase.action, previous)
        facts, mode, previous = outcome.facts, outcome.motion, phase.action
    return Reached(facts, mode, moved(problem, skeleton, paths[:count], begin.configuration), previous)


def moved(
    problem: ir.Problem, skeleton: Skeleton, paths: Sequence[PhasePath], configuration: Configuration
) -> Configuration:
    """Where everything is after the first `len(paths)` phases, which begin at `configuration`."""
    for phase, path in zip(skeleton.phases, paths, strict=False):
        configuration = resample(problem, phase.mode, path, configuration, 0.0, DENSER).end(configuration)
    return configuration.copy()


def rerooted(
    problem: ir.Problem,
    facts: frozenset[ir.Fact],
    motion_literals: frozenset[ir.Fact],
    configuration: Configuration,
) -> ir.Problem:
    """The same task, begun from a state: logic facts, motion literals, and where everything is. Joint values are taken
    as they are, also outside of limits and in mid-air."""
    modules = {
        name: replace(
            module, pose=_pose(configuration.modules[name]), joints=tuple(configuration.modules[name][7:].tolist())
        )
        for name, module in problem.world.modules.items()
    }
    bodies = {
        name: replace(body, pose=_pose(configuration.bodies[name])) for name, body in problem.world.bodies.items()
    }
    world = replace(problem.world, modules=modules, bodies=bodies)
    return replace(
        problem, init=facts, init_motion=motion_literals, world=world, touching=touching(world, configuration)
    )


def reached_problem(problem: ir.Problem, reached: Reached) -> ir.Problem:
    """`rerooted` from a `Reached`."""
    return rerooted(problem, reached.facts, reached.mode, reached.configuration)


def _pose(values: np.typing.NDArray[np.float64]) -> ir.Pose:
    x, y, z, a, b, c, w = (float(v) for v in values[:7])
    return x, y, z, a, b, c, w


# --- what touches --------------------------------------------------------------------------------------------------


def touching(world: ir.World, configuration: Configuration, within: float = TOUCHING) -> frozenset[Pair]:
    """Pairs of effectors and bodies, of different robots' modules or of a module and a body or of two bodies one of
    which can be moved, that are less than `within` metres apart."""
    found: set[Pair] = set()
    movers = _movers(world, configuration)
    resting = [(b.name, Placed(b.shape, _pose(configuration.bodies[b.name]))) for b in world.bodies.values()]
    still = [(name, placed) for name, placed in resting if not world.bodies[name].movable]
    centres = np.array([placed.pose[:3] for _, placed in still]).reshape(-1, 3)
    radii = np.array([bounding_radius(placed.shape) for _, placed in still])
    for index, (name, placed) in enumerate(movers):
        far = np.linalg.norm(centres - np.array(placed.pose[:3]), axis=1) - radii
        near = np.flatnonzero(far < bounding_radius(placed.shape) + within)
        others = [still[i] for i in near.tolist()] + movers[index + 1 :]
        for other, shape in others:
            if _owner(name) != _owner(other) and _near(placed, shape, within):
                found.add(pair(name, other))
    return frozenset(found)


def _movers(world: ir.World, configuration: Configuration) -> list[tuple[str, Placed]]:
    """Effectors with a shape, then movable bodies, where they are."""
    found = []
    for module in world.modules.values():
        values = configuration.modules[module.name]
        frames = joint_frames(module.type, _pose(values), values[7:].tolist())
        for effector in module.type.effectors:
            if effector.shape is not None:
                placed = Placed(effector.shape, compose(frames[effector.joint], effector.placement))
                found.append((f"{module.name}.{effector.name}", placed))
    bodies = [body for body in world.bodies.values() if body.movable]
    return found + [(b.name, Placed(b.shape, _pose(configuration.bodies[b.name]))) for b in bodies]


def _owner(name: str) -> str:
    return name.rpartition(".")[0] or name


def _near(first: Placed, second: Placed, within: float) -> bool:
    apart = float(np.linalg.norm(np.subtract(first.pose[:3], second.pose[:3])))
    if apart >= bounding_radius(first.shape) + bounding_radius(second.shape) + within:
        return False
    return shape_distance(first, second) < within
