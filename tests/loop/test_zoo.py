"""The robots of examples/zoo: their tasks compile without a word, and some are solved here, as `bench zoo` does all."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest

from tamplang.compiler.pipeline import check, compile_problem
from tamplang.runtime.planner.lgp import SolveOptions, solve

ROOT = Path(__file__).parents[2]
ZOO = sorted((ROOT / "examples" / "zoo").glob("*.tamp"))


@pytest.fixture(scope="module")
def bench() -> ModuleType:
    sys.path.insert(0, str(ROOT / "benchmarks"))
    spec = importlib.util.spec_from_file_location("zoo", ROOT / "benchmarks" / "zoo.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["zoo"] = module
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("path", ZOO, ids=lambda p: p.stem)
def test_texts_of_the_zoo_are_good(path: Path) -> None:
    assert check(path) == ()


def test_the_benchmark_knows_every_file_and_task_of_the_zoo(bench: ModuleType) -> None:
    assert {r.file for r in bench.ROBOTS if r.file} == {p.stem for p in ZOO}
    for robot in bench.ROBOTS:
        for task in bench.TASKS if robot.file else ():
            compile_problem(ROOT / "examples" / "zoo" / f"{robot.file}.tamp", task + robot.ending, seed=3)


def test_the_text_of_an_arm_compiles_with_a_urdf(bench: ModuleType, tmp_path: Path) -> None:
    urdf = ROOT / "tests" / "programs" / "good" / "parts" / "arm.urdf"
    text = bench.ARM.format(urdf=urdf, base="base_link", tool="tool0", beyond="6 cm", away="50 cm")
    (tmp_path / "arm.tamp").write_text(text)
    for task in bench.TASKS:
        problem, _ = compile_problem(tmp_path / "arm.tamp", task)
        assert "a.tool" in problem.objects


@pytest.mark.parametrize(("name", "task"), [("inchworm", "own"), ("quadruped", "reach"), ("climber", "reach")])
def test_robots_of_the_zoo_do_their_tasks(name: str, task: str) -> None:
    problem, _ = compile_problem(ROOT / "examples" / "zoo" / f"{name}.tamp", task, seed=5)
    outcome = solve(problem, SolveOptions(seed=5, time=100.0))
    assert outcome.status == "solved" and outcome.plans[0].verdict is not None and outcome.plans[0].verdict.verified
