"""What stands in a plan file: all that it needs, nothing that changes from one time to the next, and no more than a
reader understands. Damaged files are refused with a sentence, by every command that reads one."""

from __future__ import annotations

import base64
import copy
import hashlib
import io
import json
import math
import os
import shutil
from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec
import pytest

import tamplang
from tamplang import cli
from tamplang.runtime.plan import Plan
from tamplang.runtime.plan_files import PlanFileError, read_plan, write_plan
from tamplang.runtime.verify import verify

HERE = Path(__file__).parent
OLD = HERE / "format_1.plan.json"
"""A plan of one step, made by the last version that wrote format 1."""
PROGRAMS = HERE.parent / "programs" / "good"
Data = dict[str, Any]


@dataclass(frozen=True)
class Told:
    """What a command ended with, and all that it said."""

    exit_code: int
    output: str


def run(*arguments: object) -> Told:
    said = io.StringIO()
    with redirect_stdout(said), redirect_stderr(said):
        status = cli.run([str(a) for a in arguments])
    return Told(status, said.getvalue())


def verified(folder: Path, data: Data) -> Told:
    (folder / "p.json").write_text(json.dumps(data))
    return run("verify", folder / "p.json")


@pytest.fixture(scope="module")
def good(hop: Plan, tmp_path_factory: pytest.TempPathFactory) -> str:
    path = tmp_path_factory.mktemp("good") / "plan.json"
    write_plan(hop, path)
    return path.read_text()


# --- format 1 ----------------------------------------------------------------------------------------------------


def test_a_file_of_format_1_is_read_and_verified(tmp_path: Path) -> None:
    assert run("verify", OLD).exit_code == 0
    plan = tamplang.read_plan(OLD)
    assert plan.record.format == "tamplang-plan/2"
    assert [(s.first, s.until) for s in plan.record.splines] == [(0, 0)]
    assert plan.record.timing is not None and plan.record.timing.seconds["total"] > 0.0
    plan.save(tmp_path / "new.json")
    assert json.loads((tmp_path / "new.json").read_text())["format"] == "tamplang-plan/2"
    assert read_plan(tmp_path / "new.json") == plan.record


def move_joint(data: Data) -> None:
    data["tracks"][0]["joints"][10][3] += 0.01


def drop_spline(data: Data) -> None:
    data["splines"] = []


def move_slab(data: Data) -> None:
    data["body_tracks"].append({"name": "right", "poses": [[0.5, 0, 0.001, 0, 0, 0, 1]] * len(data["times"])})


def short_track(data: Data) -> None:
    data["body_tracks"].append({"name": "right", "poses": [[0.5, 0, 0, 0, 0, 0, 1]]})


def other_text(data: Data) -> None:
    data["task"]["sources"][0]["text"] += " "


@pytest.mark.parametrize("change", [move_joint, drop_spline, move_slab, short_track, other_text])
def test_a_tampered_file_of_format_1_is_refused(change: Callable[[Data], None], tmp_path: Path) -> None:
    data = json.loads(OLD.read_text())
    change(data)
    assert verified(tmp_path, data).exit_code == 5


def test_a_file_of_format_1_with_parts_of_format_2_is_refused(tmp_path: Path) -> None:
    data = json.loads(OLD.read_text())
    data["timing"] = None
    told = verified(tmp_path, data)
    assert told.exit_code == 1 and "unknown field `timing`" in told.output


# --- nothing but what the file holds -----------------------------------------------------------------------------


