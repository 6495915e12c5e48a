"""Export: a problem as PDDL that every planner reads: typed STRIPS, positive conditions only.

Numeric guards over locations become static facts of their own; rules over chains become one action for every length
that chains could ever have, whose parameters are the ends of the modules; alternatives become actions of their own;
motion literals are left out. A goal with alternatives is reached by one action more.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import count, product
from math import prod
from typing import Any

from ...langs.diagnostics import UsageError
from ..ir import (
    And,
    ChainType,
    Compare,
    Effect,
    EffectIf,
    EffectItem,
    Exists,
    Formula,
    Literal,
    Not,
    Object,
    Problem,
    RangeType,
    Term,
    Var,
    Variable,
    effects_of,
)
from .algebra import Environment, conjunction, negation
from .domains import FlatRule
from .guards import Guards
from .lifted_chains import ChainLifting, LiftedRule, ends_named, ends_of
from .normal_form import FALSE, TRUE, free_names, substitute
from .pddl_conditions import SOME, Settling
from .settings import SYMBOLIC
from .strips import NOBODY, NOTHING, THING, Change, Schema, Strips, alternatives, contradicts, denial, literals
from .successors import Successors


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
        self.lifting, self.settling = ChainLifting(self.guards), Settling(problem, self.guards)
        self.relations: dict[object, tuple[str, int]] = {}
        self.related: list[str] = []
        self._names: dict[tuple[str, str], str] = {}
        self._taken = {"reached", "object_"}
        self.schemas = [s for flat in self.successors.domains.rules for s in self.actions(flat)]
        self.goals = list(self._reaching(problem.goal))
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
        ways = [(relation, 2) for relation in self.lifting.relations]
        for relation, places in [*self.relations.values(), *ways]:
            lines.append(f"    ({self._predicate(relation)} {_parameters([f'x{k}' for k in range(places)])})")
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
        for relation, passage in self.lifting.relations.items():
            for _, *ends in passage.pairs:
                shown.append(f"({' '.join([self._predicate(relation), *map(self._object, ends)])})")
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
        return list(dict.fromkeys(map(self._literal, [*schema.static, *schema.more])))

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
        for name, chain in schema.chains.items():
            ends = chain.values(values[name]) if name in values else {}
            if ends is None:
                return None
            known |= ends
        for name, other in schema.same.items():
            if name in values and known.setdefault(other, values[name]) != values[name]:
                return None
        return {f"?{self._variable(n)}": self._object(value) for n, value in known.items()}

    def shown(self, schema: Schema) -> list[str]:
        """The parameters of an action, in order."""
        return [f"?{self._variable(n)}" for n in schema.parameters]

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

    def _reaching(self, goal: Formula) -> Iterator[Schema]:
        """The alternatives of the goal, as actions without effect. What it asks of chains is a condition on ends."""
        for hidden, conjuncts in self.successors.normal.alternatives(goal):
            chains = [v for v in hidden if isinstance(v.type, ChainType)]
            others = tuple(v for v in hidden if v not in chains)
            for lifted in self.lifting.choices(chains):
                env = {name: chain.sample for name, chain in lifted.items()}
                whole = conjunction(self.lifting.lift(f, lifted, env) for f in conjuncts)
                large = ends_of(lifted)
                links = [f for chain in lifted.values() for f in chain.holds(self._linkable(chain.type))]
                every = {v.name: frozenset(self.problem.of_type("effector")) for v in large}
                asked = Exists(others, whole) if others else whole
                both = conjunction((*links, self.settling.settled(asked, env)))
                for option in alternatives(self.settling.gathered(both, count())):
                    conditions, static = literals(option, self.layout)
                    known = LiftedRule([], lifted, {}, every, large)
                    names = [*(v.name for v in large), *_some(conditions)]
                    related = [self._relate(c, known) for c in static]
                    yield Schema("`reach", names, conditions, related, [], chains=lifted)

    def actions(self, flat: FlatRule) -> Iterator[Schema]:
        """One action per choice of the small variables under which the rule may fire, per length of its chains, and per
        alternative."""
        domains = dict(self.layout.domains.variable_domains(flat))
        ranges = [v for v in flat.variables if isinstance(v.type, RangeType)]
        objects = [v for v in flat.variables if v.name in domains]
        every = frozenset(self.problem.of_type("effector"))
        for chains in self.lifting.choices([v for v in flat.variables if isinstance(v.type, ChainType)]):
            known = {name: chain.sample for name, chain in chains.items()}
            for env in self._choices(ranges, known, domains):
                conjuncts = [self.lifting.lift(f, chains, env) for f in flat.conjuncts]
                same, conjuncts = ends_named(conjuncts, chains, domains)
                small = [v for v in objects if v.name not in same and domains[v.name] <= self.layout.small]
                if prod(len(domains[v.name]) for v in small) > SYMBOLIC.pddl_choices:
                    small = []
                large = [v for v in objects if v.name not in same and v not in small] + ends_of(chains)
                ends = {v.name: every for v in large if v.name not in domains}
                lifted = LiftedRule(conjuncts, chains, same, {**domains, **ends}, large)
                for whole in self._choices(small, env, domains):
                    yield from self._actions(flat, lifted, whole)

    def _actions(self, flat: FlatRule, lifted: LiftedRule, env: Environment) -> Iterator[Schema]:
        settled = [f for chain in lifted.chains.values() for f in chain.holds(self._linkable(chain.type))]
        for formula in lifted.conjuncts:
            settled.append(self.settling.settled(formula, env))
            if settled[-1] == FALSE:
                return
        whole = conjunction(settled)
        for condition, changes in self._changes(flat.rule.effects, env, lifted):
            both = conjunction((whole, condition, *self.strips.single(changes)))
            both = self.settling.gathered(both, count())
            for option in [] if both == FALSE else alternatives(both):
                conditions, static = literals(option, self.layout)
                if not contradicts(conditions):
                    related = [self._relate(compare, lifted) for compare in static]
                    names = [*(v.name for v in lifted.large), *_some(conditions)]
                    kept = {name: value for name, value in env.items() if name not in lifted.chains}
                    schema = Schema(
                        flat.rule.name, names, conditions, related, list(changes), env=kept, chains=lifted.chains,
                        same=lifted.same,
                    )  # fmt: skip
                    own = {v.name: v.name for v in lifted.large if v in flat.variables} | dict(lifted.same)
                    schema.more += [Literal(self._typed(v, flat), (Var(name),)) for v, name in own.items()]
                    yield schema

    def _linkable(self, kind: ChainType) -> list[str]:
        """The ends to which those of a chain may ever be linked."""
        ends = self.layout.domains.at(kind.predicate, 0) | self.layout.domains.at(kind.predicate, 1)
        return [e for e in self.problem.of_type("effector") if e in ends]

    def _changes(
        self, items: Sequence[EffectItem], env: Environment, lifted: LiftedRule
    ) -> Iterator[tuple[Formula, tuple[Change, ...]]]:
        """The effects of a rule for every way in which its conditional effects may come out."""
        branches: list[tuple[Formula, tuple[Change, ...]]] = [(TRUE, ())]
        for item in items:
            options: list[tuple[Formula, tuple[Change, ...]]] = []
            if isinstance(item, Effect):
                literal = item.literal
                if literal.motion:
                    continue
                literal = self._lift(literal, env, lifted)
                args = tuple(self.guards.resolve(a, env) for a in literal.args)
                options = [(TRUE, ((Literal(literal.predicate, args), item.negated),))]
            elif isinstance(item, EffectIf):
                if all(effect.literal.motion for effect in effects_of(item.effects)):
                    continue
                asked = self._lift(self.successors.normal.normal(item.condition, {}, False), env, lifted)
                condition = self.settling.settled(asked, env)
                options = [(conjunction((condition, c)), e) for c, e in self._changes(item.effects, env, lifted)]
                options = [(c, e) for c, e in [*options, (negation(condition), ())] if c != FALSE]
            else:
                inner = [e for e, _ in self.guards.solutions(item.variables, (), env, None)]
                for found in product(*(list(self._changes(item.effects, e, lifted)) for e in inner)):
                    options.append((conjunction(c for c, _ in found), sum((e for _, e in found), ())))
            branches = [(conjunction((a, c)), (*b, *e)) for a, b in branches for c, e in options]
            branches = [(condition, changes) for condition, changes in branches if not _denied(condition)]
            if len(branches) > SYMBOLIC.pddl_branches:
                raise UsageError("a rule has too many conditional effects for PDDL")
        yield from ((c, e) for c, e in branches if c != FALSE)

    def _lift(self, part: Any, env: Environment, lifted: LiftedRule) -> Any:
        renaming = {name: Var(other) for name, other in lifted.same.items()}
        return substitute(self.lifting.lift(part, lifted.chains, env), renaming)

    def _typed(self, name: str, flat: FlatRule) -> str:
        """Type and static reach of a variable, as a unary relation."""
        allowed = self.layout.domains.variable_domains(flat)[name]
        key = (name, flat.rule.name, allowed)
        if key not in self.relations:
            relation = self._relation(f"`may_{flat.rule.name}_{name}", key, 1)
            shown = self._predicate(relation)
            self.related += [f"({shown} {self._object(o)})" for o in self.problem.objects if o in allowed]
        return self.relations[key][0]

    def _relation(self, name: str, key: object, places: int) -> str:
        """A static predicate of its own for `key`, called like `name`."""
        taken = {relation for relation, _ in self.relations.values()}
        fresh = name if name not in taken else f"{name}_{len(self.relations)}"
        self.relations[key] = fresh, places
        return fresh

    def _relate(self, formula: Compare, lifted: LiftedRule) -> Literal:
        """A numeric guard over locations, or a comparison of things, grounded into static facts of a predicate of its
        own."""
        names = free_names(formula)
        variables = tuple(v for v in lifted.large if v.name in names)
        key = (formula, tuple(lifted.domains[v.name] for v in variables))
        if key not in self.relations:
            relation = self._relation(f"`guard_{len(self.relations)}", key, len(variables))
            for env, _ in self.guards.solutions(variables, (formula,), {}, None, lifted.domains):
                things = " ".join(self._object(env[v.name]) for v in variables)
                self.related.append(f"({self._predicate(relation)} {things})")
        return Literal(self.relations[key][0], tuple(Var(v.name) for v in variables))

    def _choices(
        self, variables: Sequence[Variable], env: Environment, domains: Mapping[str, frozenset[str]]
    ) -> Iterator[Environment]:
        if not variables:
            yield env
            return
        first, *rest = variables
        if isinstance(first.type, RangeType):
            values: Sequence[object] = self.guards.values(first, env, None)
        else:
            values = [o for o in self.problem.objects if o in domains[first.name]]
        for value in values:
            yield from self._choices(rest, {**env, first.name: value}, domains)


def _parameters(names: Sequence[str]) -> str:
    return " ".join(f"?{n}" for n in names) + (" - object_" if names else "")


def _some(conditions: Sequence[tuple[Literal, bool]]) -> list[str]:
    """The parameters in conditions that stand for anything."""
    names = (a.name for literal, _ in conditions for a in literal.args if isinstance(a, Var))
    return list(dict.fromkeys(name for name in names if name.startswith(SOME)))


def _denied(formula: Formula) -> bool:
    """Whether a conjunction asks for something and for its contrary."""
    parts = set(formula.operands) if isinstance(formula, And) else set()
    return any(isinstance(part, Not) and part.operand in parts for part in parts)
