"""Room for a robot that cannot go on: a posture, standing where it stands, that keeps away from all that is near."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...compiler import ir
from ..budget import Budget
from ..geometry.attachments import involved
from ..geometry.transforms import coupled
from ..planner.bounds.requests import sequence_path
from ..planner.motion.end_conditions import eased
from ..planner.motion.settings import MotionSettings
from ..seeds import Seed
from ..skeleton import Bound, BoundResult, Configuration, PhasePath, Skeleton, start_configuration
from .predicted_clearance import clearances
from .settings import SIMULATION
from .world import carried


def way_aside(skeleton: Skeleton, settings: MotionSettings, seed: Seed, budget: Budget) -> PhasePath | None:
    """A motion of the robot that the only phase of a skeleton moves, from where it is to a posture with room around
    it, at rest at both ends; None where none is found. Raises OutOfTime."""
    start = start_configuration(skeleton.problem)
    found = [(goal, motion) for goal, motion in _postures(skeleton, start, seed) if _has_room(skeleton, goal)]
    for goal, _ in sorted(found, key=lambda pair: pair[1])[:SIMULATION.evasion_paths]:
        switches = BoundResult(Bound.SEQ, True, 0.0, 0.0, 0, [start, goal], [], [])
        path = sequence_path(skeleton, switches, settings, seed, budget, thorough=False)
        if path.feasible:
            return eased(skeleton.problem.world, path.paths)[0]
    return None


def _postures(skeleton: Skeleton, start: Configuration, seed: Seed) -> Iterator[tuple[Configuration, float]]:
    """Random postures, and how far the joint that moves most has to go."""
    problem, mode = skeleton.problem, skeleton.phases[0].mode
    random = seed.child("postures").random()
    moving = sorted(involved(skeleton, 0))
    own = {name: pose[None, :] for name, pose in start.bodies.items() if not problem.world.bodies[name].movable}
    for spread in np.repeat(SIMULATION.evasion_spreads, SIMULATION.evasion_draws):
        joints = {name: state[None, 7:].copy() for name, state in start.modules.items()}
        for name in moving:
            limits = np.array([(j.lower, j.upper) for j in problem.world.modules[name].type.joints]).reshape(-1, 2)
            drawn = joints[name] + random.normal(0.0, spread, joints[name].shape)
            joints[name] = coupled(
                problem.world.modules[name].type.joints, np.clip(drawn, limits[:, 0], limits[:, 1])
            )
        poses = carried(problem, mode, joints, start, own)
        modules = {name: np.concatenate([poses[name][0], rows[0]]) for name, rows in joints.items()}
        most = max(float(np.abs(joints[m][0] - start.modules[m][7:]).max(initial=0.0)) for m in moving)
        yield Configuration(modules, {name: poses[name][0] for name in start.bodies}), most


def _has_room(skeleton: Skeleton, configuration: Configuration) -> bool:
    """Whether the modules that move are clear of all bodies but those that they are kept to now."""
    problem = skeleton.problem
    moving, kept = involved(skeleton, 0), _kept(problem, skeleton)
    near = clearances(problem.world, configuration, SIMULATION.evasion_room)
    return not any(module in moving and body not in kept for module, body in near)


def _kept(problem: ir.Problem, skeleton: Skeleton) -> set[str]:
    return {name for literal in skeleton.phases[0].mode for name in literal[1:] if name in problem.world.bodies}
