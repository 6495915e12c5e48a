"""The meaning of rules, conditions and goals, spelt out: states are sets of facts, variables take every value."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

from tamplang.compiler import ir

from .lengths import Lengths

Binding = dict[str, Any]
Fact = tuple[str, ...]
COMPARE: dict[str, Callable[[Any, Any], bool]] = {
    "=": operator.eq, "!=": operator.ne, "<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge,
}  # fmt: skip
ANY = object()
SLACK = 1e-7
"""Lengths that should be equal differ by rounding."""


class NotAllowed(Exception):
    """An action that the rules do not allow, with the reason."""


class State:
    """Logic facts and motion literals that hold. `lengths` measures the scene that conditions ask about."""

    def __init__(self, problem: ir.Problem, facts: Iterable[Fact], motion: Iterable[Fact], lengths: Lengths) -> None:
        self.problem, self.lengths = problem, lengths
        self.facts, self.motion = set(facts), set(motion)
        self._chains: dict[tuple[str, str], list[ir.Chain]] = {}

    # --- conditions ----------------------------------------------------------------------------------------------

    def holds(self, formula: ir.Formula, binding: Binding) -> bool:
        match formula:
            case ir.Literal():
                return self._literal(formula, binding)
            case ir.Not():
                return not self.holds(formula.operand, binding)
            case ir.And():
                return all(self.holds(f, binding) for f in formula.operands)
            case ir.Or():
                return any(self.holds(f, binding) for f in formula.operands)
            case ir.Exists():
                return any(self.holds(formula.body, b) for b in self.bindings(formula.variables, binding))
            case ir.Forall():
                return all(self.holds(formula.body, b) for b in self.bindings(formula.variables, binding))
            case ir.Compare():
                left, right = self.value(formula.left, binding), self.value(formula.right, binding)
                if isinstance(left, float) or isinstance(right, float):
                    return _compared(formula.operator, left, right)
                return COMPARE[formula.operator](left, right)
        raise NotAllowed(f"no condition of a rule: {formula}")

    def _literal(self, literal: ir.Literal, binding: Binding) -> bool:
        args = [self.value(a, binding) for a in literal.args]
        derived = self.problem.derived.get(literal.predicate)
        if derived is not None:
            inner = {v.name: a for v, a in zip(derived.variables, args, strict=True)}
            return self.holds(derived.body, inner)
        pattern = (literal.predicate, *args)
        if ANY in args:
            return any(self._matches(pattern, f) for f in self.facts)
        return pattern in self.facts or (self._symmetric(literal.predicate) and (pattern[0], *args[::-1]) in self.facts)

    def bindings(self, variables: Sequence[ir.Variable], binding: Binding) -> Iterator[Binding]:
        if not variables:
            yield binding
            return
        for value in self.values(variables[0].type, binding):
            yield from self.bindings(variables[1:], {**binding, variables[0].name: value})

    def values(self, kind: ir.Type, binding: Binding) -> Iterable[Any]:
        match kind:
            case ir.ObjectType():
                return self.problem.of_type(kind.name)
            case ir.RangeType():
                first, last = self.value(kind.first, binding), self.value(kind.last, binding)
                return range(math.ceil(first - SLACK), math.floor(last + SLACK) + 1)
            case ir.ChainType():
                return self.chains(kind)
        raise NotAllowed(f"no type of a variable: {kind}")

    def chains(self, kind: ir.ChainType) -> list[ir.Chain]:
        """All maximal lines of modules of a type, each from both its ends."""
        key = kind.element, kind.predicate
        if key not in self._chains:
            self._chains[key] = list(_lines(self.problem, kind, self.facts))
        return self._chains[key]

    # --- terms ---------------------------------------------------------------------------------------------------

    def value(self, term: ir.Term, binding: Binding) -> Any:
        match term:
            case ir.Number():
                return term.value
            case ir.Object():
                return term.name
            case ir.Var():
                return binding[term.name]
            case ir.Any_():
                return ANY
            case ir.ChainEnd():
                chain = binding[term.chain]
                return chain.modules[-1][2] if term.last else chain.modules[0][1]
            case ir.ChainModule():
                return self._chain_module(term, binding)
            case ir.Arith():
                return _arithmetic(term.operator, [self.value(o, binding) for o in term.operands])
            case ir.Conditional():
                return self.value(term.then if self.holds(term.condition, binding) else term.otherwise, binding)
            case ir.Aggregate():
                found = [self.value(term.body, b) for b in self.bindings(term.variables, binding)]
                if term.operator == "sum":
                    return sum(found)
                return (min if term.operator == "min" else max)(found, default=math.inf)
            case ir.Function():
                return self._function(term, binding)
        raise NotAllowed(f"no term of a rule: {term}")

    def _chain_module(self, term: ir.ChainModule, binding: Binding) -> Any:
        index = round(self.value(term.index, binding))
        modules = binding[term.chain].modules
        if not 1 <= index <= len(modules):
            raise NotAllowed(f"a chain of {len(modules)} has no module {index}")
        return modules[index - 1][{"": 0, "in": 1, "out": 2}[term.side]]

    def _function(self, term: ir.Function, binding: Binding) -> Any:
        args = [self.value(a, binding) for a in term.args]
        match term.name:
            case "distance":
                return self.lengths.distance(args[0], args[1])
            case "stride":
                return self.lengths.stride(args[0], args[1], float(args[2]))
            case "reach":
                return self.lengths.chain_reach(args[0]) if len(args) == 1 else self.lengths.reach(args[0], args[1])
            case "radius":
                return self.lengths.radius(args[0])
            case "length":
                return float(len(args[0].modules))
            case "sqrt" | "sin" | "cos" | "floor":
                return float(getattr(math, term.name)(args[0]))
            case "abs":
                return abs(args[0])
        raise NotAllowed(f"no function of a rule: {term.name}")

    # --- actions -------------------------------------------------------------------------------------------------

    def bound(self, rule: ir.Rule, args: Sequence[str | int]) -> Binding:
        """The arguments of a plan file, as values of the rule's variables. Raises NotAllowed."""
        if len(args) != len(rule.variables):
            raise NotAllowed(f"{rule.name} has {len(rule.variables)} arguments, not {len(args)}")
        binding: Binding = {}
        for variable, arg in zip(rule.variables, args, strict=True):
            allowed = list(self.values(variable.type, binding))
            if isinstance(variable.type, ir.ChainType):
                allowed = [c for c in allowed if str(c) == arg]
            elif isinstance(variable.type, ir.RangeType):
                allowed = [n for n in allowed if str(n) == str(arg)]
            else:
                allowed = [o for o in allowed if o == arg]
            if not allowed:
                raise NotAllowed(f"{arg} is no {variable.name} of {rule.name}")
            binding[variable.name] = allowed[0]
        return binding

    def after(self, rule: ir.Rule, binding: Binding) -> tuple[set[Fact], set[Fact], set[Fact]]:
        """Facts and motion literals after the action, and the motion literals that it adds."""
        changes = list(self._changes(rule.effects, binding))
        facts, motion, added = set(self.facts), set(self.motion), set[Fact]()
        for pattern, is_motion, negated in changes:
            held = motion if is_motion else facts
            if negated:
                held -= {f for f in held if self._matches(pattern, f, is_motion)}
        for fact, is_motion, negated in changes:
            if negated:
                continue
            if is_motion:
                motion.add(fact)
                added.add(fact)
            else:
                key = self.problem.predicates[fact[0]].functional_in
                if key is not None:
                    facts -= {f for f in facts if f[0] == fact[0] and f[1 + key] == fact[1 + key]}
                facts.add(fact)
        return facts, motion, added

    def _changes(self, items: Sequence[ir.EffectItem], binding: Binding) -> Iterator[tuple[Fact, bool, bool]]:
        for item in items:
            match item:
                case ir.Effect():
                    args = [self.value(a, binding) for a in item.literal.args]
                    yield (item.literal.predicate, *args), item.literal.motion, item.negated
                case ir.EffectIf():
                    if self.holds(item.condition, binding):
                        yield from self._changes(item.effects, binding)
                case ir.EffectFor():
                    for inner in self.bindings(item.variables, binding):
                        yield from self._changes(item.effects, inner)

    def _symmetric(self, predicate: str, motion: bool = False) -> bool:
        table = self.problem.motions if motion else self.problem.predicates
        return table[predicate].symmetric

    def _matches(self, pattern: Fact, fact: Fact, motion: bool = False) -> bool:
        if pattern[0] != fact[0]:
            return False
        orders = [fact[1:], fact[:0:-1]] if self._symmetric(fact[0], motion) else [fact[1:]]
        return any(all(a is ANY or a == b for a, b in zip(pattern[1:], o, strict=True)) for o in orders)


