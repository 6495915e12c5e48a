"""Processes of this machine, one piece of work in each."""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from multiprocessing import connection
from queue import SimpleQueue
from typing import Any, ParamSpec, TypeVar

from ..native import use_one_thread
from .side import Side, WorkerLost, attempt, unpacked

P = ParamSpec("P")
T = TypeVar("T")

ATTEMPTS = 2
"""How often work is started before it is given up as lost."""


class Processes(Side):
    """Computes in `jobs` processes, started when they are needed. A process that dies costs the work it had, which is
    given to a fresh one once; the others go on."""

    def __init__(self, jobs: int) -> None:
        self._jobs = jobs
        self._workers = [_Worker() for _ in range(jobs)]
        self._idle: SimpleQueue[_Worker] = SimpleQueue()
        for worker in self._workers:
            self._idle.put(worker)
        self._threads = ThreadPoolExecutor(jobs, thread_name_prefix="worker", initializer=_block_interrupt)

    @property
    def width(self) -> int:
        return self._jobs

    def submit(self, fn: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        return self._threads.submit(self._ask, pickle.dumps((fn, args, kwargs)))

    def _ask(self, question: bytes) -> Any:
        worker = self._idle.get()
        try:
            for attempts_left in reversed(range(ATTEMPTS)):
                try:
                    return pickle.loads(unpacked(pickle.loads(worker.ask(question))))
                except WorkerLost:
                    if attempts_left == 0:
                        raise
        finally:
            self._idle.put(worker)

    def kill(self) -> None:
        for worker in self._workers:
            worker.kill()

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        self._threads.shutdown(wait=wait, cancel_futures=cancel_futures)
        if wait:
            for worker in self._workers:
                worker.kill()


class _Worker:
    """One process and the pipe to it. `ask` is called by one thread at a time, `kill` by any."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._closed = False
        self._process: subprocess.Popen[bytes] | None = None
        self._pipe: Any = None
        self._alive = -1

    def ask(self, question: bytes) -> bytes:
        """The answer of the process. Raises WorkerLost when it ends without one."""
        process = self._started()
        try:
            self._pipe.send_bytes(question)
            answer: bytes = self._pipe.recv_bytes()
        except (EOFError, OSError) as error:
            raise WorkerLost(_how_it_ended(process.wait())) from error
        return answer

    def _started(self) -> subprocess.Popen[bytes]:
        with self._lock:
            if self._closed:
                raise WorkerLost("the work was dropped")
            if self._process is not None and self._process.poll() is None:
                return self._process
            self._close()
            self._process, self._pipe, self._alive = started()
            return self._process

    def kill(self) -> None:
        """End the process, whatever it does, and never start another one."""
        with self._lock:
            self._closed = True
            if self._process is not None:
                self._process.kill()
                self._process.wait()
            self._close()

    def _close(self) -> None:
        """Let go of the pipes of a process that has ended; what reads from one finds its end."""
        if self._alive >= 0:
            os.close(self._alive)
            self._alive = -1


def started() -> tuple[subprocess.Popen[bytes], connection.Connection, int]:
    """A worker, the pipe to ask it through, and a file descriptor that it lives as long as."""
    pipe, far_end = connection.Pipe()
    watched, alive = os.pipe()
    ends = far_end.fileno(), watched
    try:
        words = [sys.executable, "-P", "-c", LIFE, *map(str, ends)]
        process = subprocess.Popen(words, pass_fds=ends, stdin=subprocess.DEVNULL)
    finally:
        far_end.close()
        os.close(watched)
    with suppress(OSError):  # a process that is gone already is found out when it is asked
        pipe.send(sys.path)
    return process, pipe, alive


LIFE = f"""
import sys
from multiprocessing.connection import Connection
pipe = Connection(int(sys.argv[1]))
try:
    sys.path[:] = pipe.recv()
except (EOFError, OSError):
    sys.exit()
from {__name__} import serve
serve(pipe, int(sys.argv[2]))
"""
"""What a worker runs. It imports nothing of the program that gives the work, which may be a script without a guard, and
says nothing when that one is gone before it began."""


def serve(pipe: connection.Connection, watched: int) -> None:
    """The life of a worker: answer questions until the one who asks is gone, and with it the other end of `watched`."""
    use_one_thread()
    threading.Thread(target=_end_with, args=(watched,), daemon=True).start()
    while True:
        try:
            question = pipe.recv_bytes()
            pipe.send_bytes(pickle.dumps(attempt(_computed, question)))
        except (EOFError, OSError):  # a pipe with an answer that nobody took is reset instead of ended
            return


def _computed(question: bytes) -> bytes:
    function, args, kwargs = pickle.loads(question)
    return pickle.dumps(function(*args, **kwargs))


def _end_with(watched: int) -> None:
    os.read(watched, 1)
    os._exit(1)


def _block_interrupt() -> None:
    """Keep Ctrl-C from this thread and from the processes that it starts: it is for the one who gave the work."""
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})


def _how_it_ended(status: int | None) -> str:
    if status is not None and status < 0:
        return f"its process was ended by {signal.Signals(-status).name}"
    return f"its process ended with status {status}"
