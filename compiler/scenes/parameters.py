"""What the command line says about a task: which one, and the values of its parameters."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from pathlib import PurePath

from ...langs import syntax
from ...langs.diagnostics import UsageError, did_you_mean
from ...langs.source import Span
from ..checks.values import outside
from ..library import Library

UNITS: Mapping[str, Mapping[str, float]] = {
    "length": {"m": 1.0, "cm": 0.01, "mm": 0.001},
    "angle": {"rad": 1.0, "deg": math.pi / 180},
    "time": {"s": 1.0, "min": 60.0},
    "speed": {"m/s": 1.0, "cm/s": 0.01, "mm/s": 0.001},
    "mass": {"kg": 1.0, "g": 0.001},
    "density": {"kg/m^3": 1.0, "kg/m³": 1.0},
    "force": {"N": 1.0, "kN": 1000.0},
    "torque": {"N m": 1.0, "Nm": 1.0, "kN m": 1000.0},
    "inertia": {"kg m^2": 1.0, "kg m²": 1.0},
    "int": {},
    "real": {},
}
EXAMPLES = {"int": "8", "real": "0.5", "length": "20cm", "angle": "90deg", "time": "5s", "speed": "5cm/s",
            "mass": "2kg", "density": "300kg/m^3", "force": "110N", "torque": "38Nm",
            "inertia": "0.02kg m^2"}  # fmt: skip
"""A value of each type, as one types it."""
UNIT = r"(?:[A-Za-z/]+(?:\^[23]|³)?(?: m(?:\^2|²)?)?)?"
QUANTITY = re.compile(rf"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*({UNIT})\s*", re.ASCII)


def choose_task(library: Library, name: str | None) -> syntax.TaskDecl:
    """The task called `name`; without a name the only one of the main file, or the one named like the file."""
    tasks = library.tasks
    if name is not None:
        if name in tasks:
            return tasks[name]
        help = did_you_mean(name, tasks) or _listed(tasks)
        raise UsageError(f"there is no task `{name}`", "E0113", help=help)
    own = {n: t for n, t in tasks.items() if t.span.file == library.path} or dict(tasks)
    if len(own) == 1:
        return next(iter(own.values()))
    stem = PurePath(library.path).stem
    if stem in own:
        return own[stem]
    if own:
        raise UsageError(f"`{library.path}` has several tasks", "E0505", help=f"name one: {', '.join(own)}")
    raise UsageError(f"`{library.path}` has no task", "E0504")


def _listed(names: Mapping[str, object]) -> str:
    if not names:
        return "the file declares none"
    return f"there {'is only' if len(names) == 1 else 'are'} {', '.join(f'`{name}`' for name in names)}"


def parameter_values(task: syntax.TaskDecl, given: Mapping[str, str]) -> dict[str, float | int]:
    """The values of the given parameters in SI units. Raises UsageError on unknown names,
    unfit values and parameters left without any."""
    types = {p.name: p.type.name for p in task.parameters if isinstance(p.type, syntax.NamedType)}
    spans = {p.name: p.span for p in task.parameters}
    values: dict[str, float | int] = {}
    for name, text in given.items():
        if name not in types:
            listed = f"it has {', '.join(types)}" if types else "it has none"
            help = did_you_mean(name, types) or listed
            raise UsageError(f"task `{task.name}` has no parameter `{name}`", "E0519", task.span, help)
        values[name] = parse_value(name, types[name], text, spans[name])
    for parameter in task.parameters:
        wrong = outside(parameter, values[parameter.name]) if parameter.name in values else None
        if wrong is not None:
            raise UsageError(wrong, "E0519", parameter.span)
        if parameter.default is None and parameter.name not in values:
            message = f"parameter `{parameter.name}` of task `{task.name}` has no default and needs a value"
            raise UsageError(message, "E0519", parameter.span, _example(parameter.name, types.get(parameter.name, "")))
    return values


def parse_value(name: str, kind: str, text: str, span: Span | None = None) -> float | int:
    """The value of a text such as `8`, `0.2 m` or `20 cm` for a parameter of type int, real, length, angle,
    time or speed, which is declared at `span`. Raises UsageError."""
    units = UNITS.get(kind, {})
    match = QUANTITY.fullmatch(text)
    value, unit = (float(match[1]), match[2]) if match is not None else (math.nan, "")
    if match is None:
        wrong = f"parameter `{name}`: `{text}` is not a number{_with_unit(units)}"
    elif not math.isfinite(value):
        wrong = f"parameter `{name}`: `{text.strip()}` is too large"
    elif kind == "int" and (unit or value != int(value)):
        wrong = f"parameter `{name}` is a whole number, not `{text.strip()}`"
    elif unit not in units and (unit or (units and value != 0)):
        wrong = f"parameter `{name}` is a {kind}{_with_unit(units) or ' without unit'}, not `{text.strip()}`"
    else:
        return int(value) if kind == "int" else value * units.get(unit, 1.0)
    raise UsageError(wrong, "E0519", span, _example(name, kind))


def _example(name: str, kind: str) -> str:
    return f"for example -p {name}={EXAMPLES.get(kind, '…')}"


def _with_unit(units: Mapping[str, float]) -> str:
    return f" with a unit ({', '.join(units)})" if units else ""
