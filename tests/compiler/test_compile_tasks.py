"""Tasks from text to problem: parameters, seeds, several tasks, texts without a disk, large scenes."""

from __future__ import annotations

import re
import subprocess
import sys
import time
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tamplang.compiler import ir
from tamplang.compiler.pipeline import UsageError, check, compile_problem, compile_sources, compile_text
from tamplang.compiler.printing import format_ast, format_ir
from tamplang.compiler.scenes.parameters import parse_value
from tamplang.langs.diagnostics import SourceError
from tamplang.langs.parser import parse
from tamplang.langs.source import Source

ROOT = Path(__file__).parents[2]
CLIMB = ROOT / "examples" / "climb.tamp"
PICK = ROOT / "examples" / "pick_and_place.tamp"


def test_parameters_and_seed() -> None:
    problem, warnings = compile_problem(CLIMB, parameters={"n": "3", "crawlers": "1"}, seed=4)
    assert not warnings
    assert problem.parameters == {"n": 3, "crawlers": 1}
    assert list(problem.world.bodies) == ["ground", "stair[1]", "stair[2]", "stair[3]", "target"]
    assert list(problem.objects) == [*problem.world.bodies, "c[1]", "c[1].A", "c[1].B"]
    assert problem.options == ir.Options(bound="path", time=60)
    assert problem == compile_problem(CLIMB, parameters={"n": "3", "crawlers": "1"}, seed=4)[0]
    other = compile_problem(CLIMB, parameters={"n": "3", "crawlers": "1"}, seed=5)[0]
    assert other.world.bodies["stair[1]"] != problem.world.bodies["stair[1]"]
    assert other.world.bodies["ground"] == problem.world.bodies["ground"]
    for i in range(1, 4):
        x, _, z, *_ = problem.world.bodies[f"stair[{i}]"].pose
        assert abs(x - 0.35 * i) <= 0.03
        assert abs(z - 0.20 * i) <= 0.03


def test_results_do_not_depend_on_hash_order() -> None:
    script = (
        "from tamplang.compiler.pipeline import compile_problem; from tamplang.compiler.printing import format_ir; "
        f"print(format_ir(compile_problem({str(CLIMB)!r})[0]))"
    )
    texts = {
        subprocess.run(
            [sys.executable, "-c", script], env={"PYTHONHASHSEED": seed, "PYTHONPATH": str(ROOT)},
            capture_output=True, text=True, check=True,
        ).stdout
        for seed in ("1", "2")
    }  # fmt: skip
    assert len(texts) == 1


def test_goal_loops_are_written_out() -> None:
    problem, _ = compile_problem(PICK, parameters={"objects": "2"})
    assert problem.goal == ir.And(
        tuple(ir.Literal("on", (ir.Object("goal_tray"), ir.Object(f"item[{i}]"))) for i in (1, 2))
    )


def test_the_sources_of_a_problem_compile_again_without_a_disk(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    first, _ = compile_problem(CLIMB, parameters={"n": "4"}, seed=2)
    assert [s.path for s in first.sources[1:]] == [
        f"std/{name}.tamp" for name in ("crawler", "motion", "logic", "rules", "heuristics", "scenes")
    ]
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("tamplang.compiler.imports.STANDARD_FOLDER", tmp_path)
    again, _ = compile_sources(first.sources, "climb", {"n": "4"}, 2)
    assert again == first


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"m": "3"}, "no parameter `m`; did you mean `n`|it has n, crawlers"),
        ({"crawler": "3"}, "did you mean `crawlers`"),
        ({"n": "three"}, "`three` is not a number"),
        ({"n": "2.5"}, "whole number, not `2.5`"),
        ({"n": "3 m"}, "whole number, not `3 m`"),
        ({"n": ""}, "is not a number"),
    ],
)
def test_unfit_parameters(parameters: dict[str, str], message: str) -> None:
    with pytest.raises(UsageError, match=message):
        compile_problem(CLIMB, parameters=parameters)


@pytest.mark.parametrize(
    ("kind", "text", "value"),
    [("length", "20 cm", 0.2), ("length", "0.2m", 0.2), ("length", "-3e2 mm", -0.3), ("length", "0", 0),
     ("angle", "180 deg", 3.141592653589793), ("real", "2.5", 2.5), ("int", " 8 ", 8), ("int", "1e2", 100)],
)  # fmt: skip
def test_values_of_the_command_line(kind: str, text: str, value: float) -> None:
    assert parse_value("p", kind, text) == pytest.approx(value)


@pytest.mark.parametrize(
    ("kind", "text"),
    [("length", "0.2"), ("length", "2 deg"), ("length", "2 mm/s"), ("real", "2 m"), ("angle", "90"), ("real", "1e999"),
     ("real", "nan")],
)  # fmt: skip
def test_values_with_the_wrong_unit(kind: str, text: str) -> None:
    with pytest.raises(UsageError):
        parse_value("p", kind, text)


@given(st.text(max_size=12), st.sampled_from(["int", "real", "length", "angle"]))
def test_any_text_is_a_value_or_a_usage_error(text: str, kind: str) -> None:
    try:
        assert abs(parse_value("p", kind, text)) < float("inf")
    except UsageError as error:
        assert "`p`" in str(error)


TWO = """import std.logic
task one() { base b: box(1 m, 1 m, 1 m) at (0, 0, 0) fact (grippable b) goal (grippable b) }
task two() { base b: box(1 m, 1 m, 1 m) at (0, 0, 0) fact (tray b) goal (tray b) }
import std.motion
"""


