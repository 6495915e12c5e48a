"""Names, indices and attributes: variables, parts of chains, and the things of a scene."""

from __future__ import annotations

from collections.abc import Callable

from ...langs import syntax
from ...langs.diagnostics import did_you_mean
from ...langs.source import PLACEHOLDER
from ...langs.trees import parts
from .. import ir
from .context import Context
from .kinds import UNKNOWN, Kind
from .names import BROKEN, Entry, Scope, Typed

Check = Callable[[Context, Scope, syntax.Term], Typed]


def check_name(context: Context, scope: Scope, term: syntax.Name) -> Typed:
    """A variable, a parameter, a thing of the scene without index, or `prune`."""
    entry = scope.entries.get(term.name)
    if entry is not None:
        return _used_at(entry, term)
    if term.name == PLACEHOLDER:
        return BROKEN
    if term.name in scope.objects.families:
        return check_object(context, scope, term, term.name, [])
    if term.name == "prune":
        if scope.place == "heuristic":
            return Typed(ir.Prune(), Kind("number"))
        context.findings.report("E0311", term.span, "`prune` stands only in heuristics")
        return BROKEN
    code, what = ("E0301", "variable") if scope.place in ("rule", "motion", "heuristic") else ("E0101", "name")
    names = list(scope.names())
    help = did_you_mean(term.name, names)
    if help is None and term.name in ("pi", "PI"):
        help = "write `180 deg`"
    if help is None and scope.objects.incomplete:
        return BROKEN
    if help is None and code == "E0301":
        help = "bind it as a parameter or with `exists`" if scope.place == "rule" else "bind it as a parameter"
    thing = _in_a_scene(context, term.name) if scope.place in ("rule", "motion") else None
    if thing is not None:
        where = "rules" if scope.place == "rule" else "motion predicates"
        help = f"{where} speak of any scene: give `{term.name}` a type of its own, and bind a parameter of that type"
    labels = [] if thing is None else [(thing.span, "a thing of this scene alone")]
    context.findings.report(code, term.span, f"unknown {what} `{term.name}`", labels=labels, help=help)
    return BROKEN


def _in_a_scene(context: Context, name: str) -> syntax.Term | None:
    """Where a scene or a task of the program puts a thing of this name."""
    for declaration in (*context.library.scenes.values(), *context.library.tasks.values()):
        for item in parts(declaration):
            if isinstance(item, syntax.BodyItem | syntax.RobotItem):
                base = _base(item.name)
                if isinstance(base, syntax.Name) and base.name == name:
                    return base
    return None


def _used_at(entry: Entry, term: syntax.Name) -> Typed:
    lowered = entry.typed.term
    if isinstance(lowered, ir.Var):
        return Typed(ir.Var(lowered.name, term.span), entry.typed.kind)
    if isinstance(lowered, ir.Object):
        return Typed(ir.Object(lowered.name, term.span), entry.typed.kind)
    if isinstance(lowered, ir.Number):
        return Typed(ir.Number(lowered.value, term.span), entry.typed.kind)
    return entry.typed


def check_index(context: Context, scope: Scope, term: syntax.Index, check: Check) -> Typed:
    """`c[k]` of a chain, or a thing of the scene with its indices."""
    base: syntax.Term = term
    indices: list[syntax.Term] = []
    while isinstance(base, syntax.Index):
        indices.insert(0, base.index)
        base = base.base
    if not isinstance(base, syntax.Name):
        context.findings.report("E0208", base.span, "only chains and things of a scene have an index")
        return BROKEN
    entry = scope.entries.get(base.name)
    if entry is None and base.name in scope.objects.families:
        return check_object(context, scope, term, base.name, [(i, check(context, scope, i)) for i in indices])
    if entry is None:
        return check_name(context, scope, base)
    if entry.typed.kind.name != "chain":
        if entry.typed.kind.known:
            context.findings.report(
                "E0208",
                base.span,
                f"`{base.name}` is {entry.typed.kind} and has no index",
                labels=[(entry.span, "declared here")],
            )
        return BROKEN
    index = check(context, scope, indices[0])
    if index.kind.known and index.kind.name != "number":
        context.findings.report("E0208", indices[0].span, f"an index must be a plain number, not {index.kind}")
        return BROKEN
    return Typed(ir.ChainModule(_chain_name(entry), index.term, "", term.span), Kind("object", entry.typed.kind.type))


