"""Signals and kills at random moments of every command: what is left on the disk, and of the processes.

    python -m benchmarks.trust.signals [--count N] [--seed N] [--folder DIR]

A command is struck between the moment it takes over from Python and a little after it would have ended. Then: its exit
status is one that docs/cli.md lists or the signal's own; no traceback; every output that stands is whole; no other file
stands, nor a temporary one; no process of it lives.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from benchmarks.trust.journal import Line, Record, Settings
from tamplang.langs.disk_cache import recalled_sealed
from tamplang.langs.formatter import format_source
from tamplang.langs.source import Source

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "examples"
COUNT = 200
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGPIPE, signal.SIGKILL)
LEFT = 20.0
"""Seconds that a process may go on after its signal: a call into a compiled library ends first."""
GOES_ON = 3.0
"""While others work for it, a command does not end with a broken pipe but goes on: so many times its seconds, on a
machine with other work."""
BEYOND = 1.2
"""How far beyond the end of an undisturbed command a signal may come: it finds the command at work, ending or gone."""
UNTIDY = "import std.logic\npredicate   (lit)\nrule light() {\n  pre not (lit)   post (lit) }\ntask t() {goal (lit)}\n"

FRAMES = "".join(f"f{k} (world): {{ Q: [{k}, 0, 1], shape: ssBox, size: [.1, .1, .1, .01] }}\n" for k in range(300))
SCENE = f"""world: {{}}
turn (world): {{ joint: hingeX, limits: [-1, 1] }}
tip (turn): {{ Q: [0, 0, .3], shape: sphere, size: [.05] }}
{FRAMES}"""


@dataclass(frozen=True, slots=True)
class Command:
    """A command of the program, with the files that may stand after it; `serves` waits for input."""

    words: tuple[str, ...]
    outputs: tuple[str, ...] = ()
    serves: bool = False
    fresh: bool = False
    """Whether the cache of the grammar is empty, so that it is written."""


CLIMB = str(EXAMPLES / "climb.tamp")
SMALL = ("-p", "n=2")
COMMANDS = {
    "check": Command(("check", CLIMB), fresh=True),
    "fmt": Command(("fmt", "untidy.tamp")),
    "new": Command(("new", "fresh"), ("fresh.tamp",)),
    "solve": Command(("solve", CLIMB, *SMALL, "--report", "climb.html"), ("climb.plan.json", "climb.html")),
    "report": Command(("report", "good.plan.json", "-o", "page.html"), ("page.html",)),
    "lsp": Command(("lsp",), serves=True),
    "sweep --jobs 2": Command(
        ("sweep", CLIMB, "-p", "n=1..3", "--jobs", "2", "--plans", "plans"), ("climb.sweep.jsonl", "plans")
    ),
    "compile": Command(("compile", CLIMB, "--emit", "ir")),
    "solve over": Command(("solve", CLIMB, *SMALL, "--out", "good.plan.json", "--report", "good.html"), ()),
    "solve --jobs 2": Command(("solve", CLIMB, "-p", "n=8", "--jobs", "2"), ("climb.plan.json",)),
    "run": Command(("run", str(EXAMPLES / "moving_stairs.tamp"), *SMALL), ("moving_stairs.run.json",)),
    "sweep": Command(("sweep", CLIMB, "-p", "n=1..3", "--plans", "plans"), ("climb.sweep.jsonl", "plans")),
    "verify": Command(("verify", "good.plan.json")),
    "import": Command(("import", "arm.g", "-o", "arm.tamp"), ("arm.tamp", "arm_turn.urdf")),
}


@dataclass(frozen=True, slots=True)
class Prepared:
    """A folder with sound files, to be copied for each strike, and how long each command takes undisturbed."""

    folder: Path
    seconds: dict[str, float]


def run(settings: Settings) -> list[Line]:
    """The line of the table. Results are kept by number; the same number with the same seed is the same strike, but for
    where the machine's own speed puts it."""
    count = COUNT if settings.count is None else settings.count
    journal = settings.journal("signals")
    with tempfile.TemporaryDirectory(prefix="signals-") as place:
        prepared = prepare(Path(place))
        records = journal.fill(map(str, range(count)), lambda key: strike(prepared, settings.seed, int(key)))
        found = list(records)
    wrong = [f"{r['command']} {r['signal']}: {w}" for r in found for w in r["wrong"]]
    for line in wrong:
        print(line, file=sys.stderr)
    ended = sum(r["struck"] for r in found)
    result = f"{len(wrong)} with something half, left over, alive or unsaid; {ended} of the strikes ended the command"
    return [Line("signals", f"{count} signals and kills at {len(COMMANDS)} commands", result, not wrong)]


