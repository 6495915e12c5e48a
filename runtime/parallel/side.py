"""The interface: an executor that is told how work ends, well or not."""

from __future__ import annotations

import traceback
from abc import abstractmethod
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from types import TracebackType
from typing import Any, ParamSpec, TypeVar

from ...langs.diagnostics import Error

P = ParamSpec("P")
T = TypeVar("T")
Item = TypeVar("Item")


class ClusterUnavailable(Error):
    """There is no cluster to work on; `hint` says what to do."""

    def __init__(self, message: str, hint: str) -> None:
        super().__init__(message, hint)
        self.message, self.hint = message, hint

    def __str__(self) -> str:
        return self.message


class WorkerLost(Exception):
    """The process that had the work ended before it was done, and so did the one that took over."""


class WorkFailed(Exception):
    """The work raised an error; `kind` is its class by name, `trace` its traceback as text."""

    def __init__(self, kind: str, message: str, trace: str) -> None:
        super().__init__(kind, message, trace)
        self.kind, self.message, self.trace = kind, message, trace

    def __str__(self) -> str:
        return f"{self.kind}: {self.message}"


class Side(Executor):
    """An executor that knows how many pieces of work keep it busy. Errors of the work arrive as WorkFailed; work that
    was lost with its process arrives as WorkerLost."""

    @property
    @abstractmethod
    def width(self) -> int:
        """How many pieces of work to have under way."""

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if error is not None:
            self.kill()
        self.shutdown(wait=True, cancel_futures=error is not None)

    @abstractmethod
    def kill(self) -> None:
        """Drop all work at once. What is under way ends without a result."""


def as_finished(
    executor: Side, function: Callable[[Item], T], items: Iterable[Item]
) -> Iterator[tuple[Item, Future[T]]]:
    """Every item with the finished future of `function(item)`, as they come. No more is under way than keeps the
    executor busy."""
    waiting = iter(items)
    running: dict[Future[T], Item] = {}
    while True:
        for _ in range(executor.width - len(running)):
            for item in waiting:
                running[executor.submit(function, item)] = item
                break
        if not running:
            return
        done = wait(running, return_when=FIRST_COMPLETED).done
        for future in [f for f in running if f in done]:
            yield running.pop(future), future


class InProcess(Side):
    """Computes in this thread, at once."""

    width = 1

    def submit(self, fn: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        future: Future[T] = Future()
        settle(future, attempt(fn, *args, **kwargs))
        return future

    def kill(self) -> None:
        """There is nothing under way."""


def attempt(function: Callable[..., T], /, *args: Any, **kwargs: Any) -> tuple[T | None, WorkFailed | None]:
    """The result of the call, or its error in a form that any process can read."""
    try:
        return function(*args, **kwargs), None
    except Exception as error:  # whatever it is, it belongs to who asks for the result
        return None, WorkFailed(type(error).__name__, str(error), traceback.format_exc())


def unpacked(answer: tuple[T, WorkFailed | None]) -> T:
    """The result that `attempt` gave, or its error raised."""
    result, error = answer
    if error is not None:
        raise error
    return result


def settle(future: Future[Any], answer: tuple[Any, WorkFailed | None]) -> None:
    """Finish the future with what `attempt` gave."""
    result, error = answer
    if error is not None:
        future.set_exception(error)
    else:
        future.set_result(result)
