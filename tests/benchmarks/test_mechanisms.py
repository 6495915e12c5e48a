"""The benchmarks that change the planner still find what they change."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path
from typing import Any

import pytest

BENCHMARKS = Path(__file__).resolve().parents[2] / "benchmarks"


@pytest.fixture
def module(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    return importlib.import_module


def test_every_mechanism_is_there_to_be_switched_off(module: Any) -> None:
    for mechanism in module("_mechanisms").MECHANISMS.values():
        for place, attribute, value in mechanism.changes:
            home, _, inner = place.partition(":")
            target = getattr(importlib.import_module(home), inner) if inner else importlib.import_module(home)
            assert getattr(target, attribute) != value, mechanism.name


def test_every_mutation_changes_one_place(module: Any) -> None:
    for mutation in module("_mutations").MUTATIONS:
        text = (BENCHMARKS.parent / mutation.file).read_text(encoding="utf-8")
        assert text.count(mutation.old) == 1, mutation.name
        assert all((BENCHMARKS.parent / test.partition("::")[0]).exists() for test in mutation.tests if "/" in test)
        assert isinstance(mutation.tests, tuple), mutation.name


def test_what_a_mechanism_buys_is_told_by_runs_and_seconds(module: Any) -> None:
    ablation = module("ablation")

    def run(cpu: float, solved: bool) -> dict[str, object]:
        bounds = {"seq": {"solved": 3, "refused": int(cpu)}}
        return {"cpu": cpu, "status": "solved" if solved else "exhausted", "verified": solved, "bounds": bounds}

    base, without = [run(2.0, True), run(4.0, True)], [run(3.0, True), run(9.0, False)]
    assert ablation.cell(base, without) == "-1 solved, 2.00, 18/12"
    assert ablation.cell(base, base) == "1.00, 12/12"
    assert ablation.buys([base], [without]) == "+1 of 2 solved, +6.0 s of 6.0 s"
    sys.modules.pop("ablation")
