"""Motion literals of the start that no action can ever delete, by the types and the static conditions of the rules."""

from __future__ import annotations

from ..ir import (
    Any_,
    ChainEnd,
    ChainModule,
    Compare,
    Exists,
    Fact,
    Formula,
    Literal,
    Object,
    ObjectType,
    Problem,
    Rule,
    Term,
    Var,
    conjuncts,
    effects_of,
)

Bound = dict[Term, str]
"""What terms of a rule stand for."""


def permanent(problem: Problem) -> frozenset[Fact]:
    """The motion literals of the start that hold for ever. Some others may: what only the course of a plan rules out is
    not looked at."""
    return frozenset(f for f in problem.init_motion if not any(_deletes(problem, r, f) for r in problem.rules.values()))


def _deletes(problem: Problem, rule: Rule, fact: Fact) -> bool:
    """Whether an instance of the rule may delete the fact."""
    name, *objects = fact
    orders = [objects, objects[::-1]] if problem.motions[name].symmetric else [objects]
    for effect in effects_of(rule.effects):
        literal = effect.literal
        if effect.negated and literal.motion and literal.predicate == name:
            for order in orders:
                bound = _match(problem, rule, literal, order)
                if bound is not None and all(_possible(problem, part, bound) for part in conjuncts(rule.condition)):
                    return True
    return False


def _match(problem: Problem, rule: Rule, literal: Literal, objects: list[str]) -> Bound | None:
    """What the terms of a deleted literal stand for when it means these objects; None when it cannot."""
    types = {v.name: v.type for v in rule.variables}
    bound: Bound = {}
    for term, name in zip(literal.args, objects, strict=True):
        if isinstance(term, Any_):
            continue
        if (isinstance(term, Object) and term.name != name) or bound.get(term, name) != name:
            return None
        kind = types.get(term.name) if isinstance(term, Var) else None
        if isinstance(kind, ObjectType) and not problem.is_a(problem.objects[name], kind.name):
            return None
        of_chain = isinstance(term, ChainEnd) or (isinstance(term, ChainModule) and term.side)
        if of_chain and not problem.is_a(problem.objects[name], "effector"):
            return None
        bound[term] = name
    return bound


def _possible(problem: Problem, formula: Formula, bound: Bound) -> bool:
    """Whether a condition may hold: not where a static literal, or the type of what an equation names, says no."""
    if isinstance(formula, Literal) and formula.predicate in problem.predicates:
        if not problem.predicates[formula.predicate].static:
            return True
        wanted = [t.name if isinstance(t, Object) else bound.get(t) for t in formula.args]
        facts = (f[1:] for f in problem.init if f[0] == formula.predicate)
        return any(all(w in (None, o) for w, o in zip(wanted, fact, strict=True)) for fact in facts)
    if isinstance(formula, Exists):
        types = {v.name: v.type for v in formula.variables}
        for part in conjuncts(formula.body):
            if isinstance(part, Compare) and part.operator == "=":
                for one, other in ((part.left, part.right), (part.right, part.left)):
                    kind = types.get(one.name) if isinstance(one, Var) else None
                    named = bound.get(other)
                    if named and isinstance(kind, ObjectType) and not problem.is_a(problem.objects[named], kind.name):
                        return False
    return True
