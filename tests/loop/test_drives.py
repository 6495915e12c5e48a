"""Joints without drives: nothing opens by itself, a hand moves what it holds, and the verifier measures both."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from tamplang.compiler.ir import Problem
from tamplang.compiler.pipeline import check_sources, compile_problem, compile_text
from tamplang.langs.source import Source
from tamplang.runtime.geometry.drives import _blocks, braked
from tamplang.runtime.plan import Plan
from tamplang.runtime.planner.lgp import Outcome, SolveOptions, solve
from tamplang.runtime.verify import verify
from tamplang.runtime.verify.drives import _two_ways

EXAMPLE = Path(__file__).parents[2] / "examples" / "mechanisms.tamp"
ALONE = """
import std.mechanisms
rule wish(H: handle, F: root) { pre (part H F), not (open H) post (open H), [drawn H F] }
task t() {
    object cabinet: box(0.3 m, 0.3 m, 0.1 m) at (1 m, 0, 0.05 m)
    drawer d: F on cabinet
    goal (open d.H)
}
"""
OWN_WORDS = """
import std.crawler
import std.rules
type handle < effector
type root < effector
module till {
    effector F: root box(2 mm, 2 mm, 2 mm) normal (0, 0, -1)
    joint slide: prismatic(x) in 0 m .. 30 cm
    link 10 cm: box(20 cm, 20 cm)
    effector H: handle sphere(2 cm) at (0, 0, 3 cm)
}
placement (A: root) on (Y: object) { (on Y A), [stable Y A] }
predicate (open H: effector)
motion [drawn H F: effector] { at switch dot(position(H) - position(F), (1, 0, 0)) >= 0.2 }
rule pull(F: root, H: handle) { pre not (open H) post (open H), [drawn H F] }
rule take(A: gripper, H: handle) { pre (free A) post [touch A H], [stable A H] }
task t() {
    base cabinet: box(0.3 m, 0.3 m, 0.1 m) at (1 m, 0, 0.05 m)
    till d: F on cabinet
    goal (open d.H)
}
task beside() {
    base cabinet: box(0.3 m, 0.3 m, 0.1 m) at (1 m, 0, 0.05 m)
    till d: F on cabinet
    base pedestal: box(0.3 m, 0.3 m, 0.1 m) at (0, 0, 0.05 m)
    crawler c: A on pedestal
    goal (open d.H)
}
"""
FOUR_BAR = """
import std.mechanisms
## A crank with a drive, a coupler and a rocker without, whose end turns on the floor.
module fourBar {
    effector F: root box(2 mm, 2 mm, 2 mm) normal (0, 0, -1)
    link 10 cm
    joint crank: revolute(y) in -180 deg .. 180 deg
    link 15 cm
    joint coupler: revolute(y) in -180 deg .. 180 deg home 1.190166 rad passive
    link 40 cm
    branch { link 10 cm effector tip: root sphere(1 mm) }
    joint rocker: revolute(y) in 0 deg .. 180 deg home 1.855549 rad passive
    link 30 cm
    joint pivot: revolute(y) in -300 deg .. 0 deg home -3.045715 rad passive
    effector P: root sphere(1 mm)
}
predicate (risen H: root)
motion [higher H F: effector] { at switch dot(position(H) - position(F), (0, 0, 1)) >= HEIGHT }
rule raise(H F: root) { pre not (risen H) post (risen H), [higher H F] }
task t() {
    object floor: box(2 m, 2 m, 0.1 m) at (0, 0, 0)
    fourBar b: F on floor
    fact [stable floor b.P]
    goal (risen b.tip)
    options { margin = 0 }
}
"""


def solved(problem: Problem) -> Plan:
    outcome = solve(problem, SolveOptions(seed=problem.seed, time=60.0))
    assert outcome.status == "solved"
    verdict = outcome.plans[0].verdict
    assert verdict is not None and verdict.verified
    return outcome.plans[0]


def refused(text: str, task: str | None = None) -> Outcome:
    outcome = solve(compile_text(text, task=task)[0], SolveOptions(time=60.0))
    assert outcome.status == "exhausted"
    return outcome


@pytest.fixture(scope="module")
def plan() -> Plan:
    return solved(compile_problem(EXAMPLE, "drawer")[0])


def values(plan: Plan, module: str, phase: int) -> np.ndarray:
    """All stored values `(T, n)` of a module's joints in a phase."""
    (track,) = (t for t in plan.tracks if t.name == module)
    times, own = np.array(plan.times), plan.phases[phase]
    ends = [i for i in range(len(times) - 1) if times[i] == times[i + 1]]
    first, last = [0, *(i + 1 for i in ends)][phase], [*ends, len(times) - 1][phase]
    assert (times[first], times[last]) == (own.start, own.end)
    return np.array(track.joints)[first : last + 1]


