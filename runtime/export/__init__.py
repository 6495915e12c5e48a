"""Plans for the tools of others. `docs/cli.md` lists the forms; `write` makes each."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from ...compiler.ir import Problem
from ..plan import Plan

FORMS = ("csv", "npz", "ros2", "multidof", "mcap", "urdf", "mjcf", "pddl", "val")
SYMBOLIC = ("pddl", "val")
"""Forms that need the plan's task."""


def write(
    plan: Plan, form: str, path: Path, rate: float | None = None, module: str | None = None, phase: int = 0,
    problem: Problem | None = None,
) -> None:  # fmt: skip
    """Write `plan` to `path` in one of FORMS. `rate`, hertz, is that of samples; None takes those of the plan. `urdf`
    is the robot that `module` (None: the first) is part of in `phase`. SYMBOLIC forms need the `problem`. Raises
    langs.diagnostics.UsageError for what the plan lacks or a form cannot say,
    runtime.native.MissingLibrary without the extra of a form, and OSError."""
    from . import mujoco, pddl, robots, ros2, tables

    makers: dict[str, Callable[[], dict[Path, bytes]]] = {
        "csv": lambda: {path: tables.csv_table(plan, rate)},
        "npz": lambda: {path: tables.arrays(plan, rate)},
        "ros2": lambda: {path: ros2.trajectories(plan, rate)},
        "multidof": lambda: {path: ros2.multi_dof(plan, rate)},
        "mcap": lambda: {path: ros2.bag(plan, rate)},
        "urdf": lambda: robots.robot(plan, path, module, phase),
        "mjcf": lambda: {path: mujoco.scene(plan)},
    }
    if problem is not None:
        makers["pddl"] = lambda: pddl.task(problem, path)
        makers["val"] = lambda: {path: pddl.actions(plan, problem)}
    from ...langs.writer import write_atomically

    for file, content in makers[form]().items():
        write_atomically(file, content)