@pytest.fixture(scope="module")
def meshes(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A plan of a task whose bodies come from meshes, in a folder in which no mesh is left."""
    folder = tmp_path_factory.mktemp("meshes")
    (folder / "good").mkdir()
    shutil.copy(PROGRAMS / "meshes.tamp", folder / "good")
    for parts in ("good/parts", "bad/parts"):
        shutil.copytree(PROGRAMS.parent / parts, folder / parts)
    solved = run("solve", folder / "good" / "meshes.tamp", "--out", folder / "plan.json")
    assert solved.exit_code == 0, solved.output
    shutil.rmtree(folder / "good")
    shutil.rmtree(folder / "bad")
    return folder / "plan.json"


def test_meshes_travel_inside_the_plan(meshes: Path) -> None:
    files = json.loads(meshes.read_text())["task"]["files"]
    assert files and all("parts/" in f["path"] for f in files)
    for file in files:
        data = base64.b64decode(file["data"])
        assert data == next(PROGRAMS.parent.glob(f"*/parts/{Path(file['path']).name}")).read_bytes()
        assert hashlib.sha256(data).hexdigest() == file["sha256"]
    assert run("verify", meshes).exit_code == 0


def test_a_changed_or_lost_mesh_is_refused_by_its_name(meshes: Path, tmp_path: Path) -> None:
    data = json.loads(meshes.read_text())
    file = data["task"]["files"][0]
    lost = copy.deepcopy(data)
    del lost["task"]["files"][0]
    told = verified(tmp_path, lost)
    assert told.exit_code == 5 and file["path"] in told.output and "make the plan anew" in told.output
    file["data"] = base64.b64encode(base64.b64decode(file["data"]) + b"\n").decode()
    told = verified(tmp_path, data)
    assert told.exit_code == 5 and f"the file {file['path']} was changed" in told.output


def as_format_1(data: Data, folder: str) -> Data:
    """The plan as format 1 would have it, made from outside the folder of its task: meshes as lists of corners."""
    old = copy.deepcopy(data)
    renamed = {s["path"]: f"{folder}/{s['path']}" for s in old["task"]["sources"] if not s["path"].startswith("std/")}
    text = json.dumps(old)
    for path, name in renamed.items():
        text = text.replace(json.dumps(path), json.dumps(name))
    old = json.loads(text) | {"format": "tamplang-plan/1"}
    for file in old["task"].pop("files"):
        corners = "0.0 0.0 0.0\n"
        digest = hashlib.sha256(corners.encode()).hexdigest()
        old["task"]["sources"].append({"path": f"{folder}/{file['path']}", "text": corners, "sha256": digest})
    del old["needs"], old["timing"], old["verdict"]
    old["statistics"]["bounds"] = []
    old["splines"] = [{**s, "phase": s["from"]} for s in old["splines"]]
    for spline in old["splines"]:
        del spline["from"], spline["until"]
    old["body_tracks"] = []
    return old


def test_meshes_of_a_plan_of_format_1_come_from_the_readers_own_text(meshes: Path, tmp_path: Path) -> None:
    data = json.loads(meshes.read_text())
    pieces = data["body_tracks"]
    old = as_format_1(data, "good")
    for piece in pieces:
        rest = next(b["pose"] for b in data["bodies"] if b["name"] == piece["name"])
        rows = [rest] * piece["first"] + piece["poses"]
        rows += [rows[-1]] * (len(data["times"]) - len(rows))
        old["body_tracks"].append({"name": piece["name"], "poses": rows})
    told = verified(tmp_path, old)
    assert told.exit_code == 5 and "the plan lacks the file good/parts/wedge.stl" in told.output
    told = run("verify", tmp_path / "p.json", "--against", PROGRAMS / "meshes.tamp")
    assert told.exit_code == 0, told.output


def names_disk(data: Data, path: Path, text: str) -> None:
    source = data["task"]["sources"][0]
    source["text"] += "\n" + text.replace("PATH", str(path)) + "\n"
    source["sha256"] = hashlib.sha256(source["text"].encode()).hexdigest()


@pytest.mark.parametrize(
    "text",
    [
        'import "PATH"',
        'module thief from urdf "PATH" { effector A: "base" }',
        'scene secret() { base b: hull("PATH") at (9 m, 9 m, 0) }',
        'scene secret() { base b: mesh("PATH") at (9 m, 9 m, 0) }',
    ],
)
@pytest.mark.parametrize("ending", [".tamp", ".urdf", ".stl", ".obj"])
def test_verify_opens_no_file_that_a_plan_names(good: str, text: str, ending: str, tmp_path: Path) -> None:
    """The named file is a FIFO that nobody writes to: whoever opens it waits for ever."""
    path = tmp_path / f"secret{ending}"
    os.mkfifo(path)
    data = json.loads(good)
    names_disk(data, path, text)
    told = verified(tmp_path, data)
    assert told.exit_code == 5 and str(path) in told.output


def test_verify_opens_no_mesh_that_a_urdf_or_a_mesh_names(good: str, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "secret.stl")
    os.mkfifo(tmp_path / "secret.mtl")
    urdf = f"""<robot name="t"><link name="base"><collision><geometry>
        <mesh filename="{tmp_path}/secret.stl"/></geometry></collision></link></robot>"""
    corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
    colours = f"mtllib {tmp_path}/secret.mtl\nmt\\\nllib {tmp_path}/secret.mtl\nusemtl x\n"
    mesh = f"{colours}{corners}f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
    data = json.loads(good)
    names_disk(data, tmp_path, 'module t from urdf "t.urdf" { effector A: "base" }')
    names_disk(data, tmp_path, 'scene secret() { base b: mesh("s.obj") at (9 m, 9 m, 0) }')
    data["task"]["files"] = [
        {"path": p, "data": base64.b64encode(t.encode()).decode(), "sha256": hashlib.sha256(t.encode()).hexdigest()}
        for p, t in (("t.urdf", urdf), ("s.obj", mesh))
    ]
    told = verified(tmp_path, data)
    refused = [line for line in told.output.splitlines() if "refused: " in line]
    assert told.exit_code == 5 and any("E0515" in line and "secret.stl" in line for line in refused), told
    assert all(code in line for code, line in zip(("E0509", "E0515"), sorted(refused), strict=True)), told


def test_a_plan_without_a_standard_text_is_refused_by_its_name(good: str, tmp_path: Path) -> None:
    data = json.loads(good)
    data["task"]["sources"] = [s for s in data["task"]["sources"] if s["path"] != "std/rules.tamp"]
    told = verified(tmp_path, data)
    assert told.exit_code == 5 and "the plan lacks the text of std/rules.tamp" in told.output


# --- one file from one task --------------------------------------------------------------------------------------


def test_seconds_of_computing_stand_in_timing_alone(tmp_path: Path) -> None:
    task = json.loads(OLD.read_text())["task"]["sources"][0]["text"]
    (tmp_path / "tiny.tamp").write_text(task)
    plans = []
    for name in ("one.json", "two.json"):
        assert run("solve", tmp_path / "tiny.tamp", "--out", tmp_path / name).exit_code == 0
        plans.append(json.loads((tmp_path / name).read_text()))
    assert all(plan["timing"]["seconds"]["total"] > 0.0 for plan in plans)
    assert all(plan["timing"]["machine"]["cores"] >= 1 and plan["timing"]["machine"]["system"] for plan in plans)
    texts = [json.dumps({**plan, "timing": None}) for plan in plans]
    assert texts[0] == texts[1] and '"seconds"' not in texts[0]


def test_only_phases_in_which_a_body_moves_have_samples_of_it(hop: Plan) -> None:
    (piece,) = hop.body_tracks
    held = [p for p in hop.phases if any(a.predicate == "stable" and "ball" in a.args for a in p.mode)]
    assert [hop.times[piece.first], hop.times[piece.first + len(piece.poses) - 1]] == [held[0].start, held[-1].end]


# --- damage ------------------------------------------------------------------------------------------------------

DAMAGE: dict[str, Callable[[str], str]] = {
    "empty": lambda text: "",
    "half": lambda text: text[: len(text) // 2],
    "brackets": lambda text: "[" * 100_000,
    "brackets inside": lambda text: text[:-1] + ',"verdict":' + '{"a":' * 100_000,
    "deep and whole": lambda text: text[:-1] + ',"foreign":' + "[" * 100_000 + "]" * 100_000 + "}",
    "foreign field": lambda text: text[:-1] + ',"note":1}',
    "foreign field inside": lambda text: text.replace('"kind":"box"', '"kind":"box","colour":"red"', 1),
    "size twice": lambda text: text.replace('"size":[0.3', '"size":[9.0,9.0,9.0],"size":[0.3', 1),
    "rows twice": lambda text: text.replace('"joints":[[', '"joints":[],"joints":[[', 1),
    "name twice": lambda text: text[:-1] + ',"complete":false,"complete":true}',
    "number as text": lambda text: text.replace('"seed":0', '"seed":"0"', 1),
    "truth as number": lambda text: text.replace('"movable":false', '"movable":0', 1),
    "NaN": lambda text: text.replace('"start":0.0', '"start":NaN', 1),
    "Infinity": lambda text: text.replace('"start":0.0', '"start":Infinity', 1),
    "too large": lambda text: text.replace('"start":0.0', '"start":1e999', 1),
    "null": lambda text: text.replace('"phases":[', '"phases":null,"x":[', 1),
    "other format": lambda text: text.replace("tamplang-plan/2", "tamplang-plan/3", 1),
    "no format": lambda text: text.replace('"format"', '"Format"', 1),
    "unknown need": lambda text: text.replace('"needs":[]', '"needs":["warmth"]', 1),
    "no base64": lambda text: text.replace('"files":[]', '"files":[{"path":"a","data":"@","sha256":""}]', 1),
    "two objects": lambda text: text + text,
    "lone surrogate": lambda text: text.replace('"name":"hop"', '"name":"\\ud800"', 1),
}


@pytest.mark.parametrize("damage", DAMAGE.values(), ids=list(DAMAGE))
@pytest.mark.parametrize("command", [("verify",), ("report", "-o"), ("run",)], ids=lambda c: c[0])
def test_a_damaged_file_is_refused_with_a_sentence(
    good: str, damage: Callable[[str], str], command: tuple[str, ...], tmp_path: Path
) -> None:
    path = tmp_path / "p.json"
    path.write_text(damage(good))
    assert path.read_text() != good
    rest = [*command[1:], tmp_path / "out.html"] if len(command) > 1 else []
    told = run(command[0], path, *rest)
    assert told.exit_code == 1, told.output
    assert told.output.startswith("error[E0023]: ") and len(told.output) < 600 and "Traceback" not in told.output


@pytest.mark.parametrize("kind", ["folder", "fifo", "device", "missing", "long name", "huge"])
def test_what_is_no_file_is_refused_at_once(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "p.json"
    if kind == "folder":
        path.mkdir()
    elif kind == "fifo":
        os.mkfifo(path)
    elif kind == "device":
        path = Path("/dev/zero")
    elif kind == "long name":
        path = tmp_path / ("x" * 300 + ".json")
    elif kind == "huge":
        path.touch()
        os.truncate(path, 2_000_000_000)
    told = run("verify", path)
    assert told.exit_code == 1 and told.output.startswith("error[E0023]: cannot read")


def test_plan_file_survives_writing(hop: Plan, tmp_path: Path) -> None:
    write_plan(hop, tmp_path / "plan.json")
    again = read_plan(tmp_path / "plan.json")
    assert again == hop
    assert verify(again).verified


@pytest.mark.parametrize("text", ["", "{}", "[]", "null", '{"format": "other"}', "\x00\x01"])
def test_other_files_are_no_plans(text: str, tmp_path: Path) -> None:
    (tmp_path / "plan.json").write_text(text)
    with pytest.raises(PlanFileError):
        read_plan(tmp_path / "plan.json")


def test_nan_in_a_file_is_refused(hop: Plan, tmp_path: Path) -> None:
    write_plan(msgspec.structs.replace(hop, times=[math.nan, *hop.times[1:]]), tmp_path / "plan.json")
    with pytest.raises(PlanFileError):
        read_plan(tmp_path / "plan.json")
