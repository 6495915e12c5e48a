"""When texts are checked: counted on a clock that the test moves, so that no load can change it."""

from __future__ import annotations

import asyncio
import heapq
from collections.abc import Callable, Coroutine
from contextlib import suppress
from typing import Any, cast

from tamplang.lsp.scheduling import Checks


class Clock:
    """The part of an event loop that the checks use; time passes by `run`."""

    def __init__(self) -> None:
        self.now = 0.0
        self.waiting: list[tuple[float, int, Callable[..., object], tuple[object, ...], list[bool]]] = []
        self.number = 0

    def call_later(self, delay: float, call: Callable[..., object], *args: object) -> Any:
        self.number += 1
        alive = [True]
        heapq.heappush(self.waiting, (self.now + delay, self.number, call, args, alive))
        return type("Handle", (), {"cancel": lambda self: alive.__setitem__(0, False)})()

    def create_task(self, work: Coroutine[Any, Any, None]) -> None:
        self._step(work)

    def _step(self, work: Coroutine[Any, Any, None]) -> None:
        with suppress(StopIteration):
            self.call_later(cast(float, work.send(None)), self._step, work)

    def run(self, until: float) -> None:
        while self.waiting and self.waiting[0][0] <= until:
            self.now, _, call, args, alive = heapq.heappop(self.waiting)
            if alive[0]:
                call(*args)
        self.now = until


class Seconds:
    """What a check awaits: so many seconds of the clock."""

    def __init__(self, seconds: float) -> None:
        self.seconds = seconds

    def __await__(self) -> Any:
        yield self.seconds


def typed(seconds_of_a_check: float, keys: list[tuple[float, str]]) -> tuple[list[tuple[float, str]], int]:
    """When which text was checked, and how many checks ran at once at most."""
    clock, begun, running, most = Clock(), list[tuple[float, str]](), 0, 0

    async def work(uri: str) -> None:
        nonlocal running, most
        begun.append((clock.now, uri))
        running += 1
        most = max(most, running)
        await Seconds(seconds_of_a_check)
        running -= 1

    checks = Checks(work, cast(asyncio.AbstractEventLoop, clock), lambda error: None)
    for when, uri in keys:
        clock.run(when)
        checks.touch(uri)
    clock.run(clock.now + 60)
    return begun, most


def test_eighty_keys_in_two_seconds_cost_one_check() -> None:
    begun, _ = typed(0.05, [(i / 40, "a") for i in range(80)])
    assert len(begun) == 1
    assert abs(begun[0][0] - (79 / 40 + 0.1)) < 1e-9


def test_eighty_keys_with_two_pauses_cost_three_checks() -> None:
    keys = [(i * 0.02 + 0.2 * (i // 30), "a") for i in range(80)]
    assert keys[-1][0] < 2.0
    assert len(typed(0.05, keys)[0]) == 3


def test_slow_checks_do_not_pile_up() -> None:
    """With a pause behind every key and checks that take a second, a new one begins when the last is done."""
    begun, most = typed(1.0, [(i * 0.15, "a") for i in range(14)])
    assert most == 1 and len(begun) == 3


def test_each_text_is_checked_and_one_at_a_time() -> None:
    begun, most = typed(0.5, [(0.0, "a"), (0.01, "b"), (0.02, "c"), (0.3, "b")])
    assert most == 1
    assert [uri for _, uri in begun] == ["a", "c", "b"]


def test_what_fails_stops_no_later_check() -> None:
    clock, begun, failures = Clock(), list[str](), list[Exception]()

    async def work(uri: str) -> None:
        begun.append(uri)
        raise ValueError(uri)

    checks = Checks(work, cast(asyncio.AbstractEventLoop, clock), failures.append)
    checks.touch("a")
    checks.touch("b")
    clock.run(1)
    assert begun == ["a", "b"] and [str(f) for f in failures] == ["a", "b"]


def test_a_forgotten_text_is_not_checked() -> None:
    clock, begun = Clock(), list[str]()

    async def work(uri: str) -> None:
        begun.append(uri)

    checks = Checks(work, cast(asyncio.AbstractEventLoop, clock), lambda error: None)
    checks.touch("a")
    checks.forget("a")
    clock.run(1)
    assert begun == []
