"""The toolchain from Python: load a task, solve it, check and draw its plans.

Importing this module loads nothing of the planner; each function loads what it needs.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from os import PathLike
from typing import TYPE_CHECKING, Any

from .langs.counting import counted
from .plans import Plan, read_plan, record_of

if TYPE_CHECKING:
    from .compiler.ir import Problem
    from .langs.diagnostics import Diagnostic
    from .plans import PlanLike
    from .runtime.budget import Status
    from .runtime.engine.actor import Simulated
    from .runtime.plan import Plan as PlanRecord
    from .runtime.plan import StatisticsRecord, TimingRecord
    from .runtime.planner.lgp import Outcome, Progress, SolveOptions
    from .runtime.simulation.actuators import Noise
    from .runtime.simulation.results import RunProgress
    from .runtime.simulation.tracking import Deviations
    from .runtime.skeleton import NearestMiss


__all__ = ["Plan", "Result", "RunResult", "Task", "load", "loads", "read_plan", "task_of_plan"]

ENGINE = "mujoco"
BESIDE_OPTIONS = ("horizon", "jobs", "cluster", "progress", "found")
"""What `Task.solve` takes besides the planner's options."""
RUN_OPTIONS = ("plan", "horizon", "noise", "latency", "time", "seed", "engine", "minimise", "progress")


def load(path: str | PathLike[str], /, task: str | None = None, seed: int = 0, **parameters: str | float) -> Task:
    """Compile the task named `task` of the program at `path`; None takes the only one, or the one named like the file.

    `seed` steers the random parts of the scene and of the search. `parameters` override those of the task; a length
    or an angle is a text with its unit, such as "20 cm".
    Raises SourceError when the program has errors, and UsageError for a task or a parameter that is unknown or unfit.
    The time that it takes is not limited: see `Task.solve`.
    """
    from .compiler.pipeline import compile_problem
    from .runtime.native import prefer_one_thread

    prefer_one_thread()
    _check_seed(seed)
    texts = {name: str(value) for name, value in parameters.items()}
    with _shown_as_on_the_terminal():
        return Task(*compile_problem(path, task, texts, seed))


def loads(text: str, /, task: str | None = None, seed: int = 0, **parameters: str | float) -> Task:
    """`load` for a program that is a text; what it imports and names is looked for in the current folder.

    >>> task = loads("predicate (lit) rule light() { pre not (lit) post (lit) } task t() { goal (lit) }")
    >>> task
    <Task t: 0 modules, 0 bodies>
    """
    from .compiler.pipeline import compile_text
    from .runtime.native import prefer_one_thread

    prefer_one_thread()
    _check_seed(seed)
    if not isinstance(text, str):
        from .langs.diagnostics import UsageError

        raise UsageError(f"a program is a text, not {text!r:.40}")
    texts = {name: str(value) for name, value in parameters.items()}
    with _shown_as_on_the_terminal(str(text)):
        return Task(*compile_text(str(text), "<text>", task, texts, seed))


@contextmanager
def _shown_as_on_the_terminal(text: str = "") -> Iterator[None]:
    """Around what compiles: a traceback ends with all that is wrong, with its lines, as the command shows it."""
    from .langs.diagnostics import SourceError

    try:
        yield
    except SourceError as error:
        from .langs.diagnostics import sources_of
        from .langs.render import render
        from .langs.source import Source

        sources = {**sources_of(error.diagnostics), "<text>": Source("<text>", text)}
        error.add_note(f"\n{render(error.diagnostics, sources)}")
        raise


def _check_seed(seed: object) -> None:
    """Raises UsageError unless a seed is a whole number from 0."""
    if isinstance(seed, bool) or not isinstance(seed, int) or seed < 0:
        from .langs.diagnostics import UsageError

        raise UsageError(f"a seed is a whole number from 0, not {seed!r}")


