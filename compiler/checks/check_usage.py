"""Warnings about the logic as a whole: deletions that nothing feeds, fluents never read, rules that never fire."""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping, Sequence

from ...langs import syntax
from ...langs.source import Span
from ...langs.trees import parts
from .. import ir
from ..library import Library
from .check_logic import PlacementChoice, predicates_in
from .context import Context
from .names import names_in
from .relaxation import needed_literals


def check_usage(
    context: Context,
    rules: Mapping[str, ir.Rule],
    derived: Mapping[str, ir.Derived],
    placements: Sequence[PlacementChoice],
) -> None:
    """All warnings of this file."""
    stated = list(_stated(context))
    added = [e.literal for r in rules.values() for e in ir.effects_of(r.effects) if not e.negated]
    added += [literal for p in placements for literal in p.literals]
    patterns = [
        literal_pattern(context, e.literal, r.variables)
        for r in rules.values()
        for e in ir.effects_of(r.effects)
        if not e.negated
    ]
    patterns += [literal_pattern(context, x, (p.subject, p.support)) for p in placements for x in p.literals]
    sources: dict[tuple[bool, str], set[Places]] = {}
    for motion, name, places in patterns:
        sources.setdefault((motion, name), set()).add(places)
    named = {(s.motion, s.predicate) for s in stated}
    given = {x.predicate for x in added if not x.motion} | {name for motion, name in named if not motion}
    for rule in rules.values():
        _check_deletions(context, rule, sources, named)
        _check_fires(context, rule, given)
    _check_read(context, rules, derived, added)
    _check_parameters(context)
    _check_empty(context)


def _check_empty(context: Context) -> None:
    """Files and rules that do nothing."""
    main = context.library.files[0]
    if not main.declarations:
        start = Span(main.path, 0, 0, 1, 1, 1, 1)
        context.findings.report("W0016", start, "this file declares nothing", help="`tamplang new NAME` writes a task")
    for rule in context.library.rules.values():
        if not rule.post:
            where = context.findings.word(rule.span, rule.name)
            context.findings.report("W0015", where, f"rule `{rule.name}` changes nothing", help="add `post (…)`")


Places = tuple[str | None, ...]
Pattern = tuple[bool, str, Places]


def _stated(context: Context) -> Iterator[syntax.Literal]:
    """The literals of all `fact` items in modules, scenes and tasks."""
    library = context.library
    for items in (*(m.items for m in library.modules.values()), *_scene_items(library)):
        yield from (part.literal for part in parts(items) if isinstance(part, syntax.FactItem))


def _scene_items(library: Library) -> Iterator[tuple[syntax.SceneItem, ...]]:
    yield from (s.items for s in library.scenes.values())
    yield from (t.items for t in library.tasks.values())


def _types(variables: Sequence[ir.Variable]) -> dict[str, str]:
    return {v.name: v.type.name for v in variables if isinstance(v.type, ir.ObjectType)}


def literal_pattern(context: Context, literal: ir.Literal, variables: Sequence[ir.Variable]) -> Pattern:
    """What a literal can be: whether it is one of motion, its predicate, and the type at each place."""
    types = _types(variables)
    signature = (context.motion if literal.motion else context.logic)[literal.predicate]
    places: list[str | None] = []
    for arg, variable in zip(literal.args, signature.variables, strict=True):
        declared = variable.type.name if isinstance(variable.type, ir.ObjectType) else None
        if isinstance(arg, ir.ChainEnd) or (isinstance(arg, ir.ChainModule) and arg.side):
            places.append("effector")
        elif isinstance(arg, ir.Var):
            places.append(types.get(arg.name) or declared)
        else:
            places.append(declared)
    return literal.motion, literal.predicate, tuple(places)


def _check_deletions(
    context: Context,
    rule: ir.Rule,
    sources: Mapping[tuple[bool, str], set[Places]],
    stated: Container[tuple[bool, str]],
) -> None:
    for effect in ir.effects_of(rule.effects):
        literal = effect.literal
        kind = literal.motion, literal.predicate
        if not effect.negated or kind in stated:
            continue
        pattern = literal_pattern(context, literal, rule.variables)
        if not any(_overlap(context, pattern, places) for places in sources.get(kind, ())):
            left, right = "[]" if literal.motion else "()"
            context.findings.report(
                "W0001",
                literal.span,
                f"`{rule.name}` deletes `{left}{literal.predicate} …{right}`, and nothing ever adds such a literal",
            )


