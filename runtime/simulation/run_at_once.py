"""Runs in which seconds count: robots move at once, and while one is replanned the others move on.

A window is put on a time line on which motions are underway. When one of them has to be broken off, it comes to rest
along its path, with those that wait for it; all others go on. The next window is planned from where everything will be
then, and its motions begin as soon as it is there and nothing is in their way.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Sequence
from dataclasses import replace

from ...compiler import ir
from ..budget import Status
from ..geometry.attachments import carrier
from ..planner.bounds.length_unit import length_unit
from ..planner.lgp import motion_settings
from ..planner.receding.mid_run_state import Reached, moved, reached_problem
from ..planner.schedule.clearance import NEVER, SegmentClearances
from ..planner.schedule.dependencies import Precedence, precedence
from ..planner.schedule.list_schedule import Timetable
from ..planner.schedule.scheduled_plan import plan_order
from ..planner.schedule.stage import Scheduler, configurations
from ..planner.search.stepper import Inapplicable, Stepper
from ..seeds import Seed
from ..skeleton import Phase, PhasePath, Skeleton
from .dynamic_collisions import Struck, first_hit
from .planning import Window
from .results import RunOptions, RunOutcome, RunProgress
from .run import Run
from .run_record import RunStep
from .settings import SIMULATION
from .underway import TICK, MotionUnderway, Underway
from .world import SimulatedWorld

LOOK = round(SIMULATION.sensing_period / TICK)
"""Ticks between two looks at the scene."""


def goes_at_once(problem: ir.Problem, options: RunOptions) -> bool:
    """Whether a run is one of these: modules that fail, and engines, have one action after the other."""
    several = len(problem.world.modules) > 1 and not problem.world.breakdowns
    return options.solve.minimise.timed and several and options.engine is None


class RunAtOnce(Run):
    """One run of a task whose robots move at once."""

    def __init__(
        self, problem: ir.Problem, options: RunOptions, tell: Callable[[RunProgress], None] | None = None,
        first: Window | None = None,
    ) -> None:  # fmt: skip
        super().__init__(problem, options, tell, first)
        self._underway = Underway(self.world)
        self._coming: list[MotionUnderway] = []
        self._beyond: tuple[ir.Action, ...] = ()
        self._why: str | None = None
        self._settings = motion_settings(problem, options.solve)
        self._margin = self._settings.margin * length_unit(problem)

    # --- planning ------------------------------------------------------------------------------------------------

    def _hold(self) -> None:
        """Until the next window can be there all that is underway goes on; to its end where nothing is left to plan."""
        line = self._underway
        if not line.open:
            super()._hold()
            return
        while line.now < self._ready():
            why = self._advance(min(line.now + LOOK, self._ready()))
            self._why = self._why or why
        if self._is_last():
            self._why = self._settle()

    def _is_last(self) -> bool:
        """Whether the goal is reached once all that is underway has come to its end."""
        return Stepper(self.problem).holds(self._ahead().facts, self.problem.goal)

    def _ready(self) -> int:
        """The tick at which the next window can be there, and what was broken off has come to rest."""
        line = self._underway
        asked = round((self._asked + self.options.latency - line.origin) / TICK)
        return max([asked, *(m.end for m in line.motions if m.switch is None)])

    def _plan(self, reason: str) -> Window | None:
        reason, self._why = self._why or reason, None
        return super()._plan(reason)

    def _foreseen(self) -> SimulatedWorld:
        """The world as it is now, but with all at its end that is underway."""
        if not self._underway.open:
            return self.world
        view = copy.copy(self.world)
        view.reached, view.time = self._ahead(), self._underway.time(self._underway.now)
        return view

    def _ahead(self) -> Reached:
        """The state once all that is underway has come to its end."""
        before, skeleton, paths = self._begun()
        stepper, facts = Stepper(self.problem), before.facts
        for phase in skeleton.phases:
            facts = stepper.effects(facts, phase.mode, phase.action).facts
        configuration = moved(skeleton.problem, skeleton, paths, before.configuration)
        return Reached(facts, skeleton.final_mode, configuration)

    def _begun(self, more: Sequence[ir.Action] = ()) -> tuple[Reached, Skeleton, list[PhasePath]]:
        """The state had nothing begun of what is underway, the skeleton of that and `more`, and the paths of what is
        underway, on which all rests that they do not move."""
        active, world = self._underway.active, self.world
        before = replace(world.reached, configuration=self._underway.before())
        problem = reached_problem(self._failures.base(self.problem), before)
        phases, mode = _phases(problem, [*(m.phase.action for m in active), *more])
        skeleton, now, paths = Skeleton(problem, tuple(phases), mode), before.configuration, []
        for phase, motion in zip(phases, active, strict=False):
            paths.append(motion.alone(now))
            now = moved(problem, Skeleton(problem, (phase,), mode), paths[-1:], now)
        return before, skeleton, paths

    def _gave_way(self) -> bool:
        """Where nothing leads on, all that is underway ends first: from there something may."""
        if self._underway.open:
            self._why = self._settle() or "nothing led on"
            return True
        return super()._gave_way()

    # --- carrying out ----------------------------------------------------------------------------------------------

    def _follow(self, window: Window) -> str:
        line = self._underway
        if window.moving or not window.paths:
            if line.open:
                return self._settle() or "what moves by itself is near"
            return super()._follow(window)
        if not line.open:
            line.restart()
        found = self._placed(window)
        if found is None and line.open:
            broken = self._settle()
            if broken is not None:
                return broken
            line.restart()
            found = self._placed(window)
        if found is None:
            return super()._follow(window)
        self._coming, self._beyond = found, window.actions[len(window.paths) :]
        self._trail, self._left = [], None
        self._asked = line.time(max(m.start for m in found))
        self._lead_on()
        while self._coming:
            broken = self._advance(line.now + LOOK)
            if broken is not None:
                return broken
        return "next window"

    def _lead_on(self, again: Sequence[MotionUnderway] = ()) -> None:
        """The way on: what is to be done `again` or to begin, in the order of its switches, and what lies beyond."""
        motions = sorted((*again, *self._coming), key=lambda m: m.switch or 0)
        self._route.way = (*(m.phase.action for m in motions), *self._beyond)

    def _placed(self, window: Window) -> list[MotionUnderway] | None:
        """The motions of a window on the time line, those first that begin first; what is underway gets new switches.
        None where no schedule was found."""
        count, line = len(window.paths), self._underway
        active = line.active
        _, skeleton, begun = self._begun(window.actions[:count])
        actions, paths = [phase.action for phase in skeleton.phases], [*begun, *window.paths]
        seed = Seed(self.options.seed).child("at once", len(self.windows))
        scheduler = Scheduler(skeleton.problem, self._margin, seed, self.budget)
        try:
            made = scheduler.placed(skeleton, actions, paths, [m.start for m in active], line.now)
        except (Inapplicable, ValueError):
            made = None
        if made is None:
            return None
        return self._motions(skeleton, active, *made)

    def _motions(
        self, skeleton: Skeleton, active: Sequence[MotionUnderway], table: Timetable, order: Precedence
    ) -> list[MotionUnderway] | None:
        line = plan_order(table)
        done = _phases(skeleton.problem, [skeleton.phases[k].action for k in line])[0]
        found = list(active)
        for k in range(len(active), len(skeleton)):
            segment, start = order.segments[k], table.starts[k]
            if segment is None or start is None:
                return None
            phase = done[line.index(k)]
            found.append(MotionUnderway(phase, segment, start, None, _named(skeleton.problem, phase, segment.held)))
        for k, motion in enumerate(found):
            motion.switch = table.switches[k]
            motion.behind = [found[j] for j in order.ordered[k] | order.begins_after[k] | order.closes[k] if j != k]
        return sorted(found[len(active) :], key=lambda m: m.start)

    def _advance(self, until: int) -> str | None:
        """Let time pass until a tick and look; why something was broken off."""
        line = self._underway
        self.budget.check()
        line.now = until
        while self._coming and self._coming[0].start < until:
            motion = self._coming.pop(0)
            motion.drive(self.world, line.configuration(motion.start))
            line.motions.append(motion)
            self._lead_on()
            self._say(str(motion.phase.action))
        for motion in line.active:
            if motion.switch is not None and motion.switch <= until:
                self._take(motion.phase, motion.switch, completed=True)
                motion.switch = None
        line.took_place(line.done)
        self._lookout.look(self.world, line.time(until))
        return self._look_round()

    def _take(self, phase: Phase, tick: int, *, completed: bool) -> None:
        """Everything up to a tick takes place, and with `completed` the switch of the phase. Raises Struck."""
        line, before = self._underway, dict(self._places)
        interval, told, driven = line.interval(phase, tick, completed=completed)
        hit = first_hit(self.problem, self.world, Phase(phase.action, interval.mode, interval.added), interval.path)
        if hit is not None:
            at = self.world.time + hit.seconds
            self._take_back()
            raise Struck(self.problem, hit, at)
        executed = self.world.carry_on(interval, told, driven)
        self.world.time = line.time(tick)
        line.took_place(tick)
        if completed:
            self._apply(phase.action)
        self.steps.append(RunStep(executed, before, dict(self._places)))

    def _take_back(self) -> None:
        """Forget what was carried out since everything was at rest: the run ends there."""
        while self.steps and self.steps[-1].executed.interval.through:
            step = self.steps.pop()
            self.world.reached, self._places = step.executed.before, dict(step.before)
            self.world.time = float(step.executed.times[0])
        self.windows = [w for w in self.windows if w.phase <= len(self.steps)]
        self.seconds = self.seconds[: len(self.windows)]

    def _outcome(self, status: Status) -> RunOutcome:
        self._take_back()
        return super()._outcome(status)

    def _settle(self) -> str | None:
        """Let all that is underway come to its end, and take place; why something was broken off meanwhile."""
        line, broken = self._underway, None
        while any(m.end > line.now or m.switch is not None for m in line.motions):
            broken = self._advance(line.now + LOOK) or broken
        goal = Stepper(self.problem).holds(self.world.reached.facts, self.problem.goal)
        last = max([m.end for m in line.motions] + ([] if goal else [line.now]), default=line.done)
        if last > line.done:
            action = self._route.way[0] if self._route.way else self.steps[-1].executed.interval.action
            self._take(Phase(action, self.world.reached.mode, frozenset()), last, completed=False)
        line.restart()
        return broken

    # --- looking -----------------------------------------------------------------------------------------------------

    def _look_round(self) -> str | None:
        """Break off what cannot go on; why."""
        line = self._underway
        reasons = {m: why for m in line.active if m.end > line.now if (why := self._wrong(m)) is not None}
        dropped = [why for m in self._coming if (why := self._strayed(m)) is not None]
        if not reasons and not dropped:
            return None
        stopped = self._stopped(list(reasons))
        while crossed := self._crossed(stopped):
            stopped = self._stopped([*stopped, *crossed])
        if stopped and line.now > line.done:
            self._take(min(stopped, key=lambda m: m.switch or 0).phase, line.now, completed=False)
        self._lead_on(stopped)
        self._beyond, self._coming = self._route.way, []
        for motion in stopped:
            self._stop(motion)
        self._asked = line.time(line.now)
        return next(iter(reasons.values()), None) or dropped[0]

    def _strayed(self, motion: MotionUnderway) -> str | None:
        """What a motion touches and is not where it was expected."""
        strayed = self._lookout.strayed(motion.named, self._underway.time(self._underway.now))
        if not strayed:
            return None
        body = max(strayed, key=lambda name: strayed[name])
        return f"{body} is {1000 * strayed[body]:.1f} mm from where it was expected"

    def _wrong(self, motion: MotionUnderway) -> str | None:
        """Why a motion that is underway has to be broken off."""
        touched = self._strayed(motion)
        if touched is not None or not self.world.on_course:
            return touched
        line = self._underway
        passed = self._lookout.strayed(frozenset(self.world.on_course) - motion.named, line.time(line.now))
        if not passed:
            return None
        view = copy.copy(self.world)
        view.time = line.time(motion.start)
        since = (line.now - motion.start) * TICK
        path = motion.alone(view.reached.configuration)
        if not self._route.threatens(view, motion.phase, path, since, passed, motion.segment.held):
            return None
        body = max(passed, key=lambda name: passed[name])
        return f"{body} is {1000 * passed[body]:.1f} mm from where it was expected"

    def _stopped(self, wrong: Sequence[MotionUnderway]) -> list[MotionUnderway]:
        """Those that are broken off, and all that wait for them, or whose actions cannot be done without theirs."""
        stopped = list(wrong)
        grew = True
        while grew:
            grew = False
            for motion in self._underway.active:
                if motion not in stopped and any(m in stopped for m in motion.behind):
                    stopped.append(motion)
                    grew = True
            rest = [m for m in self._underway.active if m not in stopped]
            stepper = Stepper(self._failures.base(self.problem))
            facts, mode = self.world.reached.facts, self.world.reached.mode
            for motion in rest:
                try:
                    step = stepper.step(facts, mode, motion.phase.action)
                except Inapplicable:
                    stopped.append(motion)
                    grew = True
                    break
                facts, mode = step.facts, step.motion
        return stopped

    def _crossed(self, stopped: Sequence[MotionUnderway]) -> list[MotionUnderway]:
        """Those that go on and would come too near one that is brought to rest."""
        line = self._underway
        _, skeleton, paths = self._begun()
        active, now = line.active, self.world.reached.configuration
        slowed = {m: m.broken_off(self.world, line.now, exact=True) for m in stopped if m.end > line.now}
        paths = [path if (other := slowed.get(m)) is None else other.alone(now)
                 for m, path in zip(active, paths, strict=True)]  # fmt: skip
        order = precedence(skeleton, paths, TICK)
        near = SegmentClearances(skeleton, order, configurations(skeleton, paths), self._margin)
        found = []
        for k, one in enumerate(active):
            if one in stopped or order.segments[k] is None or one.end <= line.now:
                continue
            for j, other in enumerate(active):
                rest = order.segments[j]
                if other not in stopped or rest is None or one.segment.held & other.segment.held:
                    continue
                meets = near.first_meeting(k, j, other.start - one.start) != NEVER
                ended = other.start + rest.ticks - one.start
                if meets or any(near.blocked_past(k, thing, j).max(initial=-1) >= ended for thing in rest.moved):
                    found.append(one)
                    break
        return found

    def _stop(self, motion: MotionUnderway) -> None:
        """Bring a motion to rest without its switch; one that cannot rest sooner does so at its end."""
        line = self._underway
        motion.switch = None
        slowed = motion.broken_off(self.world, line.now) if motion.end > line.now else None
        line.motions[line.motions.index(motion)] = motion if slowed is None else slowed


def _named(problem: ir.Problem, phase: Phase, held: frozenset[str]) -> frozenset[str]:
    """What the literals of a phase name that add something, or hold what moves."""
    literals = [f for f in phase.mode if any(carrier(problem, a) in held for a in f[1:])]
    return frozenset(a for literal in (*literals, *phase.added) for a in literal[1:])


def _phases(problem: ir.Problem, actions: Sequence[ir.Action]) -> tuple[list[Phase], frozenset[ir.Fact]]:
    """The phases of actions whose conditions are not asked, and the motion literals behind them."""
    stepper, facts, phases = Stepper(problem), problem.init, []
    mode = stepper.canonical(problem.init_motion)
    for action in actions:
        step = stepper.effects(facts, mode, action)
        phases.append(Phase(action, mode, step.added))
        facts, mode = step.facts, step.motion
    return phases, mode
