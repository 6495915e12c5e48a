"""Import of PDDL: a domain and a problem as one task, whose objects are small things in rows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import field
from typing import TypeGuard

from ...langs.diagnostics import Diagnostic, SourceError
from ...langs.frozen import dataclass
from ...langs.source import Source
from .faults import FaultList
from .names import plain_name
from .nodes import Faults, Group, Node, Token, read_groups
from .pddl_costs import Costs, check_metric
from .pddl_formulas import NUMBER, Formulas, Vocabulary
from .pddl_tables import PddlFile, Tables, check_requirements, parts_of, pddl_file, read_tables

MOST_OBJECTS = 10_000
APART = 10
"""Centimetres between the things of a row, and between rows."""


@dataclass(slots=True)
class ImportedRule:
    """What became of an action: how many of the rule's parameters are the action's own; the rest are constants."""

    action: str
    own: int


@dataclass(slots=True)
class ImportedTask:
    """`text` is the program. `rules` are the actions by the name of their rule, `objects` what the domain and problem
    call the things of the scene."""

    text: str
    rules: dict[str, ImportedRule] = field(default_factory=dict)
    objects: dict[str, str] = field(default_factory=dict)


def import_pddl(sources: Sequence[Source]) -> ImportedTask:
    """The task of a domain and a problem, in either order. Raises SourceError with all faults of both (E0019, E0020,
    E0022)."""
    domain, problem = _pair([_file(source) for source in sources])
    check_requirements(domain)
    check_requirements(problem)
    tables = read_tables(domain, problem)
    if len(tables.objects) > MOST_OBJECTS:
        objects = problem.the(":objects") or problem.whole
        problem.faults.tell("E0510", objects, f"{len(tables.objects)} objects, at most {MOST_OBJECTS}")
    _end(domain, problem)
    made = _Translation(domain, problem, tables).task()
    _end(domain, problem)
    return made


def _file(source: Source) -> PddlFile:
    faults = Faults(source)
    return pddl_file(faults, read_groups(faults))


def _pair(files: Sequence[PddlFile]) -> tuple[PddlFile, PddlFile]:
    kinds = {file.kind: file for file in files}
    if len(files) == 2 and len(kinds) == 2:
        domain, problem = kinds["domain"], kinds["problem"]
        named = problem.the(":domain")
        other = named.rest[0].text if named is not None and named.rest and isinstance(named.rest[0], Token) else None
        if other != domain.name:
            shown = "names no domain" if other is None else f"is one of the domain `{other}`"
            problem.faults.tell("E0022", named or problem.whole, f"the problem {shown}, not of `{domain.name}`")
        return domain, problem
    first = files[-1]
    lacking = "problem" if first.kind == "domain" else "domain"
    message = f"`{first.faults.source.path}` is a {first.kind}; a {lacking} is needed, too"
    raise SourceError([Diagnostic("E0021", message, help="tamplang import domain.pddl problem.pddl")])


def _end(*files: PddlFile) -> None:
    """Raises SourceError with the faults of all files."""
    found = FaultList()
    found.found = [d for file in files for d in file.faults.found]
    found.end()


class _Translation:
    """One import."""

    def __init__(self, domain: PddlFile, problem: PddlFile, tables: Tables) -> None:
        self.domain, self.problem, self.tables = domain, problem, tables
        self.words = Vocabulary(tables)
        self.singled: dict[str, str] = {}
        self.made = ImportedTask("")
        self.metric = check_metric(problem)
        self.costs = Costs(self.words, problem.faults)

    def task(self) -> ImportedTask:
        """The whole program."""
        section = self.problem.the(":init")
        self.costs.note([n for n in (section.rest if section is not None else ()) if _is_value(n)])
        derived = self._derived()
        rules = [self._rule(action) for action in self.domain.sections.get(":action", ())]
        goal = self._goal()
        reach: dict[str, list[str]] = {}
        while reach != self.tables.predicates and not self.domain.faults.found:  # as far as all that asks for them
            reach = dict(self.tables.predicates)
            derived = self._derived()
        scene = [*self._things(), *self._init(), *self.costs.facts()]
        self.made.objects = {self.words.objects[name]: name for name in self.tables.objects}
        declared = [*self._types(), "", *self._predicates(), *self.costs.predicates()]
        name = plain_name(self.problem.name)
        origin = f"# The problem {self.problem.name} of the domain {self.domain.name}, imported from PDDL."
        blocks = [*derived, *self.costs.functions(), *rules]
        lines = [origin, "", *declared, "", *blocks, "", f"task {name}() {{", *scene, goal, "}", ""]
        self.made.text = "\n".join(lines)
        return self.made

    def _types(self) -> list[str]:
        names = self.tables.parents
        in_order = sorted(names, key=lambda t: len(list(self.tables.above(t))))
        return [f"type {self.words.type_name(t)} < {self.words.type_name(names[t])}" for t in in_order]

    def _predicates(self) -> list[str]:
        shown = []
        for name, kinds in self.tables.predicates.items():
            if name not in self.words.derived:
                mark = "" if name in self.words.changed else " static"
                parameters = [(f"X{k}", kind) for k, kind in enumerate(kinds, 1)]
                told = Formulas(self.domain.faults, self.words).shown(parameters)
                shown.append(f"predicate ({' '.join([self.words.predicates[name], told]).strip()}){mark}")
        for name, predicate in self.singled.items():
            kind = self.words.type_name(self.tables.objects[name])
            shown.append(f"predicate ({predicate} X: {kind}) static")
        for above, predicate in self.words.unions.values():
            shown.append(f"predicate ({predicate} X: {self.words.type_name(above)}) static")
        return shown

    def _singled(self, name: str) -> str:
        """The predicate that holds of one constant: what rules say of it."""
        if name not in self.singled:
            self.singled[name] = self.words.predicates.fresh(f"is_{name}")
        return self.singled[name]

    def _is(self, formulas: Formulas) -> list[str]:
        return [f"({self._singled(name)} {variable})" for name, variable in formulas.used.items()]

    # --- domain --------------------------------------------------------------------------------------------------

    def _derived(self) -> list[str]:
        groups: dict[str, list[Group]] = {}
        for group in self.domain.sections.get(":derived", ()):
            head = group.rest[0] if group.rest else None
            if not isinstance(head, Group) or len(group.rest) != 2:
                self.domain.faults.tell("E0019", group, "expected `(:derived (NAME ?x …) CONDITION)`")
            elif head.head not in self.tables.predicates:
                self.domain.faults.tell("E0022", head, f"`{head.head}` is no declared predicate")
            else:
                groups.setdefault(head.head, []).append(group)
        self.words.derived |= groups.keys()
        reads: dict[str, set[str]] = {}
        shown = {name: self._one_derived(name, each, reads) for name, each in groups.items()}
        for name in groups:
            if name in _reached(name, reads):
                self.domain.faults.tell("E0020", groups[name][0], f"the derived predicate `{name}` uses itself, "
                                        "which has no counterpart here")  # fmt: skip
        return list(shown.values())

    def _one_derived(self, name: str, groups: Sequence[Group], reads: dict[str, set[str]]) -> str:
        """A derived predicate; several of one name are alternatives."""
        options = []
        parameters: list[tuple[str, str]] = []
        for group in groups:
            head, body = group.rest
            assert isinstance(head, Group)
            formulas = Formulas(self.domain.faults, self.words)
            for taken, _ in parameters:
                formulas.names.take(taken)
            bound = formulas.bind(Group(head.start, head.end, head.rest))
            if len(bound) != len(self.tables.predicates[name]):
                self.domain.faults.tell("E0022", head, f"`{name}` takes {len(self.tables.predicates[name])} arguments")
                return ""
            declared = [kind for _, kind in parameters] or self.tables.predicates[name]
            firsts = [first for first, _ in parameters or bound]
            pairs = zip(firsts, declared, bound, strict=True)
            parameters = [(first, self.tables.common((kind, own))) for first, kind, (_, own) in pairs]
            for variable, reached, (own, _) in zip(list(formulas.variables), parameters, bound, strict=True):
                formulas.variables[variable] = reached
                formulas.types[reached[0]] = formulas.types[own]
            asked = formulas.asks(parameters)
            text = formulas.condition(body)
            if asked:
                text = f"({' and '.join([*asked, text])})"
            reads.setdefault(name, set()).update(formulas.read)
            for constant, variable in formulas.used.items():
                kind = self.words.type_name(self.tables.objects[constant])
                text = f"exists {variable}: {kind} {{ ({self._singled(constant)} {variable}) and {text} }}"
            options.append(text)
        told = Formulas(self.domain.faults, self.words).shown(parameters)
        return f"derived ({' '.join([self.words.predicates[name], told]).strip()}) = {' or '.join(options)}"

    def _rule(self, action: Group) -> str:
        name = action.rest[0] if action.rest else None
        if not isinstance(name, Token) or name.text.startswith(":"):
            self.domain.faults.tell("E0019", action, "an action needs a name")
            return ""
        rule = self.words.rules.fresh(name.text)
        if any(r.action == name.text for r in self.made.rules.values()):
            self.domain.faults.tell("E0022", name, f"there are two actions `{name.text}`")
        parts = parts_of(self.domain.faults, action, (":parameters", ":precondition", ":effect"), 2)
        formulas = Formulas(self.domain.faults, self.words)
        parameters = formulas.bind(parts.get(":parameters"))
        self.made.rules[rule] = ImportedRule(name.text, len(parameters))
        before = formulas.conjuncts(parts[":precondition"]) if ":precondition" in parts else []
        costs: list[str] = []
        after = formulas.effects(parts[":effect"], costs) if ":effect" in parts else []
        kinds = formulas.asks(parameters)
        conditions = [*kinds, *self._is(formulas), *before, *(formulas.asked if self.metric else ())]
        parameters += [(variable, self.tables.objects[c]) for c, variable in formulas.used.items()]
        lines = [f"rule {rule}({formulas.shown(parameters)}) {{"]
        lines += [f"pre {', '.join(conditions)}"] if conditions else []
        lines += [f"post {', '.join(after)}"] if after else []
        lines += [f"cost {' + '.join(costs) or '0'}"] if self.metric else []
        return "\n".join([*lines, "}"])

    # --- problem -------------------------------------------------------------------------------------------------

    def _things(self) -> list[str]:
        """Every object as a thing, those of a type in a row."""
        rows: dict[str, list[str]] = {}
        for name, kind in self.tables.objects.items():
            rows.setdefault(kind, []).append(name)
        return [
            f"{self.words.type_name(kind)} {self.words.objects[name]}: sphere(1 cm) "
            f"at ({column * APART} cm, {row * APART} cm, 0)"
            for row, (kind, names) in enumerate(rows.items())
            for column, name in enumerate(names)
        ]  # fmt: skip

    def _init(self) -> list[str]:
        facts = [f"fact ({predicate} {self.words.objects[name]})" for name, predicate in self.singled.items()]
        for types, (_, predicate) in self.words.unions.items():
            facts += [f"fact ({predicate} {self.words.objects[name]})" for name in self.tables.members(types)]
        formulas = Formulas(self.problem.faults, self.words, scene=True)
        section = self.problem.the(":init")
        for node in section.rest if section is not None else ():
            if isinstance(node, Token) or not node.head:
                self.problem.faults.tell("E0019", node, "expected a fact in brackets, such as `(at a b)`")
            elif node.head == "=":
                continue
            elif node.head == "at" and _timed(node):
                self.problem.faults.tell("E0020", node, "timed facts have no counterpart here")
            elif node.head == "not":
                for inner in node.rest:
                    formulas.condition(inner)
            elif node.head in self.words.derived:
                self.problem.faults.tell("E0022", node, f"`{node.head}` is derived: it cannot be a fact")
            elif node.head in ("and", "or", "oneof", "unknown", "forall", "exists", "imply"):
                self.problem.faults.tell("E0020", node, f"`{node.head}` has no counterpart among facts")
            else:
                facts.append(f"fact {formulas.literal(node)}")
        return list(dict.fromkeys(facts))

    def _goal(self) -> str:
        section = self.problem.the(":goal")
        formulas = Formulas(self.problem.faults, self.words, scene=True)
        if section is None or len(section.rest) != 1:
            self.problem.faults.tell("E0019", section or self.problem.whole, "a goal is one condition in brackets")
            return ""
        return f"goal {', '.join(formulas.conjuncts(section.rest[0])) or '1 = 1'}"


def _is_value(node: Node) -> TypeGuard[Group]:
    return isinstance(node, Group) and node.head == "="


def _timed(node: Group) -> bool:
    rest: Sequence[Node] = node.rest
    return len(rest) == 2 and isinstance(rest[0], Token) and NUMBER.fullmatch(rest[0].text) is not None


def _reached(name: str, reads: dict[str, set[str]]) -> set[str]:
    """What a derived predicate reads, directly or through others."""
    found: set[str] = set()
    waiting = list(reads.get(name, ()))
    while waiting:
        other = waiting.pop()
        if other not in found:
            found.add(other)
            waiting += reads.get(other, ())
    return found
