"""Robots of many kinds, each with three tasks that are drawn by seed: reach, pick and place, and one of its own.

    tamplang bench zoo [--seeds 5] [--rows TEXT] [--time S] [--out FILE.json] [--markdown FILE.md] [--robots FOLDER]

One process `tamplang solve` per robot, task and seed, one after the other, on one core, with collisions and
verification. The robots of examples/zoo are always there; arms whose parts are meshes come from the URDFs of a package
that is only read (`pip install example-robot-data==6.0.0`), in the folder `robots` that it brings or that --robots
names. With --out, runs are kept in FILE.json as they end and not run again. --rows takes the rows whose name contains
TEXT, such as "snake" or "place".
"""

from __future__ import annotations

import importlib.metadata
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import _runs as bench

TASKS = ("reach", "place", "own")
LIMIT = 60.0
ARM = """import std.mechanisms
import std.rules
module arm from urdf "{urdf}" {{
    effector foot: gripper "{base}" box(15 cm, 15 cm, 2 cm) at (0, 0, -1 cm) normal (0, 0, -1)
    effector tool: gripper "{tool}" sphere(2 cm) at (0, 0, {beyond})
    fact (linked foot tool)
}}
scene room() {{
    base pad: box(30 cm, 30 cm, 10 cm) at (0, 0, 0)
    object table: box(30 cm, 60 cm, 20 cm) at ({away}, 0, 10 cm)
    arm a: foot on pad
}}
task reach() {{
    scene room()
    object post: box(4 cm, 4 cm, 30 cm) on table at (0, 12 cm + jitter(2 cm))
    object ball: sphere(4 cm) at ({away} + jitter(3 cm), jitter(5 cm), 40 cm + jitter(4 cm))
    fact (grippable ball)
    goal  (held ball)
}}
task place() {{
    scene room()
    object shelf: box(30 cm, 30 cm, 20 cm) at (0, {away}, 10 cm)
    fact (tray shelf)
    object item: box(4 cm, 4 cm, 8 cm) on table at (jitter(3 cm), jitter(4 cm))
    object left: box(4 cm, 4 cm, 8 cm) on table at (0, 15 cm)
    object right: box(4 cm, 4 cm, 8 cm) on table at (0, -15 cm)
    fact (grippable item)
    goal  (on shelf item)
}}
## Its own: a button is pressed.
task own() {{
    scene room()
    button b: F on table at (jitter(5 cm), jitter(10 cm))
    goal  (pressed b.H)
}}
"""


TWO_ARMS = """import std.mechanisms
import std.rules
module arms from urdf "{urdf}" {{
    effector foot: gripper "{base}" box(30 cm, 30 cm, 2 cm) at (0, 0, {beyond}) normal (0, 0, -1)
    effector left: gripper "left{tool}" sphere(2 cm)
    effector right: gripper "right{tool}" sphere(2 cm)
    fact (linked foot left)
    fact (linked foot right)
}}
scene room() {{
    object pad: box(60 cm, 60 cm, 4 cm) at (0, 0, -2 cm)
    object table: box(40 cm, 120 cm, 4 cm) at ({away}, 0, 78 cm)
    arms a: foot on pad
}}
task reach() {{
    scene room()
    object post: box(4 cm, 4 cm, 30 cm) on table at (0, 12 cm + jitter(2 cm))
    object ball: sphere(4 cm) at ({away} + jitter(3 cm), -20 cm + jitter(5 cm), 100 cm + jitter(4 cm))
    fact (grippable ball)
    goal  (held ball)
}}
task place() {{
    scene room()
    object shelf: box(30 cm, 30 cm, 10 cm) on table at (0, -40 cm)
    fact (tray shelf)
    object item: box(4 cm, 4 cm, 8 cm) on table at (jitter(3 cm), 10 cm + jitter(4 cm))
    object one: box(4 cm, 4 cm, 8 cm) on table at (0, 25 cm)
    object other: box(4 cm, 4 cm, 8 cm) on table at (0, -8 cm)
    fact (grippable item)
    goal  (on shelf item)
}}
## Its own: from hand to hand, as only the left one gets there.
task own() {{
    scene room()
    object near: box(30 cm, 30 cm, 4 cm) at (60 cm, 85 cm, 78 cm)
    object item: box(4 cm, 4 cm, 16 cm) on near at (jitter(3 cm), jitter(4 cm))
    fact (grippable item)
    goal  (grasped a.right item)
}}
"""


@dataclass(frozen=True, slots=True)
class Robot:
    """A robot of the zoo: the file of its tasks in examples/zoo, whose names end with `ending`, or the URDF of an arm,
    its first link and that of its tool, how far the tool is `beyond` that, and how far `away` its table stands; `text`
    has its tasks."""

    name: str
    what: str
    file: str = ""
    ending: str = ""
    urdf: str = ""
    base: str = ""
    tool: str = ""
    beyond: str = "6 cm"
    away: str = "50 cm"
    text: str = ARM


