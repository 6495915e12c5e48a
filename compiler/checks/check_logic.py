"""Declarations of the logic: predicates, derived predicates, rules and placements. Syntax in, IR out."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from ...langs import syntax
from ...langs.frozen import dataclass
from ...langs.source import Span
from ...langs.trees import parts
from .. import ir
from .binders import bind
from .chain_bounds import check_chain_bounds
from .context import Context
from .effects import check_effects
from .formulas import TRUE, check_formula
from .kinds import NUMBER
from .names import Scope
from .relaxation import needed_literals
from .scalars import check_scalar


@dataclass(frozen=True, slots=True)
class PlacementChoice:
    """What holds at the start for every `subject` that stands or lies on a `support`."""

    subject: ir.Variable
    support: ir.Variable
    literals: tuple[ir.Literal, ...]
    span: Span

    @property
    def types(self) -> tuple[str, str]:
        """The types of what stands and of what it stands on."""
        one, other = (
            v.type.name if isinstance(v.type, ir.ObjectType) else "object" for v in (self.subject, self.support)
        )
        return one, other


def lower_predicates(context: Context) -> dict[str, ir.Predicate]:
    """All logic predicates that are not derived."""
    lowered = {}
    for declaration in context.library.predicates.values():
        signature = context.logic[declaration.name]
        names = [v.name for v in signature.variables]
        key = declaration.functional_in
        lowered[declaration.name] = ir.Predicate(
            declaration.name,
            signature.variables,
            declaration.static,
            declaration.symmetric,
            names.index(key) if key in names else None,
            signature.span,
        )
    return lowered


def check_derived(context: Context) -> dict[str, ir.Derived]:
    """All derived predicates; reports those that use themselves."""
    lowered = {}
    for declaration in context.library.derived.values():
        scope, variables = bind(context, Scope("rule"), _unique(declaration.parameters))
        body = check_formula(context, scope, declaration.body)
        derived = ir.Derived(declaration.name, variables, body, context.logic[declaration.name].span)
        check_chain_bounds(context, derived)
        lowered[declaration.name] = derived
    _check_circles(context, lowered)
    return lowered


def _unique(parameters: tuple[syntax.Parameter, ...]) -> list[syntax.Parameter]:
    return list({p.name: p for p in parameters}.values())


def _check_circles(context: Context, derived: Mapping[str, ir.Derived]) -> None:
    uses = {name: predicates_in(d.body) & derived.keys() for name, d in derived.items()}
    for name in _suspects(uses):
        reached, frontier = set[str](), sorted(uses[name])
        while frontier:
            current = frontier.pop()
            if current not in reached:
                reached.add(current)
                frontier.extend(sorted(uses[current]))
        if name in reached:
            context.findings.report("E0307", derived[name].span, f"`{name}` is derived from itself")


def _suspects(uses: Mapping[str, set[str]]) -> list[str]:
    """What is left when all is taken away, again and again, that uses nothing else that is left."""
    users: dict[str, list[str]] = {}
    for name, used in uses.items():
        for other in used:
            users.setdefault(other, []).append(name)
    left = {name: len(used) for name, used in uses.items()}
    ready = [name for name, count in left.items() if count == 0]
    while ready:
        name = ready.pop()
        del left[name]
        for user in users.get(name, ()):
            left[user] -= 1
            if left[user] == 0:
                ready.append(user)
    return list(left)


def check_rules(context: Context) -> dict[str, ir.Rule]:
    """All decision rules."""
    return {name: _check_rule(context, rule) for name, rule in context.library.rules.items()}


def _check_rule(context: Context, rule: syntax.RuleDecl) -> ir.Rule:
    scope, variables = bind(context, Scope("rule"), rule.parameters)
    conditions = tuple(check_formula(context, scope, f) for f in (*rule.pre, *rule.where))
    effects = check_effects(context, scope, rule.post)
    cost: ir.Term = ir.Number(1)
    if rule.cost is not None:
        cost = check_scalar(context, scope, rule.cost, NUMBER, "the cost of a rule").term
        if isinstance(cost, ir.Number) and cost.value < 0:
            context.findings.report("E0205", rule.cost.span, "the cost of a rule cannot be negative")
    condition = ir.And(tuple(c for c in conditions if c != TRUE))
    lowered = ir.Rule(rule.name, variables, condition, effects, cost, context.findings.word(rule.span, rule.name))
    check_chain_bounds(context, lowered)
    _check_values(context, lowered)
    return lowered


def _check_values(context: Context, rule: ir.Rule) -> None:
    """Report a rule that gives a functional predicate a value beside one that it needs, or gives it two."""
    own = [e for e in rule.effects if isinstance(e, ir.Effect) and not e.negated and not e.literal.motion]
    deleted = {e.literal.predicate for e in ir.effects_of(rule.effects) if e.negated and not e.literal.motion}
    needed = [x for x in needed_literals(rule.condition)[0] if x.predicate not in deleted]
    for number, effect in enumerate(own):
        literal = effect.literal
        declared = context.library.predicates[literal.predicate]
        names = [v.name for v in context.logic[literal.predicate].variables]
        if declared.functional_in not in names:
            continue
        key = names.index(declared.functional_in)
        for other in (*needed, *(e.literal for e in own[:number])):
            if other.predicate == literal.predicate and other.args[key] == literal.args[key] and other != literal:
                context.findings.report(
                    "E0306",
                    literal.span,
                    f"`{rule.name}` would leave two values of `{literal.predicate}`, so it can do nothing new",
                    help=f"delete the other one: `not {context.findings.text(other.span)}`" if other.span else None,
                    labels=[(other.span, "the other value")] if other.span else [],
                )
                break


def check_placements(context: Context) -> tuple[PlacementChoice, ...]:
    """All placements; they list literals without conditions."""
    choices = tuple(_check_placement(context, p) for p in context.library.placements)
    _tell_twice(context, choices)
    return choices


def _tell_twice(context: Context, choices: Iterable[PlacementChoice]) -> None:
    """Two placements of one file for the same types: only one of them could count."""
    first: dict[tuple[str, ...], PlacementChoice] = {}
    for choice in choices:
        known = first.setdefault((choice.span.file, *choice.types), choice)
        if known is not choice:
            subject, support = choice.types
            context.findings.report(
                "E0110", choice.span, f"the placement of `{subject}` on `{support}` is declared twice",
                help="put the literals of both into one", labels=[(known.span, "first declared here")],
            )  # fmt: skip


def _check_placement(context: Context, placement: syntax.PlacementDecl) -> PlacementChoice:
    scope, variables = bind(context, Scope("rule"), (placement.subject, placement.support))
    for item in placement.post:
        if not isinstance(item, syntax.Effect) or item.negated:
            context.findings.report("E0311", item.span, "a placement only lists literals that hold at the start")
    plain = [i for i in placement.post if isinstance(i, syntax.Effect) and not i.negated]
    literals = tuple(e.literal for e in check_effects(context, scope, plain) if isinstance(e, ir.Effect))
    if len(variables) < 2:
        variables = (variables[0], variables[0])
    return PlacementChoice(variables[0], variables[1], literals, placement.span)


def predicates_in(part: object) -> set[str]:
    """The logic predicates that a part of the IR reads, those of its chains included."""
    return {p.predicate for p in parts(part) if isinstance(p, ir.Literal | ir.ChainType)}
