"""Runs the real command, as a user does."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
Tamplang = Callable[..., "subprocess.CompletedProcess[str]"]


def environment(*first: Path) -> dict[str, str]:
    """The surroundings of a command; Python looks for modules in the folders `first`."""
    path = os.pathsep.join(map(str, (*first, ROOT)))
    return {**os.environ, "PYTHONPATH": path, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}


def begin(folder: Path, *arguments: object, first: tuple[Path, ...] = ()) -> subprocess.Popen[str]:
    """A Python process of the tests' own, with the package in reach; its output is text."""
    return subprocess.Popen(
        [sys.executable, *map(str, arguments)],
        cwd=folder,
        env=environment(*first),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


@pytest.fixture
def tamplang(tmp_path: Path) -> Tamplang:
    """`tamplang("check", file)` runs the command in an empty folder; no command may ever show a traceback."""

    def run(*arguments: object, timeout: float = 60.0) -> subprocess.CompletedProcess[str]:
        process = subprocess.run(
            [sys.executable, "-m", "tamplang", *map(str, arguments)],
            cwd=tmp_path,
            env=environment(),
            capture_output=True,
            text=True,
            timeout=timeout,
            stdin=subprocess.DEVNULL,
        )
        assert "Traceback" not in process.stdout + process.stderr
        assert process.returncode != 70, process.stderr
        return process

    return run


@pytest.fixture
def program(tmp_path: Path) -> Callable[[str], Path]:
    """Write a program into the folder of the test."""

    def write(text: str, name: str = "program.tamp") -> Path:
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return path

    return write
