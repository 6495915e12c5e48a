"""The file of a sweep: one JSON line per instance, written as it comes, so that a sweep can go on where it ended."""

from __future__ import annotations

import fcntl
import json
import math
import os
from collections import Counter
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any

from .instances import Instance
from .outputs import UnwritableFile

TRIED_AGAIN = ("crashed", "lost")
"""Statuses that say nothing about the instance."""
LONGEST = 10_000_000
"""Bytes of a line; results have some thousand, and a few million when a search tells what it refused."""
_START = b'{"key": "'


class Results:
    """The results in a file, by key; the last of a key counts. The file is locked against other sweeps until this one
    ends.

    Raises UnwritableFile when that is impossible, or when the file holds nothing but other things.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            self._file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND | os.O_CLOEXEC, 0o666)
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            raise UnwritableFile(path, "another sweep is writing to it") from error
        except OSError as error:
            raise UnwritableFile(path, error.strerror or "it cannot be opened") from error
        self.damaged: list[int] = []
        """Numbers of lines, from 1, that are no results: they stay in the file and are passed over."""
        try:
            self._records = self._read()
        except BaseException:
            os.close(self._file)
            raise

    def _read(self) -> dict[str, dict[str, Any]]:
        """The sound lines. The half of a line at the end, of a run that was killed while it wrote, is cut off."""
        records: dict[str, dict[str, Any]] = {}
        ours, line, end = False, b"", 0
        with open(self._file, "rb", closefd=False) as stream:
            for number, line in enumerate(iter(partial(stream.readline, LONGEST), b""), start=1):
                record = _record(line)
                ours = ours or line.startswith(_START) or _START.startswith(line)
                if record is not None:
                    records[record["key"]] = record
                elif line.endswith(b"\n") or not line.startswith(_START):
                    self.damaged.append(number)
                end += len(line)
        if end and not (ours or records):
            raise UnwritableFile(self.path, "it holds no result of a sweep")
        if line and not line.endswith(b"\n"):
            half = _record(line) is None and (line.startswith(_START) or _START.startswith(line))
            self._finish(end - len(line) if half else None)
        return records

    def _finish(self, end: int | None) -> None:
        """Let the file end with a whole line: cut it at `end`, or, with None, end the line."""
        try:
            if end is None:
                os.write(self._file, b"\n")
            else:
                os.ftruncate(self._file, end)
        except OSError as error:
            raise UnwritableFile(self.path, error.strerror or "the write failed") from error

    def of(self, instance: Instance, folder: Path | None = None) -> dict[str, Any] | None:
        """The result of the instance, if it stands, with its plan in `folder` if there is one."""
        record = self._records.get(instance.key)
        if record is None or record["status"] in TRIED_AGAIN:
            return None
        if folder is not None and record["verified"] and not plan_file(folder, instance).exists():
            return None
        return record

    def add(self, record: dict[str, Any]) -> None:
        """Append the result: one line, in one write. Raises UnwritableFile, such as on a full disk."""
        line = json.dumps(record).encode() + b"\n"
        end = os.fstat(self._file).st_size
        try:
            written = os.write(self._file, line)
        except OSError as error:
            raise UnwritableFile(self.path, error.strerror or "the write failed") from error
        if written < len(line):
            os.ftruncate(self._file, end)
            raise UnwritableFile(self.path, "the disk is full")
        self._records[record["key"]] = record

    def close(self) -> None:
        """Give the file free."""
        os.close(self._file)


def _record(line: bytes) -> dict[str, Any] | None:
    """The result that a line holds, or None."""
    try:
        record = json.loads(line)
    except (ValueError, RecursionError):
        return None
    return record if isinstance(record, dict) and _is_sound(record) else None


def _is_sound(record: Mapping[str, Any]) -> bool:
    """Whether all is there that is read later, of the right kind."""
    seconds = record.get("seconds", {})
    return (
        isinstance(record.get("key"), str)
        and isinstance(record.get("status"), str)
        and isinstance(record.get("verified"), bool)
        and isinstance(record.get("explanation"), list)
        and type(record.get("length")) is int
        and isinstance(seconds, dict)
        and (record["status"] != "solved" or _is_time(seconds.get("total")))
    )


def _is_time(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and 0 <= value < math.inf


def plan_file(folder: Path, instance: Instance) -> Path:
    """Where the plan of the instance lies."""
    return folder / f"{instance.name}.plan.json"


def groups(instances: Sequence[Instance], results: Results) -> list[dict[str, Any]]:
    """For each combination of parameters: how many instances are finished and solved, the medians of the solved ones
    (None without any), and by which codes how many of the others ended."""
    found: dict[tuple[str, ...], dict[str, Any]] = {}
    members: dict[tuple[str, ...], list[dict[str, Any]]] = {}
    for instance in instances:
        key = tuple(instance.parameters.values())
        found.setdefault(key, {"parameters": dict(instance.parameters), "instances": 0})["instances"] += 1
        record = results.of(instance)
        members.setdefault(key, []).extend([record] if record is not None else [])
    return [group | _figures(members[key]) for key, group in found.items()]


def _figures(records: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    solved = [r for r in records if r["status"] == "solved"]
    codes = Counter(_code(r) for r in records if r["status"] != "solved")
    return {
        "finished": len(records),
        "solved": len(solved),
        "success": len(solved) / len(records) if records else None,
        "median_seconds": median(r["seconds"]["total"] for r in solved) if solved else None,
        "median_length": median(r["length"] for r in solved) if solved else None,
        "codes": dict(sorted(codes.items())),
    }


def _code(record: Mapping[str, Any]) -> str:
    """What ended an instance: the first code of its explanation, else its status."""
    told = next(iter(record["explanation"]), None)
    return str(told.get("code", record["status"])) if isinstance(told, dict) else str(record["status"])
