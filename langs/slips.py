"""Slips in this language itself: parts in another order, a sign too many, and parentheses, commas or names that lack.

All begin and end on one line, and are tried like the forms of other languages, by the same recovery.
"""

from __future__ import annotations

import re

from .idiom import ITEM, LITERAL, NAME, idiom

SHAPE = r"(?:box|sphere|capsule|cylinder|hull|mesh|union)"
SIZES = rf"{SHAPE}[ \t]*\([^()\n]*\)"
UNIT = r"(?:mm|cm|m|deg|rad|kg|g|s|min|N)"
QUANTITY = rf"(?:-[ \t]*)?\d[\d.]*(?:[ \t]*{UNIT}\b(?:/s)?)?"
PLACED = rf"{NAME}(?:\[[^\]\n]*\])*"
BEHIND = r"(?:at|on|heading|normal|home|holds|mass|density|speed|torque)"
WEIGHTS = ("mass", "density", "torque", "force", "bearing", "rotor", "brake", "holds")
CLAUSES = (("on",), ("at", "in"), ("heading", "normal", "home"), ("speed",), ("acceleration",), ("jerk",), ("passive",),
           WEIGHTS)  # fmt: skip
ORDER = {word: place for place, words in enumerate(CLAUSES) for word in words}
"""In which order the clauses of bodies, robots, ends and joints stand."""
VECTOR = r"\([^(),\n]+,[^(),\n]+,[^(),\n]+\)"
HEADS = r"(?:task|scene|rule|module|function|heuristic)"


def _commas(match: re.Match[str]) -> str:
    found = re.findall(QUANTITY, match["x"])
    return ", ".join(found)


def _scaled(match: re.Match[str]) -> str:
    """`(0, 40, 50) cm`, with the unit at each number."""
    return "(" + ", ".join(f"{part.strip()} {match[3]}" for part in match[2].split(",")) + ")"


def _literal(match: re.Match[str]) -> str:
    return f"({' '.join([match[2], *re.split(r'[ ,]+', match[3].strip())]).strip()})"


def _imports(match: re.Match[str]) -> str:
    head = match["head"] or ""
    return "\n".join(f"import {head}{name}" for name in re.findall(r"[\w.]+", match["names"]))


def _when(match: re.Match[str]) -> str:
    """When the row of the match binds."""
    line = match.string[match.string.rfind("\n", 0, match.start("x")) + 1 : match.start("x")]
    found = re.match(r"[ \t]*(at[ \t]+switch|during)\b", line)
    return found[1] if found is not None else "at switch"


def _between(match: re.Match[str]) -> str:
    """`low <= f(X) <= high`, and `f(X) in low .. high`."""
    low, value, high = match["low"].strip(), match["value"].strip(), match["high"].strip()
    return f"{value} >= {low} {_when(match)} {value} <= {high}"


def _together(names: str) -> str:
    """`X, Y: object` as the names of one type."""
    return re.sub(rf"({NAME})[ \t]*,[ \t]*(?=(?:{NAME}[ \t]*,[ \t]*)*{NAME}[ \t]*:)", r"\1 ", names)


def _bare_parameters(match: re.Match[str]) -> str:
    kind = "int" if match[1] in ("task", "scene", "function", "module") else "object"
    found = [part.strip() for part in match["x"].split(",")]
    return ", ".join(re.sub(rf"^({NAME})(?=[ \t]*=|$)", rf"\1: {kind}", part) for part in found)


def _in_order(match: re.Match[str]) -> str:
    """The clauses of an item in the order in which they are read."""
    text, depth = match["x"], 0
    begun: list[tuple[int, int]] = []
    for found in re.finditer(r"[()]|\w+", text):
        depth += {"(": 1, ")": -1}.get(found[0], 0)
        if depth == 0 and found[0] in ORDER:
            begun.append((found.start(), ORDER[found[0]]))
    ends = [start for start, _ in begun[1:]] + [len(text)]
    clauses = [(place, text[start:end].strip()) for (start, place), end in zip(begun, ends, strict=True)]
    return " ".join(clause for _, clause in sorted(clauses, key=lambda clause: clause[0]))


