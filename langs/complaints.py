"""What the parser says about a mistake, in words of the language."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Mapping, Sequence

from lark import Token

from .automaton import Automaton
from .build_terms import span_of
from .diagnostics import Diagnostic, Label, did_you_mean
from .frozen import dataclass
from .source import Source, Span

UNITS = ("m", "cm", "mm", "rad", "deg", "s", "min", "m/s", "rad/s", "deg/s", "m/s^2", "rad/s^2", "deg/s^2",
         "m/s^3", "rad/s^3", "deg/s^3", "kg", "g", "N", "kN", "N m", "kN m", "kg/m^3", "kg m^2")  # fmt: skip
SAME_UNITS = {name: unit for unit, names in {
    "m": "meter meters metre metres", "cm": "centimeter centimeters centimetre centimetres",
    "mm": "millimeter millimeters millimetre millimetres mms", "rad": "radian radians rads",
    "deg": "degree degrees degs", "s": "second seconds sec secs", "min": "minute minutes mins",
    "kg": "kilogram kilograms kgs", "g": "gram grams", "N": "newton newtons", "N m": "Nm",
}.items() for name in names.split()}  # fmt: skip
"""Units by other names."""
FOREIGN_UNITS = {*SAME_UNITS, "inch", "inches", "ft", "foot", "feet", "yd", "km", "h", "hour", "px", "lb",
                 "lbs", "t"}  # fmt: skip
_WORDS = {
    "NAME": "a name",
    "NUMBER": "a number",
    "STRING": "a quoted text",
    "COMMA": "`,`",
    "COLON": "`:`",
    "LPAR": "`(`",
    "RPAR": "`)`",
    "LBRACE": "`{`",
    "RBRACE": "`}`",
    "LSQB": "`[`",
    "RSQB": "`]`",
    "DOT": "`.`",
    "_DOTS": "`..`",
    "EQUAL": "`=`",
    "LESS": "`<`",
    "$END": "the end of the file",
    "AGGREGATE": "`min`, `max` or `sum`",
}
_VALUE_STARTS = {
    "NAME",
    "NUMBER",
    "STRING",
    "_ANY",
    "LPAR",
    "LSQB",
    "MINUS",
    "AGGREGATE",
    "_EXISTS",
    "_FORALL",
    "_PREVIOUS",
    "_NOT",
    "_IF",
}
_GROUPS = (
    (
        {"_IMPORT", "_RULE", "_TASK"},
        {
            "_IMPORT",
            "_TYPE",
            "_PREDICATE",
            "_DERIVED",
            "_FUNCTION",
            "_MODULE",
            "_MOTION",
            "_RULE",
            "_PLACEMENT",
            "_HEURISTIC",
            "_SCENE",
            "_TASK",
        },
        "a declaration such as `rule` or `task`",
    ),
    (
        {"_GOAL", "_GUIDE"},
        {
            "_GOAL",
            "_GUIDE",
            "_OPTIONS",
            "_FACT",
            "_FOR",
            "_FORALL",
            "_IF",
            "_SCENE",
            "_MOVES",
            "_DISTURB",
            "_FAIL",
            "NAME",
        },
        "an item such as `goal`, `fact` or `for`",
    ),
    ({"LESS", "ORDER"}, {"EQUAL", "LESS", "ORDER"}, "a comparison"),
    ({"SIGN", "STAR"}, {"SIGN", "MINUS", "STAR"}, "an operator"),
)
_BEFORE_CONDITION = {"_PRE", "_WHERE", "_GOAL", "_IF", "_AND", "_OR", "_NOT"}
_CLOSING = {")": "(", "]": "[", "}": "{"}
_OPENERS = frozenset({"LPAR", "LSQB", "LBRACE"})
_CLOSERS = frozenset({"RPAR", "RSQB", "RBRACE"})
_INSTEAD = {
    "&": ("_AND", "and"),
    "|": ("_OR", "or"),
    "!": ("_NOT", "not"),
    "∧": ("_AND", "and"),
    "∨": ("_OR", "or"),
    "∃": ("_EXISTS", "exists"),
    "∀": ("_FORALL", "forall"),
    "≤": ("ORDER", "<="),
    "≥": ("ORDER", ">="),
    "≠": ("ORDER", "!="),
    "·": ("STAR", "*"),
    "×": ("STAR", "*"),
    "−": ("MINUS", "-"),
    "–": ("MINUS", "-"),
    "…": ("_DOTS", ".."),
}
_FOREIGN = {
    "//": "a comment begins with `#`",
    "/*": "a comment begins with `#`",
    "<>": "inequality is written `!=`",
    "=>": "at least is written `>=`, at most `<=`",
    "...": "a range is written `1 .. n`",
}
_HINTS = {
    ";": "lines need no sign at their end",
    "\u00a0": "this is a no-break space; write a plain one",
}
_OTHER_DIGITS = re.compile(r"(?![0-9])\d+(\.\d+)?([ \t]*(cm|mm|m|deg|rad|s|kg)\b)?")
"""A number in the digits of another script, with its unit."""
_WRONG_QUOTES = re.compile(r"['‘’“”`][^'‘’“”`]*['‘’“”`]")


@dataclass(frozen=True, slots=True)
class Strange:
    """What is said about characters that start no terminal: how many they are, and the terminal meant, if known."""

    diagnostic: Diagnostic
    width: int
    meant: tuple[str, str] | None


def misspelt(source: Source, token: Token, keyword: str) -> Diagnostic:
    return Diagnostic(
        "E0004", f"`{token}` is no keyword", span_of(source.path, token), help=f"did you mean `{keyword}`?"
    )


def lacking(source: Source, sign: str, before: Sequence[Token], found: Token) -> Diagnostic:
    """One sign lacks between the tokens `before` and `found`."""
    opening = _CLOSING.get(sign)
    opened, taken = (None, None) if opening is None else _unclosed(source, before, opening)
    found = taken or found
    after = f" after `{before[-1]}`" if before else ""
    if opened is None:
        return Diagnostic("E0003", f"missing `{sign}`{after}", _gap(source, before, found))
    place = span_of(source.path, found) if sign == "}" else _gap(source, before, found)
    name = "the end of the file" if found.type == "$END" else f"`{found}`"
    return Diagnostic(
        "E0005",
        f"missing `{sign}` before {name}" if sign == "}" else f"missing `{sign}`{after}",
        place,
        labels=(Label(span_of(source.path, opened), f"this `{opening}` is never closed"),),
    )


def _unclosed(source: Source, before: Sequence[Token], opening: str) -> tuple[Token | None, Token | None]:
    """The bracket that lacks its partner, and the closing one that it took from an outer block, if any. A closing
    brace at the start of a line that is indented differently from the line of its opening brace shows that it was
    meant for an outer one; the first such since a declaration began."""
    stack: list[Token] = []
    suspect: Token | None = None
    taken: Token | None = None
    for token in before:
        if token.type in _OPENERS:
            stack.append(token)
        elif token.type in _CLOSERS and stack:
            partner = stack.pop()
            if not stack:
                suspect = taken = None
            if token.type != "RBRACE" or suspect is not None or not stack:
                continue
            text = source.line(token.line or 1)
            if text.lstrip().startswith("}") and _indent(text) != _indent(source.line(partner.line or 1)):
                suspect, taken = partner, token
    open_ones = [t for t in stack if t == opening]
    if opening == "{" and suspect is not None:
        return suspect, taken
    return (open_ones[-1] if open_ones else None), None


def _indent(line: str) -> int:
    return len(line) - len(line.lstrip())


def _gap(source: Source, before: Sequence[Token], found: Token) -> Span:
    """The character behind the last token before a gap, or the found token where there is none; at the end of the
    file, the place behind its last character."""
    if not before:
        return span_of(source.path, found)
    last = span_of(source.path, before[-1])
    width = min(1, len(source.text) - last.end)
    end = last.end + width, last.end_line, last.end_column + width
    return Span(last.file, last.end, end[0], last.end_line, last.end_column, end[1], end[2])


def bare_literal(source: Source, words: Sequence[Token]) -> Diagnostic:
    first, last = span_of(source.path, words[0]), span_of(source.path, words[-1])
    span = Span(first.file, first.start, last.end, first.line, first.column, last.end_line, last.end_column)
    return Diagnostic("E0003", "missing parentheses around a literal", span, help=f"write `({' '.join(words)})`")


def dangling(source: Source, comma: Token) -> Diagnostic:
    return Diagnostic("E0001", "nothing follows this `,`", span_of(source.path, comma), help="leave it out")


def ended_early(source: Source, brace: Token) -> Diagnostic:
    """What follows a brace can only stand in front of it."""
    told = "this `}` ends the declaration, and what follows belongs to it"
    return Diagnostic("E0001", told, span_of(source.path, brace), help="leave it out")


def unreadable(source: Source, position: int, automaton: Automaton) -> Strange:
    """The character at `position` starts no terminal."""
    character = source.text[position]
    line, column = automaton.place(position)
    quoted = _quoted(source.line(line)[column - 1 :].rstrip())
    if quoted is not None:
        span = Span(source.path, position, position + len(quoted), line, column, line, column + len(quoted))
        told = "this text has no closing quote" if character == '"' else 'texts stand between `"` and `"`'
        inner = quoted[1:] if character == '"' else quoted[1:-1]
        repair = 'put `"` at its start and its end, on the same line' if character == '"' else f'write `"{inner}"`'
        found = Diagnostic("E0006", told, span, help=repair)
        return Strange(found, len(quoted), ("STRING", f'"{inner}"'))
    width = 2 if source.text.startswith(("&&", "||"), position) else 1
    shown = f"`{character}`" if character.isprintable() else f"U+{ord(character):04X}"
    meant = _INSTEAD.get(character)
    number = _OTHER_DIGITS.match(source.text, position)
    if number is not None:
        width, shown = len(number[0]), f"`{number[0]}`"
        meant = "NUMBER", "".join(str(unicodedata.decimal(c, c)) for c in number[0])
    span = Span(source.path, position, position + width, line, column, line, column + width)
    hint = f"write `{meant[1]}`" if meant is not None else _HINTS.get(character)
    return Strange(Diagnostic("E0002", f"unknown character {shown}", span, help=hint), width, meant)


def _quoted(rest: str) -> str | None:
    """The text that a quote without partner, or a pair of wrong quotes, was meant to enclose."""
    if rest.startswith('"'):
        return rest
    match = _WRONG_QUOTES.match(rest)
    return None if match is None else match[0]


def unknown_unit(source: Source, number: Token, found: Token) -> Diagnostic | None:
    """The diagnostic for a word right behind a number that can only be meant as its unit."""
    if number.line != found.line or not str(number)[-1].isdigit():
        return None
    same = SAME_UNITS.get(str(found)) or (str(found).lower() if str(found).lower() in UNITS else None)
    near = did_you_mean(str(found), UNITS) if same is None else f"did you mean `{same}`?"
    if near is None and str(found) not in FOREIGN_UNITS:
        return None
    return Diagnostic(
        "E0007",
        f"unknown unit `{found}`",
        span_of(source.path, found),
        help=near or "units are m, cm, mm, rad, deg, s, min, m/s, rad/s, kg, g, N, N m, kg/m^3 and kg m^2",
    )


def unexpected(
    source: Source, found: Token, previous: Token | None, accepted: Sequence[str], keywords: Mapping[str, str]
) -> Diagnostic:
    foreign = _foreign_sign(source, found)
    if previous is not None and previous.type == "_DOTS" and foreign is None:
        help = "write both ends, such as `1 .. length(c)` for the modules of a chain c"
        return Diagnostic("E0017", "this range has no end", span_of(source.path, previous), help=help)
    ended = "RBRACE" in accepted or "$END" in accepted
    if previous is not None and foreign is None and not ended and _begins_statement(found, previous, keywords):
        return unfinished(source, previous, accepted, keywords, _advice(found, previous, accepted))
    words = expectations(accepted, previous, keywords)
    name = "the file ends here" if found.type == "$END" else f"unexpected `{found}`"
    if found == "}" and "$END" in accepted and foreign is None:
        return Diagnostic("E0001", "this `}` closes nothing", span_of(source.path, found), help="leave it out")
    behind = f": expected {words}" if words else ""
    advice = foreign or _advice(found, previous, accepted)
    return Diagnostic("E0001", name + behind, span_of(source.path, found), help=advice)


def unfinished(
    source: Source, last: Token, accepted: Sequence[str], keywords: Mapping[str, str], advice: str | None = None
) -> Diagnostic:
    """A statement ends with the token `last` before it is whole: said where it is being typed."""
    words = expectations(accepted, last, keywords)
    return Diagnostic("E0001", f"expected {words} after `{last}`", _gap(source, [last], last), help=advice)


def _begins_statement(found: Token, previous: Token, keywords: Mapping[str, str]) -> bool:
    """Whether a line starts with a word or brace that shows that the line above was left unfinished."""
    word = found.type in keywords or str(found) in keywords.values()
    return found.line != previous.end_line and (found.type == "RBRACE" or word)


def _foreign_sign(source: Source, found: Token) -> str | None:
    """What to write for a sign of other languages of which the token is a part."""
    start = found.start_pos or 0
    for sign, meant in _FOREIGN.items():
        for offset in range(len(sign)):
            if source.text[start - offset : start - offset + len(sign)] == sign and start >= offset:
                return meant
    return None


def _advice(found: Token, previous: Token | None, accepted: Sequence[str]) -> str | None:
    if found.type in ("_PRE", "_WHERE", "_POST", "_COST"):
        return "the parts of a rule stand in the order pre, where, post, cost, each at most once"
    if found.type == "EQUAL" and previous is not None and previous.type == "EQUAL":
        return "equality is written `=`"
    if "_DOTS" in accepted and found in ("to", "until", "through"):
        return "a range is written `1 .. n`"
    if found.type == "COMMA" and "_ANY" in accepted and "SIGN" not in accepted:
        return "arguments of a literal are separated by blanks: `(on X A)`"
    return None


def expectations(accepted: Sequence[str], previous: Token | None, keywords: Mapping[str, str]) -> str:
    """What may stand here, as an English list; at most eight things."""
    rest, found = set(accepted), list[str]()
    if {"NUMBER", "LPAR", "MINUS"} <= rest:
        condition = previous is not None and previous.type in _BEFORE_CONDITION
        found.append("a condition" if condition else "a value")
        rest -= _VALUE_STARTS
    for needed, group, word in _GROUPS:
        if needed <= rest:
            found.append(word)
            rest -= group
    found += [_WORDS[k] for k in accepted if k in rest and k in _WORDS and k != "$END"]
    found += [f"`{keywords[k]}`" for k in accepted if k in rest and k in keywords]
    found += [_WORDS[k] for k in accepted if k in rest and k == "$END"]
    shown = found if len(found) <= 8 else [*found[:7], "…"]
    return " or ".join([", ".join(shown[:-1]), shown[-1]] if len(shown) > 1 else shown)
