"""How near a task that is proved infeasible comes to an action that its goal needs: a look at every state that can be
reached."""

from __future__ import annotations

from collections.abc import Sequence

from ....compiler.ir import Action, Fact, Forall, Formula, Problem, Rule, conjuncts, span_of
from ....compiler.printing_terms import format_formula
from ....compiler.symbolic.algebra import Environment
from ....compiler.symbolic.renaming import renaming
from ....compiler.symbolic.successors import Successors
from ....langs.frozen import dataclass
from ....langs.source import Span
from ...native import MissingLibrary
from ..search.stepper import Stepper
from .settings import CONFLICTS


@dataclass(frozen=True, slots=True)
class Nearest:
    """The action of a rule that lacks least in any state, the actions that lead to that state, and the parts of its
    condition that are false there, each with the first values for which a `forall` fails."""

    action: Action
    before: tuple[Action, ...]
    missing: tuple[Formula, ...]
    where: str

    @property
    def place(self) -> Span | None:
        """Where the first missing part stands."""
        return next(filter(None, map(span_of, self.missing)), None)

    def __str__(self) -> str:
        after = f"after {', '.join(map(str, self.before))}" if self.before else "at the start"
        lacks = " and ".join(f"`{format_formula(part)}`" for part in self.missing)
        return f"{self.action} comes nearest {after}: it still lacks {lacks}{self.where}"


def nearest(problem: Problem, rules: Sequence[Rule]) -> Nearest | None:
    """The nearest action of all `rules`; None where they are too many to look at, or coal is missing."""
    found: tuple[tuple[int, int], Nearest] | None = None
    looks = 0
    try:
        stepper = Stepper(problem)
        for facts, before in _reached(problem):
            for rule in rules:
                parts = [*conjuncts(rule.condition)]
                for values in stepper.environments(facts, rule.variables):
                    looks += 1
                    if looks > CONFLICTS.most_looks:
                        return None
                    missing = tuple(part for part in parts if not stepper.holds(facts, part, values))
                    failing = [_failing(stepper, facts, part, values) for part in missing]
                    rank = len(missing), sum(map(len, failing))
                    if missing and (found is None or rank < found[0]):
                        action = Action(rule.name, tuple(values[v.name] for v in rule.variables))
                        found = rank, Nearest(action, before, missing, _told(failing))
    except MissingLibrary:
        return None
    return found[1] if found else None


def _reached(problem: Problem) -> list[tuple[frozenset[Fact], tuple[Action, ...]]]:
    """Every state that can be reached, one of those that are alike up to names, each with the shortest way there; none
    where they are too many."""
    successors = Successors(problem)
    names = renaming(successors)
    queue: list[tuple[int, tuple[int, ...]]] = [(successors.initial, ())]
    seen = {names.canonical(successors.initial) if names else successors.initial}
    for state, way in queue:
        for following, number in successors.expand(state):
            key = names.canonical(following) if names else following
            if key not in seen:
                seen.add(key)
                queue.append((following, (*way, number)))
        if len(queue) > CONFLICTS.most_states:
            return []
    return [(successors.facts(state), tuple(map(successors.action, way))) for state, way in queue]


def _failing(stepper: Stepper, facts: frozenset[Fact], part: Formula, values: Environment) -> list[str]:
    """The values for which a `forall` fails; one entry for any other formula."""
    if not isinstance(part, Forall):
        return [""]
    names = [variable.name for variable in part.variables]
    return [
        ", ".join(f"{name} = {inner[name]}" for name in names)
        for inner in stepper.environments(facts, part.variables, values)
        if not stepper.holds(facts, part.body, inner)
    ]


def _told(failing: Sequence[Sequence[str]]) -> str:
    values = [values[0] for values in failing if values and values[0]]
    return f", which fails for {' and '.join(values)}" if values else ""
