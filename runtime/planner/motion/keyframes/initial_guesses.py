"""First guesses for the motion programs: copies of the start with noise, set down on the feet that carry them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import permutations

import numpy as np

from .....compiler import poses
from .....compiler.extents import box_sides
from .....compiler.ir import IDENTITY, Effector, Fact, Module, Pose, Problem, Shape, ShapeKind
from .....compiler.kept_pairs import kept_pairs
from .....compiler.motion.collision import bounding_radius
from ....geometry.attachments import followers, looped, standing
from ....geometry.drives import braked
from ....skeleton import Array, Configuration, Skeleton
from .clear_postures import clear_posture
from .placement_samples import outline, places
from .posture_samples import Aim, Stance, closing, freedom, meeting, reaching, rooms
from .settings import KEYFRAMES

HALF_TURN = (1.0, 0.0, 0.0, 0.0)
"""About x: effectors that are docked look at each other."""


def to_tuple(pose: Array) -> Pose:
    x, y, z, a, b, c, w = (float(v) for v in pose)
    return (x, y, z, a, b, c, w)


def effector_pose(module: Module, effector: str, slot: Array) -> Pose:
    """The effector's frame in the world, from the module's slot `(7 + n,)`."""
    return poses.compose(to_tuple(slot[:7]), poses.effector_pose(module.type, effector, slot[7:].tolist()))


def put_effector(module: Module, effector: str, slot: Array, target: Pose) -> None:
    """Move the module as a rigid thing, in place, so that its effector, with "" its frame, comes to `target`."""
    local = poses.effector_pose(module.type, effector, slot[7:].tolist()) if effector else IDENTITY
    slot[:7] = poses.compose(target, poses.inverse(local))


def _height(shape: Shape) -> float:
    """Half the height of a shape that lies in its own axes."""
    flat = shape.kind in (ShapeKind.BOX, ShapeKind.CONVEX)
    return box_sides(shape)[2] / 2 if flat else bounding_radius(shape)


class Guess:
    """Guesses one slice after the other: feet that are kept stay, feet that are set down go on top of their base."""

    def __init__(
        self, skeleton: Skeleton, start: Configuration, random: np.random.Generator, noise: float, wide: bool = False,
        steady: bool = False, clear: bool = False,
    ) -> None:  # fmt: skip
        self.problem: Problem = skeleton.problem
        self.skeleton = skeleton
        self.random = random
        self.noise = noise
        self.wide = wide
        self.steady = steady
        self.clear = clear
        self.obstructed = 0.0
        """What is in the way of clear postures, and what these miss, all together; metres."""
        self.current = start.copy()
        self.feet: dict[str, Pose] = {}
        self.places = places(skeleton)

    def _pose(self, name: str) -> Pose:
        found = self.problem.world.effector(name)
        if found:
            module, effector = found
            return effector_pose(module, effector.name, self.current.modules[module.name])
        slot = self.current.bodies.get(name)
        return to_tuple(self.current.modules[name][:7] if slot is None else slot)

    def _shake(self, mode: frozenset[Fact]) -> None:
        closed = looped(self.problem, mode) if self.steady else frozenset[str]()
        held = braked(self.problem, mode)
        for name, slot in self.current.modules.items():
            lower, upper = rooms(self.problem.world.modules[name], KEYFRAMES.limit_inset)
            shaken = np.clip(slot[7:] + self.noise * self.random.normal(size=len(lower)), lower, upper)
            still = [*held.get(name, ())]
            shaken[still] = slot[7:][still]
            slot[7:] = slot[7:] if name in closed else shaken

    def _above(self, base: str, lift: float, turn: tuple[float, float, float, float]) -> Pose:
        body = self.problem.world.bodies[base]
        bearer = body.shape.solids[0]
        x, y, z = poses.compose(to_tuple(self.current.bodies[base]), bearer.placement)[:3]
        return (x, y, z + _height(bearer.shape) + lift, *turn)

    def _aside(self, base: str, phase: int, thing: str) -> Array:
        """Where on a base: as laid out, or shifted at random from its middle, as two things that lie in the very same
        place do not push each other away."""
        planned = self.places.get((phase, thing))
        if planned is not None:
            return planned
        side = outline(self.problem.world.bodies[base])
        middle = np.array(self._above(base, 0.0, IDENTITY[3:])[:2])
        return middle + KEYFRAMES.base_spread * self.random.uniform(-0.5, 0.5, 2) * side

    def advance(self, phase: int) -> Configuration:
        """The guess for the switch of the next phase; call for rising phases."""
        mode, added = self.skeleton.phases[phase].mode, self.skeleton.phases[phase].added
        carried = followers(self.problem, mode)
        names = (name for pair in kept_pairs(self.problem, mode) for name in pair)
        before = {name: self.feet.get(name) or self._pose(name) for name in names}
        self.current = self.current.copy()
        self._shake(mode)
        stances = self._stand(mode, carried, before)
        placed = set(stances)
        feet = self._set_down(phase, carried, before, list(stances.values()), placed)
        self._turn_to(self._aims(phase, feet, before), stances, feet, self._grasps(mode, before))
        self._meet(phase, stances)
        self._dock(mode, placed)
        for leader, follower in kept_pairs(self.problem, mode):
            if follower in carried and follower not in {b for _, b in kept_pairs(self.problem, added)}:
                self.current.bodies[follower][:3] = self._pose(leader)[:3]
        stays = {name: pose for name, pose in self.feet.items() if name in before}
        self.feet = stays | feet
        return self.current.copy()

    def _stand(self, mode: frozenset[Fact], carried: frozenset[str], before: dict[str, Pose]) -> dict[str, Stance]:
        """Put modules on the feet that carry them, by module."""
        world = self.problem.world
        stances: dict[str, Stance] = {
            name: ("", to_tuple(self.current.modules[name][:7])) for name in sorted(standing(self.problem, mode))
        }
        for base, follower in kept_pairs(self.problem, mode):
            found = world.effector(follower)
            if found and base in world.bodies and base not in carried and found[0].name not in stances:
                stance = (found[1].name, before[follower])
                put_effector(found[0], stance[0], self.current.modules[found[0].name], stance[1])
                stances[found[0].name] = stance
        return stances

    def _set_down(
        self, phase: int, carried: frozenset[str], before: dict[str, Pose], stances: list[Stance], placed: set[str]
    ) -> dict[str, Pose]:
        """The poses of feet and things that are set down at the switch, on top of their bases."""
        world = self.problem.world
        feet: dict[str, Pose] = {}
        for base, follower in kept_pairs(self.problem, self.skeleton.phases[phase].added):
            found = world.effector(follower)
            if found and base in world.bodies and base not in carried:
                lift = bounding_radius(found[1].shape) if found[1].shape else 0.0
                turn = (stances[-1][1] if stances else before.get(follower) or self._pose(follower))[3:]
                feet[follower] = self._above(base, lift, turn)
                if found[0].name not in placed:
                    put_effector(found[0], found[1].name, self.current.modules[found[0].name], feet[follower])
                    placed.add(found[0].name)
            elif follower in world.bodies and base in world.bodies:
                body = world.bodies[follower]
                self.current.bodies[follower][:] = self._above(base, _height(body.shape), body.pose[3:])
                self.current.bodies[follower][:2] = self._aside(base, phase, follower)
        return feet

    def _aims(self, phase: int, feet: dict[str, Pose], before: dict[str, Pose]) -> dict[str, Aim]:
        """By module, what a switch brings where: an effector to its foothold, to the thing that it is to meet, or to
        the place of what it holds, which then stands as upright as where it was taken."""
        world = self.problem.world
        aims: dict[str, Aim] = {}
        held = {follower: leader for leader, follower in kept_pairs(self.problem, self.skeleton.phases[phase].mode)}
        for literal in sorted(self.skeleton.phases[phase].added):
            for name, other in permutations(literal[1:], 2):
                hand = held.get(name, "") if name in world.bodies else name
                found = world.effector(hand)
                handle = self._handle(other)
                if found and handle is not None and found[0].name != handle[0].name:
                    radii = sum(bounding_radius(e.shape) for e in (found[1], handle[1]) if e.shape)
                    aim = Aim(found[1].name, np.array(self._pose(other)[:3]), radii)
                    aims.setdefault(found[0].name, aim)
                if not found or other not in world.bodies:
                    continue
                thing = name if name in world.bodies else other
                distance = _height(world.bodies[thing].shape)
                distance += bounding_radius(found[1].shape) if found[1].shape else 0.0
                aim = Aim(found[1].name, self.current.bodies[thing][:3], distance)
                if hand in feet:
                    aim = Aim(found[1].name, np.array(feet[hand][:3]), 0.0)
                elif thing == name:
                    aim = replace(aim, upright=np.array(poses.rotate(poses.inverse(before[hand])[3:], (0.0, 0.0, 1.0))))
                aims.setdefault(found[0].name, aim)
        return aims

    def _handle(self, name: str) -> tuple[Module, Effector] | None:
        """An effector of a module with joints that have no drive, such as a door's: it waits to be taken hold of."""
        found = self.problem.world.effector(name)
        return found if found and any(j.passive for j in found[0].type.joints) else None

    def _grasps(self, mode: frozenset[Fact], before: dict[str, Pose]) -> dict[str, Array]:
        """By effector, where it is `(3,)` from what it holds, in the world, at the switch before."""
        bodies = self.problem.world.bodies
        return {
            hand: np.subtract(before[hand][:3], before[thing][:3])
            for hand, thing in kept_pairs(self.problem, mode) if hand not in bodies and thing in bodies
        }  # fmt: skip

    def _turn_to(
        self, aims: dict[str, Aim], stances: dict[str, Stance], feet: dict[str, Pose], grasps: dict[str, Array]
    ) -> None:
        """Joint values from which modules that stand on their own and cannot turn as they like come near to their aims.
        A foot that is set down gets there, and is turned as this posture turns it: the next one starts from there."""
        for name, stance in stances.items():
            module, slot, aim = self.problem.world.modules[name], self.current.modules[name], aims.get(name)
            if aim is None or aim.effector == stance[0] or any(j.passive for j in module.type.joints):
                continue
            if not self.wide and freedom(module.type, stance[0], aim.effector) >= KEYFRAMES.free_directions:
                continue
            foot = f"{name}.{aim.effector}"
            if self.clear and foot not in feet:
                held = None if aim.upright is None else grasps.get(foot)
                values = slot[7:], stance, aim, held, KEYFRAMES.limit_inset, self.random
                slot[7:], obstructed = clear_posture(module, *values, self._solids())
                self.obstructed += obstructed
            else:
                slot[7:] = reaching(module, slot[7:], stance, aim, KEYFRAMES.limit_inset, self.random)
            if foot in feet:
                slot[7:] = closing(module, slot[7:], stance, aim, KEYFRAMES.limit_inset)
            put_effector(module, stance[0], slot, stance[1])
            if foot in feet:
                feet[foot] = (*feet[foot][:3], *self._pose(foot)[3:])

    def _solids(self) -> list[tuple[Shape, Array]]:
        """The parts of all bodies, where they are."""
        return [
            (part.shape, np.array(poses.compose(to_tuple(self.current.bodies[body.name]), part.placement)))
            for body in self.problem.world.solids for part in body.shape.solids
        ]  # fmt: skip

    def _meet(self, phase: int, stances: dict[str, Stance]) -> None:
        """Joint values with which two modules that stand on their own, and cannot turn as they like, face each other
        with the ends that a switch brings together."""
        for literal in sorted(self.skeleton.phases[phase].added):
            found = [end for end in map(self.problem.world.effector, literal[1:]) if end and end[0].name in stances]
            if len(found) != 2 or found[0][0].name == found[1][0].name:
                continue
            ends = [(m, self.current.modules[m.name], stances[m.name], e) for m, e in found]
            if any(
                e.name == foot or freedom(m.type, foot, e.name) >= KEYFRAMES.free_directions
                or any(j.passive for j in m.type.joints) for m, _, (foot, _), e in ends
            ):  # fmt: skip
                continue
            radii = sum(bounding_radius(e.shape) for *_, e in ends if e.shape)
            one, other = ((m, slot[7:], stance, e.name) for m, slot, stance, e in ends)
            chosen = meeting((one, other), radii, KEYFRAMES.limit_inset, self.random)
            for (module, slot, stance, _), values in zip(ends, chosen, strict=True):
                slot[7:] = values
                put_effector(module, stance[0], slot, stance[1])
            return

    def _dock(self, mode: frozenset[tuple[str, ...]], placed: set[str]) -> None:
        """Put modules that hang on placed ones against them, effector to effector."""
        world = self.problem.world
        waiting = [pair for pair in kept_pairs(self.problem, mode) if all(world.effector(name) for name in pair)]
        found = True
        while found:
            found = False
            for pair in [*waiting, *((b, a) for a, b in waiting)]:
                leader, follower = (world.effector(name) for name in pair)
                if leader and follower and leader[0].name in placed and follower[0].name not in placed:
                    radii = sum(bounding_radius(e.shape) for _, e in (leader, follower) if e.shape)
                    pose = poses.compose(self._pose(pair[0]), (0.0, 0.0, radii, *HALF_TURN))
                    put_effector(follower[0], follower[1].name, self.current.modules[follower[0].name], pose)
                    placed.add(follower[0].name)
                    found = True