def _chain_name(entry: Entry) -> str:
    assert isinstance(entry.typed.term, ir.Var)
    return entry.typed.term.name


def check_attribute(context: Context, scope: Scope, term: syntax.Attribute, check: Check) -> Typed:
    """`p.first`, `c[k].out`, or an effector of a module of the scene such as `c[1].A`."""
    base = term.base
    if isinstance(base, syntax.Name) and base.name not in scope.entries and base.name not in scope.objects.families:
        return check_name(context, scope, base)
    typed = check(context, scope, base)
    if not typed.kind.known:
        return BROKEN
    if typed.kind.name == "chain" and isinstance(typed.term, ir.Var):
        if term.name in ("first", "last"):
            lowered = ir.ChainEnd(typed.term.name, term.name == "last", term.span)
            return Typed(lowered, Kind("object", typed.kind.ends))
        _unknown_attribute(context, term, "a chain", ("first", "last"))
        return BROKEN
    if isinstance(typed.term, ir.ChainModule):
        if term.name in ("in", "out"):
            ends = scope.entries[_base_name(base)].typed.kind.ends
            chain = ir.ChainModule(typed.term.chain, typed.term.index, term.name, term.span)
            return Typed(chain, Kind("object", ends))
        _unknown_attribute(context, term, "a module of a chain", ("in", "out"))
        return BROKEN
    if isinstance(typed.term, ir.Object) and typed.kind.type in scope.objects.ends:
        ends_of = scope.objects.ends[typed.kind.type]
        if term.name in ends_of:
            return Typed(ir.Object(f"{typed.term.name}.{term.name}", term.span), Kind("object", ends_of[term.name]))
        where = context.findings.word(term.span, term.name)
        context.findings.unknown("E0117", "effector", term.name, where, ends_of)
        return BROKEN
    _unknown_attribute(context, term, str(typed.kind), ())
    return BROKEN


def _base(term: syntax.Term) -> syntax.Term:
    """What stands before all indices."""
    while isinstance(term, syntax.Index):
        term = term.base
    return term


def _base_name(term: syntax.Term) -> str:
    base = _base(term)
    assert isinstance(base, syntax.Name)
    return base.name


def _unknown_attribute(context: Context, term: syntax.Attribute, what: str, known: tuple[str, ...]) -> None:
    has = f"it has {' and '.join('.' + k for k in known)}" if known else None
    last = context.findings.word(term.span, term.name)
    context.findings.report(
        "E0114", last, f"{what} has no attribute `{term.name}`", help=did_you_mean(term.name, known) or has
    )


def check_object(
    context: Context, scope: Scope, term: syntax.Term, base: str, indices: list[tuple[syntax.Term, Typed]]
) -> Typed:
    """A thing of the scene by its base name and indices, such as `plate[3]`; while the scene is not built yet the
    indices are not looked up."""
    family = scope.objects.families[base]
    findings = context.findings
    if family.type not in context.library.types:
        return BROKEN
    if len(indices) != family.indices:
        needs = f"needs {family.indices} index" if family.indices else "has no index"
        findings.report("E0101", term.span, f"`{base}` {needs}", labels=[(family.span, "declared here")])
        return BROKEN
    name = object_name(context, base, indices)
    if name is None:
        return (
            BROKEN
            if scope.objects.ground is not None
            else Typed(ir.Object(base, term.span), Kind("object", family.type))
        )
    if scope.objects.ground is not None and name not in scope.objects.ground:
        later = family.span.file == term.span.file and family.span.start > term.span.start
        help = f"`{base}` is declared further down; move it up" if later else did_you_mean(name, scope.objects.ground)
        findings.report("E0101", term.span, f"there is no object `{name}`", help=help)
        return Typed(ir.Number(0), UNKNOWN)
    return Typed(ir.Object(name, term.span), Kind("object", family.type))


def object_name(context: Context, base: str, indices: list[tuple[syntax.Term, Typed]]) -> str | None:
    """`base[i][j]` with the values of the indices, or None while one of them is not known or not whole."""
    parts = [base]
    for term, typed in indices:
        if not typed.kind.known:
            return None
        if typed.kind.name != "number":
            context.findings.report("E0208", term.span, f"an index must be a plain number, not {typed.kind}")
            return None
        if typed.value is None:
            return None
        if typed.value != int(typed.value):
            context.findings.report("E0205", term.span, f"an index must be a whole number, not {typed.value:g}")
            return None
        parts.append(f"[{int(typed.value)}]")
    return "".join(parts)
