"""Quick commands stay quick: they do not load what they do not need."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from .conftest import ROOT, environment

HEAVY = {"casadi", "pinocchio", "coal", "numpy", "scipy", "meshcat", "rich", "jinja2", "pygls"}


@pytest.mark.parametrize(
    "arguments",
    [
        ["--version"],
        ["check", str(ROOT / "examples" / "climb.tamp")],
        ["check", str(ROOT / "examples" / "tow.tamp")],
        ["check", str(ROOT / "examples" / "payload.tamp")],
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


def test_a_command_loads_no_other() -> None:
    program = (
        "import sys; from tamplang.cli import run; run(['check', '--help']); "
        "print(*sorted(name for name in sys.modules if name.startswith('tamplang.cli.')))"
    )
    process = subprocess.run(
        [sys.executable, "-c", program], env=environment(), capture_output=True, text=True, timeout=60
    )
    loaded = set(process.stdout.splitlines()[-1].split())
    assert "tamplang.cli.check" in loaded
    assert not loaded & {f"tamplang.cli.{other}" for other in ("solve", "sweep", "execute", "plans", "export", "new")}


def test_importing_the_package_loads_nothing_of_the_planner() -> None:
    program = "import sys, tamplang; print(*sorted(sys.modules))"
    process = subprocess.run(
        [sys.executable, "-c", program], env=environment(), capture_output=True, text=True, timeout=60
    )
    loaded = set(process.stdout.split())
    assert not loaded & HEAVY
    assert not {name for name in loaded if name.startswith(("tamplang.langs", "tamplang.compiler", "tamplang.runtime"))}


def test_nothing_is_loaded_before_the_command_listens_for_ctrl_c() -> None:
    """Before that, Ctrl-C would show a traceback."""
    program = (
        f"import sys; sys.path.insert(0, {str(ROOT)!r}); before = set(sys.modules); import tamplang.__main__; "
        "print(*sorted(set(sys.modules) - before))"
    )
    process = subprocess.run([sys.executable, "-I", "-S", "-c", program], capture_output=True, text=True, timeout=60)
    assert process.stdout.split() == ["tamplang", "tamplang.__main__"], process.stderr


INTERRUPTING = """
import os, signal, sys
wanted = sys.argv[1]
class Finder:
    def find_spec(self, name, path=None, target=None):
        if name == wanted:
            sys.meta_path.remove(self)
            os.kill(os.getpid(), signal.SIGINT)
sys.meta_path.insert(0, Finder())
from tamplang.__main__ import main
sys.argv[1:] = ["compile", sys.argv[2], "--emit", "ir"]
main()
"""


@pytest.mark.parametrize("module", ["tamplang.cli", "click", "tamplang.cli.app", "lark", "tamplang.compiler.pipeline"])
def test_ctrl_c_while_the_command_loads_is_quiet(module: str) -> None:
    process = subprocess.run(
        [sys.executable, "-c", INTERRUPTING, module, str(ROOT / "examples" / "climb.tamp")],
        env=environment(), capture_output=True, text=True, timeout=60,
    )  # fmt: skip
    assert (process.returncode, process.stdout, process.stderr.lstrip()) == (130, "", "interrupted\n")


def test_ctrl_c_while_python_ends_is_quiet() -> None:
    program = (
        "import atexit, os, signal, sys; atexit.register(os.kill, os.getpid(), signal.SIGINT); "
        "sys.argv[1:] = ['--version']; from tamplang.__main__ import main; main()"
    )
    process = subprocess.run(
        [sys.executable, "-c", program], env=environment(), capture_output=True, text=True, timeout=60
    )
    assert (process.returncode, process.stderr) == (-signal.SIGINT, "")
    assert process.stdout.startswith("tamplang ")


def test_a_solve_and_its_check_load_no_more_of_numpy_and_scipy_than_they_use(tmp_path: Path) -> None:
    program = (
        "import sys; from tamplang.cli import run; status = run(sys.argv[1:]); "
        "print('loaded:', *sorted(sys.modules), file=sys.stderr); sys.exit(status)"
    )
    plan = tmp_path / "a.plan.json"
    for arguments in (["solve", str(ROOT / "examples" / "pick_and_place.tamp"), "-p", "objects=1", "--out", str(plan)],
                      ["verify", str(plan)]):  # fmt: skip
        process = subprocess.run(
            [sys.executable, "-c", program, *arguments], env=environment(), capture_output=True, text=True, timeout=60
        )
        assert process.returncode == 0, process.stderr
        loaded = set(process.stderr.rpartition("loaded:")[2].split())
        assert "numpy" in loaded
        assert not loaded & {"numpy.ma", "scipy"}
    assert json.loads(plan.read_text())["versions"]["scipy"]
