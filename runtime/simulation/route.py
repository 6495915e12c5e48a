"""Plans the windows of a run: in the scene as it will be when their first phase ends."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from ...compiler import ir
from ...compiler.kept_pairs import kept_pairs
from ..budget import Budget
from ..planner.lgp import SolveOptions, motion_settings
from ..seeds import Seed
from ..skeleton import Array, Phase, PhasePath
from .braking import at_times, braked, waiting
from .evasion import way_aside
from .failures import Failures
from .monitor import Lookout
from .planning import Planner, Window
from .predicted_clearance import clearances, deepest, nearest
from .scene_prediction import displaced, foreseen_problem
from .sensing import SAME_TIME
from .settings import SIMULATION
from .steering import Steering
from .world import SimulatedWorld


@dataclass(slots=True)
class Route:
    """The way to the goal as it is known, and how windows on it are planned."""

    problem: ir.Problem
    options: SolveOptions
    horizon: int
    failures: Failures
    lookout: Lookout
    budget: Budget
    way: tuple[ir.Action, ...] = ()
    planner: Planner = field(init=False)
    _seconds: dict[str, float] = field(default_factory=dict)
    _visits: dict[tuple[frozenset[ir.Fact], frozenset[ir.Fact], int], int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.planner = Planner(self.options)

    def on_the_way(self, world: SimulatedWorld, left: float | None) -> Window | None:
        """A window on the known way; `left` is how long a phase that was broken off would have taken still."""
        if not self.way:
            return None
        usual = self._seconds.get(self.way[0].rule, SIMULATION.first_guess)
        guesses = [usual, 0.5 * usual] if left is None else [min(usual, left + SIMULATION.left_over), usual]
        for seconds in guesses:
            window = self._timed(world, seconds, search=False)
            if window is not None:
                return window
        return None

    def another_way(self, world: SimulatedWorld) -> Window | None:
        """A window on a way that is searched anew, in haste where the scene may have moved on a moment later."""
        self.planner.hasty = bool(world.on_course) and world.time > 0.0 and not self.planner.redraws
        window = self._timed(world, SIMULATION.first_guess, search=True)
        self.way = window.actions if window is not None else self.way
        return window

    def take(self, world: SimulatedWorld, window: Window) -> None:
        """Follow a window that was planned elsewhere, for the scene as it is now."""
        self.way = window.actions
        self.lookout.expect(world.time, self.lookout.look(world))

    def arrived(self, world: SimulatedWorld) -> None:
        """Count how often the run has been in this state."""
        here = world.reached.facts, world.reached.mode, len(self.failures.locked | self.failures.gone)
        self.planner.returns = self._visits.get(here, 0)
        self._visits[here] = self.planner.returns + 1

    def _timed(self, world: SimulatedWorld, seconds: float, *, search: bool) -> Window | None:
        """A window whose first phase ends when its scene is the foreseen one."""
        poses = self.lookout.look(world)
        self.lookout.expect(world.time, poses)
        met, passed, wider = frozenset[str](), dict[str, str](), 0.0
        for _ in range(SIMULATION.attempts):
            expected = self._at(poses, world.time + seconds)
            base = self.failures.base(self.problem)
            problem = self.failures.stuck(foreseen_problem(base, world.reached, expected, met, passed))
            window = self._search(problem) if search else self._known(problem, wider)
            if window is None and not search:
                more = self._in_the_way(world, passed)
                if more:
                    passed |= more
                    continue
            if window is None or not window.moving or not window.paths:
                return window
            self.way, search = window.actions, False
            first = window.skeleton.phases[0]
            named = frozenset(a for literal in first.added for a in literal[1:])
            elsewhere = named & displaced(problem, base, world.reached, expected)
            if elsewhere:
                met |= elsewhere
                passed = {body: module for body, module in passed.items() if body not in elsewhere}
            elif window.paths[0].duration > seconds:
                seconds = SIMULATION.time_room * window.paths[0].duration
            elif self._deepest(world, first, in_time(window.paths[0], seconds), poses) > SIMULATION.deep:
                wider += SIMULATION.wider
            else:
                self._seconds[first.action.rule] = SIMULATION.time_room * window.paths[0].duration
                return replace(window, paths=[in_time(window.paths[0], seconds)])
        return None

    def _in_the_way(self, world: SimulatedWorld, passed: Mapping[str, str]) -> dict[str, str]:
        """Bodies that only come in the way later, and that the robot passes meanwhile."""
        kept = {name for pair in kept_pairs(self.problem, world.reached.mode) for name in pair}
        bodies = self.problem.world.bodies
        blamed = self.planner.blamed.items()
        return {b: m for b, m in blamed if b not in passed and b not in kept and not bodies[b].movable}

    def is_clear(self, world: SimulatedWorld, phase: Phase, path: PhasePath) -> bool:
        """Whether nothing presses upon a robot on a way that no window is for, such as rest, or no more than now."""
        poses, now = self.lookout.look(world), waiting(world.reached.configuration, SAME_TIME)
        pressed = self._deepest(world, phase, now, poses, everyone=True)
        bearable = max(SIMULATION.pressed, min(pressed + SIMULATION.no_more, SIMULATION.deep))
        return self._deepest(world, phase, path, poses, everyone=True) <= bearable

    def is_time_to_stop(
        self, world: SimulatedWorld, phase: Phase, path: PhasePath, since: float, until: float,
        steering: Steering | None,
    ) -> bool:  # fmt: skip
        """Whether a motion that is to be broken off had better be so now, `since` seconds after its begin, than a
        little later or not at all: it comes to rest, and stays there `until` so many seconds after its begin while
        things move on as they seem to. One that all but meets what it is to meet soon goes on to its end."""
        soon = steering if path.duration - since < SIMULATION.later_looks * SIMULATION.sensing_period else None
        if soon and self._off(world, path, since, soon) < SIMULATION.nearly_met and (
            self._pressed(world, phase, path, since, path.duration) <= SIMULATION.deep
        ):
            return False
        depths: list[float] = []
        for stop in since + SIMULATION.sensing_period * np.arange(SIMULATION.later_looks + 1):
            slowed = path if stop >= path.duration else self.brought_to_rest(world, path, float(stop))
            if slowed is path and not (steering and self._off(world, path, since, steering) < SIMULATION.nearly_met):
                break
            depths.append(self._pressed(world, phase, slowed, since, until))
            if depths[-1] <= self._bearable(world, phase, path, since):
                break
        return int(np.argmin(depths)) == 0 if depths else True

    def brought_to_rest(self, world: SimulatedWorld, path: PhasePath, since: float) -> PhasePath:
        """Rest where the robot is, before a motion begins; else the motion that slows down."""
        if since > 0.0:
            return braked(self.problem.world, path, since)
        return waiting(world.reached.configuration, SIMULATION.sensing_period)

    def _bearable(self, world: SimulatedWorld, phase: Phase, path: PhasePath, since: float) -> float:
        """How deep, metres, a robot may be pressed upon: little more than now."""
        now = self._pressed(world, phase, path, since, since + SAME_TIME, instant=True)
        return max(SIMULATION.pressed, min(now + SIMULATION.no_more, SIMULATION.deep))

    def _pressed(
        self, world: SimulatedWorld, phase: Phase, path: PhasePath, since: float, until: float, instant: bool = False
    ) -> float:  # fmt: skip
        """How deep, metres, robots get into something from `since` on, on a motion and at rest at its end `until`."""
        last = since + SAME_TIME if instant else max(path.duration, until)
        rest = at_times(path, np.minimum(np.linspace(since, last, SIMULATION.phase_looks), path.duration), last - since)
        whole = self.failures.whole(rest, world.reached.configuration)
        looks = world.time + np.linspace(since, last, SIMULATION.phase_looks)
        own = self._own(world.at(world.time + since), looks, newest=True)
        return deepest(self.problem, world.reached.configuration, phase, whole, own, everyone=True)

    def aside(self, world: SimulatedWorld) -> PhasePath | None:
        """A motion, standing where it stands, of the robot that the next action moves, to where it has room."""
        expected = self._at(self.lookout.look(world), world.time + SIMULATION.first_guess)
        base = self.failures.base(self.problem)
        problem = self.failures.stuck(foreseen_problem(base, world.reached, expected, frozenset(), {}))
        skeleton = self.planner.skeleton(problem, self.way[:1])
        if skeleton is None:
            return None
        seed = Seed(self.options.seed).child("aside", self.planner.failures)
        return way_aside(skeleton, motion_settings(problem, self.options), seed, self.budget)

    def passed(self, world: SimulatedWorld, phase: Phase, path: PhasePath) -> frozenset[str]:
        """The bodies on courses that a motion comes near, as they seem to move."""
        times = world.time + np.linspace(0.0, path.duration, SIMULATION.phase_looks)
        poses = self.lookout.look(world)
        own = self._own(poses, times)
        found = nearest(self.problem, world.reached.configuration, phase, path, own)
        return frozenset(body for (_, body), distance in found.items() if distance < SIMULATION.around and body in own)

    def threatens(
        self, world: SimulatedWorld, phase: Phase, path: PhasePath, since: float, bodies: Iterable[str],
        movers: frozenset[str] | None = None,
    ) -> bool:  # fmt: skip
        """Whether one of `bodies`, as they seem to move now, comes near what is left of a motion of `movers` (None:
        anything) after `since` seconds; the motion began in the state that the world is in."""
        rest, own = self._what_is_left(world, path, since)
        found = nearest(self.problem, world.reached.configuration, phase, rest, own)
        return any(
            distance < SIMULATION.threat and body in bodies and (movers is None or name in movers)
            for (name, body), distance in found.items()
        )

    def steering(self, world: SimulatedWorld, phase: Phase, path: PhasePath) -> Steering:
        """What steers a phase that begins now to where what it meets will be."""
        expected = self.lookout.expected(world.time + path.duration, world.at(world.time))
        return Steering(self.problem, phase, path, world.reached.configuration, expected)

    def steered(
        self, world: SimulatedWorld, phase: Phase, path: PhasePath, since: float, steering: Steering
    ) -> tuple[PhasePath, float]:
        """The motion, after `since` seconds of it, led to where what it meets seems to be at its end, and by how many
        metres its end is moved; the same motion where that makes no difference, is too far, or would get into
        something."""
        foreseen = self._at_the_end(world, path, since)
        off = steering.off(path, foreseen)
        least = SIMULATION.steer_least + self.lookout.sensing.sigma
        found = steering.steered(path, since, foreseen) if least < off < SIMULATION.steer_farthest else None
        if found is None:
            return path, off
        rest, own = self._what_is_left(world, found, since)
        clear = deepest(self.problem, world.reached.configuration, phase, rest, own) <= SIMULATION.deep
        return (found if clear else path), off

    def _off(self, world: SimulatedWorld, path: PhasePath, since: float, steering: Steering) -> float:
        return steering.off(path, self._at_the_end(world, path, since))

    def _at_the_end(self, world: SimulatedWorld, path: PhasePath, since: float) -> dict[str, Array]:
        """The poses `(7,)` of bodies at the end of a motion, as they seem to move after `since` seconds of it."""
        return self._at(world.at(world.time + since), world.time + path.duration, newest=True)

    def near(self, world: SimulatedWorld) -> frozenset[str]:
        """The bodies on courses that a robot at rest has to look out for."""
        found = clearances(self.problem.world, world.reached.configuration, SIMULATION.around)
        return frozenset(body for _, body in found if body in world.on_course)

    def _deepest(
        self, world: SimulatedWorld, phase: Phase, path: PhasePath, poses: Mapping[str, Array], everyone: bool = False
    ) -> float:
        """How deep a phase gets into something, metres, while bodies move on as they seem to."""
        times = world.time + np.linspace(0.0, path.duration, SIMULATION.phase_looks)
        own = self._own(poses, times, newest=everyone)
        whole = self.failures.whole(path, world.reached.configuration)
        return deepest(self.problem, world.reached.configuration, phase, whole, own, everyone)

    def _own(self, poses: Mapping[str, Array], times: Array, *, newest: bool = False) -> dict[str, Array]:
        """The poses `(T, 7)` of bodies at some times, as they seem to move; `poses` tell how they are turned."""
        foreseen = self.lookout.sensing.foreseen
        return {body: foreseen(body, pose, times, newest=newest) for body, pose in poses.items()}

    def _at(self, poses: Mapping[str, Array], time: float, *, newest: bool = False) -> dict[str, Array]:
        """As `_own`, the poses `(7,)` at one time."""
        return {body: rows[0] for body, rows in self._own(poses, np.array([time]), newest=newest).items()}

    def _what_is_left(self, world: SimulatedWorld, path: PhasePath, since: float) -> tuple[PhasePath, dict[str, Array]]:
        """What is left of a motion after `since` seconds, and the poses of bodies meanwhile, as they seem to move."""
        rest = at_times(path, np.linspace(since, path.duration, SIMULATION.phase_looks), path.duration - since)
        times = world.time + since + np.linspace(0.0, rest.duration, SIMULATION.phase_looks)
        return rest, self._own(world.at(world.time + since), times, newest=True)

    def _known(self, problem: ir.Problem, wider: float) -> Window | None:
        return self.planner.known_way(problem, self.way, self.horizon, self._moving(), wider, self.budget)

    def _search(self, problem: ir.Problem) -> Window | None:
        return self.planner.new_way(problem, self.horizon, self._moving(), 0.0, self.budget)

    def _moving(self) -> frozenset[str]:
        expectation = self.lookout.expectation
        velocities: dict[str, Array] = {} if expectation is None else expectation.velocities
        return frozenset(body for body, velocity in velocities.items() if velocity.any())


def in_time(path: PhasePath, seconds: float) -> PhasePath:
    """The same motion in more time."""
    return PhasePath(path.modules, path.bodies, seconds)
