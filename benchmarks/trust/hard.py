"""Hard inputs: what takes long somewhere in a command, made as files in a folder.

Texts for parser, checks, scenes, the symbolic layer and PDDL; meshes and URDFs for the readers of other people;
searches without end, motion programs of long chains and thin plates; long and hostile plans for the verifier; sweeps,
runs, and the address of a cluster that says nothing.
"""

from __future__ import annotations

import json
import math
import os
import socket
import struct
import subprocess
import sys
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path

from benchmarks.trust.families import FAMILIES, MAIN

ROOT = Path(__file__).resolve().parents[2]
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT)}
COMMAND = (sys.executable, "-m", "tamplang")
Make = Callable[[Path], list[str]]
"""Writes files into a folder and gives the arguments of a command, without `--time`."""
TURNS, RINGS = 400, 126
"""Points of a mesh: some 100,000 triangles."""
SAMPLES = 100_000


def _family(name: str, size: int, *command: str) -> Make:
    def make(folder: Path) -> list[str]:
        for file, text in FAMILIES[name].make(size).items():
            (folder / file).write_text(text, encoding="utf-8")
        return [command[0], MAIN, *command[1:]]

    return make


def _example(name: str, command: str, *options: str) -> Make:
    def make(folder: Path) -> list[str]:
        return [command, str(ROOT / "examples" / f"{name}.tamp"), *options]

    return make


def _text(text: str, command: str, *options: str) -> Make:
    def make(folder: Path) -> list[str]:
        (folder / MAIN).write_text(text, encoding="utf-8")
        return [command, MAIN, *options]

    return make


# --- plans -------------------------------------------------------------------------------------------------------


@cache
def _solved(steps: int) -> bytes:
    """A plan of the example `climb` that is made without a limit."""
    with tempfile.TemporaryDirectory() as folder:
        example = str(ROOT / "examples" / "climb.tamp")
        arguments = ["solve", example, "-p", f"n={steps}", "--time", "inf", "--out", "plan.json"]
        subprocess.run([*COMMAND, *arguments], cwd=folder, capture_output=True, check=True, env=ENVIRONMENT)
        return (Path(folder) / "plan.json").read_bytes()


def _plan(steps: int, command: str, *options: str) -> Make:
    def make(folder: Path) -> list[str]:
        (folder / "plan.json").write_bytes(_solved(steps))
        return [command, "plan.json", *options]

    return make


def _crowded(command: str, *options: str) -> Make:
    """A plan that starts with some SAMPLES samples in a blink."""

    def make(folder: Path) -> list[str]:
        plan = json.loads(_solved(8))
        times = plan["times"]
        more = SAMPLES - len(times)
        gap = 1e-4 * (times[1] - times[0]) / more
        plan["times"] = [times[0] + gap * k for k in range(more)] + times[1:]
        for track in plan["tracks"]:
            for name in ("poses", "joints"):
                track[name] = track[name][:1] * more + track[name][1:]
        (folder / "plan.json").write_text(json.dumps(plan), encoding="utf-8")
        return [command, "plan.json", *options]

    return make


# --- meshes and URDFs --------------------------------------------------------------------------------------------


def _ball() -> tuple[list[tuple[float, float, float]], list[tuple[int, int, int]]]:
    """Points and triangles of a ball of 10 cm, every point a corner of its hull."""
    points = []
    for ring in range(RINGS):
        height = math.pi * (ring + 0.5) / RINGS
        for turn in range(TURNS):
            angle = 2 * math.pi * turn / TURNS
            points.append((0.1 * math.sin(height) * math.cos(angle), 0.1 * math.sin(height) * math.sin(angle),
                           0.1 * math.cos(height)))  # fmt: skip
    triangles = []
    for ring in range(RINGS - 1):
        for turn in range(TURNS):
            a, b = ring * TURNS + turn, ring * TURNS + (turn + 1) % TURNS
            triangles += [(a, b, a + TURNS), (b, b + TURNS, a + TURNS)]
    return points, triangles


def _stl() -> bytes:
    points, triangles = _ball()
    body = [struct.pack("<12fH", 0, 0, 1, *points[a], *points[b], *points[c], 0) for a, b, c in triangles]
    return bytes(80) + struct.pack("<I", len(triangles)) + b"".join(body)


def _obj() -> bytes:
    points, triangles = _ball()
    lines = [f"v {x} {y} {z}" for x, y, z in points] + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in triangles]
    return "\n".join(lines).encode() + b"\n"