def test_several_tasks() -> None:
    with pytest.raises(UsageError, match="several tasks; name one: one, two"):
        compile_text(TWO)
    assert compile_text(TWO, task="two")[0].task == "two"
    assert compile_text(TWO, name="two.tamp")[0].task == "two"
    with pytest.raises(UsageError, match="no task `tow`; did you mean `two`"):
        compile_text(TWO, task="tow")
    with pytest.raises(UsageError, match="has no task"):
        compile_text("type a < object\n")


def test_a_parameter_without_default_needs_a_value() -> None:
    task = "task t(n: int) { base b[n]: box(1 m, 1 m, 1 m) at (0, 0, 0) fact (tray b[n]) goal (tray b[n]) }"
    text = f"import std.motion\n{task}\n"
    assert list(compile_text(text, parameters={"n": "4"})[0].world.bodies) == ["b[4]"]
    with pytest.raises(UsageError, match="parameter `n` of task `t` has no default"):
        compile_text(text)


def test_errors_are_raised_together() -> None:
    with pytest.raises(SourceError) as error:
        compile_text("import std.motion\ntype a < b\nrule r(A: c) { pre (support A) post not (suport A) }\n")
    assert [d.code for d in error.value.diagnostics] == ["E0102", "E0102", "E0103"]


def large(n: int) -> str:
    return f"""import std.crawler
import std.rules
task t(n: int = {n}) {{
    base ground: box(2 m, 2 m, 0.05 m) at (0, 0, 0)
    for i in 1 .. n {{
        object item[i]: box(0.3 m, 0.3 m, 0.05 m) at (0.35 m * i, 3 m + jitter(1 cm), 0.2 m * i)
        fact (grippable item[i])
    }}
    fact (tray ground)
    crawler c: A on ground
    goal forall i in 1 .. n {{ (on ground item[i]) }}
}}
"""


def test_a_thousand_bodies_compile_quickly() -> None:
    compile_text(large(2))
    begin = time.process_time()
    problem, _ = compile_text(large(1024))
    assert time.process_time() - begin < 3
    assert sum(b.movable for b in problem.world.bodies.values()) == 1024


def test_check_loads_no_numerics_for_a_clean_example() -> None:
    script = (
        "import sys; from tamplang.compiler.pipeline import check; "
        f"assert not check({str(CLIMB)!r}); "
        "print([m for m in ('numpy', 'scipy', 'casadi', 'coal', 'pinocchio') if m in sys.modules])"
    )
    process = subprocess.run(
        [sys.executable, "-c", script], env={"PYTHONPATH": str(ROOT)}, capture_output=True, text=True, check=True
    )
    assert process.stdout.strip() == "[]"


def test_unreadable_files_are_diagnostics(tmp_path: Path) -> None:
    empty = tmp_path / "empty.tamp"
    empty.write_text("")
    assert [d.code for d in check(empty)] == ["E0013"]
    assert [d.code for d in check(tmp_path / "none.tamp")] == ["E0010"]
    with pytest.raises(SourceError):
        compile_problem(tmp_path)


def test_stages_print() -> None:
    problem, _ = compile_problem(CLIMB, parameters={"n": "2", "crawlers": "1"})
    text = format_ir(problem)
    for line in (
        "rule connect(p: chain of module by connected, q: chain of module by connected)",
        "  post for i: 1 .. length(c) - 1 { not [stable c[i].out c[i + 1].in], [stable c[i + 1].in c[i].out] }",
        "  at switch position(Y) - position(X) = (radius(X) + radius(Y)) * axis(X, z)  # 3 rows",
        "  (on X: object, A: object) functional in A",
        "  step: distance(Y, target) - distance(X, target)",
        "  [stand c[1].A ground]",
    ):
        assert line in text.splitlines()
    tree = format_ast(parse(Source("t", "type a < object\n"))[0])
    assert "TypeDecl name='a' parent='object' doc=''" in tree


RANGED = "task t(n: int in 1 .. 4 = 2, size: length in 1 cm .. 1 m = 1 m) { goal n = 2 and size = 1 m }"


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"n": "0"}, "parameter `n` must be 1 .. 4, not 0"),
        ({"n": "-3"}, "parameter `n` must be 1 .. 4, not -3"),
        ({"size": "2 m"}, "parameter `size` must be 0.01 .. 1 m, not 2 m"),
    ],
)
def test_values_outside_of_the_range_of_a_parameter(parameters: dict[str, str], message: str) -> None:
    with pytest.raises(UsageError, match=re.escape(message)):
        compile_text(RANGED, parameters=parameters)


def test_values_inside_of_the_range_of_a_parameter() -> None:
    problem, _ = compile_text(RANGED, parameters={"n": "4", "size": "20 cm"})
    assert problem.parameters == {"n": 4, "size": 0.2}


@pytest.mark.parametrize(
    ("example", "parameters"),
    [
        ("quadruped", {"steps": "1"}),
        ("quadruped", {"steps": "2"}),
        ("chain_climb", {"scattered": "1"}),
        ("chain_climb", {"missing": "1"}),
        ("strut_bridge", {"struts": "0"}),
        ("rendezvous", {"gap": "1.5 m"}),
        ("mobile_manipulator", {"objects": "64", "height": "2 m"}),
        ("terraces", {"width": "1.7 m"}),
    ],
)
def test_examples_compile_whatever_their_parameters(example: str, parameters: dict[str, str]) -> None:
    problem, _ = compile_problem(ROOT / "examples" / f"{example}.tamp", None, parameters)
    assert problem.parameters.keys() >= parameters.keys()
    assert problem.goal != ir.And(())
