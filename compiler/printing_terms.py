"""Terms, formulas and effects of the IR in the notation of the language."""

from __future__ import annotations

from collections.abc import Iterable

from . import ir

PRECEDENCE = {"+": 1, "-": 1, "*": 2, "/": 2, "neg": 3}


def format_variable(variable: ir.Variable) -> str:
    """`X: base`, `c: chain of module by connected`, `k: 1 .. 3`."""
    return f"{variable.name}: {_type(variable.type)}"


def _type(kind: ir.Type) -> str:
    if isinstance(kind, ir.ChainType):
        return f"chain of {kind.element} by {kind.predicate}"
    if isinstance(kind, ir.RangeType):
        return f"{format_term(kind.first)} .. {format_term(kind.last)}"
    return kind.name


def _variables(variables: Iterable[ir.Variable]) -> str:
    return ", ".join(map(format_variable, variables))


def format_term(term: ir.Term, outer: int = 0) -> str:
    """The term, with brackets where its operator binds less than `outer`."""
    match term:
        case ir.Number():
            return f"{term.value:g}"
        case ir.Object() | ir.Var():
            return term.name
        case ir.Any_():
            return "ANY"
        case ir.ChainEnd():
            return f"{term.chain}.{'last' if term.last else 'first'}"
        case ir.ChainModule():
            return f"{term.chain}[{format_term(term.index)}]" + (f".{term.side}" if term.side else "")
        case ir.Function(name="torque", args=(thing, ir.Letter(joint))):
            return f"torque({format_term(thing)}.{joint})"
        case ir.Function():
            return f"{term.name}({', '.join(map(format_term, term.args))})"
        case ir.Letter():
            return term.letter
        case ir.Arith():
            return _arithmetic(term, outer)
        case ir.Vector():
            return f"({', '.join(map(format_term, term.items))})"
        case ir.Conditional():
            condition = format_formula(term.condition)
            return f"(if {condition} then {format_term(term.then)} else {format_term(term.otherwise)})"
        case ir.Aggregate():
            return f"{term.operator}({_variables(term.variables)}) {format_term(term.body, 3)}"
        case ir.Prune():
            return "prune"


def _arithmetic(term: ir.Arith, outer: int) -> str:
    own = PRECEDENCE[term.operator]
    if term.operator == "neg":
        return f"-{format_term(term.operands[0], own)}"
    left, right = format_term(term.operands[0], own), format_term(term.operands[1], own + 1)
    text = f"{left} {term.operator} {right}"
    return f"({text})" if own < outer else text


def format_formula(formula: ir.Formula, inner: bool = False) -> str:
    """The formula; `inner` puts conjunctions and disjunctions in brackets."""
    match formula:
        case ir.Literal():
            return format_literal(formula)
        case ir.Not():
            return f"not {format_formula(formula.operand, True)}"
        case ir.And() | ir.Or():
            return _joined(formula, inner)
        case ir.Exists() | ir.Forall():
            word = "exists" if isinstance(formula, ir.Exists) else "forall"
            return f"{word} {_variables(formula.variables)} {{ {format_formula(formula.body)} }}"
        case ir.Compare():
            return f"{format_term(formula.left)} {formula.operator} {format_term(formula.right)}"
        case ir.Previous():
            arguments = "" if formula.args is None else f"({', '.join(map(format_term, formula.args))})"
            return f"previous is {formula.rule}{arguments}"


def _joined(formula: ir.And | ir.Or, inner: bool) -> str:
    if not formula.operands:
        return "true" if isinstance(formula, ir.And) else "false"
    word = " and " if isinstance(formula, ir.And) else " or "
    text = word.join(format_formula(f, True) for f in formula.operands)
    return f"({text})" if inner and len(formula.operands) > 1 else text


def format_literal(literal: ir.Literal) -> str:
    """`(on X A)` or `[stable X A]`."""
    left, right = "[]" if literal.motion else "()"
    return left + " ".join([literal.predicate, *map(format_term, literal.args)]) + right


def format_effect(effect: ir.EffectItem) -> str:
    """One effect on one line."""
    if isinstance(effect, ir.Effect):
        return "not " * effect.negated + format_literal(effect.literal)
    inner = ", ".join(map(format_effect, effect.effects))
    if isinstance(effect, ir.EffectIf):
        return f"if {format_formula(effect.condition)} {{ {inner} }}"
    return f"for {_variables(effect.variables)} {{ {inner} }}"
