"""The words that programs of families are made of."""

from __future__ import annotations

from collections.abc import Callable, Mapping

MAIN = "main.tamp"
Texts = Mapping[str, str]
WORDS = """
type base < object
type foot < effector
predicate (at X: object)
predicate (open X: object)
derived (both X: object) = (at X) and (open X)
module arm(size: length = 1 m) {
    effector A: foot sphere(5 cm) normal (0, 0, -1)
    joint j: revolute(z) in -3 rad .. 3 rad
    link 0.5 * size: capsule(4 cm)
    effector B: foot sphere(5 cm)
}
motion [held X Y: object] { keep pose(Y, X) }
"""
"""What the programs below are made of."""


def task_text(items: str, goal: str = "(at b)", rule: str = "") -> str:
    """A task over one body and one arm, which a rule can finish."""
    rule = rule or "rule go(X: base) { pre not (at X) post (at X) }"
    return f"""{rule}
task t() {{
    base g: box(1 m, 1 m, 5 cm) at (0, 0, 0)
    base b: box(20 cm, 20 cm, 5 cm) at (1 m, 0, 0)
    arm r: at (0, 0, 1 m)
    {items}
    goal {goal}
}}
"""


def one(text: str) -> Texts:
    return {MAIN: WORDS + text}


def lines(line: Callable[[int], str], count: int, start: int = 1) -> str:
    return "\n".join(line(i) for i in range(start, count + 1)) + "\n"
