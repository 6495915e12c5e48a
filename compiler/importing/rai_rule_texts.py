"""The texts of rai's rules: symbols, `START_STATE { … }`, `DecisionRule name { variables, { … } { … } }` and `Rule`."""

from __future__ import annotations

from dataclasses import field

from ...langs.diagnostics import Diagnostic, SourceError
from ...langs.frozen import dataclass
from .nodes import Faults, Token
from .rai_texts import DEEPEST, WORD

DECISIONS = ("DecisionRule", "DECISION", "Decision")
WORLD = "Rule"
CONDITION, EFFECT = ("pre", "precondition"), ("eff", "effect", "post", "postcondition")
MARKS = ("(", ")", "{", "}", "[", "]", ":", "=", "!", ",")


@dataclass(frozen=True, slots=True)
class RuleWord:
    """A word with its place."""

    text: str
    start: int
    end: int
    quoted: bool = False

    @property
    def token(self) -> Token:
        return Token(self.text, self.start, self.end)


@dataclass(frozen=True, slots=True)
class RuleLiteral:
    """`(on A B)`, with `!` behind it or with a value."""

    words: tuple[RuleWord, ...]
    start: int
    end: int
    negated: bool = False
    value: str = ""

    @property
    def token(self) -> Token:
        return Token("", self.start, self.end)


@dataclass(frozen=True, slots=True)
class RuleBlock:
    """A rule: one that is decided for, or one of the world."""

    name: RuleWord
    decides: bool
    variables: list[RuleWord]
    before: list[RuleLiteral]
    after: list[RuleLiteral]


@dataclass(slots=True)
class RuleText:
    """What a file says, and what of it is left out."""

    symbols: list[RuleWord] = field(default_factory=list)
    start: list[RuleLiteral] = field(default_factory=list)
    blocks: list[RuleBlock] = field(default_factory=list)
    left: list[tuple[RuleWord, str]] = field(default_factory=list)


def read_rules(faults: Faults) -> RuleText:
    """What the text says. Raises SourceError (E0019) where it cannot be read."""
    return _RuleReader(faults).all()


