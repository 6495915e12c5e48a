"""What is said of a plan: what it was checked against, whether it is finished, and where refused ones go."""

from __future__ import annotations

import hashlib
import io
import json
import re
from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from tamplang import cli, read_plan
from tamplang.runtime.verify.limits import LIMITS

TINY = """import std.crawler
import std.rules

task tiny(gap: length = 0.5 m) {
    base left: box(0.3 m, 0.3 m, 0.05 m) at (0, 0, 0)
    base right: box(0.3 m, 0.3 m, 0.05 m) at (gap, 0, 0)
    base far: box(0.3 m, 0.3 m, 0.05 m) at (2 * gap, 0, 0)
    crawler c: A on left
    goal (on far c.A), not (on left c.A)
    options { slices = 5 }
}
"""
Data = dict[str, Any]


@dataclass(frozen=True)
class Told:
    """How a command ended, and what it said where."""

    status: int
    out: str
    err: str

    def json(self) -> Data:
        found: Data = json.loads(self.out)
        return found


def run(*arguments: object) -> Told:
    out, err = io.StringIO(), io.StringIO()
    with redirect_stdout(out), redirect_stderr(err):
        status = cli.run([str(a) for a in arguments])
    return Told(status, out.getvalue(), err.getvalue())


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A task and its plan, made under an absolute path, with an import from the folder above and one that looks like
    the standard library's."""
    folder = tmp_path_factory.mktemp("maker") / "task"
    (folder / "std").mkdir(parents=True)
    (folder.parent / "above.tamp").write_text("predicate (above)\n")
    (folder / "std" / "own.tamp").write_text("predicate (own)\n")
    (folder / "tiny.tamp").write_text('import "../above.tamp"\nimport "std/own.tamp"\n' + TINY)
    solved = run("solve", folder / "tiny.tamp", "--out", folder / "plan.json", "--seed", "3")
    assert solved.status == 0, solved.err
    return folder


@pytest.fixture(scope="module")
def good(folder: Path) -> Data:
    found: Data = json.loads((folder / "plan.json").read_text())
    return found


def written(path: Path, data: Data) -> Path:
    path.write_text(json.dumps(data))
    return path


# --- what it was checked against ---------------------------------------------------------------------------------


def test_a_plan_names_no_path_of_its_maker(folder: Path, good: Data) -> None:
    text = (folder / "plan.json").read_text()
    assert str(folder.parent) not in text and str(Path.home()) not in text.replace('"std/', "")
    paths = [s["path"] for s in good["task"]["sources"] if not s["path"].startswith("std/")]
    assert paths == ["task/tiny.tamp", "above.tamp", "task/std/own.tamp"]
    assert good["task"]["file"] == "task/tiny.tamp"
    places = re.findall(r'"place":\{"file":"([^"]*)"', text)
    assert set(places) <= {s["path"] for s in good["task"]["sources"]}
    assert run("verify", folder / "plan.json").status == 0


def test_verify_says_what_it_checked_against(folder: Path, good: Data) -> None:
    told = run("verify", folder / "plan.json", "--json").json()
    assert told["verified"] and told["complete"] and told["goal_reached"] and told["unmet"] == []
    assert (told["task"], told["seed"], told["parameters"]) == ("tiny", 3, {"gap": 0.5})
    assert told["goal"] == good["task"]["goal"] and told["against"] is None
    assert [s["path"] for s in told["sources"]] == [s["path"] for s in good["task"]["sources"]]
    for shown, stored in zip(told["sources"], good["task"]["sources"], strict=True):
        assert shown["sha256"] == hashlib.sha256(stored["text"].encode()).hexdigest()
        assert shown["installed"] is (True if stored["path"].startswith("std/") else None)
    assert told["limits"] == LIMITS
    text = run("verify", folder / "plan.json").out
    assert "task tiny of task/tiny.tamp, gap = 0.5, seed 3" in text and told["goal"] in text
    assert all(s["sha256"] in text for s in told["sources"]) and "WARNING" not in text


def other_standard(data: Data) -> None:
    source = next(s for s in data["task"]["sources"] if s["path"] == "std/crawler.tamp")
    source["text"] += "\n"
    source["sha256"] = hashlib.sha256(source["text"].encode()).hexdigest()


