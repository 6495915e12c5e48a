"""The last word on time and memory: a timer that looks at both, whatever the process is doing.

Loops ask their budget themselves. What no loop of ours holds, such as reading, checking and compiling programs, is
ended from outside: a timer of the system interrupts the main thread as Ctrl-C does, between two steps of Python, and
raises `OutOfTime` or `OutOfMemory` there. One place ends every pass, also those that are still to be written, without
a question in each of their loops. What was raised inside the callback of a library may be lost there, so it is raised
again until somebody says that it arrived. Files are written whole or not at all, as they have to be for Ctrl-C.

A single call of a compiled library cannot be interrupted. For memory the system itself refuses what is far too much:
that arrives as MemoryError.
"""

from __future__ import annotations

import contextlib
import math
import os
import resource
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

from . import budget
from .budget import Budget, OutOfMemory, OutOfTime, closing_time

LOOK = 0.05
"""Seconds between two looks."""
GRACE = 0.1
"""Seconds that the loops have to notice by themselves that the time is spent: they know best how to end."""
AGAIN = 1.0
"""Seconds until what was raised and not answered is raised again: to unwind what was under way takes its time."""
_ENDING = (__file__, contextlib.__file__, budget.__file__)
"""Where an ending is under way: what is raised between the steps of these would escape it, so it waits for the next
look."""
_WRAPPING = "__set_name__"
"""Python 3.11 wraps whatever is raised in such a method, or in what it calls, into a RuntimeError: what is raised waits
there, too."""
SHARE = 0.8
"""How much of the memory that is free at the start a command may take, where nothing else is said."""
PAGE = os.sysconf("SC_PAGE_SIZE")
SLACK = 1.25
"""How far above its limit a process may go, with what it has mapped already, before the system refuses more."""
LIBRARIES = 2**29
"""But never less than so many bytes: some libraries of linear algebra hang or end the process where the system refuses
them their buffers. Those of a solve map 220 MB, and more where they see many cores; the timer still looks."""


class Guard(Budget):
    """A budget that raises by itself, of seconds and of `memory` in bytes of this process."""

    def __init__(self, seconds: float | None, memory: int | None, started: float | None = None) -> None:
        super().__init__(seconds, started=started)
        self.memory = memory
        self.doing = ""
        """What is under way, for who tells that it was too much."""
        self._quiet_until = 0.0
        self._closes = False
        self._rests = False
        self._interrupted = False
        self.loops = 0
        """How many loops are under way that look at their budget themselves."""
        self.optional = 0
        """How many pieces of work are under way that may be left out."""

    @property
    def seconds_of_work(self) -> float:
        """When the work is interrupted."""
        return math.inf if self.seconds is None else self.seconds + (GRACE if self.loops else 0.0)

    @property
    def closed(self) -> bool:
        """Whether even the time for what follows the work is spent."""
        if self.seconds is None:
            return False
        return self.elapsed > self.seconds + closing_time(self.seconds)

    def close(self) -> None:
        """The work is done, or what was raised arrived. What puts together what was found goes on to its end; what may
        be left out, such as its verification, has a time of its own, and is interrupted once."""
        self._rests = self._closes and self.closed
        self._closes = True

    def rest(self) -> None:
        """Raise nothing any more."""
        self._rests = True

    def lost(self, unraisable: sys.UnraisableHookArgs) -> bool:
        """Whether what a signal raised got lost in a callback; then it is raised again at the next look."""
        if isinstance(unraisable.exc_value, KeyboardInterrupt):
            self._interrupted = True
        elif isinstance(unraisable.exc_value, OutOfTime):
            self._quiet_until = 0.0
        else:
            return False
        return True

    def look(self, number: int, frame: FrameType | None) -> None:
        """Raise OutOfTime or OutOfMemory when it is so, and what got lost (a signal handler)."""
        now = time.monotonic()
        if self._interrupted:
            self._interrupted = False
            raise KeyboardInterrupt
        if self._rests or now < self._quiet_until:
            return
        if frame is not None and (frame.f_code.co_filename in _ENDING or _wraps(frame)):
            return
        if self.memory is not None and not self._closes and resident() > self.memory:
            self._quiet_until = now + AGAIN
            raise OutOfMemory
        if self._closes and not self.optional:
            return
        if self.closed if self._closes else now - self.started > self.seconds_of_work:
            self._quiet_until = now + AGAIN
            raise OutOfTime


def _wraps(frame: FrameType) -> bool:
    """Whether something around what is under way would make another error of what is raised."""
    around: FrameType | None = frame
    while around is not None and around.f_code.co_name != _WRAPPING:
        around = around.f_back
    return around is not None


_guards: list[Guard] = []


def answered() -> None:
    """Say that OutOfTime or OutOfMemory arrived, or that the loop is done: it is raised once more, where something that
    may be left out takes too long."""
    if _guards:
        _guards[-1].close()


@contextmanager
def interruptible() -> Iterator[None]:
    """Around work that may be left out where the time for what follows the work is spent."""
    guard = _guards[-1] if _guards else Guard(None, None)
    guard.optional += 1
    try:
        yield
    finally:
        guard.optional -= 1


