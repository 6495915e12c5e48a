"""What a run says of its plans and of its refusals: the gap, what is blamed, what is expected, what is told first."""

from __future__ import annotations

import pytest

from tamplang.compiler.ir import Action, Problem
from tamplang.compiler.pipeline import compile_text
from tamplang.runtime.planner.bounds.verdicts import Conflict, blame
from tamplang.runtime.planner.conflicts.infeasibility import Refusals
from tamplang.runtime.planner.conflicts.nogoods import GeneralisedNoGoods
from tamplang.runtime.planner.lgp import SolveOptions, solve
from tamplang.runtime.planner.search.skeleton_replay import build_skeleton
from tamplang.runtime.skeleton import BoundResult, Breach, Skeleton, Violation

TWO_WAYS = """
import std.crawler
motion [beside X: effector, Y: object] { at switch gap(X, Y) <= 1 m }
motion [inside_of X: effector, Y: object] { at switch gap(X, Y) <= -1 m }
predicate (done)
rule short(A: effector, X: object) { pre not (done)   post (done), [inside_of A X]   cost 1 }
rule long(A: effector, X: object)  { pre not (done)   post (done), [beside A X]   cost LONG }
task two() {
    base pad: box(0.3 m, 0.3 m, 0.05 m) at (0, 0, 0)
    object ball: sphere(0.04 m) at (0.5 m, 0, 0.5 m)
    crawler c: A on pad
    goal (done)
}
"""


def two_ways(long: float) -> Problem:
    return compile_text(TWO_WAYS.replace("LONG", str(long)), "two.tamp")[0]


@pytest.mark.parametrize(("long", "gap"), [(3.5, 2.5), (1, 0.0), (0.5, 0.0)])
def test_the_gap_is_the_cost_above_the_cheapest_actions(long: float, gap: float) -> None:
    """The cheap way asks for a depth that no motion reaches; what the dear one costs more is the gap."""
    statistics = solve(two_ways(long), SolveOptions(bound="seq", time=None)).statistics
    assert statistics.cost == long
    assert statistics.gap == gap and statistics.optimal == (gap == 0.0)


def skeleton(*rules: str) -> Skeleton:
    problem = two_ways(1)
    return build_skeleton(problem, [Action(rule, ("c.B", "ball")) for rule in rules])


def conflict(amount: float, kind: Breach = Breach.COLLISION, first: int = 0, last: int = 0) -> Conflict:
    return Conflict("seq", first, last, False, (Violation(last, kind, ("c", "ball"), amount, "m"),))


def told(*found: tuple[str, Conflict]) -> list[str]:
    refusals = Refusals(two_ways(1))
    for rule, one in found:
        refusals.add(skeleton(rule), one)
    return [d.message for d in refusals.explain("exhausted")]


def test_what_was_met_most_often_is_told_first_and_of_it_the_smallest_miss() -> None:
    often = [("long", conflict(0.3)), ("long", conflict(0.1)), ("long", conflict(0.2))]
    messages = told(("short", conflict(0.01)), *often)
    assert "long" in messages[0] and "0.1 m" in messages[0] and "short" in messages[1]
    assert "0.3" not in messages[0] and len(messages) == 2


def test_different_causes_of_one_rule_are_told_apart() -> None:
    assert len(told(("long", conflict(0.1)), ("long", conflict(0.1, Breach.JOINT_LIMIT)))) == 2


def refused(*phases: int) -> BoundResult:
    violations = [Violation(k, Breach.COLLISION, ("a", "b"), 1.0 / (n + 1), "m") for n, k in enumerate(phases)]
    return BoundResult("seq-path", False, 0.0, 0.0, 0, [], [], violations)


def test_only_a_phase_that_failed_between_all_of_three_pairs_of_poses_is_blamed_anywhere() -> None:
    here = blame("seq-path", refused(2, 1), [{2, 1}, {2}, {2, 3}], 5)
    assert (here.first, here.last, here.from_start) == (2, 2, False)
    assert [v.phase for v in here.violations] == [2]
    for blamed in ([{2}, {2}], [{2}], [{2}, {1}, {2}]):
        start = blame("seq-path", refused(2, 1), blamed, 5)
        assert (start.first, start.last, start.from_start) == (0, 2, True)
        assert [v.phase for v in start.violations] == [2, 1]
    first = blame("seq-path", refused(0), [{0}, {0}, {0}], 5)
    assert (first.first, first.last, first.from_start) == (0, 0, True)
    assert blame("path", refused(), [set()], 5).last == 4


def test_a_window_is_expected_to_be_refused_at_the_strain_of_a_refused_one_and_above() -> None:
    phases = skeleton("short").phases
    experience = GeneralisedNoGoods(two_ways(1))
    experience.refuse(phases, [0.8], False)
    assert experience.expected_refusals(phases, [0.8]) == [(0, 0, False)]
    assert experience.expected_refusals(phases, [0.9]) == [(0, 0, False)]
    assert experience.expected_refusals(phases, [0.7]) == []
    assert experience.expected_refusals(skeleton("long").phases, [0.9]) == []
    experience.forget()
    assert experience.expected_refusals(phases, [0.9]) == []


def test_refusals_from_the_start_are_dropped_when_the_run_goes_on() -> None:
    phases = skeleton("short").phases
    experience = GeneralisedNoGoods(two_ways(1))
    experience.refuse(phases, [0.8], True)
    assert experience.expected_refusals(phases, [0.8]) == [(0, 0, True)]
    experience.leave_start()
    assert experience.expected_refusals(phases, [0.8]) == []


def test_an_action_is_expected_to_succeed_up_to_the_strain_of_the_most_strained_that_did() -> None:
    phase = skeleton("short").phases[0]
    experience = GeneralisedNoGoods(two_ways(1))
    assert not experience.expects_success(phase, 0.0)
    experience.accept(phase, 0.6)
    experience.accept(phase, 0.4)
    assert experience.expects_success(phase, 0.6) and not experience.expects_success(phase, 0.7)
