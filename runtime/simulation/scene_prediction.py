"""The scene in which a window is planned: bodies where they are expected, robots carried along with what they stand on.

A phase that ends at time t is planned as if everything stood still where it will be at t, so that what is touched then
is met exactly. Its motion, relative to what the robot stands on, is carried out while that moves. What lets go of a
body when the phase starts must begin clear of it: such a body is put where it is now as seen from that robot.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ...compiler import ir
from ...compiler.kept_pairs import kept_pairs
from ...compiler.motion.collision import Pair, bounding_radius, pair
from ...compiler.motion.module_reach import reach
from ...compiler.poses import joint_frames
from ..geometry.attachments import carrier, followers
from ..geometry.start_contacts import touching
from ..geometry.transforms import compose, inverse, rotate
from ..planner.receding.mid_run_state import Reached, placed, reached_problem
from ..skeleton import Array, Configuration, Skeleton
from .predicted_clearance import clearances, signed_distance
from .settings import SIMULATION
from .world import carried


def foreseen_problem(
    problem: ir.Problem, reached: Reached, expected: Mapping[str, Array], met: frozenset[str],
    passed: Mapping[str, str],
) -> ir.Problem:  # fmt: skip
    """The task, begun from `reached` as it will be when bodies are at their `expected` poses `(7,)`.

    Bodies in `met` are there even when a robot lets go of them now. Those that `passed` names are where they are now,
    as seen from that module.
    """
    if not expected:
        return reached_problem(problem, reached)
    now = reached.configuration
    poses = _then(problem, reached, expected)
    modules = {name: np.concatenate([poses[name], state[7:]]) for name, state in now.modules.items()}
    bodies = {name: poses[name].copy() for name in now.bodies}

    def seen_from(module: str, body: str) -> Array:
        shift = compose(modules[module][:7], inverse(now.modules[module][:7]))
        return compose(shift, now.bodies[body])

    for end, body in touched(problem, reached, met):
        module = carrier(problem, end)
        seen = seen_from(module, body)
        seen[:3] += SIMULATION.put_away * _outward(problem, end, modules[module], body, seen)
        for other in _kept_with(problem, reached.mode, body) - met:
            bodies[other] = compose(compose(seen, inverse(poses[body])), poses[other])
    let_go = {body for _, body in touched(problem, reached, met)}
    then = Configuration(modules, bodies)
    coming = _coming(problem, reached, then)
    for body, module in {**coming, **passed}.items():
        if body not in let_go | met:
            bodies[body] = seen_from(module, body)
    begun = reached_problem(problem, replace(reached, configuration=then))
    return replace(begun, touching=begun.touching | _close(begun, then))


def _coming(problem: ir.Problem, reached: Reached, then: Configuration) -> dict[str, str]:
    """Bodies that will have come too near to a module that does not move, and the module: it has to leave before."""
    kept = _of_robots(problem, reached.mode)
    now = clearances(problem.world, reached.configuration, SIMULATION.too_near)
    near = clearances(problem.world, then, SIMULATION.too_near).items()
    found: dict[str, str] = {}
    for (module, body), distance in sorted(near, key=lambda item: item[1]):
        comes = distance < now.get((module, body), SIMULATION.too_near) - SIMULATION.same_place
        if comes and body not in kept and not problem.world.bodies[body].movable:
            found.setdefault(body, module)
    return found


def _of_robots(problem: ir.Problem, mode: frozenset[ir.Fact]) -> frozenset[str]:
    """The bodies that an effector is kept to, or that follow one."""
    pairs = kept_pairs(problem, mode)
    held = {body for pair in pairs for body, other in (pair, pair[::-1]) if problem.world.effector(other) is not None}
    return followers(problem, mode) | held


def _close(problem: ir.Problem, configuration: Configuration) -> frozenset[Pair]:
    """Modules with the bodies that they are not kept to and that are nearer than is asked for along a path, so that
    they may be so when it starts."""
    kept = _of_robots(problem, problem.init_motion)
    near = clearances(problem.world, configuration, SIMULATION.too_near)
    return frozenset(pair(module, body) for module, body in near if body not in kept)


def _then(problem: ir.Problem, reached: Reached, expected: Mapping[str, Array]) -> dict[str, Array]:
    """The poses `(7,)` of everything when bodies are at their `expected` ones, and what is kept to them goes along."""
    now = reached.configuration
    joints = {name: state[None, 7:] for name, state in now.modules.items()}
    own = {name: pose[None, :] for name, pose in expected.items()}
    return {name: rows[0] for name, rows in carried(problem, reached.mode, joints, now, own).items()}


def _kept_with(problem: ir.Problem, mode: frozenset[ir.Fact], body: str) -> frozenset[str]:
    """A body, and those that are kept to it, directly or through others, but not to a robot."""
    robots, found = _of_robots(problem, mode), {body}
    pairs = [pair for pair in kept_pairs(problem, mode) if robots.isdisjoint(pair)]
    grew = True
    while grew:
        more = {name for pair in pairs if not found.isdisjoint(pair) for name in pair} - found
        grew, found = bool(more), found | more
    return frozenset(found)


def _outward(problem: ir.Problem, end: str, state: Array, body: str, pose: Array) -> Array:
    """The direction `(3,)` in which an effector sees a body at `pose`, for the state `(7 + n,)` of its module."""
    found = problem.world.effector(end)
    assert found is not None
    module, effector = found
    frames = joint_frames(module.type, tuple(state[:7].tolist()), state[7:].tolist())
    centre = compose(np.array(frames[effector.joint]), np.array(effector.placement))[:3]
    local = compose(inverse(pose), np.array([*centre, 0.0, 0.0, 0.0, 1.0]))[:3]
    around = local + SIMULATION.same_place * np.vstack([np.eye(3), -np.eye(3)])
    distances = signed_distance(problem.world.bodies[body].shape, around)
    away = rotate(pose[3:], distances[3:] - distances[:3])
    return np.asarray(away / max(float(np.linalg.norm(away)), 1e-12))


def displaced(
    problem: ir.Problem, base: ir.Problem, reached: Reached, expected: Mapping[str, Array]
) -> frozenset[str]:
    """The bodies that a foreseen problem has elsewhere than they are expected, as a robot lets go of them; `base` is
    the task without what has left."""
    at = _then(base, reached, expected)
    bodies = problem.world.bodies.items()
    return frozenset(n for n, b in bodies if np.linalg.norm(at[n][:3] - np.array(b.pose[:3])) > SIMULATION.same_place)


def touched(problem: ir.Problem, reached: Reached, met: frozenset[str]) -> list[tuple[str, str]]:
    """Ends with the bodies that they touch without being kept there; bodies that a robot stands on are left out."""
    kept = _of_robots(problem, reached.mode)
    found = {}
    for a, b in sorted(touching(placed(problem.world, reached.configuration), SIMULATION.let_go)):
        for end, body in ((a, b), (b, a)):
            if body in problem.world.bodies and body not in kept | met and problem.world.effector(end) is not None:
                found[body] = end
    return [(end, body) for body, end in found.items()]


def concerned(skeleton: Skeleton, bodies: frozenset[str]) -> frozenset[str]:
    """Those of `bodies` that the phases of a skeleton touch, stand on or come near."""
    problem, world = skeleton.problem, skeleton.problem.world
    names = {a for phase in skeleton.phases for literal in phase.mode | phase.added for a in literal[1:]}
    modules = {carrier(problem, a) for phase in skeleton.phases for literal in phase.added for a in literal[1:]}
    places: list[tuple[Array, float]] = []
    for module in (world.modules[m] for m in sorted(modules) if m in world.modules):
        frames = joint_frames(module.type, module.pose, module.joints)
        for effector in module.type.effectors:
            places.append((np.array(frames[effector.joint][:3]), reach(module.type, effector.name)))
    near = set()
    for name in sorted(bodies):
        body = world.bodies[name]
        centre, radius = np.array(body.pose[:3]), bounding_radius(body.shape)
        if any(np.linalg.norm(centre - place) < length + radius for place, length in places):
            near.add(name)
    return frozenset(bodies & (names | near))
