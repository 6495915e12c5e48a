"""`ANY` in a condition stands for some object, as `exists` does."""

from __future__ import annotations

import pytest

import tamplang

TEXT = """
type thing < object
predicate (p A B: object)
predicate (q A: object)
predicate (r A B: object) functional in A
derived (some A: object) = (p A ANY)
derived (both A B: object) = (p A B) and (r B ANY)
rule one(X: thing) { pre (some ANY), not (q ANY), not (r X ANY) post (q X), (r X X) }
rule two(X: thing) { pre (both ANY X), (p ANY ANY) post not (q ANY), if (r X ANY) and not (p X ANY) { (p X X) } }
task t {
    thing a: box(1 cm, 1 cm, 1 cm) at (0, 0, 0)
    thing b: box(1 cm, 1 cm, 1 cm) at (1 m, 0, 0)
    fact (p FACT)
    goal (p ANY ANY), (p b b), not (q ANY)
}
"""
SPELLED = {
    "= (p A ANY)": "= exists X: object { (p A X) }",
    "(some ANY)": "exists Y: object { (some Y) }",
    "not (q ANY), not (r X ANY)": "not exists Y: object { (q Y) }, not exists Y: object { (r X Y) }",
    "(r B ANY)": "exists Z: object { (r B Z) }",
    "(both ANY X), (p ANY ANY)": "exists Y: object { (both Y X) }, exists Y Z: object { (p Y Z) }",
    "if (r X ANY) and not (p X ANY)": "if exists Z: object { (r X Z) } and not exists Z: object { (p X Z) }",
    "goal (p ANY ANY)": "goal exists Y Z: object { (p Y Z) }",
    "not (q ANY)\n": "not exists Y: object { (q Y) }\n",
}


def test_any_stands_for_some_object() -> None:
    text = spelled = TEXT.replace("FACT", "a b")
    for short, long in SPELLED.items():
        spelled = spelled.replace(short, long)
    assert spelled.count("ANY") == 1
    for program in (text, spelled):
        found = tamplang.loads(program).solve(time=20.0).plan
        assert found is not None and [str(action) for action in found.actions] == ["one(b)", "two(b)"]


def test_any_stands_for_no_object_where_there_is_none() -> None:
    with pytest.raises(tamplang.SourceError, match="E0503"):
        tamplang.loads(TEXT.replace("FACT", "a a"))
