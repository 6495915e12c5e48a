"""Files written whole or not at all: a reader, a full disk or an interrupted run never leaves half of one."""

from __future__ import annotations

import errno
import os
import secrets
import signal
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

NO_UNNAMED = (errno.EOPNOTSUPP, errno.EISDIR, errno.EINVAL, errno.ENOENT)
"""What systems say that have no files without a name."""
INTERRUPTS = (signal.SIGINT, signal.SIGALRM, signal.SIGTERM)
"""What has to wait while a file is overwritten."""


def write_atomically(path: str | Path, content: bytes) -> None:
    """Write `content` so that nobody ever sees half of it. What stood there before keeps its permissions; a symbolic
    link is followed. Raises OSError, with `path` as its file name.

    Until it is whole the new file has no name, so that even a killed process leaves nothing behind, but in the
    microseconds between two system calls where it takes the place of an older file.
    """
    target = os.path.realpath(path)
    with _named(path):
        mode = stat.S_IMODE(os.stat(target).st_mode) if os.path.lexists(target) else None
        _replace(target, content, mode)


def write_new(path: str | Path, content: bytes) -> None:
    """Write a file that does not exist yet, whole or not at all. Raises OSError, with `path` as its file name:
    FileExistsError where there is one."""
    target = os.fspath(path)
    with _named(path):
        file, temporary = _opened(os.path.dirname(target) or ".")
        try:
            with os.fdopen(file, "wb", closefd=False) as stream:
                stream.write(content)
            if temporary is None:
                _link(file, target)
            else:
                os.link(temporary, target)
        finally:
            os.close(file)
            if temporary is not None:
                os.unlink(temporary)


def rewrite(path: str | Path, text: str) -> None:
    """Write `text` into a file that exists, which keeps permissions, owner, and links of both kinds. Raises OSError,
    with `path` as its file name.

    It is replaced at once; only a file with several hard links, with an owner or in a folder where that is not allowed,
    is written in place, once the disk has room for it.
    """
    target = os.path.realpath(path)
    with _named(path):
        with open(target, "r+b") as stream:
            status = os.fstat(stream.fileno())
        if status.st_nlink == 1:
            with suppress(PermissionError):
                _replace(target, text.encode(), stat.S_IMODE(status.st_mode), (status.st_uid, status.st_gid))
                return
        _overwrite(target, text.encode())


@contextmanager
def _named(path: str | Path) -> Iterator[None]:
    """Errors of the code inside name the file that the user named."""
    try:
        yield
    except OSError as error:
        raise type(error)(error.errno, error.strerror, str(path)) from error


def _replace(target: str, content: bytes, mode: int | None, owner: tuple[int, int] | None = None) -> None:
    """The file at `target` becomes one with that content. Raises PermissionError where it cannot get the owner."""
    folder = os.path.dirname(target)
    file, temporary = _opened(folder)
    try:
        with os.fdopen(file, "wb", closefd=False) as stream:
            stream.write(content)
        if owner is not None and owner != (os.fstat(file).st_uid, os.fstat(file).st_gid):
            os.fchown(file, *owner)
        if mode is not None:
            os.fchmod(file, mode)
        if temporary is None:
            if mode is None:
                with suppress(FileExistsError):
                    _link(file, target)
                    return
            name = _spare(folder)
            _link(file, name)
            temporary = name
        os.replace(temporary, target)
        temporary = None
    finally:
        os.close(file)
        if temporary is not None:
            os.unlink(temporary)


def _opened(folder: str) -> tuple[int, str | None]:
    """A new file in the folder, without a name where the system can do that."""
    try:
        return os.open(folder, os.O_TMPFILE | os.O_WRONLY | os.O_CLOEXEC, 0o666), None
    except OSError as error:
        if error.errno not in NO_UNNAMED:
            raise
    name = _spare(folder)
    return os.open(name, os.O_CREAT | os.O_EXCL | os.O_WRONLY | os.O_CLOEXEC, 0o666), name


def _link(file: int, path: str) -> None:
    """Give an open file without a name that one. A folder is named only because Python follows the symbolic link of
    /proc, as it promises, where one is."""
    folder = os.open("/", os.O_PATH | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        os.link(f"/proc/self/fd/{file}", path, src_dir_fd=folder, follow_symlinks=True)
    finally:
        os.close(folder)


def _spare(folder: str) -> str:
    return os.path.join(folder, f".tamplang-{secrets.token_hex(8)}")


def _overwrite(target: str, content: bytes) -> None:
    """Put the content in place of the old one, once there is room for it."""
    file = os.open(target, os.O_RDWR | os.O_CLOEXEC)
    try:
        before = os.fstat(file).st_size
        try:
            os.posix_fallocate(file, 0, max(before, len(content)))
        except OSError:
            os.ftruncate(file, before)
            raise
        done, mask = 0, signal.pthread_sigmask(signal.SIG_BLOCK, INTERRUPTS)
        try:
            while done < len(content):
                done += os.pwrite(file, content[done:], done)
            os.ftruncate(file, len(content))
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)
    finally:
        os.close(file)