@dataclass(frozen=True, slots=True, repr=False)
class Task:
    """A compiled task: its intermediate representation, and the warnings on the way to it."""

    problem: Problem
    warnings: tuple[Diagnostic, ...] = ()

    def __repr__(self) -> str:
        world = self.problem.world
        modules, bodies = counted(len(world.modules), "module"), counted(len(world.bodies), "body", "bodies")
        return f"<Task {self.problem.task}: {modules}, {bodies}>"

    def _repr_html_(self) -> str:
        """What a notebook shows: what there is, the goal, and the scene at the start in 3-D."""
        from .showing import task_html

        return task_html(self)

    def solve(
        self,
        *,
        bound: str | None = None,
        search: str | None = None,
        time: float | None = None,
        nodes: int | None = None,
        solutions: int = 1,
        solver: str | None = None,
        slices: int | None = None,
        minimise: str | None = None,
        gap: float | None = None,
        horizon: int | str | None = None,
        jobs: int = 1,
        cluster: str | None = None,
        progress: Callable[[Progress], None] | Any = None,
        found: Callable[[Plan], None] | None = None,
        **unknown: object,
    ) -> Result:
        """Plan the task. What is None here comes from the task's `options` block, else from the defaults
        (`compiler/options.py`).

        `bound` is "seq", "seq-path" or "path"; `search` "astar", "wastar", "bfs" or "guide"; `time` seconds from now
        (`math.inf`: no limit); `nodes` of the search tree; `solver` "algn" or "ipopt"; `slices` per phase;
        `minimise` an objective such as "makespan + 0.1 * travel"; behind a first plan `gap` lets the search go on until
        none can be better by more than this, as far as is known; `horizon`
        plans the motion of so many actions at a time, "auto" as many as seem wise. With `jobs` above 1, so many
        processes work side by side, or this one and the workers of the `cluster` at tcp://HOST:PORT: the result is the
        same. `progress` is called with where the run stands, or is a bar as tqdm's: what has `update` and `total`.
        `found` gets every verified plan as soon as it stands.

        The loops of search, motion and verifier look at the time; reading and compiling are `load`, which has no limit.
        Around whatever there is, `tamplang.runtime.guard.guarded(seconds, memory)` raises OutOfTime, in the main
        thread. Raises UsageError for an option that is `unknown` or does not take its value, MissingLibrary when a
        system library is missing, and ClusterUnavailable when no cluster answers.
        """
        from .compiler.options import check_given

        chosen = {
            "bound": bound, "search": search, "time": time, "nodes": nodes, "solutions": solutions, "solver": solver,
            "slices": slices, "minimise": minimise, "gap": gap,
        }  # fmt: skip
        check_given("python", chosen | unknown, BESIDE_OPTIONS)
        _check_count("horizon", horizon, "auto")
        _check_count("jobs", jobs)
        from .bars import callback, checked
        from .runtime.planner.bounds.speculation import opened
        from .runtime.planner.lgp import options_of

        options = options_of(self.problem, chosen)
        checked(found, "`found` is called with every plan")

        def hand_on(record: PlanRecord) -> None:
            if found is not None:
                found(Plan(record, fresh=True))

        with opened(jobs, cluster) as ahead:
            outcome = _solved(
                self.problem, replace(options, ahead=ahead), horizon, callback(progress), hand_on
            )
        return Result(
            outcome.status,
            tuple(Plan(record, fresh=True) for record in outcome.plans),
            tuple(outcome.explanation),
            outcome.statistics,
            outcome.timing,
            tuple(outcome.actions),
            outcome.cost,
            None if outcome.refused is None else Plan(outcome.refused, fresh=True),
            tuple(outcome.misses),
        )

    def run(
        self,
        *,
        plan: PlanLike | None = None,
        horizon: int | str | None = None,
        noise: Noise | None = None,
        latency: float | None = None,
        time: float | None = None,
        seed: int = 0,
        engine: str | None = None,
        minimise: str | None = None,
        progress: Callable[[RunProgress], None] | Any = None,
        **unknown: object,
    ) -> RunResult:
        """Carry the task out in the simulated world, planning on the way; `plan`, a plan or the name of its file, is
        followed as long as the world allows it. `horizon` actions get their motion in one window, whose planning takes
        `latency` simulated seconds (None: the default); `seed` steers the noise; `minimise` is as in `solve`. With
        `engine` "mujoco" joints go where that lets them, and docks and feet break beyond their strength; only scenes
        that rest can be carried out so (`tamplang.runtime.simulation.execution.StillOnly`). `progress` is as in
        `solve`. Raises UsageError for an option that is `unknown` or does not take its value, and MissingLibrary when
        a system library, or the engine, is missing.
        """
        from .bars import run_callback
        from .compiler.options import check_given
        from .runtime.simulation.execution import execute

        for name in unknown:
            from .langs.diagnostics import UsageError, did_you_mean

            raise UsageError(f"there is no option `{name}`", help=did_you_mean(name, RUN_OPTIONS))
        check_given("python", {"minimise": minimise, "time": time})
        _check_count("horizon", horizon, "auto")
        _check_seed(seed)
        _check_run(noise, latency, engine)
        record = None if plan is None else record_of(plan)
        told = run_callback(progress)
        found = execute(self.problem, record, horizon, noise, time, seed, latency, told, engine, minimise)
        return RunResult(*found)


def _check_run(noise: object, latency: object, engine: object) -> None:
    """Raises UsageError unless these options of a run are None or what they should be."""
    from .langs.diagnostics import UsageError, did_you_mean
    from .runtime.simulation.actuators import Noise

    if noise is not None and not isinstance(noise, Noise):
        raise UsageError(f"option `noise` is a `tamplang.Noise`, not {noise!r}")
    number = isinstance(latency, int | float) and not isinstance(latency, bool) and 0.0 <= latency < math.inf
    if latency is not None and not number:
        raise UsageError(f"option `latency` is a number of seconds from 0, not {latency!r}")
    if engine not in (None, ENGINE):
        raise UsageError(f"option `engine` is {ENGINE}, not {engine!r}", help=did_you_mean(str(engine), [ENGINE]))


