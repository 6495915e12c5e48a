"""The processes of a `distributed` cluster, an optional extra."""

from __future__ import annotations

import logging
import os
import socket
import threading
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from importlib import import_module
from importlib.util import find_spec
from typing import Any, ParamSpec, TypeVar

from ... import __version__
from .processes import Processes
from .side import ClusterUnavailable, Side, WorkerLost, WorkFailed, attempt, settle

P = ParamSpec("P")
T = TypeVar("T")

ANSWER_SECONDS = 4.0
"""How long a cluster has to answer, at each step of the connection."""
DEADLINE = 6.0
"""Seconds for all steps together."""
START = "start it with `dask scheduler`, and give the address that it prints, such as tcp://127.0.0.1:8786"


class Cluster(Side):
    """Computes on the processes of a `distributed` cluster. Its scheduler gives the work of a lost process to others,
    and gives up after some losses (its setting `allowed-failures`). Work that was given to a scheduler that is gone
    arrives as ClusterUnavailable."""

    def __init__(self, address: str) -> None:
        _check_answer(address)
        self._client = _connected(address)
        self._executor = self._client.get_executor(pure=False)
        self._address = address
        self._closed: type[Exception] = import_module("distributed.client").ClosedClientError

    @property
    def width(self) -> int:
        """Twice the number of workers, so that none waits for the next piece. Raises ClusterUnavailable."""
        try:
            return 2 * max(1, len(self._client.nthreads()))
        except OSError as error:
            raise self._gone() from error

    def _gone(self) -> ClusterUnavailable:
        return ClusterUnavailable(f"the cluster at {self._address} is gone", "start it again, and give the work again")

    def submit(self, fn: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        future: Future[T] = Future()
        future.set_running_or_notify_cancel()  # it cannot be taken back

        def finish(inner: Future[Any]) -> None:
            if inner.cancelled():
                future.set_exception(self._gone())
            elif (error := inner.exception()) is not None:
                future.set_exception(WorkerLost(f"the cluster gave the work up: {error}"))
            else:
                settle(future, inner.result())

        try:
            inner = self._executor.submit(_attempt_alone, fn, *args, **kwargs)
        except self._closed as error:
            raise self._gone() from error
        inner.add_done_callback(finish)
        return future

    def kill(self) -> None:
        if self._client.status == "running":
            self._executor.shutdown(wait=False)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        if wait and not cancel_futures:
            self._executor.shutdown(wait=True)
        self._client.close()


_alone = threading.Lock()


def _attempt_alone(function: Callable[..., T], /, *args: Any, **kwargs: Any) -> tuple[T | None, WorkFailed | None]:
    """`attempt` on a cluster, where a process may have got several threads since it was looked at."""
    with _alone:
        return attempt(function, *args, **kwargs)


def _check_answer(address: str) -> None:
    """Let another process connect first: what stands at the address may be no cluster, and `distributed` waits without
    end for one that is silent, and breaks on what others answer. Raises ClusterUnavailable."""
    if find_spec("distributed") is None:
        raise _missing()
    host, _, port = address.removeprefix("tcp://").rpartition(":")
    with Processes(1) as side:
        try:
            with socket.create_connection((host.strip("[]"), int(port)), ANSWER_SECONDS) as connection:
                if not connection.recv(1):  # a scheduler speaks first
                    raise OSError("it says nothing")
            loaded = side.submit(_imported)
            _library()
            loaded.result()
            trouble = side.submit(_trouble, address).result(DEADLINE)
        except (OSError, ValueError, OverflowError, WorkerLost, WorkFailed) as error:
            side.kill()
            raise ClusterUnavailable(f"no cluster answers at {address}", START) from error
    if trouble is not None:
        raise ClusterUnavailable(*trouble)


def _imported() -> None:
    """Load the library, which takes longer on a busy machine than a cluster may take to answer."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)  # it tells of its broken connections
    with suppress(ImportError):
        import_module("distributed")


def _trouble(address: str) -> tuple[str, str] | None:
    """Why there is no cluster at the address, and what to do."""
    try:
        _connected(address).close()
    except ClusterUnavailable as error:
        return error.message, error.hint
    return None


def _connected(address: str) -> Any:
    """A client of the cluster at `address`, whose processes are fit for the work. Raises ClusterUnavailable."""
    distributed = _library()
    for logger in ("distributed", "distributed.client"):  # what they say, the errors of this module say
        logging.getLogger(logger).setLevel(logging.CRITICAL)
    try:
        client = distributed.Client(address, timeout=ANSWER_SECONDS, set_as_default=False)
    except (OSError, ValueError) as error:
        raise ClusterUnavailable(f"no cluster answers at {address}", START) from error
    try:
        _check_workers(client)
    except ClusterUnavailable:
        client.close()
        raise
    return client


def _library() -> Any:
    """The package `distributed`. Raises ClusterUnavailable."""
    try:
        return import_module("distributed")
    except ImportError as error:
        raise _missing() from error


def _missing() -> ClusterUnavailable:
    hint = "install the extra `cluster`: pip install 'tamplang[cluster]'"
    return ClusterUnavailable("a cluster needs the package `distributed`, which is missing", hint)


def _check_workers(client: Any) -> None:
    start = f"start some with `dask worker {client.scheduler.address} --nworkers N --nthreads 1`"
    try:
        client.wait_for_workers(1, timeout=ANSWER_SECONDS)
    except TimeoutError as error:
        raise ClusterUnavailable("the cluster has no workers", start) from error
    if any(threads > 1 for threads in client.nthreads().values()):
        raise ClusterUnavailable("the workers of the cluster have several threads", start)
    install = f"install tamplang {__version__} where the workers run"
    try:
        versions = set(client.run(installed_version).values())
    except ImportError as error:
        raise ClusterUnavailable("the workers of the cluster do not have tamplang", install) from error
    if versions != {__version__}:
        raise ClusterUnavailable(f"the workers of the cluster have tamplang {', '.join(sorted(versions))}", install)


def installed_version() -> str:
    """The version of tamplang in this process."""
    return __version__