def test_a_changed_standard_text_is_told_loudly(good: Data, tmp_path: Path) -> None:
    other = json.loads(json.dumps(good))
    other_standard(other)
    path = written(tmp_path / "p.json", other)
    told = run("verify", path)
    assert told.status == 0 and "WARNING: std/crawler.tamp differs from the installed one\n" in told.out
    sources = {s["path"]: s["installed"] for s in run("verify", path, "--json").json()["sources"]}
    assert sources["std/crawler.tamp"] is False and sources["std/rules.tamp"] is True


@pytest.mark.parametrize(
    ("old", "new", "what"),
    [
        ("0.05 m) at (gap", "0.05 m) at (gap + 1 cm", "body right"),
        ("goal (on far c.A)", "goal (on far c.B)", "the goal"),
        ("A on left", "B on left", "module c"),
        ("box(0.3 m, 0.3 m, 0.05 m) at (0", "box(0.4 m, 0.3 m, 0.05 m) at (0", "body left"),
        ("crawler c: A on left", "crawler c: A on left crawler d: A on right", "module d"),
        ("task tiny", "rule leap(A: effector, X: base) { pre (on X A) post not (on X A) }\ntask tiny", "rule leap"),
        ("task tiny", "motion [over X: effector, Y: object] { at switch inside(X, Y) >= 3 cm }\ntask tiny", "over"),
        ("task tiny", "predicate (mine)\ntask tiny", "predicate mine"),
    ],
)
def test_against_refuses_another_task(old: str, new: str, what: str, folder: Path, tmp_path: Path) -> None:
    own = (folder / "tiny.tamp").read_text()
    assert old in own
    (tmp_path / "task" / "std").mkdir(parents=True)
    (tmp_path / "above.tamp").write_text("predicate (above)\n")
    (tmp_path / "task" / "std" / "own.tamp").write_text("predicate (own)\n")
    (tmp_path / "task" / "own.tamp").write_text("\n\n" + own)
    assert run("verify", folder / "plan.json", "--against", tmp_path / "task" / "own.tamp").status == 0
    (tmp_path / "task" / "own.tamp").write_text(own.replace(old, new, 1))
    told = run("verify", folder / "plan.json", "--against", tmp_path / "task" / "own.tamp")
    assert told.status == 5 and re.search(rf"refused: .*{what}", told.out), told


def test_against_a_file_that_is_no_such_task(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "own.tamp").write_text(TINY.replace("task tiny", "task other"))
    assert run("verify", folder / "plan.json", "--against", tmp_path / "own.tamp").status == 2
    (tmp_path / "own.tamp").write_text("task tiny {")
    assert run("verify", folder / "plan.json", "--against", tmp_path / "own.tamp").status == 1
    assert run("verify", folder / "plan.json", "--against", tmp_path / "none.tamp").status == 1


def twice(data: Data) -> None:
    data["task"]["sources"].append(data["task"]["sources"][1])


def source_and_file(data: Data) -> None:
    source = data["task"]["sources"][1]
    data["task"]["files"] = [{"path": source["path"], "data": "", "sha256": hashlib.sha256(b"").hexdigest()}]


def unnamed_source(data: Data) -> None:
    text = "predicate (spare)"
    digest = hashlib.sha256(text.encode()).hexdigest()
    data["task"]["sources"].append({"path": "spare.tamp", "text": text, "sha256": digest})


def unnamed_file(data: Data) -> None:
    data["task"]["files"] = [{"path": "spare.stl", "data": "", "sha256": hashlib.sha256(b"").hexdigest()}]


def other_goal(data: Data) -> None:
    data["task"]["goal"] = "(on left c.A)"


def other_file(data: Data) -> None:
    data["task"]["file"] = "elsewhere/tiny.tamp"


def other_parameter(data: Data) -> None:
    data["task"]["parameters"]["gap"] = 0.6


def window(data: Data, **fields: object) -> None:
    last = {"time": 0.0, "phase": 0, "reason": "start", "actions": ["a"], "motions": 1, "unmet": []}
    data["windows"] = [last, {**last, **fields}]


def last_not_done(data: Data) -> None:
    data["phases"][-1] |= {"completed": False, "added": []}


