"""Robots that work at once: what the planner makes of it, and what the verifier refuses."""

from __future__ import annotations

import json
from pathlib import Path
from random import Random

import msgspec
import numpy as np
import pytest
from msgspec.structs import replace

from benchmarks.trust.checker import judge, read
from benchmarks.trust.draft import Draft
from benchmarks.trust.tampers_motion import crowded
from tamplang.api import Plan, Result, load, loads
from tamplang.runtime.plan import Plan as PlanRecord
from tamplang.runtime.plan_files import PlanFileError, read_plan
from tamplang.runtime.verify import verify

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


PRESS = """
import std.crawler
import std.rules
motion [press A: gripper, X: object] { at switch gap(A, X) <= 20 mm at switch gap(A, X) >= 8 mm }
predicate (pressed X: object)
rule press(A: gripper, X: object) {
    pre (free A), (reachable A X), not (pressed X)
    post (pressed X), [press A X]
}
task two() {
    object table: cylinder(0.3 m, 0.04 m) at (0, 0, 0.02 m)
    for k in 1 .. 2 {
        base stand[k]: box(0.3 m, 0.3 m, 0.05 m) at (0.65 m * cos(180 deg * k), 0, 0)
        crawler c[k]: A on stand[k]
    }
    for i in 1 .. 2 {
        object thing[i]: box(5 cm, 5 cm, 5 cm) on table at (-0.06 m, -0.36 m + 0.24 m * i)
    }
    goal forall i in 1 .. 2 { (pressed thing[i]) }
}
"""


@pytest.fixture(scope="module")
def chosen() -> tuple[Result, list[Plan]]:
    """Two arms that touch two things, and all plans on the way."""
    met: list[Plan] = []
    return loads(PRESS).solve(time=300, minimise="makespan", gap=0.5, found=met.append), met


@pytest.fixture(scope="module")
def pressed(chosen: tuple[Result, list[Plan]]) -> PlanRecord:
    assert chosen[0].plan is not None
    return chosen[0].plan.record


@pytest.fixture(scope="module")
def mounted() -> PlanRecord:
    """Four crawlers mount a plate, all at once."""
    result = load(EXAMPLES / "quadruped.tamp").solve(time=300, minimise="makespan")
    assert result.plan is not None
    return result.plan.record


def test_what_nothing_keeps_apart_is_done_at_once(mounted: PlanRecord) -> None:
    objective = mounted.statistics.objective
    assert objective.value == pytest.approx(mounted.times[-1])
    assert objective.value == pytest.approx(objective.bounds["these actions"])
    assert any(s.until > s.first for s in mounted.splines)
    soon = 0.5 * min(s.knots[-1] for s in mounted.splines)
    assert len({s.module for s in mounted.splines if s.knots[0] < soon < s.knots[-1]}) == 4
    assert mounted.times[-1] < 3.0


def test_both_checkers_believe_it(mounted: PlanRecord) -> None:
    verdict = verify(mounted)
    assert verdict.verified and verdict.goal_reached
    assert judge(read(text_of(mounted))) == []


def text_of(plan: PlanRecord) -> str:
    return str(msgspec.json.encode(plan), "utf-8")


def kinds(plan: PlanRecord) -> set[str]:
    return {f.kind for f in verify(plan).failures}


def test_a_spline_that_moves_a_bound_module_through_its_switch_is_refused(mounted: PlanRecord) -> None:
    """Two phases of one module as one spline, with a rate at the switch between them that binds it."""
    last = len(mounted.phases) - 1
    final = next(s for s in mounted.splines if s.first == s.until == last)
    before = next(s for s in mounted.splines if s.module == final.module and s.until < last)
    begin = mounted.phases[before.first].start
    count = round((mounted.phases[last].end - begin) / 0.01)
    knots = np.round(begin + np.arange(count + 1) * 0.01, 10)
    share = np.linspace(0.0, 1.0, count + 1)[:, None]
    start, end = np.asarray(before.values[0]), np.asarray(final.values[-1])
    values = np.round(start + (end - start) * (3 * share**2 - 2 * share**3), 10)
    joined = replace(before, until=last, knots=knots.tolist(), values=values.tolist())
    splines = [s for s in mounted.splines if s is not final and s is not before and not (
        s.module == final.module and before.first <= s.first)]  # fmt: skip
    assert "switch_rad_s" in kinds(replace(mounted, splines=[joined, *splines]))


def test_a_spline_shifted_in_time_is_refused(mounted: PlanRecord) -> None:
    spline = next(s for s in mounted.splines if s.until > s.first)
    values = [spline.values[0], *spline.values[:-1]]
    shifted = replace(spline, values=[*values[:-1], spline.values[-1]])
    others = [s for s in mounted.splines if s is not spline]
    assert kinds(replace(mounted, splines=[shifted, *others])) & {"spline_rad", "joint_acceleration_rad_s2"}


