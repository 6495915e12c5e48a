"""What a plan is of: its sources and files, the goal it names, and whether a text of the reader's says the same."""

from __future__ import annotations

import dataclasses
import hashlib
import posixpath
import re
from collections import Counter
from collections.abc import Iterable, Mapping
from typing import Any

from ...compiler import ir
from ...compiler.foreign import beside
from ...compiler.printing_terms import format_formula
from ...langs.source import Span
from ..plan import Plan
from .findings import Findings
from .limits import LIMITS

SOON = 1e-6
"""Seconds by which the time of a window may differ from the start of its phase, beyond what is told of it."""


def check_sources(plan: Plan, findings: Findings) -> bool:
    """Whether every stored source and file has the hash that is stored with it, and a path of its own."""
    before = len(findings.failures)
    for source in plan.task.sources:
        if sha256(source.text) != source.sha256:
            findings.fail("source", f"the text of {source.path} was changed: its hash differs")
    for file in plan.task.files:
        if hashlib.sha256(file.data).hexdigest() != file.sha256:
            findings.fail("source", f"the file {file.path} was changed: its hash differs")
    paths = Counter([*(s.path for s in plan.task.sources), *(f.path for f in plan.task.files)])
    for path in sorted(path for path, count in paths.items() if count > 1):
        findings.fail("source", f"the plan holds {path} more than once")
    return len(findings.failures) == before


def check_task(plan: Plan, problem: ir.Problem, findings: Findings) -> bool:
    """Whether parameters, goal, sources and files of the plan are those of its task, no more and no less."""
    before = len(findings.failures)
    if problem.parameters != plan.task.parameters or problem.called(problem.file) != plan.task.file:
        findings.fail("source", "file name or parameters of the plan are not those of its sources")
    if plan.task.goal != format_formula(problem.goal):
        findings.fail("goal", f"the goal of the task is {format_formula(problem.goal)}, not {plan.task.goal}")
    unnamed = {s.path for s in plan.task.sources} - {problem.called(s.path) for s in problem.sources}
    unnamed |= {f.path for f in plan.task.files} - set(map(problem.called, problem.files))
    for path in sorted(unnamed):
        findings.fail("source", f"the plan holds {path}, which no source names")
    return len(findings.failures) == before


def check_windows(plan: Plan, findings: Findings) -> None:
    """Windows come one after the other, each at the start of the phase that it names or while the one before it lasts,
    and none lies outside the plan."""
    starts = [*(p.start for p in plan.phases), plan.phases[-1].end if plan.phases else 0.0]
    before = (0.0, 0)
    for number, window in enumerate(plan.windows, start=1):
        inside = 0 <= window.phase <= len(plan.phases) and 0 <= window.motions <= max(1, len(window.actions))
        if not inside or not 0.0 <= window.time <= starts[-1] + SOON:
            findings.fail("window", f"window {number} lies outside the plan", time=window.time)
        elif (window.time, window.phase) < before:
            findings.fail("window", f"window {number} comes before the one before it", time=window.time)
        elif abs(window.time - starts[window.phase]) > SOON:
            message = f"window {number} is not at the start of phase {window.phase + 1}"
            findings.fail("window", message, amount=abs(window.time - starts[window.phase]), unit="s", time=window.time)
        else:
            before = (window.time, window.phase)


# --- against a text of the reader's --------------------------------------------------------------------------------


def check_against(problem: ir.Problem, own: ir.Problem, findings: Findings) -> bool:
    """Whether the plan's problem is the reader's own. What differs is told part by part, by name."""
    before = len(findings.failures)
    tables: tuple[tuple[str, Mapping[str, Any], Mapping[str, Any]], ...] = (
        ("parameter", problem.parameters, own.parameters),
        ("type", problem.types, own.types),
        ("object", problem.objects, own.objects),
        ("predicate", problem.predicates, own.predicates),
        ("derived predicate", problem.derived, own.derived),
        ("motion predicate", problem.motions, own.motions),
        ("rule", problem.rules, own.rules),
        ("body", problem.world.bodies, own.world.bodies),
        ("module", problem.world.modules, own.world.modules),
        ("course of body", _by(problem.world.courses, "body"), _by(own.world.courses, "body")),
        ("failure of module", _by(problem.world.breakdowns, "module"), _by(own.world.breakdowns, "module")),
    )
    for what, ours, theirs in tables:
        names = sorted(n for n in {*ours, *theirs} if _bare(ours.get(n)) != _bare(theirs.get(n)))
        if names or list(ours) != list(theirs):
            told = ", ".join(names[:5]) + (f" and {len(names) - 5} more" if len(names) > 5 else "")
            findings.fail("against", f"{what} {told or 'names in another order'}: the plan's text says otherwise")
    for what, one, other in (
        ("the facts at the start", problem.init, own.init),
        ("the motion literals at the start", problem.init_motion, own.init_motion),
        ("the goal", _bare(problem.goal), _bare(own.goal)),
        ("the task", problem.task, own.task),
    ):
        if one != other:
            findings.fail("against", f"{what} of the plan's text are others" if what.endswith("start") else
                          f"{what} of the plan's text is another")  # fmt: skip
    return len(findings.failures) == before


def files_beside(main: str, own: ir.Problem) -> dict[str, bytes]:
    """The files that the reader's own task names, called as if its main file were `main`."""
    folder = posixpath.dirname(own.called(own.file))
    return {beside(main, posixpath.relpath(own.called(path), folder or ".")): data for path, data in own.files.items()}


def _by(items: Iterable[Any], name: str) -> dict[str, tuple[Any, ...]]:
    found: dict[str, tuple[Any, ...]] = {}
    for item in items:
        key = getattr(item, name)
        found[key] = (*found.get(key, ()), item)
    return found


def _bare(node: object) -> object:
    """The same without the places in the text."""
    if isinstance(node, Span):
        return None
    if dataclasses.is_dataclass(node) and not isinstance(node, type):
        return type(node).__name__, *(_bare(getattr(node, f.name)) for f in dataclasses.fields(node))
    if isinstance(node, Mapping):
        return tuple((key, _bare(value)) for key, value in node.items())
    if isinstance(node, tuple | list):
        return tuple(map(_bare, node))
    return node


# --- for people ----------------------------------------------------------------------------------------------------


def sha256(text: str) -> str:
    """The hash of a text in UTF-8, hexadecimal."""
    return hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()


def basis(plan: Plan) -> dict[str, object]:
    """What a verdict rests on, ready for JSON. `installed` tells of texts of the standard library whether they are
    those of this version; it is None for others."""
    task = plan.task
    return {
        "task": task.name,
        "file": task.file,
        "parameters": dict(task.parameters),
        "seed": task.seed,
        "goal": task.goal,
        "sources": [
            {"path": s.path, "sha256": sha256(s.text), "installed": _installed(s.path, s.text)} for s in task.sources
        ],
        "files": [{"path": f.path, "sha256": hashlib.sha256(f.data).hexdigest()} for f in task.files],
        "limits": dict(LIMITS),
    }


def _installed(path: str, text: str) -> bool | None:
    from ...compiler.standard import STANDARD, installed_text

    name = re.fullmatch(rf"{STANDARD}/(\w+)\.tamp", path)
    return None if name is None else installed_text(name[1]) == text
