"""Loads of random closed loops against MuJoCo, held still."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from tamplang.compiler import ir
from tamplang.compiler.physics.frames import Poses, poses
from tamplang.compiler.physics.statics import drives_of, wrenches
from tamplang.compiler.physics.structure import WORLD, Structure, structure, subtrees
from tamplang.runtime.engine import welds
from tamplang.runtime.engine.model import EngineWorld, build

SECONDS = 1.5
"""For which everything is held, and then rests."""
RESTS = 1e-3
"""rad/s or m/s: what moves faster does not rest."""


@dataclass(frozen=True, slots=True)
class Held:
    """Of one assembly: by which shares of its greatest torque the drives of the engine differ from what statics gives
    for the engine's own wrenches of the loop (`balance`), and from what statics gave them ahead (`share`); and how
    fast its joints still were."""

    balance: float
    share: float
    speed: float


def ring(problem: ir.Problem) -> frozenset[ir.Fact]:
    """Every arm on the ground by its A, and neighbours joined by their B."""
    names = list(problem.world.modules)
    feet = {("stable", "ground", f"{n}.A") for n in names}
    return frozenset(feet | {("stable", f"{a}.B", f"{b}.B") for a, b in pairwise(names)})


def held_still(problem: ir.Problem, rows: dict[str, np.ndarray]) -> Held:
    """Hold a ring of arms in a posture, with the torques that statics gives, until it rests."""
    placed = {
        name: replace(module, pose=tuple(rows[name][0, :7]), joints=tuple(rows[name][0, 7:]))
        for name, module in problem.world.modules.items()
    }
    problem = replace(problem, world=replace(problem.world, modules=placed))
    mode = ring(problem)
    built = structure(problem, mode)
    bodies = {n: np.array([b.pose]) for n, b in problem.world.bodies.items()}
    ahead = poses(problem, rows, bodies)
    told = drives_of(problem, built, ahead, wrenches(problem, built, ahead, 1.0))
    pairs = {(e.parent, e.child): e for e in built.all if not e.is_joint}
    world = build(problem, pairs)
    for pair in pairs:
        welds.fasten(world, pair, ahead.places[pair[1]][0])
    gains, targets, damping = _drives(world, told)
    world.data.ctrl[:] = targets
    for _ in range(round(SECONDS / world.model.opt.timestep)):
        world.engine.mj_step(world.model, world.data)
    places, rates = (np.array([j[k] for j in world.joints.values()]) for k in (0, 1))
    ids = np.array([j[2] for j in world.joints.values()])
    given = gains[ids] * (targets[ids] - world.data.qpos[places]) - damping[ids] * world.data.qvel[rates]
    here = _here(world, ahead)
    found = drives_of(problem, built, here, _borne(problem, built, here, world))
    most = float(np.abs(given).max())
    wanted = np.array([float(found[key][0]) for key in world.joints])
    first = np.array([float(told[key][0]) for key in world.joints])
    return Held(
        float(np.abs(given - wanted).max()) / most, float(np.abs(given - first).max()) / most,
        float(np.abs(world.data.qvel[rates]).max()),
    )  # fmt: skip


def _drives(world: EngineWorld, told: dict[tuple[str, int], np.ndarray]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    gains = world.model.actuator_gainprm[:, 0].copy()
    targets = np.zeros(world.model.nu)
    for key, (place, _, drive) in world.joints.items():
        targets[drive] = world.data.qpos[place] + float(told[key][0]) / gains[drive]
    return gains, targets, -world.model.actuator_biasprm[:, 2]


def _here(world: EngineWorld, ahead: Poses) -> Poses:
    turns = {n: world.data.xmat[b].reshape(1, 3, 3).copy() for n, b in world.bodies.items()}
    places = {n: world.data.xpos[b][None].copy() for n, b in world.bodies.items()}
    return Poses({**ahead.turns, **turns}, {**ahead.places, **places})


def _borne(
    problem: ir.Problem, built: Structure, here: Poses, world: EngineWorld
) -> list[tuple[np.ndarray, np.ndarray]]:
    """The wrenches of all edges where the loops take what the engine's welds bear."""
    tree = wrenches(problem, Structure(built.edges, ()), here, 1.0)
    measured = welds.wrenches(world)
    ways, found = subtrees(built), [(f.copy(), m.copy()) for f, m in tree]
    for loop in built.loops:
        pair = loop.parent, loop.child
        force, moment = measured[world.welds[pair]]
        about = moment + np.cross(welds.anchor(world, pair), force)
        force, moment = -force[None], -about[None]
        found.append((force, moment))
        for edge in ways[loop.child] ^ ways[loop.parent]:
            sign = -1.0 if edge in ways[loop.child] else 1.0
            found[edge] = found[edge][0] + sign * force, found[edge][1] + sign * moment
    assert WORLD in here.turns
    return found
