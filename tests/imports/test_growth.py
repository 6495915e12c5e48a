"""What reading files of others costs, in calls that are counted: twice as large a file costs about twice as much."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from types import FrameType

import pytest

from tamplang.compiler.importing.reading import import_files
from tamplang.compiler.pipeline import check

LIMIT = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'
FIRST, MOST = 60, 2.8
"""The smaller of the files has so many elements; what grows with their square costs four times as much."""


def urdf(n: int) -> str:
    """A chain of joints, each of which follows the one before."""
    links, mimic = "".join(f'<link name="l{k}"/>' for k in range(n + 1)), '<mimic joint="j{}" multiplier="0.9"/>'
    joints = "".join(
        f'<joint name="j{k}" type="revolute"><parent link="l{k}"/><child link="l{k + 1}"/><axis xyz="0 0 1"/>{LIMIT}'
        f'{mimic.format(k - 1) if k else ""}</joint>'
        for k in range(n)
    )
    Path("u.tamp").write_text('module m from urdf "m.urdf" { effector A: "l0" sphere(1 cm) }\n')
    return f'<robot name="m">{links}{joints}</robot>'


def sdf(n: int) -> str:
    """A chain of joints, each link of which is placed by the one before."""
    links = "".join(f'<link name="l{k}"><pose relative_to="l{k - 1}">0 0 1 0 0 0</pose></link>' for k in range(1, n))
    axis = "<axis><xyz>0 0 1</xyz></axis>"
    joints = "".join(
        f'<joint name="j{k}" type="revolute"><parent>l{k}</parent><child>l{k + 1}</child>{axis}</joint>'
        for k in range(n - 1)
    )
    return f'<sdf version="1.9"><model name="m"><link name="l0"/>{links}{joints}</model></sdf>'


def mjcf(n: int) -> str:
    bodies = "".join(f'<body name="b{k}" pos="{k} 0 1"><joint/><geom size=".1"/></body>' for k in range(n))
    return f"<mujoco><worldbody>{bodies}</worldbody></mujoco>"


def rai(n: int) -> str:
    return "l0: {}\n" + "".join(f'l{k} (l{k - 1}): {{ joint: hingeX, Q: "t(0 0 .1)" }}\n' for k in range(1, n))


def rules(n: int) -> str:
    made = "".join(f"DecisionRule r{k} {{ X, {{ (p X) }} {{ (q X) }} }}\n" for k in range(n))
    return f"p q\na\nSTART_STATE {{ {'(p a) ' * n} }}\n{made}Rule {{ {{ (q a) }} {{ (QUIT) }} }}\n"


def pddl(n: int) -> str:
    names = " ".join(f"o{k}" for k in range(n))
    facts = " ".join(f"(p o{k} o{k} o{k})" for k in range(n))
    Path("p.pddl").write_text(
        f"(define (problem e) (:domain d) (:objects {names} - t1) (:init {facts}) (:goal (not (p o1 o1 o1))))"
    )
    actions = "".join(
        f"(:action a{k} :parameters (?x ?y ?z - t1) :precondition (p ?x ?y ?z) :effect (not (p ?x ?y ?z)))"
        for k in range(n)
    )
    return f"""(define (domain d) (:requirements :strips :typing) (:types t1)
(:predicates (p ?x ?y ?z - t1)) {actions})"""


def catalogue(n: int) -> str:
    pose = "[[1,0,0,0.1],[0,1,0,0],[0,0,1,0],[0,0,0,1]]"
    ball = '{"type": "sphere", "parameters": {"r": 0.1}}'
    ends = f'[{{"ID": "c", "gender": "m", "pose": {pose}}}]'
    modules = ", ".join(
        f'{{"ID": "m{k}", "bodies": [{{"ID": "a", "collision": [{ball}], "connectors": {ends}}}], "joints": []}}'
        for k in range(n)
    )
    return f'{{"modules": [{modules}]}}'


FORMATS: dict[str, Callable[[int], str]] = {
    "m.urdf": urdf, "m.sdf": sdf, "m.xml": mjcf, "s.g": rai, "r.fol": rules, "d.pddl": pddl, "c.json": catalogue,
}  # fmt: skip


def test_long_chains_of_followers_are_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Longer than Python may call itself; each of those that follow a hundredth as far comes to nothing."""
    monkeypatch.chdir(tmp_path)
    Path("m.urdf").write_text(urdf(1500))
    assert not any(d.is_error for d in check(Path("u.tamp")))
    Path("m.urdf").write_text(urdf(300).replace('"0.9"', '"0.001"'))
    assert [d.code for d in check(Path("u.tamp")) if d.is_error] == ["E0521"]


def calls(action: Callable[[], object]) -> int:
    """How many functions are called."""
    found = 0

    def count(_frame: FrameType, event: str, _argument: object) -> None:
        nonlocal found
        found += event in ("call", "c_call")

    sys.setprofile(count)
    try:
        action()
    finally:
        sys.setprofile(None)
    return found


@pytest.mark.parametrize("name", FORMATS)
def test_twice_as_much_costs_twice_as_much(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    monkeypatch.chdir(tmp_path)

    def read() -> None:
        if name == "m.urdf":
            assert not any(d.is_error for d in check(Path("u.tamp")))
        else:
            import_files([name, "p.pddl"] if name == "d.pddl" else [name])

    counted = []
    for size in (2, 2, FIRST, 2 * FIRST):  # what is loaded at first use counts once
        Path(name).write_text(FORMATS[name](size))
        counted.append(calls(read))
    _, nothing, some, twice = counted
    assert twice - nothing < MOST * (some - nothing), counted
