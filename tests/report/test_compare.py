"""Two plans on one page: what differs is told, and both reports are there."""

from __future__ import annotations

from pathlib import Path

import msgspec
from click.testing import CliRunner
from playwright.sync_api import Browser

from tamplang.cli.app import application
from tamplang.runtime.plan import MachineRecord, TimingRecord
from tamplang.runtime.plan_files import write_plan
from tamplang.runtime.report.clearance import build_clearance
from tamplang.runtime.report.compare import actions, figures

from .sample import climb_plan


def test_what_differs_is_told_in_figures_and_actions(tmp_path: Path) -> None:
    first = climb_plan()
    second = msgspec.structs.replace(first, phases=first.phases[:-1])
    told = {row.name: (row.first, row.second) for row in figures(first, second)}
    assert told["Actions"] == (str(len(first.phases)), str(len(first.phases) - 1))
    assert next(row for row in figures(first, second) if row.name == "Cost").same
    far = min(build_clearance(first), key=lambda c: c.least)
    assert told["Least clearance"][0] == f"{1000.0 * far.least:.1f} mm, {far.first} and {far.second}"
    assert "n = " in told["Parameters"][0]
    assert "Computed on" not in told
    machine = MachineRecord("Abacus", "x86_64", 4, "Linux 6.1")
    timed = msgspec.structs.replace(first, timing=TimingRecord({"total": 3.0}, machine=machine))
    (row,) = (row for row in figures(timed, second) if row.name == "Computed on")
    assert (row.first, row.second) == ("Abacus (x86_64), 4 cores, Linux 6.1", "–")
    rows = actions(first, second)
    assert [row.first for row in rows] == [phase.action for phase in first.phases]
    assert [row.same for row in rows] == [True] * (len(rows) - 1) + [False] and rows[-1].second == ""


def test_the_command_writes_a_page_of_both_of_which_what_plays_is_not_printed(tmp_path: Path, browser: Browser) -> None:
    for name in ("a", "b"):
        write_plan(climb_plan(), tmp_path / f"{name}.json")
    first, second, page = (str(tmp_path / name) for name in ("a.json", "b.json", "c.html"))
    result = CliRunner().invoke(application, ["report", first, second, "--unchecked", "-o", page])
    assert result.exit_code == 0, result.output
    text = Path(page).read_text(encoding="utf-8")
    assert text.count("<iframe") == 2 and "Both in step" in text and "a.json" in text
    shown = browser.new_page()
    shown.goto(Path(page).as_uri())
    assert shown.locator("#step-title").is_visible()
    shown.emulate_media(media="print")
    assert shown.locator("#differences").is_visible() and not shown.locator("#step-title").is_visible()
    shown.close()
