"""One solve in several processes: the same plan, whatever happens to them."""

from __future__ import annotations

import json
import os
import signal
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tamplang.api import load
from tamplang.compiler.symbolic.successors import Successors
from tamplang.runtime.budget import Budget, OutOfTime
from tamplang.runtime.parallel import Side
from tamplang.runtime.parallel.processes import Processes
from tamplang.runtime.planner.bounds.requests import AttemptRequest, SequenceRequest, WindowRequest
from tamplang.runtime.planner.bounds.speculation import Speculation, opened
from tamplang.runtime.planner.motion.settings import MotionSettings
from tamplang.runtime.planner.search.best_first import SkeletonSearch
from tamplang.runtime.planner.search.skeleton_replay import build_skeleton
from tamplang.runtime.seeds import Seed
from tamplang.runtime.skeleton import Skeleton, start_configuration

from .conftest import ROOT, begin, is_solving, session, wait_until
from .test_cluster import local_cluster

BRIDGE = ROOT / "examples" / "strut_bridge.tamp"
"""A third of what P_seq is asked is refused."""


def solving(folder: Path, *options: object) -> Any:
    return begin(folder, "solve", BRIDGE, "--json", "--time", "inf", "--out", "plan.json", *options)


def told(folder: Path, out: str) -> dict[str, Any]:
    """All that a run says and writes but for times."""
    answer, plan = json.loads(out), json.loads((folder / "plan.json").read_text())
    del answer["seconds"], plan["timing"]
    return {"answer": answer, "plan": plan}


