"""The executors: results, errors, lost processes, and what they leave behind."""

from __future__ import annotations

import math
import operator
import os
import signal
import time
from concurrent.futures import Future
from pathlib import Path
from typing import Any

import pytest

from tamplang.cli.instances import Instance, instances, read_program, read_values, solve_instance
from tamplang.runtime.parallel import WorkerLost, WorkFailed, as_finished, open_executor

from .conftest import CLIMB, is_solving, timeless, wait_until, workers


@pytest.mark.parametrize("jobs", [1, 2])
def test_results_and_errors_belong_to_their_items(jobs: int) -> None:
    with open_executor(jobs) as executor:
        found = dict(as_finished(executor, math.factorial, [3, -1, 5]))
        assert (found[3].result(), found[5].result()) == (6, 120)
        error = found[-1].exception()
        assert isinstance(error, WorkFailed)
        assert (error.kind, "factorial" in error.message) == ("ValueError", True)
        assert "Traceback" in error.trace
        assert executor.submit(operator.sub, 5, 3).result() == 2
    assert not workers()


@pytest.mark.parametrize("jobs", [1, 2])
def test_what_cannot_be_handed_over_is_an_error_of_its_own(jobs: int) -> None:
    with open_executor(jobs) as executor:
        if jobs > 1:
            assert isinstance(executor.submit(memoryview, b"a").exception(), WorkFailed)
        assert executor.submit(abs, -1).result() == 1


def test_workers_are_other_processes_with_one_thread() -> None:
    with open_executor(2) as executor:
        assert executor.submit(os.getpid).result() != os.getpid()
        assert executor.submit(os.getenv, "OPENBLAS_NUM_THREADS").result() == "1"


def test_no_more_is_under_way_than_there_are_processes() -> None:
    taken: list[int] = []

    def items() -> Any:
        for number in range(6):
            taken.append(number)
            yield number

    with open_executor(2) as executor:
        for finished, _ in enumerate(as_finished(executor, abs, items()), start=1):
            assert len(taken) <= finished + 2


def test_work_that_kills_its_process_is_lost_and_harms_no_other() -> None:
    with open_executor(2) as executor:
        deadly = executor.submit(os._exit, 3)
        others = [executor.submit(abs, -number) for number in range(8)]
        assert [other.result() for other in others] == list(range(8))
        assert isinstance(deadly.exception(), WorkerLost)
        assert "status 3" in str(deadly.exception())
        assert executor.submit(abs, -9).result() == 9


def test_leaving_by_an_error_drops_all_work_at_once() -> None:
    started = time.monotonic()
    futures: list[Future[None]] = []
    with pytest.raises(KeyboardInterrupt), open_executor(2) as executor:
        futures += [executor.submit(time.sleep, 600) for _ in range(4)]
        wait_until(lambda: len(workers()) == 2)
        raise KeyboardInterrupt
    assert time.monotonic() - started < 60
    assert all(future.cancelled() or isinstance(future.exception(), WorkerLost) for future in futures)
    assert not workers()


def climbs() -> list[Instance]:
    program = read_program(CLIMB, None)
    values = read_values(program, {"n": ["1", "2"], "crawlers": ["1"]})
    options = dict.fromkeys(("bound", "search", "time", "nodes", "solver"))
    return instances(program, values, [0], options, with_plan=False)


def test_a_worker_killed_in_mid_solve_costs_only_its_work() -> None:
    expected = timeless([solve_instance(instance)[0] for instance in climbs()])
    with open_executor(2) as executor:
        futures = [executor.submit(solve_instance, instance) for instance in climbs()]
        wait_until(lambda: any(map(is_solving, workers())))
        victim = next(filter(is_solving, workers()))
        os.kill(victim, signal.SIGKILL)
        answers = [future.result()[0] for future in futures]
        wait_until(lambda: not Path(f"/proc/{victim}").exists())
    assert timeless(answers) == expected