def prepare(place: Path) -> Prepared:
    """The sound files, made once, and the seconds that each command takes."""
    folder = place / "sound"
    folder.mkdir()
    (folder / "untidy.tamp").write_text(UNTIDY)
    (folder / "arm.g").write_text(SCENE)
    made = subprocess.run(
        [*_tamplang(), "solve", CLIMB, *SMALL, "--out", "good.plan.json", "--report", "good.html"],
        cwd=folder, env=_environment(place, place), capture_output=True, check=False,
    )  # fmt: skip
    assert made.returncode == 0, made.stderr
    return Prepared(folder, {})


def strike(prepared: Prepared, seed: int, number: int) -> Record:
    """One command, struck once. `wrong` says what should not be."""
    rng = random.Random(f"{seed} {number}")
    name = list(COMMANDS)[number % len(COMMANDS)]
    command, sign, share = COMMANDS[name], rng.choice(SIGNALS), rng.random()
    if name not in prepared.seconds:
        prepared.seconds[name] = _undisturbed(prepared, command)
    with _Place(prepared) as place:
        process, out = _start(place, command, prepared.folder.parent)
        _await_begin(process)
        try:
            process.wait(share * BEYOND * prepared.seconds[name])
            struck = False
        except subprocess.TimeoutExpired:
            process.send_signal(sign)
            struck = True
        wrong = _ended(process, LEFT + (GOES_ON * prepared.seconds[name] if sign == signal.SIGPIPE else 0.0))
        told = out.read_text(errors="replace")
        wrong += _untrue_status(process.returncode, sign, struck, told)
        wrong += [f"it tells of a {word}" for word in ("Traceback", "internal error") if word in told]
        wrong += _leftovers(place, prepared, command)
    return {"command": name, "signal": sign.name, "struck": struck, "status": process.returncode, "wrong": wrong}


class _Place:
    """A copy of the sound files in a folder of its own, which goes with what was made in it."""

    def __init__(self, prepared: Prepared) -> None:
        self._temporary = tempfile.TemporaryDirectory(dir=prepared.folder.parent)
        self._sound = prepared.folder

    def __enter__(self) -> Path:
        place = Path(self._temporary.__enter__())
        shutil.copytree(self._sound, place / "work")
        for name in ("tmp", "cache"):
            (place / name).mkdir()
        return place

    def __exit__(self, *error: object) -> None:
        self._temporary.cleanup()


def _tamplang() -> list[str]:
    return [sys.executable, "-m", "tamplang"]


def _environment(place: Path, cache: Path) -> dict[str, str]:
    own = {"TMPDIR": str(place / "tmp"), "XDG_CACHE_HOME": str(cache / "cache"), "PYTHONDONTWRITEBYTECODE": "1"}
    return {**os.environ, "PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", **own}


def _start(place: Path, command: Command, shared: Path) -> tuple[subprocess.Popen[bytes], Path]:
    out = place / "out"
    with out.open("wb") as stream:
        process = subprocess.Popen(
            [*_tamplang(), *command.words],
            cwd=place / "work",
            env=_environment(place, place if command.fresh else shared),
            stdin=subprocess.PIPE if command.serves else subprocess.DEVNULL,
            stdout=stream,
            stderr=stream,
            start_new_session=True,
        )
    return process, out


