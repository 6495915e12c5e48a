"""The LGP loop: roomy plans, similar refusals, lack of reach, plans handed on as they are found."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from tamplang.api import Plan, load
from tamplang.compiler.ir import Chain, span_of
from tamplang.compiler.pipeline import compile_problem, compile_text
from tamplang.compiler.symbolic.strain import Strain
from tamplang.compiler.symbolic.successors import Successors
from tamplang.runtime.budget import Budget
from tamplang.runtime.planner.bounds.multi_bound import MultiBound
from tamplang.runtime.planner.bounds.settings import BOUNDS
from tamplang.runtime.planner.candidate_loop import CandidateLoop
from tamplang.runtime.planner.conflicts.infeasibility import Refusals, describe
from tamplang.runtime.planner.conflicts.nogoods import GeneralisedNoGoods
from tamplang.runtime.planner.lgp import SolveOptions, solve
from tamplang.runtime.planner.motion.nlp.program import DIVERGED
from tamplang.runtime.planner.motion.settings import MotionSettings
from tamplang.runtime.planner.search.best_first import SkeletonSearch
from tamplang.runtime.planner.search.learned_penalties import LearnedPenalties
from tamplang.runtime.planner.search.settings import SEARCH
from tamplang.runtime.planner.search.skeleton_replay import build_skeleton
from tamplang.runtime.planner.search.slack_maximisation import maximise_slack
from tamplang.runtime.seeds import Seed
from tamplang.runtime.skeleton import Breach, Phase, Violation

EXAMPLES = Path(__file__).parent.parent.parent / "examples"
GAP = """
import std.crawler
import std.rules

