"""Symbol tables: every declaration of a file and of all that it imports, by kind and name."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeVar

from ..langs import syntax
from ..langs.frozen import dataclass
from ..langs.source import Source, Span
from . import ir
from .checks.findings import Findings
from .mesh_bodies import MeshBody
from .urdf_files import MeshName

BUILT_IN_TYPES: Mapping[str, str | None] = {"object": None, "effector": "object", "region": "object", "module": None}
VALUE_TYPE_NAMES = ("int", "real", "length", "angle", "time", "speed", "mass", "density", "force", "torque", "inertia")

Named = (
    syntax.TypeDecl
    | syntax.PredicateDecl
    | syntax.DerivedDecl
    | syntax.FunctionDecl
    | syntax.MotionDecl
    | syntax.RuleDecl
    | syntax.HeuristicDecl
    | syntax.ModuleDecl
    | syntax.SceneDecl
    | syntax.TaskDecl
)
Declared = TypeVar("Declared", bound=Named)


@dataclass(frozen=True, slots=True)
class Signature:
    """What a use of a logic or motion predicate must fit. `variables` are its typed parameters."""

    name: str
    variables: tuple[ir.Variable, ...]
    span: Span
    static: bool = False
    derived: bool = False


@dataclass(frozen=True, slots=True)
class Library:
    """Parsed files, the main one first, and their declarations. `models` are the texts that module types and shapes
    come from: URDFs, and the corners of meshes; `meshes` are the bodies for the meshes of URDFs. `foreign` holds the
    files that they were read from; `names` tells how sources and these files, by path, are called on any machine."""

    sources: tuple[Source, ...]
    models: tuple[Source, ...]
    meshes: Mapping[MeshName, MeshBody | None]
    files: tuple[syntax.File, ...]
    foreign: Mapping[str, bytes]
    names: Mapping[str, str]
    types: Mapping[str, str | None]
    predicates: Mapping[str, syntax.PredicateDecl]
    derived: Mapping[str, syntax.DerivedDecl]
    functions: Mapping[str, syntax.FunctionDecl]
    motions: Mapping[str, syntax.MotionDecl]
    rules: Mapping[str, syntax.RuleDecl]
    placements: tuple[syntax.PlacementDecl, ...]
    heuristics: Mapping[str, syntax.HeuristicDecl]
    modules: Mapping[str, syntax.ModuleDecl]
    scenes: Mapping[str, syntax.SceneDecl]
    tasks: Mapping[str, syntax.TaskDecl]

    @property
    def tables(self) -> tuple[Mapping[str, Named], ...]:
        """All declarations that have a name, by kind, but for types."""
        return (
            self.predicates,
            self.derived,
            self.functions,
            self.motions,
            self.rules,
            self.heuristics,
            self.modules,
            self.scenes,
            self.tasks,
        )

    @property
    def path(self) -> str:
        return self.sources[0].path

    def is_a(self, type_name: str, ancestor: str) -> bool:
        """Whether type `type_name` is `ancestor` or below it."""
        current: str | None = type_name
        while current is not None:
            if current == ancestor:
                return True
            current = self.types.get(current)
        return False

    def overlap(self, one: str, other: str) -> bool:
        """Whether an object can be of both types."""
        return self.is_a(one, other) or self.is_a(other, one)


class _Tables:
    def __init__(self, files: tuple[syntax.File, ...], findings: Findings) -> None:
        # Imported files first, so that of two declarations the later one, in the importing file, is reported.
        self.declarations = [d for f in reversed(files) for d in f.declarations]
        self.findings = findings

    def of(self, kind: type[Declared]) -> dict[str, Declared]:
        table: dict[str, Declared] = {}
        for declaration in self.declarations:
            if not isinstance(declaration, kind):
                continue
            name = declaration.name
            first = table.setdefault(name, declaration)
            if first is not declaration:
                self.duplicate(name, declaration.span, first.span)
        return table

    def duplicate(self, name: str, span: Span, first: Span) -> None:
        at = self.findings.word
        self.findings.report(
            "E0110", at(span, name), f"`{name}` is declared twice", labels=[(at(first, name), "first declared here")]
        )


def build_library(
    sources: tuple[Source, ...], models: tuple[Source, ...], meshes: Mapping[MeshName, MeshBody | None],
    files: tuple[syntax.File, ...], foreign: Mapping[str, bytes], names: Mapping[str, str], findings: Findings,
) -> Library:  # fmt: skip
    """The tables of `files`. Reports names declared twice, built-in names declared again, unknown parents of types and
    types that are below themselves."""
    tables = _Tables(files, findings)
    predicates, derived = tables.of(syntax.PredicateDecl), tables.of(syntax.DerivedDecl)
    for name in predicates.keys() & derived.keys():
        tables.duplicate(name, derived[name].span, predicates[name].span)
    modules = tables.of(syntax.ModuleDecl)
    types = _types(tables.of(syntax.TypeDecl), modules, tables)
    return Library(
        sources,
        models,
        meshes,
        files,
        foreign,
        names,
        types,
        predicates,
        derived,
        tables.of(syntax.FunctionDecl),
        tables.of(syntax.MotionDecl),
        tables.of(syntax.RuleDecl),
        tuple(d for d in tables.declarations if isinstance(d, syntax.PlacementDecl)),
        tables.of(syntax.HeuristicDecl),
        modules,
        tables.of(syntax.SceneDecl),
        tables.of(syntax.TaskDecl),
    )


def _types(
    declared: Mapping[str, syntax.TypeDecl], modules: Mapping[str, syntax.ModuleDecl], tables: _Tables
) -> dict[str, str | None]:
    findings = tables.findings
    types: dict[str, str | None] = dict(BUILT_IN_TYPES)
    spans: dict[str, Span] = {}
    for name, declaration in [*declared.items(), *modules.items()]:
        where = findings.word(declaration.span, name)
        if name in BUILT_IN_TYPES or name in VALUE_TYPE_NAMES:
            findings.report("E0118", where, f"`{name}` is a built-in type and cannot be declared again")
            continue
        if name in spans:
            tables.duplicate(name, declaration.span, spans[name])
            continue
        spans[name] = where
        types[name] = (declaration.parent or "object") if isinstance(declaration, syntax.TypeDecl) else "module"
    for name, declaration in declared.items():
        parent = types.get(name)
        if name in spans and parent is not None and parent not in types:
            findings.unknown("E0102", "type", parent, findings.word(declaration.span, parent), types)
            types[name] = "object"
    _break_cycles(types, spans, findings)
    return types


def _break_cycles(types: dict[str, str | None], spans: Mapping[str, Span], findings: Findings) -> None:
    sound: set[str] = set()
    for name in list(types):
        seen = {name: None}
        current = types[name]
        while current is not None and current not in seen and current not in sound:
            seen[current] = None
            current = types[current]
        if current is None or current in sound:
            sound.update(seen)
        if current == name:
            ring = " < ".join([*seen, name])
            findings.report("E0115", spans[name], f"type `{name}` is below itself: {ring}")
            types[name] = "object"