def _directed(match: re.Match[str]) -> str:
    """`0.3 m along x`, or along a vector with one number, as a vector."""
    way, far = match["way"], match["far"]
    numbers = [n.strip() for n in way.strip("()").split(",")] if "," in way else [str(int(way[-1] == c)) for c in "xyz"]
    sign = "-" if way.startswith("-") else ""
    parts = {"0": "0", "1": f"{sign}{far}", "-1": f"-{far}"}
    return f"({', '.join(parts.get(n, f'{n} * {far}') for n in numbers)})"


def _apart(match: re.Match[str]) -> str:
    """`object a, b: sphere(4 cm) …` as one item each."""
    names = [name.strip() for name in match["names"].split(",")]
    return "\n    ".join(f"{match['kind']} {name}: {match['rest'].strip()}" for name in names)


def _typed_signature(match: re.Match[str]) -> str:
    return ", ".join(f"{name}: object" for name in re.findall(NAME, match["x"]))


SLIPS = (
    # --- the order of parts
    idiom(rf":[ \t]*(?P<x>((?:at[ \t]*\([^()\n]*\)|on[ \t]+{PLACED})(?:[ \t]+at[ \t]*\([^()\n]*\))?)[ \t]+({SIZES}))",
          "the shape stands in front of the place", r"\3 \2"),
    idiom(rf":[ \t]*(?P<x>on[ \t]+({PLACED})[ \t]+(?!at\b|heading\b)({NAME}))(?=[ \t]+at\b|[ \t]*$)",
          "the end of the robot stands in front of `on`", r"\3 on \2"),
    idiom(rf":[ \t]*(?P<x>on[ \t]+({PLACED}))(?=[ \t]+(?:at|heading)\b|[ \t]*$)",
          "a robot stands on one of its ends", r"A on \2",
          help="name that end in front, such as `A on ground`"),
    idiom(rf":[ \t]*(?P<x>({NAME})[ \t]+at[ \t]+({PLACED})[ \t]*(?=\())",
          "a robot stands `on` something, and `at` a place of it",
          r"\2 on \3 at "),
    idiom(rf"(?P<x>(heading[ \t]+{QUANTITY})[ \t]+({NAME}[ \t]+on[ \t]+{PLACED}(?:[ \t]+at[ \t]*\([^()\n]*\))?))",
          "`heading` stands behind the place", r"\3 \2"),
    idiom(rf":[^\n{{}}#]*?(?P<x>\b(?:{'|'.join(ORDER)})\b[^\n{{}}#]*\b(?:{'|'.join(ORDER)})\b[^\n{{}}#]*?)"
          r"(?=[ \t]*(?:[}#]|$))", "these stand in another order", _in_order),
    idiom(rf"\blink[ \t]+{QUANTITY}(?P<x>((?:[ \t]+(?:mass|density)[ \t]+{QUANTITY})+)[ \t]*(:[ \t]*{SIZES}))",
          "the shape of a link stands in front of its weight", r"\3\2"),
    idiom(rf"\blink[ \t]+(?P<x>(?P<far>{QUANTITY})[ \t]+(?:along|in)[ \t]+(?P<way>-?[xyz]\b|{VECTOR}))",
          "a link goes on along z, or by a vector", _directed),
    idiom(rf"\blink[ \t]+(?P<x>({SIZES})[ \t]*:?[ \t]*({QUANTITY}))",
          "the length of a link stands in front of its shape",
          r"\3: \2"),
    idiom(rf"\beffector[ \t]+{NAME}[ \t]*:[ \t]*(?P<x>({SIZES})[ \t]+(?!{BEHIND}\b)({NAME}))",
          "the type of an effector stands in front of its shape", r"\3 \2"),
    idiom(rf"^[ \t]*{NAME}[ \t]+(?P<x>({PLACED})[ \t]+((?:at[ \t]*\([^()\n]*\)|on[ \t]+{PLACED})+)[ \t]*:"
          rf"[ \t]*({SIZES}))", "the place stands behind the shape", r"\2: \4 \3"),
    idiom(rf":[ \t]*(?P<x>{PLACED}\.)(?={NAME}[ \t]+on\b)", "an end is named without its robot here"),
    idiom(r"(?P<x>\b(?:on[ \t]+(?:the[ \t]+)?top[ \t]+of|onto|upon|atop)\b)",
          "what something stands on is named behind `on`",
          "on"),
    # --- names and types
    idiom(rf"^(?P<x>({HEADS})[ \t]*)(?=\(|\{{)", "what is declared has a name", r"\2 first",
          help="such as `first` in `task first() { … }`"),
    idiom(rf"\b{HEADS}[ \t]+(?P<x>({NAME})[ \t]+({NAME}))(?=[ \t]*[({{=])", "a name is one word", r"\2_\3"),
    idiom(rf"^[ \t]*(?P<x>(?P<kind>{NAME})[ \t]+(?P<names>{NAME}(?:[ \t]*,[ \t]*{NAME})+)[ \t]*:(?P<rest>[^\n#{{}}]+))",
          "what is put into a scene has one name", _apart),
    idiom(rf"^[ \t]*(?P<x>({NAME})[ \t]*\[([^\[\]\n]+)\][ \t]+({NAME})[ \t]*:)",
          "several are put into a scene by `for`, and counted behind the name", r"\2 \4[\3]:",
          help="such as `for k in 1 .. 3 { crawler c[k]: A on ground at (k * 1 m, 0) }`"),
    idiom(rf"\b(?:forall|exists|for)[ \t]+{NAME}(?P<x>[ \t]*:[ \t]*int)(?=[ \t]+in\b)", "what counts has no type"),
    idiom(rf"\b(?:forall|exists)\b[^\n{{}}:]*(?P<x>:[ \t]*({LITERAL}))[ \t]*(?=$|,)",
          "what is said of all or of some stands between `{` and `}`", r" { \2 }"),
    idiom(r"(?P<x>\bfor[ \t]+all\b)", "`for all` is one word here", "forall", code="E0004"),
    idiom(rf"(?P<x>\b(?:rotated|turned|facing|yaw|rotation)(?:[ \t]+by)?(?:[ \t]*[:=])?)(?=[ \t]*{QUANTITY})",
          "how something is turned stands behind `heading`", "heading"),
    idiom(r"\bfact[ \t]*\([^()\n]*\)(?P<x>[ \t]+\()", "each fact has its own `fact`", "\n    fact ("),
    idiom(rf"\b(?:on|of|in)[ \t]+(?P<x>(?:the|a)[ \t]+)(?={NAME})", "names stand without articles"),
    idiom(r"^[ \t]*(?P<x>(?:fact[ \t]+)?not[ \t]*\([^()\n]*\))[ \t]*$",
          "what is not stated does not hold at the start", "",
          help="leave it out; what must not hold in the end stands behind `goal`: `goal not (held ball)`"),
    idiom(rf"\bmodule[ \t]+{NAME}(?P<x>([ \t]*\([^()\n]*\))?[ \t]*\{{\s*from[ \t]+urdf[ \t]+(\"[^\"\n]*\"))",
          "the URDF of a module is named in front of its braces", r"\2 from urdf \3 {",
          help='such as `module arm from urdf "arm.urdf" { … }`'),
    idiom(rf"(?P<x>\"({NAME})\")", "names stand without quotes", r"\2"),
    idiom(rf"^[ \t]*(?P<x>(object|base|region)[ \t]*:)(?=[ \t]*{SIZES})", "a body has a name", r"\2 first:",
          help="such as `object ball: sphere(4 cm)`"),
    idiom(rf"^[ \t]*(?P<x>({PLACED})[ \t]*:)(?=[ \t]*{SHAPE}\b)", "the type of a body stands in front of its name",
          r"object \2:"),
    idiom(rf"\b{NAME}[ \t]+(?P<x>({NAME})[ \t]*\(([^()\n]*)\))(?=[ \t]*:)", "things are counted in square brackets",
          r"\2[\3]"),
    idiom(rf"^[ \t]*(?P<x>({NAME})[ \t]+({NAME})[ \t]*:)(?=[ \t]*{SIZES})", "an end of a module begins with `effector`",
          r"effector \3: \2"),
    idiom(rf"\blink[ \t]+(?P<x>{NAME}[ \t]*:?[ \t]+)(?=\d)", "links have no names"),
    idiom(r"\bjoint[ \t]+(?P<x>(revolute|prismatic)[ \t]*\()", "a joint has a name", r"j: \2(",
          help="such as `joint j1: revolute(y)`"),
    idiom(rf"\b(task|scene|rule|function|module|heuristic)\b[^\n(]*\((?P<x>[^()\n]*\b{NAME}[ \t]*(?:[,=][^()\n]*)?)\)",
          "a parameter has a type", _bare_parameters, code="E0003"),
    # --- parentheses, commas and signs
    idiom(rf":[ \t]*(?P<x>({SHAPE})[ \t]*\[([^\[\]\n]*)\])", "the sizes of a shape stand in parentheses", r"\2(\3)"),
    idiom(rf":[ \t]*(?P<x>({SHAPE})[ \t]+({QUANTITY}(?:[ \t]*,[ \t]*{QUANTITY})*))",
          "the sizes of a shape stand in parentheses", r"\2(\3)"),
    idiom(rf"\b{SHAPE}[ \t]*\([^()\n]*?(?P<x>{NAME}[ \t]*[:=][ \t]*)(?=[-\d])", "the sizes of a shape have no names"),
    idiom(rf":[ \t]*(?P<x>({SHAPE}))(?=[ \t]+(?:at|on)\b|[ \t]*$)", "the sizes of this shape lack", r"\2(1 mm)",
          help="they stand in parentheses, such as `sphere(4 cm)` or `box(10 cm, 10 cm, 4 cm)`"),
    idiom(r"\b(?P<x>(revolute|prismatic)[ \t]+([xyz]))\b", "the axis of a joint stands in parentheses", r"\2(\3)"),
    idiom(r"\b(?P<x>(revolute|prismatic))(?=[ \t]+(?:in|home)\b|[ \t]*$)", "a joint has an axis", r"\2(z)",
          help="it stands in parentheses: `revolute(x)`, `revolute(y)` or `revolute(z)`"),
    idiom(rf"(?P<x>{QUANTITY}(?:(?:[ \t]*[x×][ \t]*|[ \t]+){QUANTITY})+)(?=[ \t]*[,)])",
          "values are separated by commas",
          _commas),
    idiom(rf"(?P<x>\(([^()\n]*)\)[ \t]*({UNIT}))\b", "each number has its own unit", _scaled),
    idiom(rf"\b(?:at|normal|by|along)[ \t]+(?P<x>{ITEM}+(?:,{ITEM}+?){{1,2}})(?=[ \t]*$|[ \t]+{BEHIND}\b)",
          "a vector stands in parentheses", r"(\g<x>)"),
    idiom(r"\b(?:at|on|in|heading|normal|home|mass|density|torque|speed|acceleration|jerk|along|by|switch|during|keep"
          r"|link|post|pre|cost)(?P<x>[ \t]*[:=])(?!=)", "no sign stands behind this word"),
    idiom(r"(?P<x>;)(?=[ \t]*[\w(\[-])", "unknown character `;`", ",", code="E0002"),
    idiom(rf"(?<![\w.)\]])(?P<x>\.(\d+(?:[ \t]*{UNIT}\b)?))", "a number starts with a digit", r"0.\2"),
    idiom(r"(?P<x>\b(?:begin|do)\b)(?=[ \t]*$)", "a block stands between `{` and `}`", "{"),
    idiom(r"(?P<x>(?<![=<>!])=[ \t]*)(?=\{)", "nothing stands between the head of a block and its `{`"),
    idiom(r"\b(?:goal|pre|post|where|fact)[ \t]*(?P<x>\{[ \t]*([^{}\n]*?)[ \t]*\})",
          "what follows this word has no braces",
          r" \2"),
    idiom(r"\boptions[ \t]*(?P<x>\(([^(){}\n]*)\))", "options stand between `{` and `}`", r"{ \2 }"),
    idiom(rf"\boptions[ \t]+(?P<x>({NAME}[ \t]*=[^{{}}\n]+?))[ \t]*$", "options stand between `{` and `}`", r"{ \2 }"),
    idiom(r"^[ \t]*(?P<x>minimi[sz]e[ \t]*[:=]?[ \t]*([\w.*+ \t-]+?))[ \t]*$",
          "what to minimise stands among the options",
          r"options { minimise \2 }"),
    idiom(r"(?P<x>\bminimize\b[ \t]*:?)", "`minimize` is no keyword", "minimise", code="E0004"),
    idiom(r"^[ \t]*(?P<x>((?:time|memory|bound|horizon|solutions)[ \t]*[:=][ \t]*[\w.]+(?:[ \t]*(?:s|min)\b)?))[ \t]*$",
          "options stand in a block of their own", lambda m: f"options {{ {m[2].replace(':', ' =')} }}"),
    # --- literals and effects
    idiom(r"(?P<x>\b(?:del|delete|remove|retract)\b[ \t]*)(?=[(\[])", "what is deleted stands behind `not`", "not "),
    idiom(r"(?P<x>\b(?:add|insert|assert)\b[ \t]*)(?=[(\[])", "what is added needs no word"),
    idiom(rf"\b(?:fact|goal|post|not|pre)[ \t]*(?P<x>({NAME})[ \t]*\(([^()\n]*)\))",
          "the name of a literal stands inside its parentheses",
          _literal, code="E0016"),
    idiom(rf",[ \t]*(?P<x>({NAME})[ \t]*\(([^()\n]*)\))(?=[ \t]*(?:,|$))",
          "the name of a literal stands inside its parentheses",
          _literal, code="E0016"),
    idiom(r"[)\]](?P<x>[ \t]*\band\b[ \t]*)(?=(?:not\b[ \t]*)?[(\[])", "effects are separated by commas", ", "),
    idiom(r"[)\]](?P<x>[ \t]*\bor\b[ \t]*)(?=(?:not\b[ \t]*)?[(\[])", "the effects of a rule are no choice", ", ",
          help="write a rule for each of them"),
    idiom(r"(?P<x>~[ \t]*)(?=[(\[])", "unknown character `~`", "not ", code="E0002"),
    idiom(rf"^[ \t]*post\b[^\n]*?(?P<x>,[ \t]*{NAME}[ \t]*\([^()\n]*\)[ \t]*[<>=]+[^,\n]+)", "an effect is a literal",
          help="a condition stands in `pre`, one on lengths in `where`"),
    idiom(r"^[ \t]*(?P<x>(\([^()\n]*\)))[ \t]*$", "a literal stands behind `fact` or `goal`", r"fact \2",
          help="put `fact` in front of what holds at the start, `goal` in front of what is wanted"),
    # --- the heads of predicates
    idiom(rf"\bmotion[ \t]+(?P<x>\[?[ \t]*({NAME})[ \t]*[\[(][ \t]*([^()\[\]\n]*)[\])][ \t]*\]?)",
          "a motion predicate stands in square brackets, its name too", lambda m: f"[{m[2]} {_together(m[3])}]"),
    idiom(rf"\bmotion[ \t]+(?P<x>\([ \t]*({NAME}[^()\n]*)\))",
          "a motion predicate stands in square brackets, its name too",
          lambda m: f"[{_together(m[2])}]"),
    idiom(rf"\bmotion[ \t]+(?P<x>\[({NAME}(?:[ \t]+{NAME})*[ \t]*,[^\[\]\n]*)\])",
          "names of one type stand side by side",
          lambda m: f"[{_together(m[2])}]"),
    idiom(rf"\b(?:predicate|derived)[ \t]+(?P<x>\(({NAME}(?:[ \t]+{NAME})*[ \t]*,[^()\n]*:[^()\n]*)\))",
          "names of one type stand side by side", lambda m: f"({_together(m[2])})"),
    idiom(rf"\b(?:predicate|derived)[ \t]+\({NAME}[ \t]+(?P<x>{NAME}(?:[ \t,]+{NAME})*)[ \t]*\)",
          "a parameter has a type",
          _typed_signature, code="E0003"),
    idiom(rf"\bmotion[ \t]+\[{NAME}[ \t]+(?P<x>{NAME}(?:[ \t,]+{NAME})*)[ \t]*\]", "a parameter has a type",
          _typed_signature, code="E0003"),
    idiom(rf"\b(?:predicate|derived)[ \t]+(?P<x>({NAME}[ \t]+[^()\n=]*:[ \t]*{NAME}))",
          "a predicate stands in parentheses",
          r"(\2)"),
    # --- rows of motion predicates
    idiom(r"^[ \t]*(?P<x>(?:always|throughout|whenever|through)\b(?:[ \t]*:)?)",
          "a row binds `at switch` or `during` a phase",
          "during"),
    idiom(r"^[ \t]*(?P<x>at[ \t]+(?:the[ \t]+)?(?:end|finish|goal|contact)\b(?:[ \t]*:)?)",
          "a row binds `at switch` or `during` a phase", "at switch"),
    idiom(rf"(?P<x>(?P<low>{QUANTITY})[ \t]*<=[ \t]*(?P<value>{NAME}\([^()\n]*\))[ \t]*<=[ \t]*(?P<high>{QUANTITY}))",
          "a row compares two sides", _between),
    idiom(rf"(?P<x>(?P<value>{NAME}\([^()\n]*\))[ \t]+in[ \t]+(?P<low>{QUANTITY})[ \t]*\.\.[ \t]*(?P<high>{QUANTITY}))",
          "a row compares two sides", _between),
    idiom(rf"[<>=][ \t]*[^<>=\n]*?(?P<x>([\w)]+)[ \t]*(?:,|\band\b|&&))(?=[ \t]*{NAME}[ \t]*\([^\n]*[<>=])",
          "each row says when it binds", lambda m: f"{m[2]} {_when(m)}"),
    # --- joints and ranges
    idiom(rf"(?P<x>\b(?:limits?|range|between|from)[ \t]*[:=]?[ \t]*)(?={QUANTITY}[ \t]*\.\.)",
          "the limits of a joint stand behind `in`", "in "),
    idiom(rf"(?P<x>(?:\+[ \t]*/?[ \t]*-|±)[ \t]*(\d[\d.]*(?:[ \t]*{UNIT})?))",
          "a range has both its ends", r"-\2 .. \2"),
    idiom(rf"\bin[ \t]+(?P<x>({QUANTITY})[ \t]*(?:,|-|:|\bto\b|\bthrough\b)[ \t]*({QUANTITY}))"
          rf"(?=[ \t]*$|[ \t]+{BEHIND}\b)",
          "a range has `..` between its ends", r"\2 .. \3"),
    idiom(r"\bin[ \t]+(?P<x>(\d+))(?=[ \t]*\{)", "a range has both its ends", r"1 .. \2"),
    idiom(r"^[ \t]*for\b[^\n{}:]*\bin\b[^\n{}:]*?(?P<x>[ \t]*:[ \t]*([^{}\n]+?))[ \t]*$",
          "what is repeated stands between `{` and `}`",
          r" { \2 }"),
    idiom(r"^[ \t]*(?P<x>(?:repeat|loop)[ \t]+(\w+)(?:[ \t]+times)?)(?=[ \t]*\{)",
          "`for` repeats items", r"for k in 1 .. \2"),
    idiom(r"^[ \t]*(?P<x>while\b[^{}\n]*)(?=\{)", "there is no `while`", "if 1 < 2 ",
          help="`for k in 1 .. n { … }` repeats items, and rules are done as often as it takes"),
    # --- imports and what stands at the head of a line
    idiom(rf"import[ \t]+(?P<head>)(?P<names>{NAME}(?:\.\w+)*(?:[ \t]*,[ \t]*{NAME}(?:\.\w+)*)+)",
          "an import names one file",
          _imports),
    idiom(rf"import[ \t]+(?P<head>(?:{NAME}\.)+)\{{(?P<names>[^{{}}\n]*)\}}", "an import names one file", _imports),
    idiom(r"import[ \t]+std[ \t]+(\w+)", "the parts of an import are joined by points", r"import std.\1"),
    idiom(r"import[ \t]+\w+(?:::\w+)+", "the parts of an import are joined by points", lambda m: m[0].replace("::",
          ".")),
    idiom(r"^(?P<x>(?:use|load|require|open|#include)[ \t]+(std(?:\.\w+)+))", "a library is taken over by `import`",
          r"import \2"),
    idiom(r"^(?P<x>(std(?:\.\w+)+))[ \t]*$", "a library is taken over by `import`", r"import \2"),
    idiom(rf"^(?P<x>(?:def|fn|func|fun|procedure|void|let)[ \t]+)(?={HEADS}\b)", "a declaration begins with its kind"),
    idiom(r"^(?P<x>(?:def|fn|func|fun|procedure|void)\b)(?=[^\n=]*\{)", "a declaration begins with its kind", "task",
          help="write `task`, `rule` or `function`"),
    idiom(r"^(?P<x>(?:def|fn|func|fun)\b)(?=[^\n]*=)", "a declaration begins with its kind", "function"),
    idiom(r"^[ \t]*(?P<x>(?:print|echo|log|assert|return)\b[^{}\n]*)$",
          "a program only says what is, and what is wanted"),
    idiom(r"(?P<x>\b(?:position|pos|location|origin|xyz|pose)[ \t]*[:=]?[ \t]*)(?=\()", "a place stands behind `at`",
          "at "),
    idiom(r"(?P<x>\b(?:colou?r|material|texture)[ \t]*[:=]?[ \t]*(?:\([^()\n]*\)|\"[^\"\n]*\"|\w+))",
          "bodies have no looks; the report colours them"),
    idiom(rf"^type[ \t]+{NAME}[ \t]+(?P<x>is[ \t]+an?\b)", "a type stands below another one, behind `<`", "<"),
    idiom(rf"^type[ \t]+(?P<x>({NAME})[ \t]*\([ \t]*({NAME})[ \t]*\)?)", "a type stands below another one, behind `<`",
          r"\2 < \3"),
    idiom(rf"\bfunction\b[^\n=]*\)(?P<x>[ \t]*(?:->|:)[ \t]*{NAME})(?=[ \t]*=)",
          "the type of a function follows from its value"),
    idiom(r"(?P<x>\bis\b)", "`:` stands between a name and what it is", ":"),
    idiom(r"(?P<x>,)[ \t]*$", "nothing follows this `,`"),
)  # fmt: skip
"""What is read as its replacement is never certain to be meant: the message says what the language asks for."""
