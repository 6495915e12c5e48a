"""Writes docs/python.md from the docstrings of the Python interface: python docs/write_python.py"""

from __future__ import annotations

import inspect
import re
from pathlib import Path

import tamplang

HEAD = """# Python

What `import tamplang` offers, from its docstrings, whose examples the tests run; `python docs/write_python.py` writes
this page. `examples/notebook.ipynb` walks through it. Tables and figures need the extra `notebook`.

```python
import tamplang

task = tamplang.load("examples/climb.tamp", n=4)
result = task.solve(time=30.0)
if result.plan is not None:
    result.plan.report("climb.html")
    print(result.plan.trajectory("c[1]").q.shape)
```

In a notebook tasks, results, plans, runs and diagnostics show themselves: what there is and why, and the replay in 3-D,
in a frame of its own that needs no network."""


def text() -> str:
    """The page. A test refuses one that is not what this gives."""
    found = [(name, getattr(tamplang, name)) for name in tamplang.__all__ if not name.startswith("_")]
    functions = [part for name, thing in found if inspect.isfunction(thing) for part in _function(name, thing, "##")]
    classes = [(name, thing) for name, thing in found if inspect.isclass(thing)]
    errors = [(name, thing) for name, thing in classes if issubclass(thing, Exception)]
    others = [part for name, thing in classes if not issubclass(thing, Exception) for part in _class(name, thing)]
    table = [f"| `{name}` | {_line(thing)} |" for name, thing in errors]
    parts = [HEAD, *functions, *others, "## Errors", "\n".join(["| error | raised |", "|---|---|", *table])]
    return "\n\n".join(parts) + "\n"


def _function(name: str, thing: object, level: str) -> list[str]:
    assert callable(thing)
    signature = re.sub(r"\bself, ?|\(self\)", lambda m: "()" if m[0] == "(self)" else "", str(inspect.signature(thing)))
    return [f"{level} {name}", f"```python\n{name}{signature.replace(chr(39), '')}\n```", _doc(thing)]


def _class(name: str, thing: type) -> list[str]:
    parts = [f"## {name}", _doc(thing)]
    for member, value in vars(thing).items():
        if isinstance(value, property):
            parts += [f"### {name}.{member}", _doc(value)]
        elif inspect.isfunction(value) and not member.startswith("_"):
            parts += _function(f"{name}.{member}", value, "###")
    return parts


def _doc(thing: object) -> str:
    """The docstring, its examples as code."""
    doc = inspect.getdoc(thing) or ""
    return re.sub(r"(?m)((?:^>>> .*\n?)(?:^\S.*\n?)*)", lambda m: f"```pycon\n{m[1].rstrip()}\n```\n", doc).rstrip()


def _line(thing: type) -> str:
    return " ".join((inspect.getdoc(thing) or "").split())


if __name__ == "__main__":
    (Path(__file__).parent / "python.md").write_text(text(), encoding="utf-8")