def _overlap(context: Context, one: Pattern, other: Places) -> bool:
    """Whether a literal can be one of the same predicate whose places have the types `other`."""
    if _places_overlap(context, one[2], other):
        return True
    return _symmetric(context, one) and _places_overlap(context, one[2], other[::-1])


def _places_overlap(context: Context, one: Sequence[str | None], other: Sequence[str | None]) -> bool:
    return all(a is None or b is None or context.library.overlap(a, b) for a, b in zip(one, other, strict=True))


def _symmetric(context: Context, pattern: Pattern) -> bool:
    motion, name, _ = pattern
    if motion:
        return context.library.motions[name].symmetric
    return name in context.library.predicates and context.library.predicates[name].symmetric


def _check_fires(context: Context, rule: ir.Rule, given: Container[str]) -> None:
    own = rule.span is not None and rule.span.file == context.library.path
    positive = needed_literals(rule.condition)[0]
    negative = set(_negated(rule.condition))
    for literal in positive:
        if literal in negative:
            context.findings.report(
                "W0003", literal.span, f"`{rule.name}` can never fire: it needs this literal both true and false"
            )
            return
        signature = context.logic[literal.predicate]
        if signature.derived or literal.predicate in given:
            continue
        if not signature.static or (own and context.library.tasks):
            what = "fact" if signature.static else "rule, placement or fact"
            context.findings.report(
                "W0003",
                literal.span,
                f"`{rule.name}` can never fire: no {what} gives `{literal.predicate}`",
                labels=[(signature.span, "declared here")],
            )
            return


def _negated(formula: ir.Formula) -> Iterator[ir.Literal]:
    if isinstance(formula, ir.And):
        for operand in formula.operands:
            yield from _negated(operand)
    elif isinstance(formula, ir.Not) and isinstance(formula.operand, ir.Literal):
        yield formula.operand


def _check_read(
    context: Context, rules: Mapping[str, ir.Rule], derived: Mapping[str, ir.Derived], added: Sequence[ir.Literal]
) -> None:
    read: set[str] = set()
    for rule in rules.values():
        conditions = [e.condition for e in parts(rule.effects) if isinstance(e, ir.EffectIf)]
        read |= predicates_in((rule.variables, rule.condition, *conditions, rule.cost))
    for definition in derived.values():
        read |= predicates_in(definition.body)
    read |= _read_in_syntax(context.library)
    for literal in added:
        name = literal.predicate
        if not literal.motion and name not in read:
            signature = context.logic[name]
            context.findings.report(
                "W0002", signature.span, f"rules change `{name}`, but no condition, goal or derived predicate reads it"
            )


def _read_in_syntax(library: Library) -> set[str]:
    """Predicates in goals, functions and heuristics, found in the tree."""
    read: list[object] = [*library.functions.values(), *library.heuristics.values()]
    for items in _scene_items(library):
        read += [goal for goal in parts(items) if isinstance(goal, syntax.GoalItem)]
    return {p.predicate for p in parts(tuple(read)) if isinstance(p, syntax.Literal | syntax.ChainType)}


def _check_parameters(context: Context) -> None:
    """Parameters that the body of their declaration never names."""
    library = context.library
    declarations: list[tuple[str, Span, tuple[syntax.Parameter, ...], tuple[object, ...]]] = [
        *((d.name, d.span, d.parameters, (d.body,)) for d in library.derived.values()),
        *((d.name, d.span, d.parameters, (d.body,)) for d in library.functions.values()),
        *((d.name, d.span, d.parameters, (d.pre, d.where, d.post, d.cost)) for d in library.rules.values()),
        *((d.name, d.span, d.parameters, d.items) for d in library.motions.values()),
        *((d.name, d.span, d.parameters, (d.start, d.cases)) for d in library.heuristics.values()),
        *((d.name, d.span, d.parameters, d.items) for d in library.modules.values()),
        *((d.name, d.span, d.parameters, d.items) for d in library.scenes.values()),
        *((d.name, d.span, d.parameters, d.items) for d in library.tasks.values()),
    ]
    for owner, span, parameters, body in declarations:
        if context.findings.errors_within([span]):
            continue
        named = names_in(body) | names_in(tuple((p.type, p.default) for p in parameters))
        for parameter in parameters:
            if parameter.name not in named:
                where = context.findings.word(parameter.span, parameter.name)
                context.findings.report("W0005", where, f"`{owner}` never uses its parameter `{parameter.name}`")
