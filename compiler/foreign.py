"""Files that texts name beside their imports, such as meshes and URDFs: from the disk, or carried by a plan."""

from __future__ import annotations

import os
import posixpath
import stat
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field

LARGEST = 64_000_000
"""Bytes of a mesh: more than a million triangles, of which a hull keeps a few hundred corners."""


MOST_BELOW = 10_000
"""Files below a folder in which one is searched for, more than packages of robots hold: a tenth of a second."""

MADE = ".parts"
"""What a file is called beside that from which another program made it."""


class Missing(Exception):
    """There is no such file, or it cannot be read; the message says why. `help` tells what to do."""

    def __init__(self, message: str, help: str | None = None) -> None:
        super().__init__(message)
        self.help = help


@dataclass(slots=True)
class Files:
    """Reads files, and keeps what it has read, by path. `given` are the only files that there are, by path; None
    stands for the disk."""

    given: Mapping[str, bytes] | None = None
    kept: dict[str, bytes] = field(default_factory=dict)

    def first(self, paths: Iterable[str]) -> int | None:
        """Which of the paths, counted from 0, is the first that names a file."""
        known = os.path.isfile if self.given is None else self.given.__contains__
        return next((index for index, path in enumerate(paths) if known(path)), None)

    def ending(self, folder: str, end: str) -> list[str]:
        """The files below a folder whose paths end so, sorted; none where the folder holds too much to look at."""
        if self.given is None:
            below = _below(folder)
        else:
            start = "" if folder in ("", ".") else f"{folder.rstrip('/')}/"
            below = [path for path in self.given if path.startswith(start)]
        return sorted(posixpath.normpath(path) for path in below if path.endswith(f"/{end}") or path == end)

    def read(self, path: str) -> bytes:
        """The content of a file. Raises Missing."""
        if path not in self.kept:
            self.kept[path] = _on_disk(path) if self.given is None else self._carried(path)
        return self.kept[path]

    def made(self, path: str) -> str | None:
        """What another program made of the file at `path` before the plan was written, which carries it."""
        if self.given is None or f"{path}{MADE}" not in self.given:
            return None
        return self.read(f"{path}{MADE}").decode("utf-8", "replace")

    def make(self, path: str, text: str) -> None:
        """Keep what another program made of the file at `path`."""
        self.kept.setdefault(f"{path}{MADE}", text.encode())

    def _carried(self, path: str) -> bytes:
        assert self.given is not None
        if path not in self.given:
            raise Missing(f"the plan lacks the file {path}", "make the plan anew, with its files in place")
        return self.given[path]


def _below(folder: str) -> list[str]:
    """The paths of the files below a folder; links to folders are not followed."""
    found: list[str] = []
    for place, folders, files in os.walk(folder or "."):
        folders.sort()
        found += [posixpath.join(place, file) for file in files]
        if len(found) > MOST_BELOW:
            return []
    return found


def _on_disk(path: str) -> bytes:
    try:
        status = os.stat(path)
        if not stat.S_ISREG(status.st_mode):
            raise Missing(f"{path} is not a regular file")
        if status.st_size > LARGEST:
            raise Missing(f"{path} is too large: {status.st_size / 1e6:.1f} MB, at most {LARGEST / 1e6:g} MB")
        with open(path, "rb", opener=lambda name, flags: os.open(name, flags | os.O_NONBLOCK)) as stream:
            return stream.read(LARGEST)
    except (FileNotFoundError, NotADirectoryError) as error:
        raise Missing(f"there is no file {path}") from error
    except (OSError, ValueError) as error:
        raise Missing(f"cannot read {path}: {getattr(error, 'strerror', None) or error}") from error


def beside(importer: str, name: str) -> str:
    """The path of a file that `importer` names, as the user should see it."""
    return posixpath.normpath(posixpath.join(posixpath.dirname(importer), name))


def portable(names: Mapping[str, str], library: Collection[str], standard: str) -> dict[str, str]:
    """Names that say the same on any machine, by path. `names` are relative to the folder of the main text, but for
    those that a text itself writes out from the root. Only texts of the `library` may begin with `standard`: where
    another does, all are told from a folder above that is called `task`."""
    own, folder = {path: name for path, name in names.items() if path not in library}, ""
    while any(name.startswith(f"{standard}/") for name in own.values()):
        folder = posixpath.join(folder, "task")
        own = {path: posixpath.normpath(posixpath.join(folder, names[path])) for path in own}
    return {**names, **own}
