"""What the checks share: symbol tables, signatures, the findings, and the random numbers of a scene."""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from ...langs import syntax
from ...langs.source import Span
from .. import ir
from ..library import VALUE_TYPE_NAMES, Library, Signature
from .findings import Findings
from .names import Scope, Typed
from .repeated_values import Repeated


@dataclass(slots=True)
class Context:
    """`logic` and `motion` hold the signatures of the two kinds of predicates. `random` is None while nothing is
    evaluated; then it is drawn from in the order of the scene's text. `open_functions` are those whose bodies are
    being read, `open_defaults` the parameters whose defaults are; `expands` is False where they would make too much.
    `rounds` counts those of all loops. Terms hold formulas and formulas hold terms, each within declared functions and
    binders, too: how they are checked stands here for all that lies between."""

    library: Library
    findings: Findings
    check_term: Callable[[Context, Scope, syntax.Term], Typed]
    check_formula: Callable[[Context, Scope, syntax.Formula], ir.Formula]
    logic: Mapping[str, Signature] = field(default_factory=dict)
    motion: Mapping[str, Signature] = field(default_factory=dict)
    random: random.Random | None = None
    open_functions: list[str] = field(default_factory=list)
    open_defaults: list[Span] = field(default_factory=list)
    expands: bool = True
    rounds: int = 0
    repeated: Repeated = field(default_factory=Repeated)

    def object_type(self, node: syntax.Type) -> str | None:
        """The name of a declared object type, or None after reporting that there is none."""
        if not isinstance(node, syntax.NamedType):
            self.findings.report("E0208", node.span, "a type of objects is needed here")
            return None
        if node.name in VALUE_TYPE_NAMES:
            self.findings.report(
                "E0208", node.span, f"`{node.name}` is a type of values; a type of objects is needed here"
            )
            return None
        if node.name not in self.library.types:
            self.findings.unknown("E0102", "type", node.name, node.span, self.library.types)
            return None
        return node.name


def build_context(
    library: Library,
    findings: Findings,
    check_term: Callable[[Context, Scope, syntax.Term], Typed],
    check_formula: Callable[[Context, Scope, syntax.Formula], ir.Formula],
) -> Context:
    """A context with the signatures of all predicates of `library`; checks their parameters on the way."""
    context = Context(library, findings, check_term, check_formula)
    logic: dict[str, Signature] = {}
    for predicate in library.predicates.values():
        logic[predicate.name] = Signature(
            predicate.name,
            _parameters(context, predicate),
            findings.word(predicate.span, predicate.name),
            predicate.static,
        )
        _check_modifiers(context, predicate, logic[predicate.name])
    for derived in library.derived.values():
        logic[derived.name] = Signature(
            derived.name, _parameters(context, derived), findings.word(derived.span, derived.name), derived=True
        )
    context.logic = logic
    context.motion = {
        motion.name: Signature(motion.name, _parameters(context, motion), findings.word(motion.span, motion.name))
        for motion in library.motions.values()
    }
    for motion in library.motions.values():
        if motion.symmetric:
            _check_symmetric(context, motion, context.motion[motion.name])
    return context


def _parameters(
    context: Context, declaration: syntax.PredicateDecl | syntax.DerivedDecl | syntax.MotionDecl
) -> tuple[ir.Variable, ...]:
    seen: set[str] = set()
    variables = []
    for parameter in declaration.parameters:
        if parameter.name in seen:
            context.findings.report(
                "E0309", context.findings.word(parameter.span, parameter.name), f"`{parameter.name}` is bound twice"
            )
        seen.add(parameter.name)
        variables.append(ir.Variable(parameter.name, ir.ObjectType(context.object_type(parameter.type) or "object")))
    return tuple(variables)


def _check_modifiers(context: Context, declaration: syntax.PredicateDecl, signature: Signature) -> None:
    names = [p.name for p in declaration.parameters]
    key = declaration.functional_in
    if key is not None and key not in names:
        occurrence = names.count(key)
        where = context.findings.word(declaration.span, key, occurrence)
        context.findings.unknown("E0304", "parameter", key, where, names)
    if declaration.symmetric:
        _check_symmetric(context, declaration, signature)


def _check_symmetric(
    context: Context, declaration: syntax.PredicateDecl | syntax.MotionDecl, signature: Signature
) -> None:
    if len(signature.variables) != 2 or signature.variables[0].type != signature.variables[1].type:
        context.findings.report(
            "E0308",
            context.findings.word(declaration.span, "symmetric"),
            f"`{declaration.name}` is symmetric, which needs two parameters of one type",
        )
