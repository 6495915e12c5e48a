"""Rules of rai (`.fol`): decisions with what must hold and what becomes of it, as rules of this language.

Variables of a rule stand for different things, and each must stand in a condition that is not negated. `ANY` stands for
whatever is there. Effects come about in their order: of what is added and then deleted nothing stays. A rule of the
world that ends with `QUIT` tells the goal. Where the state at the start comes from a scene, `logical` names what holds
of its frames, and `on` what hangs on what, as in rai's own reader.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import field
from itertools import combinations

from ...langs.frozen import dataclass
from ...langs.source import Source
from .names import NO_PREDICATES, GivenNames, plain_name
from .nodes import Faults
from .pddl import APART, MOST_OBJECTS
from .rai import LOOSE, RaiFrame
from .rai_rule_texts import RuleBlock, RuleLiteral, RuleText, RuleWord, read_rules

ANY, QUIT = "ANY", "QUIT"
IMPLICIT = {"ssBox": "is_box", "sphere": "is_sphere", "capsule": "is_capsule"}
"""What rai says of things that are held, by their shape."""


@dataclass(slots=True)
class RaiRules:
    """`text` is the program, of a task called `name`; `faults` tells what is left out."""

    text: str
    faults: Faults


def import_rules(source: Source, stem: str, frames: dict[str, RaiFrame] | None = None) -> RaiRules:
    """The program of the rules, with the `frames` of a scene as its objects where there is one. Raises SourceError with
    all faults (E0019, E0020, E0022)."""
    faults = Faults(source)
    rules = read_rules(faults)
    facts = [] if frames is None else scene_facts(frames)
    text = _RuleTranslation(faults, rules, facts).program(plain_name(stem))
    faults.end()
    return RaiRules(text, faults)


def scene_facts(frames: dict[str, RaiFrame]) -> list[tuple[str, ...]]:
    """What holds of the frames of a scene at the start."""
    facts: list[tuple[str, ...]] = []
    for frame in frames.values():
        logical = frame.given.get("logical")
        if logical is not None:
            words = (logical.value,) if isinstance(logical.value, str) else logical.value
            values = {k + 1 for k, word in enumerate(words) if word in (":", "=")}
            facts += [(w, frame.name) for k, w in enumerate(words) if k not in values and w not in (":", "=", "!")]
        elif _joint(frame) == "rigid":
            facts.append(("is_object", frame.name))
            shape = frame.given.get("shape")
            known = "" if shape is None else IMPLICIT.get(str(shape.value), "")
            facts += [(known, frame.name)] if known else []
    things = {fact[1] for fact in facts}
    for frame in frames.values():
        above = _link(frames, frame) if frame.name in things else None
        if above is not None and above.name != frame.name and above.name in things:
            facts.append(("partOf", above.name, frame.name))
        if above is not None and above.parent in things:
            facts.append(("on", str(above.parent), frame.name))
    return facts


def _joint(frame: RaiFrame) -> str:
    given = frame.given.get("joint")
    return "" if given is None else str(given.value)


def _link(frames: dict[str, RaiFrame], frame: RaiFrame) -> RaiFrame:
    """The frame that carries all that is rigidly joined to this one."""
    while frame.parent is not None and (not _joint(frame) or (_joint(frame) in LOOSE and _joint(frame) != "rigid")):
        frame = frames[frame.parent]
    return frame


@dataclass(slots=True)
class _Scope:
    """The variables of a rule as they are named here, and its constants, each a variable more."""

    names: GivenNames
    variables: dict[str, str]
    constants: dict[str, str] = field(default_factory=dict)


class _RuleTranslation:
    def __init__(self, faults: Faults, rules: RuleText, facts: list[tuple[str, ...]]) -> None:
        self.faults, self.rules = faults, rules
        self.facts = facts
        self.predicates, self.objects = GivenNames(words=NO_PREDICATES), GivenNames()
        self.known: dict[tuple[str, int], str] = {}
        self.changed: set[str] = set()
        self.singled: dict[str, str] = {}
        self.wanted: list[str] = []
        self.given_names = GivenNames()
        self.symbols = {word.text for word in rules.symbols} | {a for fact in facts for a in fact[1:]}
        self.symbols |= {fact[0] for fact in facts} | {QUIT, ANY, "WAIT", "Terminate"}

    def program(self, name: str) -> str:
        """The whole program."""
        start = [self._fact(literal) for literal in self.rules.start]
        self.facts += [fact for fact in start if fact is not None]
        decisions = [self._rule(block) for block in self.rules.blocks if block.decides]
        goals = [goal for block in self.rules.blocks if not block.decides for goal in self._world(block)]
        if (QUIT, 0) in self.known:
            goals.append(f"({self.known[QUIT, 0]})")
        for where, message in self.rules.left:
            self._leave(where, message)
        facts = list(dict.fromkeys(self._shown_fact(fact) for fact in self.facts))
        things = list(dict.fromkeys(a for fact in self.facts for a in fact[1:]))
        things += [name for name in dict.fromkeys([*self.singled, *self.wanted]) if name not in things]
        if len(things) > MOST_OBJECTS:
            self.faults.add("E0510", self.faults.span(0, 1), f"{len(things)} objects, at most {MOST_OBJECTS}")
        facts += [f"({predicate} {self.objects[thing]})" for thing, predicate in self.singled.items()]
        lines = [f"# Rules of rai, imported from {self.faults.source.path.rpartition('/')[2]}.", "", *self._declared()]
        lines += ["", *decisions]
        if things:
            lines += ["", f"task {name}() {{"]
            lines += [
                f"object {self.objects[thing]}: sphere(1 cm) at ({k % 10 * APART} cm, {k // 10 * APART} cm, 0)"
                for k, thing in enumerate(things)
            ]
            lines += [f"fact {fact}" for fact in facts]
            lines += [] if goals else ["# No rule of the world ends with (QUIT): write the goal here."]
            lines += [f"goal {' or '.join(goals) or '1 = 1'}", "}"]
        return "\n".join([*lines, ""])

    def _leave(self, where: RuleWord | RuleLiteral, message: str) -> None:
        self.faults.note(self.faults.span(where.start, where.end), message)

    def _declared(self) -> list[str]:
        lines = []
        for (_, count), name in self.known.items():
            told = f" {' '.join(f'X{k}' for k in range(1, count + 1))}: object" if count else ""
            lines.append(f"predicate ({name}{told}){'' if name in self.changed else ' static'}")
        return lines + [f"predicate ({name} X: object) static" for name in self.singled.values()]

    # --- literals ------------------------------------------------------------------------------------------------

    def _predicate(self, word: RuleWord, count: int) -> str:
        if word.text not in self.symbols:
            self.faults.unknown(word.token, "predicate", sorted(self.symbols))
        return self._known(word.text, count)

    def _known(self, name: str, count: int) -> str:
        if (name, count) not in self.known:
            self.known[name, count] = self.predicates.fresh(name)
        return self.known[name, count]

    def _fact(self, literal: RuleLiteral) -> tuple[str, ...] | None:
        words = literal.words
        if literal.negated or literal.value or any(word.text == ANY for word in words):
            self.faults.tell("E0020", literal.token, "only plain facts hold at the start")
            return None
        for word in words[1:]:
            self._object(word)
        self._predicate(words[0], len(words) - 1)
        return tuple(word.text for word in words)

    def _object(self, word: RuleWord) -> str:
        if word.text not in self.symbols:
            self.faults.unknown(word.token, "symbol", sorted(self.symbols))
        return self.objects[word.text]

    def _shown_fact(self, fact: Sequence[str]) -> str:
        return f"({' '.join([self._known(fact[0], len(fact) - 1), *(self.objects[a] for a in fact[1:])])})"

    def _atom(self, literal: RuleLiteral, scope: _Scope, goal: bool = False) -> tuple[str, list[str]]:
        """A literal without its sign, and the variables that stand for `ANY`."""
        anything, shown = [], [self._predicate(literal.words[0], len(literal.words) - 1)]
        for word in literal.words[1:]:
            if word.text == ANY:
                anything.append(scope.names.fresh("any"))
                shown.append(anything[-1])
            elif word.text in scope.variables:
                shown.append(scope.variables[word.text])
            elif goal:
                shown.append(self._object(word))
                self.wanted.append(word.text)
            else:
                self._object(word)
                if word.text not in scope.constants:
                    scope.constants[word.text] = scope.names.fresh(word.text)
                shown.append(scope.constants[word.text])
        return f"({' '.join(shown)})", anything

    def _conditions(self, block: RuleBlock, scope: _Scope, goal: bool = False) -> list[str]:
        bound = {w.text for literal in block.before if not literal.negated for w in literal.words[1:]}
        for word in block.variables:
            if word.text not in bound:
                message = f"`{word.text}` stands in no condition that is not negated: it could be anything"
                self.faults.tell("E0022", word.token, message)
        found = []
        for literal in block.before:
            text, anything = self._atom(literal, scope, goal)
            text = f"exists {' '.join(anything)}: object {{ {text} }}" if anything else text
            found.append(f"not {text}" if literal.negated else text)
        return found + [f"{one} != {other}" for one, other in combinations(scope.variables.values(), 2)]

    # --- rules ---------------------------------------------------------------------------------------------------

    def _scope(self, block: RuleBlock) -> _Scope:
        names = GivenNames()
        scope = _Scope(names, {})
        for word in block.variables:
            if word.text in scope.variables:
                self.faults.tell("E0022", word.token, f"`{word.text}` is declared twice")
            scope.variables[word.text] = names.fresh(word.text)
        return scope

    def _rule(self, block: RuleBlock) -> str:
        if not block.before:
            self._leave(block.name, f"`{block.name.text}` has no condition: rai never takes it, and it is left out")
            return ""
        scope = self._scope(block)
        conditions = self._conditions(block, scope)
        effects = []
        for number, literal in enumerate(block.after):
            text, anything = self._atom(literal, scope)
            if literal.value:
                self._leave(literal, f"`{text}` lasts for a time, which has no counterpart: it becomes true")
            if anything and not literal.negated:
                self.faults.tell("E0020", literal.token, "what becomes true of `ANY` has no counterpart here")
            if not literal.negated and any(later.negated and _meet(literal, later) for later in block.after[number:]):
                continue
            self.changed.add(self.known[literal.words[0].text, len(literal.words) - 1])
            text = f"not {text}" if literal.negated else text
            effects.append(f"for {' '.join(anything)}: object {{ {text} }}" if anything else text)
        known = [f"({self._singled(name)} {variable})" for name, variable in scope.constants.items()]
        parameters = " ".join([*scope.variables.values(), *scope.constants.values()])
        lines = [f"rule {self.given_names.fresh(block.name.text)}({f'{parameters}: object' if parameters else ''}) {{"]
        lines.append(f"pre {', '.join([*known, *conditions])}")
        lines += [f"post {', '.join(effects)}"] if effects else []
        return "\n".join([*lines, "}"])

    def _singled(self, name: str) -> str:
        if name not in self.singled:
            self.singled[name] = self.predicates.fresh(f"is_{name}")
        return self.singled[name]

    def _world(self, block: RuleBlock) -> list[str]:
        """The goal that a rule of the world tells; others are left out."""
        if [literal.words[0].text for literal in block.after] != [QUIT] or block.after[0].negated:
            name = block.name.text
            self._leave(block.name, f"`{name}` follows by itself after every decision, without counterpart: left out")
            return []
        scope = self._scope(block)
        conditions = self._conditions(block, scope, goal=True)
        whole = " and ".join(conditions) or "1 = 1"
        if scope.variables:
            return [f"exists {' '.join(scope.variables.values())}: object {{ {whole} }}"]
        return [f"({whole})" if len(conditions) > 1 else whole]


def _meet(added: RuleLiteral, deleted: RuleLiteral) -> bool:
    """Whether what is deleted is, word by word, what was added."""
    one, other = ([word.text for word in literal.words] for literal in (added, deleted))
    return len(one) == len(other) and all(b in (a, ANY) for a, b in zip(one, other, strict=True))
