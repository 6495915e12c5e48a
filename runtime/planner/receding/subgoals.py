"""The parts of a goal, which of them hold, and in which order the others should be reached.

The order comes from two facts about achievers, which hold whatever the state is: a part is a landmark of another one
when every way to achieve that needs it (delete relaxation), and it must not be reached after one that every way to
achieve it destroys (reasonable orders, Koehler & Hoffmann 2000).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product

from ....compiler import ir
from ....compiler.printing_terms import format_formula
from ....compiler.symbolic.achievers import Achiever, Achievers
from ....compiler.symbolic.normal_form import NormalForm
from ....compiler.symbolic.successors import Successors
from ..search.stepper import Stepper
from .settings import RECEDING


def parts_of(problem: ir.Problem) -> tuple[ir.Formula, ...]:
    """The conjuncts of the goal, with quantifiers over objects unrolled."""
    return tuple(dict.fromkeys(_parts(problem, NormalForm(problem), problem.goal)))


def _parts(problem: ir.Problem, normal: NormalForm, formula: ir.Formula) -> list[ir.Formula]:
    if isinstance(formula, ir.And):
        return [part for operand in formula.operands for part in _parts(problem, normal, operand)]
    if isinstance(formula, ir.Forall) and all(isinstance(v.type, ir.ObjectType) for v in formula.variables):
        kinds = [v.type.name for v in formula.variables if isinstance(v.type, ir.ObjectType)]
        found: list[ir.Formula] = []
        for names in product(*(problem.of_type(kind) for kind in kinds)):
            pairs = zip(formula.variables, names, strict=True)
            bound: dict[str, ir.Term] = {v.name: ir.Object(name) for v, name in pairs}
            found += _parts(problem, normal, normal.normal(formula.body, bound, False))
        return found
    return [formula]


def unmet(problem: ir.Problem, facts: frozenset[ir.Fact], parts: Sequence[ir.Formula]) -> list[ir.Formula]:
    """The parts that do not hold. Raises MissingLibrary."""
    stepper = Stepper(problem)
    return [part for part in parts if not stepper.holds(facts, part)]


def told(parts: Sequence[ir.Formula]) -> list[str]:
    return [format_formula(part) for part in parts]


def ordered(successors: Successors, parts: Sequence[ir.Formula]) -> list[ir.Formula]:
    """The parts, each behind those that must come before it; otherwise in their own order."""
    if not 1 < len(parts) <= RECEDING.most_ordered:
        return list(parts)
    achievers = Achievers(successors)
    facts = [_fact(successors, part) for part in parts]
    before = _Orders(achievers, facts).before()
    waiting, result = list(range(len(parts))), []
    while waiting:
        ready = [i for i in waiting if not before[i] & set(waiting) - {i}]
        chosen = (ready or waiting)[0]
        waiting.remove(chosen)
        result.append(parts[chosen])
    return result


def _fact(successors: Successors, part: ir.Formula) -> ir.Fact | None:
    known = isinstance(part, ir.Literal) and part.predicate in successors.problem.predicates
    if not known or not isinstance(part, ir.Literal) or not all(isinstance(a, ir.Object) for a in part.args):
        return None
    return (part.predicate, *(a.name for a in part.args if isinstance(a, ir.Object)))


class _Orders:
    """Which facts must come before which."""

    def __init__(self, achievers: Achievers, facts: Sequence[ir.Fact | None]) -> None:
        self.achievers = achievers
        self.facts = facts
        self.numbers: dict[ir.Fact, int] = {fact: i for i, fact in enumerate(facts) if fact is not None}

    def before(self) -> list[set[int]]:
        found: list[set[int]] = [set() for _ in self.facts]
        for fact, i in self.numbers.items():
            found[i] |= self._needed([fact], RECEDING.landmark_depth) - {i}
            for j in self._destroyed(fact) - {i}:
                found[j].add(i)
        return found

    def _needed(self, facts: Sequence[ir.Fact], depth: int) -> set[int]:
        """The parts that each way to achieve one of the facts needs, at once or farther back."""
        achievers = [a for fact in facts for a in self.achievers.of(fact)]
        if not achievers or depth == 0:
            return set()
        common: set[int] | None = None
        for achiever in achievers:
            own: set[int] = set()
            for literal in achiever.flat.conjuncts:
                if isinstance(literal, ir.Literal) and self.achievers.fluent(literal):
                    instances = self.achievers.instances(literal, achiever)
                    if len(instances) == 1:
                        own |= {self.numbers[f] for f in instances if f in self.numbers}
                        own |= self._needed(instances, depth - 1)
            common = own if common is None else common & own
        return common or set()

    def _destroyed(self, fact: ir.Fact) -> set[int]:
        """The parts that every way to achieve a fact deletes for certain."""
        achievers = self.achievers.of(fact)
        if not achievers:
            return set()
        return {
            i for other, i in self.numbers.items()
            if other != fact and all(_deletes(achiever, other) for achiever in achievers)
        }  # fmt: skip


def _deletes(achiever: Achiever, fact: ir.Fact) -> bool:
    for effect in achiever.flat.rule.effects:
        if isinstance(effect, ir.Effect) and effect.negated and not effect.literal.motion:
            literal = effect.literal
            if literal.predicate == fact[0] and _matches(literal.args, fact[1:], achiever.env):
                return True
    return False


def _matches(args: Sequence[ir.Term], names: Sequence[str], env: Mapping[str, str]) -> bool:
    """Whether a pattern means these objects for certain."""
    for arg, name in zip(args, names, strict=True):
        if isinstance(arg, ir.Var) and env.get(arg.name) == name:
            continue
        if isinstance(arg, ir.Any_) or (isinstance(arg, ir.Object) and arg.name == name):
            continue
        return False
    return True
