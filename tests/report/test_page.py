"""The page's text: what it says, that it escapes, and that partial plans pass."""

from __future__ import annotations

import re
from html.parser import HTMLParser
from pathlib import Path

import msgspec
import pytest

from tamplang.runtime.plan import (
    BodyRecord,
    BodyTrackRecord,
    Plan,
    SearchNode,
    ShapeRecord,
    StatisticsRecord,
    TrackRecord,
)
from tamplang.runtime.plan_files import read_plan, write_plan
from tamplang.runtime.report import render_report, write_report

from .sample import SAMPLES, climb_plan, dock_plan, empty_plan, place, still_plan

EVIL = "</script><script>alert(1)</script><!--\u2028\"'&"


class Text(HTMLParser):
    """The visible text of a page, and its elements."""

    def __init__(self) -> None:
        super().__init__()
        self.words: list[str] = []
        self.tags: list[str] = []
        self.addresses: list[str] = []
        self.silent = False

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.silent = tag in ("script", "style")
        self.addresses += [v for k, v in attrs if k in ("href", "src", "action") and v]

    def handle_endtag(self, tag: str) -> None:
        self.silent = False

    def handle_data(self, data: str) -> None:
        if not self.silent:
            self.words.append(data)


def parse(html: str) -> Text:
    text = Text()
    text.feed(html)
    return text


def words(plan: Plan) -> str:
    return " ".join(" ".join(parse(render_report(plan)).words).split())


def test_says_what_was_asked_and_what_came_out() -> None:
    text = words(climb_plan())
    for part in ("climb", "n = 3", "crawlers = 1", "seed = 0", "verified", "optimal", "4.61 s", "120 nodes",
                 "step(c[1].A, c[1].B, ground, stair[1])", "[stand c[1].B stair[1]]", "rules.tamp:2",
                 "c[1] meets stair[2]", "13 mm", "seq-path", "0.21 mm"):  # fmt: skip
        assert part in text


def test_says_plainly_why_a_plan_is_refused() -> None:
    text = words(dock_plan())
    assert "refused" in text and "slip : c[1].B slides on c[2].B" in text and "4.1 mm" in text
    assert "at most 1 above the optimum" in text


def test_rule_stands_with_its_lines_marked() -> None:
    html = render_report(climb_plan())
    marked = re.findall(r'<span class="row here"><a class="gutter" href="#s1-(\d+)">', html)
    assert {"2", "8", "10"} <= set(marked)


@pytest.mark.parametrize("make", [climb_plan, dock_plan, empty_plan, still_plan])
def test_same_plan_same_page(make: object) -> None:
    assert callable(make)
    assert render_report(make()) == render_report(make())


def test_survives_the_plan_file(tmp_path: Path) -> None:
    write_plan(climb_plan(), tmp_path / "plan.json")
    write_report(read_plan(tmp_path / "plan.json"), tmp_path / "report.html")
    assert (tmp_path / "report.html").read_text(encoding="utf-8") == render_report(climb_plan())
    assert [p.name for p in tmp_path.iterdir() if p.name.startswith(".")] == []


def test_needs_nothing_from_outside() -> None:
    html = render_report(climb_plan())
    addresses = parse(html).addresses
    assert all(a.startswith("#") or a == "data:," for a in addresses)
    assert "default-src 'none'" in html


def test_size_of_nine_phases() -> None:
    assert len(render_report(climb_plan(7))) < 1_000_000


def poison(value: object) -> object:
    """Every free text of a plan, with a script in it."""
    if isinstance(value, str):
        return value + EVIL
    if isinstance(value, list):
        return [poison(v) for v in value]
    if isinstance(value, dict):
        return {k: poison(v) if k not in ("format", "kind") else v for k, v in value.items()}
    return value


@pytest.mark.parametrize("make", [climb_plan, dock_plan])
def test_escapes_everything(make: object) -> None:
    assert callable(make)
    clean = make()
    dirty = msgspec.convert(poison(msgspec.to_builtins(clean)), Plan)
    before, after = parse(render_report(clean)), parse(render_report(dirty))
    assert after.tags.count("script") == before.tags.count("script")
    assert "alert(1)" in " ".join(after.words)


def test_links_lead_somewhere() -> None:
    html = render_report(climb_plan())
    targets = set(re.findall(r' id="([^"]+)"', html))
    assert {a[1:] for a in parse(html).addresses if a.startswith("#")} <= targets


def test_unknown_places_are_named_but_not_linked() -> None:
    plan = climb_plan()
    phase = msgspec.structs.replace(plan.phases[0], place=place("elsewhere.tamp", 7))
    text = words(msgspec.structs.replace(plan, phases=[phase]))
    assert "elsewhere.tamp:7" in text and "The plan holds no source text for this rule." in text


@pytest.mark.parametrize(
    "change",
    [
        {"tracks": [TrackRecord("c[1]", [], [])]},
        {"tracks": [TrackRecord("c[1]", [[0.0] * 7] * 4, [[0.0] * 7] * 2)]},
        {"tracks": [TrackRecord("c[1]", [[0.0] * 3] * 9, [[0.0] * 2] * 9)]},
        {"tracks": [TrackRecord("somebody", [[0.0] * 7], [[0.0] * 7])]},
        {"body_tracks": [BodyTrackRecord("target", 0, [])]},
        {"bodies": [BodyRecord("blob", "object", ShapeRecord("mesh", []), [], True)]},
        {"times": []},
        {"times": [0.0]},
        {"phases": []},
        {"verdict": None},
        {"statistics": StatisticsRecord(tree=[SearchNode(1, 2, "a", 1.0, ""), SearchNode(2, 1, "b", 1.0, "x")])},
        {"modules": []},
    ],
)  # fmt: skip
def test_partial_plans_pass(change: dict[str, object]) -> None:
    assert "</html>" in render_report(msgspec.structs.replace(climb_plan(2), **change))


def test_deep_and_wide_trees_pass() -> None:
    deep = [SearchNode(i, i - 1, f"a{i}", float(i), "expanded") for i in range(1500)]
    wide = [SearchNode(1500 + i, 0, f"b{i}", 1.0, "pruned") for i in range(900)]
    text = words(msgspec.structs.replace(climb_plan(1), statistics=StatisticsRecord(tree=deep + wide)))
    assert "1500 expanded" in text and "900 pruned" in text and "400 more nodes are in the plan file" in text


def test_long_motion_is_thinned_but_keeps_switches() -> None:
    from tamplang.runtime.report.replay import MOST_SAMPLES, pick_samples

    times = [k + s / 400 for k in range(40) for s in range(401)]
    picked = pick_samples(times)
    assert len(picked) < MOST_SAMPLES + 200
    assert {401 * k for k in range(40)} | {401 * k + 400 for k in range(40)} <= set(picked.tolist())
    assert len(pick_samples([k * 1.0 for k in range(SAMPLES)])) == SAMPLES
