"""What a room may know of the others (docs/architecture.md), read from every import."""

from __future__ import annotations

import ast
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
ROOMS = ("langs", "compiler", "runtime")
DOORS = {"runtime.verify", "runtime.verify.verify"}
"""What a planner asks about a plan: whether it is verified."""
MEASURING = {"runtime.simulation.tracking", "runtime.simulation.executed_clearance"}
"""They measure an executed motion as the verifier measures a plan."""

FORBIDDEN = {
    "langs": ["compiler", "runtime", "stdlib", "cli", "api", "lsp"],
    "compiler": ["runtime", "cli", "api", "lsp"],
    "compiler.checks": ["compiler.scenes", "compiler.symbolic", "compiler.motion"],
    "compiler.symbolic": ["compiler.scenes", "compiler.motion"],
    "compiler.motion": ["compiler.scenes", "compiler.symbolic"],
    "runtime": ["cli", "api", "lsp"],
    "runtime.geometry": ["runtime.planner", "runtime.simulation", "runtime.verify", "runtime.report"],
    "runtime.planner": ["runtime.verify", "runtime.simulation", "runtime.report"],
    "runtime.planner.motion": ["runtime.planner.search", "runtime.planner.receding", "runtime.planner.lgp"],
    "runtime.planner.search": ["runtime.planner.motion", "runtime.planner.receding", "runtime.planner.lgp"],
    "runtime.simulation": ["runtime.verify", "runtime.report"],
    "runtime.verify": ["runtime.planner", "runtime.geometry", "runtime.simulation", "runtime.skeleton",
                       "compiler.motion", "compiler.symbolic"],
    "runtime.report": ["runtime.planner", "runtime.simulation", "runtime.verify"],
    "runtime.export": ["runtime.planner", "runtime.simulation", "runtime.verify", "runtime.report"],
}  # fmt: skip


def imported(path: Path, text: str) -> set[str]:
    """The modules of the package, or names in them, that the module at `path` below the root imports."""
    package = list(path.parent.parts)
    found: set[str] = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.ImportFrom):
            home = [] if node.level == 0 else package[: len(package) - node.level + 1]
            base = ".".join([*home, *([node.module] if node.module else [])])
            found |= {f"{base}.{alias.name}".removeprefix("tamplang.").lstrip(".") for alias in node.names}
        elif isinstance(node, ast.Import):
            found |= {alias.name.removeprefix("tamplang.") for alias in node.names}
    return found


def within(name: str, room: str) -> bool:
    return name == room or name.startswith(room + ".")


@cache
def modules() -> dict[str, set[str]]:
    found = {}
    for room in ROOMS:
        for path in sorted((ROOT / room).rglob("*.py")):
            inside = path.relative_to(ROOT)
            name = ".".join(inside.with_suffix("").parts).removesuffix(".__init__")
            found[name] = imported(inside, path.read_text(encoding="utf-8"))
    return found


def test_imports_are_read() -> None:
    text = "from ..langs.source import Span\nfrom . import ir\nimport tamplang.runtime.plan\nfrom ..runtime import plan"
    assert imported(Path("compiler/printing.py"), text) == {
        "langs.source.Span", "compiler.ir", "runtime.plan",
    }  # fmt: skip


@pytest.mark.parametrize("room", FORBIDDEN)
def test_a_room_knows_only_what_it_may(room: str) -> None:
    known = {name: imports for name, imports in modules().items() if within(name, room) and name not in MEASURING}
    assert known
    wrong = {
        (name, other) for name, imports in known.items() for other in imports - DOORS
        if any(within(other, forbidden) for forbidden in FORBIDDEN[room])
    }  # fmt: skip
    assert not wrong


VERIFIER = "runtime/verify/"
"""It repeats by design what the compiler and the planner do, under the same names."""
SAME_THING = {
    "Joint": "the IR's, and what it has in common with that of a plan file",
    "Coupling": "the same",
    "Plan": "the record, and what the Python interface gives of it",
    "Window": "of a horizon, and of a run",
}


def test_a_name_of_a_class_means_one_thing() -> None:
    """But for the syntax tree and the IR, which have a record each for the same construct."""
    homes: dict[str, set[str]] = {}
    for room in ROOMS:
        for path in (ROOT / room).rglob("*.py"):
            inside = path.relative_to(ROOT).as_posix()
            own = "compiler/lifted_ir.py" if inside.startswith("langs/syntax") else inside
            for node in ast.parse(path.read_text(encoding="utf-8")).body:
                if isinstance(node, ast.ClassDef) and not inside.startswith(VERIFIER):
                    homes.setdefault(node.name, set()).add(own)
    twice = {name for name, files in homes.items() if len(files) > 1}
    assert twice <= SAME_THING.keys(), {name: homes[name] for name in twice}
