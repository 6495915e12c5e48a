"""Plans of runs on the page: windows, replannings, broken-off intervals, and a module that leaves the scene."""

from __future__ import annotations

from pathlib import Path

import pytest
from msgspec.structs import replace

from tamplang.runtime.plan import BreakdownRecord, CourseRecord, Plan, TimingRecord, WindowRecord
from tamplang.runtime.report import render_report, write_report

from .conftest import Opener
from .sample import climb_plan


@pytest.fixture
def run() -> Plan:
    plan = climb_plan()
    middle = plan.phases[0].end
    windows = [
        WindowRecord(0.0, 0, "start", ["a", "b"], 2, ["(held target)"]),
        WindowRecord(middle, 1, "stair[2] is <4> mm off", ["b"], 1, ["(held target)"]),
    ]
    phases = [replace(plan.phases[0], completed=False, added=[]), *plan.phases[1:]]
    gone = [BreakdownRecord(plan.modules[0].name, middle, "gone")]
    return replace(plan, phases=phases, windows=windows, breakdowns=gone, complete=False,
                   timing=TimingRecord({}, [0.5, 0.125]))  # fmt: skip


def test_the_page_tells_windows_and_what_was_broken_off(run: Plan) -> None:
    page = render_report(run)
    assert 'class="block broken"' in page and "(broken off)" in page
    assert page.count('class="window"') == 1 and page.count('class="window anew"') == 1
    assert "stair[2] is &lt;4&gt; mm off; planned in 0.12 s" in page
    assert "the action did not take place" in page and "not reached" in page
    assert "125 ms" in page or "0.125 s" in page
    assert 'id="planning"' not in render_report(climb_plan())


def test_a_run_that_tells_of_no_search_has_no_empty_chapters(run: Plan) -> None:
    without = replace(run.statistics, tree_nodes=0, expanded_nodes=0, bounds=[], refusals=[], tree=[])
    page = render_report(replace(run, statistics=without))
    for chapter in ("Search", "Bounds", "Time by stage", "Refused candidates"):
        assert f">{chapter}<" in render_report(climb_plan()) and f">{chapter}<" not in page


def test_the_page_tells_what_happens_by_itself(run: Plan) -> None:
    middle = run.phases[0].end
    pushed = CourseRecord("target", middle, [[0.0, 0.0, 1.0]], 0.0, False)
    drifts = CourseRecord("stair[1]", 0.0, [[0.0, 0.0, 1.0]], 0.01, True)
    later = CourseRecord("stair[2]", 1e6, [[0.0, 0.0, 1.0]], 0.01, True)
    window = replace(run.windows[1], reason="next window; the last motion was steered by 3.0 mm")
    page = render_report(replace(run, courses=[pushed, drifts, later], windows=[run.windows[0], window]))
    assert page.count('class="window happens anew"') == 2 and page.count('class="window happens"') == 1
    assert f"{middle:.2f} s: target is moved all at once" in page and "stair[2] begins" not in page
    assert page.count('class="window"') == 2  # a window after a steered motion is planned in turn


def test_a_module_that_left_is_out_of_sight(run: Plan, open_report: Opener, tmp_path: Path) -> None:
    write_report(run, tmp_path / "run.html")
    opened = open_report(tmp_path / "run.html")
    name, middle = run.modules[0].name, run.phases[0].end
    opened.seek(middle - 0.1)
    before = opened.pose(name)[2]
    opened.seek(middle + 0.5)
    assert opened.pose(name)[2] < before - 500.0
