"""The toolchain from Python: load a task, solve it, check and draw its plans.

Importing this module loads nothing of the planner; each function loads what it needs.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from os import PathLike, fspath
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .compiler.ir import Problem
    from .langs.diagnostics import Diagnostic
    from .runtime.lgp import Progress
    from .runtime.plan import Plan as PlanRecord
    from .runtime.plan import StatisticsRecord, VerdictRecord


def load(path: str | PathLike[str], /, task: str | None = None, seed: int = 0, **parameters: str | float) -> Task:
    """Compile the task named `task` of the program at `path`; None takes the only one, or the one named like the file.

    `seed` steers the random parts of the scene and of the search. `parameters` override those of the task; a length
    or an angle is a text with its unit, such as "20 cm".
    Raises `tamplang.langs.diagnostics.SourceError` when the program has errors, and
    `tamplang.compiler.pipeline.UsageError` for a task or a parameter that is unknown or unfit.
    """
    from .compiler.pipeline import compile_problem

    texts = {name: str(value) for name, value in parameters.items()}
    problem, warnings = compile_problem(path, task, texts, seed)
    return Task(problem, warnings)


@dataclass(frozen=True, slots=True)
class Task:
    """A compiled task: its intermediate representation, and the warnings on the way to it."""

    problem: Problem
    warnings: tuple[Diagnostic, ...] = ()

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
        horizon: int | str | None = None,
        progress: Callable[[Progress], None] | None = None,
        found: Callable[[Plan], None] | None = None,
    ) -> Result:
        """Plan the task. What is None here comes from the task's `options` block, else from the defaults.

        `bound` is "seq", "seq-path" or "path"; `search` "astar", "wastar", "bfs" or "guide"; `time` seconds
        (`math.inf`: no limit); `nodes` of the search tree; `solver` "algn" or "ipopt"; `slices` per phase; `horizon`
        plans the motion of so many actions at a time, "auto" as many as seem wise. `found` gets every verified plan as
        soon as it stands.
        Raises `tamplang.runtime.native.MissingLibrary` when a system library is missing.
        """
        from .runtime.lgp import SolveOptions, solve

        given = self.problem.options
        default = SolveOptions()
        seconds = next(t for t in (time, given.time, default.time, math.inf) if t is not None)
        options = SolveOptions(
            bound=bound or given.bound or default.bound,
            search=search or given.search or default.search,
            time=None if math.isinf(seconds) else seconds,
            nodes=nodes or given.nodes,
            solutions=solutions,
            solver=solver or given.solver or default.solver,
            seed=self.problem.seed,
            slices=slices or given.slices,
        )

        def hand_on(record: PlanRecord) -> None:
            if found is not None:
                found(Plan(record))

        if horizon is None:
            outcome = solve(self.problem, options, progress, hand_on)
        else:
            from .runtime.horizon.receding import solve_receding

            count = None if horizon == "auto" else int(horizon)
            outcome = solve_receding(self.problem, options, count, progress, hand_on)
        return Result(
            outcome.status,
            tuple(Plan(record) for record in outcome.plans),
            tuple(outcome.explanation),
            outcome.statistics,
            tuple(outcome.actions),
            outcome.cost,
        )


@dataclass(frozen=True, slots=True)
class Result:
    """What a run found. `status` is "solved", "infeasible" (proved), "exhausted", "budget", "interrupted" or
    "refused" (by the verifier); `plans` are best first; `explanation` says what refused the task."""

    status: str
    plans: tuple[Plan, ...]
    explanation: tuple[Diagnostic, ...]
    statistics: StatisticsRecord
    actions: tuple[str, ...]
    cost: float

    @property
    def plan(self) -> Plan | None:
        """The best plan, or None."""
        return self.plans[0] if self.plans else None


@dataclass(frozen=True, slots=True)
class Plan:
    """A plan; `record` is what a plan file holds (`docs/plan-format.md`)."""

    record: PlanRecord

    @property
    def actions(self) -> tuple[str, ...]:
        """The actions in order."""
        return tuple(phase.action for phase in self.record.phases)

    def verify(self) -> VerdictRecord:
        """Check the plan anew, with none of the planner's code."""
        from .runtime.verify import verify

        return verify(self.record)

    def report(self, path: str | PathLike[str]) -> None:
        """Write the report: one HTML file that works offline. Raises OSError."""
        from .runtime.report import write_report

        write_report(self.record, fspath(path))

    def save(self, path: str | PathLike[str]) -> None:
        """Write the plan file, atomically. Raises OSError."""
        from .runtime.plan import write_plan

        write_plan(self.record, fspath(path))


def read_plan(path: str | PathLike[str]) -> Plan:
    """Read a plan file. Raises `tamplang.runtime.plan.PlanFileError`."""
    from .runtime.plan import read_plan as read

    return Plan(read(fspath(path)))
