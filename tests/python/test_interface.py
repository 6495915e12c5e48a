"""The Python interface: names, errors, plans as arrays."""

from __future__ import annotations

import doctest
import math
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pandas
import pytest
from msgspec.structs import replace

import tamplang
from tamplang import api, texts
from tamplang.runtime.plan_files import PlanFileError

PLAN = Path(__file__).resolve().parents[1] / "verify" / "format_1.plan.json"
LAMP = "predicate (lit) rule light() { pre not (lit) post (lit) } task t() { goal (lit) }"


def test_every_name_is_listed_and_there() -> None:
    assert set(tamplang.__all__) <= set(dir(tamplang))
    assert all(getattr(tamplang, name) is not None for name in tamplang.__all__)
    with pytest.raises(AttributeError):
        tamplang.lod  # noqa: B018


def test_what_users_can_mend_has_one_base(tmp_path: Path) -> None:
    (tmp_path / "a.json").write_text("[]")
    for wrong in (
        lambda: tamplang.loads("task t() {"),
        lambda: tamplang.load(tmp_path / "lost.tamp"),
        lambda: tamplang.loads(LAMP, task="u"),
        lambda: tamplang.loads(LAMP).solve(bound="paht"),
        lambda: tamplang.read_plan(tmp_path / "a.json"),
        lambda: tamplang.read_plan(PLAN).poses("c[9]"),
        lambda: tamplang.read_plan(PLAN).trajectory("nobody"),
    ):
        with pytest.raises(tamplang.Error):
            wrong()
    assert tamplang.PlanFileError is PlanFileError
    for raised in (tamplang.MissingLibrary, tamplang.OutOfTime, tamplang.ClusterUnavailable):
        assert issubclass(raised, tamplang.Error)
    with pytest.raises(tamplang.ClusterUnavailable):
        tamplang.loads(LAMP).solve(cluster="tcp://127.0.0.1:9")


def test_plans_are_equal_that_do_the_same_in_the_same_task(tmp_path: Path) -> None:
    climb = Path(tamplang.__file__).resolve().parents[1] / "examples" / "climb.tamp"
    found, other = (tamplang.load(climb, n=n, crawlers=1).solve().plan for n in (1, 2))
    assert found is not None and other is not None
    found.save(tmp_path / "a.json")
    read = tamplang.read_plan(tmp_path / "a.json")
    assert read == found and hash(read) == hash(found) and not read.verified
    assert tamplang.load(climb, n=1, crawlers=1).solve(search="bfs").plan in {found}
    track = found.record.tracks[0]
    moved = replace(track, joints=[*track.joints[:-1], [q + 1e-9 for q in track.joints[-1]]])
    assert found != tamplang.Plan(replace(found.record, tracks=[moved, *found.record.tracks[1:]]), fresh=True)
    assert found != other and found != found.record and found != "a.json"


def test_a_wrong_value_of_an_option_is_told_with_the_near_ones() -> None:
    with pytest.raises(tamplang.UsageError, match="did you mean `path`"):
        tamplang.loads(LAMP).solve(bound="paht")
    lamp = tamplang.loads(LAMP)
    for wrong, word in (
        (lambda: lamp.solve(horizon="atuo"), "did you mean `auto`"),
        (lambda: lamp.solve(jobs=0), "whole number from 1"), (lambda: lamp.run(bound="path"), "no option `bound`"),
        (lambda: lamp.run(horizn=3), "did you mean `horizon`"), (lambda: lamp.run(horizon=0), "whole number from 1"),
    ):  # fmt: skip
        with pytest.raises(tamplang.UsageError, match=word):
            wrong()


@pytest.mark.parametrize(("before", "after"), [({}, "1"), ({"OPENBLAS_NUM_THREADS": "3"}, "3")])
def test_numerical_libraries_have_one_thread_unless_told_otherwise(before: dict[str, str], after: str) -> None:
    program = f"import os, tamplang; tamplang.loads({LAMP!r}); print(os.environ['OPENBLAS_NUM_THREADS'])"
    root = str(Path(__file__).resolve().parents[2])
    process = subprocess.run(
        [sys.executable, "-c", program], env={"PYTHONPATH": root, **before}, capture_output=True, text=True, timeout=60
    )
    assert process.stdout.strip() == after, process.stderr


def test_texts_are_loaded_and_shown_in_short() -> None:
    assert doctest.testmod(api, extraglobs={"loads": tamplang.loads}).failed == 0
    plan = tamplang.read_plan(PLAN)
    assert not plan.verified and plan.verify().verified
    assert len(repr(plan)) < 100 and plan.record.task.name in repr(plan)
    assert plan.actions[0].split("(")[0] in plan._repr_html_()
    light = "predicate (lit) rule light() { pre not (lit) post (lit) }"
    lit = f"{light} task t() {{ object b: sphere(1 cm) at (0, 0, 0) goal (lit) }}"
    assert repr(tamplang.loads(lit)) == "<Task t: 0 modules, 1 body>"


def test_motion_comes_as_arrays() -> None:
    plan = tamplang.read_plan(PLAN)
    module = plan.record.modules[0]
    motion = plan.trajectory(module.name, rate=20.0)
    assert motion.q.shape == motion.dq.shape == motion.ddq.shape == (len(motion.t), len(module.joints))
    assert motion.q[0] == pytest.approx(module.start, abs=1e-6)
    poses = plan.poses(module.name, rate=20.0)
    assert poses.shape == (len(motion.t), 7) and np.allclose(np.linalg.norm(poses[:, 3:], axis=1), 1.0)
    assert plan.poses(f"{module.name}.{module.effectors[0].name}").shape[1] == 7