def guess(
    skeleton: Skeleton, phases: Sequence[int], start: Configuration, random: np.random.Generator, noise: float,
    wide: bool = False, steady: bool = False, clear: bool = False,
) -> list[Configuration]:  # fmt: skip
    """Guesses for the switches of `phases`, by the poses of feet and `noise` radians on every joint. Modules that stand
    on their own and cannot turn as they like, with `wide` all that stand on their own, take postures from anywhere
    within their limits that come near to what they are to meet. With `steady` modules that close a loop stay as they
    are: noise opens it, and what closes it again is often a posture to which no path leads. With `clear` hands come to
    things from sides that are free, such as also leave room where these are put down: the best of several guesses."""
    drawn = []
    for _ in range(KEYFRAMES.clear_draws if clear else 1):
        maker = Guess(skeleton, start, random, noise, wide, steady, clear)
        drawn.append(([maker.advance(phase) for phase in phases], maker.obstructed))
        if maker.obstructed < KEYFRAMES.clear_enough:
            break
    return min(drawn, key=lambda g: g[1])[0]


def shake(
    problem: Problem, configuration: Configuration, random: np.random.Generator, noise: float
) -> Configuration:
    """A copy with noise on every joint, within the limits."""
    copy = configuration.copy()
    for name, slot in copy.modules.items():
        for i, joint in enumerate(problem.world.modules[name].type.joints):
            slot[7 + i] = min(max(slot[7 + i] + noise * random.normal(), joint.lower), joint.upper)
    return copy
