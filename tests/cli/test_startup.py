"""Quick commands stay quick: they do not load what they do not need."""

from __future__ import annotations

import subprocess
import sys

import pytest

from .conftest import ROOT, environment

HEAVY = {"casadi", "pinocchio", "coal", "numpy", "scipy", "meshcat", "rich", "jinja2", "pygls"}


@pytest.mark.parametrize(
    "arguments",
    [
        ["--version"],
        ["check", str(ROOT / "examples" / "climb.tamp")],
        ["explain", "E0101"],
        ["fmt", "--check", str(ROOT / "tamplang" / "cli" / "starter.tamp")],
    ],
)
def test_no_heavy_import(arguments: list[str]) -> None:
    program = (
        "import sys; from tamplang.cli import run; status = run(sys.argv[1:]); "
        "print('loaded:', *sorted({name.partition('.')[0] for name in sys.modules}), file=sys.stderr); sys.exit(status)"
    )
    process = subprocess.run(
        [sys.executable, "-c", program, *arguments],
        env=environment(),
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert process.returncode == 0, process.stderr
    loaded = set(process.stderr.rpartition("loaded:")[2].split())
    assert "click" in loaded
    assert not loaded & HEAVY


def test_importing_the_package_loads_nothing_of_the_planner() -> None:
    program = "import sys, tamplang; print(*sorted(sys.modules))"
    process = subprocess.run(
        [sys.executable, "-c", program], env=environment(), capture_output=True, text=True, timeout=60
    )
    loaded = set(process.stdout.split())
    assert not loaded & HEAVY
    assert not {name for name in loaded if name.startswith(("tamplang.langs", "tamplang.compiler", "tamplang.runtime"))}
