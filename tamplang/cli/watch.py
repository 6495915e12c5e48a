"""`--watch`: the same command again whenever the program or something that it imports changes, until Ctrl-C."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import click

PAUSE = 0.3
"""Seconds between two looks at the disk: soon enough for a person, and next to no work."""
GRACE = 10.0
"""Seconds that a command gets after Ctrl-C to keep what it found: none takes longer, but one that was not reached."""

watch_option: Callable[[Any], Any] = click.option(
    "--watch", is_flag=True, help="Do it again whenever a file changes, until Ctrl-C."
)


def watching(files: Sequence[Path], arguments: Sequence[str]) -> int:
    """Run `tamplang` with these arguments now and after every change; ends by KeyboardInterrupt only."""
    command = [sys.executable, "-m", "tamplang", *(a for a in arguments if a != "--watch")]
    while True:
        before = stamps(files)
        _carried_out(command)
        click.echo("watching; Ctrl-C ends", err=True)
        while stamps(files) == before:
            time.sleep(PAUSE)


def _carried_out(command: Sequence[str]) -> None:
    """Run a command to its end, also after Ctrl-C, which reaches it too."""
    import subprocess

    process = subprocess.Popen(command)
    try:
        process.wait()
    except KeyboardInterrupt:
        with suppress(subprocess.TimeoutExpired):
            process.wait(GRACE)
        process.terminate()
        raise


def stamps(files: Sequence[Path]) -> dict[Path, tuple[int, int] | None]:
    """Time and size of the files and of all that they import; None for one that is not there."""
    return {path: _stamp(path) for file in files for path in (file, *imported(file))}


def imported(file: Path) -> list[Path]:
    """What a program imports, and the models it reads, as far as it can be read."""
    from ..compiler.imports import load_sources, on_disk
    from ..langs.diagnostics import SourceError
    from ..langs.reader import read_source

    try:
        library = load_sources([read_source(file)])[0]
    except SourceError:
        return []
    return [on_disk(text.path) for text in (*library.sources, *library.models)]


def _stamp(path: Path) -> tuple[int, int] | None:
    try:
        status = path.stat()
    except OSError:
        return None
    return status.st_mtime_ns, status.st_size
