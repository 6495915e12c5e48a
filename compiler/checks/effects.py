"""Effects of rules: what may be added and deleted, conditional effects and loops over effects."""

from __future__ import annotations

from collections.abc import Sequence

from ...langs import syntax
from .. import ir
from .binders import bind
from .context import Context
from .formulas import check_formula, check_literal
from .names import Scope


def check_effects(context: Context, scope: Scope, items: Sequence[syntax.EffectItem]) -> tuple[ir.EffectItem, ...]:
    """The lowered effects; reports literals that no rule may change and literals both added and deleted."""
    lowered: list[ir.EffectItem] = []
    for item in items:
        if isinstance(item, syntax.Effect):
            effect = _check_effect(context, scope, item)
            if effect is not None:
                lowered.append(effect)
        elif isinstance(item, syntax.EffectIf):
            condition = check_formula(context, scope, item.condition)
            lowered.append(ir.EffectIf(condition, check_effects(context, scope, item.effects)))
        else:
            inner, variables = bind(context, scope, item.binders)
            lowered.append(ir.EffectFor(variables, check_effects(context, inner, item.effects)))
    _check_contradictions(context, [e for e in lowered if isinstance(e, ir.Effect)])
    return tuple(lowered)


def _check_effect(context: Context, scope: Scope, item: syntax.Effect) -> ir.Effect | None:
    literal = check_literal(context, scope.with_wildcard() if item.negated else scope, item.literal)
    if literal is None:
        return None
    signature = (context.motion if literal.motion else context.logic)[literal.predicate]
    if signature.static or signature.derived:
        kind = "static" if signature.static else "derived"
        context.findings.report(
            "E0305",
            context.findings.word(item.literal.span, literal.predicate),
            f"`{literal.predicate}` is {kind}: a rule cannot change it",
            labels=[(signature.span, "declared here")],
        )
        return None
    return ir.Effect(literal, item.negated)


def _check_contradictions(context: Context, effects: Sequence[ir.Effect]) -> None:
    added = {e.literal: e.literal for e in effects if not e.negated}
    for effect in effects:
        other = added.get(effect.literal)
        if effect.negated and other is not None:
            context.findings.report(
                "E0302",
                effect.literal.span,
                f"`{effect.literal.predicate}` with the same arguments is both added and deleted",
                labels=[(other.span, "added here")],
                note="an action first deletes, then adds: the literal would hold",
            )
