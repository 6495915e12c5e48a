"""The same file, seed and options give the same plan, whatever the machine does besides; and the tree of seeds."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tamplang.runtime.seeds import Seed

EXAMPLES = Path(__file__).parent.parent.parent / "examples"


def test_a_seed_is_a_value_and_its_children_are_others() -> None:
    def numbers(seed: Seed) -> list[int]:
        return [int(n) for n in seed.random().integers(0, 2**32, 4)]

    seed = Seed(5)
    assert seed.child("a", 1) == seed.child("a").child(1) and hash(seed.child("a")) == hash(Seed(5).child("a"))
    assert numbers(seed.child("a", 1)) == numbers(Seed(5).child("a", 1))
    others = [Seed(6), seed, *(seed.child(*w) for w in (("a",), ("b",), ("a", 0), ("a", 1), (0,), (0, 0), (1,)))]
    assert len({tuple(numbers(s)) for s in others}) == len(others)
    assert numbers(Seed(0)) != numbers(Seed(0).child(0)) != numbers(Seed(0).child(0, 0))


BUSY = "while True: pass"


def content(path: Path) -> bytes:
    plan = json.loads(path.read_bytes())
    plan.pop("timing", None)
    return json.dumps(plan).encode()


@pytest.mark.parametrize("parameters", [("climb", "n=4"), ("pick_and_place",)])
def test_the_plan_is_the_same_on_a_loaded_machine_by_other_hashes_threads_and_jobs(
    parameters: tuple[str, ...], tmp_path: Path
) -> None:
    file, *given = parameters
    found = []
    for name, loaded, threads, jobs in (("idle", 0, "1", "1"), ("loaded", 2, "2", "2")):
        busy = [subprocess.Popen([sys.executable, "-c", BUSY]) for _ in range(loaded)]
        out = tmp_path / f"{name}.json"
        command = [sys.executable, "-m", "tamplang", "solve", str(EXAMPLES / f"{file}.tamp"), "--out", str(out)]
        command += ["--seed", "1", "--time", "600", "--jobs", jobs, *(f"-p{p}" for p in given)]
        environment = {**os.environ, "PYTHONHASHSEED": threads, "OMP_NUM_THREADS": threads,
                       "OPENBLAS_NUM_THREADS": threads}  # fmt: skip
        try:
            subprocess.run(command, env=environment, check=True, capture_output=True)
        finally:
            for process in busy:
                process.kill()
                process.wait()
        found.append(content(out))
    assert found[0] == found[1]


def test_loads_are_summed_in_the_same_order_by_other_hashes(tmp_path: Path) -> None:
    plan = str(tmp_path / "plan.json")
    tamplang = [sys.executable, "-m", "tamplang"]
    solve = [*tamplang, "solve", str(EXAMPLES / "real_bridge.tamp"), "--out", plan]
    subprocess.run(solve, check=True, capture_output=True)
    worst = []
    for seed in ("1", "2", "3"):
        environment = {**os.environ, "PYTHONHASHSEED": seed}
        done = subprocess.run([*tamplang, "verify", plan, "--json"], env=environment, check=True, capture_output=True)
        worst.append(json.loads(done.stdout)["worst"])
    assert "torque_ratio" in worst[0] and worst[0] == worst[1] == worst[2]
