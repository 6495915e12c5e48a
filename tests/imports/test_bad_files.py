"""Files of others that are broken, cut off, huge, of another kind or made to harm: a code with its place, or a program
that checks; never a traceback, and nothing written where there is a fault."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from .conftest import Answer, Command, problems

SCENE = """a: { shape: ssBox, Q: [0, 0, 1], size: [.1, .1, .1, .01] }
b (a): { joint: hingeX, Q: "t(0 0 .1)", limits: [-1, 1] }
c (b): { shape: sphere, size: [.1] }
"""
RULES = "p q\nSTART_STATE { (p a) }\na\nDecisionRule r { X, { (p X) } { (q X) } }\nRule { { (q a) } { (QUIT) } }\n"
MESH = "<mesh><uri>/dev/zero</uri></mesh>"
BOX, BALL = "<box><size>0.1 0.1 0.1</size></box>", "<sphere><radius>0.1</radius></sphere>"
SDF = f"""<sdf version="1.9"><model name="m">
<link name="l"><collision name="c"><geometry>{BOX}</geometry></collision></link>
<link name="k"><collision name="c"><geometry>{BALL}</geometry></collision></link>
<joint name="j" type="revolute"><parent>l</parent><child>k</child>
<axis><xyz>0 0 1</xyz><limit><lower>-1</lower><upper>1</upper></limit></axis></joint></model></sdf>"""
MJCF = """<mujoco model="m"><worldbody><geom name="f" type="box" size="1 1 0.1"/>
<body name="a" pos="0 0 0.4"><geom name="g" size="0.1"/><joint name="j" axis="0 0 1" range="-10 10"/>
<body name="b" pos="0.1 0 0.1"><geom name="h" size="0.1"/><joint name="k" axis="0 1 0" range="-10 10"/></body>
</body></worldbody></mujoco>"""
MATRIX = "[[1, 0, 0, 0.1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]"
CATALOGUE = f"""{{"modules": [{{"ID": "m", "bodies": [
{{"ID": "a", "mass": 0.1, "collision": [{{"type": "box", "parameters": {{"x": 0.1, "y": 0.1, "z": 0.1}}}}],
 "connectors": [{{"ID": "c", "gender": "m", "pose": {MATRIX}}}]}},
{{"ID": "b", "collision": [{{"type": "sphere", "parameters": {{"r": 0.1}}, "pose": {MATRIX}}}]}}],
"joints": [{{"ID": "j", "parent": "a", "child": "b", "type": "revolute", "poseParent": {MATRIX},
 "limits": {{"positionLower": -1.1, "positionUpper": 1.1}}}}]}}]}}"""
URDF = """<robot name="m">
<link name="a"><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
<link name="b"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
<collision><origin xyz="0.1 0 0"/><geometry><sphere radius="0.1"/></geometry></collision></link>
<joint name="j" type="revolute"><parent link="a"/><child link="b"/><origin xyz="0 0 0.1" rpy="0 0 1"/>
<axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"""
USING = 'module m from urdf "m.urdf" { effector A: "a" sphere(1 cm) effector B: "b" sphere(1 cm) }\n'
DOMAIN = """(define (domain d) (:requirements :strips :typing) (:types t1)
(:predicates (p ?x - t1) (q ?x - t1))
(:action a1 :parameters (?x - t1) :precondition (p ?x) :effect (and (q ?x) (not (p ?x)))))"""
PROBLEM = "(define (problem e) (:domain d) (:objects o1 - t1) (:init (p o1)) (:goal (q o1)))"
GOOD = {
    "s.g": SCENE, "r.fol": RULES, "m.sdf": SDF, "d.pddl": DOMAIN, "m.xml": MJCF, "c.json": CATALOGUE, "m.urdf": URDF,
}  # fmt: skip
WHOLE = ("[E0013]", "[E0014]", "[E0015]", "[E0021]")
"""What is said of a whole file has no place in it."""
BAD: dict[str, Callable[[str], str]] = {
    "empty": lambda t: "",
    "blank": lambda t: " \n\n",
    "with a zero byte": lambda t: f"{t[:20]}\0{t[20:]}",
    **{f"cut off after {k} eighths": lambda t, k=k: t[: len(t) * k // 8] for k in range(1, 8)},
    "twice": lambda t: t + t,
    "with huge numbers": lambda t: t.replace("1", "1e999"),
    "with NaN": lambda t: t.replace("1", "nan"),
    "with negative sizes": lambda t: t.replace(".1", "-.1").replace("0-.1", "-0.1"),
    "with sizes of 0": lambda t: t.replace("1", "0"),
    "with words for numbers": lambda t: t.replace("1", "one"),
    "nested deeply inside": lambda t: t[:10] + "{(" * 3000 + t[10:],
    "nested deeply": lambda t: ("<sdf>" if t[0] == "<" else "(") * 3000,
    "from right to left": lambda t: t.replace("a", "\u202ea"),
    "with long names": lambda t: t.replace('m"', "m" * 10_000 + '"').replace("a:", "a" * 10_000 + ":"),
    "with control characters": lambda t: t.replace(" ", "\x01"),
    "without quotes": lambda t: t.replace('"', ""),
    "without ends": lambda t: t.replace("}", "").replace(">", "").replace(")", ""),
    "in capitals": str.upper,
    "backwards": lambda t: t[::-1],
    "with a document type": lambda t: f'<!DOCTYPE x [<!ENTITY a "b">]>{t}',
    "with blanks in names": lambda t: t.replace('name="', 'name="1 2 '),
    "of another kind": lambda t: CATALOGUE if t[0] == "<" else MJCF,
    "with all names the same": lambda t: re.sub(r'(name="|"ID": ")\w+"', r'\1a"', t).replace("b (a)", "a (a)"),
    "in a ring": lambda t: t.replace("<parent>l", "<parent>k").replace('parent link="a"', 'parent link="b"')
    .replace('"parent": "a"', '"parent": "b"').replace("c (b)", "b (c)").replace("l1", "l1"),
    "that names what is not there": lambda t: t.replace("<parent>l", "<parent>no").replace('link="a"', 'link="no"')
    .replace('"child": "b"', '"child": "no"').replace("(b)", "(no)").replace("- t1", "- no"),
    "that includes itself": lambda t: t.replace("<worldbody>", '<include file="m.xml"/><worldbody>')
    + ("\nInclude: <s.g>" if "ssBox" in t else ""),
    "that includes a device": lambda t: t.replace("<worldbody>", '<include file="/dev/zero"/><worldbody>')
    .replace("<sphere radius", '<mesh filename="/dev/zero"/><sphere radius').replace(BALL, MESH)
    .replace('"sphere", "parameters": {', '"mesh", "parameters": {"file": "/dev/zero", ')
    + ("\nInclude: </dev/zero>" if "ssBox" in t else ""),
    "with many thousand elements": lambda t: t.replace("><", ">" + "<a/>" * 20_000 + "<", 1).replace(
        '"joints": [', '"x": [' + "0, " * 50_000 + '0], "joints": [') + " " * 1_000_000,
    "with comments that never end": lambda t: "<!--" * 100_000 + t,
    "with instructions that never end": lambda t: "<?" * 200_000 + t,
    "behind many blanks": lambda t: " " * 900_000 + t,
    "far away": lambda t: t.replace("0 0 1", "0 0 1e300").replace('radius="', 'radius="1e300'),
    "with a null": lambda t: t.replace('"b"', "null").replace("[", "[null, "),
    "with letters of other scripts": lambda t: t.replace('"a"', '"\u0661\u4e2d"').replace("a (", "\u0661 ("),
}


def read(command: Command, name: str) -> Answer:
    """What the command says that takes a file in: a module of a program, or an import."""
    Path("p.pddl").write_text(PROBLEM)
    Path("u.tamp").write_text(USING)
    if name == "m.urdf":
        return command("check", "u.tamp")
    return command("import", name, *(["p.pddl"] if name == "d.pddl" else []), "-o", "o.tamp")


@pytest.mark.parametrize("name", GOOD)
def test_no_file_harms(command: Command, name: str) -> None:
    assert len({change(GOOD[name]) for change in BAD.values()} - {GOOD[name]}) >= 20
    for kind, change in BAD.items():
        Path(name).write_text(change(GOOD[name]), encoding="utf-8")
        answer = read(command, name)
        written = sorted(f.name for f in Path().glob("o*"))
        if answer.status == 0:
            checked = problems(command, "u.tamp" if name == "m.urdf" else "o.tamp")
            assert all(code[0] == "W" for code in checked), (kind, checked)
        else:
            assert answer.status == 1 and "error[E" in answer.told and not written, (kind, answer.told[:400], written)
            placed = any(mark in answer.told for mark in (f"{name}:", "p.pddl:", "u.tamp:", *WHOLE))
            assert placed, (kind, answer.told[:400])
        for file in written:
            Path(file).unlink()


@pytest.mark.parametrize("name", GOOD)
def test_what_is_spoilt_was_good_before(command: Command, name: str) -> None:
    Path(name).write_text(GOOD[name])
    answer = read(command, name)
    assert answer.status == 0 and (name == "m.urdf" or Path("o.tamp").exists()), answer.told


@pytest.mark.parametrize(
    ("name", "number", "where"), [("m.xml", "0 0 0.4", "m.xml:2:25"), ("m.sdf", "<box><size>0.1", "m.sdf:2:")]
)
def test_what_lies_too_far_off_is_told_where_it_stands(command: Command, name: str, number: str, where: str) -> None:
    text = GOOD[name].replace(number, f"{number[:-3]}7e250", 1)
    Path(name).write_text(text + "<!-- 1e-320 0.0 1e999 -->")
    answer = read(command, name)  # beside numbers that are next to nothing, too
    assert answer.status == 1 and "no place in a scene" in answer.told and where in answer.told, answer.told
