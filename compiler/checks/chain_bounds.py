"""Indices of chains must end where the chain does: `c[k]` needs a k that something holds to length(c) (E0313)."""

from __future__ import annotations

from collections.abc import Iterator

from ...langs.trees import parts
from .. import ir
from .context import Context


def check_chain_bounds(context: Context, part: ir.Rule | ir.Derived | ir.Formula) -> None:
    """Report each range variable that counts the modules of a chain whose length the rule, derived predicate or goal
    never asks for."""
    nodes = list(parts(part))
    measured = {a.name for f in nodes if isinstance(f, ir.Function) and f.name == "length" for a in _vars(f)}
    ranges = {v.name for v in nodes if isinstance(v, ir.Variable) and _counts(v.type)}
    for node in nodes:
        if not isinstance(node, ir.ChainModule) or node.chain in measured:
            continue
        counters = [v.name for v in parts(node.index) if isinstance(v, ir.Var) and v.name in ranges]
        if counters:
            context.findings.report(
                "E0313",
                node.span,
                f"nothing bounds `{counters[0]}` by the length of the chain `{node.chain}`",
                help=f"let its range end with `length({node.chain})`",
            )


def _counts(kind: ir.Type) -> bool:
    """Whether a variable has numbers to take."""
    if not isinstance(kind, ir.RangeType):
        return False
    first, last = kind.first, kind.last
    return not (isinstance(first, ir.Number) and isinstance(last, ir.Number) and last.value < first.value)


def _vars(node: ir.Function) -> Iterator[ir.Var]:
    return (a for a in node.args if isinstance(a, ir.Var))
