"""What the command line says about a task: which one, and the values of its parameters."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from pathlib import PurePath

from ...langs import syntax
from ...langs.diagnostics import did_you_mean
from ..checks.values import outside
from ..library import Library

UNITS: Mapping[str, Mapping[str, float]] = {
    "length": {"m": 1.0, "cm": 0.01, "mm": 0.001},
    "angle": {"rad": 1.0, "deg": math.pi / 180},
    "time": {"s": 1.0, "min": 60.0},
    "speed": {"m/s": 1.0, "cm/s": 0.01, "mm/s": 0.001},
    "int": {},
    "real": {},
}
QUANTITY = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*([A-Za-z/]*)\s*")


class UsageError(Exception):
    """The command asks for a task or parameter that the file does not have, or gives an unfit value; the message names
    what is near."""


def choose_task(library: Library, name: str | None) -> syntax.TaskDecl:
    """The task called `name`; without a name the only one of the main file, or the one named like the file."""
    tasks = library.tasks
    if name is not None:
        if name in tasks:
            return tasks[name]
        raise UsageError(f"there is no task `{name}`; " + (did_you_mean(name, tasks) or _listed(tasks)))
    own = {n: t for n, t in tasks.items() if t.span.file == library.path} or dict(tasks)
    if len(own) == 1:
        return next(iter(own.values()))
    stem = PurePath(library.path).stem
    if stem in own:
        return own[stem]
    raise UsageError(
        f"`{library.path}` has several tasks, name one: {', '.join(own)}" if own else f"`{library.path}` has no task"
    )


def _listed(names: Mapping[str, object]) -> str:
    return f"there are {', '.join(names)}" if names else "the file declares none"


def parameter_values(task: syntax.TaskDecl, given: Mapping[str, str]) -> dict[str, float | int]:
    """The values of the given parameters in SI units. Raises UsageError on unknown names,
    unfit values and parameters left without any."""
    types = {p.name: p.type.name for p in task.parameters if isinstance(p.type, syntax.NamedType)}
    values: dict[str, float | int] = {}
    for name, text in given.items():
        if name not in types:
            listed = f"it has {', '.join(types)}" if types else "it has none"
            raise UsageError(f"task `{task.name}` has no parameter `{name}`; {did_you_mean(name, types) or listed}")
        values[name] = parse_value(name, types[name], text)
    for parameter in task.parameters:
        wrong = outside(parameter, values[parameter.name]) if parameter.name in values else None
        if wrong is not None:
            raise UsageError(wrong)
        if parameter.default is None and parameter.name not in values:
            raise UsageError(f"parameter `{parameter.name}` of task `{task.name}` has no default and needs a value")
    return values


def parse_value(name: str, kind: str, text: str) -> float | int:
    """The value of a text such as `8`, `0.2 m` or `20 cm` for a parameter of type int, real, length, angle,
    time or speed."""
    units = UNITS.get(kind, {})
    match = QUANTITY.fullmatch(text)
    if match is None:
        raise UsageError(f"parameter `{name}`: `{text}` is not a number{_with_unit(units)}")
    value, unit = float(match[1]), match[2]
    if not math.isfinite(value):
        raise UsageError(f"parameter `{name}`: `{text.strip()}` is too large")
    if kind == "int" and not unit and value == int(value):
        return int(value)
    if kind == "int":
        raise UsageError(f"parameter `{name}` is a whole number, not `{text.strip()}`")
    if unit not in units and (unit or (units and value != 0)):
        raise UsageError(f"parameter `{name}` is a {kind}{_with_unit(units) or ' without unit'}, not `{text.strip()}`")
    return value * units.get(unit, 1.0)


def _with_unit(units: Mapping[str, float]) -> str:
    return f" with a unit ({', '.join(units)})" if units else ""
