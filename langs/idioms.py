"""Forms of Python, PDDL, URDF and other languages, as they are written, and how this language says the same.

Each is a pattern of text. Around a mistake the recovery tries those that fit there: what the pattern calls `x`, else
all that it matches, is read as its replacement. One is taken only where more can be read with it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator

from .frozen import dataclass

Writer = Callable[[re.Match[str]], str]


@dataclass(frozen=True, slots=True)
class Idiom:
    """`write` gives what is meant: a template, a function of the match, or None where it is left out. `help` is said
    where there is more to say than `write`."""

    pattern: re.Pattern[str]
    message: str
    write: str | Writer | None = None
    help: str | None = None
    code: str = "E0001"

    def meant(self, match: re.Match[str]) -> str:
        if self.write is None:
            return ""
        return match.expand(self.write) if isinstance(self.write, str) else self.write(match)

    def hint(self, match: re.Match[str]) -> str:
        return self.help or (f"write `{self.meant(match).strip()}`" if self.write is not None else "leave it out")

    def stretch(self, match: re.Match[str]) -> tuple[int, int]:
        """What is replaced."""
        return match.span("x") if "x" in self.pattern.groupindex else match.span()


def _idiom(pattern: str, message: str, write: str | Writer | None = None, help: str | None = None,
           code: str = "E0001") -> Idiom:  # fmt: skip
    return Idiom(re.compile(pattern, re.MULTILINE), message, write, help, code)


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


def _motion(match: re.Match[str]) -> str:
    words = re.split(r"[\s\[(]+", match["x"].strip("[]() \t"), maxsplit=1)
    return f"[{' '.join(words)}]"


def _otherwise(match: re.Match[str]) -> str:
    """`else`, by the condition of the `if` before it."""
    before = re.findall(r"\bif\b[ \t]*([^{}\n]+?)[ \t]*\{", match.string[: match.start("x")])
    return f"if not ({before[-1]})" if before else ""


def _comment(match: re.Match[str]) -> str:
    inner = re.sub(r"^(?://+|/\*+|\"\"\"|''')|(?:\*+/|\"\"\"|''')$", "", match[0])
    return "\n".join(f"# {line.strip().lstrip('*').strip()}".rstrip() for line in inner.strip().split("\n"))


def _typed_parameter(match: re.Match[str]) -> str:
    return f"{match['x']}: {'int' if match[1] in ('task', 'scene', 'function', 'module') else 'object'}"


WORDS = {
    "action": "rule", "operator": "rule", "durative_action": "rule", "precondition": "pre", "preconditions": "pre",
    "requires": "pre", "require": "pre", "condition": "pre", "conditions": "pre", "effect": "post", "effects": "post",
    "ensures": "post", "init": "fact", "initial": "fact", "initially": "fact", "given": "fact", "objective": "goal",
    "target": "goal", "problem": "task", "mission": "task", "world": "scene", "environment": "scene", "robot": "module",
    "class": "type", "struct": "type", "include": "import", "using": "import", "constraint": "during",
    "heuristics": "heuristic", "segment": "link", "endeffector": "effector", "end_effector": "effector",
    "tool": "effector", "foreach": "for",
}  # fmt: skip
"""What other languages call a keyword of this one."""

NAME = r"[A-Za-z_]\w*"
ITEM = r"[^,\[\]()\n]"
LITERAL = r"\([^()\n]*\)"
IDIOMS = (
    _idiom(r"\A\s*(?P<x><[?!\w][\s\S]*)", "this is XML, not a program",
           help='a robot is read by `module arm from urdf "FILE" { … }`, in a program beside it'),
    _idiom(r"\A\s*(?P<x>(?:;[^\n]*\s+)*\(\s*define\b[\s\S]*)", "this is PDDL, not a program of this language",
           help="`type`, `predicate`, `rule` and `task` say the same here; docs/tutorial.md shows how"),
    _idiom(r"//[^\n]*|/\*[\s\S]*?\*/|\"\"\"[\s\S]*?\"\"\"|'''[\s\S]*?'''", "a comment begins with `#`",
           _comment, code="E0002"),
    _idiom(r"import[ \t]+\w+(?:/\w+)+(?:\.tamp\b)?", "the parts of an import are joined by points",
           lambda m: m[0].removesuffix(".tamp").replace("/", ".")),
    _idiom(rf"import[ \t]+({NAME}(?:\.\w+)*)[ \t]+as[ \t]+\w+", "an import takes over names as they are", r"import \1"),
    _idiom(r"import[ \t]+\w+(?:\.\w+)*\.\*", "an import names one file",
           help="name each of them, such as `import std.rules` and `import std.crawler`"),
    _idiom(rf"^[ \t]*(?:{'|'.join(WORDS)})\b", "", code="E0004"),
    _idiom(rf"^[ \t]*(?P<x>({NAME}(?:\[[^\]\n]*\])*)[ \t]*:[ \t]*({NAME})[ \t]+)(?={NAME}[ \t]*(?:\(|on\b|at\b))",
           "the type stands before the name", r"\3 \2: ", code="E0003"),
    _idiom(r"(?P<x>at[ \t]*(\([^()\n]*\))[ \t]+(\w+[ \t]+on[ \t]+[\w.\[\]]+))", "`at` stands behind what it stands on",
           r"\3 at \2"),
    _idiom(r"\b(?:force|shear|moment|twist|friction)[ \t]*(?P<x>[=:])(?=[ \t]*[\w.(-])",
           "strengths stand behind their names, as in `force 90 N`"),
    _idiom(rf"(?P<x>\b({NAME}|[0-9.]+)[ \t]*(?:\*\*|\^)[ \t]*2)\b", "there are no powers", r"\2 * \2"),
    _idiom(r"(?P<x>[ \t]*(?:\*\*|\^)[ \t]*[\w.]+)", "there are no powers", help="a product says the same: `x * x * x`"),
    _idiom(rf"(?P<x>({LITERAL})[ \t]*(?:->|=>|==>|implies\b)[ \t]*)(?=[(\[n])", "there is no implication",
           r"not \2 or "),
    _idiom(rf"function[ \t]+({NAME})[ \t]*\(([^)\n]*)\)[^{{=\n]*\{{\s*(?:return\b)?[ \t]*([^}}\n]*?)[ \t]*;?\s*\}}",
           "a function is a value, behind `=`", r"function \1(\2) = \3"),
    _idiom(rf"^[ \t]*(?P<x>(?:(?:let|var|const)[ \t]+)?{NAME}[ \t]*:?=[ \t]*[^={{}}\n]+)$", "there are no variables",
           help="give the task a parameter, such as `task t(h: length = 1 m)`, or declare a `function`"),
    _idiom(r"\((?P<x>(?:\??\w+[ \t]+)+-[ \t]*\w+(?:,?[ \t]+(?:\??\w+[ \t]+)+-[ \t]*\w+)*)[ \t]*\)",
           "the type stands behind the name, after `:`", _typed, code="E0003"),
    _idiom(r"(?P<x>\?(\w+))", "variables have no sign in front of them", r"\2", code="E0002"),
    _idiom(r"\([ \t]*(and|or)[ \t]+((?:\((?:[^()\n]|\([^()\n]*\))*\)[ \t]*)+)\)",
           "`and` and `or` stand between conditions", _infix),
    _idiom(rf"\([ \t]*not[ \t]+({LITERAL})[ \t]*\)", "`not` stands in front of the literal", r"not \1"),
    _idiom(rf"when[ \t]+({LITERAL})[ \t]+(?:\([ \t]*(not[ \t]+{LITERAL})[ \t]*\)|({LITERAL}))",
           "an effect under a condition is written with `if`", lambda m: f"if {m[1]} {{ {m[2] or m[3]} }}"),
    _idiom(rf"\b{NAME}(?:-[A-Za-z_]\w*)+\b", "a name has no `-` in it", lambda m: m[0].replace("-", "_")),
    _idiom(r"\b(\d+)([A-Za-z_]\w*)\b", "a name starts with a letter", r"\2\1"),
    _idiom(rf"^[ \t]*{NAME}[ \t]+(?P<x>({NAME})[ \t]+({NAME}))(?=[ \t]*:)", "a name is one word", r"\2_\3"),
    _idiom(rf"(?:predicate|derived)[ \t]+(?P<x>({NAME})[ \t]*\(([^()\n]*)\))", "the name stands inside the parentheses",
           r"(\2 \3)"),
    _idiom(rf"motion[ \t]+(?P<x>\([^()\n]*\)|{NAME}[ \t]*[\[(][^()\]\n]*[\])])",
           "a motion predicate stands in square brackets, its name too", _motion),
    _idiom(r"type[ \t]+\w+[ \t]*(?P<x>:|extends\b|inherits\b|is\b|-)(?=[ \t]*\w)",
           "a type stands below another one, behind `<`", "<"),
    _idiom(rf"(?:rule|task|scene|function|module)[ \t]+{NAME}(?P<x>[ \t]+({NAME}[^{{(\n]*:[^{{(\n]*?))[ \t]*\{{",
           "parameters stand in parentheses", r"(\2)", code="E0003"),
    _idiom(r"^[ \t]*(?P<x>[A-Za-z(][^{}\n]*?[<>=][^{}\n]*)$", "a row says when it binds",
           lambda m: f"at switch {m['x']}"),
    _idiom(rf"^[ \t]*(?P<x>joint[ \t]+{NAME}[ \t]*:[ \t]*(?:fixed|rigid)\b[^\n]*)$", "a joint moves",
           help="leave it out: what is fixed is one `link`"),
    _idiom(rf"\bin[ \t]*(?P<x>[\[(][ \t]*({ITEM}+?)[ \t]*,[ \t]*(?:{ITEM}+,[ \t]*)*({ITEM}+?)[ \t]*[\])])",
           "a range has `..` between its ends", r"\2 .. \3"),
    _idiom(r"(?P<x>from[ \t]+([^\n]+?)[ \t]+to[ \t]+(-?[\w.]+(?:[ \t]+[a-z]\w*)?))", 
           "a range has `..` between its ends", r"in \2 .. \3"),
    _idiom(r"module[^\n]*?\bfrom[ \t]+(?P<x>\"[^\"\n]*\")", "`urdf` says what the file is", r"urdf \g<x>",
           code="E0003"),
    _idiom(r"\burdf[ \t]+(?P<x>[\w./-]+)", "the name of a file stands in quotes", r'"\g<x>"', code="E0003"),
    _idiom(r"(?P<x>\b(?:rpy|orientation|rotation|rotate|rotated|yaw|quat|quaternion)[ \t]*\([^)\n]*\))",
           "bodies turn only about the vertical", help="`heading 90 deg` does so; for more, exchange the sizes"),
    _idiom(r"(?P<x>(\d[\d.]*)[ \t]*°)", "unknown character `°`", r"\2 deg", code="E0002"),
    _idiom(r"(?P<x>==?[ \t]*(?:[Tt]rue)\b)", "a literal holds by being there"),
    _idiom(r"(?P<x>\belse\b)", "a scene has no `else`", _otherwise),
    _idiom(rf"^[ \t]*(?P<x>(?:heuristic|guided?[ \t]+by|use|using)[ \t]+({NAME}[ \t]*\([^(){{}}\n]*\)))[ \t]*$",
           "a task names its heuristic behind `guide`", r"guide \2"),
    _idiom(r"^[ \t]*fact\b[^\n]*?(?P<x>,)[ \t]*(?=[(\[])", "every fact begins with `fact`", " fact"),
    _idiom(rf"\b(task|scene|rule|function|module|heuristic)\b[^\n(]*\((?:[^)\n]*,)?[ \t]*(?P<x>{NAME})(?=[ \t]*[,)=])",
           "a parameter has a type", _typed_parameter, code="E0003"),
    _idiom(r"\b(?:at|normal|by|along)[ \t]*(?P<x>[\[{]([^\[\]{}\n]*)[\]}])", "a vector stands in parentheses", r"(\2)"),
    _idiom(r"^[ \t]*(?:goal|fact|guide|pre|where|post|cost|start)(?P<x>[ \t]*[:=])", "no sign stands behind this word"),
    _idiom(r"^[ \t]*(?P<x>(?:(?:at|on)(?:_?[Ss]witch|[ \t]+(?:the|a|each|every)[ \t]+switch)|(?:on|when)[ \t]+switch)"
           r"\b(?:[ \t]*:)?)", "a row of switches begins with two words", "at switch"),
    _idiom(rf"(?P<x>({NAME}[ \t]*\([^()\n]*\))[ \t]*\.[ \t]*([xyz])\b)", "a vector has no parts of its own",
           _component),
    _idiom(r"(?P<x>,)(?=[ \t]*(?:at|on|in|heading|normal|home|mass|density|torque|speed|holds)\b)",
           "what is said of an item stands side by side"),
)  # fmt: skip


def idioms(text: str, start: int, end: int, at: int) -> Iterator[tuple[Idiom, re.Match[str]]]:
    """Those that begin on the line from `start` to `end`, before or at the mistake `at` there."""
    for idiom in IDIOMS:
        for match in idiom.pattern.finditer(text, start):
            first, last = idiom.stretch(match)
            if first > min(at, end):
                break
            if first < last:
                yield idiom, match
