"""Every export, read back by tools of others, of plans of five kinds."""

from __future__ import annotations

import re
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from shutil import copytree

import pytest
from click.testing import CliRunner

import tamplang
from tamplang.cli.app import application
from tamplang.runtime.plan import Plan

from .readers import check_bag, check_mjcf, check_rates, check_ros2, check_tables, check_urdf

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "examples"
WEDGE = ((0, 0, 0), (0.03, 0, 0), (0, 0.03, 0), (0, 0, 0.03))


def solved(task: tamplang.Task) -> Plan:
    result = task.solve(time=300.0)
    assert result.plan is not None, result.explanation
    return result.plan.record


def mesh_arm(folder: Path) -> Plan:
    """The arm of the tests with a mesh for one of its shapes."""
    copytree(ROOT / "tests" / "programs" / "good", folder / "good")
    lines = ["solid wedge"]
    for a, b, c in ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)):
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += ["vertex " + " ".join(map(str, WEDGE[i])) for i in (a, b, c)] + ["endloop", "endfacet"]
    (folder / "good" / "parts" / "wedge.stl").write_text("\n".join([*lines, "endsolid wedge", ""]))
    urdf = folder / "good" / "parts" / "arm.urdf"
    text, count = re.subn("<box [^>]*/>", '<mesh filename="wedge.stl"/>', urdf.read_text())
    assert count
    urdf.write_text(text)
    return solved(tamplang.load(folder / "good" / "arm_from_urdf.tamp"))


PLANS: dict[str, Callable[[Path], Plan]] = {
    "docking": lambda _: solved(tamplang.load(EXAMPLES / "rendezvous.tamp", n=1)),
    "closed loop": lambda _: solved(tamplang.load(EXAMPLES / "strut_bridge.tamp")),
    "mobile base": lambda _: solved(tamplang.load(EXAMPLES / "mobile_manipulator.tamp", objects=1)),
    "moving scene": lambda _: tamplang.load(EXAMPLES / "moving_stairs.tamp").run(time=300.0).record,
    "mesh arm": mesh_arm,
}
WELDS = {"docking": 1, "closed loop": 2, "mobile base": 1, "moving scene": 0, "mesh arm": 0}
ROBOTS = {"docking": 2, "closed loop": 3, "mobile base": 2, "moving scene": 1, "mesh arm": 1}


@pytest.mark.parametrize("kind", PLANS)
def test_others_read_the_exports_of(kind: str, tmp_path: Path) -> None:
    plan = PLANS[kind](tmp_path)
    check_tables(plan, tmp_path)
    check_rates(plan)
    check_ros2(plan, tmp_path)
    check_bag(plan, tmp_path)
    assert check_mjcf(plan, tmp_path) == WELDS[kind]
    sizes = [check_urdf(plan, tmp_path, phase) for phase in range(len(plan.phases) + 1)]
    assert max(sizes) == ROBOTS[kind]


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (("--to", "csv", "--rate", "0"), "hertz above 0"),
        (("--to", "csv", "--rate", "nan"), "hertz above 0"),
        (("--to", "csv", "--rate", "1e12"), "more than"),
        (("--to", "urdf", "--module", "c[9]"), "no module `c[9]`"),
        (("--to", "urdf", "--phase", "99"), "phases 0 to"),
        (("--to", "urdf", "--phase", "-1"), "phases 0 to"),
        (("--to", "word"), "is not one of"),
    ],
)
def test_what_cannot_be_exported_is_told_and_nothing_written(
    tmp_path: Path, arguments: tuple[str, ...], word: str
) -> None:
    plan = ROOT / "tests" / "verify" / "format_1.plan.json"
    target = tmp_path / "out"
    outcome = CliRunner().invoke(application, ["export", str(plan), *arguments, "--out", str(target)], obj=0.0)
    assert outcome.exit_code not in (0, 70) and word in outcome.output, outcome.output
    assert not target.exists()


def test_a_file_that_is_no_plan_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.plan.json").write_text("{}")
    outcome = CliRunner().invoke(application, ["export", str(tmp_path / "a.plan.json"), "--to", "csv"], obj=0.0)
    assert outcome.exit_code == 1 and not (tmp_path / "a.csv").exists()


def test_samples_come_at_the_rate_that_is_asked_for(tmp_path: Path) -> None:
    plan = ROOT / "tests" / "verify" / "format_1.plan.json"
    target = tmp_path / "a.csv"
    arguments = ["export", str(plan), "--to", "csv", "--rate", "10", "--out", str(target)]
    assert CliRunner().invoke(application, arguments, obj=0.0).exit_code == 0
    stamps = [float(line.split(",")[0]) for line in target.read_text().splitlines()[1:]]
    assert stamps[:3] == [0.0, 0.1, 0.2] and all(b > a for a, b in pairwise(stamps))