ROBOTS = [
    Robot("inchworm", "3 joints in one plane; its own: two steps", "inchworm"),
    Robot("climber", "two telescopes on one drive; its own: up a stair", "climber"),
    Robot("snake 8", "8 joints; its own: from stone to stone", "snake", "8"),
    Robot("snake 16", "16 joints; its own: from stone to stone", "snake", "16"),
    Robot("quadruped", "8 joints and 4 without drives; its own: four feet one tile on", "quadruped"),
    Robot("gantry", "coupled hoists and fingers; its own: a button", "gantry"),
    Robot("cubes", "drive, turn, tilt, flat faces; its own: three dock to a row", "cubes"),
    Robot("UR5", "meshes", urdf="ur_description/urdf/ur5_robot.urdf", base="base_link", tool="tool0",
          away="-50 cm"),
    Robot("Panda", "meshes, coupled fingers", urdf="panda_description/urdf/panda.urdf", base="panda_link0",
          tool="panda_hand", beyond="14 cm"),
    Robot("Kinova", "meshes", urdf="kinova_description/robots/kinova.urdf", base="j2s6s200_link_base",
          tool="j2s6s200_end_effector", beyond="4 cm"),
    Robot("xArm7", "meshes", urdf="xarm_description/urdf/xarm7.urdf", base="link_base", tool="link7"),
    Robot("Z1", "meshes", urdf="z1_description/urdf/z1.urdf", base="link00", tool="link06", beyond="10 cm",
          away="40 cm"),
    Robot("Baxter", "two arms; its own: from hand to hand", urdf="baxter_description/urdf/baxter.urdf", base="base",
          tool="_gripper", beyond="-93 cm", away="75 cm", text=TWO_ARMS),
]  # fmt: skip


def robots_of_package() -> Path | None:
    """The folder `robots` of the installed package of URDFs."""
    try:
        files = importlib.metadata.files("example-robot-data") or []
    except importlib.metadata.PackageNotFoundError:
        return None
    found = next((f for f in files if "ur5_robot.urdf" in str(f)), None)
    return None if found is None else Path(str(found.locate())).parents[2]


def run(robot: Robot, task: str, folder: Path | None, limit: float, seed: int, work: Path) -> bench.Run:
    """One seed of one task. An arm's text is written beside the plan and reads its URDF where that lies."""
    plan = work / "plan.json"
    if robot.file:
        return bench.solve(f"zoo/{robot.file}", (), seed, limit, plan, task + robot.ending)
    assert folder is not None
    text = work / "arm.tamp"
    words = {n: getattr(robot, n) for n in ("base", "tool", "beyond", "away")}
    text.write_text(robot.text.format(urdf=folder / robot.urdf, **words), encoding="utf-8")
    return bench.solve(str(text.with_suffix("")), (), seed, limit, plan, task)


def row(name: str, what: str, runs: Sequence[bench.Run]) -> str:
    done = bench.good(runs)
    cpu = sorted(float(str(r["cpu"])) for r in done)
    late = cpu[min(len(cpu) - 1, int(0.95 * len(cpu)))] if cpu else float("nan")
    cells = [name, what, f"{len(done)} of {len(runs)}", bench.number(bench.median(cpu)), bench.number(late)]
    ended = sorted({str(r["status"]) for r in runs if r not in done})
    return f"| {' | '.join([*cells, ', '.join(ended) or '–'])} |"


def _folder() -> Path | None:
    """The folder of URDFs that --robots names, which is taken from the command line, or that of the package."""
    if "--robots" in sys.argv:
        at = sys.argv.index("--robots")
        named = Path(sys.argv[at + 1]).absolute() if at + 1 < len(sys.argv) else Path()
        del sys.argv[at : at + 2]
        return named
    return robots_of_package()


def main() -> None:
    folder = _folder()
    options = bench.options("zoo", __doc__ or "", LIMIT)
    there = [r for r in ROBOTS if r.file or (folder is not None and (folder / r.urdf).exists())]
    pairs = [(robot, task) for robot in there for task in TASKS]
    names = [f"{robot.name} {task}" for robot, task in pairs]
    wanted = [n for n, take in zip(names, bench.chosen(names, options.rows), strict=True) if take]
    tasks = {
        name: partial(run, robot, task, folder, options.time)
        for name, (robot, task) in zip(names, pairs, strict=True) if name in wanted
    }  # fmt: skip
    runs = bench.measure(tasks, options.seeds, options.out)
    lines = [f"{bench.machine()}, {bench.today()}; {options.seeds} seeds per row, {options.time:g} s per run."]
    headings = ["robot and task", "what it is", "verified", "CPU s, median", "95 %", "else"]
    lines += bench.table("robots and their tasks", headings)
    lines += [row(n, r.what, list(runs[n].values())) for n, (r, _) in zip(names, pairs, strict=True) if n in wanted]
    missing = [r.name for r in ROBOTS if r not in there]
    lines += ["", f"Not there: {', '.join(missing)}; `pip install example-robot-data==6.0.0`."] if missing else []
    bench.tell("\n".join(lines) + "\n", options.markdown)


if __name__ == "__main__":
    main()
