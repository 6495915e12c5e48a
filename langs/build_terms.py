"""Parse tree to syntax tree, first half: terms, conditions, variables."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from typing import TypeAlias

from lark import Token, Tree

from . import syntax as s
from .diagnostics import Diagnostic
from .source import MAX_DEPTH, Span

Branch: TypeAlias = Tree[Token]
Child: TypeAlias = Branch | Token | None

_NUMBER = re.compile(
    r"([0-9.]+(?:[eE][+-]?[0-9]+)?)[ \t]*(k?N m|k?N|kg/m(?:\^3|³)|kg m(?:\^2|²)|[a-z]*)(/s(?:\^[23])?)?", re.ASCII
)
_UNITS = {
    "": (1.0, ""),
    "m": (1.0, "length"),
    "cm": (0.01, "length"),
    "mm": (0.001, "length"),
    "rad": (1.0, "angle"),
    "deg": (math.pi / 180, "angle"),
    "s": (1.0, "time"),
    "min": (60.0, "time"),
    "kg": (1.0, "mass"),
    "g": (0.001, "mass"),
    "N": (1.0, "force"),
    "kN": (1000.0, "force"),
    "N m": (1.0, "torque"),
    "kN m": (1000.0, "torque"),
    "kg/m^3": (1.0, "density"),
    "kg/m³": (1.0, "density"),
    "kg m^2": (1.0, "inertia"),
    "kg m²": (1.0, "inertia"),
}
_RATES = {
    ("length", "/s"): "speed",
    ("angle", "/s"): "angular speed",
    ("length", "/s^2"): "acceleration",
    ("angle", "/s^2"): "angular acceleration",
    ("length", "/s^3"): "jerk",
    ("angle", "/s^3"): "angular jerk",
}

WRENCH = 6
"""Components of a bound on a wrench: three forces, three moments."""


class NestingError(Exception):
    """A term or condition is nested deeper than MAX_DEPTH."""

    def __init__(self, span: Span) -> None:
        self.span = span
        super().__init__(str(span))


_SEPARATED = "arguments of a literal are separated by blanks: `(on X A)`"


def span_of(file: str, node: Branch | Token) -> Span:
    place = node if isinstance(node, Token) else node.meta
    return Span(
        file,
        place.start_pos or 0,
        place.end_pos or 0,
        place.line or 0,
        place.column or 0,
        place.end_line or 0,
        place.end_column or 0,
    )


def branches(tree: Branch, *kinds: str) -> list[Branch]:
    """The children that are trees, of those kinds where any are named."""
    return [c for c in tree.children if isinstance(c, Tree) and (not kinds or c.data in kinds)]


def tokens(tree: Branch) -> list[Token]:
    return [c for c in tree.children if isinstance(c, Token)]


class TermBuilder:
    """Builds terms and conditions of one file; `problems` collects what the grammar alone could not refuse."""

    def __init__(self, file: str, lines: list[str]) -> None:
        self.file = file
        self._lines = lines
        self.problems: list[Diagnostic] = []
        self._depth = 0

    def span(self, node: Branch | Token) -> Span:
        return span_of(self.file, node)

    # --- terms ---------------------------------------------------------------------------------------------------

    def term(self, node: Child) -> s.Term:
        assert isinstance(node, Tree)
        self._enter(node)
        try:
            return self._term(node)
        finally:
            self._depth -= 1

    def maybe_term(self, node: Child) -> s.Term | None:
        return None if node is None else self.term(node)

    def terms(self, nodes: Iterable[Child]) -> tuple[s.Term, ...]:
        return tuple(self.term(n) for n in nodes if n is not None)

    def _term(self, tree: Branch) -> s.Term:
        span, children = self.span(tree), tree.children
        match str(tree.data):
            case "number":
                return self._number(tree)
            case "text":
                return self.text(tokens(tree)[0])
            case "name":
                return s.Name(str(children[0]), span=span)
            case "wildcard":
                return s.Wildcard(span=span)
            case "index":
                return s.Index(self.term(children[0]), self.term(children[1]), span=span)
            case "attribute":
                return s.Attribute(self.term(children[0]), str(children[1]), span=span)
            case "call":
                return self.call(tree)
            case "placed":
                return s.Call("at", self.terms(children), span=span)
            case "group":
                return self.term(children[0])
            case "vector":
                return self._vector(tree)
            case "negate":
                return s.Negate(self.term(children[1]), span=span)
            case "binary":
                return s.Binary(str(children[1]), self.term(children[0]), self.term(children[2]), span=span)
            case "conditional":
                condition, then, otherwise = children
                return s.Conditional(self.formula(condition), self.term(then), self.term(otherwise), span=span)
            case "aggregate":
                operator, binders, body = children
                return s.Aggregate(str(operator), self.binders(binders), self.term(body), span=span)
        self.problem("E0016", "a value is needed here, not a condition", span, help=self._value_help(tree))
        return s.Wildcard(span=span)

    def _value_help(self, tree: Branch) -> str | None:
        """`radius = 4 cm`, as other languages name what they hand over."""
        if tree.data != "compare" or str(tree.children[1]) != "=" or not _is_word(tree.children[0]):
            return None
        value = self.span(branches(tree)[1])
        written = self._lines[value.line - 1][value.column - 1 : value.end_column - 1]
        return f"write `{written}`: its place says what it is"

    def _number(self, tree: Branch) -> s.Number:
        text = str(tree.children[0])
        match = _NUMBER.fullmatch(text)
        assert match is not None
        factor, kind = _UNITS[match[2]]
        value = float(match[1]) * factor
        if not math.isfinite(value):
            self.problem("E0009", f"the number `{text}` is too large", self.span(tree))
            value = 0.0
        return s.Number(value, _RATES.get((kind, match[3]), kind), text, span=self.span(tree))

    def text(self, token: Token) -> s.Text:
        return s.Text(str(token)[1:-1], span=self.span(token))

    def call(self, tree: Branch) -> s.Call:
        return s.Call(str(tree.children[0]), self.terms(tree.children[1:]), span=self.span(tree))

    def _vector(self, tree: Branch) -> s.Vector:
        if len(tree.children) not in (2, 3, WRENCH):
            self.problem(
                "E0001",
                "a vector has two or three components",
                self.span(tree),
                help=_SEPARATED if _is_word(tree.children[0]) else None,
            )
        return s.Vector(self.terms(tree.children), span=self.span(tree))

    # --- conditions ----------------------------------------------------------------------------------------------

    def formula(self, node: Child) -> s.Formula:
        assert isinstance(node, Tree)
        self._enter(node)
        try:
            return self._formula(node)
        finally:
            self._depth -= 1

    def formulas(self, nodes: Iterable[Child]) -> tuple[s.Formula, ...]:
        return tuple(self.formula(n) for n in nodes if n is not None)

    def _formula(self, tree: Branch) -> s.Formula:
        span, children = self.span(tree), tree.children
        match str(tree.data):
            case "disjunction":
                return s.Or(self.formulas(children), span=span)
            case "conjunction":
                return s.And(self.formulas(children), span=span)
            case "not_":
                return s.Not(self.formula(children[0]), span=span)
            case "compare":
                return s.Compare(str(children[1]), self.term(children[0]), self.term(children[2]), span=span)
            case "exists":
                return s.Exists(self.binders(children[0]), self.formula(children[1]), span=span)
            case "forall":
                return s.Forall(self.binders(children[0]), self.formula(children[1]), span=span)
            case "previous":
                return self._previous(tree)
            case "logic_literal" | "motion_literal":
                return self.literal(tree)
            case "group":
                return self._group(tree)
        self.problem("E0016", "a condition is needed here, not a value", span, help=_condition_help(tree))
        return s.And((), span=span)

    def _group(self, tree: Branch) -> s.Formula:
        """`(p)` is a literal without arguments where a condition is needed, and a name where a value is."""
        inner = branches(tree)[0]
        if inner.data == "name":
            return s.Literal(str(inner.children[0]), (), False, span=self.span(tree))
        return self.formula(inner)

    def _previous(self, tree: Branch) -> s.Previous:
        written = self._text_has_parenthesis(tree)
        args = self.terms(tree.children[1:]) if written else None
        return s.Previous(str(tree.children[0]), args, span=self.span(tree))

    def _text_has_parenthesis(self, tree: Branch) -> bool:
        name = tokens(tree)[0]
        return (tree.meta.end_pos or 0) > (name.end_pos or 0)

    def literal(self, tree: Branch) -> s.Literal:
        motion = tree.data == "motion_literal"
        return s.Literal(str(tree.children[0]), self.terms(tree.children[1:]), motion, span=self.span(tree))

    # --- variables -----------------------------------------------------------------------------------------------

    def binders(self, node: Child) -> tuple[s.Parameter, ...]:
        assert isinstance(node, Tree)
        return tuple(p for child in branches(node) for p in self._grouped(child))

    def parameters(self, node: Child) -> tuple[s.Parameter, ...]:
        """The parameters of a `parameters` tree; none where the declaration has no parentheses."""
        return () if node is None else self.binders(node)

    def signature(self, tree: Branch) -> tuple[s.Parameter, ...]:
        return tuple(p for child in branches(tree, "parameter") for p in self._grouped(child))

    def _grouped(self, tree: Branch) -> list[s.Parameter]:
        """`A B: port = x` gives a parameter for each name."""
        names, (kind, *rest) = tokens(tree), branches(tree)
        limits = self.type(rest.pop(0)) if rest and rest[0].data == "range_type" else None
        default = self.term(rest[0]) if rest else None
        allowed = limits if isinstance(limits, s.RangeType) else None
        return [s.Parameter(str(n), self.type(kind), default, allowed, span=self.span(n)) for n in names]

    def type(self, tree: Branch) -> s.Type:
        span, children = self.span(tree), tree.children
        if tree.data == "chain_type":
            return s.ChainType(str(children[0]), str(children[1]), span=span)
        if tree.data == "range_type":
            return s.RangeType(self.term(children[0]), self.term(children[1]), span=span)
        return s.NamedType(str(children[0]), span=span)

    # --- helpers -------------------------------------------------------------------------------------------------

    def problem(self, code: str, message: str, span: Span, help: str | None = None) -> None:
        self.problems.append(Diagnostic(code, message, span, help=help))

    def _enter(self, tree: Branch) -> None:
        if self._depth >= MAX_DEPTH:
            raise NestingError(self.span(tree))
        self._depth += 1


def _condition_help(tree: Branch) -> str | None:
    if tree.data == "name":
        return f"a literal stands in parentheses: `({tree.children[0]} …)`"
    if tree.data in ("call", "vector"):
        words = [str(c if isinstance(c, Token) else c.children[0]) for c in tree.children if _is_word(c)]
        shown = " ".join(words) if len(words) == len(tree.children) else f"{words[0] if words else 'p'} X Y"
        return f"a literal is written `({shown})`, its arguments separated by blanks"
    return None


def _is_word(child: Child) -> bool:
    return isinstance(child, Token) or (isinstance(child, Tree) and child.data == "name")
