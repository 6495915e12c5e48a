"""Files that cannot be read or written: coded, at once, and nothing is lost that stood before."""

from __future__ import annotations

import json
import os
import resource
import socket
import stat
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from .conftest import LIGHT, Faulty, environment, here

LONG = "a" * 300
UNTIDY = LIGHT.replace(" pre", "   pre")


@pytest.fixture
def odd(tmp_path: Path) -> Iterator[dict[str, Path]]:
    """Paths at which there is no file to read or write, by what is there."""
    os.mkfifo(tmp_path / "pipe.json")
    (tmp_path / "folder.json").mkdir()
    (tmp_path / "loop.json").symlink_to("loop.json")
    plain = tmp_path / "plain"
    plain.touch()
    with socket.socket(socket.AF_UNIX) as server:
        here_before = os.getcwd()
        os.chdir(tmp_path)  # the path of a socket must be short
        server.bind("socket.json")
        os.chdir(here_before)
        yield {
            "long": tmp_path / f"{LONG}.json", "long folder": tmp_path / LONG / "x.json",
            "deep": tmp_path / ("a/" * 3000) / "x.json", "folder": tmp_path / "folder.json",
            "pipe": tmp_path / "pipe.json", "loop": tmp_path / "loop.json", "socket": tmp_path / "socket.json",
            "zero": Path("/dev/zero"), "below a file": plain / "x.json", "gone": tmp_path / "gone" / "x.json",
        }  # fmt: skip


COMMANDS = [
    ("check", "@"), ("fmt", "@"), ("solve", "@"), ("run", "@"), ("sweep", "@"), ("compile", "@", "--emit", "ir"),
    ("verify", "@"), ("report", "@", "-o", "r.html"), ("solve", "light.tamp", "--out", "@"),
    ("solve", "light.tamp", "--report", "@"), ("run", "light.tamp", "--out", "@"),
    ("run", "light.tamp", "--report", "@"), ("sweep", "light.tamp", "--out", "@"),
    ("sweep", "light.tamp", "--plans", "@"),
]  # fmt: skip


@pytest.mark.parametrize("command", COMMANDS, ids=" ".join)
def test_what_is_no_file_is_refused_at_once(
    light: Path, tmp_path: Path, odd: dict[str, Path], command: tuple[str, ...]
) -> None:
    for kind, path in odd.items():
        if (kind, command[-1]) in (("folder", "@"), ("gone", "@")) and "--plans" in command:
            continue  # folders of plans may be there, or are made
        answer = here(tmp_path, *(str(path) if word == "@" else word for word in command))
        assert answer.returncode in (1, 2), (kind, answer)
        assert answer.stderr.strip() or answer.stdout.strip(), kind
        assert "search" not in answer.stderr, kind


NAMES = [LONG, "x" * 255, "a/" * 3000, "pipe.json", "folder.json", "loop.json", "\u2028", "a\tb"]


@pytest.mark.parametrize("name", NAMES, ids=[n[:10] for n in NAMES])
@pytest.mark.parametrize(
    ("text", "code"),
    [
        ('import "@.tamp"', "E0"), ('import "@"', "E0"),
        ('task t() { object b: mesh("@") at (0, 0, 0) goal (b) }', "E0515"),
        ('task t() { object b: hull("@.stl") at (0, 0, 0) goal (b) }', "E0515"),
        ('module m from urdf "@" { effector a: "b" }', "E0513"),
    ],
)  # fmt: skip
def test_what_a_text_names_is_refused_at_once(
    tmp_path: Path, odd: dict[str, Path], text: str, code: str, name: str
) -> None:
    program = tmp_path / "program.tamp"
    program.write_text(text.replace("@", name))
    answer = here(tmp_path, "check", program, "--format", "json")
    assert answer.returncode == 1
    assert any(d["code"].startswith(code) for d in json.loads(answer.stdout))


@pytest.mark.parametrize(
    ("name", "told"),
    [("", "the mesh has no file"), ("https://example.org/a.stl", "https://example.org/a.stl is no file")],
)
def test_what_is_no_name_of_a_mesh_is_told_as_written(tmp_path: Path, name: str, told: str) -> None:
    (tmp_path / "program.tamp").write_text(f'task t() {{ object b: mesh("{name}") at (0, 0, 0) goal (b) }}')
    assert told in here(tmp_path, "check", "program.tamp").stdout


@pytest.mark.parametrize("mesh", ["/dev/zero", "pipe.json", LONG, "folder.json"])
def test_a_mesh_of_a_urdf_is_refused_at_once(tmp_path: Path, odd: dict[str, Path], mesh: str) -> None:
    shape = f'<collision><geometry><mesh filename="{mesh}"/></geometry></collision>'
    (tmp_path / "r.urdf").write_text(f'<robot name="r"><link name="b">{shape}</link></robot>')
    (tmp_path / "program.tamp").write_text('module m from urdf "r.urdf" { effector a: "b" sphere(1 cm) }')
    answer = here(tmp_path, "check", "program.tamp")
    assert answer.returncode == 1 and "error[E0515]" in answer.stdout


def test_a_name_that_just_fits_is_written(light: Path, tmp_path: Path) -> None:
    name = "a" * 250 + ".json"
    assert here(tmp_path, "solve", light, "--out", name).returncode == 0
    assert here(tmp_path, "verify", name).returncode == 0


