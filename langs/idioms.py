"""Forms of Python, PDDL, URDF and other languages, as they are written, and how this language says the same.

Each is a pattern of text. Around a mistake the recovery tries those that fit there: what the pattern calls `x`, else
all that it matches, is read as its replacement. One is taken only where more can be read with it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from .idiom import ITEM, LITERAL, NAME, Idiom, idiom
from .slips import SLIPS


def _groups(text: str) -> list[str]:
    """The parts of a text that stand in parentheses side by side."""
    found, depth, start = [], 0, 0
    for index, sign in enumerate(text):
        if sign == "(":
            start = index if depth == 0 else start
            depth += 1
        elif sign == ")":
            depth -= 1
            found += [text[start : index + 1]] if depth == 0 else []
    return found


def _component(match: re.Match[str]) -> str:
    """`position(X).z`, along an axis of the world."""
    axis = ", ".join(str(int(match[3] == letter)) for letter in "xyz")
    return f"dot({match[2]}, ({axis}))"


def _infix(match: re.Match[str]) -> str:
    """`(and (a X) (not (b X)))`, with the word between its parts."""
    parts = [re.sub(r"^\(\s*not\s+(\(.*\))\s*\)$", r"not \1", part) for part in _groups(match[2])]
    return (", " if match[1] == "and" else " or ").join(parts)


def _typed(match: re.Match[str]) -> str:
    """`?a ?b - gripper ?x - base` as parameters."""
    parts = re.findall(r"((?:\??\w+[ \t]+)+)-[ \t]*(\w+)", match["x"])
    return ", ".join(f"{names.replace('?', '').strip()}: {type}" for names, type in parts)


def _otherwise(match: re.Match[str]) -> str:
    """`else`, by the condition of the `if` before it."""
    before = re.findall(r"\bif\b[ \t]*([^{}\n]+?)[ \t]*\{", match.string[: match.start("x")])
    return f"if not ({before[-1]})" if before else ""


def _comment(match: re.Match[str]) -> str:
    inner = re.sub(r"^(?://+|/\*+|\"\"\"|''')|(?:\*+/|\"\"\"|''')$", "", match[0])
    return "\n".join(f"# {line.strip().lstrip('*').strip()}".rstrip() for line in inner.strip().split("\n"))


WORDS = {
    "action": "rule", "operator": "rule", "durative_action": "rule", "precondition": "pre", "preconditions": "pre",
    "requires": "pre", "require": "pre", "condition": "pre", "conditions": "pre", "effect": "post", "effects": "post",
    "ensures": "post", "init": "fact", "initial": "fact", "initially": "fact", "given": "fact",
    "start": "fact", "objective": "goal",
    "target": "goal", "problem": "task", "mission": "task", "world": "scene", "environment": "scene", "robot": "module",
    "class": "type", "struct": "type", "include": "import", "using": "import", "constraint": "during",
    "heuristics": "heuristic", "segment": "link", "endeffector": "effector", "end_effector": "effector",
    "tool": "effector", "foreach": "for",
}  # fmt: skip
"""What other languages call a keyword of this one."""

IDIOMS = (
    idiom(r"\A\s*(?P<x><[?!\w][\s\S]*)", "this is XML, not a program",
           help='a robot is read by `module arm from urdf "FILE" { … }`, in a program beside it'),
    idiom(r"\A\s*(?P<x>(?:;[^\n]*\s+)*\(\s*define\b[\s\S]*)", "this is PDDL, not a program of this language",
           help="`type`, `predicate`, `rule` and `task` say the same here; docs/tutorial.md shows how"),
    idiom(r"//[^\n]*|/\*[\s\S]*?\*/|\"\"\"[\s\S]*?\"\"\"|'''[\s\S]*?'''", "a comment begins with `#`",
           _comment, code="E0002"),
    idiom(r"import[ \t]+\w+(?:/\w+)+(?:\.tamp\b)?", "the parts of an import are joined by points",
           lambda m: m[0].removesuffix(".tamp").replace("/", ".")),
    idiom(rf"import[ \t]+({NAME}(?:\.\w+)*)[ \t]+as[ \t]+\w+", "an import takes over names as they are", r"import \1"),
    idiom(r"import[ \t]+\w+(?:\.\w+)*\.\*", "an import names one file",
           help="name each of them, such as `import std.rules` and `import std.crawler`"),
    idiom(rf"^[ \t]*(?:{'|'.join(WORDS)})\b", "", code="E0004"),
    idiom(rf"^[ \t]*(?P<x>({NAME}(?:\[[^\]\n]*\])*)[ \t]*:[ \t]*({NAME})[ \t]+)(?={NAME}[ \t]*(?:\(|on\b|at\b))",
           "the type stands before the name", r"\3 \2: ", code="E0003"),
    idiom(r"(?P<x>at[ \t]*(\([^()\n]*\))[ \t]+(\w+[ \t]+on[ \t]+[\w.\[\]]+))", "`at` stands behind what it stands on",
           r"\3 at \2"),
    idiom(r"\b(?:force|shear|moment|twist|friction)[ \t]*(?P<x>[=:])(?=[ \t]*[\w.(-])",
           "strengths stand behind their names, as in `force 90 N`"),
    idiom(rf"(?P<x>\b({NAME}|[0-9.]+)[ \t]*(?:\*\*|\^)[ \t]*2)\b", "there are no powers", r"\2 * \2"),
    idiom(r"(?P<x>[ \t]*(?:\*\*|\^)[ \t]*[\w.]+)", "there are no powers", help="a product says the same: `x * x * x`"),
    idiom(rf"(?P<x>({LITERAL})[ \t]*(?:->|=>|==>|implies\b)[ \t]*)(?=[(\[n])", "there is no implication",
           r"not \2 or "),
    idiom(rf"function[ \t]+({NAME})[ \t]*\(([^)\n]*)\)[^{{=\n]*\{{\s*(?:return\b)?[ \t]*([^}}\n]*?)[ \t]*;?\s*\}}",
           "a function is a value, behind `=`", r"function \1(\2) = \3"),
    idiom(rf"^[ \t]*(?P<x>(?:(?:let|var|const)[ \t]+)?{NAME}[ \t]*:?=[ \t]*[^={{}}\n]+)$", "there are no variables",
           help="give the task a parameter, such as `task t(h: length = 1 m)`, or declare a `function`"),
    idiom(r"\((?P<x>(?:\??\w+[ \t]+)+-[ \t]*\w+(?:,?[ \t]+(?:\??\w+[ \t]+)+-[ \t]*\w+)*)[ \t]*\)",
           "the type stands behind the name, after `:`", _typed, code="E0003"),
    idiom(r"(?P<x>\?(\w+))", "variables have no sign in front of them", r"\2", code="E0002"),
    idiom(r"\([ \t]*(and|or)[ \t]+((?:\((?:[^()\n]|\([^()\n]*\))*\)[ \t]*)+)\)",
           "`and` and `or` stand between conditions", _infix),
    idiom(rf"\([ \t]*not[ \t]+({LITERAL})[ \t]*\)", "`not` stands in front of the literal", r"not \1"),
    idiom(rf"when[ \t]+({LITERAL})[ \t]+(?:\([ \t]*(not[ \t]+{LITERAL})[ \t]*\)|({LITERAL}))",
           "an effect under a condition is written with `if`", lambda m: f"if {m[1]} {{ {m[2] or m[3]} }}"),
    idiom(rf"\b{NAME}(?:-[A-Za-z_]\w*)+\b", "a name has no `-` in it", lambda m: m[0].replace("-", "_")),
    idiom(r"\b(\d+)([A-Za-z_]\w*)\b", "a name starts with a letter", r"\2\1"),
    idiom(rf"^[ \t]*{NAME}[ \t]+(?P<x>({NAME})[ \t]+({NAME}))(?=[ \t]*:)", "a name is one word", r"\2_\3"),
    idiom(rf"(?:predicate|derived)[ \t]+(?P<x>({NAME})[ \t]*\(([^()\n]*)\))", "the name stands inside the parentheses",
           r"(\2 \3)"),
    idiom(r"type[ \t]+\w+[ \t]*(?P<x>:|extends\b|inherits\b|is\b|-)(?=[ \t]*\w)",
           "a type stands below another one, behind `<`", "<"),
    idiom(rf"(?:rule|task|scene|function|module)[ \t]+{NAME}(?P<x>[ \t]+({NAME}[^{{(\n]*:[^{{(\n]*?))[ \t]*\{{",
           "parameters stand in parentheses", r"(\2)", code="E0003"),
    idiom(r"^[ \t]*(?P<x>[A-Za-z(][^{}\n]*?[<>=][^{}\n]*)$", "a row says when it binds",
           lambda m: f"at switch {m['x']}"),
    idiom(rf"^[ \t]*(?P<x>joint[ \t]+{NAME}[ \t]*:[ \t]*(?:fixed|rigid)\b[^\n]*)$", "a joint moves",
           help="leave it out: what is fixed is one `link`"),
    idiom(rf"\bin[ \t]*(?P<x>[\[(][ \t]*({ITEM}+?)[ \t]*,[ \t]*(?:{ITEM}+,[ \t]*)*({ITEM}+?)[ \t]*[\])])",
           "a range has `..` between its ends", r"\2 .. \3"),
    idiom(r"(?P<x>from[ \t]+([^\n]+?)[ \t]+to[ \t]+(-?[\w.]+(?:[ \t]+[a-z]\w*)?))", 
           "a range has `..` between its ends", r"in \2 .. \3"),
    idiom(r"module[^\n]*?\bfrom[ \t]+(?P<x>\"[^\"\n]*\")", "`urdf` says what the file is", r"urdf \g<x>",
           code="E0003"),
    idiom(r"\burdf[ \t]+(?P<x>[\w./-]+)", "the name of a file stands in quotes", r'"\g<x>"', code="E0003"),
    idiom(r"(?P<x>\b(?:rpy|orientation|rotation|rotate|rotated|yaw|quat|quaternion)[ \t]*\([^)\n]*\))",
           "bodies turn only about the vertical", help="`heading 90 deg` does so; for more, exchange the sizes"),
    idiom(r"(?P<x>(\d[\d.]*)[ \t]*°)", "unknown character `°`", r"\2 deg", code="E0002"),
    idiom(r"(?P<x>==?[ \t]*(?:[Tt]rue)\b)", "a literal holds by being there"),
    idiom(r"(?P<x>\belse\b)", "a scene has no `else`", _otherwise),
    idiom(rf"^[ \t]*(?P<x>(?:heuristic|guided?[ \t]+by|use|using)[ \t]+({NAME}[ \t]*\([^(){{}}\n]*\)))[ \t]*$",
           "a task names its heuristic behind `guide`", r"guide \2"),
    idiom(r"^[ \t]*fact\b[^\n]*?(?P<x>,)[ \t]*(?=[(\[])", "every fact begins with `fact`", " fact"),
    idiom(r"\b(?:at|normal|by|along)[ \t]*(?P<x>[\[{]([^\[\]{}\n]*)[\]}])", "a vector stands in parentheses", r"(\2)"),
    idiom(r"^[ \t]*(?:goal|fact|guide|pre|where|post|cost|start)(?P<x>[ \t]*[:=])", "no sign stands behind this word"),
    idiom(r"^[ \t]*(?P<x>(?:(?:at|on)(?:_?[Ss]witch|[ \t]+(?:the|a|each|every)[ \t]+switch)|(?:on|when)[ \t]+switch)"
           r"\b(?:[ \t]*:)?)", "a row of switches begins with two words", "at switch"),
    idiom(rf"(?P<x>({NAME}[ \t]*\([^()\n]*\))[ \t]*\.[ \t]*([xyz])\b)", "a vector has no parts of its own",
           _component),
    idiom(r"(?P<x>,)(?=[ \t]*(?:at|on|in|heading|normal|home|mass|density|torque|speed|holds)\b)",
           "what is said of an item stands side by side"),
    *SLIPS,
)  # fmt: skip


def idioms(text: str, start: int, end: int, at: int) -> Iterator[tuple[Idiom, re.Match[str]]]:
    """Those that begin on the line from `start` to `end`, before or at the mistake `at` there."""
    for known in IDIOMS:
        last_place = len(text) if known.several_lines else end
        for match in known.pattern.finditer(text, start, last_place):
            first, last = known.stretch(match)
            if first > min(at, end):
                break
            if first < last:
                yield known, match