def _check_count(name: str, value: object, word: str | None = None) -> None:
    """Raises UsageError unless an option is None, a whole number from 1, or the `word`."""
    if value is None or value == word or (isinstance(value, int) and not isinstance(value, bool) and value >= 1):
        return
    from .langs.diagnostics import UsageError, did_you_mean

    near = did_you_mean(value, [word]) if isinstance(value, str) and word else None
    known = "a whole number from 1" + (f" or {word}" if word else "")
    raise UsageError(f"option `{name}` is {known}, not {value!r}", help=near)


def _solved(
    problem: Problem,
    options: SolveOptions,
    horizon: int | str | None,
    progress: Callable[[Progress], None] | None,
    found: Callable[[PlanRecord], None],
) -> Outcome:
    """The whole task at once, or with a receding horizon."""
    if horizon is None:
        from .runtime.planner.lgp import solve

        return solve(problem, options, progress, found)
    from .runtime.planner.receding.receding_horizon import solve_receding

    return solve_receding(problem, options, None if horizon == "auto" else int(horizon), progress, found)


@dataclass(frozen=True, slots=True, repr=False)
class Result:
    """What a run found. `status` equals one of the words "solved", "infeasible" (proved), "exhausted", "budget",
    "memory", "interrupted" or "refused" (by the verifier); `plans` are best first, and all verified; `explanation`
    says what refused the task. `refused` is a plan that the verifier does not believe, or had no time for, to look
    into, where there is no other; `misses` are postures that came nearest, which the report draws."""

    status: Status
    plans: tuple[Plan, ...]
    explanation: tuple[Diagnostic, ...]
    statistics: StatisticsRecord
    timing: TimingRecord
    actions: tuple[str, ...]
    cost: float
    refused: Plan | None = None
    misses: tuple[NearestMiss, ...] = ()

    def __repr__(self) -> str:
        return f"<Result {self.status}: {counted(len(self.plans), 'plan')}, cost {self.cost:g}>"

    def _repr_html_(self) -> str:
        """What a notebook shows: the best plan, or what refused the task."""
        from .showing import result_html

        return result_html(self)

    @property
    def plan(self) -> Plan | None:
        """The best plan, or None."""
        return self.plans[0] if self.plans else None


@dataclass(frozen=True, slots=True, repr=False)
class RunResult:
    """What came of a run. `status` equals "solved", "stuck", "infeasible", "lost" (with a module that left), "budget",
    "interrupted" or "refused" (by the verifier); `plan` is what was carried out; `deviations` tell how simulated drives
    follow it; `replans` counts the windows after the first."""

    status: Status
    record: PlanRecord
    explanation: tuple[Diagnostic, ...]
    deviations: Deviations
    carried: Simulated | None = None
    """What a physics engine found."""

    def __repr__(self) -> str:
        actions, replans = counted(len(self.record.phases), "action"), counted(self.replans, "replan")
        return f"<RunResult {self.status}: {actions}, {replans}>"

    def _repr_html_(self) -> str:
        """What a notebook shows: how it ended, and what was carried out."""
        from .showing import run_html

        return run_html(self)

    @property
    def plan(self) -> Plan:
        """What was carried out."""
        return Plan(self.record, fresh=True)

    @property
    def replans(self) -> int:
        """How many windows were planned after the first."""
        return max(0, len(self.record.windows) - 1)

    @property
    def latency(self) -> float:
        """Seconds of computing of a replanning, in the median; 0 without any."""
        from statistics import median

        return median(self.seconds[1:]) if self.replans else 0.0

    @property
    def worst_latency(self) -> float:
        """Seconds of computing of the longest replanning."""
        return max(self.seconds[1:], default=0.0)

    @property
    def seconds(self) -> list[float]:
        """Seconds of computing of every window; 0 for those of a plan that does not tell."""
        told = [] if self.record.timing is None else self.record.timing.windows
        return (told + [0.0] * len(self.record.windows))[: len(self.record.windows)]


def task_of_plan(record: PlanRecord) -> Task:
    """The task that a plan is of, compiled anew from its own sources. Raises SourceError, UsageError."""
    from .compiler.pipeline import compile_sources
    from .langs.source import Source
    from .runtime.plan_parameters import parameter_texts

    sources = [Source(s.path, s.text) for s in record.task.sources]
    files = {f.path: f.data for f in record.task.files}
    texts = parameter_texts(record, sources)
    return Task(*compile_sources(sources, record.task.name, texts, record.task.seed, files))
