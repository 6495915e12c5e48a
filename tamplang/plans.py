"""Plans from Python: what they hold, as arrays, tables, plots and pages."""

from __future__ import annotations

from dataclasses import dataclass
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from .langs.counting import counted

if TYPE_CHECKING:
    from .api import Task
    from .runtime.export.motion import Array, Trajectory
    from .runtime.plan import Plan as PlanRecord
    from .runtime.plan import VerdictRecord

    PlanLike: TypeAlias = "Plan | PlanRecord | str | PathLike[str]"
    """What is taken where a plan is: a plan, its record, or the name of its file."""


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class Plan:
    """A plan; `record` is what a plan file holds (`docs/plan-format.md`). The verdict in it is `fresh` when it was made
    in this process, and not read from a file.

    Plans are equal when they do the same in the same task: every action, place and instant of the motion, and the texts
    that it was made from. How a plan was found, how long that took and what verdict it has do not count, so that a plan
    equals its file, read, and what the same task, seed and options give again. Equal plans have one hash."""

    record: PlanRecord
    fresh: bool = False

    def __eq__(self, other: object) -> bool:
        from .runtime.plan import what_it_does

        return what_it_does(self.record) == what_it_does(other.record) if isinstance(other, Plan) else NotImplemented

    def __hash__(self) -> int:
        return hash((self.record.task.name, self.actions, self.record.times[-1]))

    def __repr__(self) -> str:
        actions = counted(len(self.record.phases), "action")
        return f"<Plan of {self.record.task.name}: {actions}, {self.record.times[-1]:.2f} s>"

    def _repr_html_(self) -> str:
        """What a notebook shows: the actions in order, the verdict, and the replay in 3-D, which works offline."""
        from .showing import plan_html

        return plan_html(self)

    def trajectory(self, module: str, rate: float | None = None) -> Trajectory:
        """The joint motion of a module such as "c[1]" at the samples of the plan, or at `rate` hertz: `joints` by name,
        `t` (T,) in seconds, and `q`, `dq`, `ddq` (T, joints), in rad or m. Raises UsageError."""
        from .runtime.export.motion import times, trajectory

        return trajectory(self.record, module, times(self.record, rate))

    def poses(self, name: str, rate: float | None = None) -> Array:
        """Poses (T, 7) in the world, x, y, z, qx, qy, qz, qw, of a module, a body, or an effector such as "c[1].A", at
        the samples of the plan or at `rate` hertz. Raises UsageError."""
        from .runtime.export.motion import poses, times

        return poses(self.record, name, times(self.record, rate))

    def to_dataframe(self, rate: float | None = None) -> Any:
        """The columns of `tamplang export --to csv` as a pandas.DataFrame with the time, seconds, as its index.
        Needs the extra `notebook`; raises MissingLibrary without it, and UsageError for a rate that is none."""
        from .tables import dataframe

        return dataframe(self.record, rate)

    def plot_joints(self, *modules: str) -> Any:
        """A matplotlib Figure of the joint values of `modules`, or of all that move, over time, with their limits.
        Needs the extra `notebook`; raises MissingLibrary without it, and UsageError for an unknown module."""
        from .tables import joints_figure

        return joints_figure(self.record, modules)

    def plot_clearance(self) -> Any:
        """A matplotlib Figure of how near each module, with what it holds, comes to what is not of its robot.
        Needs the extra `notebook`; raises MissingLibrary without it."""
        from .tables import clearance_figure

        return clearance_figure(self.record)

    @property
    def actions(self) -> tuple[str, ...]:
        """The actions in order."""
        return tuple(phase.action for phase in self.record.phases)

    @property
    def verified(self) -> bool:
        """Whether this process found nothing wrong with the plan, at the end of which the goal holds. What a file says
        of itself does not count: `verify` looks anew."""
        verdict = self.record.verdict
        return self.fresh and verdict is not None and verdict.verified and verdict.goal_reached

    def verify(self, time: float | None = None, against: Task | None = None) -> VerdictRecord:
        """Check the plan anew, with none of the planner's code. Its own texts are what it is checked against; with
        `against`, it is refused where that task says otherwise. Raises OutOfTime when `time` seconds are
        not enough, and UsageError for a time or a task that is none."""
        from .api import Task
        from .compiler.options import check_given
        from .langs.diagnostics import UsageError
        from .runtime.budget import Budget
        from .runtime.verify import verify

        check_given("python", {"time": time})
        if against is not None and not isinstance(against, Task):
            raise UsageError(f"a plan is checked against a `tamplang.Task`, not {against!r:.40}")
        return verify(self.record, Budget(time), None if against is None else against.problem)

    def report(self, path: str | PathLike[str], unchecked: bool = False, time: float | None = None) -> None:
        """Write the report: one HTML file that works offline. A verdict that was read from a file is made anew, within
        `time` seconds, or, with `unchecked`, shown as what it is. Raises OSError, and OutOfTime."""
        from msgspec.structs import replace as changed

        from .runtime.report import write_report

        record = self.record
        if not self.fresh and not unchecked:
            record = changed(record, verdict=self.verify(time))
        write_report(record, fspath(path), checked=self.fresh or not unchecked)

    def compare(self, other: PlanLike, path: str | PathLike[str], unchecked: bool = False) -> None:
        """Write the report of this plan beside `other`. Verdicts that were read from files are made anew, unless
        `unchecked`. Raises OSError, and PlanFileError when `other` is the name of a file that is none of a plan."""
        from msgspec.structs import replace as changed

        from .runtime.report.compare import write_comparison

        pair = self, other if isinstance(other, Plan) else Plan(record_of(other))
        shown = [
            p.record if p.fresh or unchecked else changed(p.record, verdict=p.verify()) for p in pair
        ]  # fmt: skip
        write_comparison(shown[0], shown[1], ("first", "second"), fspath(path), checked=not unchecked)

    def export(
        self, form: str, path: str | PathLike[str], rate: float | None = None, module: str | None = None,
        phase: int = 0, at: float | None = None,
    ) -> None:  # fmt: skip
        """Write the plan for another tool, in a form of `tamplang export --to`, with the same meaning. Raises
        UsageError, MissingLibrary and OSError."""
        from .api import task_of_plan
        from .langs.diagnostics import UsageError, did_you_mean
        from .runtime.export import FORMS, SYMBOLIC, write
        from .runtime.report import pictures

        known = (*FORMS, *pictures.FORMS)
        if form not in known:
            raise UsageError(f"there is no form `{form}` to export", help=did_you_mean(form, known) or ", ".join(known))
        if form in pictures.FORMS:
            pictures.write_picture(self.record, form, Path(path), rate, at)
            return
        problem = task_of_plan(self.record).problem if form in SYMBOLIC else None
        write(self.record, form, Path(path), rate, module, phase, problem)

    def save(self, path: str | PathLike[str]) -> None:
        """Write the plan file, atomically. Raises OSError."""
        from .runtime.plan_files import write_plan

        write_plan(self.record, fspath(path))


def read_plan(path: str | PathLike[str]) -> Plan:
    """Read a plan file. Raises PlanFileError."""
    from .runtime.native import prefer_one_thread
    from .runtime.plan_files import read_plan as read

    prefer_one_thread()
    return Plan(read(fspath(path)))


def record_of(plan: PlanLike) -> PlanRecord:
    """The record of what stands for a plan. Raises PlanFileError where it is the name of a file that is none, and
    UsageError where it is nothing of that kind."""
    if isinstance(plan, Plan):
        return plan.record
    if isinstance(plan, str | PathLike):
        return read_plan(plan).record
    if not hasattr(plan, "phases"):
        from .langs.diagnostics import UsageError

        raise UsageError(f"a plan is a `tamplang.Plan` or the name of its file, not {plan!r:.40}")
    return plan
