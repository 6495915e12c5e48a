"""From a sequence of actions to a skeleton: which motion literals hold in each phase, and which its switch adds."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from ....compiler.ir import Action, Any_, Effect, EffectIf, EffectItem, Fact, Object, Problem
from ....compiler.symbolic.algebra import Environment, Undefined
from ....compiler.symbolic.chains import KnownFacts
from ....compiler.symbolic.guards import Guards
from ....compiler.symbolic.normal_form import TRUE
from ....compiler.symbolic.successors import Successors
from ...skeleton import Phase, Skeleton
from .stepper import WILDCARD, left


def build_skeleton(
    problem: Problem, actions: Sequence[Action], successors: Successors | None = None, possible: bool = False
) -> Skeleton:
    """Replay the motion effects of `actions` from the start. Deletions come before additions, so that a literal that
    is deleted and added again counts as added. Raises ValueError when an action cannot follow the ones before it; where
    they are known to be `possible`, states are only asked for where effects depend on them."""
    successors = successors or Successors(problem)
    mode = problem.init_motion
    state = successors.initial
    phases: list[Phase] = []
    behind = 0
    for k, action in enumerate(actions):
        if not (possible and has_plain_effects(problem, action)):
            for done in actions[behind:k]:
                state = _after(successors, state, done)
            behind = k
        deleted, added = motion_changes(problem, successors, state, action)
        phases.append(Phase(action, mode, frozenset(added)))
        mode = left(problem.motions, mode, deleted) | frozenset(added)
    for done in () if possible else actions[behind:]:
        state = _after(successors, state, done)
    return Skeleton(problem, tuple(phases), mode)


def has_plain_effects(problem: Problem, action: Action) -> bool:
    """Whether what an action changes is the same in all states: no effect has a condition or a quantifier."""
    return all(isinstance(item, Effect) for item in problem.rules[action.rule].effects)


def _after(successors: Successors, state: int, action: Action) -> int:
    for following, number in successors.expand(state):
        if successors.action(number) == action:
            return following
    raise ValueError(f"{action} cannot be done here")


def motion_changes(
    problem: Problem, successors: Successors, state: int, action: Action
) -> tuple[list[Fact], list[Fact]]:
    """Patterns of deleted motion literals, with ANY, and added ones, in the order of the rule."""
    rule = problem.rules[action.rule]
    env = {v.name: value for v, value in zip(rule.variables, action.args, strict=True)}
    deleted: list[Fact] = []
    added: list[Fact] = []
    for fact, negated in _changes(successors, rule.effects, env, state):
        found = deleted if negated else added
        if fact not in found:
            found.append(fact)
    return deleted, added


def _changes(
    successors: Successors, items: Sequence[EffectItem], env: Environment, state: int
) -> Iterator[tuple[Fact, bool]]:
    guards: Guards = successors.guards
    word: KnownFacts = successors.word(state)
    for item in items:
        if isinstance(item, Effect):
            if item.literal.motion:
                try:
                    yield _ground(guards, item, env), item.negated
                except Undefined:
                    continue
        elif isinstance(item, EffectIf):
            condition = guards.reduce(successors.normal.normal(item.condition, {}, False), env, word)
            if condition == TRUE or successors.condition(condition)(state):
                yield from _changes(successors, item.effects, env, state)
        else:
            for inner, _ in guards.solutions(item.variables, (), env, word):
                yield from _changes(successors, item.effects, inner, state)


def _ground(guards: Guards, effect: Effect, env: Mapping[str, object]) -> Fact:
    args = [guards.resolve(a, env) for a in effect.literal.args]
    names = [WILDCARD if isinstance(a, Any_) else a.name for a in args if isinstance(a, Any_ | Object)]
    return (effect.literal.predicate, *names)

