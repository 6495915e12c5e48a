"""Small sweeps, run as a user does, and a look at the processes behind them."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import chdir, redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

from tamplang.cli import run

ROOT = Path(__file__).resolve().parents[2]
CLIMB = ROOT / "examples" / "climb.tamp"
SMALL = ("-p", "n=1..2", "-p", "crawlers=1")


def start(folder: Path, *arguments: object) -> subprocess.Popen[str]:
    """The command `tamplang sweep climb` in a session of its own, so that it and its processes are known by it."""
    return begin(folder, "sweep", CLIMB, *arguments)


def begin(folder: Path, *arguments: object) -> subprocess.Popen[str]:
    """The command `tamplang` in a session of its own."""
    return subprocess.Popen(
        [sys.executable, "-m", "tamplang", *map(str, arguments)],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


def sweep(folder: Path, *arguments: object, status: int = 0) -> tuple[str, str]:
    """What the command prints on standard output and on standard error."""
    with start(folder, *arguments) as process:
        out, err = process.communicate(timeout=180)
    assert process.returncode == status, err
    assert "Traceback" not in err
    return out, err


def sweep_here(folder: Path, *arguments: object, status: int = 0) -> tuple[str, str]:
    """The same in the process of the tests: quick, but with the numerical libraries as they were loaded."""
    out, err = StringIO(), StringIO()
    with chdir(folder), redirect_stdout(out), redirect_stderr(err):
        assert run(["sweep", str(CLIMB), *map(str, arguments)]) == status
    return out.getvalue(), err.getvalue()


def lines(path: Path) -> list[dict[str, Any]]:
    """The results in the file."""
    return [json.loads(line) for line in path.read_text().splitlines()]


def timeless(records: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The results without times, in the order of their keys."""
    kept = [{n: v for n, v in r.items() if n not in ("seconds", "cpu_seconds")} for r in records]
    return sorted(kept, key=lambda record: str(record["key"]))


def session(number: int) -> list[int]:
    """The living processes of a session."""
    found = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = path.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[3]) == number and fields[0] != "Z":
            found.append(int(path.parent.name))
    return found


def workers() -> list[int]:
    """The living processes that this one has started for work."""
    return [p for p in session(os.getsid(0)) if _parent(p) == os.getpid() and b"serve(pipe" in _command(p)]


def _parent(process: int) -> int:
    try:
        return int(Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[1])
    except OSError:
        return -1


def _command(process: int) -> bytes:
    try:
        return Path(f"/proc/{process}/cmdline").read_bytes()
    except OSError:
        return b""


def is_solving(process: int | None) -> bool:
    """Whether the process has come as far as the motion programs."""
    try:
        return "libcasadi" in Path(f"/proc/{process}/maps").read_text()
    except OSError:
        return False


def wait_until(condition: Callable[[], object], seconds: float = 90.0) -> None:
    """Wait for it, and fail when it does not come true."""
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.02)
