"""Motion predicates: rows with their shapes checked and counted, loops over numbers written out."""

from __future__ import annotations

from collections.abc import Sequence

from ...langs import syntax
from ...langs.diagnostics import did_you_mean
from ...langs.trees import parts
from .. import ir
from ..physics.records import MANNERS, NOTHING
from .binders import bind, unrolled
from .context import Context
from .kinds import FORCE, TORQUE, Kind, added, size_of
from .names import Scope, Typed
from .scalars import warn_bare
from .terms import check_term


def check_motions(context: Context) -> dict[str, ir.MotionPredicate]:
    """All motion predicates, lowered."""
    return {name: _check_motion(context, motion) for name, motion in context.library.motions.items()}


def _check_motion(context: Context, motion: syntax.MotionDecl) -> ir.MotionPredicate:
    unique = list({p.name: p for p in motion.parameters}.values())
    scope, variables = bind(context, Scope("motion", values_known=True), unique)
    rows = _check_rows(context, scope, motion.items)
    touching = [_check_touching(context, scope, i) for i in parts(motion) if isinstance(i, syntax.MotionTouching)]
    return ir.MotionPredicate(
        motion.name, variables, motion.symmetric, tuple(rows), context.findings.word(motion.span, motion.name),
        _borne(context, motion, variables), tuple(pair for pair in touching if pair),
    )


def _check_touching(context: Context, scope: Scope, item: syntax.MotionTouching) -> tuple[str, str] | None:
    """The names of two different objects of the predicate."""
    found = [check_term(context, scope, term) for term in (item.first, item.second)]
    if not all(one.kind.known for one in found):
        return None
    names = [one.term.name for one in found if one.kind.name == "object" and isinstance(one.term, ir.Var)]
    if len(set(names)) != 2:
        context.findings.report("E0406", item.span, "`touching` names two different objects of the predicate")
        return None
    return names[0], names[1]


def _borne(context: Context, motion: syntax.MotionDecl, variables: Sequence[ir.Variable]) -> str | None:
    """How the pair is borne of which the predicate speaks: its first two objects."""
    if motion.borne is None:
        return None
    where = context.findings.word(motion.span, motion.borne)
    known = (*MANNERS, NOTHING)
    if motion.borne not in known:
        help = did_you_mean(motion.borne, known) or f"pairs are borne as {', '.join(known)}"
        context.findings.report("E0522", where, f"no pair is borne as `{motion.borne}`", help=help)
        return None
    if len(variables) < 2:
        context.findings.report("E0522", where, f"[{motion.name}] speaks of no pair that could be borne")
        return None
    return motion.borne


def _check_rows(context: Context, scope: Scope, items: Sequence[syntax.MotionItem]) -> list[ir.Row]:
    rows: list[ir.Row] = []
    for item in items:
        if isinstance(item, syntax.MotionFor):
            rounds = unrolled(context, scope, item.binders)
            if rounds is None:
                context.findings.report(
                    "E0311", item.span, "loops of a motion predicate run over fixed ranges of numbers"
                )
            for inner in rounds or ():
                rows.extend(_check_rows(context, inner, item.rows))
        elif isinstance(item, syntax.MotionRow):
            row = _check_keep(context, scope, item) if item.when == "keep" else _check_row(context, scope, item)
            if row is not None:
                rows.append(row)
    return rows


def _check_keep(context: Context, scope: Scope, item: syntax.MotionRow) -> ir.Row | None:
    if item.right is not None:
        context.findings.report(
            "E0404", item.span, "`keep` holds one value constant and compares nothing", help="leave out the comparison"
        )
        return None
    value = check_term(context, scope, item.left)
    if not value.kind.known or not _check_measures(context, item.left, value):
        return None
    if not _depends(value.term):
        context.findings.report("E0405", item.left.span, "this value never changes")
        return None
    return ir.Row("keep", value.term, "", None, size_of(value.kind), item.span)


