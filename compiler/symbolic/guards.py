"""Partial evaluation of formulas and terms, and joins over them.

What is known: static facts, the scene's geometry, values of some variables and, where a flag word is given, the facts
between small objects and hence the chains. What remains is a formula over the other facts and variables.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from operator import is_
from typing import Any

from ..ir import (
    Aggregate,
    And,
    Any_,
    Arith,
    Chain,
    ChainEnd,
    ChainModule,
    ChainType,
    Compare,
    Conditional,
    Exists,
    Fact,
    Forall,
    Formula,
    Function,
    Letter,
    Literal,
    Not,
    Number,
    Object,
    ObjectType,
    Or,
    Previous,
    Problem,
    RangeType,
    Term,
    Value,
    Var,
    Variable,
)
from .algebra import (
    COMPARISONS,
    MATHS,
    Environment,
    Undefined,
    arithmetic,
    conjunction,
    disjunction,
    flip,
    holds,
    negation,
)
from .candidates import Candidates
from .chains import KnownFacts
from .geometry import SceneLengths
from .layout import FIELD, STATIC, Layout
from .normal_form import FALSE, TRUE, free_names


class Guards:
    """`known` facts are static ones, where they are not those of the layout."""

    def __init__(
        self, problem: Problem, layout: Layout, geometry: SceneLengths, known: frozenset[Fact] | None = None
    ) -> None:
        self.problem = problem
        self.layout = layout
        self.geometry = geometry
        self.static = KnownFacts(problem, layout.static if known is None else known)
        self._types: dict[str, tuple[str, ...]] = {}
        self._order = geometry.index
        self.candidates = Candidates(self)

    # --- terms ---------------------------------------------------------------------------------------------------

    def resolve(self, term: Term, env: Environment) -> Term:
        """`term` with known variables replaced; references into chains become objects. Raises Undefined."""
        match term:
            case Object() | Number():
                return term
            case Var():
                value = env.get(term.name)
                if isinstance(value, str):
                    return Object(value)
                return Number(value) if isinstance(value, int) else term
            case ChainEnd():
                chain = env.get(term.chain)
                if isinstance(chain, Chain):
                    return Object(chain.last if term.last else chain.first)
                return term
            case ChainModule():
                return self._chain_module(term, env)
            case Function():
                if free_names(term) <= env.keys():
                    return Number(self.number(term, env))
                args = tuple([self.resolve(a, env) for a in term.args])
                return term if all(map(is_, args, term.args)) else Function(term.name, args)
            case Arith():
                if free_names(term) <= env.keys():
                    return Number(self.number(term, env))
                operands = tuple([self.resolve(a, env) for a in term.operands])
                return term if all(map(is_, operands, term.operands)) else Arith(term.operator, operands)
            case _:
                return term

    def _chain_module(self, term: ChainModule, env: Environment) -> Term:
        chain = env.get(term.chain)
        index = self.resolve(term.index, env)
        if not isinstance(chain, Chain) or not isinstance(index, Number):
            return ChainModule(term.chain, index, term.side)
        name = chain.part(int(index.value), term.side)
        if name is None:
            raise Undefined
        return Object(name)

    def number(self, term: Term, env: Environment) -> Any:
        """The value of a static number; an array where a variable stands for many objects. Raises Undefined."""
        match term:
            case Number():
                return term.value
            case Var():
                return env[term.name]
            case Function():
                return self._function(term, env)
            case Arith():
                values = [self.number(t, env) for t in term.operands]
                return arithmetic(term.operator, values)
            case Conditional():
                chosen = self.reduce(term.condition, env, None)
                return self.number(term.then if chosen == TRUE else term.otherwise, env)
            case Aggregate():
                values = [self.number(term.body, inner) for inner in self.assignments(term.variables, env)]
                return {"min": min, "max": max}[term.operator](values) if term.operator != "sum" else sum(values)
            case _:
                raise Undefined

    def _function(self, term: Function, env: Environment) -> Any:
        name, args = term.name, term.args
        if name in ("distance", "stride"):
            first, second = self.thing(args[0], env), self.thing(args[1], env)
            if name == "distance":
                return self.geometry.distance(first, second)
            return self.geometry.stride(first, second, float(self.number(args[2], env)))
        if name == "radius":
            return self.geometry.radius(self.thing(args[0], env))
        if name == "load" and isinstance(args[0], Var) and isinstance(env.get(args[0].name), Chain):
            return self.geometry.loads.chain(env[args[0].name])
        if name in ("load", "torque"):
            joint = term.args[1].letter if len(term.args) > 1 and isinstance(term.args[1], Letter) else ""
            return self.geometry.load(self.thing(args[0], env), joint)
        if name in ("reach", "length") and len(args) == 1 and isinstance(args[0], Var):
            chain: Chain = env[args[0].name]
            return float(len(chain.modules)) if name == "length" else self.geometry.chain_reach(chain)
        if name == "reach":
            names = [self.geometry.names[self.thing(a, env)] for a in args]
            if len(set(map(self.problem.world.owner, names))) > 1:
                raise Undefined
            return self.geometry.reach(names[0], names[1])
        return MATHS[name](*(self.number(a, env) for a in args))

    def thing(self, term: Term, env: Environment) -> Any:
        """The index of the object that a term denotes, or an array of indices."""
        match self.resolve(term, env):
            case Object(name):
                return self._order[name]
            case Var(name):
                return env[name]
            case _:
                raise Undefined

    # --- formulas ------------------------------------------------------------------------------------------------

    def reduce(self, formula: Formula, env: Environment, word: KnownFacts | None) -> Formula:
        """What remains of a normal-form formula: TRUE, FALSE, or a formula over unknown facts and variables. A literal
        that remains with ANY as value of a functional fact says that there is some value."""
        match formula:
            case Literal():
                return self._literal(formula, env, word)
            case Not():
                return negation(self.reduce(formula.operand, env, word))
            case And():
                return conjunction(self.reduce(f, env, word) for f in formula.operands)
            case Or():
                return disjunction(self.reduce(f, env, word) for f in formula.operands)
            case Compare():
                return self._compare(formula, env)
            case Exists():
                return self._exists(formula, env, word)
            case Forall():
                flipped = Exists(formula.variables, flip(formula.body))
                return negation(self._exists(flipped, env, word))
            case Previous():
                return FALSE

    def _literal(self, literal: Literal, env: Environment, word: KnownFacts | None) -> Formula:
        try:
            args = tuple([self.resolve(a, env) for a in literal.args])
        except Undefined:
            return FALSE
        if not all(isinstance(a, Object) for a in args):
            return literal if all(map(is_, args, literal.args)) else Literal(literal.predicate, args)
        fact = (literal.predicate, *(a.name for a in args if isinstance(a, Object)))
        if self.layout.kinds[literal.predicate] == STATIC:
            return TRUE if fact in self.static.facts else FALSE
        if self.layout.encode(fact)[0] == 0:
            return FALSE
        if word is not None and self.layout.canonical(fact) in self.layout.flags:
            return TRUE if word.holds(fact) else FALSE
        return Literal(literal.predicate, args)

    def _compare(self, formula: Compare, env: Environment) -> Formula:
        try:
            left, right = self.resolve(formula.left, env), self.resolve(formula.right, env)
            if isinstance(left, Object) and isinstance(right, Object):
                return TRUE if COMPARISONS[formula.operator](left.name, right.name) else FALSE
            things = _is_thing(left, env) or _is_thing(right, env)
            if not things and free_names(left) <= env.keys() and free_names(right) <= env.keys():
                return TRUE if holds(formula.operator, self.number(left, env), self.number(right, env)) else FALSE
        except Undefined:
            return FALSE
        return formula if left is formula.left and right is formula.right else Compare(formula.operator, left, right)

    def _exists(self, formula: Exists, env: Environment, word: KnownFacts | None) -> Formula:
        known = env.keys() | {v.name for v in formula.variables}
        if any(isinstance(v.type, RangeType) and not free_names(v.type) <= known for v in formula.variables):
            return formula
        kept = [v for v in formula.variables if not self.is_small(v)]
        unrolled = [v for v in formula.variables if self.is_small(v)]
        bodies = [
            (dict(inner), conjunction(rest)) for inner, rest in self.solutions(unrolled, (formula.body,), env, word)
        ]
        if not kept:
            return disjunction(body for _, body in bodies)
        return disjunction(self._exists_large(kept, body, inner, word) for inner, body in bodies)

    def _exists_large(
        self, variables: list[Variable], body: Formula, env: Environment, word: KnownFacts | None
    ) -> Formula:
        if body in (TRUE, FALSE):
            return body if all(self.values(v, env, word) for v in variables) else FALSE
        if len(variables) == 1 and isinstance(body, Literal):
            some = self._some_value(variables[0], body)
            if some is not None:
                return some
        if not free_names(body) - env.keys() <= {v.name for v in variables}:
            return Exists(tuple(variables), body)
        found = self.solutions(variables, (body,), env, word)
        return disjunction(conjunction(rest) for _, rest in found)

    def _some_value(self, variable: Variable, literal: Literal) -> Formula | None:
        """`exists X { (p X key) }` as one test of the field of `key`, when X may be every value."""
        if self.layout.kinds[literal.predicate] != FIELD:
            return None
        key_at = self.problem.predicates[literal.predicate].functional_in or 0
        key, value = literal.args[key_at], literal.args[1 - key_at]
        if value != Var(variable.name) or not isinstance(key, Object):
            return None
        place = self.layout.fields.get((literal.predicate, key.name))
        if place is None:
            return FALSE
        if not set(place.values) <= set(self.values(variable, {}, None)):
            return None
        args = (key, Any_()) if key_at == 0 else (Any_(), key)
        return Literal(literal.predicate, args)

    # --- values and joins ----------------------------------------------------------------------------------------

    def is_small(self, variable: Variable) -> bool:
        """Whether a variable is unrolled: ranges, chains, and objects that are all effectors or modules."""
        if isinstance(variable.type, ObjectType):
            return self.layout.domains.of_type(variable.type.name) <= self.layout.small
        return True

    def values(self, variable: Variable, env: Environment, word: KnownFacts | None) -> Sequence[Value]:
        """All values of a variable, in the order of declaration."""
        match variable.type:
            case ObjectType(name):
                if name not in self._types:
                    self._types[name] = self.problem.of_type(name)
                return self._types[name]
            case ChainType():
                if word is None:
                    raise Undefined
                return word.chains(variable.type)
            case RangeType(first, last):
                bounds = (self.number(self.resolve(t, env), env) for t in (first, last))
                low, high = (round(float(b)) for b in bounds)
                return range(low, high + 1)
            case _:
                raise Undefined

    def assignments(self, variables: Sequence[Variable], env: Environment) -> Iterator[Environment]:
        """All values of variables that do not depend on the state."""
        for inner, _ in self.solutions(variables, (), env, None):
            yield inner

    def solutions(
        self,
        variables: Sequence[Variable],
        conjuncts: Sequence[Formula],
        env: Environment,
        word: KnownFacts | None,
        domains: Mapping[str, frozenset[str]] | None = None,
    ) -> Iterator[tuple[Environment, tuple[Formula, ...]]]:
        """All values of `variables` under which no conjunct is refuted, each with what remains of the conjuncts; the
        variable with the fewest candidates first."""
        live = self.live(conjuncts, env, word)
        if live is None:
            return
        if not variables:
            yield env, tuple(live)
            return
        chosen, values, live = self.candidates.branch(variables, live, env, word, domains or {})
        others = [v for v in variables if v is not chosen]
        for value in values:
            yield from self.solutions(others, live, {**env, chosen.name: value}, word, domains)

    def live(
        self, conjuncts: Sequence[Formula], env: Environment, word: KnownFacts | None
    ) -> list[Formula] | None:
        """What remains of conjuncts; None where one is refuted."""
        live: list[Formula] = []
        for formula in conjuncts:
            rest = self.reduce(formula, env, word)
            if rest == FALSE:
                return None
            for part in rest.operands if isinstance(rest, And) else (rest,):
                if part not in live:
                    live.append(part)
        return live


def _is_thing(term: Term, env: Environment) -> bool:
    """An object, or a chain variable; the other side is then one too, not known yet."""
    return isinstance(term, Object | ChainEnd | ChainModule) or (isinstance(term, Var) and term.name not in env)
