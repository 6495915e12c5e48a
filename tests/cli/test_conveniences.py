"""What makes the command line pleasant: standard input, differences, help, watching, examples, completion."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from tamplang.cli.new import examples
from tamplang.langs.codes import CODES

from .conftest import ROOT, Tamplang, environment

WRONG = "type   a < b\n"
UNTIDY = "type   a<object\n"


def piped(folder: Path, text: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "tamplang", *arguments], input=text, cwd=folder, env=environment(),
        capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip


def test_check_reads_standard_input(tmp_path: Path) -> None:
    done = piped(tmp_path, WRONG, "check", "-")
    assert done.returncode == 1
    assert "<stdin>:1:12" in done.stdout and "type   a < b" in done.stdout
    assert piped(tmp_path, "type a < object\n", "check", "-").returncode == 0


def test_what_does_not_read_standard_input_says_what_does(tmp_path: Path) -> None:
    done = piped(tmp_path, "task t() { }", "solve", "-")
    assert done.returncode == 1 and "`check` and `fmt` alone read standard input" in done.stderr


def test_standard_input_imports_from_the_current_folder(tmp_path: Path) -> None:
    (tmp_path / "own.tamp").write_text("type board < object\n")
    done = piped(tmp_path, 'import "own.tamp"\ntype plank < board\n', "check", "-")
    assert done.returncode == 0, done.stdout


def test_check_quiet_tells_errors_only(tamplang: Tamplang, program: Callable[[str], Path]) -> None:
    loud, quiet = (tamplang("check", program("# nothing\n"), *more) for more in ((), ("-q",)))
    assert "W0016" in loud.stdout and "1 warning" in loud.stderr
    assert quiet.stdout == quiet.stderr == ""
    assert "E0102" in tamplang("check", program(WRONG), "--quiet").stdout


def test_fmt_of_standard_input(tmp_path: Path) -> None:
    done = piped(tmp_path, UNTIDY, "fmt", "-")
    assert (done.returncode, done.stdout) == (0, "type a < object\n")
    asked = piped(tmp_path, UNTIDY, "fmt", "--check", "-")
    assert (asked.returncode, asked.stdout, asked.stderr) == (1, "", "would change: -\n")
    ends_early = piped(tmp_path, UNTIDY.rstrip("\n"), "fmt", "--diff", "-").stdout.splitlines()
    assert ends_early.count("\\ No newline at end of file") == 1 and all(line[0] in " +-@\\" for line in ends_early)


def test_fmt_shows_differences(tamplang: Tamplang, program: Callable[[str], Path]) -> None:
    file = program(UNTIDY)
    done = tamplang("fmt", "--diff", file)
    assert done.returncode == 1
    assert "-type   a<object" in done.stdout and "+type a < object" in done.stdout
    assert file.read_text() == UNTIDY


def test_help_of_a_command(tamplang: Tamplang) -> None:
    assert tamplang("help", "fmt").stdout == tamplang("fmt", "--help").stdout
    assert "solve" in tamplang("help").stdout
    wrong = tamplang("help", "slove")
    assert wrong.returncode == 2 and "did you mean `solve`?" in wrong.stderr


def test_explain_lists_all_codes(tamplang: Tamplang) -> None:
    lines = tamplang("explain", "--list").stdout.splitlines()
    assert [line.split()[0] for line in lines] == list(CODES)
    assert tamplang("explain", "--list", "s").stdout.splitlines() == [line for line in lines if line.startswith("S")]


def test_new_from_an_example(tamplang: Tamplang, tmp_path: Path) -> None:
    assert tamplang("new", "mine", "--from", "climb").returncode == 0
    text = (tmp_path / "mine.tamp").read_text()
    assert "task mine(" in text and "solve mine.tamp" in text and "examples/" not in text
    assert tamplang("check", "mine.tamp").returncode == 0
    assert "did you mean `climb`?" in tamplang("new", "x", "--from", "clim").stderr
    assert [line.split()[0] for line in tamplang("new", "--from", "list").stdout.splitlines()] == list(examples())


def test_all_examples_can_be_copied() -> None:
    assert set(examples()) == {p.stem for p in (ROOT / "examples").glob("*.tamp")}


def test_check_watches(tmp_path: Path) -> None:
    """What the program imports counts, too; Ctrl-C ends it."""
    (tmp_path / "own.tamp").write_text("type board < object\n")
    (tmp_path / "main.tamp").write_text('import "own.tamp"\ntype plank < board\n')
    command = [
        sys.executable, "-c", "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); "
        "from tamplang.__main__ import main; main()", "check", "--watch", "--format", "concise", "main.tamp",
    ]  # fmt: skip
    watch = subprocess.Popen(
        command, cwd=tmp_path, env=environment(), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    assert watch.stdout is not None
    assert [watch.stdout.readline() for _ in range(2)] == ["1 file, 0 errors, 0 warnings\n", "watching; Ctrl-C ends\n"]
    (tmp_path / "own.tamp").write_text("type brick < object\n")
    assert "E0102 unknown type `board`" in watch.stdout.readline()
    assert [watch.stdout.readline() for _ in range(2)][1] == "watching; Ctrl-C ends\n"
    os.kill(watch.pid, signal.SIGINT)
    assert watch.wait(timeout=30) == 130
    assert "Traceback" not in watch.stdout.read()


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_completion_in_the_shell(tmp_path: Path, shell: str) -> None:
    program = "import sys; sys.argv[0] = 'tamplang'; from tamplang.__main__ import main; main()"
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True, timeout=60, check=False,
        env={**environment(), "_TAMPLANG_COMPLETE": f"{shell}_source"},
    )  # fmt: skip
    assert "tamplang" in done.stdout and "complete" in done.stdout, done


@pytest.mark.parametrize(
    ("words", "found"),
    [("explain e010", "E0103"), ("help so", "solve"), ("new --from clim", "climb"), ("solve --bound seq", "seq-path")],
)
def test_words_are_completed(tmp_path: Path, words: str, found: str) -> None:
    program = "import sys; sys.argv[0] = 'tamplang'; from tamplang.__main__ import main; main()"
    typed = {"COMP_WORDS": f"tamplang {words}", "COMP_CWORD": str(len(words.split()))}
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True, timeout=60, check=False,
        env={**environment(), **typed, "_TAMPLANG_COMPLETE": "bash_complete"},
    )  # fmt: skip
    assert f"plain,{found}" in done.stdout.splitlines(), done


def test_solve_tells_nothing_or_everything(tamplang: Tamplang) -> None:
    tamplang("new", "tiny")
    quiet = tamplang("solve", "tiny.tamp", "--bound", "seq", "-q")
    loud = tamplang("solve", "tiny.tamp", "--bound", "seq", "--verbose")
    assert (quiet.returncode, quiet.stderr) == (0, "") and quiet.stdout
    assert len(loud.stderr.splitlines()) >= 2
    assert tamplang("solve", "tiny.tamp", "--quiet", "--verbose").returncode == 2
