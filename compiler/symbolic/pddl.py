"""Export: a problem as PDDL that every planner reads: typed STRIPS, positive conditions only.

Numeric guards over locations become static facts of their own; rules over chains become one action for every chain
that the modules could ever form; alternatives become actions of their own; motion literals are left out. A goal with
alternatives is reached by one action more.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import permutations, product
from math import perm

from ...langs.diagnostics import UsageError
from ..ir import (
    And,
    Chain,
    ChainType,
    Compare,
    Effect,
    EffectIf,
    EffectItem,
    Exists,
    Fact,
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
from .algebra import Environment, conjunction, disjunction, negation
from .domains import FlatRule
from .guards import Guards
from .normal_form import FALSE, TRUE, free_names
from .settings import SYMBOLIC
from .strips import NOBODY, NOTHING, THING, Change, Schema, Strips, alternatives, contradicts, denial, literals
from .successors import Successors, has_chains


def to_pddl(problem: Problem) -> tuple[str, str]:
    """Domain and problem text. One action per rule, choice of its small variables (effectors, chains, ranges) and
    alternative of its condition; locations stay parameters. Raises UsageError for what PDDL cannot say."""
    writer = PddlWriter(problem)
    return writer.domain(), writer.task()


class PddlWriter:
    """One problem as PDDL. Raises UsageError for what PDDL cannot say."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self.successors = Successors(problem)
        self.guards: Guards = self.successors.guards
        self.layout = self.successors.layout
        self.strips = Strips(self.guards)
        self.relations: dict[tuple[Formula, ...], tuple[str, tuple[Variable, ...]]] = {}
        self.related: list[str] = []
        self._names: dict[tuple[str, str], str] = {}
        self._taken = {"reached", "object_"}
        self._links: dict[tuple[ChainType, Chain], tuple[frozenset[Fact], frozenset[Fact]]] = {}
        self.schemas = [s for flat in self.successors.domains.rules for s in self.actions(flat)]
        goals = alternatives(self._settled(self.successors.normal.normal(problem.goal, {}, False), {}))
        self.goals = [Schema("`reach", [], *literals(g, self.layout), []) for g in goals]
        for schema in (*self.schemas, *self.goals):
            self.strips.note(schema)
        for schema in (*self.schemas, *self.goals):
            self.strips.settle(schema)
        self.single = len(self.goals) == 1 and not self.goals[0].parameters

    # --- texts ---------------------------------------------------------------------------------------------------

    def domain(self) -> str:
        actions = [self._text(schema, number) for number, schema in enumerate(self.schemas)]
        if not self.single:
            actions += [self._text(schema, number, "(reached)") for number, schema in enumerate(self.goals)]
        lines = [f"(define (domain {self._name('d', self.problem.task)})", "  (:requirements :strips :typing)"]
        lines.append("  (:types object_ - object)")
        lines.append("  (:constants " + " ".join(map(self._object, self._objects())) + " - object_)")
        lines.append(f"  (:predicates (reached) ({self._predicate(THING)} ?x - object_)")
        for predicate in self.problem.predicates.values():
            shown = _parameters([f"x{k}" for k in range(len(predicate.variables))])
            lines.append(f"    ({self._predicate(predicate.name)} {shown})")
            if predicate.name in self.strips.denied:
                lines.append(f"    ({self._predicate(denial(predicate.name))} {shown})")
        for relation, variables in self.relations.values():
            lines.append(f"    ({self._predicate(relation)} {_parameters([f'x{k}' for k in range(len(variables))])})")
        return "\n".join([lines[0], *self._legend(), *lines[1:], "  )", *actions, ")", ""])

    def task(self) -> str:
        name = self._name("d", self.problem.task)
        lines = [f"(define (problem {name}_1)", f"  (:domain {name})", "  (:init"]
        lines += [f"    {fact}" for fact in self.facts()]
        goal = " ".join(self._literal(m) for m in self.goals[0].more) if self.single else "(reached)"
        return "\n".join([*lines, "  )", f"  (:goal (and {goal}))", ")", ""])

    def facts(self) -> list[str]:
        """What holds at the start."""
        facts = [*sorted(self.problem.init), *self.strips.initial(self.problem.init)]
        facts += [(THING, o) for o in self.problem.objects]
        shown = [f"({' '.join([self._predicate(p), *map(self._object, names)])})" for p, *names in facts]
        return [*shown, *self.related]

    def _objects(self) -> list[str]:
        return [*self.problem.objects, NOTHING.name, NOBODY.name]

    def _text(self, schema: Schema, number: int, reached: str = "") -> str:
        deleted, added = self.effects(schema)
        effects = [*(f"(not {e})" for e in deleted), *added, *([reached] if reached else [])]
        return "\n".join([
            f"  (:action {self.action_name(schema, number)}",
            f"    :parameters ({_parameters([self._variable(n) for n in schema.parameters])})",
            f"    :precondition (and {' '.join(self.conditions(schema))})",
            f"    :effect (and {' '.join(effects)}))",
        ])

    def action_name(self, schema: Schema, number: int) -> str:
        """What an action is called."""
        return self._name("a", f"{schema.rule}_{number}")

    def conditions(self, schema: Schema) -> list[str]:
        """The literals that an action asks for."""
        return list(dict.fromkeys([*map(self._relation_text, schema.static), *map(self._literal, schema.more)]))

    def effects(self, schema: Schema) -> tuple[list[str], list[str]]:
        """The literals that an action deletes, and those that it adds."""
        added = [*schema.added, *self.strips.left_behind(schema)]
        deleted = [self._literal(e) for e in schema.deleted if e not in added]
        return deleted, [self._literal(e) for e in dict.fromkeys(added)]

    def bound(self, schema: Schema, values: Mapping[str, str]) -> dict[str, str] | None:
        """What the parameters of an action stand for where its rule's variables have these values, as the export calls
        them; None where it is not the action of these values."""
        if any(name in values and str(value) != values[name] for name, value in schema.env.items()):
            return None
        known = {n: values[n] for n in schema.parameters if n in values}
        return {f"?{self._variable(n)}": self._object(value) for n, value in known.items()}

    def shown(self, schema: Schema) -> list[str]:
        """The parameters of an action, in order."""
        return [f"?{self._variable(n)}" for n in schema.parameters]

    def _relation_text(self, formula: Compare) -> str:
        relation, variables = self.relations[(formula,)]
        return f"({self._predicate(relation)} {' '.join('?' + self._variable(v.name) for v in variables)})"

    def _literal(self, literal: Literal) -> str:
        return f"({' '.join([self._predicate(literal.predicate), *map(self._term, literal.args)])})"

    def _term(self, term: Term) -> str:
        if isinstance(term, Object):
            return self._object(term.name)
        if isinstance(term, Var):
            return f"?{self._variable(term.name)}"
        raise UsageError(f"PDDL cannot say {term}")

    def _name(self, kind: str, name: str) -> str:
        """A name of small letters, digits and underscores that nothing else has. What the task names begins with the
        letter of its kind, so that it is a reserved word of no reader and never one of the export's own names, which
        begin with a backquote in here."""
        if (kind, name) not in self._names:
            own = name.startswith("`")
            plain = re.sub(r"[^a-z0-9_]", "_", name.lower()).strip("_")[:SYMBOLIC.pddl_name]
            whole = base = plain if own else f"{kind}_{plain}"
            number = 2
            while whole in self._taken:
                whole, number = f"{base}_{number}", number + 1
            self._taken.add(whole)
            self._names[kind, name] = whole
        return self._names[kind, name]

    def _object(self, name: str) -> str:
        return self._name("o", name)

    def _predicate(self, name: str) -> str:
        return self._name("p", name)

    def _variable(self, name: str) -> str:
        return self._name("v", name)

    def _legend(self) -> Iterator[str]:
        """Comments that tell what the names of things and predicates stand for."""
        yield "; NAME HERE: NAME IN THE TASK"
        for kind, names in (("o", self.problem.objects), ("p", self.problem.predicates)):
            yield from (f"; {self._name(kind, name)}: {ascii(name)[1:-1]}" for name in names)

    # --- actions -------------------------------------------------------------------------------------------------

    def actions(self, flat: FlatRule) -> Iterator[Schema]:
        """One action per choice of the small variables under which the rule may fire, and per alternative."""
        domains = self.layout.domains.variable_domains(flat)
        small = [v for v in flat.variables if v.name not in domains or domains[v.name] <= self.layout.small]
        large = [v for v in flat.variables if v not in small]
        for env in self._choices(small, {}, domains):
            yield from self._actions(flat, env, large)

    def _actions(self, flat: FlatRule, env: Environment, large: Sequence[Variable]) -> Iterator[Schema]:
        chains = [(v.type, env[v.name]) for v in flat.variables if isinstance(v.type, ChainType)]
        links = conjunction(f for kind, chain in chains for f in self._is_chain(kind, chain))
        settled = [links]
        for formula in flat.conjuncts:
            settled.append(self._settled(formula, env))
            if settled[-1] == FALSE:
                return
        whole = conjunction(settled)
        for condition, changes in self._changes(flat.rule.effects, env):
            both = conjunction((whole, condition, *self.strips.single(changes)))
            for option in [] if both == FALSE else alternatives(both):
                conditions, static = literals(option, self.layout)
                if not contradicts(conditions):
                    for compare in static:
                        self._relate(compare, large, flat)
                    names = [v.name for v in large]
                    schema = Schema(flat.rule.name, names, conditions, static, list(changes), env=env)
                    schema.more += [Literal(self._typed(v, flat), (Var(v.name),)) for v in large]
                    yield schema

    def _changes(self, items: Sequence[EffectItem], env: Environment) -> Iterator[tuple[Formula, tuple[Change, ...]]]:
        """The effects of a rule for every way in which its conditional effects may come out."""
        branches: list[tuple[Formula, tuple[Change, ...]]] = [(TRUE, ())]
        for item in items:
            options: list[tuple[Formula, tuple[Change, ...]]] = []
            if isinstance(item, Effect):
                literal = item.literal
                if literal.motion:
                    continue
                args = tuple(self.guards.resolve(a, env) for a in literal.args)
                options = [(TRUE, ((Literal(literal.predicate, args), item.negated),))]
            elif isinstance(item, EffectIf):
                condition = self._settled(self.successors.normal.normal(item.condition, {}, False), env)
                options = [(conjunction((condition, c)), e) for c, e in self._changes(item.effects, env)]
                options = [(c, e) for c, e in [*options, (negation(condition), ())] if c != FALSE]
            else:
                inner = [e for e, _ in self.guards.solutions(item.variables, (), env, None)]
                for found in product(*(list(self._changes(item.effects, e)) for e in inner)):
                    options.append((conjunction(c for c, _ in found), sum((e for _, e in found), ())))
            branches = [(conjunction((a, c)), (*b, *e)) for a, b in branches for c, e in options]
            if len(branches) > SYMBOLIC.pddl_branches:
                raise UsageError("a rule has too many conditional effects for PDDL")
        yield from ((c, e) for c, e in branches if c != FALSE)

    def _typed(self, variable: Variable, flat: FlatRule) -> str:
        """Type and static reach of a variable, as a unary relation."""
        relation = f"`may_{flat.rule.name}_{variable.name}"
        key: tuple[Formula, ...] = (Literal(relation, (Var(variable.name),)),)
        if key not in self.relations:
            self.relations[key] = (relation, (variable,))
            allowed = self.layout.domains.variable_domains(flat)[variable.name]
            name = self._predicate(relation)
            self.related += [f"({name} {self._object(o)})" for o in self.problem.objects if o in allowed]
        return relation

    def _relate(self, formula: Compare, large: Sequence[Variable], flat: FlatRule) -> None:
        """A numeric guard over locations, grounded into static facts of a predicate of its own."""
        key = (formula,)
        if key not in self.relations:
            names = free_names(formula)
            variables = tuple(v for v in large if v.name in names)
            self.relations[key] = relation, _ = f"`guard_{len(self.relations)}", variables
            domains = self.layout.domains.variable_domains(flat)
            for env, _ in self.guards.solutions(variables, key, {}, None, domains):
                things = " ".join(self._object(env[v.name]) for v in variables)
                self.related.append(f"({self._predicate(relation)} {things})")

    def _choices(
        self, variables: Sequence[Variable], env: Environment, domains: Mapping[str, frozenset[str]]
    ) -> Iterator[Environment]:
        if not variables:
            yield env
            return
        first, *rest = variables
        if isinstance(first.type, ChainType):
            others = [value for value in env.values() if isinstance(value, Chain)]
            values: Sequence[object] = [
                c for c in self._chains(first.type) if all(self._together(first.type, c, o) for o in others)
            ]
        elif isinstance(first.type, RangeType):
            values = self.guards.values(first, env, None)
        else:
            values = [o for o in self.problem.objects if o in domains[first.name]]
        for value in values:
            yield from self._choices(rest, {**env, first.name: value}, domains)

    def _chains(self, kind: ChainType) -> Iterator[Chain]:
        """Every chain that the modules of the problem could ever form. Raises UsageError where they are too many."""
        modules = [m for m in self.problem.of_type(kind.element) if m in self.problem.world.modules]
        lines = sum(perm(len(modules), size) for size in range(1, min(len(modules), 4) + 1))
        if lines > SYMBOLIC.pddl_chains:
            raise UsageError(f"PDDL needs actions for each chain, and {len(modules)} modules could form too many")
        for size in range(1, len(modules) + 1):
            for line in permutations(modules, size):
                sides = [self._passages(m) for m in line]
                for passage in product(*sides):
                    yield Chain(tuple((m, a, b) for m, (a, b) in zip(line, passage, strict=True)))

    def _passages(self, module: str) -> list[tuple[str, str]]:
        ends = [f"{module}.{e.name}" for e in self.problem.world.modules[module].type.effectors]
        return list(permutations(ends, 2))

    def _settled(self, formula: Formula, env: Environment) -> Formula:
        """What remains of a condition, with quantifiers over chains replaced by all chains that could ever be."""
        if not has_chains(formula):
            return self._unquantified(self.guards.reduce(formula, env, None), env)
        match formula:
            case And():
                return conjunction(self._settled(f, env) for f in formula.operands)
            case Or():
                return disjunction(self._settled(f, env) for f in formula.operands)
            case Exists() | Forall():
                return self._quantified(formula, env)
            case _:
                raise UsageError(f"PDDL cannot say {formula}")

    def _unquantified(self, formula: Formula, env: Environment) -> Formula:
        """What remains of a condition, with quantifiers over things replaced by all of them."""
        match formula:
            case And():
                return conjunction(self._unquantified(f, env) for f in formula.operands)
            case Or():
                return disjunction(self._unquantified(f, env) for f in formula.operands)
            case Exists() | Forall():
                found = (e for e, _ in self.guards.solutions(formula.variables, (), env, None))
                all_of_them = (self._unquantified(self.guards.reduce(formula.body, e, None), e) for e in found)
                return conjunction(all_of_them) if isinstance(formula, Forall) else disjunction(all_of_them)
            case _:
                return formula

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

    def _together(self, kind: ChainType, one: Chain, other: Chain) -> bool:
        """Whether two chains can be there at once: no link that one needs is denied by the other."""
        told = [self._told(kind, chain) for chain in (one, other)]
        return not told[0][0] & told[1][1] and not told[0][1] & told[1][0]

    def _told(self, kind: ChainType, chain: Chain) -> tuple[frozenset[Fact], frozenset[Fact]]:
        """The links that a chain needs, and those that it denies."""
        if (kind, chain) not in self._links:
            needed: set[Fact] = set()
            denied: set[Fact] = set()
            for formula in self._is_chain(kind, chain):
                literal = formula.operand if isinstance(formula, Not) else formula
                if isinstance(literal, Literal):
                    fact = (literal.predicate, *(a.name for a in literal.args if isinstance(a, Object)))
                    (denied if isinstance(formula, Not) else needed).add(self.layout.canonical(fact))
            self._links[kind, chain] = frozenset(needed), frozenset(denied)
        return self._links[kind, chain]

    def _is_chain(self, kind: ChainType, chain: Chain) -> Iterator[Formula]:
        """The links of a chain hold, and its ends are not linked on."""
        for (_, _, leave), (_, enter, _) in zip(chain.modules, chain.modules[1:], strict=False):
            yield Literal(kind.predicate, (Object(leave), Object(enter)))
        inner = {part for line in chain.modules for part in line}
        for end in dict.fromkeys((chain.first, chain.last)):
            for other in self.problem.of_type("effector"):
                if other not in inner and self.layout.encode((kind.predicate, end, other))[0]:
                    yield Not(Literal(kind.predicate, (Object(end), Object(other))))


def _parameters(names: Sequence[str]) -> str:
    return " ".join(f"?{n}" for n in names) + (" - object_" if names else "")
