"""compile --emit: every stage of every example, and what each must show."""

from __future__ import annotations

from pathlib import Path

import pytest

from .conftest import ROOT, Tamplang

EXAMPLES = sorted((ROOT / "examples").glob("*.tamp"))
SHOWN = {
    "ast": "RuleDecl",
    "ir": "rule grasp",
    "ground": "facts at the start",
    "successors": "def expand_",
    "constraints": "keep pose(Y, X)  # 6 rows",
    "costs": "cost of grasp: 1",
    "pddl": "(:action",
}


@pytest.mark.parametrize("stage", SHOWN)
def test_every_stage_of_an_example(tamplang: Tamplang, stage: str) -> None:
    source = ROOT / ("stdlib/rules.tamp" if stage == "ast" else "examples/pick_and_place.tamp")
    process = tamplang("compile", source, "--emit", stage, *([] if stage == "ast" else ["-p", "objects=1"]))
    assert process.returncode == 0, process.stderr
    assert SHOWN[stage] in process.stdout


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_the_ir_is_the_same_every_time(tamplang: Tamplang, example: Path) -> None:
    task = ["drawer"] if example.stem == "mechanisms" else []
    first, second = (tamplang("compile", example, *task, "--emit", "ir", "--seed", "3") for _ in range(2))
    assert first.returncode == 0
    assert first.stdout == second.stdout
