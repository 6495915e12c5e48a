"""Why a task is proved infeasible, as far as cheap look-ups tell: what is nearest to the objects of its goal, how far
that is, and how far the scene's robots reach at most."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from ....compiler.ir import (
    And,
    Compare,
    Effect,
    EffectItem,
    Exists,
    Forall,
    Formula,
    Function,
    Literal,
    Not,
    Object,
    ObjectType,
    Or,
    Problem,
    Rule,
    Var,
)
from ....compiler.symbolic.geometry import SceneLengths, lengths_of
from ....langs.frozen import dataclass
from ....langs.trees import parts


@dataclass(frozen=True, slots=True)
class Lack:
    """How far an object is from the nearest support that robots can come to, and how far they reach at most; metres."""

    name: str
    support: str
    distance: float
    reach: float
    modules: int

    def __str__(self) -> str:
        robots = "the module reaches" if self.modules == 1 else f"all {self.modules} modules in one line reach"
        text = f"{self.name} is {self.distance:.2f} m from {self.support}, the nearest that robots can come to"
        return f"{text}; {robots} {self.reach:.2f} m: {self.distance - self.reach:.2f} m too little"


def lacking(problem: Problem) -> list[Lack]:
    """The objects of the goal that stand still out of reach of everything that modules stand on, the farthest first."""
    geometry = lengths_of(problem)
    reach = geometry.longest_reach(len(problem.world.modules))
    named = [name for name in dict.fromkeys(_named(problem, problem.goal)) if name in problem.world.bodies]
    supports = _within(geometry, [name for name in _supports(problem) if name not in named], problem, reach)
    found: list[Lack] = []
    for name in named:
        far = [(geometry.distance(geometry.index[s], geometry.index[name]), s) for s in supports]
        if far and min(far)[0] > reach:
            distance, support = min(far)
            found.append(Lack(name, support, distance, reach, len(problem.world.modules)))
    return sorted(found, key=lambda lack: (lack.distance, lack.name), reverse=True)


def achievers(problem: Problem) -> list[tuple[Rule, Compare | None]]:
    """The rules that can make literals of the goal true, each with the first comparison of lengths that it needs."""
    wanted: set[str] = set()
    for literal in (part for part in parts(problem.goal) if isinstance(part, Literal)):
        wanted |= {part.predicate for part in _expanded(problem, literal) if isinstance(part, Literal)}
    found = []
    for rule in problem.rules.values():
        if any(effect.literal.predicate in wanted for effect in _added(rule.effects)):
            found.append((rule, _measured(problem, rule)))
    return found


def _added(items: Sequence[EffectItem]) -> Iterator[Effect]:
    for item in items:
        if not isinstance(item, Effect):
            yield from _added(item.effects)
        elif not item.negated and not item.literal.motion:
            yield item


def _measured(problem: Problem, rule: Rule) -> Compare | None:
    """The first comparison in a rule's condition, or in what it is derived from, that a place in the scene decides."""
    for part in _expanded(problem, rule.condition):
        if isinstance(part, Compare) and part.operator in ("<", "<="):
            inner = [p for p in parts(part) if isinstance(p, Function)]
            if any(function.name in ("distance", "stride") for function in inner):
                return part
    return None


def _expanded(problem: Problem, formula: Formula) -> Iterator[object]:
    """Everything in a formula, with the bodies of derived predicates behind their literals."""
    for part in parts(formula):
        yield part
        if isinstance(part, Literal) and part.predicate in problem.derived:
            yield from _expanded(problem, problem.derived[part.predicate].body)


def _within(geometry: SceneLengths, supports: list[str], problem: Problem, reach: float) -> list[str]:
    """The supports to which a robot of all modules could come, from one to the next, from where modules stand."""
    facts = [fact for fact in problem.init if _touches_module(problem, fact)]
    found = [name for name in supports if any(name in fact for fact in facts)]
    for here in found:
        near = (geometry.distance(geometry.index[here], geometry.index[name]) <= reach for name in supports)
        found += [name for name, close in zip(supports, list(near), strict=True) if close and name not in found]
    return found


def _supports(problem: Problem) -> list[str]:
    """Bodies of the types of those on which modules stand at the start."""
    standing = {fact[k] for fact in problem.init for k in range(1, len(fact)) if _touches_module(problem, fact)}
    types = {problem.objects[name] for name in standing if name in problem.world.bodies}
    return [name for name in problem.world.bodies if problem.objects[name] in types]


def _touches_module(problem: Problem, fact: tuple[str, ...]) -> bool:
    return any(problem.world.effector(name) for name in fact[1:])


def _named(problem: Problem, formula: Formula) -> list[str]:
    """The objects of the goal's literals; of a quantified variable, all objects of its type."""
    match formula:
        case Literal():
            return [a.name for a in formula.args if isinstance(a, Object)]
        case Not():
            return _named(problem, formula.operand)
        case And() | Or():
            return [name for operand in formula.operands for name in _named(problem, operand)]
        case Forall() | Exists():
            found = _named(problem, formula.body)
            used = _variables(formula.body)
            for variable in formula.variables:
                if variable.name in used and isinstance(variable.type, ObjectType):
                    found += problem.of_type(variable.type.name)
            return found
        case _:
            return []


def _variables(formula: Formula) -> set[str]:
    match formula:
        case Literal():
            return {a.name for a in formula.args if isinstance(a, Var)}
        case Not():
            return _variables(formula.operand)
        case And() | Or():
            return set().union(*map(_variables, formula.operands))
        case Forall() | Exists():
            return _variables(formula.body)
        case _:
            return set()