def goal_phase_not_done(data: Data) -> None:
    last_not_done(data)
    data["complete"] = False


def other_action_not_done(data: Data) -> None:
    """An action whose condition does not hold, called one that was broken off."""
    data["phases"][-1] |= {"completed": False, "added": [], "action": "step(c.A, c.B, right, left)"}
    data["phases"][-1]["args"] = ["c.A", "c.B", "right", "left"]
    data["complete"] = False


def no_action(data: Data) -> None:
    data["phases"][-1] |= {"completed": False, "added": [], "action": "fly(c)", "rule": "fly", "args": ["c"]}
    data["complete"] = False


def other_label(data: Data) -> None:
    goal_phase_not_done(data)
    data["phases"][-1]["action"] = "step(c.A, c.B, left, left)"


@pytest.mark.parametrize(
    "change",
    [
        twice,
        source_and_file,
        unnamed_source,
        unnamed_file,
        other_goal,
        other_file,
        other_parameter,
        lambda d: window(d, phase=9),
        lambda d: window(d, phase=-1),
        lambda d: window(d, time=99.0),
        lambda d: window(d, time=0.4),
        lambda d: window(d, time=-1.0),
        lambda d: window(d, motions=7),
        last_not_done,
        goal_phase_not_done,
        other_action_not_done,
        no_action,
        other_label,
    ],
)
def test_what_a_plan_says_of_itself_must_be_true(change: Callable[[Data], None], good: Data, tmp_path: Path) -> None:
    data = json.loads(json.dumps(good))
    change(data)
    told = run("verify", written(tmp_path / "p.json", data))
    assert told.status == 5 and "refused: " in told.out, told


# --- finished or not ---------------------------------------------------------------------------------------------


@pytest.fixture
def unfinished(good: Data, tmp_path: Path) -> Path:
    """The first step of the plan alone, as a run that ended then would have written it."""
    data = json.loads(json.dumps(good))
    end = data["phases"][0]["end"]
    count = data["times"].index(end) + 1
    data["final_mode"] = data["phases"][1]["mode"]
    data["phases"], data["times"] = data["phases"][:1], data["times"][:count]
    for track in data["tracks"]:
        track["poses"], track["joints"] = track["poses"][:count], track["joints"][:count]
    data["splines"] = [s for s in data["splines"] if s["until"] == 0]
    data["complete"] = False
    return written(tmp_path / "p.json", data)


def test_an_unfinished_plan_is_not_called_verified(unfinished: Path, tmp_path: Path) -> None:
    told = run("verify", unfinished)
    assert told.status == 6
    assert told.out.splitlines()[0] == "motion verified, goal not reached: (on far c.A)"
    answer = run("verify", unfinished, "--json")
    assert answer.status == 6
    found = answer.json()
    assert not found["verified"] and found["motion_verified"] and not found["complete"] and not found["goal_reached"]
    assert found["unmet"] == ["(on far c.A)"]
    assert run("report", unfinished, "-o", tmp_path / "r.html").status == 0
    page = (tmp_path / "r.html").read_text()
    assert 'class="verdict motion-verified-goal-not-reached"' in page and "(on far c.A)" in page


def test_a_refused_plan_that_is_unfinished_too_is_refused(unfinished: Path, tmp_path: Path) -> None:
    data = json.loads(unfinished.read_text())
    data["tracks"][0]["joints"][9][2] += 0.1
    told = run("verify", written(tmp_path / "q.json", data))
    assert told.status == 5 and told.out.startswith("refused\n")


def test_following_an_unfinished_plan_does_not_reach_the_goal(unfinished: Path, tmp_path: Path) -> None:
    told = run("run", unfinished, "--out", tmp_path / "out.json", "--json")
    found = told.json()
    assert told.status == 4 and found["status"] == "stuck"
    assert not found["verified"] and found["motion_verified"] and not found["goal_reached"]


