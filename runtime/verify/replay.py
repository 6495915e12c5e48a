"""A plain interpreter of the decision rules on sets of ground facts, and the replay of a whole plan with it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import field

from ...compiler import ir
from ...compiler.printing_terms import format_formula
from ...langs.frozen import dataclass
from ...langs.source import Span
from ..plan import LiteralRecord, PhaseRecord, PlaceRecord, Plan
from .findings import Findings
from .formulas import (
    Environment,
    ReplayError,
    State,
    Value,
    bindings,
    holds,
    matches,
    number,
    pattern,
    unmeasured,
    values,
)
from .guards import Guards
from .happenings import left_at, scene_at, without
from .kinematics import Motion

Facts = frozenset[ir.Fact]


class Inapplicable(ReplayError):
    """A condition of the action is false; `place` is where it stands in the source."""

    def __init__(self, message: str, place: Span | None) -> None:
        super().__init__(message)
        self.place = place


@dataclass(frozen=True, slots=True)
class Applied:
    """What an action leaves: logic facts, motion literals, those of both that it added, and where each is written."""

    facts: Facts
    motion: Facts
    added_facts: Facts
    added_motion: Facts
    places: Mapping[ir.Fact, Span | None]


@dataclass(slots=True)
class _Changes:
    deleted: list[tuple[bool, str, tuple[str | None, ...]]] = field(default_factory=list)
    added: dict[tuple[bool, ir.Fact], Span | None] = field(default_factory=dict)


class Interpreter:
    """The rules of one problem. Raises MissingLibrary when coal, which measures guards, cannot be loaded."""

    def __init__(self, problem: ir.Problem) -> None:
        self.problem = problem
        self._guards = Guards(problem)

    def state(self, facts: Facts) -> State:
        """The facts as something that formulas can be asked of."""
        return State(self.problem, facts, self._guards)

    def holds(self, facts: Facts, formula: ir.Formula) -> bool:
        """Whether a formula without free variables is true of the facts."""
        return holds(self.state(facts), formula, {})

    def applicable(self, facts: Facts, rule: ir.Rule) -> Iterator[ir.Action]:
        """All ground instances of the rule that can be done."""
        state = self.state(facts)
        for environment in bindings(state, rule.variables, {}):
            if holds(state, rule.condition, environment):
                action = ground(rule, environment)
                with suppress(Inapplicable):
                    self.effects(facts, frozenset(), action)
                    yield action

    def action(self, facts: Facts, rule: str, arguments: Sequence[str]) -> ir.Action:
        """The action that a plan file spells. Raises ReplayError when it is none in this state."""
        if rule not in self.problem.rules:
            raise ReplayError(f"there is no rule `{rule}`")
        variables = self.problem.rules[rule].variables
        if len(arguments) != len(variables):
            raise ReplayError(f"{rule} takes {len(variables)} arguments, not {len(arguments)}")
        state = self.state(facts)
        environment: dict[str, Value] = {}
        for variable, text in zip(variables, arguments, strict=True):
            choices = {str(v): v for v in values(state, variable.type, environment)}
            if text not in choices:
                raise ReplayError(f"{text} is no possible value of {variable.name} in {rule}")
            environment[variable.name] = choices[text]
        return ir.Action(rule, tuple(_argument(v) for v in environment.values()))

    def apply(
        self, facts: Facts, motion: Facts, action: ir.Action
    ) -> Applied:
        """The state after the action; deletions before additions. Raises Inapplicable, ReplayError."""
        rule = self.problem.rules[action.rule]
        environment = {v.name: a for v, a in zip(rule.variables, action.args, strict=True)}
        self._require(self.state(facts), rule.condition, environment, action)
        return self.effects(facts, motion, action)

    def require_unmeasured(self, facts: Facts, action: ir.Action) -> None:
        """As much of the action's condition as does not measure a scene that may have moved. Raises Inapplicable,
        ReplayError."""
        rule = self.problem.rules[action.rule]
        environment = {v.name: a for v, a in zip(rule.variables, action.args, strict=True)}
        self._require(self.state(facts), unmeasured(self.problem, rule.condition), environment, action)

    def effects(
        self, facts: Facts, motion: Facts, action: ir.Action
    ) -> Applied:
        """The state after the action, whose condition is not asked. Raises Inapplicable where a functional predicate
        would have two values, ReplayError."""
        rule = self.problem.rules[action.rule]
        state = self.state(facts)
        environment = {v.name: a for v, a in zip(rule.variables, action.args, strict=True)}
        changes = _Changes()
        self._collect(state, rule.effects, environment, changes)
        return self._outcome(facts, motion, changes)

    def cost(self, facts: Facts, action: ir.Action) -> float:
        """What an action costs in the state given by `facts`. Raises ReplayError."""
        rule = self.problem.rules[action.rule]
        environment = {v.name: a for v, a in zip(rule.variables, action.args, strict=True)}
        return number(self.state(facts), rule.cost, environment)

    def _require(
        self, state: State, condition: ir.Formula, environment: Environment, action: ir.Action
    ) -> None:
        parts = condition.operands if isinstance(condition, ir.And) else (condition,)
        for part in parts:
            if isinstance(part, ir.And):
                self._require(state, part, environment, action)
            elif not holds(state, part, environment):
                raise Inapplicable(f"a condition of {action} does not hold", ir.span_of(part))

    def _collect(
        self, state: State, effects: Sequence[ir.EffectItem], environment: Environment, changes: _Changes
    ) -> None:
        for effect in effects:
            match effect:
                case ir.EffectIf():
                    if holds(state, effect.condition, environment):
                        self._collect(state, effect.effects, environment, changes)
                case ir.EffectFor():
                    for inner in bindings(state, effect.variables, environment):
                        self._collect(state, effect.effects, inner, changes)
                case ir.Effect():
                    self._note(state, effect, environment, changes)

    def _note(self, state: State, effect: ir.Effect, environment: Environment, changes: _Changes) -> None:
        literal = effect.literal
        names = pattern(state, literal.args, environment)
        both = [names, names[::-1]] if self._symmetric(literal.predicate, literal.motion) else [names]
        if effect.negated:
            changes.deleted += [(literal.motion, literal.predicate, p) for p in both]
            return
        if None in names:
            raise ReplayError(f"an effect adds ({literal.predicate} …) of ANY object")
        for p in both[:1] if literal.motion else both:
            changes.added[literal.motion, (literal.predicate, *(n for n in p if n is not None))] = literal.span

    def _outcome(self, facts: Facts, motion: Facts, changes: _Changes) -> Applied:
        def kept(old: Facts, is_motion: bool) -> Facts:
            gone = [(p, names) for m, p, names in changes.deleted if m == is_motion]
            return frozenset(f for f in old if not any(f[0] == p and matches(n, f[1:]) for p, n in gone))

        added_facts = frozenset(f for is_motion, f in changes.added if not is_motion)
        added_motion = self.canonical(f for is_motion, f in changes.added if is_motion)
        places = {f: span for (_, f), span in changes.added.items()}
        after = kept(facts, False) | added_facts
        self._require_functional(after, places)
        moved = self.canonical(kept(motion, True)) | added_motion
        return Applied(after, moved, added_facts, added_motion, places)

    def _require_functional(self, facts: Facts, places: Mapping[ir.Fact, Span | None]) -> None:
        """An action that would leave two values of a functional predicate cannot be done."""
        owners: dict[tuple[str, str], ir.Fact] = {}
        for fact in sorted(facts):
            declared = self.problem.predicates.get(fact[0])
            index = None if declared is None else declared.functional_in
            if index is not None:
                other = owners.setdefault((fact[0], fact[1 + index]), fact)
                if other != fact:
                    message = f"({' '.join(other)}) and ({' '.join(fact)}) cannot both hold"
                    raise Inapplicable(message, places.get(fact) or places.get(other))

    def _symmetric(self, predicate: str, is_motion: bool) -> bool:
        table: Mapping[str, ir.Predicate | ir.MotionPredicate]
        table = self.problem.motions if is_motion else self.problem.predicates
        declared = table.get(predicate)
        return declared is not None and declared.symmetric

    def canonical(self, motion: Iterator[ir.Fact] | Facts | list[ir.Fact]) -> Facts:
        """Motion literals with the arguments of symmetric ones in alphabetical order."""
        known = self.problem.motions
        return frozenset(
            (f[0], *sorted(f[1:])) if f[0] in known and known[f[0]].symmetric else f for f in motion
        )

    def fluents(self, facts: Facts) -> Facts:
        """The facts of predicates that are not static, symmetric ones in one order only."""
        table = self.problem.predicates
        return frozenset(
            f for f in facts
            if f[0] in table and not table[f[0]].static and not (table[f[0]].symmetric and f[1] > f[-1])
        )  # fmt: skip


def ground(rule: ir.Rule, environment: Environment) -> ir.Action:
    """The action of a rule with these values of its variables. Raises ReplayError."""
    return ir.Action(rule.name, tuple(_argument(environment[v.name]) for v in rule.variables))


def _argument(value: Value) -> ir.Value:
    if isinstance(value, float):
        raise ReplayError(f"{value} cannot be the argument of an action")
    return value


# --- the plan ----------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Story:
    """The motion literals of the plan as the rules give them: during each phase, added at each switch, at the end."""

    modes: tuple[Facts, ...]
    added: tuple[Facts, ...]
    final: Facts


def replay(problem: ir.Problem, plan: Plan, findings: Findings, measured: Motion | None = None) -> Story:
    """Carry out every action of the plan by the rules; compare conditions, stored literals and goal.

    Conditions measure the scene at the start; those of a run, which is planned on the way, measure it as `measured`
    has it when the window of the phase starts, or as its planner foresaw it, when the phase ends.
    """
    interpreter, left = Interpreter(problem), frozenset[str]()
    facts, motion = problem.init, interpreter.canonical(problem.init_motion)
    modes: list[Facts] = []
    added: list[Facts] = []
    for index, phase in enumerate(plan.phases):
        now_left = left_at(problem, plan, phase.start)
        if now_left != left:
            left, interpreter = now_left, Interpreter(without(problem, now_left))
            facts, motion = _remaining(facts, left), _remaining(motion, left)
        modes.append(motion)
        _compare(f"phase {index + 1}: mode", interpreter.canonical(_facts(phase.mode)), motion, phase, findings)
        _compare(f"phase {index + 1}: literals", _facts(phase.literals), interpreter.fluents(facts), phase, findings)
        try:
            action = interpreter.action(facts, phase.rule, phase.args)
            _check_label(problem, index, phase, action, findings)
            if not phase.completed:
                added.append(frozenset())
                _broken_off(index, phase, findings)
                interpreter.require_unmeasured(facts, action)
                continue
            scenes = _scenes(interpreter, plan, measured, index)
            outcome = _applied(scenes, facts, motion, action)
        except ReplayError as error:
            place = findings.place_of(error.place) if isinstance(error, Inapplicable) else phase.place
            findings.fail("action", f"phase {index + 1}, {phase.action}: {error}", time=phase.end, place=place)
            return _as_stored(plan, interpreter, modes, added)
        added.append(outcome.added_motion)
        stored = interpreter.canonical(_facts(phase.added))
        if not (outcome.added_motion - motion <= stored <= outcome.added_motion):
            _compare(f"phase {index + 1}: added", stored, outcome.added_motion, phase, findings)
        facts, motion = outcome.facts, outcome.motion
    last = plan.phases[-1] if plan.phases else None
    at_end = left if last is None else left_at(problem, plan, last.end)
    if at_end != left:
        interpreter = Interpreter(without(problem, at_end))
        facts, motion = _remaining(facts, at_end), _remaining(motion, at_end)
    _compare("final mode", interpreter.canonical(_facts(plan.final_mode)), motion, last, findings)
    _check_goal(problem, plan, interpreter, facts, findings)
    return Story(tuple(modes), tuple(added), motion)


def _check_goal(
    problem: ir.Problem, plan: Plan, interpreter: Interpreter, facts: Facts, findings: Findings
) -> None:
    end = plan.phases[-1].end if plan.phases else 0.0
    parts = problem.goal.operands if isinstance(problem.goal, ir.And) else (problem.goal,)
    try:
        findings.unmet = [format_formula(p) for p in parts if not interpreter.holds(facts, p)]
    except ReplayError as error:
        findings.fail("goal", f"the goal cannot be evaluated: {error}")
        return
    if plan.complete and findings.unmet:
        findings.fail("goal", "the goal does not hold at the end", time=end)
    if plan.complete and plan.phases and not plan.phases[-1].completed:
        findings.fail("goal", "the plan is called complete, but its last action did not take place", time=end)


def _check_label(
    problem: ir.Problem, index: int, phase: PhaseRecord, action: ir.Action, findings: Findings
) -> None:
    if str(action) != phase.action:
        findings.fail("action", f"phase {index + 1} is called {phase.action} but is {action}", time=phase.end)
    span = problem.rules[action.rule].span
    place = None if span is None else PlaceRecord(problem.called(span.file), span.line, span.column)
    if phase.place != place:
        findings.fail("action", f"phase {index + 1} does not name the place of rule {action.rule}", time=phase.end)


def _remaining(facts: Facts, left: frozenset[str]) -> Facts:
    return frozenset(f for f in facts if not left.intersection(f[1:]))


def _broken_off(index: int, phase: PhaseRecord, findings: Findings) -> None:
    if phase.added:
        findings.fail("literals", f"phase {index + 1} was broken off, but adds literals", time=phase.end)


def _scenes(
    interpreter: Interpreter, plan: Plan, measured: Motion | None, index: int
) -> Iterator[Interpreter]:
    """The scenes in which the condition of an action may hold: that at the start, or, in a run, which is planned on
    the way, that in which the window of the phase starts, and that in which the phase ends."""
    planned = max((w.phase for w in plan.windows if 0 <= w.phase <= index), default=0)
    if measured is None or planned == 0:
        yield interpreter
    if measured is not None and plan.windows:
        samples = [measured.ranges[planned][0]] if planned else []
        for sample in (*samples, measured.ranges[index][1]):
            yield Interpreter(scene_at(interpreter.problem, measured, sample))


def _applied(
    scenes: Iterator[Interpreter], facts: Facts, motion: Facts, action: ir.Action
) -> Applied:
    """The outcome of an action whose condition holds in one of some scenes. Raises Inapplicable, ReplayError."""
    try:
        return next(scenes).apply(facts, motion, action)
    except Inapplicable:
        for scene in scenes:
            with suppress(Inapplicable):
                return scene.apply(facts, motion, action)
        raise


def _as_stored(plan: Plan, interpreter: Interpreter, modes: list[Facts], added: list[Facts]) -> Story:
    """The rest of the story as the plan tells it, so that its motion can be measured all the same."""
    for phase in plan.phases[len(modes) :]:
        modes.append(_known(interpreter, phase.mode))
    for phase in plan.phases[len(added) :]:
        added.append(_known(interpreter, phase.added))
    return Story(tuple(modes), tuple(added), _known(interpreter, plan.final_mode))


def _known(interpreter: Interpreter, records: Sequence[LiteralRecord]) -> Facts:
    problem = interpreter.problem
    return interpreter.canonical(frozenset(
        f for f in _facts(records)
        if f[0] in problem.motions
        and len(f) == 1 + len(problem.motions[f[0]].variables)
        and all(name in problem.objects for name in f[1:])
    ))  # fmt: skip


def _facts(records: Sequence[LiteralRecord]) -> Facts:
    return frozenset((r.predicate, *r.args) for r in records)


def _compare(what: str, stored: Facts, derived: Facts, phase: PhaseRecord | None, findings: Findings) -> None:
    missing, surplus = sorted(derived - stored), sorted(stored - derived)
    if not missing and not surplus:
        return
    parts = [f"({' '.join(f)}) is missing" for f in missing] + [f"({' '.join(f)}) is false" for f in surplus]
    findings.fail(
        "literals",
        f"{what}: {'; '.join(parts)}",
        time=phase.start if phase else 0.0,
        between=sorted({name for f in missing + surplus for name in f[1:]}),
        place=phase.place if phase else None,
    )
