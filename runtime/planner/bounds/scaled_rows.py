"""Rows of motion predicates in another unit of length. Only numbers that are lengths change: a row keeps its form, by
which contacts, bounds and guesses know it.

Terms have a degree in length: 1 for a distance, 0 for an axis, 2 for a square. Of a number, and of a number times an
axis, what stands beside it tells whether it is a length.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ....compiler import ir
from ....compiler.motion.constraints import METRES, units

PRODUCTS = ("*", "dot", "cross")
ALIKE = ("+", "-", "neg", "abs", "norm", "least")
PLAIN = ("axis", "mass", "load")


class Unclear(Exception):
    """A term of which the degree does not follow."""


def in_unit(row: ir.Row, metres: float) -> ir.Row | None:
    """The row where lengths are counted in so many metres; None where its sides are no plain lengths or numbers."""
    try:
        sides = [_degree(row.left), None if row.right is None else _degree(row.right)]
        degree = _common(sides) or 0
        if degree != (units(row)[0] == "m"):
            return None
        right = row.right and _turned(row.right, degree, metres)
        return replace(row, left=_turned(row.left, degree, metres), right=right)
    except Unclear:
        return None


def _parts(term: ir.Term) -> tuple[str, Sequence[ir.Term]]:
    """What a term is called, and what it is made of."""
    match term:
        case ir.Number():
            return "number", ()
        case ir.Vector(items=items):
            return "vector", items
        case ir.Arith(operator=name, operands=parts) | ir.Function(name=name, args=parts):
            return name, parts
    raise Unclear


def _common(degrees: Sequence[int | None]) -> int | None:
    """The degree that all of them have which have one."""
    known = {degree for degree in degrees if degree is not None}
    if len(known) > 1:
        raise Unclear
    return known.pop() if known else None


def _degree(term: ir.Term) -> int | None:
    """The degree of a term; None where it depends on what the numbers in it are. Raises Unclear."""
    name, parts = _parts(term)
    if name == "number":
        return None
    if name in METRES or name in PLAIN:
        return int(name in METRES)
    if name not in (*PRODUCTS, *ALIKE, "vector", "/", "sqrt", "sin", "cos"):
        raise Unclear
    degrees = [_degree(part) for part in parts]
    if name in ALIKE or name == "vector":
        return _common(degrees)
    if name in PRODUCTS:
        return sum(d or 0 for d in degrees) or (None if None in degrees else 0)
    if name == "/" and not degrees[1]:
        return degrees[0]
    if name == "sqrt" and not (degrees[0] or 0) % 2:
        return None if degrees[0] is None else degrees[0] // 2
    if name in ("sin", "cos") and not degrees[0]:
        return 0
    raise Unclear


def _turned(term: ir.Term, degree: int, metres: float) -> ir.Term:
    """A term, which is or may be of the degree, with its lengths in the unit."""
    name, parts = _parts(term)
    match term:
        case ir.Number(value=value):
            return replace(term, value=value / metres**degree)
        case ir.Vector():
            return replace(term, items=tuple(_turned(part, degree, metres) for part in parts))
    if name in METRES or name in (*PLAIN, "sin", "cos"):
        return term
    if name in PRODUCTS:
        wanted = _shares([_degree(part) for part in parts], degree)
    elif name == "/":
        wanted = [degree, 0]
    else:
        wanted = [degree * (2 if name == "sqrt" else 1)] * len(parts)
    turned = tuple(_turned(part, share, metres) for part, share in zip(parts, wanted, strict=True))
    match term:
        case ir.Arith():
            return replace(term, operands=turned)
        case ir.Function():
            return replace(term, args=turned)
    raise Unclear


def _shares(degrees: Sequence[int | None], degree: int) -> list[int]:
    """The degrees of the factors of a product: what lacks is that of the first whose own is open."""
    shares = [d or 0 for d in degrees]
    lacking = degree - sum(shares)
    if lacking:
        if None not in degrees:
            raise Unclear
        shares[list(degrees).index(None)] += lacking
    return shares
