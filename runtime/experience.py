"""What verdicts on some windows of actions say about similar ones.

Two windows are similar when they differ only in names: of modules of one type, of ends of a reversible module, of
bodies of one shape. A window that strains the numeric conditions of its rules at least as much as a similar one that
motion refused is expected to be refused too; one action that strains them no more than one that succeeded is expected
to succeed. Expectations steer the search; no verdict rests on them, and `forget` drops them.
"""

from __future__ import annotations

from collections.abc import Sequence

from ..compiler.ir import Action, Problem
from .search.conflicts import Lifting, Names

Kind = tuple[object, ...]
NEAR = 0.005
"""By how much strains may differ and still count as the same."""


class Experience:
    """Refused and accepted windows by kind, with the strain of each of their actions."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self._lifting = Lifting(problem)
        self._refused: dict[tuple[Kind, bool], list[tuple[float, ...]]] = {}
        self._lengths: set[int] = set()
        self._accepted: dict[Kind, float] = {}

    def lifted(self, actions: Sequence[Action]) -> Kind:
        """The actions up to names of interchangeable modules and ends."""
        return self._lifting.actions(actions)[0]

    def refuse(self, actions: Sequence[Action], strains: Sequence[float], from_start: bool) -> None:
        """Remember that these actions were refused one after the other."""
        self._lengths.add(len(actions))
        self._refused.setdefault((self._kind(actions), from_start), []).append(tuple(strains))

    def accept(self, action: Action, strain: float) -> None:
        """Remember that an action alone was accepted from an unknown start."""
        kind = self._kind((action,))
        self._accepted[kind] = max(self._accepted.get(kind, 0.0), strain)

    def expects_success(self, action: Action, strain: float) -> bool:
        return strain <= self._accepted.get(self._kind((action,)), -1.0) + NEAR

    def expected_refusals(self, actions: Sequence[Action], strains: Sequence[float]) -> list[tuple[int, int, bool]]:
        """Windows (first, last, from the start) of a plan that are expected to be refused, shortest first."""
        found: list[tuple[int, int, bool]] = []
        for length in sorted(self._lengths):
            for first in range(len(actions) - length + 1):
                last = first + length - 1
                if any(f >= first and e <= last for f, e, _ in found):
                    continue
                kind = self._kind(actions[first : last + 1])
                for from_start in (False, True) if first == 0 else (False,):
                    known = self._refused.get((kind, from_start), ())
                    if any(_at_least(strains[first : last + 1], refused) for refused in known):
                        found.append((first, last, from_start))
                        break
        return found

    def forget(self) -> None:
        """Drop the refusals."""
        self._refused.clear()
        self._lengths.clear()

    def _kind(self, actions: Sequence[Action]) -> Kind:
        """The lifted actions, with bodies replaced by their shapes; the same body twice is told from two bodies."""
        names = Names()
        bodies: dict[str, int] = {}
        signature: list[object] = []
        for action in actions:
            parts: list[object] = [action.rule]
            for arg in action.args:
                body = self.problem.world.bodies.get(arg) if isinstance(arg, str) else None
                if body is None or not isinstance(arg, str):
                    parts.append(self._lifting.token(arg, names))
                else:
                    number = bodies.setdefault(arg, len(bodies))
                    parts.append((body.shape.kind, body.shape.size, number))
            signature.append(tuple(parts))
        return tuple(signature)


def _at_least(strains: Sequence[float], refused: Sequence[float]) -> bool:
    return all(a >= b - NEAR for a, b in zip(strains, refused, strict=True))
