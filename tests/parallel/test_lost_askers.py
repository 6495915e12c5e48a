"""A worker whose asker goes away, at any moment, ends without a word; and it runs nothing of who asks."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tamplang.runtime.parallel import processes

SCRIPT = f"""
print("the script")
import tamplang
task = tamplang.load({str(Path(__file__).parents[2] / "examples" / "rendezvous.tamp")!r}, seed=1)
print(task.solve(jobs=2).status)
"""


@pytest.mark.parametrize("moment", ["at once", "idle", "answering"])
def test_a_worker_ends_quietly_when_nobody_takes_its_answer(moment: str, capfd: pytest.CaptureFixture[str]) -> None:
    process, pipe, alive = processes.started()
    if moment != "at once":
        pipe.send_bytes(pickle.dumps((abs, (-1,), {})))
        assert pipe.poll(30.0)
    if moment == "idle":
        pipe.recv_bytes()
    pipe.close()
    assert process.wait(30.0) == 0
    os.close(alive)
    assert capfd.readouterr().err == ""


def test_a_worker_ends_at_work_when_its_asker_is_gone() -> None:
    process, pipe, alive = processes.started()
    pipe.send_bytes(pickle.dumps((time.sleep, (60.0,), {})))
    os.close(alive)
    assert process.wait(30.0) == 1
    pipe.close()


def test_an_asker_that_is_gone_before_its_worker_began_is_not_told_of() -> None:
    words = [sys.executable, "-P", "-c", processes.LIFE, "0", "1"]
    told = subprocess.run(words, stdin=subprocess.DEVNULL, capture_output=True, check=False)
    assert (told.returncode, told.stderr) == (0, b"")


def test_a_script_without_a_guard_solves_in_several_processes(tmp_path: Path) -> None:
    (tmp_path / "script.py").write_text(SCRIPT)
    told = subprocess.run(
        [sys.executable, "script.py"], cwd=tmp_path, capture_output=True, text=True, check=False,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
    )  # fmt: skip
    assert (told.stdout, told.stderr) == ("the script\nsolved\n", "")