def one_order(problem: ir.Problem, facts: Iterable[Fact], motion: bool) -> set[Fact]:
    """The same facts, those of symmetric predicates in one order."""
    table: Any = problem.motions if motion else problem.predicates
    return {(f[0], *sorted(f[1:])) if f[0] in table and table[f[0]].symmetric else f for f in facts}


def _compared(sign: str, left: float, right: float) -> bool:
    """Rounding counts for the plan: what is equal to 1e-7 m may be smaller, larger and equal."""
    if abs(left - right) <= SLACK:
        return sign in ("=", "<=", ">=") or left != right
    return COMPARE[sign](left, right)


def _arithmetic(sign: str, values: Sequence[Any]) -> Any:
    if sign == "neg":
        return -values[0]
    left, right = values
    if sign == "/" and right == 0:
        raise NotAllowed("division by zero")
    return {"+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv}[sign](left, right)


def _lines(problem: ir.Problem, kind: ir.ChainType, facts: Iterable[Fact]) -> Iterator[ir.Chain]:
    modules = [m for m in problem.of_type(kind.element) if m in problem.world.modules]
    ends = {m: [f"{m}.{e.name}" for e in problem.world.modules[m].type.effectors] for m in modules}
    owner = {end: m for m, some in ends.items() for end in some}
    links: dict[str, set[str]] = {}
    for fact in facts:
        if fact[0] == kind.predicate and fact[1] in owner and fact[2] in owner:
            links.setdefault(fact[1], set()).add(fact[2])
            links.setdefault(fact[2], set()).add(fact[1])

    def onward(line: list[tuple[str, str, str]], enter: str) -> Iterator[ir.Chain]:
        module = owner[enter]
        for leave in ends[module]:
            if leave == enter:
                continue
            longer = [*line, (module, enter, leave)]
            if leave not in links:
                yield ir.Chain(tuple(longer))
            for other in sorted(links.get(leave, ())):
                if owner[other] not in [m for m, _, _ in longer]:
                    yield from onward(longer, other)

    for some in ends.values():
        for enter in some:
            if enter not in links:
                yield from onward([], enter)
