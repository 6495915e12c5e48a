"""Robots that have nothing to do with each other: what is refused of one is refused whatever the others do."""

from pathlib import Path

import pytest

from tamplang.api import load
from tamplang.runtime.budget import Budget
from tamplang.runtime.planner.bounds.multi_bound import MultiBound
from tamplang.runtime.planner.candidate_loop import CandidateLoop
from tamplang.runtime.planner.conflicts.infeasibility import Refusals
from tamplang.runtime.planner.motion.settings import MotionSettings
from tamplang.runtime.seeds import Seed
from tamplang.runtime.skeleton import Bound

HALL = """
import std.crawler
import std.rules
import std.scenes

task hall(crawlers: int = 4) {{
    for k in 1 .. crawlers {{
        base plate[k]: box(0.6 m, 0.6 m, 0.05 m) at (0, 1.5 m * k, 0)
        base step[k]: box(0.3 m, 0.6 m, 0.05 m) at (0.6 m, 1.5 m * k, 0.15 m)
        crawler c[k]: A on plate[k] at (0.1 m, 0)
        object target[k]: sphere(0.04 m) at ({x} m, 1.5 m * k, 0.7 m)
        fact (grippable target[k])
        {around}
    }}
    goal  forall k in 1 .. crawlers {{ (held target[k]) }}
    options {{ bound = seq }}
}}
"""
CAGE = """
        for s in 0 .. 1 {
            object x[2 * k + s]: box(0.02 m, 0.2 m, 0.2 m) at (0.4 m + 0.2 m * s, 1.5 m * k, 0.7 m)
            object y[2 * k + s]: box(0.2 m, 0.02 m, 0.2 m) at (0.5 m, 1.5 m * k - 0.12 m + 0.24 m * s, 0.7 m)
            object z[2 * k + s]: box(0.2 m, 0.2 m, 0.02 m) at (0.5 m, 1.5 m * k, 0.58 m + 0.24 m * s)
        }"""


def hall(folder: Path, x: float, around: str = "", crawlers: int = 4):
    path = folder / "hall.tamp"
    path.write_text(HALL.format(x=x, around=around))
    return load(path, crawlers=crawlers)


def test_robots_that_must_each_come_closer_are_planned_one_by_one(tmp_path: Path) -> None:
    """The orders of their actions are many: without that 3,000 nodes do not do for three."""
    result = hall(tmp_path, 1.1).solve(nodes=600, time=120)
    assert result.status == "solved"
    assert len(result.actions) == 8
    assert {str(record.actions) for record in result.statistics.refusals} == {
        f"['grasp(c[{k}].B, target[{k}])']" for k in range(1, 5)
    }


@pytest.mark.parametrize(("x", "around", "lasting"), [(1.1, "", True), (0.5, CAGE, False)], ids=["far", "caged"])
def test_only_what_is_refused_with_nothing_in_the_way_is_refused_whatever_others_do(
    tmp_path: Path, x: float, around: str, lasting: bool
) -> None:
    problem = hall(tmp_path, x, around, crawlers=2).problem
    bounds = MultiBound(problem, MotionSettings(), Bound.SEQ, Seed(0), Budget(None), lambda stage, message: None)
    loop = CandidateLoop(problem, "astar", Budget(None), bounds, Refusals(problem))
    candidate = loop.next()
    judgement = loop.judge(candidate, loop.skeleton(candidate))
    assert not judgement.accepted
    assert bool(loop.search.no_goods.openings) == lasting
    other = loop.search.next()
    assert (candidate.numbers[1], candidate.numbers[0]) != other.numbers[:2]
    if lasting:
        assert candidate.numbers[0] not in other.numbers[:1] and candidate.numbers[1] not in other.numbers[:1]
