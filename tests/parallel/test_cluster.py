"""A cluster of two worker processes on this machine."""

from __future__ import annotations

import socket
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tamplang.runtime.parallel import ClusterUnavailable, WorkFailed, open_executor

from .conftest import SMALL, is_solving, lines, start, sweep, sweep_here, timeless, wait_until


def local_cluster(**settings: Any) -> Any:
    """A `distributed.LocalCluster` that listens to this machine only."""
    try:
        from distributed import LocalCluster
    except ImportError:
        pytest.fail("these tests need the package `distributed`: pip install -e '.[dev]'")
    return LocalCluster(host="127.0.0.1", dashboard_address="127.0.0.1:0", **settings)


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    with local_cluster(n_workers=2, threads_per_worker=1, processes=True) as cluster:
        yield cluster


def test_a_worker_lost_in_mid_solve_costs_only_its_work(cluster: Any, tmp_path: Path) -> None:
    with start(tmp_path, *SMALL, "--cluster", cluster.scheduler_address) as process:
        workers = [nanny.process.process.pid for nanny in cluster.workers.values()]
        wait_until(lambda: process.poll() is not None or any(is_solving(worker) for worker in workers))
        assert process.poll() is None
        victim = next(nanny for nanny in cluster.workers.values() if is_solving(nanny.process.process.pid))
        victim.process.process.kill()
        _, err = process.communicate(timeout=180)
    assert process.returncode == 0, err
    assert "Traceback" not in err
    sweep(tmp_path, *SMALL, "--out", "here.jsonl")
    assert timeless(lines(tmp_path / "climb.sweep.jsonl")) == timeless(lines(tmp_path / "here.jsonl"))


def test_errors_of_the_work_come_back(cluster: Any) -> None:
    with open_executor(cluster=cluster.scheduler_address) as executor:
        assert executor.submit(divmod, 7, 2).result() == (3, 1)
        error = executor.submit(divmod, 7, 0).exception()
        assert isinstance(error, WorkFailed)
        assert error.kind == "ZeroDivisionError"


def test_a_cluster_without_workers_is_refused() -> None:
    with local_cluster(n_workers=0) as empty, pytest.raises(ClusterUnavailable, match="no workers"):
        open_executor(cluster=empty.scheduler_address)


def test_workers_of_several_threads_are_refused() -> None:
    several = local_cluster(n_workers=1, threads_per_worker=2, processes=True)
    with several, pytest.raises(ClusterUnavailable, match="several threads"):
        open_executor(cluster=several.scheduler_address)


def test_an_address_that_does_not_answer_is_told_within_ten_seconds(tmp_path: Path) -> None:
    started = time.monotonic()
    with pytest.raises(ClusterUnavailable, match="no cluster answers"):
        open_executor(cluster="tcp://127.0.0.1:9")
    assert time.monotonic() - started < 10
    _, err = sweep_here(tmp_path, *SMALL, "--cluster", "tcp://127.0.0.1:9", status=1)
    assert "S0006" in err
    assert "dask scheduler" in err


def test_the_missing_package_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with socket.create_server(("127.0.0.1", 0)) as server, pytest.raises(ClusterUnavailable) as caught:
        open_executor(cluster=f"tcp://127.0.0.1:{server.getsockname()[1]}")
    assert "pip install 'tamplang[cluster]'" in caught.value.hint


def test_a_cluster_that_goes_away_ends_the_sweep_with_what_is_finished(cluster: Any, tmp_path: Path) -> None:
    path = tmp_path / "climb.sweep.jsonl"
    address = cluster.scheduler_address
    with start(tmp_path, *SMALL, "--seeds", "0..99", "--cluster", address) as process:
        wait_until(lambda: process.poll() is not None or (path.exists() and path.read_text().count("\n")))
        cluster.close()
        _, err = process.communicate(timeout=60)
    assert process.returncode == 1, err
    assert "S0006" in err
    assert f"the cluster at {address} is gone" in err
    assert {record["status"] for record in lines(path)} == {"solved"}
