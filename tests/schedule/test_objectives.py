"""What may be minimised, and what is told about objectives that make no sense."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tamplang.api import load, loads
from tamplang.cli import run
from tamplang.compiler.objective_terms import spelled
from tamplang.compiler.pipeline import compile_text
from tamplang.langs.diagnostics import SourceError, UsageError

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
TASK = """
predicate (lit)
rule light() {{ pre not (lit) post (lit) }}
task t(w: real = 2) {{ goal (lit) options {{ {} }} }}
"""


@pytest.mark.parametrize(
    ("text", "meant"),
    [
        ("makespan", "makespan"),
        ("travel * 2 + makespan", "makespan + 2 * travel"),
        ("0.5 * (makespan + 4 * travel) + makespan / 2", "makespan + 2 * travel"),
        ("3 * actions - actions", "2 * actions"),
    ],
)
def test_sums_of_measures(text: str, meant: str) -> None:
    assert str(spelled(text)) == meant


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("time", "E0212"), ("makespn + travel", "E0212"), ("2 * makespn", "E0212"),
        ("makespan + 3 s", "E0215"), ("makespan + 2", "E0215"), ("2 m * travel", "E0215"),
        ("makespan * travel", "E0215"), ("1 / makespan", "E0215"),
        ("-makespan", "E0214"), ("makespan - travel", "E0214"), ("0 * travel", "E0214"),
        ("makespan / 0", "E0211"), ("", "E0210"), ("makespan } goal (lit", "E0210"), ("makespan, time = 3 s", "E0210"),
    ],
)  # fmt: skip
def test_what_is_no_objective_has_a_code(text: str, code: str) -> None:
    with pytest.raises(UsageError) as caught:
        spelled(text)
    assert caught.value.diagnostic is not None and caught.value.diagnostic.code == code


@pytest.mark.parametrize("entry", ["minimise = makespan + w * travel", "minimise makespan + w * travel"])
def test_a_task_states_its_objective_with_its_parameters(entry: str) -> None:
    problem, _ = compile_text(TASK.format(entry), parameters={"w": "3"})
    assert str(problem.options.minimise) == "makespan + 3 * travel"


@pytest.mark.parametrize(
    ("entry", "code"),
    [("minimise = speed", "E0212"), ("minimise = makespan - w * travel", "E0214"), ("minimise = travel + 1 m", "E0215"),
     ("minimise = energy", "E0524"), ("gap = -1", "E0210"), ("gap = 2 m", "E0203")],
)  # fmt: skip
def test_a_task_is_told_where_its_objective_is_wrong(entry: str, code: str) -> None:
    with pytest.raises(SourceError) as caught:
        compile_text(TASK.format(entry))
    (found,) = (d for d in caught.value.diagnostics if d.is_error)
    assert found.code == code and found.span is not None and found.span.line == 4


@pytest.mark.parametrize("gap", ["-1", "nan", "inf", "1 s", "٣"])
def test_a_gap_is_a_number_from_zero(gap: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["solve", str(EXAMPLES / "climb.tamp"), "--gap", gap]) == 2
    assert "--gap" in capsys.readouterr().err
    with pytest.raises(UsageError, match="`gap` is a number from 0"):
        loads(TASK.format("time = 5 s")).solve(gap=-1.0)


def test_energy_needs_physics(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(UsageError, match="physics"):
        loads(TASK.format("time = 5 s")).solve(minimise="energy")
    file = tmp_path / "t.tamp"
    file.write_text(TASK.format("time = 5 s"), encoding="utf-8")
    assert run(["solve", str(file), "--minimise", "energy"]) == 2
    assert "E0524" in capsys.readouterr().err
    assert run(["solve", str(file), "--minimise", "makespn"]) == 2
    assert "E0212" in capsys.readouterr().err and not list(tmp_path.glob("*.json"))


def test_the_value_is_told_with_bounds_and_gap(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    arguments = ["solve", str(EXAMPLES / "climb.tamp"), "-p", "n=4", "--json", "--quiet"]
    assert run([*arguments, "--minimise", "makespan + 0.1 * travel + 2 * actions"]) == 0
    told = json.loads(capsys.readouterr().out)
    objective, measures = told["objective"], told["objective"]["measures"]
    value = measures["makespan"] + 0.1 * measures["travel"] + 2.0 * measures["actions"]
    assert objective["value"] == pytest.approx(value)
    assert measures["actions"] == told["cost"]
    for claim, bound in objective["bounds"].items():
        assert 0.0 < bound <= objective["value"]
        assert objective["gap"][claim] == pytest.approx(objective["value"] - bound)


def test_what_is_lighter_is_looked_for_behind_refused_candidates() -> None:
    """Two crawlers are the first to come up, slow under their weight; four candidates later one alone does it."""
    task = load(EXAMPLES / "real_climb.tamp")
    (plan,) = task.solve(minimise="duration", time=300.0).plans
    assert {phase.rule for phase in plan.record.phases} == {"step", "grasp"} and plan.record.times[-1] < 10.0
    assert len({module for module, *_ in (phase.action.split("(")[1].split(".") for phase in plan.record.phases)}) == 1


def test_plans_without_an_objective_are_what_they_were(tmp_path: Path) -> None:
    task = load(EXAMPLES / "climb.tamp", n=4)
    plain, asked = task.solve(time=60), task.solve(time=60, minimise="actions")
    assert plain.plan is not None and asked.plan is not None
    plain.plan.save(tmp_path / "plain.json")
    asked.plan.save(tmp_path / "asked.json")
    texts = [json.loads((tmp_path / f"{name}.json").read_text()) for name in ("plain", "asked")]
    assert all(text.pop("timing") for text in texts)
    assert texts[0] == texts[1] and "objective" not in texts[0]["statistics"]


def test_windows_have_no_gap(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["solve", str(EXAMPLES / "climb.tamp"), "--horizon", "2", "--gap", "1"]) == 2
    assert "--gap" in capsys.readouterr().err


@pytest.mark.parametrize(("way", "seconds"), [(0.0, 0.0), (0.8, 0.8), (2.0, 1.4)])
def test_the_least_time_of_a_way_from_rest_to_rest(way: float, seconds: float) -> None:
    """At 2 rad/s and 5 rad/s²: 0.8 rad are reached without ever being at full speed."""
    from tamplang.compiler.ir import IDENTITY, Joint, JointKind
    from tamplang.runtime.planner.schedule.least_times import least_time

    joint = Joint("j", JointKind.REVOLUTE, -1, IDENTITY, (0, 0, 1), -3.0, 3.0, 0.0, 2.0, 5.0)
    assert least_time(joint, way) == pytest.approx(seconds)


def test_a_straight_way_takes_the_least_time_by_the_fastest_law() -> None:
    import numpy as np

    from tamplang.runtime.planner.schedule.time_optimal import fastest

    ones = np.ones((101, 1))
    for way, seconds in ((0.8, 0.8), (2.0, 1.4)):
        law = fastest(way * ones, 0.0 * ones, 2.0 * ones, 5.0 * ones)
        assert law is not None and law.duration == pytest.approx(seconds, rel=2e-3)
        shares = law.smoothed(0.05, 200)
        bends = np.diff(shares, 2)
        assert shares[0] == 0.0 and shares[-1] == 1.0 and (np.diff(shares) >= 0.0).all()
        assert abs(bends[0]) < 0.2 * np.abs(bends).max() and abs(bends[-1]) < 0.2 * np.abs(bends).max()