def test_nothing_opens_by_itself() -> None:
    (told,) = refused(ALONE).explanation
    assert told.code == "S0002" and "[drawn d.H d.F] is missed" in told.message
    assert "slide of d cannot move: no drive" in (told.note or "")
    (warning,) = check_sources([Source("alone.tamp", ALONE)])
    assert warning.code == "W0013" and warning.span is not None and "`slide` of `d`" in warning.message


def test_what_has_no_end_behind_its_joint_is_told_whatever_rules_there_are() -> None:
    """The rules of std.mechanisms take hold of other things; a flap without a handle they cannot."""
    text = """import std.mechanisms
import std.crawler
module flap {
    effector F: root box(2 mm, 2 mm, 2 mm) normal (0, 0, -1)
    link 10 cm
    joint h: revolute(y) in 0 deg .. 90 deg passive
    link 10 cm: capsule(1 cm)HANDLE
}
task t {
    base ground: box(2 m, 2 m, 2 cm) at (0, 0, 0)
    crawler c: A on ground
    flap f: F on ground at (60 cm, 0)
    drawer d: F on ground at (-60 cm, 0)
    goal (open d.H)
}"""
    (told,) = (d for d in check_sources([Source("t.tamp", text.replace("HANDLE", ""))]) if d.code == "W0013")
    assert "`h` of `f`: no effector lies behind" in told.message
    held = text.replace("HANDLE", "\n    effector H: knob sphere(1 cm)")
    assert "W0013" not in {d.code for d in check_sources([Source("t.tamp", held)])}


def test_what_the_rules_have_moved_by_others_only_has_no_drives() -> None:
    assert "slide of d cannot move: no drive" in (refused(OWN_WORDS, "t").explanation[0].note or "")
    problem, warnings = compile_text(OWN_WORDS, task="beside")
    assert [w.code for w in warnings] == ["W0021"] and "`till`" in warnings[0].message
    modules = problem.world.modules
    assert all(j.passive for j in modules["d"].type.joints) and not any(j.passive for j in modules["c"].type.joints)


@pytest.mark.parametrize("other", [("30 cm\n", "30 cm speed 0.1 m/s\n"), ("[touch A H], [stable A H]", "[touch A H]")])
def test_a_speed_or_something_that_it_does_says_that_a_module_has_drives(other: tuple[str, str]) -> None:
    problem, warnings = compile_text(OWN_WORDS.replace(*other), task="beside")
    assert warnings == () and not any(j.passive for j in problem.world.modules["d"].type.joints)


def test_a_drawer_opens_while_a_hand_holds_it_and_stays_then(plan: Plan) -> None:
    assert [p.rule for p in plan.phases] == ["take", "pullOut", "release"] and plan.needs == ["passive"]
    taken, pulled, released = (values(plan, "d", k)[:, 0] for k in range(3))
    assert np.ptp(taken) == 0.0 and taken[0] == 0.0 and np.ptp(released) == 0.0
    assert pulled[-1] >= 0.1 - 1e-6 and released[0] == pulled[-1]