def _check_row(context: Context, scope: Scope, item: syntax.MotionRow) -> ir.Row | None:
    findings = context.findings
    if item.right is None:
        findings.report("E0402", item.span, "a row compares two sides by =, <= or >=", help="only `keep` has one side")
        return None
    left, right = check_term(context, scope, item.left), check_term(context, scope, item.right)
    if item.operator not in ("=", "<=", ">="):
        near = {"<": "<=", ">": ">="}.get(item.operator)
        findings.report(
            "E0402",
            item.span,
            f"rows of motion predicates compare by =, <= or >=, not by {item.operator}",
            help=f"use `{near}`" if near else "keep it away by `>=`, from one side or the other",
        )
        return None
    if not (left.kind.known and right.kind.known):
        return None
    if any("pose" in _pose_inside(t) for t in (left, right)):
        findings.report("E0404", item.span, "`pose` stands only after `keep`", help="write `keep pose(…)`")
        return None
    left, right = _six(left, right), _six(right, left)
    measured = [_check_measures(context, t, v) for t, v in ((item.left, left), (item.right, right))]
    if not all(measured) or not _check_sizes(context, item, left, right):
        return None
    if not all([_check_components(context, t, v) for t, v in ((item.left, left), (item.right, right))]):
        return None
    if not (_depends(left.term) or _depends(right.term)):
        findings.report("E0405", item.span, "this row depends on no parameter of the predicate")
        return None
    rows = max(size_of(left.kind), size_of(right.kind))
    return ir.Row(item.when, left.term, item.operator, right.term, rows, item.span)


def _six(typed: Typed, other: Typed) -> Typed:
    """Six numbers beside a wrench are one."""
    items = typed.term.items if isinstance(typed.term, ir.Vector) else ()
    if other.kind.name == "wrench" and len(items) == size_of(other.kind):
        return Typed(typed.term, other.kind, items=typed.items)
    return typed


def _check_components(context: Context, term: syntax.Term, typed: Typed) -> bool:
    """Whether the components of a vector are lengths or plain numbers, those of a wrench forces and torques."""
    spans = [item.span for item in term.items] if isinstance(term, syntax.Vector) else []
    wrench, fits = typed.kind.name == "wrench", True
    for number, (span, item) in enumerate(zip(spans, typed.items, strict=False)):
        wanted = ("force" if number < 3 else "torque",) if wrench else ("number", "length")
        if item.kind.name not in wanted and not item.is_zero:
            what = f"component {number + 1} of a wrench is {FORCE if number < 3 else TORQUE}"
            what = what if wrench else "the components of a vector are lengths, or plain numbers"
            context.findings.report("E0203", span, f"{what}, not {item.kind}")
            fits = False
    return fits


def _pose_inside(typed: Typed) -> str:
    return typed.kind.name


def _check_measures(context: Context, term: syntax.Term, typed: Typed) -> bool:
    if typed.kind.name in ("object", "chain", "letter"):
        context.findings.report("E0208", term.span, f"a number or vector is needed here, not {typed.kind}")
        return False
    if isinstance(typed.term, ir.Vector) and len(typed.term.items) != size_of(typed.kind):
        context.findings.report("E0401", term.span, f"a vector has 3 components, not {len(typed.term.items)}")
        return False
    return True


def _check_sizes(context: Context, item: syntax.MotionRow, left: Typed, right: Typed) -> bool:
    assert item.right is not None
    if left.is_zero or right.is_zero:
        return True
    one, other = left.kind, right.kind
    names = {one.name, other.name}
    if size_of(one) != size_of(other) and not ("rows" in names and (names & {"length", "number"})):
        context.findings.report(
            "E0401",
            item.span,
            f"{_sized(one)} cannot be compared with {_sized(other)}",
            help="compare with a plain 0, or with a vector `(x, y, z)`" if "vector" in names else None,
            labels=[(item.left.span, _sized(one)), (item.right.span, _sized(other))],
        )
        return False
    if added(one, other, left.literal, right.literal) is None:
        context.findings.report("E0203", item.span, f"{one} cannot be compared with {other}")
        return False
    warn_bare(context, ((item.left, left), (item.right, right)))
    return True


def _sized(kind: Kind) -> str:
    size = size_of(kind)
    return f"{kind} ({size} row{'s' * (size != 1)})"


def _depends(term: ir.Term) -> bool:
    return any(isinstance(part, ir.Var) for part in parts(term))
