"""Long calls of compiled libraries, in a process of their own: nothing else can end one before it is done.

The process is a copy of this one (fork), so that a call is worth it from some hundredths of a second on. It is killed
when this one is interrupted, by Ctrl-C or by the end of its time, and ends with it.
"""

from __future__ import annotations

import ctypes
import os
import pickle
import signal
from collections.abc import Callable
from typing import TypeVar

Result = TypeVar("Result")
PR_SET_PDEATHSIG = 1


def apart(work: Callable[[], Result]) -> Result:
    """What `work` gives, or raises, computed by a copy of this process; what it changes is lost. Raises MemoryError
    when the copy is killed from outside."""
    reader, writer = os.pipe()
    parent = os.getpid()
    child = os.fork()
    if child == 0:
        _answer(work, parent, reader, writer)
    try:
        os.close(writer)
        with open(reader, "rb") as stream:
            answer = stream.read()
    finally:
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
    if not answer:
        raise MemoryError("the process that reads a file was killed")
    result, error = pickle.loads(answer)
    if error is not None:
        raise error
    found: Result = result
    return found


def _answer(work: Callable[[], object], parent: int, reader: int, writer: int) -> None:
    """The life of the copy."""
    try:
        os.close(reader)
        for number in (signal.SIGINT, signal.SIGALRM):
            signal.signal(number, signal.SIG_DFL)
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() == parent:
            try:
                answer = pickle.dumps((work(), None))
            except Exception as error:
                answer = pickle.dumps((None, error))
            with open(writer, "wb") as stream:
                stream.write(answer)
    finally:
        os._exit(0)