def test_a_plan_for_the_scene_at_rest_says_so_whenever_it_is_checked(tmp_path: Path) -> None:
    text = TINY.replace("    crawler c", "    base stone: sphere(10 cm) at (9 m, 9 m, 9 m)\n"
                        "    moves stone along (1 m, 0, 0) at 1 m/s\n    crawler c")  # fmt: skip
    (tmp_path / "t.tamp").write_text(text)
    plan = tmp_path / "p.json"
    solved = run("solve", tmp_path / "t.tamp", "--out", plan, "--json")
    assert solved.status == 0 and solved.json()["at_rest"], solved
    told = run("verify", plan)
    assert told.status == 0 and told.out.startswith("verified, for the scene at rest: ")
    assert run("verify", plan, "--json").json()["at_rest"]
    run("report", plan, "-o", tmp_path / "r.html")
    assert "for the scene at rest" in (tmp_path / "r.html").read_text()


def test_a_run_of_what_is_proved_impossible_ends_with_3(tmp_path: Path) -> None:
    (tmp_path / "t.tamp").write_text(TINY.replace("= 0.5 m", "= 9 m"))
    told = run("run", tmp_path / "t.tamp", "--out", tmp_path / "p.json", "--json")
    assert told.status == 3 and told.json()["status"] == "infeasible", told
    assert told.json()["explanation"][0]["code"] == "S0001"
    assert run("solve", tmp_path / "t.tamp", "--out", tmp_path / "p.json").status == 3


# --- reports -----------------------------------------------------------------------------------------------------


def test_a_report_verifies_anew(good: Data, tmp_path: Path) -> None:
    data = json.loads(json.dumps(good))
    data["tracks"][0]["joints"][9][2] += 0.1
    assert data["verdict"]["verified"]
    path, page = written(tmp_path / "p.json", data), tmp_path / "r.html"
    told = run("report", path, "-o", page)
    assert told.status == 0 and "refused" in told.err
    assert 'class="verdict refused"' in page.read_text() and "leaves its spline" in page.read_text()
    read_plan(path).report(page)
    assert 'class="verdict refused"' in page.read_text()
    assert run("report", path, "-o", page, "--unchecked").status == 0
    text = page.read_text()
    assert 'class="verdict unchecked"' in text and "as stored in the file, not checked" in text
    assert 'class="verdict verified"' not in text and "verified (not checked)</title>" in text
    assert run("report", path, "-o", page, "--time", "0.001").status == 4


# --- refused plans -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("command", [["solve"], ["solve", "--solutions", "3"], ["solve", "--horizon", "1"]])
def test_a_refused_plan_is_kept_only_where_it_was_asked_for(
    command: list[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setitem(LIMITS, "position_m", -1.0)  # a verifier that believes no plan
    (tmp_path / "t.tamp").write_text(TINY)
    out, bad = tmp_path / "p.json", tmp_path / "bad.json"
    options = ["--time", "60", "--nodes", "600" if "--horizon" in command else "60", "--out", out, "--json"]
    told = run(command[0], tmp_path / "t.tamp", *command[1:], *options)
    found = told.json()
    assert told.status == 5 and found["status"] == "refused" and not found["verified"], told
    assert found["plan"] is None and found["plans"] == [] and found["refused"] is None
    assert {p.name for p in tmp_path.iterdir()} == {"t.tamp"}
    first = found["explanation"][0]
    assert first["code"] == "S0004" and "the verifier refuses the plan: " in first["message"]
    told = run(command[0], tmp_path / "t.tamp", *command[1:], *options, "--keep-refused", bad)
    assert {p.name for p in tmp_path.iterdir()} == {"t.tamp", "bad.json"}
    assert told.json()["refused"] == str(bad) and run("verify", bad).status == 5


def test_a_run_writes_no_refused_plan(good: Data, tmp_path: Path) -> None:
    data = json.loads(json.dumps(good))
    data["tracks"][0]["joints"][9][2] += 0.1
    path, out, bad = written(tmp_path / "p.json", data), tmp_path / "out.json", tmp_path / "bad.json"
    told = run("run", path, "--out", out, "--json")
    assert told.status == 5 and told.json()["plan"] is None and not out.exists()
    assert "leaves its spline" in told.json()["explanation"][0]["message"]
    told = run("run", path, "--out", out, "--keep-refused", bad)
    assert told.status == 5 and not out.exists() and f"refused plan: {bad}" in told.out and bad.exists()
    assert run("run", path, "--out", out, "--keep-refused", out).status == 2
