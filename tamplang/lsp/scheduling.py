"""When to check: after a pause, one text at a time, the newest text of each, and nothing that was overtaken."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable

PAUSE = 0.1
"""Seconds without a key before a check begins: shorter than a pause for thought, longer than between two keys."""


class Checks:
    """Runs `work(uri)` for texts that were touched. A text that is touched again before its pause is over, or while it
    waits for another one's check, is checked once, as it stands then. What goes wrong is told to `failed`."""

    def __init__(
        self,
        work: Callable[[str], Awaitable[None]],
        loop: asyncio.AbstractEventLoop,
        failed: Callable[[Exception], None],
    ) -> None:
        self._work = work
        self._failed = failed
        self._loop = loop
        self._pauses: dict[str, asyncio.TimerHandle] = {}
        self._ready: dict[str, None] = {}
        self._running = False
        self._task: asyncio.Task[None] | None = None

    def touch(self, uri: str, pause: float = PAUSE) -> None:
        """The text changed: check it when it rests."""
        self.forget(uri)
        self._pauses[uri] = self._loop.call_later(pause, self._rested, uri)

    def forget(self, uri: str) -> None:
        """What was not begun is not done."""
        waiting = self._pauses.pop(uri, None)
        if waiting is not None:
            waiting.cancel()
        self._ready.pop(uri, None)

    def _rested(self, uri: str) -> None:
        self._pauses.pop(uri, None)
        self._ready[uri] = None
        if not self._running:
            self._running = True
            self._task = self._loop.create_task(self._run())

    async def _run(self) -> None:
        try:
            while self._ready:
                uri = next(iter(self._ready))
                del self._ready[uri]
                try:
                    await self._work(uri)
                except Exception as error:  # the next text is checked all the same
                    self._failed(error)
        finally:
            self._running = False
