"""Modules of catalogues become module types with an end for each connector, which dock by gender and size."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import tamplang

from .conftest import Command, problems, refused
from .kinematics import poses


def frame(x: float, y: float, z: float, about_y: float = 0.0) -> list[list[float]]:
    c, s = math.cos(about_y), math.sin(about_y)
    return [[c, 0, s, x], [0, 1, 0, y], [-s, 0, c, z], [0, 0, 0, 1]]


def catalogue() -> list[dict[str, Any]]:
    below = [[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 0], [0, 0, 0, 1]]
    first = {
        "ID": "a", "mass": 1.5, "r_com": [0, 0, 0.05], "inertia": [[0.01, 0, 0], [0, 0.01, 0], [0, 0, 0.01]],
        "collision": [{"type": "cylinder", "pose": frame(0, 0, 0.05), "parameters": {"r": 0.04, "z": 0.1}}],
        "connectors": [{"ID": "in", "gender": "f", "size": [80], "type": "flange", "pose": below}],
    }  # fmt: skip
    last = {
        "ID": "b",
        "connectors": [{"ID": "out", "gender": "m", "size": [80], "type": "flange", "pose": frame(0, 0, 0.2)}],
        "collision": [{"type": "box", "pose": frame(0, 0, 0.1), "parameters": {"x": 0.05, "y": 0.05, "z": 0.2}}],
    }  # fmt: skip
    joint = {
        "ID": "j", "parent": "a", "child": "b", "type": "revolute", "poseParent": frame(0, 0, 0.1, 0.3),
        "poseChild": frame(0.01, 0, 0, 0.1),
        "limits": {"positionLower": -math.inf, "positionUpper": math.inf, "peakTorque": math.inf, "velocity": 1.5},
    }  # fmt: skip
    return [{"header": {"ID": "J1", "name": "joint"}, "bodies": [first, last], "joints": [joint]}]


def test_a_catalogue_becomes_modules(command: Command) -> None:
    Path("m.json").write_text(json.dumps(catalogue(), indent=1))
    assert "Infinity" in Path("m.json").read_text()
    assert command("import", "m.json", "-o", "m.tamp").status == 0
    assert problems(command, "m.tamp") == []
    text = Path("m.tamp").read_text()
    assert "(female in_)" in text and "(male out)" in text and text.count("size1") == 2
    turn = np.eye(4)
    turn[:2, :2] = [[math.cos(0.7), -math.sin(0.7)], [math.sin(0.7), math.cos(0.7)]]
    wanted = np.array(frame(0, 0, 0.1, 0.3)) @ turn @ np.array(frame(0.01, 0, 0, 0.1))
    assert poses(Path("m_J1.urdf").read_text(), {"j": 0.7})["b"][:3] == pytest.approx(wanted[:3, 3], abs=1e-9)


def test_a_scene_keeps_its_obstacles(command: Command) -> None:
    wall = {"type": "box", "parameters": {"x": 0.1, "y": 1, "z": 1}}
    obstacle = {"ID": "1", "name": "wall", "pose": frame(1, 0, 0.5), "collision": [wall]}
    scene = {"obstacles": [obstacle], "goals": [{"ID": 7}]}
    Path("s.json").write_text(json.dumps(scene, indent=1))
    answer = command("import", "s.json", "-o", "s.tamp")
    assert answer.status == 0 and "goal `7`" in answer.told
    assert "base wall: box(0.1 m, 1 m, 1 m) at (1 m, 0 m, 0.5 m)" in Path("s.tamp").read_text()


def test_only_fitting_connectors_dock(command: Command) -> None:
    task = """import std.rules
import std.docking
module foot() {
    effector A: gripper sphere(4 cm) normal (0, 0, -1)
    joint j1: revolute(z) in -3 rad .. 3 rad
    link 20 cm: capsule(3 cm)
    joint j2: revolute(y) in -2 rad .. 2 rad home 0.5 rad
    link 20 cm: capsule(3 cm)
    effector B: connector sphere(4 cm)
    fact (male B)
    fact (size1 B)
    fact (linked A B)
}
module peg() {
    effector A: connector sphere(4 cm) normal (0, 0, -1)
    link 20 cm: capsule(2 cm)
    effector B: connector sphere(4 cm)
    fact (GENDER A)
    fact (size1 A)
    fact (linked A B)
}
task t() {
    base ground: box(2 m, 2 m, 5 cm) at (0, 0, 0)
    foot f: A on ground
    peg p: at (0, 0, 54.5 cm)
    goal (connected f.B p.A)
    options { bound = seq, time = 20 s }
}
"""
    for gender, status in (("female", True), ("male", False)):
        Path("t.tamp").write_text(task.replace("GENDER", gender))
        assert (tamplang.load("t.tamp").solve().status == "solved") == status


Change = Callable[[dict[str, Any]], object]
BAD: list[tuple[Change, str]] = [
    (lambda m: m.update(bodies=[]), "E0022"), (lambda m: m.update(bodies=3), "E0022"),
    (lambda m: m.update(bodies=[1]), "E0022"), (lambda m: m["bodies"].append(m["bodies"][0]), "E0022"),
    (lambda m: m["bodies"][0].pop("ID"), "E0019"), (lambda m: m["joints"][0].pop("parent"), "E0019"),
    (lambda m: m["joints"][0].update(parent="c"), "E0022"), (lambda m: m["joints"][0].update(parent="b"), "E0022"),
    (lambda m: m["joints"][0].update(type="screw"), "E0022"), (lambda m: m.update(joints=[]), "E0022"),
    (lambda m: m["joints"][0].update(poseParent=[[1]]), "E0022"),
    (lambda m: m["joints"][0].update(poseParent=[[1, 0, 0, 0]] * 4), "E0022"),
    (lambda m: m["joints"][0].update(poseParent="x"), "E0019"),
    (lambda m: m["joints"][0].update(limits={"positionLower": 1, "positionUpper": 0}), "E0022"),
    (lambda m: m["joints"][0].update(limits={"positionLower": "low"}), "E0019"),
    (lambda m: m["bodies"][0]["connectors"][0].update(gender="x"), "E0022"),
    (lambda m: m["bodies"][0]["collision"][0].update(parameters={}), "E0019"),
    (lambda m: m["bodies"][0]["collision"][0].update(parameters={"r": math.inf, "z": 1}), "E0022"),
    (lambda m: m["bodies"][0].update(inertia=[[math.inf] * 3] * 3), "E0022"),
    (lambda m: m["bodies"][0].update(mass=math.nan), "E0019"), (lambda m: m["bodies"][0].update(mass=[]), "E0019"),
]  # fmt: skip


@pytest.mark.parametrize("number", range(len(BAD)))
def test_bad_modules_are_refused_with_their_place(command: Command, number: int) -> None:
    change, code = BAD[number]
    modules = catalogue()
    change(modules[0])
    Path("m.json").write_text(json.dumps(modules, indent=1))
    assert "--> m.json:" in refused(command, {code}, "m.json")


def test_what_is_no_json_is_refused(command: Command) -> None:
    whole = json.dumps(catalogue(), indent=1)
    for text in (whole[:-1], whole + "]", whole.replace('"j"', "'j'", 1), '{"modules": ' + "[" * 100_000):
        Path("m.json").write_text(text)
        refused(command, {"E0019"}, "m.json")
