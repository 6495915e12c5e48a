"""Every number that steers a search or a solver is a documented field of its room's settings record."""

from __future__ import annotations

import ast
import dataclasses
import importlib
from pathlib import Path

import pytest

from tamplang.compiler.ir import Options
from tamplang.compiler.options import given_at
from tamplang.compiler.settings import override

ROOT = Path(__file__).resolve().parents[2]
ROOMS = ("runtime/planner", "runtime/simulation", "compiler/symbolic")
RECORDS = {
    "SEARCH": "runtime.planner.search", "CONFLICTS": "runtime.planner.conflicts", "BOUNDS": "runtime.planner.bounds",
    "RECEDING": "runtime.planner.receding", "KEYFRAMES": "runtime.planner.motion.keyframes",
    "PHASES": "runtime.planner.motion.phases", "SOLVER": "runtime.planner.motion.nlp",
    "STATICS": "runtime.planner.statics", "PATHS": "runtime.planner.motion.path",
    "COLLISION": "runtime.planner.motion.collision", "ACCEPTANCE": "runtime.planner.motion",
    "SCHEDULE": "runtime.planner.schedule",
    "SIMULATION": "runtime.simulation", "SYMBOLIC": "compiler.symbolic",
}  # fmt: skip
UNSTEERING = {
    "EMPTY", "OFF", "LEAF", "ORIGIN", "DIVERGED", "HALF_TURN", "IDENTITY", "UP", "UPRIGHT", "DIGITS", "START", "NEVER",
    "OUT_OF_SIGHT",
}  # fmt: skip
"""Names for places in a table, poses, and how a file is written."""
ROUNDING = {
    "STILL", "EQUAL", "SAME", "SAME_TIME", "ROUND_OFF", "ROUNDING", "SLACK", "STRAIGHT", "THIN", "CLOSE", "EPSILON",
    "ACCURATE", "ACCEPTED", "CLOSURE", "NO_STEP", "CHANGE",
}  # fmt: skip
"""How near two numbers are that count as one, and steps of differences."""


def numbers(path: Path) -> list[str]:
    """Names of the numbers that a module sets."""
    found = []
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.Assign) and is_number(node.value):
            target = node.targets[0]
            found += [ast.unparse(t) for t in (target.elts if isinstance(target, ast.Tuple) else [target])]
    return found


def is_number(node: ast.expr) -> bool:
    if isinstance(node, ast.UnaryOp):
        return is_number(node.operand)
    if isinstance(node, ast.BinOp):
        return is_number(node.left) and is_number(node.right)
    if isinstance(node, ast.Tuple):
        return all(map(is_number, node.elts))
    return isinstance(node, ast.Constant) and type(node.value) in (int, float)


def test_numbers_are_found() -> None:
    assert is_number(ast.parse("((1, -2.0), 3 * 4)", mode="eval").body)
    assert not is_number(ast.parse("('a', 1)", mode="eval").body)


@pytest.mark.parametrize("room", ROOMS)
def test_no_module_hides_a_number(room: str) -> None:
    found = {path: numbers(path) for path in (ROOT / room).rglob("*.py")}
    hidden = {
        f"{path.relative_to(ROOT)}: {name}" for path, names in found.items() for name in names
        if name not in UNSTEERING | ROUNDING
    }  # fmt: skip
    assert not hidden


@pytest.mark.parametrize("name", RECORDS)
def test_every_setting_says_its_unit_and_what_it_does(name: str) -> None:
    record = getattr(importlib.import_module(f"tamplang.{RECORDS[name]}.settings"), name)
    for field in dataclasses.fields(record):
        assert set(field.metadata) == {"unit", "what", "reason"}, field.name
        assert field.metadata["unit"] and field.metadata["reason"]
        assert len(field.metadata["what"]) > 5, field.name
        assert getattr(record, field.name) == field.default
    with pytest.raises(dataclasses.FrozenInstanceError):
        setattr(record, dataclasses.fields(record)[0].name, 0)
    with pytest.raises(AttributeError, match="has no setting"):
        override(record, no_such_number=1)


def test_the_options_block_holds_what_the_table_says() -> None:
    kinds = {"word": "str", "whole": "int", "time": "float", "length": "float", "number": "float", "amount": "float"}
    kinds["objective"] = "Objective"
    told = {name: f"{kinds[option.kind]} | None" for name, option in given_at("task").items()}
    assert {f.name: f.type for f in dataclasses.fields(Options)} == told
    assert Options() == Options(**dict.fromkeys(told))