@pytest.mark.parametrize("whole", [True, False])
def test_phases_and_splines_of_two_formats_do_not_mix(mounted: PlanRecord, tmp_path: Path, whole: bool) -> None:
    """A plan that says to be of the first format, or one of whose splines is of it."""
    data = json.loads(text_of(mounted))
    if whole:
        data["format"] = "tamplang-plan/1"
    else:
        data["splines"][0]["phase"] = data["splines"][0].pop("from")
        del data["splines"][0]["until"]
    file = tmp_path / "mixed.plan.json"
    file.write_text(json.dumps(data), encoding="utf-8")
    with pytest.raises(PlanFileError, match="splines of another one") as caught:
        read_plan(str(file))
    assert caught.value.diagnostic.code == "E0023"


def test_two_robots_that_meet_between_samples_are_refused(pressed: PlanRecord) -> None:
    """Both arms turn about their feet and back, ten times as slowly as the plan moves; samples are only where they are
    not yet near each other, or not any more."""
    draft = Draft(text_of(pressed), Random(0))
    data = draft.data
    data["times"] = [round(10.0 * t, 10) for t in data["times"]]
    for phase in data["phases"]:
        phase["start"], phase["end"] = (round(10.0 * phase[name], 10) for name in ("start", "end"))
    for spline in data["splines"]:
        spline["knots"] = [round(10.0 * t, 10) for t in spline["knots"]]
    slow = verify(msgspec.json.decode(json.dumps(data), type=PlanRecord))
    assert slow.verified
    for module in ("c[1]", "c[2]"):
        draft.bump(module, 0, 0, 0.8, 0.2, 0.8)
    draft.derive(1)
    crowded(draft, 0)
    text = json.dumps(data)
    verdict = verify(msgspec.json.decode(text, type=PlanRecord))
    assert verdict.failures and {f.kind for f in verdict.failures} == {"penetration_m"}
    assert all({name[:4] for name in f.between} == {"c[1]", "c[2]"} for f in verdict.failures)
    stored = np.array(data["times"])
    assert all(f.time is not None and np.abs(stored - f.time).min() > 0.1 for f in verdict.failures)
    assert judge(read(text))


def test_the_same_seed_gives_the_same_plan(mounted: PlanRecord) -> None:
    again = load(EXAMPLES / "quadruped.tamp").solve(time=300, minimise="makespan")
    assert again.plan is not None
    assert text_of(replace(again.plan.record, timing=None)) == text_of(replace(mounted, timing=None))
    assert isinstance(again.plan, Plan)


def test_the_report_tells_what_moves_at_once_and_who_waits(mounted: PlanRecord, tmp_path: Path) -> None:
    from tamplang.runtime.report import write_report
    from tamplang.runtime.report.timeline import build_timeline

    timeline = build_timeline(mounted)
    lanes = {row.name: [b for b in row.blocks if b.acts] for row in timeline.rows if row.kind == "module"}
    first = [blocks[0] for blocks in lanes.values() if blocks]
    assert timeline.at_once and len(first) == 4
    assert max(b.left for b in first) < min(b.left + b.width for b in first)
    hanging = [b for blocks in lanes.values() for b in blocks if b.critical]
    assert {b.phase for b in hanging} >= {len(mounted.phases) - 1}
    assert sum(b.width for b in {b.phase: b for b in hanging}.values()) > 95.0
    assert timeline.waits and all(seconds > 0.0 for _, seconds in timeline.waits)
    file = tmp_path / "report.html"
    write_report(mounted, str(file), checked=True)
    text = file.read_text(encoding="utf-8")
    assert "block thin critical" in text and "waits: " in text and "makespan: " in text


def test_the_planner_chooses_who_does_what(chosen: tuple[Result, list[Plan]]) -> None:
    """Both things are nearer to one arm, which the cheapest plan of least strain takes for both; all others are tried
    that may be better by more than the gap."""
    result, met = chosen
    assert result.plan is not None and len(result.plans) == 1
    assert {action.split("[")[1][0] for action in result.actions} == {"1", "2"}
    told = result.plan.record.statistics.objective
    alike = told.bounds["any actions, none below those here"]
    assert told.value == min(plan.record.statistics.objective.value for plan in met) and len(met) > 1
    assert told.value - alike > 0.5 and [d.code for d in result.explanation] == ["S0002"]
    assert f"a gap of {told.value - alike:.3g} instead of 0.5 s" in result.explanation[0].message
    assert 0.0 < alike <= told.value < 0.7 * sum(s.knots[-1] - s.knots[0] for s in result.plan.record.splines)


def test_windows_use_the_objective_and_robots_move_through_them() -> None:
    """The first window keeps one arm busy: the second one takes the other, which moves meanwhile."""
    result = loads(PRESS).solve(time=300, minimise="makespan", horizon=1)
    assert result.plan is not None and result.plan.record.complete
    record = result.plan.record
    assert {action.split("[")[1][0] for action in result.actions} == {"1", "2"}
    assert len(record.windows) == 2 and record.verdict is not None and record.verdict.verified
    told = record.statistics.objective
    assert told.value == record.times[-1] < 0.7 * sum(s.knots[-1] - s.knots[0] for s in record.splines)
    one, other = sorted(record.splines, key=lambda s: s.knots[0])
    assert other.knots[0] < one.knots[-1]
