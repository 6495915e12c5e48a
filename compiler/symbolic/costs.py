"""Back end: the cost-to-go that a task's `guide` describes, as functions of states and actions."""

from __future__ import annotations

import math

from ...langs.trees import parts
from ..ir import (
    Action,
    Aggregate,
    And,
    Any_,
    Arith,
    Case,
    Conditional,
    Formula,
    Heuristic,
    Literal,
    Not,
    Or,
    Previous,
    Problem,
    Prune,
    Term,
    Var,
)
from .algebra import Environment, Undefined, arithmetic
from .expressions import literal_test
from .successors import Successors


class CostToGo:
    """Start value and change per action of a heuristic; infinite where it prunes."""

    def __init__(self, problem: Problem, successors: Successors) -> None:
        self.problem = problem
        self.successors = successors
        self.heuristic: Heuristic | None = problem.heuristic
        cases = self.heuristic.cases.values() if self.heuristic is not None else ()
        self.reads_previous = any(_reads_previous(c.value) for c in cases)
        self._reads_state = any(_reads_state(c.value) for c in cases)
        self._known: dict[tuple[int, int | None, int], float] = {}
        self._normal: dict[int, Formula] = {}
        """Normal forms of the conditions in the heuristic, by their identity: the heuristic keeps them alive."""

    @property
    def start(self) -> float:
        """The value at the start of the task."""
        if self.heuristic is None or self.heuristic.start is None:
            return 0.0
        return self._value(self.heuristic.start, {}, self.successors.initial, None)

    def change(self, state: int, number: int, previous: int | None) -> float:
        """What action `number`, done in `state` after action `previous`, adds to the cost-to-go."""
        key = (number, previous if self.reads_previous else None, state if self._reads_state else 0)
        if key not in self._known:
            self._known[key] = self._change(state, number, previous)
        return self._known[key]

    def _change(self, state: int, number: int, previous: int | None) -> float:
        action = self.successors.action(number)
        case: Case | None = None if self.heuristic is None else self.heuristic.cases.get(action.rule)
        if case is None:
            return 0.0
        names = (v.name for v in self.problem.rules[action.rule].variables)
        env = dict(zip(names, action.args, strict=True))
        before = None if previous is None else self.successors.action(previous)
        return self._value(case.value, env, state, before)

    def _value(self, term: Term, env: Environment, state: int, previous: Action | None) -> float:
        guards = self.successors.guards
        match term:
            case Prune():
                return math.inf
            case Conditional():
                holds = self._holds(term.condition, env, state, previous)
                return self._value(term.then if holds else term.otherwise, env, state, previous)
            case Arith():
                values = [self._value(t, env, state, previous) for t in term.operands]
                return float(arithmetic(term.operator, values))
            case Aggregate():
                word = self.successors.word(state)
                inner = (e for e, _ in guards.solutions(term.variables, (), env, word))
                found = [self._value(term.body, e, state, previous) for e in inner]
                if term.operator == "sum":
                    return sum(found)
                return (min if term.operator == "min" else max)(found, default=math.inf)
            case _:
                return float(guards.number(guards.resolve(term, env), env))

    def _holds(self, formula: Formula, env: Environment, state: int, previous: Action | None) -> bool:
        match formula:
            case Previous():
                return previous is not None and self._matches(formula, env, previous)
            case Not():
                return not self._holds(formula.operand, env, state, previous)
            case And():
                return all(self._holds(f, env, state, previous) for f in formula.operands)
            case Or():
                return any(self._holds(f, env, state, previous) for f in formula.operands)
            case _:
                normal = self._normal.get(id(formula))
                if normal is None:
                    normal = self._normal[id(formula)] = self.successors.normal.normal(formula, {}, False)
                return self._true(self.successors.guards.reduce(normal, env, self.successors.word(state)), state)

    def _true(self, formula: Formula, state: int) -> bool:
        match formula:
            case Literal():
                mask, value, same = literal_test(self.successors.layout, formula)
                return (state & mask == value) is same
            case Not():
                return not self._true(formula.operand, state)
            case And():
                return all(self._true(f, state) for f in formula.operands)
            case Or():
                return any(self._true(f, state) for f in formula.operands)
            case _:
                raise Undefined

    def _matches(self, pattern: Previous, env: Environment, action: Action) -> bool:
        if pattern.rule != action.rule:
            return False
        return pattern.args is None or all(
            isinstance(wanted, Any_) or self._same(wanted, env, arg)
            for wanted, arg in zip(pattern.args, action.args, strict=True)
        )

    def _same(self, wanted: Term, env: Environment, arg: object) -> bool:
        if isinstance(wanted, Var):
            return bool(env.get(wanted.name) == arg)
        known = self.successors.guards.resolve(wanted, env)
        return getattr(known, "name", getattr(known, "value", None)) == arg


def _reads_previous(term: Term) -> bool:
    return any(isinstance(part, Previous) for part in parts(term))


def _reads_state(term: Term) -> bool:
    return any(isinstance(part, Literal) for part in parts(term))
