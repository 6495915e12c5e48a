"""What verdicts on some windows of actions say about similar ones.

Two windows are similar when they differ only in names: of modules of one type, of ends of a reversible module, of
bodies of one shape. Bodies that never move keep their names in actions without strain, as nothing else tells where they
lie. Where windows open the plan, modules keep theirs, as each starts in a place of its own. A window that strains the
numeric conditions of its rules at least as much as a similar one that motion refused is expected to be refused too; one
action that strains them no more than one that succeeded is expected to succeed. Expectations steer the search; no
verdict rests on them, and `forget` drops them.
"""

from __future__ import annotations

from collections.abc import Sequence

from ....compiler.ir import Fact, Problem
from ...skeleton import Phase
from .lifting import Lifting, Names, objects_of
from .settings import CONFLICTS

Kind = tuple[object, ...]


class GeneralisedNoGoods:
    """Refused and accepted windows by kind, with the strain of each of their actions."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self._lifting = Lifting(problem)
        self._refused: dict[tuple[Kind, bool], list[tuple[float, ...]]] = {}
        self._lengths: set[int] = set()
        self._accepted: dict[Kind, float] = {}

    def lifted(self, phases: Sequence[Phase]) -> Kind:
        """A window and the relations that hold before it among what it concerns, up to names of interchangeable modules
        and ends."""
        return self._signature(phases, bodies=False)

    def refuse(self, phases: Sequence[Phase], strains: Sequence[float], from_start: bool) -> None:
        """Remember that these actions were refused one after the other."""
        self._lengths.add(len(phases))
        self._refused.setdefault((self._kind(phases, strains, from_start), from_start), []).append(tuple(strains))

    def accept(self, phase: Phase, strain: float) -> None:
        """Remember that an action alone was accepted from an unknown start."""
        kind = self._kind((phase,), (strain,))
        self._accepted[kind] = max(self._accepted.get(kind, 0.0), strain)

    def expects_success(self, phase: Phase, strain: float) -> bool:
        return strain <= self._accepted.get(self._kind((phase,), (strain,)), -1.0) + CONFLICTS.similar_strain

    def expected_refusals(self, phases: Sequence[Phase], strains: Sequence[float]) -> list[tuple[int, int, bool]]:
        """Windows (first, last, from the start) of a plan that are expected to be refused, shortest first."""
        found: list[tuple[int, int, bool]] = []
        for length in sorted(self._lengths):
            for first in range(len(phases) - length + 1):
                last = first + length - 1
                if any(f >= first and e <= last for f, e, _ in found):
                    continue
                for from_start in (False, True) if first == 0 else (False,):
                    strained = strains[first : last + 1]
                    kind = self._kind(phases[first : last + 1], strained, from_start)
                    known = self._refused.get((kind, from_start), ())
                    if any(_at_least(strained, refused) for refused in known):
                        found.append((first, last, from_start))
                        break
        return found

    def leave_start(self) -> None:
        """Drop the refusals that hold from the start only: the run goes on from another state."""
        self._refused = {key: known for key, known in self._refused.items() if not key[1]}

    def forget(self) -> None:
        """Drop the refusals."""
        self._refused.clear()
        self._lengths.clear()

    def _kind(self, phases: Sequence[Phase], strains: Sequence[float], from_start: bool = False) -> Kind:
        """As `lifted`, with bodies replaced by their shapes; the same body twice is told from two bodies. Modules
        keep their names from the start, bodies that never move in actions without strain."""
        return self._signature(phases, bodies=True, modules=not from_start, strains=strains)

    def _signature(
        self, phases: Sequence[Phase], bodies: bool, modules: bool = True, strains: Sequence[float] = ()
    ) -> Kind:  # fmt: skip
        names = Names()
        numbers: dict[str, int] = {}
        world = self.problem.world
        unlike = {
            arg for phase, strain in zip(phases, strains, strict=False) if not strain for arg in phase.action.args
            if isinstance(arg, str) and arg in world.bodies and not world.bodies[arg].movable
        }  # fmt: skip

        def token(arg: object) -> object:
            body = world.bodies.get(arg) if bodies and isinstance(arg, str) else None
            if body is None or not isinstance(arg, str):
                return self._lifting.token(arg, names) if modules else arg
            return arg if arg in unlike else (body.shape, numbers.setdefault(arg, len(numbers)))

        actions = tuple((p.action.rule, *map(token, p.action.args)) for p in phases)
        relations = frozenset((fact[0], *map(token, fact[1:])) for fact in self._relations(phases))
        return actions, relations

    def _relations(self, phases: Sequence[Phase]) -> list[Fact]:
        """The motion literals before a window that tie its modules and things, and what is tied to them, to
        anything."""
        world = self.problem.world
        movers = world.modules.keys() | {name for name, body in world.bodies.items() if body.movable}
        concerned = {world.owner(name) for phase in phases for name in objects_of(phase.action)} & movers
        found: list[Fact] = []
        waiting = sorted(phases[0].mode)
        grown = True
        while grown:
            tied = [fact for fact in waiting if any(world.owner(arg) in concerned for arg in fact[1:])]
            waiting = [fact for fact in waiting if fact not in tied]
            found += tied
            more = {world.owner(arg) for fact in tied for arg in fact[1:]} & movers
            grown = not more <= concerned
            concerned |= more
        return found


def _at_least(strains: Sequence[float], refused: Sequence[float]) -> bool:
    return all(a >= b - CONFLICTS.similar_strain for a, b in zip(strains, refused, strict=True))