def _undisturbed(prepared: Prepared, command: Command) -> float:
    """Seconds from the beginning to the end; a server is looked at for a second."""
    if command.serves:
        return 1.0
    with _Place(prepared) as place:
        process, out = _start(place, command, prepared.folder.parent)
        _await_begin(process)
        begin = time.monotonic()
        process.wait(120)
        assert process.returncode == 0, out.read_text()
        return time.monotonic() - begin


def _await_begin(process: subprocess.Popen[bytes]) -> None:
    """Wait until the command has taken over: Python ignores SIGPIPE, the command does not."""
    ignored, end = False, time.monotonic() + 30
    while process.poll() is None and time.monotonic() < end:
        try:
            status = Path(f"/proc/{process.pid}/status").read_text()
        except OSError:
            return
        now = bool(int(status.split("SigIgn:")[1].split()[0], 16) >> (signal.SIGPIPE - 1) & 1)
        if ignored and not now:
            return
        ignored = ignored or now
        time.sleep(0.001)


def _ended(process: subprocess.Popen[bytes], most: float) -> list[str]:
    """Wait `most` seconds for the end, of the process and of all that it started."""
    if process.stdin is not None:
        process.stdin.close()
    wrong, end = [], time.monotonic() + most
    try:
        process.wait(most)
    except subprocess.TimeoutExpired:
        wrong.append(f"it lives {most:.0f} s later")
    while alive := list(_session(process.pid)):
        if time.monotonic() > end:
            wrong.append(f"{len(alive)} processes live on")
            for number in alive:
                os.kill(number, signal.SIGKILL)
            break
        time.sleep(0.02)
    process.wait()
    return wrong


def _session(number: int) -> Iterator[int]:
    """The living processes of a session."""
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = path.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[3]) == number and fields[0] != "Z":
            yield int(path.parent.name)


def _untrue_status(status: int, sign: signal.Signals, struck: bool, told: str) -> list[str]:
    """Done, ended by the signal, or, after Ctrl-C, 130."""
    fit = {0}
    if struck:
        fit |= {-sign} | ({130} if sign == signal.SIGINT else set())
    return [] if status in fit else [f"status {status}: {told[-200:]}"]


def _leftovers(place: Path, prepared: Prepared, command: Command) -> list[str]:
    """What is half, and what should not stand."""
    wrong = [f"{p.relative_to(place)} is left" for p in (place / "tmp").rglob("*")]
    cached = [p for p in (place / "cache").rglob("*") if p.is_file()]
    trees = [p for p in cached if p.name.startswith("tree-")]
    wrong += [f"{p.name} is half" for p in trees if recalled_sealed(p) is None]
    wrong += [f"{p.relative_to(place)} is left" for p in cached if p not in trees and not p.name.startswith("grammar-")]
    sound = {p.name for p in prepared.folder.iterdir()}
    for path in sorted((place / "work").rglob("*")):
        name = path.relative_to(place / "work").parts[0]
        if name not in sound and name not in command.outputs:
            wrong.append(f"{name} is left")
        elif path.is_file() and not _is_whole(path, prepared):
            wrong.append(f"{path.name} is half")
    return wrong


def _is_whole(path: Path, prepared: Prepared) -> bool:
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".g":
        return text == SCENE
    if path.suffix == ".urdf":
        return text.rstrip().endswith("</robot>")
    if path.name == "untidy.tamp":
        return text in (UNTIDY, format_source(Source(path.name, UNTIDY)))
    if path.suffix == ".html":
        return text.rstrip().endswith("</html>")
    if path.suffix == ".tamp":
        return text.endswith("}\n")
    try:
        for line in text.splitlines() if path.suffix == ".jsonl" else [text]:
            json.loads(line)
    except ValueError:
        return False
    return path.suffix != ".jsonl" or not text or text.endswith("\n")


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--count", type=int, default=COUNT)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--folder", type=Path, default=Path("trust-results"))
    given = parser.parse_args()
    (line,) = run(Settings(given.folder.resolve(), given.seed, given.count))
    print(f"{line.what}: {line.result}")
    return 0 if line.kept else 1


if __name__ == "__main__":
    sys.exit(main())
