"""Runs a task in the simulated world: plan a window, carry it out while looking, plan anew where the world differs.

    sense ──▶ foresee ──▶ plan a window ──▶ carry out a phase ──▶ …
      ▲                                          │ a body is not where it was expected, or a module fails
      └────────────── brake, and rest ◀──────────┘

The world waits while a window is planned. Every planning is a `WindowRecord`.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from ...compiler import ir
from ...compiler.printing_terms import format_formula
from ...langs.diagnostics import Diagnostic
from ...langs.source import Span
from ..assemble import FACTOR
from ..budget import Budget, OutOfTime
from ..lgp import SolveOptions
from ..plan import Plan, StatisticsRecord, WindowRecord
from ..skeleton import Array, Phase, PhasePath
from ..verify import verify
from ..verify.replay import Interpreter
from .braking import braked, stopped
from .failures import Failures
from .foresight import concerned, displaced, foreseen_problem
from .planning import Planner, Window
from .record import Step, plan_of_run
from .sensing import PERIOD, Sensing
from .world import Interval, World

HORIZON = 4
"""Actions that get their motion in one window, where nothing else is said."""
FIRST_GUESS = 3.0
"""Seconds that a phase is assumed to take before any was seen."""
ROOM = 1.1
"""What is added to the seconds that a phase took."""
ATTEMPTS = 5
"""How often a window is planned anew because its first phase takes longer than assumed, or would collide."""
WIDER = 0.01
"""Metres by which margins grow for a phase that would collide with what moves."""


@dataclass(frozen=True, slots=True)
class RunOptions:
    """`horizon` actions get their motion in one window; `sigma` is the noise of sensed positions, metres."""

    solve: SolveOptions
    horizon: int = HORIZON
    sigma: float = 0.0
    seed: int = 0


@dataclass(frozen=True, slots=True)
class RunProgress:
    """Where a run stands: simulated seconds, actions done, actions left on the way that is known."""

    message: str
    time: float
    done: int
    left: int
    elapsed: float


@dataclass(slots=True)
class RunOutcome:
    """`status` is "solved"; "stuck": from the state reached no way leads on; "lost": a breakdown took what carries a
    robot or holds a thing; "refused": by the verifier; "budget" or "interrupted". `plan` holds what was carried out,
    verified; it is not `complete` unless the goal is reached."""

    status: str
    plan: Plan
    explanation: list[Diagnostic] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class _Expectation:
    """Where a window expects the bodies that it depends on: sensed at `time`, moving on with constant velocities."""

    time: float
    positions: dict[str, Array]
    velocities: dict[str, Array]

    def at(self, body: str, time: float) -> Array:
        return np.asarray(self.positions[body] + (time - self.time) * self.velocities[body])


class Run:
    """One run of a task; `run` carries it out."""

    def __init__(
        self, problem: ir.Problem, options: RunOptions, tell: Callable[[RunProgress], None] | None = None
    ) -> None:
        self.problem = problem
        self.options = options
        self.world = World(problem)
        self.budget = Budget(options.solve.time)
        self.planner = Planner(options.solve)
        self.steps: list[Step] = []
        self.windows: list[WindowRecord] = []
        self._tell = tell
        self._sensing = Sensing(options.sigma, np.random.default_rng([options.seed, 1]))
        self._failures = Failures(problem)
        self._places: dict[ir.Fact, Span | None] = {}
        self._way: tuple[ir.Action, ...] = ()
        self._seconds: dict[str, float] = {}
        self._expected: _Expectation | None = None
        self._explanation: list[Diagnostic] = []

    def run(self) -> RunOutcome:
        """Until the goal is reached, the way ends, or the budget; Ctrl-C ends with what was carried out."""
        try:
            status = self._loop()
        except OutOfTime:
            status = "budget"
        except KeyboardInterrupt:
            status = "interrupted"
        return self._outcome(status)

    def _loop(self) -> str:
        reason = "start"
        while True:
            failed = self._failures.until(self.world.time, self.world.reached)
            if failed.lost is not None:
                self._explanation = [failed.lost]
                return "lost"
            self.world.reached = failed.reached
            if not self._unmet():
                return "solved"
            window = self._plan(reason)
            if window is None:
                return self._no_way()
            reason = self._follow(window)

    def _no_way(self) -> str:
        refusals = self.planner.refusals
        if refusals is not None:
            self._explanation = refusals.explain(self.planner.status)
        return "budget" if self.planner.status == "budget" else "stuck"

    # --- planning ------------------------------------------------------------------------------------------------

    def _unmet(self) -> list[str]:
        """The parts of the goal that do not hold now."""
        base = self._failures.base(self.problem)
        goal = base.goal
        parts = goal.operands if isinstance(goal, ir.And) else (goal,)
        interpreter = Interpreter(base)
        return [format_formula(p) for p in parts if not interpreter.holds(self.world.reached.facts, p)]

    def _plan(self, reason: str) -> Window | None:
        began = time.process_time()
        unmet = self._unmet()
        self._say(f"planning: {reason}")
        window = self._window()
        seconds = time.process_time() - began
        actions = [str(a) for a in window.actions] if window is not None else []
        motions = len(window.paths) if window is not None else 0
        self.windows.append(
            WindowRecord(self.world.time, len(self.steps), reason, seconds, actions, motions, unmet)
        )
        return window

    def _window(self) -> Window | None:
        """A window whose first phase ends when its scene is the foreseen one, and meets nothing on the way there."""
        poses = self._look()
        velocities = {body: self._sensing.velocity(body) for body in poses}
        rule = self._way[0].rule if self._way else ""
        seconds, met, wider = self._seconds.get(rule, FIRST_GUESS), frozenset[str](), 0.0
        window: Window | None = None
        for _ in range(ATTEMPTS):
            expected = {b: self._sensing.foreseen(b, pose, seconds) for b, pose in poses.items()}
            problem = self._foreseen(expected, met)
            window = self._search(problem, velocities, wider)
            if window is None or not window.paths:
                break
            if not window.moving:
                break
            first = window.skeleton.phases[0]
            named = frozenset(a for literal in first.added for a in literal[1:])
            elsewhere = named & displaced(problem, self.world.reached, expected)
            if elsewhere:
                met |= elsewhere
                continue
            if window.paths[0].duration > seconds:
                seconds = ROOM * window.paths[0].duration
                continue
            window = self._stretched(window, seconds)
            break
        if window is not None:
            now = {body: self._sensing.foreseen(body, pose, 0.0)[:3] for body, pose in poses.items()}
            self._expected = _Expectation(self.world.time, now, velocities)
        return window

    def _stretched(self, window: Window, seconds: float) -> Window:
        first = window.paths[0]
        self._seconds[window.skeleton.phases[0].action.rule] = ROOM * first.duration
        return replace(window, paths=[replace_duration(first, seconds)])

    def _foreseen(self, expected: dict[str, Array], met: frozenset[str]) -> ir.Problem:
        base = self._failures.base(self.problem)
        return self._failures.stuck(foreseen_problem(base, self.world.reached, expected, met))

    def _search(self, problem: ir.Problem, velocities: dict[str, Array], wider: float) -> Window | None:
        moving = frozenset(body for body, velocity in velocities.items() if velocity.any())
        horizon = self.options.horizon
        if self._way:
            window = self.planner.known_way(problem, self._way, horizon, moving, wider, self.budget)
            if window is not None:
                return window
        window = self.planner.new_way(problem, horizon, moving, wider, self.budget)
        self._way = window.actions if window is not None else ()
        return window

    # --- carrying out --------------------------------------------------------------------------------------------

    def _look(self) -> dict[str, Array]:
        poses = self.world.at(self.world.time)
        self._sensing.look(self.world.time, poses)
        return poses

    def _follow(self, window: Window) -> str:
        """Carry out the phases of a window that have motions; why the next one is planned."""
        for phase, path in zip(window.skeleton.phases, window.paths, strict=False):
            self._say(str(phase.action))
            reason = self._carry_out(phase, self._whole(path), window)
            if reason is not None:
                return reason
        return "next window"

    def _carry_out(self, phase: Phase, path: PhasePath, window: Window) -> str | None:
        """One phase; when it is broken off, why."""
        concerns = concerned(replace(window.skeleton, phases=(phase,)), frozenset(self.world.on_course))
        self._look()
        found = self._off(concerns)
        if found is not None:
            return found
        begin, failure = self.world.time, self._failures.next_of(phase, self.world.time)
        for look in np.arange(1, int(np.ceil(path.duration / PERIOD))) * PERIOD:
            now = begin + float(look)
            if failure is not None and failure.time <= now:
                break
            self._sensing.look(now, self.world.at(now))
            found = self._off(concerns, now)
            if found is not None:
                slowed = braked(self.problem.world, path, float(look))
                self._perform(phase, slowed, completed=slowed is path)
                return found
        if failure is not None and failure.time < begin + path.duration:
            if failure.time - begin > 1e-3:
                self._perform(phase, stopped(path, failure.time - begin), completed=False)
            self.world.time = max(self.world.time, failure.time)
            return f"{failure.module} is {failure.kind}"
        self._perform(phase, path, completed=True)
        return None

    def _off(self, concerns: frozenset[str], now: float | None = None) -> str | None:
        """Why the window has become invalid: a body that it depends on is not where it expects it."""
        if self._expected is None:
            return None
        now = self.world.time if now is None else now
        for body in sorted(concerns & self._expected.positions.keys()):
            sensed = self._sensing.last(body)
            off = float(np.linalg.norm(sensed - self._expected.at(body, now)))
            if off > self._sensing.tolerance:
                return f"{body} is {1000 * off:.1f} mm from where it was expected"
        return None

    def _perform(self, phase: Phase, path: PhasePath, *, completed: bool) -> None:
        added = phase.added if completed else frozenset[ir.Fact]()
        before = dict(self._places)
        executed = self.world.carry_out(
            Interval(phase.action, phase.mode, added, path, completed), FACTOR * (_knots(path) - 1) + 1
        )
        if completed:
            self._apply(phase.action)
        self.steps.append(Step(executed, before, dict(self._places)))

    def _apply(self, action: ir.Action) -> None:
        """What the action does to the facts. Its condition was true of the scene in which it was planned."""
        reached = self.world.reached
        interpreter = Interpreter(self._failures.base(self.problem))
        outcome = interpreter.effects(reached.facts, interpreter.canonical(reached.mode), action, reached.previous)
        self._places.update(outcome.places)
        self.world.reached = replace(reached, facts=outcome.facts, mode=outcome.motion, previous=action)
        self.world.begin(outcome.motion)
        self._way = self._way[1:]

    def _whole(self, path: PhasePath) -> PhasePath:
        """The motion with the joints of modules that are stuck or gone, at rest."""
        modules = {}
        count = _knots(path)
        for name, state in self.world.reached.configuration.modules.items():
            rows = path.modules.get(name)
            if rows is None:
                modules[name] = np.tile(state, (count, 1))
            elif rows.shape[1] < len(state):
                modules[name] = np.hstack([rows[:, :7], np.tile(state[7:], (count, 1))])
            else:
                modules[name] = rows
        return PhasePath(modules, path.bodies, path.duration)

    # --- the outcome ---------------------------------------------------------------------------------------------

    def _outcome(self, status: str) -> RunOutcome:
        import msgspec

        reached = self.world.reached
        statistics = StatisticsRecord(
            seconds={"total": self.budget.elapsed},
            refusals=self.planner.refusals.records() if self.planner.refusals is not None else [],
        )
        plan = plan_of_run(
            self.problem, self.steps, reached.mode, self._places, self.windows, statistics, status == "solved"
        )
        plan = msgspec.structs.replace(plan, verdict=verify(plan))
        assert plan.verdict is not None
        if status == "solved" and not plan.verdict.verified:
            status = "refused"
        return RunOutcome(status, plan, self._explanation)

    def _say(self, message: str) -> None:
        if self._tell is not None:
            done = sum(s.executed.interval.completed for s in self.steps)
            self._tell(RunProgress(message, self.world.time, done, len(self._way), self.budget.elapsed))


def _knots(path: PhasePath) -> int:
    return len(next(iter(path.modules.values())))


def replace_duration(path: PhasePath, seconds: float) -> PhasePath:
    """The same motion in more time."""
    return PhasePath(path.modules, path.bodies, seconds)
