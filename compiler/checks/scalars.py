"""Terms that must be scalars: numbers, lengths, angles and the like."""

from __future__ import annotations

from collections.abc import Sequence

from ...langs import syntax
from .context import Context
from .kinds import EXAMPLES, LENGTH, NUMBER, PHYSICAL, Kind
from .names import Scope, Typed


def check_scalar(
    context: Context, scope: Scope, term: syntax.Term, kind: Kind, what: str, lenient: bool = False
) -> Typed:
    """A term that must be of scalar `kind`; `what` names its place in messages. With `lenient`, a plain number passes
    for a length."""
    typed = context.check_term(context, scope, term)
    expect_kind(context, typed, kind, term, what, lenient)
    return typed


def expect_kind(
    context: Context, typed: Typed, kind: Kind, term: syntax.Term, what: str, lenient: bool = False
) -> bool:
    """Whether `typed` passes for `kind`; reports otherwise."""
    if not typed.kind.known or not kind.known or typed.kind == kind or typed.is_zero:
        return True
    if typed.kind == NUMBER and kind == LENGTH and (lenient or typed.literal):
        if typed.literal:
            hint = f"give it a unit, such as `{context.findings.text(term.span)} m`"
            context.findings.report("W0014", term.span, f"{what} has no unit and counts in metres", help=hint)
        return True
    code = "E0203" if typed.kind.is_scalar and kind.is_scalar else "E0208"
    help = None
    if typed.kind == NUMBER and kind.name in EXAMPLES:
        help = f"give it a unit, such as `{_with_unit(context, term, typed, kind)}`"
    elif kind == NUMBER and typed.kind == LENGTH:
        help = "divide it by a length such as `1 m`"
    elif kind.name in PHYSICAL:
        help = f"write it in {EXAMPLES[kind.name]}"
    context.findings.report(code, term.span, f"{what} must be {kind}, not {typed.kind}", help=help)
    return False


def warn_bare(context: Context, sides: Sequence[tuple[syntax.Term, Typed]]) -> None:
    """Warn of a number beside a length that it is added to or compared with, as of one that stands for a length."""
    for (term, typed), (_, other) in (sides, sides[::-1]):
        if typed.kind == NUMBER and typed.value and typed.literal and other.kind == LENGTH:
            expect_kind(context, typed, LENGTH, term, "this number")


def _with_unit(context: Context, term: syntax.Term, typed: Typed, kind: Kind) -> str:
    text = context.findings.text(term.span) if typed.literal else "2"
    unit = "deg" if kind.name == "angle" and abs(typed.value or 0) > 6.3 else EXAMPLES[kind.name]
    return f"{text} {unit}"