task gap(gap: length = 3 m) {
    base ground: box(2 m, 2 m, 0.05 m) at (0, 0, 0)
    base island: box(1 m, 2 m, 0.05 m) at (1.5 m + gap, 0, 0)
    object target: sphere(0.04 m) at (1.5 m + gap, 0, 0.5 m)
    fact (grippable target)
    crawler c: A on ground at (0.5 m, 0)
    goal (held target)
}
"""


def _search(n: int) -> SkeletonSearch:
    problem, _ = compile_problem(EXAMPLES / "climb.tamp", None, {"n": str(n), "crawlers": "2"}, 0)
    return SkeletonSearch(problem, Successors(problem), "astar", Budget(30.0))


def _loop() -> CandidateLoop:
    problem, _ = compile_problem(EXAMPLES / "climb.tamp", None, {"n": "2"}, 0)
    bounds = MultiBound(problem, MotionSettings(), "path", Seed(0), Budget(None), lambda stage, message: None)
    return CandidateLoop(problem, "astar", Budget(None), bounds, Refusals(problem))


def test_a_roomier_plan_costs_the_same_and_strains_less() -> None:
    search = _search(16)
    candidate = search.next()
    assert candidate is not None
    strain = Strain(search.successors)
    better = maximise_slack(search, strain, candidate)
    assert better.cost == candidate.cost
    assert [a.rule for a in better.actions] == [a.rule for a in candidate.actions]

    def total(numbers: tuple[int, ...]) -> float:
        return sum(s**SEARCH.penalty_power for s in strain.along(numbers))

    assert total(better.numbers) <= total(candidate.numbers)
    assert all(0.0 <= s <= 1.0 + 1e-6 for s in strain.along(better.numbers))


def test_refused_sequences_make_strained_actions_dearer() -> None:
    search = _search(16)
    candidate = search.next()
    assert candidate is not None
    strain = Strain(search.successors)
    surcharge = LearnedPenalties(strain)
    last = len(candidate.numbers) - 1
    surcharge.refused(candidate.numbers, last, last)
    assert surcharge.weight == 0.0, "one action alone is forbidden, not dearer"
    for _ in range(5):
        surcharge.refused(candidate.numbers, 0, last)
    search.charge(surcharge)
    following = search.next()
    assert following is not None and following.cost >= candidate.cost
    assert max(strain.along(following.numbers)) < max(strain.along(candidate.numbers))


def test_what_was_refused_is_expected_to_be_refused_again_unless_there_is_more_room() -> None:
    search = _search(8)
    candidate = search.next()
    assert candidate is not None
    skeleton = build_skeleton(search.problem, candidate.actions, search.successors)
    strains = Strain(search.successors).along(candidate.numbers)
    experience = GeneralisedNoGoods(search.problem)
    experience.refuse(skeleton.phases[:2], strains[:2], True)
    assert experience.expected_refusals(skeleton.phases, strains) == [(0, 1, True)]
    assert experience.expected_refusals(skeleton.phases, [s - 0.1 for s in strains]) == []
    experience.forget()
    assert experience.expected_refusals(skeleton.phases, strains) == []


def test_a_quick_refusal_from_the_start_gets_a_second_try_but_a_plan_that_was_found_does_not_come_again() -> None:
    search = _search(8)
    refused = search.next()
    assert refused is not None
    search.forbid_actions(refused, 0, 1, from_start=True)
    other = search.next()
    assert other is not None and other.numbers[:2] != refused.numbers[:2]
    search.forbid_plan(other)
    assert search.readmit(), "there is a refusal to take back"
    assert not search.readmit()
    seen = []
    while refused.numbers not in seen:
        again = search.next()
        assert again is not None
        seen.append(again.numbers)
        search.forbid_plan(again)
    assert other.numbers not in seen and len(set(seen)) == len(seen)


def test_candidates_without_a_motion_come_again_a_few_times_and_get_other_draws() -> None:
    loop = _loop()
    first = loop.search.next()
    assert first is not None
    seeds = [loop.bounds.seed]
    for _ in range(BOUNDS.readmissions):
        loop.paths_refused = True
        loop.search.forbid_actions(first, 0, 0, from_start=True, survives=1)
        loop.search.status = "exhausted"
        assert loop.readmit()
        seeds.append(loop.bounds.seed)
    assert not loop.readmit()
    assert len(set(seeds)) == BOUNDS.readmissions + 1
    again = loop.search.next()
    assert again is not None and [a.rule for a in again.actions] == [a.rule for a in first.actions]


def test_candidates_without_switches_come_again_once() -> None:
    loop = _loop()
    first = loop.search.next()
    assert first is not None
    for expected in (True, False):
        loop.search.forbid_actions(first, 0, 0, from_start=True)
        loop.search.status = "exhausted"
        assert loop.readmit() is expected


def _mirrored(item: Any) -> Any:
    """The same with the two modules swapped."""
    if isinstance(item, tuple):
        return tuple(map(_mirrored, item))
    if isinstance(item, Chain):
        return Chain(_mirrored(item.modules))
    return item.translate({ord("1"): "2", ord("2"): "1"}) if item.startswith("c[") else item


def test_what_opens_a_plan_is_expected_to_be_refused_only_for_the_modules_that_it_names() -> None:
    search = _search(8)
    candidate = search.next()
    assert candidate is not None
    skeleton = build_skeleton(search.problem, candidate.actions, search.successors)
    first = skeleton.phases[0]
    facts = (frozenset(map(_mirrored, facts)) for facts in (first.mode, first.added))
    mirrored = Phase(replace(first.action, args=_mirrored(first.action.args)), *facts)
    assert mirrored != first
    for from_start, expected in ((True, []), (False, [(0, 0, False)])):
        experience = GeneralisedNoGoods(search.problem)
        experience.refuse([first], [0.5], from_start)
        assert experience.expected_refusals([first], [0.5]) == [(0, 0, from_start)]
        assert experience.expected_refusals([mirrored], [0.5]) == expected


def test_lack_of_reach_is_told_in_metres() -> None:
    problem, _ = compile_text(GAP)
    outcome = solve(problem, SolveOptions(time=20.0))
    assert outcome.status == "infeasible"
    told = outcome.explanation[0]
    assert told.code == "S0001" and told.note is not None
    assert "target is 3.49 m from ground" in told.note and "m too little" in told.note
    assert "`grasp`" in told.message and told.span == span_of(problem.goal)
    assert [label.span.file for label in told.labels] == ["std/rules.tamp", "std/logic.tamp"]


def test_plans_are_handed_on_as_they_are_found_and_differ() -> None:
    """One robot can walk about for ever: of all ways to one stair three are none of the others with a detour."""
    found: list[Plan] = []
    task = load(EXAMPLES / "climb.tamp", n=1, crawlers=1)
    result = task.solve(solutions=4, time=60, minimise="makespan", found=found.append)
    assert result.status == "solved" and len(result.plans) == 3
    first, *others = found
    assert len(others) == 3 and first.actions == others[0].actions  # the first one before it is shortened, too
    assert [d.code for d in result.explanation] == ["S0002"]
    assert {len(plan.actions) for plan in result.plans} == {2, 3}
    assert len({(plan.actions[0], plan.actions[-1]) for plan in result.plans}) == 3
    values = [plan.record.statistics.objective.value for plan in result.plans]
    assert values == sorted(values)
    for plan in result.plans:
        cost, before = plan.record.statistics.path_cost, plan.record.statistics.path_cost_before
        assert cost is not None and before is not None and 0.0 < cost <= before


def test_numbers_that_diverge_are_told_as_such() -> None:
    row = ("touch", "c.A", "ball")
    assert describe(Violation(0, Breach.ROW, row, DIVERGED, "m")) == "the numbers of [touch c.A ball] diverge"
    assert describe(Violation(0, Breach.ROW, row, 0.2134, "m")) == "[touch c.A ball] is missed by 0.213 m"
