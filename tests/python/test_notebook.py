"""The notebook of the examples, from its first cell to the last, and what its cells show."""

from __future__ import annotations

import ast
import json
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[2]
NOTEBOOK = ROOT / "examples" / "notebook.ipynb"


def run_cells(cells: list[str]) -> list[Any]:
    """What the last expression of each cell gives, as a kernel runs them: one after the other in one name space."""
    names: dict[str, Any] = {"__name__": "__main__"}
    shown = []
    for number, text in enumerate(cells):
        tree = ast.parse(text, f"cell {number}")
        last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
        exec(compile(tree, f"cell {number}", "exec"), names)
        value = None if last is None else compile(ast.Expression(last.value), f"cell {number}", "eval")
        shown.append(None if value is None else eval(value, names))
    return shown


def test_the_notebook_runs_from_first_to_last_cell(capsys: pytest.CaptureFixture[str]) -> None:
    notebook = json.loads(NOTEBOOK.read_text(encoding="utf-8"))
    assert notebook["nbformat"] == 4
    cells = ["".join(c["source"]) for c in notebook["cells"] if c["cell_type"] == "code"]
    task, plan, _, table, joints, clearance, mistake = run_cells(cells)
    assert "greatest speed" in capsys.readouterr().out
    assert "goal" in task._repr_html_() and "<iframe" in task._repr_html_()
    page = plan._repr_html_()
    assert "verified" in page and "grasp" in page and "<iframe" in page and "https://" not in page.split("iframe")[0]
    assert table.loc["max", "c.j2.rate"] > 0.0
    assert joints._repr_png_().startswith(b"\x89PNG")
    assert len(joints.axes) == 1 and "between" in clearance.axes[0].get_title(loc="left")
    assert "did you mean `held`" in mistake._repr_html_()
