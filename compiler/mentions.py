"""Every name of a text with what it stands for, for editors: read from the grammar's own tree, so that each has its
exact place, also in a text with mistakes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import field
from functools import lru_cache

from lark import Token, Tree

from ..langs.build_terms import Branch, Child
from ..langs.frozen import dataclass
from ..langs.parser import parse_tokens
from ..langs.source import PLACEHOLDER, Source


@dataclass(frozen=True, slots=True)
class Mention:
    """The characters `start` to `end` of a text are the name of something. `kind` is one of type, predicate, motion,
    function, rule, heuristic, scene, task, variable, object, effector, joint, attribute, option, word, import. `home`
    is what it belongs to: for a parameter the declaration, as in `scene stairs`, for another variable its place, for
    an object the scene or task, for an effector or joint the module, for an attribute what stands before the point."""

    kind: str
    name: str
    start: int
    end: int
    home: str = ""
    defines: bool = False


@dataclass(frozen=True, slots=True)
class Definition:
    """What a name is declared as: `what` in the words of the language, the place of the name, the stretch of the whole
    statement, its `type` (of a variable, object or effector), and its `##` text."""

    mention: Mention
    what: str
    start: int
    end: int
    type: str = ""
    doc: str = ""


@dataclass(slots=True)
class Mentions:
    """All of one text. `uses` tells which scenes a scene or task takes over."""

    source: Source
    all: list[Mention] = field(default_factory=list)
    definitions: list[Definition] = field(default_factory=list)
    uses: dict[str, list[str]] = field(default_factory=dict)

    def at(self, offset: int) -> Mention | None:
        """The name that holds the character at `offset`, or ends there."""
        return next((m for m in self.all if m.start <= offset <= m.end), None)


GLOBAL = {
    "type_decl": ("type", "type"),
    "predicate_decl": ("predicate", "predicate"),
    "derived_decl": ("predicate", "derived predicate"),
    "function_decl": ("function", "function"),
    "motion_decl": ("motion", "motion predicate"),
    "rule_decl": ("rule", "rule"),
    "heuristic_decl": ("heuristic", "heuristic"),
    "module_decl": ("type", "module"),
    "scene_decl": ("scene", "scene"),
    "task_decl": ("task", "task"),
}
"""For every declaration with a name: the kind of the name, and what is declared."""
_SCOPES = {"exists", "forall", "aggregate", "motion_for", "effect_for", "for_item"}


@lru_cache(maxsize=64)
def mentions_of(source: Source) -> Mentions:
    """The mentions of a text."""
    tree, _ = parse_tokens(source)
    reader = _Reader(source)
    for branch in tree.children:
        reader.read(branch)
    reader.found.all.sort(key=lambda m: m.start)
    return reader.found


class _Reader:
    def __init__(self, source: Source) -> None:
        self.found = Mentions(source)
        self._lines = source.text.split("\n")
        self._scopes: list[dict[str, str]] = []
        self._declared = ""
        self._kind = ""
        self._effectors: set[str] = set()
        self._joints: set[str] = set()
        self._special: dict[str, Callable[[Branch], None]] = {
            "import": self._import, "placement_decl": self._placement, "parameter": self._variables,
            "binder": self._variables, "single": self._variables, "named_type": self._types,
            "chain_type": self._chain, "logic_literal": self._literal, "motion_literal": self._literal,
            "name": self._name, "attribute": self._attribute, "call": self._call, "heuristic_case": self._case,
            "previous": self._previous, "flag": self._flag, "effector_item": self._effector,
            "joint_item": self._joint, "body_item": self._body, "robot_on": self._robot, "robot_at": self._robot,
            "scene_use": self._use, "guide_use": self._use, "option": self._option,
            "breakdown_item": self._breakdown, "holds": self._holds, "coupling_item": self._coupling,
        }  # fmt: skip

    def read(self, node: Child) -> None:
        if not isinstance(node, Tree):
            return
        kind = str(node.data)
        if kind in GLOBAL:
            self._declaration(node, *GLOBAL[kind])
        elif kind in _SCOPES:
            with self._scope():
                self._inside(node.children)
        else:
            self._special.get(kind, self._plain)(node)

    def _plain(self, tree: Branch) -> None:
        self._inside(tree.children)

    def _inside(self, nodes: Iterable[Child]) -> None:
        for node in nodes:
            self.read(node)

    # --- what is noted -------------------------------------------------------------------------------------------

    def _note(self, kind: str, token: Token, home: str = "", defines: bool = False) -> Mention:
        start = token.start_pos or 0
        mention = Mention(kind, str(token), start, token.end_pos or start, home, defines)
        if mention.name != PLACEHOLDER:
            self.found.all.append(mention)
        return mention

    def _define(self, kind: str, token: Token, tree: Branch, what: str, home: str = "", type: str = "") -> None:
        mention = self._note(kind, token, home, True)
        if mention.name == PLACEHOLDER:
            return
        meta = tree.meta
        doc = self._doc(meta.line) if home == "" else ""
        self.found.definitions.append(Definition(mention, what, meta.start_pos, meta.end_pos, type, doc))

    def _doc(self, line: int) -> str:
        found: list[str] = []
        above = line - 2
        while above >= 0 and self._lines[above].lstrip().startswith("##"):
            found.append(self._lines[above].strip().lstrip("#").strip())
            above -= 1
        return "\n".join(reversed(found))

    @contextmanager
    def _scope(self) -> Iterator[None]:
        self._scopes.append({})
        yield
        self._scopes.pop()

    # --- declarations --------------------------------------------------------------------------------------------

    def _declaration(self, tree: Branch, kind: str, what: str) -> None:
        name = _first_name(tree)
        if name is None:
            return
        self._define(kind, name, tree, what)
        self._declared, self._kind = str(name), what
        self._effectors = {str(_first_name(e)) for e in tree.find_data("effector_item")}
        self._joints = {str(_first_name(j)) for j in tree.find_data("joint_item")}
        with self._scope():
            if what == "type" and len(tree.children) > 1 and isinstance(tree.children[1], Token):
                self._note("type", tree.children[1])
            self._inside(tree.children)
            self._bearer(tree)
        self._declared = self._kind = ""
        self._effectors, self._joints = set(), set()

    def _bearer(self, tree: Branch) -> None:
        """The manner behind `borne` of a motion predicate."""
        names = [c for c in tree.children if isinstance(c, Token) and c.type == "NAME"]
        if tree.data == "motion_decl" and len(names) > 1:
            self._note("word", names[-1])

    def _placement(self, tree: Branch) -> None:
        with self._scope():
            self._inside(tree.children)

    def _import(self, tree: Branch) -> None:
        words = [c for c in tree.children if isinstance(c, Token)]
        start, end = words[0].start_pos or 0, words[-1].end_pos or 0
        name = self.found.source.text[start:end]
        self.found.all.append(Mention("import", name, start, end))

    def _variables(self, tree: Branch) -> None:
        """Parameters of a declaration belong to it; other variables are told apart by where they are bound."""
        names = [c for c in tree.children if isinstance(c, Token) and c.type == "NAME"]
        rest = [c for c in tree.children if isinstance(c, Tree)]
        self._inside(rest)
        type = ""
        if rest:
            type = self.found.source.text[rest[0].meta.start_pos : rest[0].meta.end_pos]
        outer = len(self._scopes) == 1 and tree.data == "parameter" and bool(self._declared)
        for name in names:
            home = f"{self._kind} {self._declared}" if outer else f"@{name.start_pos}"
            if self._scopes:
                self._scopes[-1][str(name)] = home
            what = "parameter" if outer else "variable"
            self._define("variable", name, tree, what, home, type)

    def _types(self, tree: Branch) -> None:
        self._note("type", _token(tree, 0))

    def _chain(self, tree: Branch) -> None:
        self._note("type", _token(tree, 0))
        self._note("predicate", _token(tree, 1))

    def _flag(self, tree: Branch) -> None:
        for token in tree.children:
            if isinstance(token, Token) and token.type == "NAME":
                self._variable(token)

    # --- conditions and values -----------------------------------------------------------------------------------

    def _literal(self, tree: Branch) -> None:
        self._note("predicate" if tree.data == "logic_literal" else "motion", _token(tree, 0))
        self._inside(tree.children[1:])

    def _name(self, tree: Branch) -> None:
        self._variable(_token(tree, 0))

    def _variable(self, token: Token) -> None:
        name = str(token)
        for scope in reversed(self._scopes):
            if name in scope:
                self._note("variable", token, scope[name])
                return
        if name in self._effectors:
            self._note("effector", token, self._declared)
        elif name in self._joints:
            self._note("joint", token, self._declared)
        elif self._kind in ("scene", "task"):
            self._note("object", token, self._declared)
        else:
            self._note("word", token)

    def _attribute(self, tree: Branch) -> None:
        base = tree.children[0]
        self.read(base)
        name = _base(base)
        known = any(name in scope for scope in self._scopes)
        home = "" if known or self._kind not in ("scene", "task") else f"{self._declared} {name}"
        self._note("attribute", _token(tree, 1), home)

    def _call(self, tree: Branch) -> None:
        self._note("function", _token(tree, 0))
        self._inside(tree.children[1:])

    def _case(self, tree: Branch) -> None:
        rule, *names = [c for c in tree.children if isinstance(c, Token)]
        self._note("rule", rule)
        with self._scope():
            for name in names:
                self._scopes[-1][str(name)] = f"@{name.start_pos}"
                self._define("variable", name, tree, "variable", f"@{name.start_pos}")
            self._inside(tree.children)

    def _previous(self, tree: Branch) -> None:
        self._note("rule", _token(tree, 0))
        self._inside(tree.children[1:])

    # --- modules and scenes --------------------------------------------------------------------------------------

    def _effector(self, tree: Branch) -> None:
        type = ""
        if len(tree.children) > 1 and isinstance(tree.children[1], Token) and tree.children[1].type == "NAME":
            type = str(self._note("type", tree.children[1]).name)
        self._define("effector", _token(tree, 0), tree, "effector", self._declared, type or "effector")
        self._inside(tree.children[2:])

    def _joint(self, tree: Branch) -> None:
        self._define("joint", _token(tree, 0), tree, "joint", self._declared)
        self._inside(tree.children[1:])

    def _coupling(self, tree: Branch) -> None:
        self._note("joint", _token(tree, 0), self._declared)
        self._inside(tree.children[1:])

    def _holds(self, tree: Branch) -> None:
        self._note("word", _token(tree, 0))
        self._inside(tree.children[1:])

    def _body(self, tree: Branch) -> None:
        self._thing(tree, tree.children[1], str(_token(tree, 0)), "body")
        self._inside(tree.children[2:])

    def _robot(self, tree: Branch) -> None:
        type = str(_token(tree, 0))
        self._arguments(tree.children[1], f"module {type}")
        self._thing(tree, tree.children[2], type, "robot")
        for child in tree.children[3:]:
            if isinstance(child, Token):
                self._note("effector", child, type)
            else:
                self.read(child)

    def _thing(self, tree: Branch, reference: Child, type: str, what: str) -> None:
        """`plate[i]` among the items of a scene: its name is declared, its indices are read."""
        self._note("type", _token(tree, 0))
        while isinstance(reference, Tree) and reference.data == "index":
            self._inside(reference.children[1:])
            reference = reference.children[0]
        if isinstance(reference, Tree) and reference.data == "name":
            self._define("object", _token(reference, 0), tree, what, self._declared, type)

    def _use(self, tree: Branch) -> None:
        kind = "scene" if tree.data == "scene_use" else "heuristic"
        name = self._note(kind, _token(tree, 0)).name
        if kind == "scene":
            self.found.uses.setdefault(self._declared, []).append(name)
        self._arguments(tree.children[1], f"{kind} {name}")

    def _arguments(self, node: Child, home: str) -> None:
        for argument in node.children if isinstance(node, Tree) else ():
            if isinstance(argument, Tree):
                if argument.data == "named":
                    self._note("variable", _token(argument, 0), home)
                self._inside(argument.children)

    def _option(self, tree: Branch) -> None:
        self._note("option", _token(tree, 0))
        value = tree.children[1]
        if isinstance(value, Tree) and value.data == "name":
            self._note("word", _token(value, 0))
        else:
            self.read(value)

    def _breakdown(self, tree: Branch) -> None:
        self._inside(tree.children)
        for child in tree.children:
            if isinstance(child, Token) and child.type == "NAME":
                self._note("word", child)


def _first_name(tree: Branch) -> Token | None:
    return next((c for c in tree.children if isinstance(c, Token) and c.type == "NAME"), None)


def _token(tree: Branch, index: int) -> Token:
    token = tree.children[index]
    assert isinstance(token, Token)
    return token


def _base(node: Child) -> str:
    """The name that an element or attribute begins with."""
    while isinstance(node, Tree) and node.children:
        node = node.children[0]
    return str(node) if isinstance(node, Token) else ""
