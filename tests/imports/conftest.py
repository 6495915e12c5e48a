"""Runs `tamplang import` and looks at what it says and writes."""

from __future__ import annotations

import json
from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from io import StringIO
from pathlib import Path

import pytest

from tamplang.cli import run as run_command


@dataclass(frozen=True, slots=True)
class Answer:
    """What a command gave."""

    status: int
    told: str


Command = Callable[..., Answer]


@pytest.fixture
def command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Command:
    """Runs a command line in an empty folder. What a user would see as a traceback fails the test."""
    monkeypatch.chdir(tmp_path)

    def run(*arguments: object) -> Answer:
        told = StringIO()
        with redirect_stdout(told), redirect_stderr(told):
            status = run_command([str(a) for a in arguments])
        return Answer(status, told.getvalue())

    return run


def refused(command: Command, codes: set[str], *files: str) -> str:
    """What `import` says of files that it refuses with one of the codes; nothing is written."""
    answer = command("import", *files, "-o", "never.tamp")
    assert answer.status == 1, answer.told
    assert not Path("never.tamp").exists()
    assert any(f"error[{code}]" in answer.told for code in codes), answer.told
    return answer.told


def problems(command: Command, file: str) -> list[str]:
    """The codes of what is wrong with a program."""
    answer = command("check", file, "--format", "json", "--quiet")
    return [found["code"] for found in json.loads(answer.told)]
