"""Runs a task in the simulated world: plan a window, carry it out while looking, plan anew where the world differs.

    sense ──▶ foresee ──▶ plan a window ──▶ carry out a phase ──▶ …
      ▲                                          │ a body is not where it was expected, or a module fails
      └────────────── brake, and rest ◀──────────┘

Planning takes simulated time. Every planning is a `WindowRecord`.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ...compiler import ir
from ...compiler.printing_terms import format_formula
from ...langs.diagnostics import Diagnostic
from ...langs.source import Span
from ..budget import ASIDE, Budget, Status, ending, unless_spent
from ..machine import this_machine
from ..plan import StatisticsRecord, TimingRecord, WindowRecord
from ..planner.conflicts.infeasibility import ENDINGS, distrust, ended, unverified
from ..planner.motion.settings import ACCEPTANCE
from ..planner.receding.horizon_length import horizon_of
from ..planner.receding.window import WindowStatus
from ..planner.search.stepper import Stepper
from ..seeds import Seed
from ..skeleton import Phase, PhasePath
from ..verify import verify
from .braking import braked, first_part, reversed_path, stopped, waiting
from .dynamic_collisions import Struck, before_hit, first_hit
from .failures import Failures
from .monitor import Lookout
from .physical_world import GaveWay, PhysicalWorld
from .planning import Window
from .results import RunOptions, RunOutcome, RunProgress
from .route import Route
from .run_record import RunStep, joint_rows, plan_of_run
from .sensing import Sensing
from .settings import SIMULATION
from .steering import Steering
from .world import Interval, SimulatedWorld, moves


def world_of(problem: ir.Problem, options: RunOptions) -> SimulatedWorld:
    """The world that a run is in. Raises MissingLibrary."""
    if options.engine is None:
        return SimulatedWorld(problem, options.noise, options.seed)
    return PhysicalWorld(problem, options.seed)


class Run:
    """One run of a task; `run` carries it out. `first` is a window that is there already, such as a whole plan."""

    def __init__(
        self, problem: ir.Problem, options: RunOptions, tell: Callable[[RunProgress], None] | None = None,
        first: Window | None = None,
    ) -> None:  # fmt: skip
        self.problem = problem
        self.options = options
        self.world = world_of(problem, options)
        self.budget = Budget(options.solve.time, options.solve.nodes, ASIDE)
        self.steps: list[RunStep] = []
        self.windows: list[WindowRecord] = []
        self.seconds: list[float] = []
        self._tell = tell
        sensing = Sensing(options.noise.position, Seed(options.seed).child("sensing").random())
        self._failures = Failures(problem)
        self._lookout = Lookout(sensing)
        self._horizon = horizon_of(options.horizon)
        self._route = Route(problem, options.solve, self._horizon.length, self._failures, self._lookout, self.budget)
        self._places: dict[ir.Fact, Span | None] = {}
        self._trail: list[PhasePath] = []
        self._left: float | None = None
        self._waits = 0
        self._steered = self._asked = self._cost = 0.0
        self._first = first
        self._explanation: list[Diagnostic] = []

    def run(self) -> RunOutcome:
        """Until the goal is reached, the way ends, or the budget; Ctrl-C ends with what was carried out."""
        return self._outcome(ending(self._until_struck))

    def _until_struck(self) -> Status:
        try:
            return self._loop()
        except (Struck, GaveWay) as trouble:
            self._explanation = [trouble.diagnostic]
            return Status.STUCK

    def _loop(self) -> Status:
        reason = "start"
        while True:
            self.budget.check()
            self._hold()
            failed = self._failures.until(self.world.time, self.world.reached)
            self.world.reached = failed.reached
            if failed.lost is not None:
                self._explanation = [failed.lost]
                return Status.LOST
            if not self._unmet():
                self.world.rest()
                return Status.SOLVED
            window = self._plan(reason)
            if window is not None:
                self._route.planner.succeeded()
                reason = self._follow(window)
            elif self._gave_way():
                reason = "nothing led on"
            elif self._route.planner.may_redraw():
                reason = "drawn anew"
            else:
                return self._no_way()

    def _no_way(self) -> Status:
        planner = self._route.planner
        proved = planner.status == WindowStatus.INFEASIBLE
        if planner.refusals is not None:
            self._explanation = planner.refusals.explain(Status.INFEASIBLE if proved else Status.EXHAUSTED)
        if not self._explanation:
            self._explanation = [Diagnostic("S0002", f"nothing leads on to the goal: {', '.join(self._unmet())}")]
        # What moves by itself may come to where the conditions of another action hold.
        return Status.INFEASIBLE if proved and not self.problem.world.courses else Status.STUCK

    def _hold(self) -> None:
        """Rest until the next window can be there, or go back where something would press. Planning goes on since it
        was asked for: while a phase that is not disturbed is carried out, or while the robot brakes. The clock starts
        with the first window."""
        end = self._asked + self.options.latency
        failure = self._failures.due(end)
        end = end if failure is None else min(end, failure.time)
        if not self.steps or not self._route.way or not self._unmet() or end < self.world.time + SIMULATION.instant:
            return
        phase = Phase(self._route.way[0], self.world.reached.mode, frozenset[ir.Fact]())
        path = waiting(self.world.reached.configuration, end - self.world.time)
        back = None if self._route.is_clear(self.world, phase, path) else self._back(phase)
        if back is not None:
            path, self._left = back, None
        period = SIMULATION.sensing_period
        for look in np.arange(self.world.time + period, self.world.time + path.duration, period):
            self._lookout.look(self.world, float(look))
        self._perform(phase, path, completed=False)

    # --- planning ------------------------------------------------------------------------------------------------

    def _unmet(self) -> list[str]:
        """The parts of the goal that do not hold now."""
        base = self._failures.base(self.problem)
        goal = base.goal
        parts = goal.operands if isinstance(goal, ir.And) else (goal,)
        stepper = Stepper(base)
        return [format_formula(p) for p in parts if not stepper.holds(self.world.reached.facts, p)]

    def _plan(self, reason: str) -> Window | None:
        """The next window: on the known way, or else on another one; while the run goes back, on the known way only."""
        began, world = time.process_time(), self._foreseen()
        self._lookout.sensing.known = world.time - self.options.latency
        unmet = self._unmet()
        self._say(f"planning: {reason}")
        window, self._first = self._first, None
        known = bool(self._route.way)
        if window is not None:
            self._route.take(world, window)
        else:
            window = self._route.on_the_way(world, self._left)
            if known:
                self._adapt(window is None)
        if window is None and not (self._trail and self._route.planner.failures):
            window = self._route.another_way(world)
        seconds = time.process_time() - began
        actions = [str(a) for a in window.actions] if window is not None else []
        motions = len(window.paths) if window is not None else 0
        self.windows.append(
            WindowRecord(self.world.time, len(self.steps), reason, actions, motions, unmet)
        )
        self.seconds.append(seconds)
        return window

    def _foreseen(self) -> SimulatedWorld:
        """The world from which a window is planned."""
        return self.world

    def _adapt(self, hard: bool) -> None:
        """Tell the horizon whether the known way was refused."""
        self._horizon.adapt(hard)
        self._route.horizon = self._horizon.length

    def _gave_way(self) -> bool:
        """Where nothing leads on: out of the way, if that can be."""
        if not self.steps or not self._route.way:
            return False
        self._route.planner.failures += 1
        phase = Phase(self._route.way[0], self.world.reached.mode, frozenset[ir.Fact]())
        path = self._way_out(phase)
        if path is None:
            return False
        path = self._failures.whole(path, self.world.reached.configuration)
        near = self._route.near(self.world)
        if self._watched(phase, path, near, frozenset(), completed=False) is not None:
            self._trail = []
        self._left = None
        return True

    def _way_out(self, phase: Phase) -> PhasePath | None:
        """Some of what was broken off, back the way it came; else rest, for what moves may move on; else a motion to
        where the robot has room. Only what stays clear of everything will do."""
        world, route = self.world, self._route
        path = self._back(phase)
        if path is not None:
            return path
        if self._waits >= SIMULATION.most_waits or not world.on_course:
            return None
        self._waits += 1
        rest = waiting(world.reached.configuration, SIMULATION.wait)
        if route.is_clear(world, phase, rest):
            return rest
        aside = route.aside(world)
        return aside if aside is not None and route.is_clear(world, phase, aside) else None

    def _back(self, phase: Phase) -> PhasePath | None:
        """Some of what was broken off, back the way it came, where that is clear."""
        if not self._trail:
            return None
        last = self._trail.pop()
        share = SIMULATION.back_share if last.duration > SIMULATION.back_short else 1.0
        path = reversed_path(self.problem.world, last, share)
        stuck = any(moves(last.modules[name]) for name in self._failures.locked)
        if not stuck and self._route.is_clear(self.world, phase, path):
            self._trail += [first_part(last, 1.0 - share)] if share < 1.0 else []
            return path
        self._trail = []
        return None

    # --- carrying out --------------------------------------------------------------------------------------------

    def _follow(self, window: Window) -> str:
        """Carry out the phases of a window that have motions; why the next one is planned."""
        for phase, path in zip(window.skeleton.phases, window.paths, strict=False):
            self._say(str(phase.action))
            reason = self._carry_out(phase, self._failures.whole(path, self.world.reached.configuration))
            failed = self._failures.due(self.world.time)
            if reason is None and failed is not None:
                reason = f"{failed.module} is {failed.kind}"
            if reason is not None:
                return reason
            if self._steered:
                return f"next window; the last motion was steered by {1000 * self._steered:.1f} mm"
        return "next window"

    def _carry_out(self, phase: Phase, path: PhasePath) -> str | None:
        """One phase; when it is broken off, why. After one that was `_steered` none was planned to follow."""
        near = self._route.passed(self.world, phase, path)
        named = frozenset(a for literal in phase.mode | phase.added for a in literal[1:])
        self._left = None
        self._steered = 0.0
        steering = self._route.steering(self.world, phase, path) if self.world.on_course else None
        found = self._watched(phase, path, named, near, completed=True, steering=steering)
        if found is None:
            self._waits = 0
        return found

    def _watched(
        self, phase: Phase, path: PhasePath, named: frozenset[str], near: frozenset[str], *, completed: bool,
        steering: Steering | None = None,
    ) -> str | None:  # fmt: skip
        """Carry out a motion while looking at the bodies that it touches and passes; when it is broken off, why. That
        is done when something is found, or, where it would press upon the robot, a little later or not at all."""
        begin, failure = self.world.time, self._failures.next_of(phase, self.world.time)
        self._asked, pending = begin, False
        for look in np.arange(int(np.ceil(path.duration / SIMULATION.sensing_period))) * SIMULATION.sensing_period:
            since, now = float(look), begin + float(look)
            if failure is not None and begin < failure.time <= now:
                break
            self._lookout.look(self.world, now)
            path = self._steer(phase, path, since, steering)
            found = self._surprise(phase, path, named, near, since) if completed or since else None
            if found is None or not pending:
                self._asked = begin if found is None else now
            pending = found is not None
            until = self._asked + self.options.latency - begin
            if found is None or not self._route.is_time_to_stop(self.world, phase, path, since, until, steering):
                continue
            if since:
                self._break_off(phase, path, since, completed=completed)
            return found
        if failure is not None and failure.time < begin + path.duration:
            if failure.time - begin > SIMULATION.instant:
                self._perform(phase, path, completed=False)
            self.world.time = self._asked = max(self.world.time, failure.time)
            return f"{failure.module} is {failure.kind}"
        self._perform(phase, path, completed=completed)
        return None

    def _steer(self, phase: Phase, path: PhasePath, since: float, steering: Steering | None) -> PhasePath:
        """The motion, steered to what it meets where that is not where it was expected and can be met."""
        if steering is None or path.duration - since < SIMULATION.at_last:
            return path
        found, off = self._route.steered(self.world, phase, path, since, steering)
        if found is not path:
            self._steered = max(self._steered, off)
            now = self.world.time + since
            self._lookout.expect(now, self._lookout.look(self.world, now), newest=True)
        return found

    def _break_off(self, phase: Phase, path: PhasePath, since: float, *, completed: bool) -> None:
        """Slow down after `since` seconds; where it is too late for that, the motion goes on to its end."""
        slowed = braked(self.problem.world, path, since)
        self._perform(phase, slowed, completed=completed and slowed is path)
        if completed and slowed is not path:
            self._trail.append(slowed)
            self._left = path.duration - since

    def _surprise(
        self, phase: Phase, path: PhasePath, named: frozenset[str], near: frozenset[str], since: float
    ) -> str | None:
        """Why a motion has to be broken off after `since` seconds: a body that it touches is not where it should be, or
        one that it passes comes too near."""
        strayed = self._lookout.strayed(named | near, self.world.time + since)
        touched = [body for body in strayed if body in named]
        passed = strayed.keys() - named
        if not touched and not (passed and self._route.threatens(self.world, phase, path, since, passed)):
            return None
        body = touched[0] if touched else max(passed, key=lambda name: strayed[name])
        return f"{body} is {1000 * strayed[body]:.1f} mm from where it was expected"

    def _perform(self, phase: Phase, path: PhasePath, *, completed: bool) -> None:
        """Carry out a motion until it ends, or until something breaks down that it moves. Raises Struck where something
        that moves goes right through a robot meanwhile."""
        failure = self._failures.next_of(phase, self.world.time)
        if failure is not None and SIMULATION.instant < failure.time - self.world.time < path.duration:
            path, completed = stopped(self.problem.world, path, failure.time - self.world.time), False
        hit = first_hit(self.problem, self.world, phase, path)
        if hit is None:
            self._take_place(phase, path, completed=completed)
            return
        time, before = self.world.time + hit.seconds, before_hit(self.problem, path, hit)
        if before is not None:
            self._take_place(phase, before, completed=False)
        raise Struck(self.problem, hit, time)

    def _take_place(self, phase: Phase, path: PhasePath, *, completed: bool) -> None:
        added = phase.added if completed else frozenset[ir.Fact]()
        before = dict(self._places)
        executed = self.world.carry_out(
            Interval(phase.action, phase.mode, added, path, completed),
            ACCEPTANCE.stored_density * (path.samples - 1) + 1,
        )
        if completed:
            self._apply(phase.action)
            self._route.way, self._trail = self._route.way[1:], []
        self.steps.append(RunStep(executed, before, dict(self._places)))

    def _apply(self, action: ir.Action) -> None:
        """What the action does to the facts. Its condition was true of the scene in which it was planned."""
        reached = self.world.reached
        stepper = Stepper(self._failures.base(self.problem))
        self._cost += stepper.cost(reached.facts, action)
        step = stepper.effects(reached.facts, reached.mode, action)
        self._places.update(step.places)
        self.world.reached = replace(reached, facts=step.facts, mode=step.motion)
        self.world.begin(step.motion)
        self._route.arrived(self.world)

    # --- the outcome ---------------------------------------------------------------------------------------------

    def _outcome(self, status: Status) -> RunOutcome:
        import msgspec

        if status in ENDINGS:
            self._explanation = [ended(status, f"{self.world.time:.2f} s into the run")]
        reached, refused = self.world.reached, self._route.planner.refusals
        statistics = StatisticsRecord(
            cost=self._cost,
            refusals=[] if refused is None else refused.records(),
        )
        plan = plan_of_run(
            self.problem, self.steps, reached.mode, self._places, self.windows, statistics, status == Status.SOLVED,
            self.options.solve.minimise,
        )  # fmt: skip
        verdict = unless_spent(lambda: verify(plan, self.budget.whole))
        if verdict is None:
            status = Status.BUDGET if status == Status.SOLVED else status
            self._explanation = [*self._explanation, unverified()]
        elif not verdict.verified:
            status = status if status == Status.INTERRUPTED else Status.REFUSED
            self._explanation = [*self._explanation, *distrust(verdict)]
        timing = TimingRecord({"total": self.budget.elapsed}, self.seconds, this_machine())
        plan = msgspec.structs.replace(plan, verdict=verdict, timing=timing)
        told, done = joint_rows(self.problem, self.steps)
        return RunOutcome(status, plan, self._explanation, told, done, self.world.result)

    def _say(self, message: str) -> None:
        if self._tell is not None:
            done = sum(s.executed.interval.completed for s in self.steps)
            self._tell(RunProgress(message, self.world.time, done, len(self._route.way), self.budget.elapsed))
