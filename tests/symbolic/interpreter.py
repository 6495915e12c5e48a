"""The meaning of the IR, spelt out slowly: states are frozensets of facts, all bindings are enumerated."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Any

from tamplang.compiler.ir import (
    Action,
    And,
    Any_,
    Arith,
    Chain,
    ChainEnd,
    ChainModule,
    ChainType,
    Compare,
    Effect,
    EffectFor,
    EffectIf,
    EffectItem,
    Exists,
    Fact,
    Forall,
    Formula,
    Function,
    Literal,
    Not,
    Number,
    Object,
    ObjectType,
    Or,
    Problem,
    RangeType,
    Term,
    Var,
    Variable,
)
from tamplang.compiler.symbolic.geometry import SceneLengths

State = frozenset[Fact]
Binding = dict[str, Any]


class Interpreter:
    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self.geometry = SceneLengths(problem)

    def successors(self, state: State) -> dict[Action, State]:
        found = {}
        for rule in self.problem.rules.values():
            for binding in self.bindings(rule.variables, {}, state):
                if self.holds(rule.condition, binding, state):
                    action = Action(rule.name, tuple(binding[v.name] for v in rule.variables))
                    after = self.after(rule.effects, binding, state)
                    if not self.has_two_values(after):
                        found[action] = after
        return found

    def has_two_values(self, state: State) -> bool:
        for predicate in self.problem.predicates.values():
            key = predicate.functional_in
            if key is not None:
                keys = [f[1 + key] for f in state if f[0] == predicate.name]
                if len(keys) != len(set(keys)):
                    return True
        return False

    def after(self, effects: tuple[EffectItem, ...], binding: Binding, state: State) -> State:
        changes = list(self.changes(effects, binding, state))
        kept = set(state)
        for pattern, negated in changes:
            if negated:
                kept = {f for f in kept if not self.matches(pattern, f)}
        for fact, negated in changes:
            if not negated:
                kept.add(fact)
                if self.problem.predicates[fact[0]].symmetric:
                    kept.add((fact[0], fact[2], fact[1]))
        return frozenset(kept)

    def matches(self, pattern: Fact, fact: Fact) -> bool:
        orders = [pattern[1:]]
        if self.problem.predicates[pattern[0]].symmetric:
            orders.append(pattern[:0:-1])
        return pattern[0] == fact[0] and any(
            all(a in ("ANY", b) for a, b in zip(order, fact[1:], strict=True)) for order in orders
        )

    def changes(
        self, effects: tuple[EffectItem, ...], binding: Binding, state: State
    ) -> Iterator[tuple[Fact, bool]]:
        for item in effects:
            if isinstance(item, Effect):
                if not item.literal.motion:
                    args = ("ANY" if isinstance(a, Any_) else self.value(a, binding) for a in item.literal.args)
                    yield (item.literal.predicate, *args), item.negated
            elif isinstance(item, EffectIf):
                if self.holds(item.condition, binding, state):
                    yield from self.changes(item.effects, binding, state)
            elif isinstance(item, EffectFor):
                for inner in self.bindings(item.variables, binding, state):
                    yield from self.changes(item.effects, inner, state)

    def bindings(self, variables: tuple[Variable, ...], binding: Binding, state: State) -> Iterator[Binding]:
        if not variables:
            yield binding
            return
        first, *rest = variables
        for value in self.values(first, binding, state):
            yield from self.bindings(tuple(rest), {**binding, first.name: value}, state)

    def values(self, variable: Variable, binding: Binding, state: State) -> list[Any]:
        kind = variable.type
        if isinstance(kind, ObjectType):
            return list(self.problem.of_type(kind.name))
        if isinstance(kind, RangeType):
            return list(range(round(self.value(kind.first, binding)), round(self.value(kind.last, binding)) + 1))
        assert isinstance(kind, ChainType)
        return self.chains(kind, state)

    def chains(self, kind: ChainType, state: State) -> list[Chain]:
        """Every sequence of distinct modules that is linked throughout and free at both ends."""
        modules = [m for m in self.problem.of_type(kind.element) if m in self.problem.world.modules]
        oriented = [
            (m, f"{m}.{a.name}", f"{m}.{b.name}")
            for m in modules
            for a in self.problem.world.modules[m].type.effectors
            for b in self.problem.world.modules[m].type.effectors
            if a is not b
        ]
        effectors = {enter for _, enter, _ in oriented}

        def linked(a: str, b: str) -> bool:
            return (kind.predicate, a, b) in state or (kind.predicate, b, a) in state

        def end(a: str) -> bool:
            return not any(linked(a, b) for b in effectors)

        found = []
        for size in range(1, len(modules) + 1):
            for line in itertools.permutations(oriented, size):
                if len({m for m, _, _ in line}) < size or not end(line[0][1]) or not end(line[-1][2]):
                    continue
                if all(linked(p[2], q[1]) for p, q in itertools.pairwise(line)):
                    found.append(Chain(tuple(line)))
        return found

    def holds(self, formula: Formula, binding: Binding, state: State) -> bool:
        match formula:
            case Literal():
                args = [self.value(a, binding) for a in formula.args]
                derived = self.problem.derived.get(formula.predicate)
                if derived is None:
                    return (formula.predicate, *args) in state
                names = (v.name for v in derived.variables)
                return self.holds(derived.body, dict(zip(names, args, strict=True)), state)
            case Not():
                return not self.holds(formula.operand, binding, state)
            case And():
                return all(self.holds(f, binding, state) for f in formula.operands)
            case Or():
                return any(self.holds(f, binding, state) for f in formula.operands)
            case Exists():
                return any(self.holds(formula.body, b, state) for b in self.bindings(formula.variables, binding, state))
            case Forall():
                return all(self.holds(formula.body, b, state) for b in self.bindings(formula.variables, binding, state))
            case Compare():
                left, right = self.value(formula.left, binding), self.value(formula.right, binding)
                if isinstance(left, str):
                    return (left == right) == (formula.operator == "=")
                return {
                    "=": left == right, "!=": left != right, "<": left < right, "<=": left <= right,
                    ">": left > right, ">=": left >= right,
                }[formula.operator]
            case _:
                raise AssertionError(formula)

    def value(self, term: Term, binding: Binding) -> Any:
        match term:
            case Number():
                return term.value
            case Object():
                return term.name
            case Var():
                return binding[term.name]
            case ChainEnd():
                chain = binding[term.chain]
                return chain.last if term.last else chain.first
            case ChainModule():
                module, enter, leave = binding[term.chain].modules[round(self.value(term.index, binding)) - 1]
                return {"": module, "in": enter, "out": leave}[term.side]
            case Arith():
                a = [self.value(t, binding) for t in term.operands]
                if term.operator == "neg":
                    return -a[0]
                return {"+": lambda x, y: x + y, "-": lambda x, y: x - y, "*": lambda x, y: x * y}[term.operator](*a)
            case Function():
                return self.function(term.name, [self.value(a, binding) for a in term.args])
            case _:
                raise AssertionError(term)

    def function(self, name: str, args: list[Any]) -> float:
        geometry, index = self.geometry, self.geometry.index
        if name == "reach":
            return geometry.chain_reach(args[0]) if len(args) == 1 else geometry.reach(*args)
        if name == "length":
            return len(args[0].modules)
        if name == "radius":
            return float(geometry.radius(index[args[0]]))
        if name == "stride":
            return float(geometry.stride(index[args[0]], index[args[1]], args[2]))
        assert name == "distance"
        return float(geometry.distance(index[args[0]], index[args[1]]))
