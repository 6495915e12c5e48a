"""The instances of a sweep: from ranges on the command line to single problems, and from a problem to its result."""

from __future__ import annotations

import hashlib
import itertools
import json
import math
import re
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from .. import __version__
from ..compiler.imports import load_sources
from ..compiler.scenes.lifted import check_declarations
from ..compiler.scenes.parameters import choose_task, parameter_values
from ..langs.diagnostics import SourceError
from ..langs.reader import read_source
from ..langs.source import Source
from ..runtime.budget import SECONDS

if TYPE_CHECKING:
    from ..runtime.guard import Guard

MAX_INSTANCES = 100_000
_RANGE = re.compile(r"([+-]?\d{1,18})\s*\.\.\s*([+-]?\d{1,18})", re.ASCII)


@dataclass(frozen=True)
class SweptProgram:
    """A program without errors: its own text first, then what it imports; the meshes and URDFs that these name, by
    path; and the name of the task."""

    sources: tuple[Source, ...]
    files: Mapping[str, bytes]
    task: str

    @cached_property
    def digest(self) -> str:
        """A hash of all texts and files."""
        texts = json.dumps([source.text for source in self.sources])
        files = [hashlib.sha256(content).hexdigest() for content in self.files.values()]
        return hashlib.sha256("".join([texts, *files]).encode()).hexdigest()[:16]


@dataclass(frozen=True, slots=True)
class Instance:
    """One problem to solve. `parameters` are the given ones as text, `values` the same in SI units; `options` are the
    keywords of `Task.solve`. `key` is the same for the same work, wherever and whenever it is done."""

    program: SweptProgram
    parameters: Mapping[str, str]
    values: Mapping[str, float | int]
    seed: int
    options: Mapping[str, Any]
    key: str
    with_plan: bool

    @property
    def name(self) -> str:
        """Task, parameters and seed, fit for a file name."""
        parts = [f"{name}={value:g}" for name, value in self.values.items()]
        return "-".join([self.program.task, *parts, f"seed={self.seed}"])

    def __str__(self) -> str:
        return " ".join([*(f"{n}={text}" for n, text in self.parameters.items()), f"seed={self.seed}"])


def read_program(file: Path, task: str | None) -> SweptProgram:
    """The program with its declarations checked.

    Raises SourceError on errors of the text, UsageError on an unknown task.
    """
    lifted = check_declarations(*load_sources([read_source(file)]))
    if lifted.findings.has_errors:
        raise SourceError(lifted.findings.sorted())
    library = lifted.library
    return SweptProgram(tuple(library.sources), dict(library.foreign), choose_task(library, task).name)


def read_values(program: SweptProgram, texts: Mapping[str, Sequence[str]]) -> dict[str, dict[str, float | int]]:
    """For each parameter its texts with their values in SI units; texts of the same value are taken once.

    Raises UsageError on unknown names, unfit values and parameters left without any.
    """
    task = load_sources(program.sources, program.files)[0].tasks[program.task]
    found: dict[str, dict[str, float | int]] = {name: {} for name in texts}
    firsts = {name: several[0] for name, several in texts.items()}
    parameter_values(task, firsts)
    for name, several in texts.items():
        for text in several:
            value = parameter_values(task, {**firsts, name: text})[name]
            if value not in found[name].values():
                found[name][text] = value
    return found


def instances(
    program: SweptProgram,
    values: Mapping[str, Mapping[str, float | int]],
    seeds: Sequence[int],
    options: Mapping[str, Any],
    with_plan: bool,
) -> list[Instance]:
    """All combinations, the seeds running fastest."""
    return [
        _instance(program, dict(zip(values, texts, strict=True)), values, seed, options, with_plan)
        for texts in itertools.product(*values.values())
        for seed in seeds
    ]


def _instance(
    program: SweptProgram,
    texts: Mapping[str, str],
    values: Mapping[str, Mapping[str, float | int]],
    seed: int,
    options: Mapping[str, Any],
    with_plan: bool,
) -> Instance:
    own = {name: values[name][text] for name, text in texts.items()}
    work = [__version__, program.digest, program.task, own, seed, shown_options(options)]
    key = hashlib.sha256(json.dumps(work, sort_keys=True).encode()).hexdigest()[:16]
    return Instance(program, texts, own, seed, options, key, with_plan)


