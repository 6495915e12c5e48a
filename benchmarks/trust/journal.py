"""What every part has in common: settings, results kept in a file as they come, and lines of the table."""

from __future__ import annotations

import json
import resource
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

Record = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Settings:
    """What the command line says. `count` None is the full number of a part; `folder` keeps the results."""

    folder: Path
    seed: int = 0
    count: int | None = None
    resume: bool = False

    def journal(self, part: str) -> Journal:
        return Journal(self.folder / f"{part}.jsonl", self.resume)


@dataclass(frozen=True, slots=True)
class Line:
    """A row of the table: what was asked, of how many, what came of it, and whether that is what is promised."""

    part: str
    what: str
    result: str
    kept: bool


class Journal:
    """Results by key, one JSON line each, written as they come. A line that an interruption left half is dropped."""

    def __init__(self, path: Path, resume: bool) -> None:
        self.path = path
        self.records: dict[str, Record] = {}
        path.parent.mkdir(parents=True, exist_ok=True)
        if resume and path.exists():
            for line in path.read_text(encoding="utf-8").splitlines():
                try:
                    record = json.loads(line)
                except ValueError:
                    continue
                self.records[record["key"]] = record
            text = "".join(json.dumps(r) + "\n" for r in self.records.values())
            path.write_text(text, encoding="utf-8")
        else:
            path.write_text("", encoding="utf-8")

    def add(self, key: str, record: Record) -> None:
        self.records[key] = {"key": key, **record}
        with self.path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(self.records[key]) + "\n")

    def fill(self, keys: Iterable[str], measure: Callable[[str], Record]) -> Iterator[Record]:
        """The records of `keys` in order; those that are missing are measured and kept."""
        keys, shown = list(keys), time.monotonic()
        for number, key in enumerate(keys, 1):
            if key not in self.records:
                self.add(key, measure(key))
            if time.monotonic() - shown > 10:
                shown = time.monotonic()
                print(f"{self.path.stem}: {number} of {len(keys)}", file=sys.stderr, flush=True)
            yield self.records[key]


def cpu() -> float:
    """CPU seconds of this process so far."""
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


def table(lines: Iterable[Line]) -> str:
    """The table as Markdown."""
    rows = ["| part | what | result | kept |", "|---|---|---|---|"]
    rows += [f"| {r.part} | {r.what} | {r.result} | {'yes' if r.kept else '**no**'} |" for r in lines]
    return "\n".join(rows) + "\n"
