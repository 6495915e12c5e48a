"""Rules of rai: what they become, judged by a plain reading of them, and what is told where that cannot be."""

from __future__ import annotations

from itertools import permutations
from pathlib import Path

import pytest

from tamplang.compiler.importing.reading import import_files
from tamplang.compiler.pipeline import compile_text
from tamplang.compiler.symbolic.successors import Successors
from tamplang.langs.diagnostics import SourceError

from .conftest import Command, problems

RULES = """# A DECISION with wildcards.
is_gripper is_object is_place
on busy
ANY QUIT
START_STATE { (is_gripper h) (is_object a) (is_object b) (is_place goal) (is_place t) (on t a), (on a b) }
h a b t goal
DECISION pick {
  X, From, H
  pre: { (is_gripper H) (is_object X) (on From X) (on X ANY)! (busy H)! }
  post: { (on ANY X)! (on H X) (busy H) }
}
DecisionRule place { X, H, P,
  { (is_gripper H) (on H X) (is_place P) }
  { (on H X)! (busy H)! (on P X) }
}
Rule { { (on goal a) } { (QUIT) } }
"""
State = frozenset[tuple[str, ...]]


def program(folder: Path, rules: str, scene: str | None = None) -> tuple[str, list[str]]:
    """The text made of rules, and what is told."""
    (folder / "r.fol").write_text(rules)
    files = [str(folder / "r.fol")]
    if scene is not None:
        (folder / "s.g").write_text(scene)
        files.append(str(folder / "s.g"))
    made = import_files(files, "r")
    return made.text, [d.message for d in made.told]


def reached(start: State) -> set[State]:
    """All states that the rules above lead to, by rai's reading: variables differ, `ANY` matches anything, effects come
    one after the other."""
    found, waiting = {start}, [start]
    for state in waiting:
        for one, two, three in permutations(("h", "a", "b", "t", "goal"), 3):
            after: State | None = None
            held = {("is_gripper", three), ("is_object", one), ("on", two, one)} <= state
            if held and not any(f[:2] == ("on", one) for f in state) and ("busy", three) not in state:
                left = frozenset(f for f in state if f[0] != "on" or f[2] != one)
                after = left | {("on", three, one), ("busy", three)}
            if {("is_gripper", two), ("on", two, one), ("is_place", three)} <= state:
                after = state - {("on", two, one), ("busy", two)} | {("on", three, one)}
            if after is not None and after not in found:
                found.add(after)
                waiting.append(after)
    return found


def test_the_states_that_rules_lead_to_are_those_of_a_plain_reading(tmp_path: Path) -> None:
    text, told = program(tmp_path, RULES)
    assert not told
    successors = Successors(compile_text(text, "r")[0])
    states, waiting = {successors.initial}, [successors.initial]
    for state in waiting:
        for after, _ in successors.expand(state):
            if after not in states:
                states.add(after)
                waiting.append(after)
    facts = {frozenset(f for f in successors.facts(s) if f[0] in ("on", "busy")) for s in states}
    start = [("is_gripper", "h"), ("is_object", "a"), ("is_object", "b"), ("is_place", "goal"), ("is_place", "t"),
             ("on", "t", "a"), ("on", "a", "b")]  # fmt: skip
    plain = {frozenset(f for f in s if f[0] in ("on", "busy")) for s in reached(frozenset(start))}
    renamed = {frozenset(tuple("goal_" if w == "goal" else w for w in f) for f in s) for s in plain}
    assert facts == renamed and len(facts) == 9
    assert "goal  (on goal_ a)" in text


def test_a_scene_says_what_holds_at_the_start(tmp_path: Path) -> None:
    scene = """table: { shape: ssBox, Q: [0, 0, .6], size: [1, 1, .1, .02], logical: { is_place } }
hand: { shape: sphere, size: [.02], Q: [0, 0, 1.2], logical: { is_gripper: 2. } }
cube (table): { joint: rigid, shape: ssBox, Q: [.1, 0, .1], size: [.1, .1, .1, .02] }
mark (table): { shape: ssBox, Q: [-.3, 0, .06], size: [.2, .2, .01, .005], logical: { is_place } }
"""
    rules = "on\nDecisionRule take { X, H, { (is_gripper H) (on table X) } { (on table X)! (on H X) } }"
    text, _ = program(tmp_path, rules, scene)
    for fact in ("(is_gripper hand)", "(is_object cube)", "(is_box cube)", "(on table cube)", "(partOf table mark)"):
        assert f"fact {fact}" in text
    assert "(is_table table)" in text, "a constant of a rule is a parameter more"
    assert compile_text(text, "r")[0].rules["take"]


@pytest.mark.parametrize(
    ("rules", "said"),
    [
        ("p q\nRule chain { X, { (p X) } { (q X) } }", "follows by itself"),
        ("p\nDecisionRule never { X, { } { (p X) } }", "rai never takes it"),
        ("p a\nREWARD { { { (p a) r=10. } weight=1. } }", "rewards"),
        ("FOL_World{ hasWait=true, gamma=1. }", "waiting"),
        ("p q\nDecisionRule slow { X, { (p X) } { (q X)=1.5 } }", "lasts for a time"),
        ("Include: 'more.fol'", "import the file"),
    ],
)
def test_what_has_no_counterpart_is_told(tmp_path: Path, rules: str, said: str) -> None:
    text, told = program(tmp_path, f"{rules}\np2\nDecisionRule x {{ Y, {{ (p2 Y) }} {{ (p2 Y)! }} }}")
    assert any(said in message for message in told), told
    assert "rule x(" in text


@pytest.mark.parametrize(
    ("rules", "code"),
    [
        ("p\nDecisionRule r { X, { (p X) } { (q X) } }", "E0022"),
        ("p\nDecisionRule r { X Y, { (p X) } { (p Y) } }", "E0022"),
        ("p\nDecisionRule r { X X, { (p X) } { (p X)! } }", "E0022"),
        ("p\nDecisionRule r { X, { (p X) } { (p ANY) } }", "E0020"),
        ("p\nDecisionRule r { X, { (p X) }", "E0019"),
        ("p\nDecisionRule r { X, { (p X) } }", "E0019"),
        ("p\nDecisionRule r { X, { (p X) } { (p X) } { (p X)! } p=[.5 .5] }", "E0019"),
        ("p\nSTART_STATE { (p a)! }\na", "E0020"),
        ("p\nSTART_STATE { p a }", "E0019"),
        ("p )", "E0019"),
        ("p\nDecisionRule r { X, { (p (X)) } { } }", "E0019"),
        ("FOL_World { " + "{" * 200, "E0019"),
        ("p \"cut", "E0019"),
    ],
)  # fmt: skip
def test_faults_have_a_place(tmp_path: Path, rules: str, code: str) -> None:
    with pytest.raises(SourceError) as raised:
        program(tmp_path, rules)
    assert raised.value.diagnostics[0].code == code
    assert all(d.span is not None for d in raised.value.diagnostics)


def test_things_that_only_the_goal_names_are_there(command: Command) -> None:
    Path("r.fol").write_text("lit on\na b\nSTART_STATE { (lit a) }\nDecisionRule go { X, { (lit X) } { (on X) } }\n"
                             "Rule { { (on b) } { (QUIT) } }\n")  # fmt: skip
    assert command("import", "r.fol", "-o", "task.tamp").status == 0
    text = Path("task.tamp").read_text()
    assert "object b: sphere(1 cm)" in text and "goal  (on b)" in text
    assert problems(command, "task.tamp") in ([], ["E0503"])  # nothing is wrong but that it cannot be reached
