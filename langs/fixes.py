"""Repairs of a text that the hint of a diagnostic tells: the hint is written for people, its form is read here."""

from __future__ import annotations

import re
from collections.abc import Iterator

from .diagnostics import Diagnostic
from .frozen import dataclass

Edit = tuple[int, int, str]


@dataclass(frozen=True, slots=True)
class Fix:
    """`edits` replace the characters from the first to before the second number by a text."""

    title: str
    edits: tuple[Edit, ...]

    def applied(self, text: str) -> str:
        for start, end, new in sorted(self.edits, reverse=True):
            text = text[:start] + new + text[end:]
        return text


_QUOTED = re.compile(r"`([^`]+)`")
_IMPORT = re.compile(r"^import\b.*$", re.MULTILINE)
_PART = re.compile(r"^[ \t]*(pre|where|post|cost)\b", re.MULTILINE)
_NUMBER_BEFORE = re.compile(r"([0-9]+(?:\.[0-9]+)?)[ \t]*$")
_METRES = {"inch": 0.0254, "inches": 0.0254, "ft": 0.3048, "foot": 0.3048, "feet": 0.3048, "yd": 0.9144, "km": 1000.0}
_COMPARED = re.compile(r"[<>!=]+")
_MISSING = re.compile(r"missing `([^`]+)` (?:after|before) ")


def fixes(diagnostic: Diagnostic, text: str) -> list[Fix]:
    """The repairs of a diagnostic of this text, the surest first."""
    span = diagnostic.span
    if span is None:
        return []
    return [f for f in _fixes(diagnostic, text, span.start, span.end) if "…" not in "".join(e[2] for e in f.edits)]


def _fixes(diagnostic: Diagnostic, text: str, start: int, end: int) -> Iterator[Fix]:
    hint = diagnostic.help or ""
    quoted = _QUOTED.findall(hint)
    missing = _MISSING.match(diagnostic.message)
    if missing is not None and diagnostic.code in ("E0003", "E0005"):
        yield _insertion(text, start, missing[1])
    elif hint.startswith(("the standard library declares it: ", "the standard library declares some: ")):
        yield from (Fix(f"Add `{q}`", (_import_edit(text, q),)) for q in quoted)
    elif hint.startswith("did you mean `("):
        inner = text[start:end].strip("[]()")
        yield Fix("Put it in parentheses", ((start, end, f"({inner})"),))
    elif hint.startswith(("name one of its ends: ", "known here: ")):
        yield from (Fix(f"Write `{q}`", ((start, end, q),)) for q in quoted)
    elif hint.startswith(("did you mean ", "give it a unit, such as ", "write ")) and quoted:
        yield from (Fix(f"Write `{q}`", ((start, end, q),)) for q in quoted if not hint.startswith("write both"))
    elif hint.startswith("a literal is written `(") and " X Y)" not in hint:
        yield Fix(f"Write `{quoted[0]}`", ((start, end, quoted[0]),))
    elif hint.startswith("use `") and diagnostic.code == "E0402":
        sign = _COMPARED.search(text, start, end)
        if sign is not None:
            yield Fix(f"Write `{quoted[0]}`", ((sign.start(), sign.end(), quoted[0]),))
    elif hint == "leave it out" or hint == "leave out the comparison" or hint == "lines need no sign at their end":
        yield Fix("Leave it out", ((start, end, ""),))
    elif hint == "this is a no-break space; write a plain one":
        yield Fix("Write a plain blank", ((start, end, " "),))
    elif hint.startswith("add `"):
        yield from _addition(text, start, quoted[0])
    elif diagnostic.code == "E0007":
        yield from _unit(text, start, end)
    elif hint.startswith("the parts of a rule stand in the order"):
        yield from _ordered_parts(text, start)
    elif hint.startswith("delete the other one: "):
        yield Fix(f"Add `{quoted[0]}`", ((start, start, f"{quoted[0]}, "),))
    elif hint.startswith("arguments of a literal are separated by blanks"):
        yield Fix("Leave out the comma", ((start, end, ""),))
    else:
        yield from _sign(text, start, hint)


def _sign(text: str, start: int, hint: str) -> Iterator[Fix]:
    """A sign of another language around `start`."""
    meant = {
        "a comment begins with `#`": (("//", "/*"), "#"),
        "inequality is written `!=`": (("<>",), "!="),
        "at least is written `>=`, at most `<=`": (("=>", "=<"), ">="),
        "a range is written `1 .. n`": (("...", "until", "through", "to"), ".."),
        "equality is written `=`": (("==",), "="),
    }.get(hint)
    for written in meant[0] if meant is not None else ():
        for begin in range(max(0, start - len(written) + 1), start + 1):
            if text.startswith(written, begin) and meant is not None:
                yield Fix(f"Write `{meant[1]}`", ((begin, begin + len(written), meant[1]),))
                return


def _insertion(text: str, at: int, sign: str) -> Fix:
    blank = " " if sign[0].isalpha() or sign == "{" else ""
    before = text[text.rfind("\n", 0, at) + 1 : at]
    if sign == "}" and (not before.strip() or at >= len(text)):
        return Fix("Insert `}`", ((at, at, "\n}" if before.strip() else f"}}\n{before}"),))
    return Fix(f"Insert `{sign}`", ((at, at, f"{blank}{sign}{blank}" if blank else sign),))


def _import_edit(text: str, line: str) -> Edit:
    """Behind the last import, else above the first line that is neither empty nor a comment."""
    imports = [m.end() for m in _IMPORT.finditer(text)]
    if imports:
        return imports[-1], imports[-1], f"\n{line}"
    offset = 0
    for row in text.splitlines(keepends=True):
        if row.strip() and (not row.lstrip().startswith("#") or row.startswith("##")):
            break
        offset += len(row)
    return offset, offset, f"{line}\n\n"


def _addition(text: str, start: int, item: str) -> Iterator[Fix]:
    """An item that a block lacks, before the brace that ends the declaration at `start`."""
    end = re.compile(r"^\}", re.MULTILINE).search(text, start)
    if end is not None and item.startswith(("effector", "fact")):
        yield Fix(f"Add `{item}`", ((end.start(), end.start(), f"    {item}\n"),))
    elif item.startswith("normal"):
        line = text.find("\n", start)
        place = line if line >= 0 else len(text)
        yield Fix(f"Add `{item}`", ((place, place, f" {item}"),))


def _unit(text: str, start: int, end: int) -> Iterator[Fix]:
    word = text[start:end]
    number = _NUMBER_BEFORE.search(text, 0, start)
    if word in _METRES and number is not None:
        written = f"{float(number[1]) * _METRES[word]:.6g} m"
        yield Fix(f"Write `{written}`", ((number.start(), end, written),))


def _ordered_parts(text: str, start: int) -> Iterator[Fix]:
    """The parts of the rule around `start` in their order; none where one stands twice."""
    heads = [m.start() for m in re.finditer(r"^rule\b", text, re.MULTILINE) if m.start() <= start]
    if not heads:
        return
    close = re.compile(r"^\}", re.MULTILINE).search(text, heads[-1])
    end = len(text) if close is None else close.start()
    found = list(_PART.finditer(text, heads[-1], end))
    names = [m[1] for m in found]
    if len(set(names)) < len(names) or not found:
        return
    ends = [*(m.start() for m in found[1:]), end]
    parts = {m[1]: text[m.start() : e] for m, e in zip(found, ends, strict=True)}
    ordered = "".join(parts[name] for name in ("pre", "where", "post", "cost") if name in parts)
    yield Fix("Put the parts in their order", ((found[0].start(), end, ordered),))
