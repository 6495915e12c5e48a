"""Runs the real command where something is wrong with what it is given, or with the machine."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from contextlib import chdir, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from typing import Any

import pytest

from tamplang.cli import run

ROOT = Path(__file__).resolve().parents[2]
CLIMB = ROOT / "examples" / "climb.tamp"
LIGHT = """import std.logic
predicate (lit)
rule light() { pre not (lit) post (lit) }
task t() { object b: box(1 cm, 1 cm, 1 cm) at (0, 0, 1 m) goal (lit) }
"""
"""Solved in a tenth of a second, without any module."""
Faulty = Callable[..., "subprocess.CompletedProcess[str]"]


def environment(**more: str) -> dict[str, str]:
    """Of the tests, with the package in reach."""
    return {**os.environ, "PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", **more}


@pytest.fixture
def faulty(tmp_path: Path) -> Faulty:
    """`faulty("check", file, stdin=…, env={…})` runs the command in an empty folder. Whatever is wrong, it ends, and
    never with a traceback, as an internal error or with a crash file."""

    def started(*arguments: object, env: dict[str, str] | None = None, **how: Any) -> subprocess.CompletedProcess[str]:
        settings: dict[str, Any] = {
            "cwd": tmp_path, "stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE,
            "timeout": 120, "text": True, "errors": "surrogateescape",
        }  # fmt: skip
        before = how.pop("before", ())
        command = [*before, sys.executable, *how.pop("python", ()), "-m", "tamplang", *map(str, arguments)]
        process = subprocess.run(command, env=environment(**(env or {})), **{**settings, **how})
        told = f"{process.stdout or ''}{process.stderr or ''}"
        assert "Traceback" not in told and "internal error" not in told and process.returncode != 70, told
        return process

    return started


@dataclass(frozen=True, slots=True)
class Answer:
    """What a command gave."""

    returncode: int
    stdout: str
    stderr: str


def here(folder: Path, *arguments: object) -> Answer:
    """The same command in the process of the tests: quicker, where nothing is wrong with the process itself."""
    out, err = StringIO(), StringIO()
    with chdir(folder), redirect_stdout(out), redirect_stderr(err):
        status = run([str(argument) for argument in arguments])
    return Answer(status, out.getvalue(), err.getvalue())


@pytest.fixture
def light(tmp_path: Path) -> Path:
    """A small sound program in the folder of the test."""
    path = tmp_path / "light.tamp"
    path.write_text(LIGHT, encoding="utf-8")
    return path
