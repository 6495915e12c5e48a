"""Files that a command is asked to write: refused before the work starts, not after."""

from __future__ import annotations

import os
import stat
from collections.abc import Mapping
from pathlib import Path

import click

from .status import ExitStatus


class UnwritableFile(click.ClickException):
    """A file that cannot be written; the message says why."""

    exit_code = ExitStatus.USAGE

    def __init__(self, path: Path, reason: str) -> None:
        super().__init__(f"cannot write {path}: {reason}")


def checked_output(path: Path, inputs: tuple[Path, ...] = ()) -> Path:
    """Make sure that `path` can be written. The file itself is not touched.

    Raises UnwritableFile when `path` is a folder, a device, a pipe or one of `inputs`, or lies in a folder that cannot
    be written.
    """
    import tempfile

    try:
        status = _status(path)
        if status is not None and stat.S_ISDIR(status.st_mode):
            raise UnwritableFile(path, "it is a folder")
        if status is not None and not stat.S_ISREG(status.st_mode):
            raise UnwritableFile(path, "it is not a regular file")
        if status is not None and any(_same(status, other) for other in inputs):
            raise UnwritableFile(path, "it is also the input")
        folder = os.path.dirname(os.path.realpath(path))
        if not os.path.isdir(folder):
            raise UnwritableFile(path, f"there is no folder {path.parent}")
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise UnwritableFile(path, error.strerror or "the folder cannot be written") from error
    return path


def checked_apart(files: Mapping[str, Path | None], inputs: tuple[Path, ...] = ()) -> None:
    """Make sure that the files of some options can be written, and that no two are the same. Raises UnwritableFile and
    click.UsageError."""
    taken: dict[Path, str] = {}
    for option, path in files.items():
        if path is not None:
            checked_output(path, inputs)
            other = taken.setdefault(path.absolute(), option)
            if other != option:
                raise click.UsageError(f"{other} and {option} are the same file: {path}")


def _status(path: Path) -> os.stat_result | None:
    """What is there, through symbolic links. Raises OSError but for a file that is not there."""
    try:
        return os.stat(path)
    except (FileNotFoundError, NotADirectoryError):
        return None


def _same(status: os.stat_result, other: Path) -> bool:
    try:
        return os.path.samestat(status, os.stat(other))
    except OSError:
        return False


def numbered(path: Path, number: int) -> Path:
    """The file of the plan with that number, counted from 1: `climb.plan.json`, then `climb.2.plan.json`, …"""
    if number == 1:
        return path
    stem, dot, suffixes = path.name.partition(".")
    return path.with_name(f"{stem}.{number}{dot}{suffixes}")
