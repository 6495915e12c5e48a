"""A worker whose asker goes away, at any moment, ends without a word."""

from __future__ import annotations

import pickle
from multiprocessing import get_context

import pytest

from tamplang.runtime.parallel.processes import _serve


@pytest.mark.parametrize("asked", [False, True])
def test_a_worker_ends_quietly_when_nobody_takes_its_answer(asked: bool) -> None:
    context = get_context("spawn")
    near, far = context.Pipe()
    process = context.Process(target=_serve, args=(far,), daemon=True)
    process.start()
    far.close()
    if asked:
        near.send_bytes(pickle.dumps((abs, (-1,), {})))
        assert near.poll(30.0)
    near.close()
    process.join(30.0)
    assert process.exitcode == 0