def shown_options(options: Mapping[str, Any]) -> dict[str, Any]:
    """The options as JSON can hold them: without limit is `"inf"`."""
    return {name: "inf" if value == math.inf else value for name, value in options.items()}


def listed(option: str, text: str) -> list[str]:
    """The values of a text such as `8,16,32` or `1..3,8`. Raises click.UsageError."""
    found: list[str] = []
    for part in (part.strip() for part in text.split(",")):
        found += _stretch(option, part)
        if len(found) > MAX_INSTANCES:
            raise too_many()
    return list(dict.fromkeys(found))


def _stretch(option: str, part: str) -> list[str]:
    if not part:
        raise click.UsageError(f"{option}: a value is missing between the commas")
    if ".." not in part:
        return [part]
    match = _RANGE.fullmatch(part)
    if match is None:
        raise click.UsageError(f"{option}: `{part}` is no range; ranges are of whole numbers, such as 1..4")
    first, last = int(match[1]), int(match[2])
    if first > last:
        raise click.UsageError(f"{option}: `{part}` is empty; did you mean `{last}..{first}`?")
    if last - first >= MAX_INSTANCES:
        raise too_many()
    return [str(number) for number in range(first, last + 1)]


def seeds_of(text: str) -> list[int]:
    """The seeds of a text such as `0..9`. Raises click.UsageError."""
    texts = listed("--seeds", text)
    unfit = next((t for t in texts if not re.fullmatch(r"[0-9]{1,18}", t)), None)
    if unfit is not None:
        raise click.UsageError(f"--seeds: `{unfit}` is no seed; seeds are whole numbers from 0, such as 0..9")
    return list(dict.fromkeys(int(t) for t in texts))


def too_many() -> click.UsageError:
    """For a sweep of more than MAX_INSTANCES."""
    return click.UsageError(f"a sweep has at most {MAX_INSTANCES} instances")


def solve_instance(instance: Instance, memory: int | None = None) -> tuple[dict[str, Any], bytes | None]:
    """The result of one instance, as `docs/sweep.md` lists it, and the best plan as the text of a plan file. Runs in
    any process, which may take `memory` bytes."""
    from .limits import Spent, limited
    from .sources import as_objects

    most = instance.options.get("time")
    try:
        with limited(SECONDS if most is None else most, memory, "compiling", started=time.monotonic()) as guard:
            return _solved(instance, guard)
    except SourceError as error:
        return failed(instance, "error", as_objects(error.diagnostics)), None
    except Spent as error:
        return failed(instance, error.status, as_objects([error.diagnostic])), None


def _solved(instance: Instance, guard: Guard) -> tuple[dict[str, Any], bytes | None]:
    from ..api import Task
    from ..compiler.pipeline import compile_sources
    from .limits import total
    from .solution import Written, result_json

    worked = time.process_time()
    program = instance.program
    problem, _ = compile_sources(
        program.sources, program.task, instance.parameters, instance.seed, program.files
    )
    compiled = guard.elapsed
    guard.doing = "planning"
    guard.seconds = total(instance.options.get("time"), problem.options.time, SECONDS)
    result = Task(problem).solve(**{**instance.options, "time": guard.left()})
    answer = result_json(problem, result, Written((), None), compiled)
    shared = {name: value for name, value in answer.items() if name not in ("plan", "plans", "report")}
    record = identity(instance) | shared | {"cpu_seconds": round(time.process_time() - worked, 4)}
    if result.plan is None or not instance.with_plan:
        return record, None
    return record, encoded(result.plan.record)


def identity(instance: Instance) -> dict[str, Any]:
    """What tells an instance from all others."""
    return {
        "key": instance.key,
        "source": instance.program.digest,
        "version": __version__,
        "task": instance.program.task,
        "parameters": dict(instance.values),
        "seed": instance.seed,
        "options": shown_options(instance.options),
    }


def failed(instance: Instance, status: str, explanation: list[dict[str, object]]) -> dict[str, Any]:
    """The result of an instance that could not be tried."""
    nothing = {"actions": [], "length": 0, "verified": False}
    return identity(instance) | {"status": status, **nothing, "explanation": explanation}


def encoded(plan: Any) -> bytes:
    """The plan as the text of a plan file."""
    import msgspec

    return msgspec.json.encode(plan)
