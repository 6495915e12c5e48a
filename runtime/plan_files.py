"""Plan files on the disk: written whole or not at all, read with suspicion."""

from __future__ import annotations

import gc
import json
import os
import re
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import msgspec

from ..langs.diagnostics import Diagnostic, Error
from ..langs.writer import write_atomically
from .plan import FORMAT, KNOWN_NEEDS, Plan
from .plan_upgrade import FORMAT_1, Plan1, upgraded

LARGEST = 1_000_000_000
"""Bytes. A plan of 64 things has some 30 million; beyond a thousand million the file is no plan that fits in memory."""


NUMBERS = re.compile(rb"(?<=:)\s*\[[\[\]0-9eE+\-.,\s]*\]")
"""The value of a field that is nothing but rows of numbers."""


class PlanFileError(Error):
    """The file is not a readable plan; the message says why, `diagnostic` the same with a code."""

    def __init__(self, message: str) -> None:
        super().__init__(message)
        self.diagnostic = Diagnostic("E0023", message)


class _Head(msgspec.Struct):
    format: str


def write_plan(plan: Plan, path: str | Path) -> None:
    """Write the plan as JSON, atomically. Raises OSError."""
    write_atomically(path, msgspec.json.encode(plan))


def read_plan(path: str | Path) -> Plan:
    """Read a plan file of this format, or of an older one, which is upgraded. Raises PlanFileError when it cannot be
    read or is no plan."""
    data = _content(Path(path))
    try:
        head = msgspec.json.decode(data, type=_Head)
        if head.format not in (FORMAT, FORMAT_1):
            known = f"this version reads {FORMAT!r} and {FORMAT_1!r}"
            raise PlanFileError(f"{path} has format {head.format!r}; {known}")
        with _uncollected():
            plan = msgspec.json.decode(data, type=Plan) if head.format == FORMAT else _read_1(data)
        _refuse_repeated(path, data)
    except (msgspec.DecodeError, json.JSONDecodeError, RecursionError) as error:
        raise PlanFileError(f"{path} is not a plan file: {_mixed(data) or _told(error)}") from error
    unknown = sorted(set(plan.needs) - KNOWN_NEEDS)
    if unknown:
        raise PlanFileError(f"{path} needs {', '.join(unknown)}, which this version does not understand")
    return plan


@contextmanager
def _uncollected() -> Iterator[None]:
    """Around what makes millions of objects and no garbage: looking for some would take a third of the time."""
    looks = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if looks:
            gc.enable()


def _read_1(data: bytes) -> Plan:
    return upgraded(msgspec.json.decode(data, type=Plan1))


def _mixed(data: bytes) -> str | None:
    """What is wrong with a file that cannot be read, where it has splines of another format than it says."""
    try:
        plan = json.loads(data)
        said, splines = plan["format"], [set(spline) for spline in plan["splines"]]
    except (ValueError, RecursionError, TypeError, KeyError):
        return None
    own, other = ({"phase"}, {"from", "until"}) if said == FORMAT_1 else ({"from", "until"}, {"phase"})
    if any(names & other for names in splines):
        told = f"it says that it has format {said!r}, and has splines of another one"
        return f"{told}: {_listed(other)} instead of {_listed(own)}"
    return None


def _listed(names: set[str]) -> str:
    return " and ".join(f"`{name}`" for name in sorted(names))


def _told(error: Exception) -> str:
    return "brackets are nested too deeply" if isinstance(error, RecursionError) else str(error)


def _content(path: Path) -> bytes:
    """All bytes of a regular file. Raises PlanFileError."""
    try:
        status = os.stat(path)
        if not stat.S_ISREG(status.st_mode):
            what = "it is a folder" if stat.S_ISDIR(status.st_mode) else "it is not a regular file"
            raise PlanFileError(f"cannot read {path}: {what}")
        if status.st_size > LARGEST:
            raise PlanFileError(f"cannot read {path}: it has {status.st_size} bytes, at most {LARGEST} are read")
        with open(path, "rb", opener=lambda name, flags: os.open(name, flags | os.O_NONBLOCK)) as stream:
            return stream.read(LARGEST + 1)
    except OSError as error:
        raise PlanFileError(f"cannot read {path}: {error.strerror}") from error
    except ValueError as error:
        raise PlanFileError(f"{str(path)!r} is not a file name") from error


def _refuse_repeated(path: str | Path, data: bytes) -> None:
    """JSON lets a name occur twice in an object, and readers differ in which of both they take. `data` is a plan; its
    rows of numbers, most of the file, hold no names, and are left out."""

    def once(pairs: list[tuple[str, Any]]) -> None:
        names = [name for name, _ in pairs]
        if len(set(names)) < len(names):
            repeated = next(name for name in names if names.count(name) > 1)
            raise PlanFileError(f"{path} is not a plan file: `{repeated}` occurs twice in one object")

    json.loads(NUMBERS.sub(b"[]", data), object_pairs_hook=once)
