"""The rules, one action at a time, on states that are sets of facts: what holds after an action.

The search steps packed states, all actions of one at once (`compiler/symbolic/successors.py`). Here it is one action
that is known, for skeletons, plan files, windows and runs. Formulas mean the same: the compiler's guards evaluate
them, which are told all facts, so that nothing is left to ask of a packed state.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import field, replace

from ....compiler import ir
from ....compiler.symbolic.algebra import Environment, Undefined
from ....compiler.symbolic.domains import Domains
from ....compiler.symbolic.geometry import lengths_of
from ....compiler.symbolic.guards import Guards
from ....compiler.symbolic.layout import Layout
from ....compiler.symbolic.normal_form import TRUE, NormalForm
from ....langs.frozen import dataclass
from ....langs.source import Span

Facts = frozenset[ir.Fact]
WILDCARD = "ANY"


class Inapplicable(Exception):
    """An action that cannot be done in a state, or is none of the task."""


@dataclass(frozen=True, slots=True)
class Transition:
    """What an action leaves: logic facts, static ones too, symmetric ones in both orders; motion literals, and those
    that it added; and where the literals that it added are written."""

    facts: Facts
    motion: Facts
    added: Facts
    places: Mapping[ir.Fact, Span | None]


@dataclass(slots=True)
class _Changes:
    """Effects on logic or on motion literals: patterns that are deleted, with ANY, and what is added."""

    deleted: list[ir.Fact] = field(default_factory=list)
    added: dict[ir.Fact, Span | None] = field(default_factory=dict)


class Stepper:
    """The rules of one problem, in its scene."""

    def __init__(self, problem: ir.Problem) -> None:
        self.problem = problem
        self._normal = NormalForm(problem)
        bare = replace(problem, rules={})
        self._layout = Layout(bare, Domains(bare, self._normal))
        self._geometry = lengths_of(problem)
        self._formulas: dict[int, tuple[ir.Formula, ir.Formula]] = {}
        self._last: tuple[Facts, Guards] | None = None

    def holds(self, facts: Facts, formula: ir.Formula, values: Environment | None = None) -> bool:
        """Whether a formula is true of the facts, given the `values` of its free variables."""
        guards = self._guards(facts)
        try:
            return guards.reduce(self._normalised(formula), values or {}, guards.static) == TRUE
        except Undefined:
            return False

    def environments(
        self, facts: Facts, variables: Sequence[ir.Variable], values: Environment | None = None
    ) -> Iterator[Environment]:
        """All values of variables, the first variable's the slowest to change; those of a range may hang on the others'
        before it."""
        values = values or {}
        if not variables:
            yield values
            return
        guards = self._guards(facts)
        for value in guards.values(variables[0], values, guards.static):
            yield from self.environments(facts, variables[1:], {**values, variables[0].name: value})

    def action(self, facts: Facts, rule: str, arguments: Sequence[str]) -> ir.Action:
        """The action that a plan file spells. Raises Inapplicable when it is none in this state."""
        if rule not in self.problem.rules or len(arguments) != len(self.problem.rules[rule].variables):
            raise Inapplicable(f"{rule} {' '.join(arguments)} is no action")
        guards = self._guards(facts)
        values: dict[str, ir.Value] = {}
        for variable, text in zip(self.problem.rules[rule].variables, arguments, strict=True):
            choices = {str(v): v for v in guards.values(variable, values, guards.static)}
            if text not in choices:
                raise Inapplicable(f"{text} is no value of {variable.name} in {rule}")
            values[variable.name] = choices[text]
        return ir.Action(rule, tuple(values.values()))

    def step(self, facts: Facts, motion: Facts, action: ir.Action) -> Transition:
        """The state after an action; deletions come before additions, so that what is deleted and added again counts as
        added. Raises Inapplicable when its condition is false, one of its chains is none, or a functional predicate
        would get two values."""
        rule, values = self._instance(action)
        chains = self._guards(facts).static.chains
        known = all(values[v.name] in chains(v.type) for v in rule.variables if isinstance(v.type, ir.ChainType))
        if not known or not self.holds(facts, rule.condition, values):
            raise Inapplicable(f"{action} cannot be done here")
        step = self.effects(facts, motion, action)
        for fact in step.facts - facts:
            self._require_one_value(step.facts, fact)
        return step

    def effects(self, facts: Facts, motion: Facts, action: ir.Action) -> Transition:
        """The same without a look at the condition."""
        rule, values = self._instance(action)
        logic, moved = changes = _Changes(), _Changes()
        self._collect(facts, rule.effects, values, changes)
        added = self.canonical(moved.added)
        return Transition(
            left(self.problem.predicates, facts, logic.deleted) | self._both_orders(logic.added),
            self.canonical(left(self.problem.motions, motion, moved.deleted)) | added,
            added,
            {told: span for f, span in logic.added.items() for told in self._both_orders((f,))}
            | {told: span for f, span in moved.added.items() for told in self.canonical((f,))}
            | moved.added,
        )

    def cost(self, facts: Facts, action: ir.Action) -> float:
        """What an action costs in a state."""
        rule, values = self._instance(action)
        return float(self._guards(facts).number(rule.cost, values))

    def canonical(self, motion: Iterable[ir.Fact]) -> Facts:
        """Motion literals, the arguments of symmetric ones in alphabetical order."""
        known = self.problem.motions
        return frozenset((f[0], *sorted(f[1:])) if known[f[0]].symmetric else f for f in motion)

    def fluents(self, facts: Facts) -> Facts:
        """The facts of predicates that are not static, symmetric ones in one order only."""
        table = self.problem.predicates
        return frozenset(
            f for f in facts
            if f[0] in table and not table[f[0]].static and not (table[f[0]].symmetric and f[1] > f[-1])
        )  # fmt: skip

    def _instance(self, action: ir.Action) -> tuple[ir.Rule, Environment]:
        rule = self.problem.rules[action.rule]
        return rule, {v.name: value for v, value in zip(rule.variables, action.args, strict=True)}

    def _guards(self, facts: Facts) -> Guards:
        if self._last is None or self._last[0] is not facts:
            self._last = facts, Guards(self.problem, self._layout, self._geometry, facts)
        return self._last[1]

    def _normalised(self, formula: ir.Formula) -> ir.Formula:
        known = self._formulas.get(id(formula))
        if known is None or known[0] is not formula:
            known = self._formulas[id(formula)] = formula, self._normal.normal(formula, {}, False)
        return known[1]

    def _collect(
        self, facts: Facts, items: Sequence[ir.EffectItem], values: Environment, changes: tuple[_Changes, _Changes]
    ) -> None:
        for item in items:
            if isinstance(item, ir.Effect):
                self._note(facts, item, values, changes)
            elif isinstance(item, ir.EffectFor):
                for inner in self.environments(facts, item.variables, values):
                    self._collect(facts, item.effects, inner, changes)
            elif self.holds(facts, item.condition, values):
                self._collect(facts, item.effects, values, changes)

    def _note(
        self, facts: Facts, effect: ir.Effect, values: Environment, changes: tuple[_Changes, _Changes]
    ) -> None:
        try:
            args = [self._guards(facts).resolve(a, values) for a in effect.literal.args]
        except Undefined:
            return
        names = (WILDCARD if isinstance(a, ir.Any_) else a.name for a in args if isinstance(a, ir.Any_ | ir.Object))
        fact = (effect.literal.predicate, *names)
        found = changes[effect.literal.motion]
        if effect.negated:
            found.deleted.append(fact)
        else:
            found.added[fact] = effect.literal.span

    def _both_orders(self, facts: Iterable[ir.Fact]) -> Facts:
        table = self.problem.predicates
        return frozenset(told for f in facts for told in ((f, (f[0], *f[:0:-1])) if table[f[0]].symmetric else (f,)))

    def _require_one_value(self, facts: Facts, fact: ir.Fact) -> None:
        index = self.problem.predicates[fact[0]].functional_in
        if index is not None:
            key = 1 + index
            others = [f for f in facts if f[0] == fact[0] and f[key] == fact[key] and f != fact]
            if others:
                raise Inapplicable(f"({' '.join(others[0])}) and ({' '.join(fact)}) cannot both hold")


def left(
    table: Mapping[str, ir.Predicate] | Mapping[str, ir.MotionPredicate], facts: Facts, patterns: Sequence[ir.Fact]
) -> Facts:
    """The facts that agree with none of some patterns, in which ANY stands for every object."""
    exact: set[ir.Fact] = set()
    swept: dict[str, list[ir.Fact]] = {}
    for pattern in patterns:
        known = table.get(pattern[0])
        both = known is not None and known.symmetric
        orders = (pattern, (pattern[0], *pattern[:0:-1])) if both else (pattern,)
        if WILDCARD in pattern:
            swept.setdefault(pattern[0], []).extend(orders)
        else:
            exact.update(orders)

    def gone(fact: ir.Fact) -> bool:
        return any(all(a in (WILDCARD, b) for a, b in zip(order, fact, strict=True)) for order in swept[fact[0]])

    return frozenset([f for f in facts if f not in exact and (f[0] not in swept or not gone(f))])


def replayed(problem: ir.Problem, actions: Iterable[ir.Action]) -> Iterator[Transition]:
    """The states after actions, one after the other from the start. Raises Inapplicable."""
    stepper = Stepper(problem)
    facts, motion = problem.init, stepper.canonical(problem.init_motion)
    for action in actions:
        step = stepper.step(facts, motion, action)
        yield step
        facts, motion = step.facts, step.motion
