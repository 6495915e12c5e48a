"""How much a declaration stands for once the functions and derived predicates that it uses are put in.

Later stages put them in. What they would make is counted here on the tree, once per declaration, so that texts that
double with every line are refused at the line where it becomes too much, before anything grows.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from ...langs import syntax
from ...langs.source import MAX_DEPTH
from ...langs.trees import children, parts
from ..library import Library
from .context import Context

MOST = 20_000
"""Terms and conditions that all uses of a program together may always add to its text. The programs of the standard
library and the examples add at most 1,500; this many take some seconds to compile."""
SHARE = 2
"""How many times the text itself they may add where that is more: a long text stands for much."""

Used = syntax.FunctionDecl | syntax.DerivedDecl
Declared = Used | syntax.MotionDecl | syntax.RuleDecl | syntax.HeuristicDecl | syntax.SceneDecl | syntax.TaskDecl


@dataclass(slots=True)
class Extent:
    """Of a declaration with everything put in: how many terms and conditions there are, how many of them stand in its
    own text, and how deep they are nested; where each parameter stands: how often, and how deep."""

    size: int = 0
    own: int = 0
    depth: int = 0
    uses: Counter[str] = field(default_factory=Counter)
    depths: dict[str, int] = field(default_factory=dict)


def check_extents(context: Context) -> None:
    """Report the first declaration that is nested deeper than the reader follows (E0008) once what it uses is put in,
    and the one with which the program stands for too much (E0314); then `context.expands` is False."""
    known: dict[str, Extent] = {}
    added = own = 0
    for declaration in _in_order(context.library):
        extent = _extent(context.library, declaration, known)
        if isinstance(declaration, Used):
            known[_key(declaration)] = extent
        if not isinstance(declaration, syntax.DerivedDecl):  # put in where it is used, but read by itself
            added += extent.size - extent.own
        own += extent.own
        most = max(MOST, SHARE * own)
        where = context.findings.word(declaration.span, declaration.name)
        if extent.depth > MAX_DEPTH:
            message = f"`{declaration.name}` is nested {extent.depth} deep once what it uses is put in"
            context.findings.report("E0008", where, f"{message}; at most {MAX_DEPTH} is read")
        elif added > most:
            message = f"with `{declaration.name}` the program stands for more than {own + most} terms"
            help = "functions and derived predicates are put in wherever they are used"
            context.findings.report("E0314", where, message, help=help)
        else:
            continue
        context.expands = False
        return


def _in_order(library: Library) -> Iterator[Declared]:
    """What is used before what uses it; the others as in the text. Circles are reported elsewhere and left out."""
    table = _used(library)
    parts = {key: _names_in(table, d.body) for key, d in table.items()}
    waiting = {key: len(names) for key, names in parts.items()}
    users: dict[str, list[str]] = {}
    for key, names in parts.items():
        for name in names:
            users.setdefault(name, []).append(key)
    ready = [key for key, count in reversed(waiting.items()) if count == 0]
    while ready:
        key = ready.pop()
        yield table[key]
        for user in users.get(key, ()):
            waiting[user] -= 1
            if waiting[user] == 0:
                ready.append(user)
    for others in (library.motions, library.rules, library.heuristics, library.scenes, library.tasks):
        yield from others.values()


def _key(declaration: Used) -> str:
    """Functions and derived predicates may have one name."""
    return f"{'f' if isinstance(declaration, syntax.FunctionDecl) else 'd'} {declaration.name}"


def _used(library: Library) -> dict[str, Used]:
    used: list[Used] = [*library.functions.values(), *library.derived.values()]
    return {_key(d): d for d in used}


def _names_in(table: Mapping[str, Used], body: object) -> set[str]:
    return {key for node in parts(body) if (key := _called(node)) in table}


def _called(node: object) -> str:
    if isinstance(node, syntax.Call):
        return f"f {node.function}"
    return f"d {node.predicate}" if isinstance(node, syntax.Literal) and not node.motion else ""


def _extent(library: Library, declaration: Declared, known: Mapping[str, Extent]) -> Extent:
    extent = Extent()
    parameters = {p.name for p in declaration.parameters}
    for name in declaration.__dataclass_fields__:
        if name not in ("span", "parameters"):
            for part in children((getattr(declaration, name),)):
                _Walk(library, known, parameters, extent).visit(part, 0, 1)
    return extent


@dataclass(slots=True)
class _Walk:
    library: Library
    known: Mapping[str, Extent]
    parameters: set[str]
    found: Extent

    def visit(self, node: syntax.Node, depth: int, times: int, own: bool = True) -> None:
        """Count `node`, which stands `times` times at `depth` once everything is put in."""
        self.count(node, depth, times, own)
        inner = self.known.get(_called(node))
        if inner is None:
            deeper = depth + isinstance(node, syntax.Term | syntax.Formula)
            for part in children(node):
                self.visit(part, deeper, times, own)
        else:
            self.put_in(node, inner, depth, times, own)

    def count(self, node: syntax.Node, depth: int, times: int, own: bool) -> None:
        found = self.found
        found.size += times
        found.own += own
        found.depth = max(found.depth, depth)
        if isinstance(node, syntax.Name) and node.name in self.parameters:
            found.uses[node.name] += times
            found.depths[node.name] = max(found.depths.get(node.name, 0), depth)

    def put_in(self, node: syntax.Node, inner: Extent, depth: int, times: int, own: bool) -> None:
        self.found.size += times * inner.size
        self.found.depth = max(self.found.depth, depth + inner.depth)
        for parameter, value, given in self.arguments(node):
            copies = max(1, inner.uses[parameter])
            self.visit(value, depth + inner.depths.get(parameter, 0), times * copies, own and given)

    def arguments(self, node: syntax.Node) -> Iterator[tuple[str, syntax.Term, bool]]:
        """The parameters of what is used with their values, and whether these stand at the use."""
        if isinstance(node, syntax.Call):
            parameters, values = self.library.functions[node.function].parameters, node.args
        else:
            assert isinstance(node, syntax.Literal)
            parameters, values = self.library.derived[node.predicate].parameters, node.args
        for index, parameter in enumerate(parameters):
            if index < len(values):
                yield parameter.name, values[index], True
            elif parameter.default is not None:
                yield parameter.name, parameter.default, False
