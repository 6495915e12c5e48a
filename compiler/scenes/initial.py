"""The state at the start: facts, and what the placements give for everything that stands on something."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from ...langs.source import Span
from .. import ir
from ..checks.check_logic import PlacementChoice
from ..checks.context import Context
from .scene import BuiltScene, Standing


class InitialState:
    """Collects ground literals, symmetric ones in both orders; reports a second value of a functional predicate."""

    def __init__(
        self, context: Context, predicates: dict[str, ir.Predicate], motions: dict[str, ir.MotionPredicate]
    ) -> None:
        self.context = context
        self.predicates = predicates
        self.motions = motions
        self.logic: dict[ir.Fact, None] = {}
        self.motion: dict[ir.Fact, None] = {}
        self.values: dict[tuple[str, str], tuple[ir.Fact, Span | None]] = {}

    def add(self, literal: ir.Literal, span: Span | None) -> None:
        names = [a.name for a in literal.args if isinstance(a, ir.Object)]
        fact = (literal.predicate, *names)
        if literal.motion:
            self.motion[fact] = None
            return
        predicate = self.predicates.get(literal.predicate)
        if predicate is None:
            where = span if span is not None else literal.span
            self.context.findings.report("E0305", where, f"`{literal.predicate}` is derived: it cannot be a fact")
            return
        if predicate.functional_in is not None:
            self.check_functional(predicate, predicate.functional_in, fact, span)
        self.logic[fact] = None
        if predicate.symmetric:
            self.logic[(literal.predicate, *reversed(names))] = None

    def check_functional(self, predicate: ir.Predicate, key: int, fact: ir.Fact, span: Span | None) -> None:
        subject = fact[1 + key]
        first, where = self.values.setdefault((predicate.name, subject), (fact, span))
        if first != fact:
            one, other = (f"({' '.join(f)})" for f in (first, fact))
            labels = [(where, f"{one} comes from here"), (predicate.span, "declared functional here")]
            self.context.findings.report("E0306", span, f"`{subject}` has two values: {one} and {other}", labels=labels)


def initial_state(
    context: Context,
    built: BuiltScene,
    placements: Sequence[PlacementChoice],
    predicates: dict[str, ir.Predicate],
    motions: dict[str, ir.MotionPredicate],
) -> tuple[frozenset[ir.Fact], frozenset[ir.Fact]]:
    """The logic and the motion literals that hold at the start."""
    state = InitialState(context, predicates, motions)
    for literal in built.facts:
        state.add(literal, literal.span)
    for standing in built.standing:
        for literal in _placed(context, placements, standing):
            state.add(literal, standing.span)
    return frozenset(state.logic), frozenset(state.motion)


def carrying(
    context: Context, placements: Sequence[PlacementChoice], standing: Iterable[Standing]
) -> frozenset[ir.Fact]:
    """The motion literals that placements give for what stands on something, where there are such."""
    state = InitialState(context, {}, {})
    for one in standing:
        chosen = _chosen(context, placements, one)
        for literal in _literals(chosen, one) if chosen is not None else ():
            if literal.motion:
                state.add(literal, one.span)
    return frozenset(state.motion)


def _placed(context: Context, placements: Iterable[PlacementChoice], standing: Standing) -> list[ir.Literal]:
    chosen = _chosen(context, placements, standing)
    if chosen is not None:
        return _literals(chosen, standing)
    context.findings.report(
        "E0501",
        standing.span,
        f"nothing says what holds when a `{standing.subject_type}` stands on a `{standing.support_type}`",
        help="declare or import a `placement` for them",
    )
    return []


def _chosen(context: Context, placements: Iterable[PlacementChoice], standing: Standing) -> PlacementChoice | None:
    """The placement that says most exactly what holds; of several for the same types that of the program itself, then
    of its own files, then of the standard library."""
    library = context.library
    fitting = [
        p
        for p in placements
        if library.is_a(standing.subject_type, p.types[0]) and library.is_a(standing.support_type, p.types[1])
    ]
    def rank(choice: PlacementChoice) -> tuple[int, int, bool, bool]:
        subject, support = choice.types
        path = choice.span.file
        return _depth(context, subject), _depth(context, support), path == library.path, not path.startswith("std/")

    return max(fitting, key=rank, default=None)


def _literals(chosen: PlacementChoice, standing: Standing) -> list[ir.Literal]:
    names = {chosen.subject.name: standing.subject, chosen.support.name: standing.support}
    return [
        ir.Literal(
            literal.predicate,
            tuple(ir.Object(names[a.name]) if isinstance(a, ir.Var) else a for a in literal.args),
            literal.motion,
            literal.span,
        )
        for literal in chosen.literals
    ]


def _depth(context: Context, name: str) -> int:
    depth, current = 0, context.library.types.get(name)
    while current is not None:
        depth, current = depth + 1, context.library.types.get(current)
    return depth
