"""Every figure that the page prints, against figures worked out by hand: each test fails when one of them is wrong."""

from __future__ import annotations

import re
from html.parser import HTMLParser

import msgspec
import pytest

from tamplang.runtime.plan import (
    FailureRecord,
    JointRecord,
    MachineRecord,
    MeasureRecord,
    PhaseRecord,
    Plan,
    StatisticsRecord,
    TimingRecord,
    VerdictRecord,
    WindowRecord,
)
from tamplang.runtime.report import render_report
from tamplang.runtime.report.timeline import build_plots, build_timeline, ticks
from tamplang.runtime.report.view import figure

from .sample import climb_plan, dock_plan, empty_plan

IDLE = ("script", "style")


class Sections(HTMLParser):
    """The text of every section by its id, the header as "top"; `rows` are the cells of all table rows, `bars` the
    titles and widths of bars in order."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.text: dict[str, str] = {}
        self.rows: dict[str, list[list[str]]] = {}
        self.bars: list[str] = []
        self.widths: list[str] = []
        self._at, self._silent, self._cell = "top", False, False
        self.feed(html)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        values = dict(attrs)
        self._silent = tag in IDLE
        if tag == "section":
            self._at = values.get("id") or ""
        if tag == "footer":
            self._at = "footer"
        if tag == "tr":
            self.rows.setdefault(self._at, []).append([])
        if tag in ("td", "th"):
            self.rows[self._at][-1].append("")
            self._cell = True
        if tag == "span" and (values.get("class") or "").startswith("bar"):
            self.bars.append(values.get("title") or "")
        if tag == "span" and (values.get("style") or "").startswith("width:"):
            self.widths.append((values["style"] or "").removeprefix("width:"))

    def handle_endtag(self, tag: str) -> None:
        self._silent = False
        self._cell = self._cell and tag not in ("td", "th")

    def handle_data(self, data: str) -> None:
        if self._silent:
            return
        self.text[self._at] = " ".join((self.text.get(self._at, "") + " " + data).split())
        if self._cell:
            self.rows[self._at][-1][-1] = " ".join((self.rows[self._at][-1][-1] + " " + data).split())


def page(plan: Plan, **changes: object) -> Sections:
    return Sections(render_report(msgspec.structs.replace(plan, **changes)))


def statistics(plan: Plan, **changes: object) -> StatisticsRecord:
    return msgspec.structs.replace(plan.statistics, **changes)


def test_the_header_tells_actions_length_motion_cost_and_time() -> None:
    text = page(climb_plan()).text["top"]
    told = ("seed = 0", "Actions 5", "Length optimal", "Motion 5 s", "Cost 31.4", "Computed in 4.61 s", "Modules 1")
    for part in told:
        assert part in text, part


def test_actions_that_were_broken_off_do_not_count() -> None:
    plan = climb_plan()
    last = msgspec.structs.replace(plan.phases[-1], completed=False)
    assert "Actions 4" in page(plan, phases=[*plan.phases[:-1], last]).text["top"]


@pytest.mark.parametrize(
    ("optimal", "gap", "told"),
    [(True, 0.0, "optimal"), (False, 1.25, "at most 1.25 above the optimum"), (False, None, "not proved optimal")],
)
def test_the_header_tells_the_gap(optimal: bool, gap: float | None, told: str) -> None:
    plan = climb_plan()
    text = page(plan, statistics=statistics(plan, optimal=optimal, gap=gap)).text["top"]
    assert f"Length {told} Motion" in text


def test_the_motion_ends_with_the_last_phase_or_sample() -> None:
    plan = dock_plan()
    longer = msgspec.structs.replace(plan.phases[-1], end=3.75)
    assert "Motion 3.75 s" in page(plan, phases=[*plan.phases[:-1], longer]).text["top"]
    assert "Motion 3 s" in page(plan).text["top"]


def test_measures_stand_against_their_limits_and_the_worst_is_marked() -> None:
    measures = [
        MeasureRecord("slip_m", 0.0005, 0.002, "m", 3.2, ["c[1].A", "ground"]),
        MeasureRecord("joint_limit_rad", 0.006, 0.008, "rad", 2.0, ["c[1]"]),
        MeasureRecord("penetration_m", -0.001, 0.001, "m", 1.1, []),
        MeasureRecord("torque_ratio", 0.3, 1.0, "", None, []),
        MeasureRecord("joint_speed_rad_s", 2.0, 2.0, "rad/s", 0.5, ["c[1]"]),
    ]
    found = page(climb_plan(), verdict=VerdictRecord(True, {}, measures, [], [], goal_reached=True))
    rows = [row for row in found.rows["evidence"] if len(row) == 7][1:]
    assert [row[:5] for row in rows] == [
        ["slip", "c[1].A, ground", "3.20 s", "0.5 mm", "2 mm"],
        ["joint limit worst", "c[1]", "2.00 s", "0.006 rad", "0.008 rad"],
        ["penetration", "", "1.10 s", "-1 mm", "1 mm"],
        ["torque", "", "", "0.3", "1"],
        ["joint speed", "c[1]", "0.50 s", "2 rad/s", "2 rad/s"],
    ]
    assert found.bars[:5] == ["25.0 %", "75.0 %", "0.0 %", "30.0 %", "100.0 %"]
    assert found.widths[:5] == ["25.0%", "75.0%", "0.0%", "30.0%", "100.0%"]


def test_nothing_is_marked_where_nothing_is_near_to_fail() -> None:
    measures = [MeasureRecord("slip_m", 1e-9, 0.002, "m", 3.2, []), MeasureRecord("gap_m", 0.0009, 0.002, "m", 1.0, [])]
    found = page(climb_plan(), verdict=VerdictRecord(True, {}, measures, [], [], goal_reached=True))
    assert not any("worst" in cell for row in found.rows["evidence"] if len(row) == 7 for cell in row[:1])


def test_a_bar_ends_at_its_limit_where_the_figure_does_not() -> None:
    over = MeasureRecord("slip_m", 0.0041, 0.002, "m", 1.5)
    failure = FailureRecord("slip_m", "it slides", 0.0041, "m", 1.5)
    found = page(climb_plan(), verdict=VerdictRecord(False, {}, [over], [failure], []))
    assert found.bars[0] == "205.0 %"
    assert found.widths[0] == "100.0%"
    assert "1 failure" in found.text["top"]
    assert "slip : it slides 4.1 mm at 1.50 s" in found.text["evidence"]


def test_residuals_are_counted() -> None:
    plan = climb_plan()
    assert plan.verdict is not None
    count = sum(len(p.added) for p in plan.phases)
    assert f"{count} switch constraints, each with its worst row" in page(plan).text["evidence"]


def test_bounds_stages_and_refusals_are_told() -> None:
    found = page(climb_plan())
    bounds = [row for row in found.rows["evidence"] if row[0] in ("seq", "seq-path", "path") and len(row) == 4]
    assert [[name, *counts] for name, _, *counts in bounds] == [
        ["seq", "4", "1"], ["seq-path", "3", "1"], ["path", "1", "1"],
    ]  # fmt: skip
    assert all(len(asked.split()) > 5 for _, asked, *_ in bounds)
    three = [row for row in found.rows["evidence"] if len(row) == 3]
    assert three[1:] == [
        ["compile", "0.21 s", ""], ["search", "20 ms", ""], ["seq", "0.31 s", ""], ["seq_path", "1.2 s", ""],
        ["path", "2.4 s", ""], ["verify", "0.4 s", ""], ["total", "4.61 s", ""],
    ]  # fmt: skip
    assert found.bars[-6:] == ["5 %", "0 %", "7 %", "26 %", "52 %", "9 %"]
    assert found.widths[-6:] == ["4.6%", "0.4%", "6.7%", "26.0%", "52.1%", "8.7%"]
    refused = [row for row in found.rows["evidence"] if len(row) == 5][1]
    assert refused[0] == "path" and refused[2:4] == ["c[1] meets stair[2]", "13 mm"]


def test_a_total_is_summed_where_none_is_stored() -> None:
    found = page(climb_plan(), timing=TimingRecord({"search": 1.0, "path": 3.0}))
    assert "Computed in 4 s" in found.text["top"]
    assert found.bars[-2:] == ["25 %", "75 %"]


def test_the_machine_stands_beside_the_command() -> None:
    machine = MachineRecord("Abacus <5>", "x86_64", 4, "Linux 6.1")
    found = page(climb_plan(), timing=TimingRecord({"total": 3.0}, machine=machine))
    assert "Computed on Abacus <5> (x86_64), 4 cores, Linux 6.1." in found.text["footer"]
    machine = MachineRecord("", "arm64", 1, "Darwin 24")
    unknown = page(climb_plan(), timing=TimingRecord({"total": 3.0}, machine=machine))
    assert "Computed on arm64, 1 core, Darwin 24." in unknown.text["footer"]
    assert "Computed on" not in page(climb_plan(), timing=TimingRecord({"total": 3.0})).text["footer"]


def test_phases_tell_their_times() -> None:
    text = page(climb_plan()).text["skeleton"]
    for k in range(5):
        assert f"{k}.00 – {k + 1}.00 s" in text


def test_the_search_tells_its_nodes() -> None:
    plan = climb_plan()
    tree = plan.statistics.tree
    text = page(plan).text["search"]
    assert "120 nodes in the tree, 17 expanded; kept here:" in text
    for status in {node.status for node in tree}:
        assert f"{sum(n.status == status for n in tree)} {status}" in text
    below = sorted((int(n) for n in re.findall(r"(\d+) below", text)), reverse=True)
    assert below == [len(tree) - 1 - 3 * k for k in range(5)]
    assert text.count("6.0") == 0 and f"{tree[2].estimate:.4g}" in text


def test_windows_tell_when_why_and_how_long() -> None:
    plan = climb_plan()
    windows = [
        WindowRecord(0.0, 0, "start", ["a", "b", "c"], 2, ["(held target)"]),
        WindowRecord(2.0, 2, "c[1] was late", ["b", "c"], 1, []),
        WindowRecord(3.0, 3, "next window", ["c"], 1, []),
        WindowRecord(4.0, 4, "next window", ["c"], 1, []),
    ]
    timing = TimingRecord({"total": 9.0}, [5.0, 0.25, 3.5, 0.5])
    found = page(plan, windows=windows, timing=timing)
    assert "Planned anew 3 ×" in found.text["top"]
    assert "4 windows were planned on the way; after the first, 0.5 s each in the median, 3.5 s at most." in (
        found.text["planning"]
    )
    assert found.rows["planning"][1:] == [
        ["0.00 s", "start", "5 s", "3", "2", "(held target)"],
        ["2.00 s", "c[1] was late", "0.25 s", "2", "1", ""],
        ["3.00 s", "next window", "3.5 s", "1", "1", ""],
        ["4.00 s", "next window", "0.5 s", "1", "1", ""],
    ]


def test_blocks_and_windows_lie_where_their_times_are() -> None:
    plan = climb_plan()
    late = msgspec.structs.replace(
        plan, windows=[WindowRecord(2.5, 2, "c[1] was late", [], 1, []), WindowRecord(4.0, 4, "next window", [], 1, [])]
    )
    line = build_timeline(late)
    assert [(b.left, b.width) for b in line.actions] == [(20.0 * k, 20.0) for k in range(5)]
    assert [(m.left, m.anew, m.title) for m in line.marks] == [
        (50.0, True, "2.50 s: c[1] was late"), (80.0, False, "4.00 s: next window"),
    ]  # fmt: skip
    assert line.total == 5.0


def test_ticks_are_round_and_in_place() -> None:
    assert ticks(5.0) == [(10.0 * k, f"{0.5 * k:g}") for k in range(11)]
    assert ticks(30.0)[1] == (pytest.approx(100.0 / 6.0), "5")
    assert ticks(0.0) == []


def test_joint_plots_tell_the_largest_value_and_the_limits() -> None:
    plan = climb_plan()
    found = page(plan).text["joints"]
    plots = build_plots(plan)[0].plots
    for column, (plot, joint) in enumerate(zip(plots, plan.modules[0].joints, strict=True)):
        values = [row[column] for row in plan.tracks[0].joints]
        peak = max(values, key=abs)
        assert plot.peak == pytest.approx(peak)
        assert f"{joint.name} {peak:.2f} rad ± {joint.upper:.3g} rad" in found
        low, high = min(joint.lower, *values), max(joint.upper, *values)
        margin = 0.06 * (high - low)
        scale = 100.0 / (high - low + 2.0 * margin)
        assert plot.upper_y == pytest.approx(scale * (high + margin - joint.upper), abs=0.01)
        assert plot.lower_y == pytest.approx(scale * (high + margin - joint.lower), abs=0.01)
        points = [tuple(map(float, p.split(","))) for p in plot.path.split(" ")]
        assert points[0] == pytest.approx((0.0, scale * (high + margin - values[0])), abs=0.06)
        assert points[-1] == pytest.approx((1000.0, scale * (high + margin - values[-1])), abs=0.06)


def test_a_slide_is_told_in_metres_with_both_its_limits() -> None:
    plan = climb_plan()
    joints = list(plan.modules[0].joints)
    first = joints[0]
    joints[0] = JointRecord("slide", "prismatic", -1, first.placement, first.axis, -0.25, 1.5, 2.0)
    module = msgspec.structs.replace(plan.modules[0], joints=joints)
    assert "-0.25 … 1.5 m" in page(plan, modules=[module]).text["joints"]


def test_a_scene_without_anything_has_no_figures() -> None:
    text = page(empty_plan()).text["top"]
    assert "Actions 0" in text and "Motion 0 ms" in text and "Computed in 0 ms" in text and "Modules 0" in text


@pytest.mark.parametrize(
    ("amount", "unit", "told"),
    [
        (0.0123, "m", "12.3 mm"), (0.099, "m", "99 mm"), (0.1, "m", "0.1 m"), (1234.5, "m", "1234 m"),
        (0.02, "s", "20 ms"), (-0.02, "m", "-20 mm"), (2e-7, "m", "< 0.001 mm"), (2e-7, "rad", "< 1e-06 rad"),
        (0.0123, "rad", "0.0123 rad"), (float("inf"), "m", "∞"), (float("-inf"), "m", "−∞"), (float("nan"), "m", "–"),
        (0.0, "m", "0 mm"), (0.5, "", "0.5"),
    ],
)  # fmt: skip
def test_figures_have_three_digits_and_units_for_people(amount: float, unit: str, told: str) -> None:
    assert figure(amount, unit) == told


def test_a_phase_of_no_length_has_no_width() -> None:
    plan = climb_plan()
    backwards: PhaseRecord = msgspec.structs.replace(plan.phases[0], end=plan.phases[0].start)
    assert build_timeline(msgspec.structs.replace(plan, phases=[backwards, *plan.phases[1:]])).actions[0].width == 0.0
