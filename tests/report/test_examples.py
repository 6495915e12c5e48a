"""The examples' own plans, solved here, in a browser: what the page shows is where the plan says things are."""

from __future__ import annotations

from pathlib import Path

import pytest

import tamplang
from tamplang.runtime.plan_files import read_plan
from tamplang.runtime.tracks import body_rows

from .conftest import Opened, Opener
from .test_browser import same_pose

EXAMPLES = Path(__file__).parents[2] / "examples"
CASES = {
    "climb-1": ("climb.tamp", {"n": 8, "crawlers": 1}),
    "climb-2": ("climb.tamp", {"n": 8, "crawlers": 2}),
    "pick_and_place": ("pick_and_place.tamp", {"objects": 3}),
}


@pytest.mark.parametrize("case", CASES)
def test_replay_of_a_solved_example(case: str, tmp_path: Path, open_report: Opener) -> None:
    file, parameters = CASES[case]
    solved = tamplang.load(EXAMPLES / file, **parameters).solve()
    assert solved.plan is not None
    solved.plan.save(tmp_path / "plan.json")
    solved.plan.report(tmp_path / "report.html")
    plan = read_plan(tmp_path / "plan.json")
    opened: Opened = open_report(tmp_path / "report.html")
    assert opened.page.locator(".verdict strong").inner_text() == "verified"
    shots = []
    for phase in plan.phases:
        time = (phase.start + phase.end) / 2
        index = max(i for i, t in enumerate(plan.times) if t <= time)
        opened.seek(plan.times[index])
        for name, rows in ({t.name: t.poses for t in plan.tracks} | body_rows(plan)).items():
            assert same_pose(opened.pose(name), rows[index])
        opened.page.wait_for_timeout(100)
        shots.append(opened.page.locator("#pane").screenshot(path=tmp_path / f"{index}.png"))
    assert len(set(shots)) == len(shots)
    assert opened.errors == []
    assert opened.requests == [(tmp_path / "report.html").as_uri()]
