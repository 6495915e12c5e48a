"""A time budget that every loop of the runtime asks, and a clock for its stages."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

SECONDS = 60.0
"""What a solve may take where nothing else is said."""
SECONDS_OF_RUN = 120.0
"""So much a run in the simulated world."""


class OutOfTime(Exception):
    """The time budget is spent; whoever catches it still reports what was found."""


class OutOfMemory(OutOfTime):
    """So is the memory."""


class Budget:
    """Wall-clock seconds from now, and nodes of all search trees together; `None` never ends."""

    def __init__(self, seconds: float | None, nodes: int | None = None) -> None:
        self.seconds = seconds
        self.nodes = nodes
        self.grown = 0
        """Nodes that were made so far."""
        self.started = time.monotonic()

    @property
    def elapsed(self) -> float:
        return time.monotonic() - self.started

    @property
    def remaining(self) -> float:
        """Seconds left, never below 0; infinite without a limit."""
        return float("inf") if self.seconds is None else max(0.0, self.seconds - self.elapsed)

    @property
    def full(self) -> bool:
        """Whether the trees have as many nodes as they may have."""
        return self.nodes is not None and self.grown >= self.nodes

    def check(self) -> None:
        """Raise `OutOfTime` once the budget is spent."""
        if self.remaining <= 0.0:
            raise OutOfTime


def ending(loop: Callable[[], str]) -> str:
    """The status that `loop` ends with; "budget" when it runs out of time, "memory" when it runs out of memory,
    "interrupted" after Ctrl-C."""
    from .guard import answered

    try:
        return loop()
    except OutOfMemory:
        answered()
        return "memory"
    except OutOfTime:
        answered()
        return "budget"
    except (MemoryError, RuntimeError) as error:
        if not is_out_of_memory(error):
            raise
        answered()
        return "memory"
    except KeyboardInterrupt:
        return "interrupted"


def is_out_of_memory(error: BaseException) -> bool:
    """Whether an error says that the system gave no more memory, to Python or to a compiled library."""
    return isinstance(error, OutOfMemory | MemoryError) or "std::bad_alloc" in str(error)


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