def _dae() -> bytes:
    points, triangles = _ball()
    numbers = " ".join(f"{v:.6f}" for p in points for v in p)
    indices = " ".join(str(i) for t in triangles for i in t)
    accessor = f'<accessor source="#p-array" count="{len(points)}" stride="3">' + "".join(
        f'<param name="{axis}" type="float"/>' for axis in "XYZ"
    )
    return f"""<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="p-array" count="{3 * len(points)}">{numbers}</float_array>
<technique_common>{accessor}</accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="{len(triangles)}"><input semantic="VERTEX" source="#v" offset="0"/><p>{indices}</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node><instance_geometry url="#g"/></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>
""".encode()


MESHES = {"stl": _stl, "obj": _obj, "dae": _dae}
LIT = """predicate (lit)
rule light() { pre not (lit) post (lit) }
"""


def _mesh(ending: str, command: str, *options: str) -> Make:
    def make(folder: Path) -> list[str]:
        (folder / f"ball.{ending}").write_bytes(MESHES[ending]())
        text = LIT + f'task t() {{ object b: hull("ball.{ending}") at (0, 0, 1 m) goal (lit) }}\n'
        return _text(text, command, *options)(folder)

    return make


def _urdf(links: int, meshes: int, command: str, *options: str) -> Make:
    """A chain of links; the first so many have a mesh each."""

    def make(folder: Path) -> list[str]:
        parts = []
        for k in range(links):
            mesh = f'<collision><geometry><mesh filename="ball.stl" scale="1 1 {1 + k / 100}"/></geometry></collision>'
            parts.append(f'<link name="l{k}">{mesh if k < meshes else ""}</link>')
            parts += [f'<joint name="j{k}" type="revolute"><parent link="l{k - 1}"/><child link="l{k}"/>'
                      '<origin xyz="0 0 0.3"/><axis xyz="0 1 0"/><limit lower="-2" upper="2" velocity="1" effort="1"/>'
                      "</joint>"] * (k > 0)  # fmt: skip
        (folder / "arm.urdf").write_text(f'<robot name="arm">{"".join(parts)}</robot>', encoding="utf-8")
        if meshes:
            (folder / "ball.stl").write_bytes(_stl())
        text = LIT + f"""module arm from urdf "arm.urdf" {{
    effector A: "l0" sphere(1 cm)
    effector B: "l{links - 1}" sphere(1 cm)
}}
task t() {{ arm a: at (0, 0, 0) goal (lit) }}
"""
        return _text(text, command, *options)(folder)

    return make


# --- motion ------------------------------------------------------------------------------------------------------

THIN = """import std.crawler
import std.rules

task thin() {
    object floor: box(4 m, 4 m, 10 cm) at (0, 0, -5 cm)
    base stand: box(40 cm, 40 cm, 4 cm) at (0, 0, 2 cm)
    object source: box(60 cm, 60 cm, 20 cm) at (1 m, 0, 10 cm)
    object target: box(60 cm, 60 cm, 20 cm) at (-1 m, 0, 10 cm)
    fact (tray target)
    object plate: SHAPE on source at (0, 0)
    fact (grippable plate)
    crawler c: A on stand
    goal (on target plate)
}
"""
SHEET = "box(40 cm, 30 cm, 0.5 mm)"
CORNERS = [f"({x} cm, {y} cm, {z} mm)" for x, y in ((0, 0), (40, 0), (0, 30), (39, 30)) for z in (0, 0.5)]
WEDGE = f"hull({', '.join(CORNERS)})"
CHAIN = """import std.crawler
import std.rules

task chain(modules: int = 40) {
    base ground: box(8 m, 8 m, 1 m) at (0, 0, -0.5 m)
    object target: sphere(0.04 m) at (0, 0, 1.1 m * (modules - 1) + 0.10 m)
    fact (grippable target)
    for k in 1 .. modules {
        crawler c[k]: A on ground at (3 m * cos(360 deg * k / modules), 3 m * sin(360 deg * k / modules))
    }
    goal (held target)
}
"""
JOINT = "joint j{}: revolute({}) in -1 rad .. 1 rad link 5 cm: capsule(1 cm)\n"
JOINTS = "".join(JOINT.format(k, "yzx"[k % 3]) for k in range(80))
SNAKE = f"""import std.crawler
import std.rules

module snake {{
    effector A: gripper sphere(2 cm) normal (0, 0, -1)
    {JOINTS}effector B: gripper sphere(2 cm)
    fact (linked A B)
}}
task t() {{
    base ground: box(4 m, 4 m, 10 cm) at (0, 0, -5 cm)
    object target: sphere(4 cm) at (2 m, 0, 2 m)
    fact (grippable target)
    snake s: A on ground
    goal (held target)
}}
"""


# --- clusters ----------------------------------------------------------------------------------------------------


