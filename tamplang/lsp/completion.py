"""What may be written at a place: words of the grammar that fit there, and names of the kind that is meant."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from contextlib import suppress

from lsprotocol import types

from ..compiler.builtins import FUNCTIONS
from ..compiler.imports import neighbours, on_disk
from ..compiler.ir import BreakdownKind
from ..compiler.library import VALUE_TYPE_NAMES
from ..compiler.naming import Naming, Place
from ..compiler.objectives import MEASURES
from ..compiler.options import OPTIONS, given_at
from ..compiler.standard import EXTENSION, STANDARD_FOLDER
from ..langs.source import Source
from ..langs.words import ATTRIBUTES, JOINTS, SHAPES, TYPES, WORDS
from .documents import Documents
from .hover import described
from .signatures import parameters_of
from .snippets import DECLARATIONS, ITEMS
from .where import Context, context_at

Item = types.CompletionItem
Kind = types.CompletionItemKind
KINDS = {
    "type": Kind.Interface, "predicate": Kind.Value, "motion": Kind.Operator, "function": Kind.Function,
    "rule": Kind.Method, "heuristic": Kind.Constant, "scene": Kind.Module, "variable": Kind.Variable,
    "object": Kind.Variable, "effector": Kind.Field, "joint": Kind.Property,
}  # fmt: skip


_FOLDER = re.compile(r'^import[ \t]+"((?:[^"\n]*/)?)[^"/\n]*$', re.MULTILINE)
"""The folders of a path that is being written."""
_LETTERS = ("x", "y", "z")


def completion(documents: Documents, uri: str, position: types.Position) -> types.CompletionList:
    source = documents.source(uri)
    offset = documents.places(source).offset(position)
    context = context_at(source, offset)
    found: dict[str, Item] = {}
    folder = _FOLDER.search(source.text[:offset])
    if folder is not None:
        return types.CompletionList(False, list(_paths(source, folder[1])))
    for item in _Completion(documents.naming(uri), source, context, offset).items():
        found.setdefault(item.label, item)
    return types.CompletionList(False, list(found.values()))


class _Completion:
    def __init__(self, naming: Naming, source: Source, context: Context, offset: int) -> None:
        self.naming = naming
        self.source = source
        self.context = context
        self.offset = offset

    def items(self) -> Iterator[Item]:
        last = self.context.last()
        head = self.context.declaration[0]
        if head == "import" or last == "import":
            yield from self._imports()
        elif last == ".":
            yield from self._attributes()
        elif self.context.block() == "options":
            yield from self._options()
        elif self._letter():
            yield from (_plain(letter, Kind.EnumMember, f"the axis {letter}") for letter in _LETTERS)
        else:
            yield from self._arguments(last)
            yield from self._names(last)
            if not self._names_a_type(last):
                yield from self._words()

    # --- arguments -----------------------------------------------------------------------------------------------

    def _letter(self) -> bool:
        """Whether an axis is written, as in `revolute(y)` and `axis(X, z)`."""
        use = self.context.use
        if use is None or use.kind != "function" or self.context.last() not in ("(", ","):
            return False
        known = FUNCTIONS.get(use.name)
        wanted = known.overloads[0][use.argument : use.argument + 1] if known is not None else ()
        return use.name in JOINTS or tuple(wanted) == ("letter",)

    def _arguments(self, last: str) -> Iterator[Item]:
        """Parameters that may be given by name."""
        use = self.context.use
        if use is not None and use.kind in ("scene", "heuristic", "module") and last in ("(", ","):
            for name, kind in parameters_of(self.naming, use.kind, use.name):
                yield _plain(f"{name} =", Kind.Field, kind, f"{name} = $0")

    def _names_a_type(self, last: str) -> bool:
        """Whether only a type may stand here: behind the colon of a parameter, or as the parent of a type."""
        head = self.context.declaration[0]
        in_brackets = bool(self.context.opened) and self.context.before[self.context.opened[-1]] != "{"
        return (head == "type" and last == "<") or (
            last == ":" and in_brackets and head not in ("scene", "task", "module")
        )

    # --- names by what stands before -----------------------------------------------------------------------------

    def _names(self, last: str) -> Iterator[Item]:
        context, head = self.context, self.context.declaration[0]
        innermost = context.last(len(context.before) - context.opened[-1]) if context.opened else ""
        starts = bool(context.opened) and len(context.before) - 1 == context.opened[-1]
        if last == "is" or (
            head == "heuristic" and innermost == "{" and "NAME" in context.expected and not self._value()
        ):
            yield from self._rules()
        elif last == "scene":
            yield from self._calls("scene")
        elif last == "guide":
            yield from self._calls("heuristic")
        elif last == "of":
            yield from self._types(modules=True)
        elif last == "by" and context.last(2) != "disturb":
            yield from self._declared("predicate")
        elif starts and innermost == "[" and context.last(2) != "" and not self._indexed():
            yield from self._declared("motion")
        elif starts and innermost == "(" and not self._called():
            yield from self._declared("predicate")
            yield from self._values() if self._value() else ()
        elif last in (":", "<") or (last == "in" and "NAME" in context.expected):
            yield from self._behind_colon(head)
        elif head in ("scene", "task") and "_GOAL" in context.expected and innermost == "{":
            yield from self._types(modules=True)
            yield from self._types(modules=False)
        elif self._value() or (context.use is not None and "NAME" in context.expected):
            yield from self._values()

    def _behind_colon(self, head: str) -> Iterator[Item]:
        braces = [i for i in self.context.opened if self.context.before[i] == "{"]
        in_parameters = bool(self.context.opened) and self.context.before[self.context.opened[-1]] == "("
        if in_parameters and head in ("scene", "task", "module") and not braces:
            yield from (_plain(t, Kind.TypeParameter, TYPES[t]) for t in VALUE_TYPE_NAMES)
            return
        if in_parameters and head == "function" and not braces:
            yield from (_plain(t, Kind.TypeParameter, TYPES[t]) for t in VALUE_TYPE_NAMES)
        line = [str(t) for t in self.context.before if t.line == self.context.before[-1].line]
        if "fail" in line:
            yield from (_plain(w, Kind.EnumMember) for w in BreakdownKind)
        elif "joint" in line:
            yield from (_plain(w, Kind.EnumMember, d) for w, d in JOINTS.items())
        elif head in ("scene", "task", "module") and "for" not in line and "exists" not in line:
            yield from (_plain(w, Kind.Struct, d, f"{w}($1)") for w, d in SHAPES.items())
            yield from self._parts(line[0] if line else "")
            if line[:1] == ["effector"]:
                yield from self._types(modules=False)
        else:
            yield from self._types(modules=False)
            yield from self._types(modules=True)
            yield _plain("chain", Kind.Keyword, WORDS["chain"].doc, "chain of ${1:module} by ${2:connected}")

    def _parts(self, module: str) -> Iterator[Item]:
        """The effectors of a module type, as in `crawler c: A on ground`."""
        yield from (_named(p, f"{p.definition.mention.name} on $1") for p in self.naming.of_home("effector", module))

    def _types(self, modules: bool) -> Iterator[Item]:
        for place in self.naming.definitions(["type"]):
            if (place.definition.what == "module") == modules:
                yield _named(place)
        for name in ("module",) if modules else ("object", "effector"):
            yield _plain(name, Kind.Interface, TYPES[name])

    def _declared(self, kind: str) -> Iterator[Item]:
        for place in self.naming.definitions([kind]):
            name = place.definition.mention.name
            names = [n for n, _ in parameters_of(self.naming, kind, name)]
            yield _named(place, _with_arguments(name, names, " ", " ", ""))

    def _calls(self, kind: str) -> Iterator[Item]:
        for place in self.naming.definitions([kind]):
            name = place.definition.mention.name
            names = [n for n, _ in parameters_of(self.naming, kind, name)]
            yield _named(place, _with_arguments(name, names, "(", ", ", ")"))

    def _rules(self) -> Iterator[Item]:
        for place in self.naming.definitions(["rule"]):
            name = place.definition.mention.name
            if self.context.last() == "is":
                yield _named(place)
            else:
                names = ", ".join(n for n, _ in parameters_of(self.naming, "rule", name))
                yield _named(place, f"{name}({names}): $0")

    def _values(self) -> Iterator[Item]:
        head, name = self.context.declaration
        for place in self._variables():
            yield _named(place)
        yield from self._parameters_written()
        if head in ("scene", "task"):
            yield from (_named(place) for place in self.naming.things(name))
        if head == "module":
            yield from (_named(place) for place in self.naming.of_home("effector", name))
        wanted = {"motion": "motion", "scene": "scene", "task": "scene", "module": "scene"}.get(head, "rule")
        for function, made in FUNCTIONS.items():
            if wanted in made.place or head == "function":
                yield _plain(function, Kind.Function, made.doc, f"{function}($1)")
        yield from self._calls("function")

    def _variables(self) -> Iterator[Place]:
        """The variables of this declaration that are bound before the place."""
        start = self.context.before[0].start_pos or 0 if self.context.before else 0
        begin = (
            self.source.text.rfind(str(self.context.before[0]), 0, self.offset - start) if self.context.before else 0
        )
        file = self.naming.files[self.source.path]
        for definition in file.definitions:
            mention = definition.mention
            if mention.kind == "variable" and begin <= mention.start < self.offset and self._inside(mention.home):
                yield Place(self.source, definition)

    def _parameters_written(self) -> Iterator[Item]:
        """The parameters in the head of a declaration that is not whole yet, of which no mention is known."""
        waiting: list[str] = []
        before = self.context.before
        for index, token in enumerate(before[:-1]):
            if token in ("{", "="):
                return
            if token.type == "NAME" and before[index - 1] != ":":
                waiting.append(str(token))
            elif token == ":":
                head = self.context.declaration[1]
                names = [n for n in waiting if n != head]
                yield from (_plain(n, Kind.Variable, f"of type {before[index + 1]}") for n in names)
                waiting = []

    def _inside(self, home: str) -> bool:
        return home.startswith("@") or home.endswith(f" {self.context.declaration[1]}")

    # --- what is known of the place ------------------------------------------------------------------------------

    def _value(self) -> bool:
        return {"NUMBER", "LPAR", "NAME"} <= self.context.expected

    def _called(self) -> bool:
        place = self.context.opened[-1]
        return place > 0 and self.context.before[place - 1].type == "NAME"

    def _indexed(self) -> bool:
        before = self.context.before[self.context.opened[-1] - 1]
        return before.type == "NAME" or before == "]"

    # --- words, imports, attributes, options ---------------------------------------------------------------------

    def _words(self) -> Iterator[Item]:
        expected = {t.lstrip("_").lower() for t in self.context.expected}
        at_top = "_TASK" in self.context.expected and "_GOAL" not in self.context.expected
        for word, told in WORDS.items():
            terminal = word.lower() in expected or (word in ("min", "max", "sum") and "aggregate" in expected)
            if terminal:
                snippet = DECLARATIONS.get(word) if at_top else ITEMS.get(word)
                yield _plain(word, Kind.Snippet if snippet else Kind.Keyword, told.doc, snippet)

    def _imports(self) -> Iterator[Item]:
        names = neighbours(STANDARD_FOLDER / "any")
        inside = self.context.last() == "."
        for name in names:
            label = name if inside else f"std.{name}"
            yield _plain(label, Kind.Module, f"std.{name} of the standard library")
        if not inside:
            own = on_disk(self.source.path)
            for name in neighbours(own):
                if name != own.stem:
                    yield _plain(f'"{name}.tamp"', Kind.File, "a file beside this one")

    def _attributes(self) -> Iterator[Item]:
        base = _base(self.context)
        things = self.naming.things(self.context.declaration[1])
        robots = [t.definition.type for t in things if t.definition.mention.name == base]
        if robots:
            yield from (_named(p) for p in self.naming.of_home("effector", robots[0]))
        else:
            names = ("in", "out") if self.context.last(2) == "]" else ("first", "last")
            yield from (_plain(n, Kind.Property, ATTRIBUTES[n]) for n in names)

    def _options(self) -> Iterator[Item]:
        options = given_at("task")
        starts = max(i for i, t in enumerate(self.context.before) if t in ("{", ","))
        name = str(self.context.before[starts + 1]) if starts + 1 < len(self.context.before) else ""
        if name in OPTIONS and OPTIONS[name].kind == "objective" and self.context.last() in ("=", "+", "*"):
            yield from (_plain(m, Kind.EnumMember, unit and f"in {unit}") for m, unit in MEASURES.items())
        elif self.context.last() == "=" and self.context.last(2) in OPTIONS:
            choices = OPTIONS[self.context.last(2)].choices
            yield from (_plain(c.replace("-", "_"), Kind.EnumMember) for c in choices)
        elif self.context.last() in ("{", ","):
            for name, option in options.items():
                yield _plain(name, Kind.Property, option.help, f"{name} = $0")


def _paths(source: Source, folder: str) -> Iterator[Item]:
    """Programs and folders behind the folders `folder` of an import's path."""
    own = on_disk(source.path)
    here = own.parent / folder
    for name in neighbours(here / "any"):
        if here / name != own.with_suffix(""):
            yield _plain(f"{name}{EXTENSION}", Kind.File, "a program")
    with suppress(OSError):
        for inside in sorted(here.iterdir()):
            if inside.is_dir() and not inside.name.startswith(".") and neighbours(inside / "any"):
                yield _plain(f"{inside.name}/", Kind.Folder, "a folder of programs")


def _base(context: Context) -> str:
    """The name before the point, without its indices."""
    depth = 0
    for token in reversed(context.before[:-1]):
        depth += (token == "]") - (token == "[")
        if depth == 0 and token.type == "NAME":
            return str(token)
    return ""


def _with_arguments(name: str, names: Iterable[str], opening: str, between: str, closing: str) -> str:
    slots = between.join(f"${{{i}:{n}}}" for i, n in enumerate(names, 1))
    return f"{name}{opening}{slots}{closing}" if slots or closing else name


def _named(place: Place, snippet: str | None = None) -> Item:
    mention = place.definition.mention
    item = _plain(mention.name, KINDS[mention.kind], "", snippet)
    item.detail = (
        f"{place.definition.what}: {place.definition.type}" if place.definition.type else place.definition.what
    )
    item.documentation = types.MarkupContent(types.MarkupKind.Markdown, described(place))
    return item


def _plain(label: str, kind: Kind, doc: str = "", snippet: str | None = None) -> Item:
    item = Item(label, kind=kind, detail=doc or None)
    if snippet is not None:
        item.insert_text, item.insert_text_format = snippet, types.InsertTextFormat.Snippet
    return item