def test_texts_are_made_from_values() -> None:
    assert doctest.testmod(texts).failed == 0
    assert tamplang.fill("$a and $b", a=np.array([1.5, 2.0]), b="c[1].A") == "(1.5, 2.0) and c[1].A"
    for template, values in (
        ("$a", {}), ("$a", {"b": 1}), ("$a", {"a": 1, "b": 2}), ("$a", {"a": "x) (y"}), ("$a", {"a": math.nan}),
        ("$a", {"a": True}), ("$a", {"a": None}), ("$a", {"a": {"x": 1}}),
    ):  # fmt: skip
        with pytest.raises(tamplang.UsageError):
            tamplang.fill(template, **values)
    with pytest.raises(tamplang.UsageError, match="did you mean `size`"):
        tamplang.fill("$sise", size=1)


def test_plans_are_taken_from_files_and_written_for_others(tmp_path: Path) -> None:
    plan = tamplang.read_plan(PLAN)
    plan.compare(str(PLAN), tmp_path / "both.html", unchecked=True)
    assert (tmp_path / "both.html").read_text().count("<iframe") == 2
    with pytest.raises(tamplang.PlanFileError):
        plan.compare(tmp_path / "lost.json", tmp_path / "both.html")
    plan.export("csv", tmp_path / "a.csv", rate=10.0)
    frame = plan.to_dataframe(rate=10.0)
    read = pandas.read_csv(tmp_path / "a.csv", index_col="time")
    pandas.testing.assert_frame_equal(read, frame)
    with pytest.raises(tamplang.UsageError, match="did you mean `csv`"):
        plan.export("csf", tmp_path / "a.csf")


def test_a_missing_extra_is_told_with_its_code(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(tamplang.MissingLibrary, match=r"S0015.*pandas") as raised:
        tamplang.read_plan(PLAN).to_dataframe()
    assert "tamplang[notebook]" in raised.value.hint


def test_progress_goes_to_functions_and_to_bars() -> None:
    class Bar:
        n, total = 0.0, None

        def update(self, more: float) -> None:
            self.n += more

    bar, steps = Bar(), []
    tamplang.loads(LAMP).solve(time=20.0, progress=bar)
    tamplang.loads(LAMP).solve(progress=steps.append)
    assert bar.total == 20.0 and 0.0 < bar.n < 20.0 and steps
    with pytest.raises(tamplang.UsageError, match="progress"):
        tamplang.loads(LAMP).solve(progress=3)


def test_a_traceback_ends_with_what_the_terminal_shows() -> None:
    with pytest.raises(tamplang.SourceError) as raised:
        tamplang.loads("rule light( { post (lit) }")
    (note,) = raised.value.__notes__
    assert "error[E0005]" in note and "rule light( { post (lit) }" in note and "^" in note


@pytest.mark.parametrize(
    ("options", "word"),
    [
        ({"noise": 3}, "tamplang.Noise"), ({"engine": "mujco"}, "did you mean `mujoco`"),
        ({"latency": -1}, "seconds from 0"), ({"seed": "a"}, "whole"), ({"seed": -1}, "whole number from 0"),
        ({"plan": 3}, "a plan is a `tamplang.Plan` or the name of its file"),
    ],
)  # fmt: skip
def test_what_a_run_does_not_take_is_told(options: dict[str, object], word: str) -> None:
    run: Any = tamplang.loads(LAMP).run
    with pytest.raises(tamplang.UsageError, match=word):
        run(**options)


def test_what_is_no_program_and_no_seed_is_told() -> None:
    loads: Any = tamplang.loads
    with pytest.raises(tamplang.UsageError, match="a program is a text"):
        loads(None)
    with pytest.raises(tamplang.UsageError, match="a seed is a whole number"):
        loads(LAMP, seed="a")
    with pytest.raises(tamplang.UsageError, match="`found` is called"):
        tamplang.loads(LAMP).solve(found=3)  # type: ignore[arg-type]
    with pytest.raises(tamplang.UsageError, match="`joint` of a noise is a number from 0, not -1"):
        tamplang.Noise(joint=-1)
    with pytest.raises(tamplang.UsageError, match="`drive` of a noise"):
        tamplang.Noise(drive=None)  # type: ignore[arg-type]
    assert tamplang.Noise(drive=0.0).drive == 0.0 and "_HOMES" not in dir(tamplang)


def test_what_plans_do_not_take_is_told() -> None:
    asked: Any = tamplang.read_plan(PLAN)
    for ask, told in [
        (lambda: asked.trajectory(1), "the plan has no module `1`"),
        (lambda: asked.poses("lamp", rate="fast"), "a rate is a number of hertz above 0, not 'fast'"),
        (lambda: asked.verify(time=-1), "a number of seconds above 0, not -1"),
        (lambda: asked.verify(against=3), "a plan is checked against a `tamplang.Task`, not 3"),
        (lambda: asked.compare(3, "never.html"), "a plan is a `tamplang.Plan` or the name of its file, not 3"),
    ]:
        with pytest.raises(tamplang.UsageError, match=re.escape(told)):
            ask()
