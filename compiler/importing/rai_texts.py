"""The texts of rai's scenes: entries `name (parent): { key: value, … }`, `Edit`, `Delete`, `Prefix` and `Include`."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator

from ...langs.diagnostics import Diagnostic, SourceError
from ...langs.frozen import dataclass
from ...langs.reader import read_bytes
from ...langs.source import Source, Span
from ..foreign import beside
from ..ir import IDENTITY, Pose
from ..poses import about, compose, make, unit
from .models import Models
from .nodes import Faults
from .rai import RaiScene

MOST_INCLUDES = 100
DEEPEST = 100
WORD = re.compile(r"\s+|#[^\n]*|\"[^\"\n]*\"|'[^'\n]*'|<[^>\n]*>|[(){}\[\]:,!=]|[^\s(){}\[\]:,!=\"'<#]+")
_STEP = re.compile(r"\s*([tdqrE])\s*\(([^()]*)\)\s*")


@dataclass(frozen=True, slots=True)
class RaiWord:
    """A word of a scene, without its quotes."""

    text: str
    start: int
    end: int
    quoted: bool = False


@dataclass(frozen=True, slots=True)
class RaiAttribute:
    """A value: a word, or the words of a list."""

    value: str | tuple[str, ...]
    span: Span

    def numbers(self) -> tuple[float, ...]:
        """As numbers; nothing where it is something else."""
        words = (self.value,) if isinstance(self.value, str) else self.value
        try:
            return tuple(float(word) for word in words)
        except ValueError:
            return ()

    def _seven(self) -> tuple[float, ...]:
        """The numbers of a text that holds seven and nothing else but brackets, which rai takes for a pose."""
        words = self.value.strip("[] ").replace(",", " ").split() if isinstance(self.value, str) else []
        try:
            return tuple(float(word) for word in words) if len(words) == 7 else ()
        except ValueError:
            return ()

    def pose(self) -> Pose:
        """As a pose: `t(…) d(…) q(…)` in their order, or 3 numbers, 4 of a quaternion, or 7. Raises ValueError."""
        plain = self._seven()
        if plain or isinstance(self.value, tuple):
            found = plain or self.numbers()
            if len(found) not in (3, 4, 7) or not all(map(math.isfinite, found)):
                raise ValueError("it is not 3, 4 or 7 finite numbers")
            place = found[:3] if len(found) != 4 else (0.0, 0.0, 0.0)
            turn = found[-4:] if len(found) > 3 else (1.0, 0.0, 0.0, 0.0)
            return make((place[0], place[1], place[2]), _quaternion(turn))
        assert isinstance(self.value, str)
        pose, text, at = IDENTITY, self.value.removeprefix("T ").strip(), 0
        while at < len(text):
            match = _STEP.match(text, at)
            if match is None:
                raise ValueError(f"`{text[at : at + 20]}` is none of t(…), d(…), r(…) and q(…)")
            values = [float(word) for word in match[2].replace(",", " ").split()]
            pose, at = compose(pose, _step(match[1], values)), match.end()
        return pose


def _quaternion(values: tuple[float, ...]) -> tuple[float, float, float, float]:
    norm = math.hypot(*values)
    if not 0 < norm < math.inf:
        raise ValueError("a quaternion is 0")
    w, x, y, z = (v / norm for v in values)
    return x, y, z, w


def _step(kind: str, values: list[float]) -> Pose:
    wanted = {"t": 3, "d": 4, "r": 4, "q": 4}.get(kind)
    if len(values) != wanted or not all(map(math.isfinite, values)):
        raise ValueError(f"{kind}(…) holds {wanted or 'what cannot be read'}{' finite numbers' if wanted else ''}")
    if kind == "t":
        return make((values[0], values[1], values[2]), (0.0, 0.0, 0.0, 1.0))
    if kind == "q":
        return make((0.0, 0.0, 0.0), _quaternion(tuple(values)))
    axis = unit((values[1], values[2], values[3]))
    if axis is None:
        raise ValueError("an axis is 0")
    return make((0.0, 0.0, 0.0), about(axis, math.radians(values[0]) if kind == "d" else values[0]))


@dataclass(frozen=True, slots=True)
class RaiEntry:
    """A frame, or with `edits` or `deletes` what becomes of one; its name has the `prefix` still to come."""

    name: str
    parents: tuple[str, ...]
    given: dict[str, RaiAttribute]
    prefix: str
    span: Span
    edits: bool = False
    deletes: bool = False


def import_rai(source: Source) -> Models:
    """The modules and bodies of a scene. Raises SourceError."""
    return read_scene(source).build()


def read_scene(source: Source) -> RaiScene:
    """The frames of a scene, of which nothing is made yet. Raises SourceError."""
    scene = RaiScene()
    for entry in _Text(source, "", (source.path,), [0, 0]).entries():
        scene.add(entry)
    scene.faults.end()
    return scene


class _Text:
    """One file, with `prefix` from those that include it."""

    def __init__(self, source: Source, prefix: str, way: tuple[str, ...], count: list[int]) -> None:
        self.faults, self.source, self.prefix, self.way, self.count = Faults(source), source, prefix, way, count
        self.own, self.at = "", 0
        self.words = self._words()

    def _words(self) -> list[RaiWord]:
        found, at, text = [], 0, self.source.text
        while at < len(text):
            match = WORD.match(text, at)
            if match is None:
                raise self._broken(at, f"`{text[at]}` cannot be read here")
            word, at = match[0], match.end()
            if word[0] in "\"'<":
                found.append(RaiWord(word[1:-1], match.start(), at, True))
            elif not word[0].isspace() and word[0] != "#":
                found.append(RaiWord(word, match.start(), at))
        return found

    def _broken(self, at: int, message: str, code: str = "E0019") -> SourceError:
        return SourceError([Diagnostic(code, message, self.faults.span(at, at + 1))])

    def _peek(self) -> str:
        word = self.words[self.at] if self.at < len(self.words) else None
        return "" if word is None or word.quoted else word.text

    def _next(self) -> RaiWord:
        if self.at >= len(self.words):
            start = max(len(self.source.text.rstrip()) - 1, 0)
            raise self._broken(start, "the file ends here, in the middle of an entry")
        self.at += 1
        return self.words[self.at - 1]

    def _skip(self, *marks: str) -> bool:
        if self._peek() in marks:
            self.at += 1
            return True
        return False

    def entries(self) -> Iterator[RaiEntry]:
        """All entries, with those of files that are included."""
        while self.at < len(self.words):
            if self._skip(","):
                continue
            first = self._next()
            if first.text == "Prefix" and not first.quoted:
                self.own = "" if self._skip("!") else self._value_after_colon(first)
                self.own = "" if self.own.lower() == "false" else self.own
            elif first.text == "Include" and not first.quoted:
                yield from self._included(first)
            else:
                yield self._entry(first)

    def _value_after_colon(self, first: RaiWord) -> str:
        if not self._skip(":", "="):
            raise self._broken(first.start, f"`{first.text}` is followed by `:` and a text")
        return self._next().text

    def _included(self, first: RaiWord) -> Iterator[RaiEntry]:
        name = self._value_after_colon(first)
        path, span = beside(self.source.path, name), self.faults.span(first.start, first.end)
        self.count[0] += 1
        reason = None
        if path in self.way:
            reason = f"`{name}` includes itself"
        elif self.count[0] > MOST_INCLUDES or len(self.way) > DEEPEST:
            reason = f"more than {MOST_INCLUDES} files are included"
        elif not path.endswith((".g", ".yml")):
            reason = f"`{name}` is not included: only files that end with .g or .yml are"
        if reason is not None:
            raise SourceError([Diagnostic("E0022", reason, span)])
        try:
            text = read_bytes(path).decode("utf-8", errors="replace").replace("\r\n", "\n")
        except SourceError as error:
            message = f"`{name}` is not included: {error.diagnostics[0].message}"
            raise SourceError([Diagnostic("E0022", message, span)]) from None
        yield from _Text(Source(path, text), self.prefix + self.own, (*self.way, path), self.count).entries()

    def _entry(self, first: RaiWord) -> RaiEntry:
        edits, deletes = (first.text == w and not first.quoted and self._named() for w in ("Edit", "Delete"))
        if deletes:
            self._skip(":")
        name = self._next() if edits or deletes else first
        if name.text == "(" and not name.quoted and not edits:  # a frame without name
            self.at -= 1
            self.count[1] += 1
            name = RaiWord(f"frame_{self.count[1]}", name.start, name.end)
        if name.text in ("(", ")", "{", "}", "[", "]", ":", "!") and not name.quoted:
            raise self._broken(name.start, f"a frame has a name, not `{name.text}`")
        if '"' in name.text:
            raise self._broken(name.start, "a name has quotes in it")
        if self._peek() not in ("(", "{", ":", "") and not deletes:  # older files say `body NAME` and `frame NAME`
            if name.text.lower() not in ("body", "frame", "shape", "joint"):
                raise self._broken(name.start, f"`{name.text}` is followed by its parent in brackets, or by `{{`")
            name = self._next()
        parents = tuple(self._group("(", ")")) if self._skip("(") else ()
        self._skip(":", "!")
        given = self._attributes() if self._skip("{") else {}
        span = self.faults.span(name.start, name.end)
        return RaiEntry(name.text, parents, given, self.prefix + self.own, span, bool(edits), bool(deletes))

    def _named(self) -> bool:
        after = self.words[self.at + 1].text if self.at + 1 < len(self.words) else ""
        return self._peek() not in ("(", "{", "=", ":", "") or (self._peek() == ":" and after not in ("{", "("))

    def _group(self, opening: str, closing: str) -> Iterator[str]:
        """The words up to the bracket that closes."""
        depth = 0
        while True:
            word = self._next()
            if not word.quoted and word.text == closing and depth == 0:
                return
            depth += 0 if word.quoted else (word.text == opening) - (word.text == closing)
            if word.quoted or word.text not in (",", opening, closing):
                yield word.text

    def _attributes(self) -> dict[str, RaiAttribute]:
        given: dict[str, RaiAttribute] = {}
        while not self._skip("}"):
            if self._skip(","):
                continue
            key = self._next()
            if key.text in ("{", "[", "(", ")", "]", ":") and not key.quoted:
                raise self._broken(key.start, f"`{key.text}` stands where the name of a value is expected")
            if self._skip("!"):
                given[key.text] = self._made("false", key)
            elif self._skip(":", "="):
                given[key.text] = self._value(key)
            elif self._skip("{"):
                list(self._group("{", "}"))
            else:
                given[key.text] = self._made("true", key)
        return given

    def _value(self, key: RaiWord) -> RaiAttribute:
        if self._skip("["):
            return self._made(tuple(self._group("[", "]")), key)
        if self._skip("{"):
            return self._made(tuple(self._group("{", "}")), key)
        if self._skip("("):
            return self._made(tuple(self._group("(", ")")), key)
        return self._made(self._next().text, key)

    def _made(self, value: str | tuple[str, ...], key: RaiWord) -> RaiAttribute:
        return RaiAttribute(value, self.faults.span(key.start, self.words[self.at - 1].end))
