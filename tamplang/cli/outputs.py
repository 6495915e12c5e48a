"""Files that a command is asked to write: refused before the work starts, not after."""

from __future__ import annotations

import tempfile
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

    Raises UnwritableFile when `path` is a folder, a device or one of `inputs`, or lies in a folder that cannot be
    written.
    """
    if path.is_dir():
        raise UnwritableFile(path, "it is a folder")
    if not path.parent.is_dir():
        raise UnwritableFile(path, f"there is no folder {path.parent}")
    if path.exists() and not path.is_file():
        raise UnwritableFile(path, "it is not a regular file")
    if any(path.exists() and other.exists() and path.samefile(other) for other in inputs):
        raise UnwritableFile(path, "it is also the input")
    try:
        with tempfile.NamedTemporaryFile(dir=path.parent, prefix=f".{path.name}."):
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


def numbered(path: Path, number: int) -> Path:
    """The file of the plan with that number, counted from 1: `climb.plan.json`, then `climb.2.plan.json`, …"""
    if number == 1:
        return path
    stem, dot, suffixes = path.name.partition(".")
    return path.with_name(f"{stem}.{number}{dot}{suffixes}")
