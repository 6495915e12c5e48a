"""Warnings about rules that move what they still hold: a literal that keeps a pose does so until the switch of the
action that deletes it, so that such an action can bring its object nowhere else."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from .. import ir
from ..kept_pairs import places_kept
from .check_logic import PlacementChoice
from .check_usage import literal_pattern
from .context import Context


def check_held(
    context: Context, motions: Mapping[str, ir.MotionPredicate], rules: Mapping[str, ir.Rule],
    placements: Sequence[PlacementChoice],
) -> None:  # fmt: skip
    """Warn of rules that delete a literal which keeps an object to a body, and have it be at another body at once."""
    found = {name: places_kept(motion) for name, motion in motions.items() if not motion.symmetric}
    kept = {
        name: places for name, places in found.items()
        if places and not any(_may_move(context, kind) for kind in _types(context, rules, placements, name, places[0]))
    }  # fmt: skip
    for rule in rules.values():
        _check_rule(context, rule, kept)


def _check_rule(context: Context, rule: ir.Rule, kept: Mapping[str, tuple[int, int]]) -> None:
    effects = [e for e in ir.effects_of(rule.effects) if e.literal.motion and e.literal.predicate in kept]
    for old in (e.literal for e in effects if e.negated):
        base, own = kept[old.predicate]
        for new in (e.literal for e in effects if not e.negated):
            there, same = kept[new.predicate]
            if new.args[same] == old.args[own] and new.args[there] != old.args[base]:
                context.findings.report(
                    "W0025",
                    old.span,
                    f"`{rule.name}` can move nothing that `[{old.predicate} …]` still keeps in its place",
                    note="a literal holds until the switch of the action that deletes it",
                    help="delete it by a rule of its own that comes before, such as one that lets go",
                    labels=[(new.span, "this asks for another place at the same switch")],
                )
                return


def _types(
    context: Context, rules: Mapping[str, ir.Rule], placements: Sequence[PlacementChoice], name: str, place: int
) -> Iterator[str | None]:
    """The types that may stand at a place of the literals of a motion predicate which rules and placements add."""
    for rule in rules.values():
        for effect in ir.effects_of(rule.effects):
            if not effect.negated and effect.literal.motion and effect.literal.predicate == name:
                yield literal_pattern(context, effect.literal, rule.variables)[2][place]
    for choice in placements:
        for literal in choice.literals:
            if literal.motion and literal.predicate == name:
                yield literal_pattern(context, literal, (choice.subject, choice.support))[2][place]


def _may_move(context: Context, kind: str | None) -> bool:
    """Whether what stands there may be part of a robot."""
    return kind is None or any(context.library.overlap(kind, part) for part in ("effector", "module"))