@contextmanager
def looking() -> Iterator[None]:
    """Around a loop that looks at its budget itself, and knows best how to end."""
    guard = _guards[-1] if _guards else Guard(None, None)
    guard.loops += 1
    try:
        yield
    finally:
        guard.loops -= 1


def closing() -> None:
    """Say that the work is done. Raises OutOfTime when even the time for what follows is spent."""
    if _guards:
        _guards[-1].close()
        if _guards[-1].closed:
            raise OutOfTime


@contextmanager
def guarded(seconds: float | None, memory: int | None, started: float | None = None) -> Iterator[Guard]:
    """Raise OutOfTime or OutOfMemory in the code inside once more is spent, where that is the main thread."""
    guard = Guard(seconds, memory, started)
    if threading.current_thread() is not threading.main_thread():
        yield guard
        return
    handler, timer = signal.getsignal(signal.SIGALRM), signal.getitimer(signal.ITIMER_REAL)
    limits = resource.getrlimit(resource.RLIMIT_DATA)
    hook = sys.unraisablehook
    _guards.append(guard)
    try:
        signal.signal(signal.SIGALRM, guard.look)
        signal.setitimer(signal.ITIMER_REAL, LOOK, LOOK)
        sys.unraisablehook = lambda unraisable: None if guard.lost(unraisable) else hook(unraisable)
        if memory is not None:
            _refuse_beyond(max(int(SLACK * memory), LIBRARIES), limits)
        yield guard
    finally:
        guard.rest()
        _guards.remove(guard)
        signal.setitimer(signal.ITIMER_REAL, *timer)
        signal.signal(signal.SIGALRM, signal.SIG_IGN)  # what another thread has not taken yet is gone with it
        signal.signal(signal.SIGALRM, handler)
        sys.unraisablehook = hook
        resource.setrlimit(resource.RLIMIT_DATA, limits)


def _refuse_beyond(memory: int, limits: tuple[int, int]) -> None:
    soft, hard = limits
    mapped = int(_status("VmData") or 0)
    wanted = min(v for v in (memory + mapped, soft, hard) if v != resource.RLIM_INFINITY)
    resource.setrlimit(resource.RLIMIT_DATA, (wanted, hard))


def resident() -> int:
    """Bytes of memory that this process takes; 0 where the system does not tell."""
    try:
        with open("/proc/self/statm", "rb") as file:
            return int(file.read().split()[1]) * PAGE
    except (OSError, IndexError, ValueError):
        return 0


def free_memory() -> int | None:
    """Bytes that this process may take from now on: what the machine has left, and its group of processes (cgroup);
    None where the system does not tell."""
    found = [free for free in (_meminfo("MemAvailable"), *_groups()) if free is not None]
    return max(0, min(found)) if found else None


def memory_limit(given: int | None, processes: int = 1) -> int | None:
    """The limit of each process: what is given, or SHARE of what is free, in equal parts."""
    if given is not None:
        return given // processes
    free = free_memory()
    return None if free is None else resident() + int(SHARE * free) // processes


def process_age() -> float:
    """Seconds since this process was started; 0 where the system does not tell."""
    try:
        fields = Path("/proc/self/stat").read_text(encoding="utf-8", errors="replace").rpartition(")")[2].split()
        born = int(fields[19]) / os.sysconf("SC_CLK_TCK")
        return max(0.0, time.clock_gettime(time.CLOCK_BOOTTIME) - born)
    except (OSError, IndexError, ValueError, AttributeError):
        return 0.0


def _groups() -> Iterator[int | None]:
    """What is left in each group of processes around this one, in both forms of cgroups."""
    try:
        lines = Path("/proc/self/cgroup").read_text(encoding="utf-8").splitlines()
    except OSError:
        return
    for line in lines:
        _, controllers, path = line.split(":", 2)
        root, limit, usage = Path("/sys/fs/cgroup"), "memory.max", "memory.current"
        if controllers:
            if "memory" not in controllers.split(","):
                continue
            root, limit, usage = root / "memory", "memory.limit_in_bytes", "memory.usage_in_bytes"
        folder = root / path.lstrip("/")
        for group in (folder, *folder.parents):
            most, taken = _number(group / limit), _number(group / usage)
            if most is not None and taken is not None:
                yield most - taken
            if group == root:
                break


def _number(file: Path) -> int | None:
    try:
        return int(file.read_text(encoding="ascii"))
    except (OSError, ValueError):
        return None


def _meminfo(name: str) -> int | None:
    return _field(Path("/proc/meminfo"), name)


def _status(name: str) -> int | None:
    return _field(Path("/proc/self/status"), name)


def _field(file: Path, name: str) -> int | None:
    """A size of a file of the system such as `MemAvailable:  1024 kB`, in bytes."""
    try:
        for line in file.read_text(encoding="ascii", errors="replace").splitlines():
            if line.startswith(f"{name}:"):
                return int(line.split()[1]) * 1024
    except (OSError, IndexError, ValueError):
        pass
    return None