@pytest.fixture(scope="module")
def alone(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    folder = tmp_path_factory.mktemp("alone")
    with solving(folder) as process:
        out, err = process.communicate(timeout=120)
    assert process.returncode == 0, err
    return told(folder, out)


@pytest.fixture(scope="module")
def skeleton() -> Skeleton:
    """The first candidate of a climb."""
    problem = load(ROOT / "examples" / "climb.tamp", n=2, crawlers=1).problem
    successors = Successors(problem)
    candidate = SkeletonSearch(problem, successors, "astar", Budget(None), None).next()
    assert candidate is not None
    return build_skeleton(problem, candidate.actions, successors)


class Counted(Speculation):
    """Counts the answers that came from elsewhere."""

    def __init__(self, side: Side) -> None:
        super().__init__(side)
        self.elsewhere = 0

    def answer(self, skeleton: Any, question: Any, budget: Budget) -> Any:
        self.elsewhere += self.expects(skeleton, question)
        return super().answer(skeleton, question, budget)


def ready(ahead: Speculation, skeleton: Skeleton) -> None:
    ahead.prepare(skeleton.problem)
    wait_until(lambda: ahead.expect(skeleton, SequenceRequest(MotionSettings(), Seed(0), 3), Budget(None)))


def test_answers_from_elsewhere_are_those_from_here(skeleton: Skeleton) -> None:
    settings, budget = MotionSettings(), Budget(None)
    whole, window = SequenceRequest(settings, Seed(0), 3), WindowRequest(settings, Seed(0), 0, 0)
    here = whole.solved(skeleton, budget)
    attempt = AttemptRequest(settings, Seed(1), 3, here.configurations[1:], len(skeleton), True)
    with Processes(1) as side:
        ahead = Counted(side)
        ready(ahead, skeleton)
        for question in (window, attempt):
            assert ahead.expect(skeleton, question, budget)
        found = [ahead.answer(skeleton, q, budget) for q in (whole, window, attempt)]
        side.kill()
    assert ahead.elsewhere >= 1
    assert [c.modules["c[1]"].tolist() for c in found[0].configurations] == [
        c.modules["c[1]"].tolist() for c in here.configurations
    ]
    assert found[1].cost == window.solved(skeleton, budget).cost
    sequence, path = attempt.solved(skeleton, budget)
    assert found[2][0].cost == sequence.cost and found[2][1].cost == path.cost


def test_questions_about_other_starts_are_other_questions(skeleton: Skeleton) -> None:
    start = start_configuration(skeleton.problem)
    moved = start.copy()
    moved.modules["c[1]"][8] += 1e-12
    keys = {AttemptRequest(MotionSettings(), Seed(1), 3, [c], 1, True).key for c in (start, moved, start.copy())}
    assert len(keys) == 2


def test_work_whose_process_dies_is_done_here(skeleton: Skeleton) -> None:
    with Processes(1) as side:
        ahead = Speculation(side)
        ready(ahead, skeleton)
        side.kill()
        result = ahead.answer(skeleton, SequenceRequest(MotionSettings(), Seed(0), 3), Budget(None))
    assert result.feasible


def test_waiting_ends_with_the_budget(skeleton: Skeleton) -> None:
    with Processes(1) as side:
        ahead = Speculation(side)
        ready(ahead, skeleton)
        with pytest.raises(OutOfTime):
            ahead.answer(skeleton, SequenceRequest(MotionSettings(), Seed(0), 3), Budget(1e-9))
        side.kill()


def test_without_other_processes_nothing_is_expected(skeleton: Skeleton) -> None:
    with opened() as ahead:
        assert not ahead.helps
        assert not ahead.expect(skeleton, SequenceRequest(MotionSettings(), Seed(0), 3), Budget(None))


# --- the command -------------------------------------------------------------------------------------------------


def workers_of(process: Any) -> list[int]:
    """Processes of its session that have come as far as the motion programs, but for itself."""
    return [pid for pid in session(process.pid) if pid != process.pid and is_solving(pid)]


def test_the_plan_is_the_same_in_three_processes_though_one_is_killed(alone: dict[str, Any], tmp_path: Path) -> None:
    with solving(tmp_path, "--jobs", "3") as process:
        wait_until(lambda: process.poll() is not None or workers_of(process))
        for worker in workers_of(process)[:1]:
            os.kill(worker, signal.SIGKILL)
        out, err = process.communicate(timeout=120)
    assert process.returncode == 0, err
    assert told(tmp_path, out) == alone
    wait_until(lambda: not session(process.pid), 5.0)  # what counts shared memory ends a moment later


@pytest.mark.parametrize(("end", "status"), [("interrupt", 130), ("budget", 4)])
def test_ctrl_c_and_the_budget_end_all_processes(tmp_path: Path, end: str, status: int) -> None:
    options = ("--jobs", "3", "--time", "1000" if end == "interrupt" else "0.8")
    with begin(tmp_path, "solve", ROOT / "examples" / "rendezvous.tamp", "-p", "n=24", *options) as process:
        if end == "interrupt":
            wait_until(lambda: process.poll() is not None or workers_of(process))
            os.killpg(process.pid, signal.SIGINT)
        began = time.monotonic()
        _, err = process.communicate(timeout=60)
    assert process.returncode == status, err
    assert "Traceback" not in err
    assert end == "budget" or time.monotonic() - began < 10
    wait_until(lambda: not session(process.pid), 5.0)  # what counts shared memory ends a moment later


# --- a cluster ---------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    with local_cluster(n_workers=2, threads_per_worker=1, processes=True) as cluster:
        yield cluster


def test_a_cluster_gives_the_same_plan_though_a_worker_dies(
    cluster: Any, alone: dict[str, Any], tmp_path: Path
) -> None:
    with solving(tmp_path, "--cluster", cluster.scheduler_address) as process:
        workers = [nanny.process.process.pid for nanny in cluster.workers.values()]
        wait_until(lambda: process.poll() is not None or any(is_solving(worker) for worker in workers))
        assert process.poll() is None
        victim = next(nanny for nanny in cluster.workers.values() if is_solving(nanny.process.process.pid))
        victim.process.process.kill()
        out, err = process.communicate(timeout=120)
    assert process.returncode == 0, err
    assert told(tmp_path, out) == alone


def test_an_address_that_does_not_answer_is_told_at_once(tmp_path: Path) -> None:
    began = time.monotonic()
    with begin(tmp_path, "solve", BRIDGE, "--cluster", "tcp://127.0.0.1:9") as process:
        _, err = process.communicate(timeout=60)
    assert process.returncode == 1
    assert "S0006" in err and "dask scheduler" in err
    assert time.monotonic() - began < 15


def test_a_cluster_that_goes_away_leaves_the_work_to_this_process(alone: dict[str, Any], tmp_path: Path) -> None:
    fleeting = local_cluster(n_workers=1, threads_per_worker=1, processes=True)
    with fleeting, solving(tmp_path, "--cluster", fleeting.scheduler_address) as process:
        worker = next(iter(fleeting.workers.values())).process.process.pid
        wait_until(lambda: process.poll() is not None or is_solving(worker))
        fleeting.close()
        out, err = process.communicate(timeout=120)
    assert process.returncode == 0, err
    assert told(tmp_path, out) == alone
