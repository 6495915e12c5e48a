"""The file of a sweep: one JSON line per instance, written as it comes, so that a sweep can go on where it ended."""

from __future__ import annotations

import fcntl
import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from statistics import median
from typing import Any

from .instances import Instance
from .outputs import UnwritableFile

TRIED_AGAIN = ("crashed", "lost")
"""Statuses that say nothing about the instance."""
_START = b'{"key": "'


class Results:
    """The results in a file, by key; the last of a key counts. The file is locked against other sweeps until this one
    ends.

    Raises UnwritableFile when that is impossible, or when the file holds other things.
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
        self._records = self._read()

    def _read(self) -> dict[str, dict[str, Any]]:
        whole, newline, rest = self.path.read_bytes().rpartition(b"\n")
        if rest and not (rest.startswith(_START) or _START.startswith(rest)):
            raise self._foreign(whole.count(b"\n") + (2 if newline else 1))
        records: dict[str, dict[str, Any]] = {}
        for number, line in enumerate(whole.splitlines(), start=1):
            try:
                record = json.loads(line)
            except ValueError as error:
                raise self._foreign(number) from error
            if not isinstance(record, dict) or not isinstance(record.get("key"), str) or "status" not in record:
                raise self._foreign(number)
            records[record["key"]] = record
        if rest:  # a run that was killed while it wrote
            os.ftruncate(self._file, len(whole) + len(newline))
        return records

    def _foreign(self, line: int) -> UnwritableFile:
        return UnwritableFile(self.path, f"line {line} is no result of a sweep")

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
        try:
            written = os.write(self._file, line)
        except OSError as error:
            raise UnwritableFile(self.path, error.strerror or "the write failed") from error
        if written < len(line):
            raise UnwritableFile(self.path, "the disk is full")
        self._records[record["key"]] = record

    def close(self) -> None:
        """Give the file free."""
        os.close(self._file)


def plan_file(folder: Path, instance: Instance) -> Path:
    """Where the plan of the instance lies."""
    return folder / f"{instance.name}.plan.json"


def groups(instances: Sequence[Instance], results: Results) -> list[dict[str, Any]]:
    """For each combination of parameters: how many instances are finished and solved, and the medians of the solved
    ones (None without any)."""
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
    return {
        "finished": len(records),
        "solved": len(solved),
        "success": len(solved) / len(records) if records else None,
        "median_seconds": median(r["seconds"]["total"] for r in solved) if solved else None,
        "median_length": median(r["length"] for r in solved) if solved else None,
    }
