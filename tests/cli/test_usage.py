"""Usage errors: status 2, on standard error, with the near names."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tamplang import __version__

from .conftest import ROOT, Tamplang, environment

CLIMB = ROOT / "examples" / "climb.tamp"


def test_version(tamplang: Tamplang) -> None:
    process = tamplang("--version")
    assert (process.returncode, process.stdout) == (0, f"tamplang {__version__}\n")


def test_help_lists_every_command(tamplang: Tamplang) -> None:
    process = tamplang("--help")
    assert process.returncode == 0
    for command in ("new", "check", "solve", "sweep", "verify", "report", "compile", "explain", "fmt", "lsp", "bench"):
        assert f"\n  {command} " in process.stdout


@pytest.mark.parametrize(
    ("arguments", "near"),
    [
        (["slove", "x.tamp"], "solve"),
        (["solve", str(CLIMB), "--repot", "x.html"], "--report"),
        (["solve", str(CLIMB), "-p", "crawler=2"], "crawlers"),
        (["compile", str(CLIMB), "--emit", "pdl"], "pddl"),
        (["solve", str(CLIMB), "--bound", "seq_path"], "seq-path"),
        (["explain", "E010"], "E0101"),
        (["solve", str(CLIMB), "climbing"], "climb"),
        (["bench", "main_jobs"], "main_job"),
    ],
)
def test_near_names(tamplang: Tamplang, arguments: list[str], near: str) -> None:
    process = tamplang(*arguments)
    assert (process.returncode, process.stdout) == (2, "")
    assert near in process.stderr


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (["solve"], "FILE"),
        (["solve", str(CLIMB), "-p", "n"], "NAME=VALUE"),
        (["solve", str(CLIMB), "-p", "n=many"], "not a number"),
        (["solve", str(CLIMB), "-p", "n=nan"], "not a number"),
        (["solve", str(CLIMB), "--time", "0"], "--time"),
        (["solve", str(CLIMB), "--seed", "-1"], "--seed"),
        (["solve", str(CLIMB), "--horizon", "0"], "--horizon"),
        (["solve", str(CLIMB), "--jobs", "2", "--cluster", "tcp://127.0.0.1:9"], "exclude each other"),
        (["solve", str(CLIMB), "--cluster", "127.0.0.1"], "tcp://HOST:PORT"),
        (["compile", str(CLIMB)], "--emit"),
        (["new", "two words"], "not a name"),
    ],
)
def test_usage_errors(tamplang: Tamplang, arguments: list[str], word: str) -> None:
    process = tamplang(*arguments)
    assert (process.returncode, process.stdout) == (2, "")
    assert word in process.stderr


@pytest.mark.parametrize(
    ("text", "code", "word"),
    [("n=nan", "E0519", "-p n=8"), ("n=inf", "E0519", "-p n=8"), ("n=1e999", "E0519", "too large"),
     ("m=3", "E0519", "has no parameter")],
)  # fmt: skip
def test_unfit_parameters_have_a_code_and_a_hint(tamplang: Tamplang, text: str, code: str, word: str) -> None:
    process = tamplang("solve", CLIMB, "-p", text, "--json")
    assert process.returncode == 2
    assert f"error[{code}]" in process.stderr and word in process.stderr and "climb.tamp:" in process.stderr
    (found,) = json.loads(process.stdout)["diagnostics"]
    assert found["code"] == code and found["help"]


@pytest.mark.parametrize("target", ["no/such/folder/plan.json", ".", "/dev/null", "/proc/plan.json", str(CLIMB)])
@pytest.mark.parametrize("option", ["--out", "--report"])
def test_unwritable_files_are_refused_before_the_search(tamplang: Tamplang, option: str, target: str) -> None:
    before = CLIMB.read_bytes()
    process = tamplang("solve", CLIMB, "-p", "n=2", option, target)
    assert process.returncode == 2
    assert "cannot write" in process.stderr
    assert "search" not in process.stderr
    assert CLIMB.read_bytes() == before


def test_a_closed_pipe_is_quiet() -> None:
    reader, writer = os.pipe()
    os.close(reader)
    process = subprocess.run(
        [sys.executable, "-m", "tamplang", "explain", "E0101"],
        stdout=writer,
        stderr=subprocess.PIPE,
        env=environment(),
        text=True,
        timeout=60,
    )
    os.close(writer)
    assert (process.returncode, process.stderr) == (-signal.SIGPIPE, "")


def test_an_unforeseen_error_leaves_a_crash_file(tmp_path: Path) -> None:
    program = "import sys; from tamplang.cli.crash import report_crash; sys.excepthook = report_crash; 1 / 0"
    process = subprocess.run(
        [sys.executable, "-c", program],
        env={**environment(), "TMPDIR": str(tmp_path)},
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert process.returncode == 70
    assert "Traceback" not in process.stderr
    (crash,) = tmp_path.glob("tamplang-crash-*.txt")
    assert str(crash) in process.stderr
    assert "ZeroDivisionError" in crash.read_text()


def test_a_terminal_that_cannot_show_every_character() -> None:
    process = subprocess.run(
        [sys.executable, "-m", "tamplang", "explain", "E0509"],
        env={**environment(), "PYTHONIOENCODING": "latin-1"},
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert (process.returncode, process.stderr) == (0, "")
    assert "\\u2026" in process.stdout


@pytest.mark.parametrize("unbuffered", ["", "1"])
@pytest.mark.parametrize("arguments", [["check", "--format", "json", CLIMB], ["explain", "E0103"]])
def test_a_full_disk_behind_standard_output_is_no_crash(
    arguments: list[object], unbuffered: str, tmp_path: Path
) -> None:
    with open("/dev/full", "w") as full:
        process = subprocess.run(
            [sys.executable, "-m", "tamplang", *map(str, arguments)],
            cwd=tmp_path, env={**environment(), "PYTHONUNBUFFERED": unbuffered}, stdout=full, stderr=subprocess.PIPE,
            text=True, timeout=60,
        )  # fmt: skip
    assert process.returncode == 2
    assert process.stderr.endswith("Error: cannot write: No space left on device\n")


def test_a_late_ctrl_c_is_no_crash(tmp_path: Path) -> None:
    text = "from tamplang.cli import crash; import sys; sys.excepthook = crash.report_crash; raise KeyboardInterrupt"
    process = subprocess.run(
        [sys.executable, "-c", text], cwd=tmp_path, env=environment(), capture_output=True, text=True, timeout=60
    )
    assert (process.returncode, process.stderr) == (130, "interrupted\n")


def test_a_program_without_its_ending_is_hinted_at(tamplang: Tamplang, tmp_path: Path) -> None:
    shutil.copy(CLIMB, tmp_path)
    assert "did you mean `climb.tamp`?" in tamplang("check", "climb").stdout
    assert "did you mean `climb.tamp`?" in tamplang("solve", "clim.tamp").stderr