@cache
def _silent() -> socket.socket:
    """A port of this machine that takes connections and says nothing."""
    listener = socket.socket()
    listener.bind(("127.0.0.1", 0))
    listener.listen(16)
    return listener


def _cluster(command: str, *options: str) -> Make:
    def make(folder: Path) -> list[str]:
        port = _silent().getsockname()[1]
        return _example("climb", command, "--cluster", f"tcp://127.0.0.1:{port}", *options)(folder)

    return make


_LARGE = (
    ("wide bodies", 4000), ("wide loop", 9000), ("wide facts", 20000), ("wide rules", 4000), ("chained rules", 2000),
    ("wide conjunction", 20000), ("wide effects", 20000), ("wide declarations", 4000),
)  # fmt: skip
def _foreign(name: str, text: str) -> Make:
    """A file of others, which is imported."""

    def make(folder: Path) -> list[str]:
        (folder / name).write_text(text, encoding="utf-8")
        return ["import", name, "-o", "made.tamp"]

    return make


_FRAMES = "".join(f"f{k}: {{ Q: [{k}, 0, 1], shape: ssBox, size: [.1, .1, .1, .01] }}\n" for k in range(12_000))
_MODEL = '<model name="m{}"><static>1</static><link name="l"><collision name="c"><geometry><sphere><radius>1</radius>'
_MODELS = "".join(f"{_MODEL.format(k)}</sphere></geometry></collision></link></model>" for k in range(6000))
_DECISIONS = "".join(f"DecisionRule r{k} {{ X, Y, {{ (on X Y) }} {{ (on X Y)! (on Y X) }} }}\n" for k in range(8000))
HARD: dict[str, Make] = {
    "import rai": _foreign("wide.g", _FRAMES),
    "import sdf": _foreign("wide.sdf", f"<sdf version='1.9'>{_MODELS}</sdf>"),
    "import rules": _foreign("wide.fol", f"on\n{_DECISIONS}"),
    **{f"check {name}": _family(name, size, "check") for name, size in _LARGE},
    **{f"ir {name}": _family(name, size, "compile", "--emit", "ir") for name, size in _LARGE[:4]},
    **{f"pddl {name}": _family(name, size, "compile", "--emit", "pddl") for name, size in _LARGE},
    **{f"successors {name}": _family(name, size, "compile", "--emit", "successors") for name, size in _LARGE},
    **{f"solve {name}": _family(name, size, "solve", "--out", "out.json") for name, size in _LARGE[:4]},
    "fmt wide declarations": _family("wide declarations", 20000, "fmt"),
    "check mesh stl": _mesh("stl", "check"),
    "check mesh obj": _mesh("obj", "check"),
    "ir mesh dae": _mesh("dae", "compile", "--emit", "ir"),
    "solve mesh stl": _mesh("stl", "solve"),
    "check urdf meshes": _urdf(8, 8, "check"),
    "check urdf links": _urdf(400, 0, "check"),
    "search bfs": _example("rendezvous", "solve", "-p", "n=64", "--search", "bfs", "--bound", "seq"),
    "search solutions": _example("climb", "solve", "-p", "n=64", "--solutions", "900", "--bound", "seq"),
    "motion": _example("quadruped", "solve", "-p", "steps=2"),
    "motion jobs": _example("quadruped", "solve", "-p", "steps=2", "--jobs", "2"),
    "motion sheet": _text(THIN.replace("SHAPE", SHEET), "solve"),
    "motion thin hull": _text(THIN.replace("SHAPE", WEDGE), "solve"),
    "motion chain": _text(CHAIN, "solve"),
    "motion chain horizon": _text(CHAIN, "solve", "--horizon", "auto"),
    "motion chain of 10": _text(CHAIN, "solve", "-p", "modules=10"),
    "motion joints": _text(SNAKE, "solve"),
    "successors chain": _text(CHAIN, "compile", "--emit", "successors"),
    "motion things": _example("mobile_manipulator", "solve", "-p", "objects=64"),
    "horizon": _example("rendezvous", "solve", "-p", "n=64", "--horizon", "auto"),
    "run": _example("moving_stairs", "run"),
    "run chain": _text(CHAIN, "run"),
    "sweep": _example("climb", "sweep", "-p", "n=64"),
    "sweep mesh": _mesh("stl", "sweep"),
    "verify": _plan(16, "verify"),
    "verify long": _plan(128, "verify"),
    "verify crowded": _crowded("verify"),
    "run plan": _plan(128, "run"),
    "report": _plan(16, "report", "--out", "plan.html"),
    "report crowded": _crowded("report", "--out", "plan.html"),
    "solve silent cluster": _cluster("solve"),
    "sweep silent cluster": _cluster("sweep"),
}
