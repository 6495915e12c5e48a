"""A time budget that every loop of the runtime asks, and a clock for its stages."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from enum import StrEnum
from typing import TypeVar

from ..compiler.options import OPTIONS
from ..langs.diagnostics import Error

Result = TypeVar("Result")

SECONDS: float = OPTIONS["time"].default
"""What a solve may take where nothing else is said."""
SECONDS_OF_RUN = 120.0
"""So much a run in the simulated world."""


OVERRUN, LEAST_OVERRUN = 0.1, 0.3
"""A command ends within its time and this share of it, or so many seconds where that is more."""
CLOSING = 0.5
"""The share of what a command may overrun in which it may verify, measure and draw; the rest is for its last file and
the end of the process."""
ASIDE = 0.1
"""The share of the time that stays for the verifier, where a loop ends with a plan that is still to be verified. Long
plans of the examples take an eighth of what was needed to find them: so much comes together with the closing time."""


class OutOfTime(Error):
    """The time budget is spent; whoever catches it still reports what was found."""


class OutOfMemory(OutOfTime):
    """So is the memory."""


def closing_time(seconds: float) -> float:
    """Seconds from the end of a command's time in which it may still verify, measure and draw."""
    return CLOSING * max(OVERRUN * seconds, LEAST_OVERRUN)


class Budget:
    """Wall-clock seconds from now but for the share set `aside`, and nodes of all search trees together; `None` never
    ends. They may count from `started` instead, as `time.monotonic` tells it."""

    def __init__(
        self, seconds: float | None, nodes: int | None = None, aside: float = 0.0, started: float | None = None
    ) -> None:
        self._whole = self
        if aside and seconds is not None:
            self._whole = Budget(seconds + closing_time(seconds), started=started)
        self.seconds = None if seconds is None else (1.0 - aside) * seconds
        self.nodes = nodes
        self.grown = 0
        """Nodes that were made so far."""
        self.started = time.monotonic() if started is None else started

    @property
    def elapsed(self) -> float:
        return time.monotonic() - self.started

    @property
    def remaining(self) -> float:
        """Seconds left, never below 0; infinite without a limit."""
        return float("inf") if self.seconds is None else max(0.0, self.seconds - self.elapsed)

    @property
    def whole(self) -> Budget:
        """With what was set aside, and the closing time: for the verifier."""
        return self._whole

    @property
    def full(self) -> bool:
        """Whether the trees have as many nodes as they may have."""
        return self.nodes is not None and self.grown >= self.nodes

    def check(self) -> None:
        """Raise `OutOfTime` once the budget is spent."""
        self.left()

    def left(self) -> float:
        """Seconds left, more than 0. Raises `OutOfTime` once the budget is spent."""
        seconds = self.remaining
        if seconds <= 0.0:
            raise OutOfTime
        return seconds


class Status(StrEnum):
    """How a search, a solve or a run ended, or that it goes on: infeasible is proved; exhausted has every candidate
    refused; refused is by the verifier. Of runs only: stuck where no way leads on, and lost where a breakdown took
    what carries a robot or holds a thing."""

    RUNNING = "running"
    SOLVED = "solved"
    INFEASIBLE = "infeasible"
    EXHAUSTED = "exhausted"
    BUDGET = "budget"
    MEMORY = "memory"
    INTERRUPTED = "interrupted"
    REFUSED = "refused"
    STUCK = "stuck"
    LOST = "lost"


def ending(loop: Callable[[], Status]) -> Status:
    """The status that `loop` ends with, or the one of time or memory that ran out, or of Ctrl-C. What follows
    is not interrupted by the guard, but in `unless_spent`."""
    from .guard import answered, looking

    try:
        with looking():
            return loop()
    except (OutOfTime, MemoryError, RuntimeError, SystemError) as error:
        if not (isinstance(error, OutOfTime) or is_out_of_memory(error)):
            raise
        return Status.MEMORY if is_out_of_memory(error) else Status.BUDGET
    except KeyboardInterrupt:
        return Status.INTERRUPTED
    finally:
        answered()


def unless_spent(work: Callable[[], Result]) -> Result | None:
    """What `work` gives; None when time or memory are spent before."""
    from .guard import answered, interruptible

    try:
        with interruptible():
            return work()
    except (OutOfTime, MemoryError, RuntimeError, SystemError) as error:
        if not (isinstance(error, OutOfTime) or is_out_of_memory(error)):
            raise
        answered()
        return None


def is_out_of_memory(error: BaseException) -> bool:
    """Whether an error says that the system gave no more memory, to Python or to a compiled library. Where Python
    itself gets none it may return nothing and not even say so."""
    told = ("std::bad_alloc", "without setting an exception", "without exception set")
    return isinstance(error, OutOfMemory | MemoryError) or any(words in str(error) for words in told)


class Clock:
    """Wall-clock seconds per stage."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}

    @contextmanager
    def __call__(self, stage: str) -> Iterator[None]:
        started = time.monotonic()
        try:
            yield
        finally:
            self.seconds[stage] = self.seconds.get(stage, 0.0) + time.monotonic() - started
