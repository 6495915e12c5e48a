"""What an action takes upon itself: whatever came before, nothing but what it adds holds a thing after it."""

from __future__ import annotations

from ....compiler.ir import Any_, Effect, ObjectType, Problem, Rule, Term, Var
from ....compiler.kept_pairs import keeps_pose, places_kept
from ....compiler.lifted_ir import effects_with_loops
from ....compiler.remembering import remembered
from ...skeleton import Phase


def lone_holders(problem: Problem, phase: Phase, name: str) -> tuple[str, ...]:
    """The objects that alone hold a body after an action, whatever held it before: the rule deletes all that kept the
    body's pose, and nothing else could hang it up. Empty where that is not known."""
    rule = problem.rules[phase.action.rule]
    own = [v.name for v, value in zip(rule.variables, phase.action.args, strict=True) if value == name]
    keeping = _keeping(problem, name)
    if keeping is None or not any(keeping <= _deleted(problem, rule, variable) for variable in own):
        return ()
    pairs = [keeps_pose(problem, literal) for literal in sorted(phase.added)]
    return tuple(pair[0] for pair in pairs if pair is not None and pair[1] == name)


def _deleted(problem: Problem, rule: Rule, variable: str) -> frozenset[str]:
    """The motion predicates by which nothing keeps the pose of what a variable stands for after a rule."""
    found = set[str]()
    for effect in rule.effects:
        if not isinstance(effect, Effect) or not effect.negated or not effect.literal.motion:
            continue
        places, args = places_kept(problem.motions[effect.literal.predicate]), effect.literal.args
        if places is not None:
            others = [term for place, term in enumerate(args) if place != places[1]]
            own = args[places[1]]
            if isinstance(own, Var) and own.name == variable and all(isinstance(term, Any_) for term in others):
                found.add(effect.literal.predicate)
    return frozenset(found)


@remembered(8)
def _keeping(problem: Problem, name: str) -> frozenset[str] | None:
    """The motion predicates that may keep the pose of a body; None where something that it carries, and that does not
    merely rest on it, might hold it up in turn."""
    found = {literal[0] for literal in problem.init_motion if (keeps_pose(problem, literal) or ("", ""))[1] == name}
    if any((keeps_pose(problem, literal) or ("", ""))[0] == name for literal in problem.init_motion):
        return None
    for rule in problem.rules.values():
        added = [e.literal for e, _ in effects_with_loops(rule.effects) if e.literal.motion and not e.negated]
        resting = [set(literal.args[:2]) for literal in added if problem.motions[literal.predicate].borne == "rest"]
        for literal in added:
            places = places_kept(problem.motions[literal.predicate])
            if places is None:
                continue
            fixed, follows = literal.args[places[0]], literal.args[places[1]]
            if _may_be(problem, rule, follows, name):
                found.add(literal.predicate)
            if _may_be(problem, rule, fixed, name) and {fixed, follows} not in resting:
                return None
    return frozenset(found)


def _may_be(problem: Problem, rule: Rule, term: Term, name: str) -> bool:
    """Whether a term of a rule may stand for a body."""
    types = {v.name: v.type for v in rule.variables}
    if isinstance(term, Var) and isinstance(kind := types.get(term.name), ObjectType):
        return problem.is_a(problem.objects[name], kind.name)
    return isinstance(term, Var | Any_)
