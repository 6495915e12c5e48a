"""What is kept on the disk for the next process, through the command line: full, forbidden, damaged, written by others
or by two at once. Nothing wrong is answered, and the way without it still works."""

from __future__ import annotations

import hashlib
import os
import pickle
import struct
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from .conftest import Faulty, environment

HOOK = [(0.0, 0.0), (0.3, 0.0), (0.3, 0.05), (0.05, 0.05), (0.05, 0.3), (0.0, 0.3)]
"""The outline of a body that is not convex, seen whole from its first corner."""
SCENE = """import std.logic
predicate (lit)
rule light() { pre not (lit) post (lit) }
task t() { object b: mesh("hook.stl") at (0, 0, 1 m) goal (lit) }
"""


@pytest.fixture
def cache(tmp_path: Path) -> Path:
    """A program with a mesh in the empty folder of the test; gives where its cache is to be."""
    n, sides = len(HOOK), range(len(HOOK))
    points = [(x, y, z) for z in (0.0, 0.05) for x, y in HOOK]
    faces = [f for i in sides for f in ((i, (i + 1) % n, n + (i + 1) % n), (i, n + (i + 1) % n, n + i))]
    faces += [f for k in range(1, n - 1) for f in ((0, k + 1, k), (n, n + k, n + k + 1))]
    packed = b"".join(struct.pack("<12fH", 0, 0, 0, *(v for i in face for v in points[i]), 0) for face in faces)
    (tmp_path / "hook.stl").write_bytes(b"\0" * 80 + struct.pack("<I", len(faces)) + packed)
    (tmp_path / "t.tamp").write_text(SCENE)
    return tmp_path / "cache"


Compiled = Callable[..., str]


@pytest.fixture
def compiled(faulty: Faulty, cache: Path) -> Compiled:
    """What the command says of the scene, with the parts of its mesh."""

    def told(**how: object) -> str:
        process = faulty("compile", "t.tamp", "--emit", "ir", env={"XDG_CACHE_HOME": str(cache)}, **how)
        assert (process.returncode, process.stderr) == (0, "")
        assert "union" in process.stdout
        return process.stdout

    return told


def kept(cache: Path) -> dict[Path, bytes]:
    """What is there, but of the grammar, of which no two are the same byte for byte."""
    files = sorted((cache / "tamplang").iterdir())
    return {file: b"" if file.name.startswith("grammar") else file.read_bytes() for file in files}


def test_one_changed_digit_is_not_believed(compiled: Compiled, cache: Path) -> None:
    sound, written = compiled(), kept(cache)
    assert {file.name.partition("-")[0] for file in written} == {"grammar", "tree", "parts"}
    for file in written:
        content = file.read_bytes()
        changed = content.replace(b"0.05", b"0.07") if file.suffix == ".json" else content[:-40] + b"0" * 40
        assert changed != content
        file.write_bytes(changed)
    assert compiled() == sound
    assert kept(cache) == written, "what was spoilt is made anew"


def test_a_full_disk(faulty: Faulty, cache: Path, light: Path) -> None:
    full = ["sh", "-c", 'ulimit -f 0; exec "$@"', "sh"]
    for _ in range(2):
        process = faulty("compile", light, "--emit", "ir", before=full, env={"XDG_CACHE_HOME": str(cache)})
        assert process.returncode == 0 and "lit" in process.stdout
        assert kept(cache) == {}, "no half of a file is left"
    process = faulty("compile", "t.tamp", "--emit", "ir", before=full, env={"XDG_CACHE_HOME": str(cache)})
    assert process.returncode == 2 and "cannot write temporary files" in process.stderr


def test_a_folder_in_which_nothing_can_be_made(compiled: Compiled, cache: Path) -> None:
    (cache / "tamplang").mkdir(parents=True)
    os.chmod(cache / "tamplang", 0o500)
    sound = compiled()
    os.chmod(cache / "tamplang", 0o000)
    assert compiled() == sound
    os.chmod(cache / "tamplang", 0o700)


def test_what_other_versions_wrote_under_the_same_names(compiled: Compiled, cache: Path) -> None:
    sound, written = compiled(), kept(cache)
    gone = b"ctamplang.langs.syntax\nGone\n."
    for told in (gone, pickle.dumps({"version": 99}), b"[1, 2]", b"{}", b"[[], [[0.0]], 1, null]"):
        for file in written:
            file.write_bytes(hashlib.sha256(told).digest() + told)
        assert compiled() == sound
        assert kept(cache) == written


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="only root can give files away")
def test_files_of_another_user_are_not_opened(compiled: Compiled, cache: Path) -> None:
    sound, written = compiled(), kept(cache)
    for file, content in written.items():
        if file.suffix == ".json":
            told = content[32:].replace(b"0.05", b"0.07")
            file.write_bytes(hashlib.sha256(told).digest() + told)
            os.chown(file, 65534, 65534)
    assert compiled() == sound


def test_two_processes_that_begin_at_once(compiled: Compiled, cache: Path, tmp_path: Path) -> None:
    command = [sys.executable, "-m", "tamplang", "compile", "t.tamp", "--emit", "ir"]
    told = environment(XDG_CACHE_HOME=str(cache))
    started = [
        subprocess.Popen(command, cwd=tmp_path, env=told, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        for _ in range(2)
    ]
    answers = [process.communicate(timeout=120) for process in started]
    assert answers[0] == answers[1] == (compiled(), "")
    written = kept(cache)
    assert {file.name.partition("-")[0] for file in written} == {"grammar", "tree", "parts"}
    assert compiled() == answers[0][0] and kept(cache) == written
