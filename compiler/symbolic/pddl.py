"""Export: a problem as PDDL, typed STRIPS with negative preconditions, disjunctions and conditional effects where the
rules have them.

Numeric guards over locations become static facts of their own; rules over chains become one action for every chain
that the modules could ever form; motion literals are left out.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import permutations, product

from ..ir import (
    And,
    Any_,
    Chain,
    ChainType,
    Compare,
    Effect,
    EffectIf,
    EffectItem,
    Exists,
    Forall,
    Formula,
    Literal,
    Not,
    Object,
    Or,
    Problem,
    RangeType,
    Term,
    Var,
    Variable,
)
from .algebra import conjunction, disjunction, negation
from .domains import FlatRule
from .guards import Environment, Guards
from .normal_form import TRUE, free_names
from .successors import Successors, has_chains

REQUIREMENTS = ":typing :equality :negative-preconditions :disjunctive-preconditions :conditional-effects"


def to_pddl(problem: Problem) -> tuple[str, str]:
    """Domain and problem text. One action per rule and choice of its small variables (effectors, chains, ranges);
    locations stay parameters."""
    writer = _Writer(problem)
    actions = [text for flat in writer.successors.domains.rules for text in writer.actions(flat)]
    return writer.domain(actions), writer.task()


class _Writer:
    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self.successors = Successors(problem)
        self.guards: Guards = self.successors.guards
        self.layout = self.successors.layout
        self.relations: dict[tuple[Formula, ...], tuple[str, tuple[Variable, ...]]] = {}
        self.related: list[str] = []

    # --- texts ---------------------------------------------------------------------------------------------------

    def domain(self, actions: Sequence[str]) -> str:
        lines = [f"(define (domain {_name(self.problem.task)})"]
        lines.append(f"  (:requirements {REQUIREMENTS})")
        lines.append("  (:types object_ - object)")
        lines.append("  (:constants " + " ".join(_name(o) for o in self.problem.objects) + " - object_)")
        lines.append("  (:predicates")
        for predicate in self.problem.predicates.values():
            lines.append(f"    ({_name(predicate.name)} {_parameters([v.name for v in predicate.variables])})")
        for relation, variables in self.relations.values():
            lines.append(f"    ({relation} {_parameters([v.name for v in variables])})")
        return "\n".join([*lines, "  )", *actions, ")", ""])

    def task(self) -> str:
        name = _name(self.problem.task)
        lines = [f"(define (problem {name}_1)", f"  (:domain {name})", "  (:init"]
        lines += [f"    ({' '.join(map(_name, fact))})" for fact in sorted(self.problem.init)]
        lines += [f"    {text}" for text in self.related]
        goal = self.successors.normal.normal(self.problem.goal, {}, False)
        return "\n".join([*lines, "  )", f"  (:goal {self.formula(self._settled(goal, {}))})", ")", ""])

    def actions(self, flat: FlatRule) -> Iterator[str]:
        """One action per choice of the small variables under which the rule may fire."""
        domains = self.layout.domains.variable_domains(flat)
        small = [v for v in flat.variables if v.name not in domains or domains[v.name] <= self.layout.small]
        for number, env in enumerate(self._choices(small, {}, domains)):
            text = self._action(flat, number, env, [v for v in flat.variables if v not in small])
            if text is not None:
                yield text

    def _choices(
        self, variables: Sequence[Variable], env: Environment, domains: Mapping[str, frozenset[str]]
    ) -> Iterator[Environment]:
        if not variables:
            yield env
            return
        first, *rest = variables
        if isinstance(first.type, ChainType):
            values: Sequence[object] = list(self._chains(first.type))
        elif isinstance(first.type, RangeType):
            values = self.guards.values(first, env, None)
        else:
            values = [o for o in self.problem.objects if o in domains[first.name]]
        for value in values:
            yield from self._choices(rest, {**env, first.name: value}, domains)

    def _chains(self, kind: ChainType) -> Iterator[Chain]:
        """Every chain that the modules of the problem could ever form."""
        modules = [m for m in self.problem.of_type(kind.element) if m in self.problem.world.modules]
        for size in range(1, len(modules) + 1):
            for line in permutations(modules, size):
                sides = [self._passages(m) for m in line]
                for passage in product(*sides):
                    yield Chain(tuple((m, a, b) for m, (a, b) in zip(line, passage, strict=True)))

    def _passages(self, module: str) -> list[tuple[str, str]]:
        ends = [f"{module}.{e.name}" for e in self.problem.world.modules[module].type.effectors]
        return list(permutations(ends, 2))

    def _action(self, flat: FlatRule, number: int, env: Environment, large: Sequence[Variable]) -> str | None:
        lines = [(v.type, env[v.name]) for v in flat.variables if isinstance(v.type, ChainType)]
        conditions = [self.formula(f) for kind, chain in lines for f in self._is_chain(kind, chain)]
        static: list[Formula] = []
        for formula in flat.conjuncts:
            rest = self._settled(formula, env)
            for part in rest.operands if isinstance(rest, And) else (rest,):
                if part == Or(()):
                    return None
                if isinstance(part, Compare) and free_names(part):
                    static.append(part)
                elif part != TRUE:
                    conditions.append(self.formula(part))
        for formula in static:
            conditions.append(self._relation(formula, large, flat))
        head = [f"  (:action {_name(flat.rule.name)}_{number}"]
        head.append(f"    :parameters ({_parameters([v.name for v in large])})")
        head.append(f"    :precondition (and {' '.join([*self._typed(large, flat), *conditions])})")
        head.append(f"    :effect (and {' '.join(self._effects(flat.rule.effects, env))}))")
        return "\n".join(head)

    def _settled(self, formula: Formula, env: Environment) -> Formula:
        """What remains of a condition, with quantifiers over chains replaced by all chains that could ever be."""
        if not has_chains(formula):
            return self.guards.reduce(formula, env, None)
        match formula:
            case And():
                return conjunction(self._settled(f, env) for f in formula.operands)
            case Or():
                return disjunction(self._settled(f, env) for f in formula.operands)
            case Exists() | Forall():
                return self._quantified(formula, env)
            case _:
                raise ValueError(f"no PDDL for {formula}")

    def _quantified(self, formula: Exists | Forall, env: Environment) -> Formula:
        variable = next((v for v in formula.variables if isinstance(v.type, ChainType)), None)
        if variable is None or not isinstance(variable.type, ChainType):
            return type(formula)(formula.variables, self._settled(formula.body, env))
        others = tuple(v for v in formula.variables if v is not variable)
        inner = type(formula)(others, formula.body) if others else formula.body
        options = []
        for chain in self._chains(variable.type):
            exists = conjunction(self._is_chain(variable.type, chain))
            rest = self._settled(inner, {**env, variable.name: chain})
            either = isinstance(formula, Forall)
            options.append(disjunction((negation(exists), rest)) if either else conjunction((exists, rest)))
        return conjunction(options) if isinstance(formula, Forall) else disjunction(options)

    def _is_chain(self, kind: ChainType, chain: Chain) -> Iterator[Formula]:
        """The links of a chain hold, and its ends are not linked on."""
        for (_, _, leave), (_, enter, _) in zip(chain.modules, chain.modules[1:], strict=False):
            yield Literal(kind.predicate, (Object(leave), Object(enter)))
        inner = {part for line in chain.modules for part in line}
        for end in dict.fromkeys((chain.first, chain.last)):
            for other in self.problem.of_type("effector"):
                if other not in inner and self.layout.encode((kind.predicate, end, other))[0]:
                    yield Not(Literal(kind.predicate, (Object(end), Object(other))))

    def _typed(self, large: Sequence[Variable], flat: FlatRule) -> list[str]:
        """Types and static reach of the domains, as unary relations."""
        domains = self.layout.domains.variable_domains(flat)
        found = []
        for variable in large:
            relation = f"may_{_name(flat.rule.name)}_{_name(variable.name)}"
            key: tuple[Formula, ...] = (Literal(relation, (Var(variable.name),)),)
            if key not in self.relations:
                self.relations[key] = (relation, (variable,))
                allowed = [o for o in self.problem.objects if o in domains[variable.name]]
                self.related += [f"({relation} {_name(o)})" for o in allowed]
            found.append(f"({relation} ?{_name(variable.name)})")
        return found

    def _relation(self, formula: Formula, large: Sequence[Variable], flat: FlatRule) -> str:
        """A numeric guard over locations, grounded into static facts of a predicate of its own."""
        names = free_names(formula)
        variables = tuple(v for v in large if v.name in names)
        key = (formula,)
        if key not in self.relations:
            relation = f"guard_{len(self.relations)}"
            self.relations[key] = (relation, variables)
            domains = self.layout.domains.variable_domains(flat)
            for env, _ in self.guards.solutions(variables, key, {}, None, domains):
                self.related.append(f"({relation} {' '.join(_name(env[v.name]) for v in variables)})")
        return f"({self.relations[key][0]} {' '.join('?' + _name(v.name) for v in variables)})"

    def _effects(self, items: Sequence[EffectItem], env: Environment) -> Iterator[str]:
        for item in items:
            if isinstance(item, Effect):
                yield from self._effect(item, env)
            elif isinstance(item, EffectIf):
                condition = self.guards.reduce(self.successors.normal.normal(item.condition, {}, False), env, None)
                inner = " ".join(self._effects(item.effects, env))
                if inner and condition != Or(()):
                    yield inner if condition == TRUE else f"(when {self.formula(condition)} (and {inner}))"
            else:
                for inner_env, _ in self.guards.solutions(item.variables, (), env, None):
                    yield from self._effects(item.effects, inner_env)

    def _effect(self, effect: Effect, env: Environment) -> Iterator[str]:
        literal = effect.literal
        if literal.motion:
            return
        args = [self.guards.resolve(a, env) for a in literal.args]
        wild = [f"?any{k}" for k, a in enumerate(args) if isinstance(a, Any_)]
        shown = [f"?any{k}" if isinstance(a, Any_) else _term(a) for k, a in enumerate(args)]
        orders = [shown]
        if self.problem.predicates[literal.predicate].symmetric:
            orders.append(shown[::-1])
        for order in orders:
            text = f"({_name(literal.predicate)} {' '.join(order)})"
            text = f"(not {text})" if effect.negated else text
            yield f"(forall ({' '.join(wild)} - object_) {text})" if wild else text

    def formula(self, formula: Formula) -> str:
        """A reduced formula as PDDL."""
        match formula:
            case Literal():
                if any(isinstance(a, Any_) for a in formula.args):
                    shown = ["?any" if isinstance(a, Any_) else _term(a) for a in formula.args]
                    return f"(exists (?any - object_) ({_name(formula.predicate)} {' '.join(shown)}))"
                return f"({_name(formula.predicate)} {' '.join(_term(a) for a in formula.args)})"
            case Not():
                return f"(not {self.formula(formula.operand)})"
            case And() | Or():
                word = "and" if isinstance(formula, And) else "or"
                return f"({word} {' '.join(self.formula(f) for f in formula.operands)})"
            case Exists() | Forall():
                word = "exists" if isinstance(formula, Exists) else "forall"
                names = " ".join(f"?{_name(v.name)}" for v in formula.variables)
                return f"({word} ({names} - object_) {self.formula(formula.body)})"
            case Compare(operator="=" | "!=", left=left, right=right):
                text = f"(= {_term(left)} {_term(right)})"
                return text if formula.operator == "=" else f"(not {text})"
            case _:
                raise ValueError(f"no PDDL for {formula}")


def _term(term: Term) -> str:
    if isinstance(term, Object):
        return _name(term.name)
    if isinstance(term, Var):
        return f"?{_name(term.name)}"
    raise ValueError(f"no PDDL for {term}")


def _name(name: str) -> str:
    return re.sub(r"[^A-Za-z0-9_]", "_", name).strip("_")


def _parameters(names: Sequence[str]) -> str:
    return " ".join(f"?{_name(n)}" for n in names) + (" - object_" if names else "")


