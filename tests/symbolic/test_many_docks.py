"""Modules with more docks than two: which chains a rule is tried for."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

from tamplang.compiler.ir import Chain, Formula
from tamplang.compiler.pipeline import compile_text
from tamplang.compiler.symbolic.algebra import Environment
from tamplang.compiler.symbolic.chains import KnownFacts
from tamplang.compiler.symbolic.guards import Guards
from tamplang.compiler.symbolic.successors import Successors

CUBES = """
import std.rules
module cube {
    effector A: gripper sphere(2 cm) normal (0, 0, -1)
    link 10 cm: capsule(1.5 cm)
    branch { link (0, 5 cm, 0) effector L: dock sphere(1 cm) normal (0, 1, 0) }
    joint j: revolute(y) in -90 deg .. 90 deg
    branch { link (0, -5 cm, 0) effector R: dock sphere(1 cm) normal (0, -1, 0) }
    link 10 cm: capsule(1.5 cm)
    effector B: gripper sphere(2 cm)
    fact (linked A B)
}
task row(n: int = 3) {
    base floor: box(4 m, 2 m, 2 cm) at (0, 0, 0)
    for k in 1 .. n { cube m[k]: A on floor at (30 cm * k - 60 cm, 0) }
    goal (connected m[1].B m[2].B)
}
"""


def test_ends_that_a_rule_names_choose_its_chains(monkeypatch: pytest.MonkeyPatch) -> None:
    looks = []
    asked = Guards.live

    def counted(
        guards: Guards, conjuncts: Sequence[Formula], env: Environment, word: KnownFacts | None
    ) -> list[Formula] | None:
        looks.append(env)
        return asked(guards, conjuncts, env, word)

    monkeypatch.setattr(Guards, "live", counted)
    successors = Successors(compile_text(CUBES)[0])
    found = [successors.action(number) for _, number in successors.expand(successors.initial)]
    chains = [[c for c in a.args if isinstance(c, Chain)] for a in found if a.rule == "connect"]
    docked = [(p.last, q.first) for p, q in chains]
    assert len(set(docked)) == len(docked) == 3 * 3 * 2 * 3
    assert all(p.rpartition(".")[0] != q.rpartition(".")[0] for p, q in docked)
    assert len(looks) < 3000
