"""Files of others that are broken, cut off, huge, of another kind or made to harm: a code with its place, or a program
that checks; never a traceback, and nothing written where there is a fault."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from .conftest import Command, problems

SCENE = """a: { shape: ssBox, Q: [0, 0, 1], size: [.1, .1, .1, .01] }
b (a): { joint: hingeX, Q: "t(0 0 .1)", limits: [-1, 1] }
c (b): { shape: sphere, size: [.1] }
"""
RULES = "p q\nSTART_STATE { (p a) }\na\nDecisionRule r { X, { (p X) } { (q X) } }\nRule { { (q a) } { (QUIT) } }\n"
BOX, BALL = "<box><size>0.1 0.1 0.1</size></box>", "<sphere><radius>0.1</radius></sphere>"
SDF = f"""<sdf version="1.9"><model name="m">
<link name="l"><collision name="c"><geometry>{BOX}</geometry></collision></link>
<link name="k"><collision name="c"><geometry>{BALL}</geometry></collision></link>
<joint name="j" type="revolute"><parent>l</parent><child>k</child>
<axis><xyz>0 0 1</xyz><limit><lower>-1</lower><upper>1</upper></limit></axis></joint></model></sdf>"""
DOMAIN = """(define (domain d) (:requirements :strips :typing) (:types t1)
(:predicates (p ?x - t1) (q ?x - t1))
(:action a1 :parameters (?x - t1) :precondition (p ?x) :effect (and (q ?x) (not (p ?x)))))"""
PROBLEM = "(define (problem e) (:domain d) (:objects o1 - t1) (:init (p o1)) (:goal (q o1)))"
GOOD = {"s.g": SCENE, "r.fol": RULES, "m.sdf": SDF, "d.pddl": DOMAIN}
WHOLE = ("[E0013]", "[E0014]", "[E0021]")
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
}


@pytest.mark.parametrize("name", GOOD)
def test_no_file_harms(command: Command, name: str) -> None:
    assert len(BAD) >= 20
    more = ["p.pddl"] if name == "d.pddl" else []
    Path("p.pddl").write_text(PROBLEM)
    for kind, change in BAD.items():
        Path(name).write_text(change(GOOD[name]), encoding="utf-8")
        answer = command("import", name, *more, "-o", "o.tamp")
        written = sorted(f.name for f in Path().glob("o*"))
        if answer.status == 0:
            assert problems(command, "o.tamp") == [] or all(c[0] == "W" for c in problems(command, "o.tamp")), kind
        else:
            assert answer.status == 1 and "error[E" in answer.told and not written, (kind, answer.told[:400], written)
            placed = any(mark in answer.told for mark in (*(f"{n}:" for n in (name, *more)), *WHOLE))
            assert placed, (kind, answer.told[:400])
        for file in written:
            Path(file).unlink()


@pytest.mark.parametrize("name", GOOD)
def test_what_is_spoilt_was_good_before(command: Command, name: str) -> None:
    Path(name).write_text(GOOD[name])
    Path("p.pddl").write_text(PROBLEM)
    answer = command("import", name, *(["p.pddl"] if name == "d.pddl" else []), "-o", "o.tamp")
    assert answer.status == 0 and Path("o.tamp").exists(), answer.told
