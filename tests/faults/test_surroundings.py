"""Streams that are closed or full, folders that are gone, a cluster that is none: coded, and nothing is lost."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

import pytest

from tamplang.runtime.parallel import ClusterUnavailable, open_executor

from .conftest import LIGHT, Faulty, here

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.mark.parametrize("closed", ["<&-", ">&-", "2>&-", "<&- >&- 2>&-"])
def test_closed_streams(faulty: Faulty, light: Path, tmp_path: Path, closed: str) -> None:
    process = faulty("solve", light, before=["sh", "-c", f'exec "$@" {closed}', "sh"], stdin=None)
    assert process.returncode == 0
    assert here(tmp_path, "verify", "t.plan.json").returncode == 0
    assert (tmp_path / "t.plan.json").read_bytes().startswith(b'{"format"')


@pytest.mark.parametrize("closed", ["<&-", ">&-"])
def test_a_server_without_streams_ends(faulty: Faulty, closed: str) -> None:
    assert faulty("lsp", before=["sh", "-c", f'exec "$@" {closed}', "sh"]).returncode == 0


def test_a_full_disk_behind_standard_output_costs_no_plan(faulty: Faulty, light: Path, tmp_path: Path) -> None:
    with open("/dev/full", "w") as full:
        process = faulty("solve", light, stdout=full)
    assert process.returncode == 2 and "No space left" in process.stderr
    assert here(tmp_path, "verify", "t.plan.json").returncode == 0


@pytest.mark.parametrize(
    "env",
    [
        {"COLUMNS": "1", "TERM": "dumb", "LANG": "C", "LC_ALL": "C"}, {"HOME": "", "XDG_CACHE_HOME": ""},
        {"HOME": "/nonexistent", "XDG_CACHE_HOME": "/proc/self/x", "TMPDIR": "/nonexistent"}, {"TZ": "nowhere/at/all"},
    ],
)  # fmt: skip
def test_odd_environments(faulty: Faulty, light: Path, env: dict[str, str]) -> None:
    assert faulty("sweep", light, "--out", "x.jsonl", env=env).returncode == 0


@pytest.mark.parametrize("python", [("-O",), ("-OO",), ("-W", "error"), ("-b",)])
def test_other_ways_to_run_python(faulty: Faulty, light: Path, python: tuple[str, ...]) -> None:
    assert faulty("solve", light, python=python).returncode == 0


def test_a_folder_that_is_gone(faulty: Faulty, light: Path, tmp_path: Path) -> None:
    (tmp_path / "gone").mkdir()
    gone = ["sh", "-c", 'cd gone && rmdir ../gone && exec "$@"', "sh"]
    process = faulty("solve", light, before=gone)
    assert process.returncode == 2 and "cannot use the current folder" in process.stderr


@pytest.mark.parametrize("damage", [lambda b: b[: len(b) // 2], lambda b: b"", lambda b: b"\xff" * 5000])
def test_a_damaged_cache_is_made_anew(
    faulty: Faulty, light: Path, tmp_path: Path, damage: Callable[[bytes], bytes]
) -> None:
    env = {"XDG_CACHE_HOME": str(tmp_path / "cache")}
    assert faulty("check", light, env=env).returncode == 0
    sound = {file: file.read_bytes() for file in (tmp_path / "cache" / "tamplang").iterdir()}
    assert {file.name.partition("-")[0] for file in sound} == {"grammar", "tree"}
    for file, content in sound.items():
        file.write_bytes(damage(content))
    assert faulty("check", light, env=env).returncode == 0
    assert set((tmp_path / "cache" / "tamplang").iterdir()) == set(sound)
    assert all(len(file.read_bytes()) > 0.9 * len(content) for file, content in sound.items())


def test_a_name_that_is_no_text(faulty: Faulty, tmp_path: Path) -> None:
    program = os.fsencode(tmp_path) + b"/\xff.tamp"
    with open(program, "w") as stream:
        stream.write(LIGHT)
    for command in ("check", "solve", "sweep", "run"):
        process = faulty(command, os.fsdecode(program))
        assert process.returncode == 1 and "E0011" in process.stdout + process.stderr


# --- what stands at the address of a cluster -----------------------------------------------------------------------

HTTP = b"HTTP/1.1 400 Bad Request\r\nContent-Length: 0\r\n\r\n"


@pytest.fixture
def serve() -> Iterator[Callable[[bytes | None], str]]:
    """Serve on this machine what is no cluster: those bytes, or silence (None). Gives the address."""
    servers: list[socket.socket] = []

    def start(answer: bytes | None) -> str:
        server = socket.create_server(("127.0.0.1", 0))
        servers.append(server)
        threading.Thread(target=_answer, args=(server, answer), daemon=True).start()
        return f"tcp://127.0.0.1:{server.getsockname()[1]}"

    yield start
    for server in servers:
        server.close()


def _answer(server: socket.socket, answer: bytes | None) -> None:
    kept = []
    with suppress(OSError):
        while True:
            connection, _ = server.accept()
            kept.append(connection)
            if answer is not None:
                connection.sendall(answer)
                connection.close()


@pytest.mark.parametrize("answer", [None, HTTP, b"", b"\xff" * 64, b"\0" * 64])
def test_what_is_no_cluster_is_told(serve: Callable[[bytes | None], str], answer: bytes | None) -> None:
    with pytest.raises(ClusterUnavailable, match="no cluster answers"):
        open_executor(cluster=serve(answer))


@pytest.mark.parametrize("command", ["solve", "sweep"])
def test_silence_at_the_address_of_a_cluster(
    faulty: Faulty, light: Path, serve: Callable[[bytes | None], str], command: str
) -> None:
    process = faulty(command, light, "--cluster", serve(None))
    assert process.returncode == 1 and "S0006" in process.stderr


def test_a_slow_reader_gets_all_that_is_printed_without_a_buffer() -> None:
    """Without a buffer what a signal leaves of a write to a pipe is lost, and the guard has one come all the time."""
    command = [sys.executable, "-u", "-m", "tamplang", "compile", str(EXAMPLES / "chain_climb.tamp"), "--emit"]
    with subprocess.Popen([*command, "successors"], stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        first = process.stdout.read(1)
        time.sleep(0.5)
        told = first + process.stdout.read()
    assert process.returncode == 0 and len(told) > 1_000_000 and told.endswith(b"return out\n")
