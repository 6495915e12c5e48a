"""The stages from text to problem, in order. Each takes what the one before gives.

1. imports   path or texts → `Library`: every file parsed, every declaration in its table (imports, library)
2. context   `Library` → signatures of predicates, types resolved (context)
3. checks    declarations → lifted IR: logic, motion predicates, heuristics, module types; scenes and tasks are walked
             without values for their parameters (check_logic, check_motion, check_heuristics, module_types, scene)
4. scene     task + parameters + seed → bodies, modules, facts, goals (scene, placing, initial)
5. start     the built scene → relaxation, movable bodies, overlaps, unreachable goals; `check` also measures what all
             modules together may reach (relaxation, check_start, reachability, check_reach, check_drives)
6. problem   everything in one frozen `ir.Problem`

Findings of all stages are collected and come out together; SourceError carries them when one is an error.
"""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Mapping, Sequence

from ..langs.diagnostics import Diagnostic, SourceError, UsageError
from ..langs.reader import read_source
from ..langs.source import Source
from . import ir
from .importing.kinds import foreign
from .imports import load_library, load_sources
from .scenes.check_drives import check_drives
from .scenes.check_reach import check_reach
from .scenes.instantiate import instantiate
from .scenes.lifted import check_declarations
from .scenes.parameters import choose_task, parameter_values

__all__ = [
    "UsageError", "check", "check_sources", "compile_problem", "compile_sources", "compile_text", "compiled_before",
    "load_library",
]  # fmt: skip

_recent: deque[ir.Problem] = deque(maxlen=4)
"""What this process compiled last, as it was compiled: problems hold whole scenes, so only a few are kept."""


def check(path: str | os.PathLike[str]) -> tuple[Diagnostic, ...]:
    """Everything that is wrong with the file and what it imports, each task also built with its default parameters;
    sorted by file and place."""
    try:
        source = read_program(path)
    except SourceError as error:
        return error.diagnostics
    return check_sources([source])


def read_program(path: str | os.PathLike[str]) -> Source:
    """The text of a program. Raises SourceError, E0021 for what belongs to another tool."""
    found = foreign(os.fspath(path))
    if found is not None:
        raise SourceError([found])
    return read_source(path)


def check_sources(sources: Sequence[Source]) -> tuple[Diagnostic, ...]:
    """`check` for texts: `sources[0]` is the main file, the others serve its imports before the disk does."""
    lifted = check_declarations(*load_sources(sources))
    for task in lifted.library.tasks.values():
        own = task.span.file == lifted.library.path
        if own and all(p.default is not None for p in task.parameters) and lifted.buildable(task):
            problem = instantiate(lifted, task, {}, 0)
            if problem is not None and not lifted.findings.has_errors:
                check_reach(lifted.findings, problem)
                check_drives(lifted.findings, problem)
    return lifted.findings.sorted()


def compile_problem(
    path: str | os.PathLike[str],
    task: str | None = None,
    parameters: Mapping[str, str] | None = None,
    seed: int = 0,
) -> tuple[ir.Problem, tuple[Diagnostic, ...]]:
    """The problem of one task of the file, and the warnings. `parameters` are raw texts of the command line, such as
    {"n": "8", "rise": "20 cm"}.

    Raises SourceError when the text has errors, UsageError when the task or a parameter is unknown or unfit.
    """
    return compile_sources([read_program(path)], task, parameters, seed)


def compile_sources(
    sources: Sequence[Source],
    task: str | None = None,
    parameters: Mapping[str, str] | None = None,
    seed: int = 0,
    files: Mapping[str, bytes] | None = None,
) -> tuple[ir.Problem, tuple[Diagnostic, ...]]:
    """`compile_problem` for texts: `sources[0]` is the main file, the others serve its imports before the disk does.
    With `files`, by path, nothing is opened on the disk: imports come from `sources`, URDFs and meshes from `files`,
    and what lacks is an error. So `problem.sources` and `problem.files` compile again to the same problem anywhere."""
    lifted = check_declarations(*load_sources(sources, files))
    if lifted.findings.has_errors:
        raise SourceError(lifted.findings.sorted())
    chosen = choose_task(lifted.library, task)
    values = parameter_values(chosen, parameters or {})
    problem = instantiate(lifted, chosen, values, seed)
    if problem is None or lifted.findings.has_errors:
        raise SourceError(lifted.findings.sorted())
    _recent.append(problem)
    return problem, lifted.findings.sorted()


def compiled_before(
    sources: Sequence[Source], task: str, parameters: Mapping[str, float | int], seed: int, files: Mapping[str, bytes]
) -> ir.Problem | None:
    """The problem of the same task of the same texts, called as on any machine, with the same values for all its
    parameters, where this process compiled it lately; its places are called as they were then."""
    for problem in reversed(list(_recent)):
        if (
            (problem.task, problem.seed, problem.parameters) == (task, seed, parameters)
            and [(problem.called(s.path), s.text) for s in problem.sources] == [(s.path, s.text) for s in sources]
            and {problem.called(path): data for path, data in problem.files.items()} == files
        ):
            return problem
    return None


def compile_text(
    text: str,
    name: str = "<text>",
    task: str | None = None,
    parameters: Mapping[str, str] | None = None,
    seed: int = 0,
) -> tuple[ir.Problem, tuple[Diagnostic, ...]]:
    """`compile_problem` for one text."""
    return compile_sources([Source(name, text)], task, parameters, seed)
