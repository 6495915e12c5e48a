"""Goals that can never be reached: literals of the goal that nothing can make true even if nothing is ever deleted.

The relaxation is generous, so a goal that it refuses is impossible; one that it accepts may still be.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from .. import ir
from ..checks.findings import Findings
from ..checks.relaxation import Relaxation, needed_literals

Binding = Mapping[str, str]
NO_RULES = "the program declares and imports no rules"


class Hindrance(NamedTuple):
    """Why something can never hold, the fact that would help, and whether that lies behind another rule."""

    told: str
    fact: str | None = None
    behind: bool = False


def check_goal(findings: Findings, relaxation: Relaxation, goal: ir.Formula) -> None:
    """Report each literal of the goal that has no achiever, and why; and two values of one functional predicate."""
    _check_values(findings, relaxation, goal)
    for literal, binding in _unreached(relaxation, goal, {}):
        shown = _shown(literal, binding)
        reasons = list(dict.fromkeys(_reasons(relaxation, literal, binding)))
        reasons = [r for r in reasons if r.fact is not None and not r.behind] or reasons
        findings.report(
            "E0503",
            literal.span,
            f"the goal `{shown}` can never be reached",
            help=_repair(reasons),
            note="; ".join(reason.told for reason in reasons) or None,
        )


def _check_values(findings: Findings, relaxation: Relaxation, goal: ir.Formula) -> None:
    """Report a second value that the goal wants for a functional predicate."""
    wanted: dict[tuple[str, str], ir.Literal] = {}
    for literal in needed_literals(goal)[0]:
        predicate = relaxation.world.predicates.get(literal.predicate)
        key_at = None if predicate is None else predicate.functional_in
        if predicate is None or key_at is None or not all(isinstance(a, ir.Object) for a in literal.args):
            continue
        key = _name(literal.args[key_at], {}) or ""
        first = wanted.setdefault((literal.predicate, key), literal)
        if first.args != literal.args:
            one, other = _shown(first, {}), _shown(literal, {})
            labels = [(predicate.span, "declared functional here")] if predicate.span else []
            findings.report("E0306", literal.span, f"the goal wants two values: {one} and {other}", labels=labels)


def _repair(reasons: list[Hindrance]) -> str | None:
    if any(reason.told == NO_RULES for reason in reasons):
        return "the standard library declares some: `import std.rules`"
    facts = [r.fact for r in reasons if r.fact is not None and (not r.behind or len(reasons) == 1)]
    return f"add `fact {facts[0]}`, if it is so" if facts else None


def _unreached(relaxation: Relaxation, formula: ir.Formula, binding: Binding) -> Iterator[tuple[ir.Literal, Binding]]:
    """The literals that make `formula` impossible; none when it is possible."""
    if isinstance(formula, ir.Literal):
        if not possible(relaxation, formula, binding):
            yield formula, binding
    elif isinstance(formula, ir.And):
        for operand in formula.operands:
            yield from _unreached(relaxation, operand, binding)
    elif isinstance(formula, ir.Or):
        failures = [list(_unreached(relaxation, f, binding)) for f in formula.operands]
        if failures and all(failures):
            yield failures[0][0]
    elif isinstance(formula, ir.Exists):
        yield from list(_unreached(relaxation, formula.body, binding))[:1]
    elif isinstance(formula, ir.Forall):
        yield from _unreached_for_all(relaxation, formula, binding)


def _unreached_for_all(
    relaxation: Relaxation, formula: ir.Forall, binding: Binding
) -> Iterator[tuple[ir.Literal, Binding]]:
    if not all(isinstance(v.type, ir.ObjectType) for v in formula.variables):
        return
    bindings: list[Binding] = [binding]
    for variable in formula.variables:
        objects = sorted(relaxation.of(variable))
        bindings = [{**b, variable.name: o} for b in bindings for o in objects]
    for inner in bindings:
        yield from list(_unreached(relaxation, formula.body, inner))[:1]


def possible(relaxation: Relaxation, literal: ir.Literal, binding: Binding) -> bool:
    """Whether a literal can ever hold. Variables that are not bound stand for anything."""
    wanted = [_name(a, binding) for a in literal.args]
    world = relaxation.world
    derived = world.derived.get(literal.predicate)
    if derived is not None:
        inner = {v.name: w for v, w in zip(derived.variables, wanted, strict=True) if w is not None}
        return not list(_unreached(relaxation, derived.body, inner))
    columns = relaxation.columns.get(literal.predicate)
    if columns is None or any(w is not None and w not in c for w, c in zip(wanted, columns, strict=True)):
        return False
    if _stated(relaxation, literal.predicate, wanted):
        return True
    if _held(relaxation, literal.predicate, wanted) is not None:
        return False
    return any(_achieves(relaxation, rule, literal.predicate, wanted) for rule in world.rules.values())


def _stated(relaxation: Relaxation, predicate: str, wanted: list[str | None]) -> bool:
    """Whether a fact at the start matches."""
    names = [w for w in wanted if w is not None]
    if len(names) == len(wanted):
        return (predicate, *names) in relaxation.world.init
    return any(f[0] == predicate and _matches(f[1:], wanted) for f in relaxation.world.init)


def _held(relaxation: Relaxation, predicate: str, wanted: list[str | None]) -> ir.Fact | None:
    """The fact at the start that keeps a functional predicate from ever having another value: no rule deletes it."""
    world = relaxation.world
    key_at = world.predicates[predicate].functional_in
    if key_at is None or None in wanted:
        return None
    for fact in sorted(world.init):
        if fact[0] == predicate and fact[1 + key_at] == wanted[key_at] and [*fact[1:]] != wanted:
            names: list[str | None] = [*fact[1:]]
            if not any(_achieves(relaxation, rule, predicate, names, deletes=True) for rule in world.rules.values()):
                return fact
    return None


def _name(term: ir.Term, binding: Binding) -> str | None:
    if isinstance(term, ir.Object):
        return term.name
    return binding.get(term.name) if isinstance(term, ir.Var) else None


def _matches(names: tuple[str, ...], wanted: list[str | None]) -> bool:
    return all(w is None or w == n for n, w in zip(names, wanted, strict=True))


def _achieves(
    relaxation: Relaxation, rule: ir.Rule, predicate: str, wanted: list[str | None], deletes: bool = False
) -> bool:
    """Whether a rule may add, or delete, a literal."""
    if rule.name not in relaxation.domains:
        return False
    symmetric = relaxation.world.predicates[predicate].symmetric
    orders = [wanted, wanted[::-1]] if symmetric else [wanted]
    for effect, loops in ir.effects_with_loops(rule.effects):
        literal = effect.literal
        if effect.negated is not deletes or literal.motion or literal.predicate != predicate:
            continue
        columns = relaxation.places(rule, literal, loops)
        for order in orders:
            if all(w is None or w in c for w, c in zip(order, columns, strict=True)):
                return True
    return False


def _reasons(
    relaxation: Relaxation, literal: ir.Literal, binding: Binding, asked: frozenset[str] = frozenset()
) -> Iterator[Hindrance]:  # fmt: skip
    """Sentences that say why nothing achieves a literal, each with the static fact that would help; of predicates that
    were `asked` about no more is said."""
    world, asked = relaxation.world, asked | {literal.predicate}
    wanted = [_name(a, binding) for a in literal.args]
    derived = world.derived.get(literal.predicate)
    if derived is not None:
        inner = {v.name: w for v, w in zip(derived.variables, wanted, strict=True) if w is not None}
        for part, bound in _unreached(relaxation, derived.body, inner):
            yield from _reasons(relaxation, part, bound, asked)
        return
    predicate = world.predicates[literal.predicate]
    if predicate.static:
        shown = _shown(literal, binding)
        yield Hindrance(f"`{shown}` is no fact, and no rule can make it one", shown)
        return
    adders = [r for r in world.rules.values() if _adds(r, literal.predicate)]
    if not relaxation.world.rules:
        yield Hindrance(NO_RULES)
    elif not adders:
        yield Hindrance(f"no rule adds `{literal.predicate}`")
    hindered = False
    for rule in adders:  # one by one: who wants the first only would else ask about all orders of the predicates
        for hindrance in _obstacle(relaxation, rule, literal.predicate, wanted, asked):
            hindered = True
            yield hindrance
    held = None if hindered else _held(relaxation, literal.predicate, wanted)
    if held is not None:
        name = predicate.variables[predicate.functional_in or 0].name
        shown = f"`({' '.join(held)})` holds at the start and no rule deletes it"
        yield Hindrance(f"{shown}: `{literal.predicate}` is functional in {name}")


def _adds(rule: ir.Rule, predicate: str) -> bool:
    return any(
        not e.negated and not e.literal.motion and e.literal.predicate == predicate
        for e in ir.effects_of(rule.effects)
    )


def _obstacle(
    relaxation: Relaxation, rule: ir.Rule, predicate: str, wanted: list[str | None], asked: frozenset[str]
) -> Iterator[Hindrance]:
    """The first thing that keeps a rule from adding the literal."""
    for effect in ir.effects_of(rule.effects):
        if effect.negated or effect.literal.motion or effect.literal.predicate != predicate:
            continue
        binding: dict[str, str] = {}
        for arg, want in zip(effect.literal.args, wanted, strict=True):
            if isinstance(arg, ir.Var) and want is not None:
                binding[arg.name] = want
        types = {v.name: v.type.name for v in rule.variables if isinstance(v.type, ir.ObjectType)}
        for name, value in binding.items():
            kind = types.get(name)
            if kind is not None and value not in relaxation.world.of_type(kind):
                yield Hindrance(f"`{rule.name}` takes only things of type `{kind}` for {name}")
                return
        for condition in needed_literals(rule.condition)[0]:
            if not possible(relaxation, condition, binding):
                yield _unmet(relaxation, rule, condition, binding, asked)
                return


def _unmet(
    relaxation: Relaxation, rule: ir.Rule, condition: ir.Literal, binding: Binding, asked: frozenset[str]
) -> Hindrance:  # fmt: skip
    """What a rule needs in vain, and why that never holds, as far as to what nobody gives."""
    shown = _shown(condition, binding)
    predicate = relaxation.world.predicates.get(condition.predicate)
    if predicate is not None and predicate.static:
        ground = all(_name(a, binding) is not None for a in condition.args)
        return Hindrance(f"`{rule.name}` needs `{shown}`, which is no fact", shown if ground else None)
    told = f"`{rule.name}` needs `{shown}`, which can never hold"
    if condition.predicate in asked:
        return Hindrance(told)
    why = next(_reasons(relaxation, condition, binding, asked), None)
    return Hindrance(told) if why is None else Hindrance(f"{told}: {why.told}", why.fact, behind=True)


def _shown(literal: ir.Literal, binding: Binding) -> str:
    words = [literal.predicate]
    for arg in literal.args:
        name = _name(arg, binding)
        words.append(name if name is not None else arg.name if isinstance(arg, ir.Var) else "…")
    return f"({' '.join(words)})"