def test_files_without_permission(faulty: Faulty, light: Path, tmp_path: Path) -> None:
    """Root's right to read and write all the same is taken from the command."""
    secret, closed = tmp_path / "secret.tamp", tmp_path / "closed"
    secret.write_text(LIGHT)
    secret.chmod(0)
    closed.mkdir()
    (closed / "light.tamp").write_text(UNTIDY)
    closed.chmod(0o500)
    drop = ["setpriv", "--bounding-set", "-dac_override,-dac_read_search"] if os.geteuid() == 0 else []

    def told(*arguments: object) -> str:
        process = faulty(*arguments, before=drop)
        assert process.returncode in (1, 2), process
        return process.stdout + process.stderr

    assert "not readable" in told("check", secret)
    (tmp_path / "imports.tamp").write_text('import "secret.tamp"')
    assert "E0011" in told("check", tmp_path / "imports.tamp")
    assert "Permission denied" in told("solve", light, "--out", closed / "x.json")
    assert "Permission denied" in told("sweep", light, "--plans", closed / "plans")
    assert "not readable" in told("verify", secret)
    closed.chmod(0)
    assert "Permission denied" in told("solve", light, "--report", closed / "x.html")
    assert "Permission denied" in told("fmt", closed / "light.tamp")
    closed.chmod(0o500)
    assert faulty("fmt", closed / "light.tamp", before=drop).returncode == 0, "the file may be written, the folder not"
    assert list(closed.iterdir()) == [closed / "light.tamp"]


# --- fmt -----------------------------------------------------------------------------------------------------------


def test_fmt_keeps_permissions_owner_and_links(tmp_path: Path) -> None:
    plain, linked = tmp_path / "plain.tamp", tmp_path / "linked.tamp"
    for path, mode in ((plain, 0o640), (linked, 0o604)):
        path.write_text(UNTIDY)
        path.chmod(mode)
        if os.geteuid() == 0:
            os.chown(path, 12, 34)
    (tmp_path / "twin.tamp").hardlink_to(linked)
    (tmp_path / "symbolic.tamp").symlink_to("plain.tamp")
    assert here(tmp_path, "fmt", "symbolic.tamp", "twin.tamp").returncode == 0
    for path, mode in ((plain, 0o640), (linked, 0o604)):
        assert path.read_text() != UNTIDY and "rule light" in path.read_text()
        assert stat.S_IMODE(path.stat().st_mode) == mode
        assert os.geteuid() != 0 or (path.stat().st_uid, path.stat().st_gid) == (12, 34)
    assert (tmp_path / "symbolic.tamp").is_symlink()
    assert linked.stat().st_nlink == 2 and linked.samefile(tmp_path / "twin.tamp")
    assert here(tmp_path, "fmt", "--check", "plain.tamp", "twin.tamp").returncode == 0
    assert sorted(p.name for p in tmp_path.iterdir()) == ["linked.tamp", "plain.tamp", "symbolic.tamp", "twin.tamp"]


def test_an_output_keeps_its_permissions_and_its_symbolic_link(light: Path, tmp_path: Path) -> None:
    (tmp_path / "plan.json").touch(0o600)
    (tmp_path / "link.json").symlink_to("plan.json")
    assert here(tmp_path, "solve", light, "--out", "link.json").returncode == 0
    assert (tmp_path / "link.json").is_symlink()
    assert stat.S_IMODE((tmp_path / "plan.json").stat().st_mode) == 0o600
    assert here(tmp_path, "verify", "plan.json").returncode == 0


# --- full disks ----------------------------------------------------------------------------------------------------

NO_BYTECODE = {"PYTHONDONTWRITEBYTECODE": "1"}
"""Python 3.11 keeps what fits of a `.pyc` on a full disk, and fails to read it ever after."""
FILLED = [
    (("solve", "light.tamp", "--out", "@"), "x.json"), (("solve", "light.tamp", "--report", "@"), "x.html"),
    (("run", "light.tamp", "--out", "@"), "x.json"), (("report", "good.json", "-o", "@"), "x.html"),
    (("sweep", "light.tamp", "--out", "@"), "x.jsonl"), (("fmt", "@"), "x.tamp"), (("fmt", "@"), "twin.tamp"),
    (("new", "@"), "fresh.tamp"),
]  # fmt: skip


@pytest.mark.parametrize(("command", "name"), FILLED, ids=[f"{c[0]} {n}" for c, n in FILLED])
def test_a_full_disk_takes_nothing_away(
    faulty: Faulty, light: Path, tmp_path: Path, command: tuple[str, ...], name: str
) -> None:
    """The greatest size of a file is what a test can make full: the system says so as it does on a full disk."""
    assert here(tmp_path, "solve", light, "--out", "good.json").returncode == 0
    before = {"x.json": "{}", "x.html": "old", "x.jsonl": '{"key": "a"}\n', "x.tamp": UNTIDY, "twin.tamp": UNTIDY}
    for other, text in before.items():
        (tmp_path / other).write_text(text)
    (tmp_path / "other.tamp").hardlink_to(tmp_path / "twin.tamp")
    names = sorted(p.name for p in tmp_path.iterdir())
    small = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (20, 20))  # noqa: E731
    words = [name if word == "@" else word for word in command]
    process = faulty(*words, preexec_fn=small, env=NO_BYTECODE)
    assert process.returncode == 2, process
    named = "t.plan.json" if "--report" in command else name
    assert f"cannot write {named}: " in process.stderr
    assert sorted(p.name for p in tmp_path.iterdir()) == names
    assert {other: (tmp_path / other).read_text() for other in before} == before


def test_a_crash_is_told_without_a_place_for_its_file(faulty: Faulty, tmp_path: Path) -> None:
    program = "import sys; from tamplang.cli.crash import report_crash; sys.excepthook = report_crash; 1 / 0"
    process = subprocess.run(
        [sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True, timeout=60,
        env=environment(**NO_BYTECODE),
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (20, 20)),
    )  # fmt: skip
    assert process.returncode == 70 and "No crash file could be written" in process.stderr
    assert "Traceback" not in process.stderr