@pytest.mark.parametrize("task", ["door", "sliding", "lever", "lid", "buttons"])
def test_every_mechanism_is_worked_by_a_hand(task: str) -> None:
    problem, warnings = compile_problem(EXAMPLE, task, seed=1)
    found = solved(problem)
    assert warnings == () and found.verdict is not None
    assert max(found.verdict.worst.get(f"undriven_{unit}", 0.0) for unit in ("m", "rad")) <= 1e-9


def test_a_four_bar_is_driven_through_joints_that_have_no_drive() -> None:
    found = solved(compile_text(FOUR_BAR.replace("HEIGHT", "0.46"))[0])
    assert np.ptp(values(found, "b", 0), axis=0).min() > 0.01


def test_a_four_bar_whose_crank_has_no_drive_stands_still() -> None:
    text = FOUR_BAR.replace("HEIGHT", "0.46").replace("180 deg\n    link 15", "180 deg passive\n    link 15")
    assert "crank, coupler, rocker, pivot of b cannot move" in str([d.note for d in refused(text).explanation])


# --- the verifier --------------------------------------------------------------------------------------------------


def open_early(data: dict[str, Any]) -> None:
    """The drawer opens, within its limits, while the hand is still on its way: splines, samples and all."""
    ends = [i for i in range(len(data["times"]) - 1) if data["times"][i] == data["times"][i + 1]]
    first = data["phases"][0]
    times = np.array(data["times"][: ends[0] + 1])
    share = (times - times[0]) / (times[-1] - times[0])
    (track,) = (t for t in data["tracks"] if t["name"] == "d")
    rows = 4e-4 * 16 * share**2 * (1 - share) ** 2
    track["joints"][: ends[0] + 1] = [[float(v)] for v in rows]
    knots = np.linspace(first["start"], first["end"], len(times))
    data["splines"].append({"module": "d", "from": 0, "until": 0, "knots": knots.tolist(),
                            "values": [[float(v)] for v in rows]})  # fmt: skip


def give_a_drive(data: dict[str, Any]) -> None:
    (module,) = (m for m in data["modules"] if m["name"] == "d")
    module["joints"][0].pop("passive")


def need_nothing(data: dict[str, Any]) -> None:
    data["needs"] = []


@pytest.mark.parametrize(
    ("change", "kind"), [(open_early, "undriven_m"), (give_a_drive, "scene"), (need_nothing, "structure")]
)
def test_a_plan_in_which_a_drawer_moves_by_itself_is_refused(
    plan: Plan, change: Callable[[dict[str, Any]], None], kind: str
) -> None:
    data = msgspec.to_builtins(plan)
    change(data)
    verdict = verify(msgspec.convert(data, Plan))
    assert not verdict.verified and kind in {f.kind for f in verdict.failures}


@pytest.mark.parametrize("seed", range(40))
def test_planner_and_verifier_find_the_same_rings(seed: int) -> None:
    """Blocks of the planner against pairs of ways of the verifier, on random graphs with parallel edges."""
    random = np.random.default_rng(seed)
    count = int(random.integers(2, 7))
    edges = [tuple((f"n{i}", -1) for i in random.integers(0, count, 2)) for _ in range(random.integers(1, 11))]
    edges = [(a, b) for a, b in edges if a != b]
    block = _blocks(edges)
    for one, other in combinations(range(len(edges)), 2):
        rest = [e for k, e in enumerate(edges) if k not in (one, other)]
        assert (block[one] == block[other]) == _two_ways(rest, edges[one], edges[other])


def test_only_what_a_hand_holds_is_free() -> None:
    problem, _ = compile_problem(EXAMPLE, "buttons")
    mode = problem.init_motion
    assert braked(problem, mode) == {"b[1]": frozenset({0}), "b[2]": frozenset({0})}
    held = mode | {("stable", "c.B", "b[2].H")}
    assert braked(problem, frozenset(held)) == {"b[1]": frozenset({0}), "b[2]": frozenset()}
