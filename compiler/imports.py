"""Stage 1: a file and all that it imports, read and parsed. Path or sources in, a library of declarations out."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from pathlib import Path

from ..langs import syntax
from ..langs.diagnostics import Diagnostic, SourceError
from ..langs.parser import parse
from ..langs.reader import read_source
from ..langs.source import MAX_DEPTH, Source
from .checks.findings import Findings
from .foreign import MADE, Files, beside, portable
from .library import Library, build_library
from .mesh_bodies import MeshBody
from .mesh_files import load_mesh, mesh_calls
from .standard import EXTENSION, STANDARD, STANDARD_FOLDER
from .urdf_files import MeshName, load_urdf, urdf_path


class _Loader:
    """Follows imports depth first. `given` holds texts that need no disk, by path; where `foreign` has files given,
    too, the disk is not asked at all. `names` tells how each path is called relative to the main file; `unfit` is what
    is wrong with URDF and mesh files, which hides no declaration."""

    def __init__(self, given: Mapping[str, Source], foreign: Files) -> None:
        self.given = given
        self.foreign = foreign
        self.names: dict[str, str] = {}
        self.standard: set[str] = set()
        self.sources: dict[str, Source] = {}
        self.files: dict[str, syntax.File] = {}
        self.models: dict[str, Source] = {}
        self.meshes: dict[MeshName, MeshBody | None] = {}
        self.convex: set[str] = set()
        self.diagnostics: list[Diagnostic] = []
        self.unfit: list[Diagnostic] = []
        self.places: dict[str, str] = {}
        self.open: list[str] = []
        self.deep = False

    def load(self, source: Source, called: str) -> None:
        self.places.setdefault(os.path.realpath(source.path), source.path)
        self.sources[source.path] = source
        self.names[source.path] = called
        file, diagnostics = parse(source)
        self.files[source.path] = file
        self.diagnostics += diagnostics
        self.open.append(source.path)
        for declaration in file.declarations:
            if isinstance(declaration, syntax.Import):
                self.follow(source, declaration)
            elif isinstance(declaration, syntax.ModuleDecl) and declaration.urdf is not None:
                self.read_urdf(source, declaration)
            for call, name in mesh_calls(declaration):
                self.read_mesh(source, call, name)
        self.open.pop()

    def read_urdf(self, importer: Source, module: syntax.ModuleDecl) -> None:
        path = urdf_path(importer.path, module)
        if path not in self.models:
            self.names[path] = urdf_path(self.names[importer.path], module)
            found = load_urdf(path, module, self.names, self.foreign)
            self.unfit += found.diagnostics
            self.meshes |= found.meshes
            self.models.update({} if found.source is None else {path: found.source})

    def read_mesh(self, importer: Source, call: syntax.Call, name: syntax.Text) -> None:
        path = beside(importer.path, name.value)
        if path not in self.models or (call.function == "mesh" and path not in self.convex):
            self.names[path] = beside(self.names[importer.path], name.value)
            found, diagnostics = load_mesh(path, call, name, self.foreign)
            self.unfit += diagnostics
            self.convex |= {path} if call.function == "mesh" and found is not None else set()
            self.names |= {f"{path}{MADE}": f"{self.names[path]}{MADE}"} if f"{path}{MADE}" in self.foreign.kept else {}
            self.models.update({} if found is None else {path: found})

    def follow(self, importer: Source, declaration: syntax.Import) -> None:
        path = self.known(resolved(importer.path, declaration), declaration)
        if path in self.open:
            ring = [*self.open[self.open.index(path) :], path]
            message = f"files import each other: {' imports '.join(ring)}"
            self.diagnostics.append(Diagnostic("E0112", message, declaration.span))
        elif path not in self.sources and len(self.open) >= MAX_DEPTH:
            if not self.deep:
                message = f"files import each other more than {MAX_DEPTH} deep"
                self.diagnostics.append(Diagnostic("E0008", message, declaration.span))
            self.deep = True
        elif path not in self.sources:
            source = self.read(path, declaration)
            if source is not None:
                self.standard |= set() if declaration.is_path else {path}
                self.load(source, resolved(self.names[importer.path], declaration))

    def known(self, path: str, declaration: syntax.Import) -> str:
        """The path by which the same file is known already, where a link leads to it; else `path` itself."""
        if path in self.sources or path in self.given or not declaration.is_path:
            return path
        return self.places.setdefault(_real(path), path)

    def read(self, path: str, declaration: syntax.Import) -> Source | None:
        if path in self.given:
            return self.given[path]
        if self.foreign.given is not None:
            message = f"the plan lacks the text of {path}"
            self.diagnostics.append(Diagnostic("E0111", message, declaration.span))
            return None
        location = Path(path) if declaration.is_path else on_disk(path)
        if not declaration.is_path and not declaration.target.startswith(f"{STANDARD}."):
            self.diagnostics.append(_foreign(declaration))
            return None
        try:
            return Source(path, read_source(location).text)
        except SourceError as error:
            for found in error.diagnostics:
                self.diagnostics.append(self.missing(location, found, declaration))
            return None

    def missing(self, location: Path, found: Diagnostic, declaration: syntax.Import) -> Diagnostic:
        if found.code != "E0010":
            return Diagnostic(found.code, found.message, declaration.span, (), found.help)
        what = f'"{declaration.target}"' if declaration.is_path else declaration.target
        own = Path(declaration.span.file)
        near = [name for name in neighbours(location) if location.with_name(f"{name}{own.suffix}") != own]
        names = get_close_matches(location.stem, near, n=3, cutoff=0.5)
        help = _read_otherwise(declaration)
        if help is None and names:
            help = "did you mean " + " or ".join(f"`{_import_of(n, declaration)}`" for n in names) + "?"
        elif help is None and not declaration.is_path and near:
            help = "the standard library has " + ", ".join(f"{STANDARD}.{n}" for n in near)
        return Diagnostic("E0111", f"nothing to import under {what}", declaration.span, (), help)


def _real(path: str) -> str:
    """The path without links; the path itself where no file can have that name, which reading it tells."""
    try:
        return os.path.realpath(path)
    except ValueError:
        return path


def _read_otherwise(declaration: syntax.Import) -> str | None:
    """The hint for what is no path of a program: a file of the standard library, or of a robot."""
    head, _, tail = declaration.target.removesuffix(EXTENSION).replace("/", ".").partition(".")
    if head == STANDARD and tail in neighbours(STANDARD_FOLDER / "any"):
        return f"write `import {STANDARD}.{tail}`"
    if declaration.target.endswith((".urdf", ".xacro", ".xml")):
        return f'a robot is read by `module NAME from urdf "{declaration.target}" {{ … }}`'
    return None


def _foreign(declaration: syntax.Import) -> Diagnostic:
    """A dotted import that is not of the standard library."""
    head, _, tail = declaration.target.partition(".")
    own = declaration.target.replace(".", "/") + EXTENSION
    help = f'files of your own are quoted: `import "{own}"`'
    known = neighbours(STANDARD_FOLDER / "any")
    if declaration.target == STANDARD:
        help = "name what you want of the standard library: " + ", ".join(f"{STANDARD}.{name}" for name in known)
    elif (tail or head) in known:
        help = f"did you mean `import {STANDARD}.{tail or head}`?"
    return Diagnostic("E0111", f"nothing to import under {declaration.target}", declaration.span, (), help)


def _import_of(stem: str, declaration: syntax.Import) -> str:
    head = os.path.dirname(declaration.target)
    return f'import "{os.path.join(head, stem + EXTENSION)}"' if declaration.is_path else f"import {STANDARD}.{stem}"


def neighbours(location: Path) -> list[str]:
    """The names, without ending, of the source files beside `location`."""
    try:
        return sorted(p.stem for p in location.parent.iterdir() if p.suffix == EXTENSION)
    except OSError:
        return []


def resolved(importer: str, declaration: syntax.Import) -> str:
    """The path of an import as the user should see it; files of the standard library are `std/NAME.tamp`."""
    if not declaration.is_path:
        return "/".join(declaration.target.split(".")) + EXTENSION
    return os.path.normpath(os.path.join(os.path.dirname(importer), declaration.target))


def on_disk(path: str) -> Path:
    """Where the file that is shown as `path` lies."""
    head, _, tail = path.partition("/")
    return STANDARD_FOLDER / tail if head == STANDARD and tail else Path(path)


def load_sources(
    sources: Sequence[Source], files: Mapping[str, bytes] | None = None
) -> tuple[Library, Findings, bool]:
    """The library of `sources[0]`, whose imports are looked up among `sources` first; findings so far; and whether the
    text could be parsed without errors. With `files`, by path, nothing else is read: neither imports nor files."""
    loader = _Loader({s.path: s for s in sources[1:]}, Files(files))
    main = sources[0].path
    loader.load(sources[0], main if files is not None else os.path.basename(main))
    findings = Findings([*loader.sources.values(), *loader.models.values()])
    for diagnostic in loader.diagnostics:
        findings.add(diagnostic)
    parsed = not findings.has_errors
    for diagnostic in loader.unfit:
        findings.add(diagnostic)
    texts = tuple(loader.sources.values()), tuple(loader.models.values())
    names = portable(loader.names, loader.standard, STANDARD)
    files_read = tuple(loader.files.values())
    library = build_library(*texts, loader.meshes, files_read, loader.foreign.kept, names, findings)
    return library, findings, parsed


def load_library(path: str | os.PathLike[str]) -> Library:
    """The file at `path` with all its imports. Raises SourceError with all errors of syntax, imports and duplicate
    declarations of all files."""
    library, findings, _ = load_sources([read_source(path)])
    if findings.has_errors:
        raise SourceError(findings.sorted())
    return library