class _RuleReader:
    def __init__(self, faults: Faults) -> None:
        self.faults, self.found, self.at = faults, RuleText(), 0
        self.words = self._words()

    def _words(self) -> list[RuleWord]:
        found, at, text = [], 0, self.faults.source.text
        while at < len(text):
            match = WORD.match(text, at)
            if match is None:
                raise self._broken(at, f"`{text[at]}` cannot be read here")
            word, start, at = match[0], at, match.end()
            if word[0] in "\"'<":
                found.append(RuleWord(word[1:-1], start, at, True))
            elif not word[0].isspace() and word[0] != "#":
                found.append(RuleWord(word, start, at))
        return found

    def _broken(self, at: int, message: str) -> SourceError:
        return SourceError([Diagnostic("E0019", message, self.faults.span(at, at + 1))])

    def _peek(self, ahead: int = 0) -> str:
        word = self.words[self.at + ahead] if self.at + ahead < len(self.words) else None
        return "" if word is None or word.quoted else word.text

    def _next(self) -> RuleWord:
        if self.at >= len(self.words):
            raise self._broken(max(len(self.faults.source.text.rstrip()) - 1, 0), "the file ends here, in the middle")
        self.at += 1
        return self.words[self.at - 1]

    def _skip(self, *marks: str) -> bool:
        found = self._peek() in marks
        self.at += found
        return found

    def all(self) -> RuleText:
        """The whole file."""
        while self.at < len(self.words):
            if self._skip(",", ";"):
                continue
            word = self._next()
            if word.text in MARKS and not word.quoted:
                raise self._broken(word.start, f"`{word.text}` stands outside of everything")
            if word.text in (*DECISIONS, WORLD) and (self._peek() == "{" or self._peek(1) in ("{", ":", "(")):
                self._rule(word)
            elif self._skip(":", "=") or self._peek() == "{":
                self._named(word)
            else:
                self.found.symbols.append(word)
        return self.found

    def _named(self, word: RuleWord) -> None:
        """What a name stands before: the facts at the start, or what is left out."""
        if word.text in ("START_STATE", "STATE") and self._skip("{"):
            self.found.start += self._literals()
            return
        whole = self._rest() if self._peek() in ("{", "[", "(") else [self._next()]
        if word.text == "Include":
            self.found.left.append((word, "`Include` is left out: import the file that it names"))
        elif word.text == "REWARD" and len(whole) > 2:
            self.found.left.append((word, "rewards are left out: what counts is the number of decisions"))
        elif word.text == "FOL_World" and "hasWait=true" in "".join(inner.text for inner in whole).replace(":", "="):
            self.found.left.append((word, "waiting is left out: nothing here lasts for a time"))

    def _rest(self) -> list[RuleWord]:
        """The words of a group, brackets with them."""
        found, depth = [], 0
        while True:
            found.append(self._next())
            depth += 0 if found[-1].quoted else (found[-1].text in "{[(") - (found[-1].text in "}])")
            if depth > DEEPEST:
                raise self._broken(found[-1].start, f"brackets are nested more than {DEEPEST} deep")
            if depth == 0:
                return found

    def _rule(self, head: RuleWord) -> None:
        name = head if self._peek() == "{" else self._next()
        if self._skip("("):
            while not self._skip(")"):
                self._next()
        self._skip(":")
        opening = self._next()
        if opening.text != "{":
            raise self._broken(opening.start, f"`{name.text}` is followed by `{{`, not by `{opening.text}`")
        variables: list[RuleWord] = []
        groups: dict[str, list[RuleLiteral]] = {}
        while not self._skip("}"):
            if self._skip(","):
                continue
            word = self._next()
            label = word.text if self._peek() in (":", "=") else ""
            if label and self._skip(":", "=") and self._peek() != "{":
                raise self._broken(word.start, f"`{label}` of a rule has no counterpart here")
            if label:
                word = self._next()
            if word.text == "{" and not word.quoted:
                self._group(label, groups, word)
            elif word.text in MARKS and not word.quoted:
                raise self._broken(word.start, f"a rule holds variables and two groups, not `{word.text}`")
            else:
                variables.append(word)
        if "before" not in groups or "after" not in groups:
            raise self._broken(name.start, f"`{name.text}` has no two groups, what must hold and what becomes of it")
        decides = head.text in DECISIONS
        self.found.blocks.append(RuleBlock(name, decides, variables, groups["before"], groups["after"]))

    def _group(self, label: str, groups: dict[str, list[RuleLiteral]], opening: RuleWord) -> None:
        kind = "before" if label in CONDITION else "after" if label in EFFECT else ""
        kind = kind or ("before" if "before" not in groups else "after")
        if kind in groups:
            raise self._broken(opening.start, "a rule with more than one effect happens by chance: no counterpart here")
        groups[kind] = self._literals()

    def _literals(self) -> list[RuleLiteral]:
        """The literals up to the bracket that closes."""
        found = []
        while not self._skip("}"):
            if self._skip(","):
                continue
            word = self._next()
            if word.text != "(" or word.quoted:
                raise self._broken(word.start, f"`{word.text}` stands where a literal such as `(on A B)` is expected")
            words = []
            while not self._skip(")"):
                inner = self._next()
                if inner.text in MARKS and not inner.quoted and inner.text != ",":
                    raise self._broken(inner.start, f"`{inner.text}` stands within a literal")
                words += [] if inner.text == "," else [inner]
            if not words:
                raise self._broken(word.start, "a literal holds a predicate")
            end = self.words[self.at - 1].end
            negated, value = self._skip("!"), ""
            if self._skip("=", ":"):
                value = self._next().text
                negated, value = negated or value == "false", "" if value in ("true", "false") else value
            found.append(RuleLiteral(tuple(words), word.start, end, negated, value))
        return found
