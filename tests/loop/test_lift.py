"""A rover rides a lift that stands at its limit: rows all along a phase, joints at their limits, what is kept in
place."""

from __future__ import annotations

from pathlib import Path

import pytest

from tamplang.compiler.pipeline import compile_problem
from tamplang.runtime.planner.lgp import Outcome, SolveOptions, solve

TEXT = """
import std.logic
import std.motion

type wheelset < effector
type floorplan < object
type deck < effector
type level < object
predicate (upAt D: deck, L: level)
predicate (parkedOn W: wheelset, X: object)

module rover(range: length = 5 m) {
    joint drive: planar(x, y) in (-range, -range) .. (range, range)
    effector W: wheelset box(2 mm, 2 mm, 2 mm) normal (0, 0, -1)
    link 2 cm
    link 10 cm: box(30 cm, 24 cm)
}
module elevator {
    effector foot: effector box(2 mm, 2 mm, 2 mm) normal (0, 0, -1)
    joint hoist: prismatic(z) in 0 m .. 1.2 m
    link 2 cm
    effector plate: deck box(60 cm, 50 cm, 2 cm)
}
motion [rolls W: wheelset, Y: object] borne rest {
    at switch bottom(W) = top(Y)
    at switch inside(W, Y) >= 5 cm
    at switch axis(W, z) = (0, 0, -1)
}
motion [driving W: wheelset, Y: object] {
    during bottom(W) = top(Y)
    during axis(W, z) = (0, 0, -1)
}
motion [levelWith D: deck, L: level] { at switch top(D) = top(L) }
placement (W: wheelset) on (Y: object) { (on Y W), (support W), [stable Y W], [rolls W Y] }

rule ride(D: deck, L: level) {
    pre   not (upAt D L)
    post  not (upAt D ANY), (upAt D L), not [levelWith D ANY], [levelWith D L]
}
predicate (loose W: wheelset)
rule start(W: wheelset, L: level) {
    pre   (on L W), not (loose W)
    post  (loose W), not [stable L W], not [rolls W L], [driving W L]
}
rule startOff(W: wheelset, D: deck) {
    pre   (on D W), not (loose W)
    post  (loose W), not [stable D W], not [rolls W D], [driving W D]
}
rule driveOnto(W: wheelset, D: deck, L: level) {
    pre   (on L W), (upAt D L), (loose W)
    post  not (on L W), (on D W), not (loose W), not [driving W L], [stable D W], [rolls W D]
}
rule driveOff(W: wheelset, D: deck, L: level) {
    pre   (on D W), (upAt D L), (loose W)
    post  not (on D W), (on L W), not (loose W), not [driving W D], [stable L W], [rolls W L]
}
task up(range: length = 5 m) {
    level ground: box(3 m, 2 m, 4 cm) at (-1.9 m, 0, -2 cm)
    level upper: box(2 m, 2 m, 10 cm) at (1.4 m, 0, 95 cm)
    object pit: box(60 cm, 2 m, 4 cm) at (0, 0, -6 cm)
    elevator e: at (0, 0, -3 cm)
    rover(range = range) r: W on ground at (50 cm, 0)
    goal (on upper r.W)
}
"""


def _outcome(folder: Path, text: str, range_: str, seed: int) -> Outcome:
    (folder / "lift.tamp").write_text(text)
    problem = compile_problem(folder / "lift.tamp", "up", {"range": range_}, seed=seed)[0]
    return solve(problem, SolveOptions(seed=seed, time=60.0))


@pytest.mark.parametrize(("range_", "seed"), [("4m", 1), ("5m", 0), ("5m", 2)])
def test_a_rover_takes_the_lift(tmp_path: Path, range_: str, seed: int) -> None:
    """Wheels touch the floor all along in any unit of length, and the deck, at the lower end of its way, stays there
    between slices too."""
    outcome = _outcome(tmp_path, TEXT, range_, seed)
    assert outcome.status == "solved"
    verdict = outcome.plans[0].verdict
    assert verdict is not None and verdict.verified


def test_what_keeps_the_wheels_in_place_is_told(tmp_path: Path) -> None:
    """Without `start` the wheels are kept where they are until the switch that is to have them elsewhere."""
    text = TEXT.replace("(upAt D L), (loose W)\n    post  not (on L W), (on D W), not (loose W), not [driving W L],",
                        "(upAt D L)\n    post  not (on L W), (on D W), not [stable L W], not [rolls W L],")  # fmt: skip
    begin, end = text.index("rule start("), text.index("rule startOff(")
    text = text[:begin] + text[end:]
    assert "not [stable L W], not [rolls W L], [stable D W]" in text
    outcome = _outcome(tmp_path, text, "5m", 0)
    told = [d for d in outcome.explanation if "driveOnto" in d.message]
    assert told and told[0].note is not None
    assert "[stable ground r.W] holds since the start until the switch of driveOnto" in told[0].note
