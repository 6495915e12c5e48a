"""What remains of a condition for PDDL: without quantifiers, and without what can never be."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import permutations, product
from math import perm

from ...langs.diagnostics import UsageError
from ..ir import (
    And,
    Chain,
    ChainType,
    Compare,
    Exists,
    Forall,
    Formula,
    Literal,
    Not,
    Object,
    Or,
    Problem,
    Term,
    Var,
)
from .algebra import Environment, conjunction, disjunction, negation
from .guards import Guards
from .normal_form import FALSE, TRUE
from .settings import SYMBOLIC
from .successors import has_chains

SOME = "some`"
"""How parameters begin that stand for anything."""


class Settling:
    """Reduces the conditions of one problem."""

    def __init__(self, problem: Problem, guards: Guards) -> None:
        self.problem, self.guards, self.layout = problem, guards, guards.layout

    def _chains(self, kind: ChainType) -> Iterator[Chain]:
        """Every chain that the modules of the problem could ever form. Raises UsageError where they are too many."""
        modules = [m for m in self.problem.of_type(kind.element) if m in self.problem.world.modules]
        lines = sum(perm(len(modules), size) for size in range(1, min(len(modules), 4) + 1))
        if lines > SYMBOLIC.pddl_denied_chains:
            message = f"PDDL would name each chain to deny that there is one, and {len(modules)} modules form too many"
            raise UsageError(message)
        for size in range(1, len(modules) + 1):
            for line in permutations(modules, size):
                sides = [self._passages(m) for m in line]
                for passage in product(*sides):
                    yield Chain(tuple((m, a, b) for m, (a, b) in zip(line, passage, strict=True)))

    def _passages(self, module: str) -> list[tuple[str, str]]:
        ends = [f"{module}.{e.name}" for e in self.problem.world.modules[module].type.effectors]
        return list(permutations(ends, 2))

    def settled(self, formula: Formula, env: Environment) -> Formula:
        """What remains of a condition, with quantifiers over chains replaced by all chains that could ever be."""
        if not has_chains(formula):
            return self._possible(self._unquantified(self.guards.reduce(formula, env, None), env))
        match formula:
            case And():
                return conjunction(self.settled(f, env) for f in formula.operands)
            case Or():
                return disjunction(self.settled(f, env) for f in formula.operands)
            case Exists() | Forall():
                return self._quantified(formula, env)
            case _:
                raise UsageError(f"PDDL cannot say {formula}")

    def _possible(self, formula: Formula) -> Formula:
        """A formula without quantifiers, and without facts that can never be."""
        match formula:
            case And():
                return conjunction(map(self._possible, formula.operands))
            case Or():
                return disjunction(map(self._possible, formula.operands))
            case Not():
                return negation(self._possible(formula.operand))
            case Compare() if formula.left == formula.right and formula.operator in ("=", "!="):
                return TRUE if formula.operator == "=" else FALSE
            case Literal() if any(
                isinstance(a, Object) and a.name not in self.layout.domains.at(formula.predicate, k)
                for k, a in enumerate(formula.args)
            ):
                return FALSE
            case _:
                return formula

    def gathered(self, formula: Formula, count: Iterator[int]) -> Formula:
        """A condition in which a fact that may hold of anything at one place is one literal with a parameter of its
        own there, in place of an alternative for each thing."""
        match formula:
            case And():
                return conjunction(self.gathered(f, count) for f in formula.operands)
            case Or():
                found = [self.gathered(f, count) for f in formula.operands]
                return disjunction(self._grouped(found, count))
            case _:
                return formula

    def _grouped(self, options: Sequence[Formula], count: Iterator[int]) -> list[Formula]:
        groups: dict[tuple[str, int, tuple[Term, ...]], set[Formula]] = {}
        for option in options:
            for k, arg in enumerate(option.args if isinstance(option, Literal) else ()):
                if isinstance(option, Literal) and isinstance(arg, Object):
                    rest = (*option.args[:k], *option.args[k + 1 :])
                    groups.setdefault((option.predicate, k, rest), set()).add(option)
        left = list(options)
        for (predicate, k, rest), found in groups.items():
            if len(found) > 1 and found <= set(left) and found >= set(self._all(predicate, k, rest)):
                some = Literal(predicate, (*rest[:k], Var(f"{SOME}{next(count)}"), *rest[k:]))
                left = [some, *(option for option in left if option not in found)]
        return left

    def _all(self, predicate: str, k: int, rest: tuple[Term, ...]) -> Iterator[Formula]:
        """Every such fact that can ever be."""
        for name in self.layout.domains.at(predicate, k):
            args = (*rest[:k], Object(name), *rest[k:])
            known = [a.name for a in args if isinstance(a, Object)]
            if len(known) < len(args) or self.layout.encode((predicate, *known))[0] != 0:
                yield Literal(predicate, args)

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
            return type(formula)(formula.variables, self.settled(formula.body, env))
        others = tuple(v for v in formula.variables if v is not variable)
        inner = type(formula)(others, formula.body) if others else formula.body
        options = []
        for chain in self._chains(variable.type):
            exists = conjunction(self._is_chain(variable.type, chain))
            rest = self.settled(inner, {**env, variable.name: chain})
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
