"""The declarations of a PDDL domain and problem: sections, types, objects, predicates and functions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field

from ...langs.diagnostics import did_you_mean
from ...langs.frozen import dataclass
from .nodes import Faults, Group, Node, Token

ROOT = "object"
KNOWN_REQUIREMENTS = (
    ":strips", ":typing", ":negative-preconditions", ":disjunctive-preconditions", ":equality",
    ":existential-preconditions", ":universal-preconditions", ":quantified-preconditions", ":conditional-effects",
    ":adl", ":derived-predicates", ":domain-axioms", ":action-costs", ":fluents", ":numeric-fluents",
)  # fmt: skip
"""`:fluents` is what older files say for action costs; other numbers are refused where they stand."""
REFUSED_REQUIREMENTS = (
    ":durative-actions", ":duration-inequalities", ":continuous-effects", ":timed-initial-literals", ":timed-effects",
    ":time", ":preferences", ":constraints", ":object-fluents", ":ucpop", ":safety-constraints", ":hierarchy",
    ":method-preconditions", ":multi-agent", ":unfactored-privacy", ":factored-privacy", ":action-expansions",
    ":probabilistic-effects", ":mdp", ":rewards", ":non-deterministic", ":open-world", ":foreach-expansions",
    ":dag-expansions", ":expression-evaluation", ":true-negation", ":contingent", ":full-observability", ":processes",
    ":events",
)  # fmt: skip
DOMAIN_SECTIONS = (
    ":requirements", ":types", ":constants", ":predicates", ":functions", ":action", ":derived", ":axiom",
    ":durative-action", ":constraints", ":process", ":event", ":method", ":task", ":observe",
)  # fmt: skip
PROBLEM_SECTIONS = (
    ":domain", ":requirements", ":objects", ":init", ":goal", ":metric", ":constraints", ":length", ":htn",
    ":goal-reward",
)  # fmt: skip
TRANSLATED = {
    ":requirements", ":types", ":constants", ":predicates", ":functions", ":action", ":derived", ":domain", ":objects",
    ":init", ":goal", ":metric", ":length",
}  # fmt: skip
MANY = (":action", ":derived")


@dataclass(frozen=True, slots=True)
class TypedWord:
    """A name and the types that it may have: more than one only behind `either`."""

    word: Token
    types: tuple[str, ...]

    @property
    def name(self) -> str:
        return self.word.text


@dataclass(slots=True)
class PddlFile:
    """One `(define …)`: its name and sections in order."""

    faults: Faults
    whole: Group
    kind: str
    name: str
    sections: dict[str, list[Group]] = field(default_factory=dict)

    def the(self, section: str) -> Group | None:
        """The section, of those that there is one of."""
        return next(iter(self.sections.get(section, ())), None)


@dataclass(slots=True)
class Tables:
    """What a domain and a problem declare. `parents` holds for each type the one above; `objects` their type;
    `predicates` the types of their parameters. `unions` are the types, and `loose` the objects, that are of `either`
    of several: above them is what lies above all of these."""

    parents: dict[str, str] = field(default_factory=dict)
    unions: dict[str, tuple[str, ...]] = field(default_factory=dict)
    loose: dict[str, tuple[str, ...]] = field(default_factory=dict)
    objects: dict[str, str] = field(default_factory=dict)
    constants: list[str] = field(default_factory=list)
    predicates: dict[str, list[str]] = field(default_factory=dict)
    functions: dict[str, list[str]] = field(default_factory=dict)

    def above(self, name: str) -> Iterator[str]:
        """A type and those above it, up to the root."""
        while name != ROOT:
            yield name
            name = self.parents.get(name, ROOT)
        yield ROOT

    def common(self, names: Sequence[str]) -> str:
        """The lowest type that is all of them, or above them."""
        first, *others = names
        return next(t for t in self.above(first) if all(t in self.above(o) for o in others))

    def within(self, name: str, kinds: Sequence[str]) -> bool:
        """Whether whatever is of a type is of one of `kinds`."""
        if name == ROOT or name in kinds or ROOT in kinds:
            return name in kinds or ROOT in kinds
        union = self.unions.get(name)
        if union is not None and all(self.within(one, kinds) for one in union):
            return True
        return self.within(self.parents.get(name, ROOT), kinds)

    def members(self, kinds: Sequence[str]) -> list[str]:
        """The objects that are of one of `kinds`."""
        return [
            name for name, kind in self.objects.items()
            if all(self.within(one, kinds) for one in self.loose.get(name, (kind,)))
        ]  # fmt: skip


def pddl_file(faults: Faults, groups: Sequence[Group]) -> PddlFile:
    """The one definition of a file, whose sections are known ones. Raises SourceError (E0019, E0020, E0022)."""
    if not groups:
        faults.tell("E0019", Group(0), "the file defines nothing", "it begins with `(define (domain NAME)`")
        faults.end()
    whole = groups[0]
    heads = [g for g in whole.groups() if g.head in ("domain", "problem") and len(g.items) == 2]
    if whole.head != "define" or not heads or len(whole.items) < 2 or whole.items[1] is not heads[0]:
        faults.tell("E0019", whole, "this is no PDDL: `(define (domain NAME)` or `(define (problem NAME)` begins it")
        faults.end()
    for other in groups[1:]:
        faults.tell("E0019", other, "a file holds one `(define …)`", "import a domain and a problem of a file each")
    name = heads[0].items[1]
    made = PddlFile(faults, whole, heads[0].head, name.text if isinstance(name, Token) else "task")
    known = DOMAIN_SECTIONS if made.kind == "domain" else PROBLEM_SECTIONS
    for section in whole.items[2:]:
        _sort(made, section, known)
    if made.kind == "problem" and made.the(":goal") is None:
        faults.tell("E0022", whole, "the problem has no `:goal`")
    return made


def _sort(made: PddlFile, section: Node, known: Sequence[str]) -> None:
    """Put a section where it belongs."""
    if isinstance(section, Token) or not section.head:
        made.faults.tell("E0019", section, "expected a section in brackets, such as `(:action …)`")
    elif section.head not in known:
        made.faults.tell(
            "E0022", section, f"a {made.kind} has no section `{section.head}`", did_you_mean(section.head, known)
        )
    elif section.head not in TRANSLATED:
        made.faults.tell("E0020", section, f"`{section.head}` has no counterpart here, so it cannot be imported")
    elif section.head in made.sections and section.head not in MANY:
        made.faults.tell("E0022", section, f"there is a second `{section.head}`")
    else:
        made.sections.setdefault(section.head, []).append(section)


def check_requirements(file: PddlFile) -> None:
    """Tell which requirements cannot be met."""
    section = file.the(":requirements")
    for item in section.rest if section is not None else ():
        if isinstance(item, Group):
            file.faults.tell("E0019", item, "a requirement is a word such as `:strips`")
        elif item.text in REFUSED_REQUIREMENTS:
            file.faults.tell("E0020", item, f"`{item.text}` has no counterpart here, so it cannot be imported")
        elif item.text not in KNOWN_REQUIREMENTS:
            known = (*KNOWN_REQUIREMENTS, *REFUSED_REQUIREMENTS)
            file.faults.tell("E0022", item, f"unknown requirement `{item.text}`", did_you_mean(item.text, known))


def typed(faults: Faults, items: Sequence[Node], variables: bool = False) -> list[TypedWord]:
    """The names of a list such as `a b - t c`, or `?a ?b - t`; those without a type are of the root."""
    made: list[TypedWord] = []
    waiting: list[Token] = []
    rest = list(items)
    while rest:
        item = rest.pop(0)
        if isinstance(item, Group):
            faults.tell("E0019", item, "expected a name", "a type stands behind `-`")
        elif item.text != "-":
            if item.text.startswith("?") != variables or item.text == "?":
                wanted = "a variable, which begins with `?`" if variables else "a name without `?`"
                faults.tell("E0019", item, f"expected {wanted}, not `{item.text}`")
            else:
                waiting.append(item)
        elif not rest:
            faults.tell("E0019", item, "a type is missing behind `-`")
        else:
            kinds = _types(faults, rest.pop(0))
            made += [TypedWord(word, kinds) for word in waiting]
            waiting = []
    return made + [TypedWord(word, (ROOT,)) for word in waiting]


def _types(faults: Faults, node: Node) -> tuple[str, ...]:
    if isinstance(node, Token):
        return (node.text,)
    names = tuple(item.text for item in node.rest if isinstance(item, Token))
    if node.head != "either" or not names or len(names) != len(node.rest):
        faults.tell("E0019", node, "expected a type, or `(either TYPE TYPE)`")
        return (ROOT,)
    return names


def read_tables(domain: PddlFile, problem: PddlFile) -> Tables:
    """All declarations of both files; what is wrong with them is told."""
    tables = Tables()
    _read_types(tables, domain)
    for file, section in ((domain, ":constants"), (problem, ":objects")):
        group = file.the(section)
        for item in typed(file.faults, group.rest) if group is not None else ():
            if item.name in tables.objects:
                file.faults.tell("E0022", item.word, f"there are two objects `{item.name}`")
            tables.objects[item.name] = known_type(tables, file.faults, item)
            if len(item.types) > 1:
                tables.loose[item.name] = item.types
    constants = domain.the(":constants")
    tables.constants = [i.name for i in typed(domain.faults, constants.rest)] if constants is not None else []
    _read_signatures(tables, domain, ":predicates", tables.predicates)
    _read_signatures(tables, domain, ":functions", tables.functions)
    return tables


def known_type(tables: Tables, faults: Faults, item: TypedWord) -> str:
    """The lowest type above all that a name may have; types that nothing declares are told."""
    for name in item.types:
        if name != ROOT and name not in tables.parents:
            faults.tell("E0022", item.word, f"`{item.name}` has the unknown type `{name}`",
                        did_you_mean(name, tables.parents))  # fmt: skip
    return tables.common([name if name in tables.parents else ROOT for name in item.types])


def _read_types(tables: Tables, domain: PddlFile) -> None:
    section = domain.the(":types")
    listed = typed(domain.faults, section.rest) if section is not None else []
    declared = [item for item in listed if item.name != ROOT]
    given: dict[str, tuple[str, ...]] = {}
    for item in declared:
        if given.setdefault(item.name, item.types) != item.types:
            one, other = (" or ".join(f"`{t}`" for t in types) for types in (given[item.name], item.types))
            domain.faults.tell("E0022", item.word, f"type `{item.name}` lies below {one} and {other}: here, it has one "
                               "above")  # fmt: skip
    for item in declared:
        for above in item.types:
            if above != ROOT:
                given.setdefault(above, (ROOT,))
    for item in declared:
        if item.name in _reached(item.name, given):
            domain.faults.tell("E0022", item.word, f"type `{item.name}` lies below itself")
    domain.faults.end()
    tables.unions = {name: types for name, types in given.items() if len(types) > 1}
    tables.parents = {name: types[0] for name, types in given.items()}
    unions = sorted(tables.unions, key=lambda name: len(_reached(name, given)))
    for name in unions:
        tables.parents[name] = tables.common(given[name])


def _reached(name: str, given: Mapping[str, Sequence[str]]) -> set[str]:
    """All types above one, by whatever way."""
    found: set[str] = set()
    waiting = list(given.get(name, ()))
    while waiting:
        above = waiting.pop()
        if above not in found:
            found.add(above)
            waiting += given.get(above, ())
    return found


def _read_signatures(tables: Tables, domain: PddlFile, section: str, into: dict[str, list[str]]) -> None:
    """Predicates, or functions, which may have a type `number` behind them."""
    whole = domain.the(section)
    items = [] if whole is None else whole.rest
    for index, node in enumerate(items):
        if isinstance(node, Token):
            before = [n for n in items[:index][-1:] if isinstance(n, Token)]
            if section == ":functions" and (node.text == "-" or (node.text == "number" and before)):
                continue
            if section == ":functions" and before and before[0].text == "-":
                domain.faults.tell("E0020", node, f"functions with values of type `{node.text}` have no counterpart")
                continue
        if isinstance(node, Token) or not node.head:
            domain.faults.tell("E0019", node, "expected a name with parameters in brackets, such as `(at ?x - ball)`")
            continue
        if node.head in tables.predicates or node.head in tables.functions:
            domain.faults.tell("E0022", node, f"`{node.head}` is declared twice")
        parameters = typed(domain.faults, node.rest, variables=True)
        into[node.head] = [known_type(tables, domain.faults, p) for p in parameters]


def parts_of(faults: Faults, group: Group, known: Sequence[str], skip: int) -> dict[str, Node]:
    """What follows each keyword of an action, behind its first `skip` items."""
    made: dict[str, Node] = {}
    rest = group.items[skip:]
    while rest:
        key = rest.pop(0)
        if not isinstance(key, Token) or not key.text.startswith(":"):
            faults.tell("E0019", key, f"expected {', '.join(f'`{k}`' for k in known)} here")
            continue
        value = None if not rest or _is_key(rest[0]) else rest.pop(0)
        if key.text not in known:
            faults.tell("E0022", key, f"unknown part `{key.text}`", did_you_mean(key.text, known))
        elif value is None:
            faults.tell("E0019", key, f"nothing follows `{key.text}`")
        elif key.text in made:
            faults.tell("E0022", key, f"there is a second `{key.text}`")
        else:
            made[key.text] = value
    return made


def _is_key(node: Node) -> bool:
    return isinstance(node, Token) and node.text.startswith(":")
