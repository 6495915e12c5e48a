"""Writes the grammars of editors from the list of patterns in `tamplang/highlight.py`: python editors/generate.py

A test refuses files that are not what this writes."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path

from tamplang.highlight import alternatives, rules
from tamplang.langs.words import JOINTS, SHAPES, TYPES, UNITS, WORDS

FOLDER = Path(__file__).resolve().parent
SCOPES = {
    "doc": "comment.line.documentation", "comment": "comment.line.number-sign", "string": "string.quoted.double",
    "number": "constant.numeric", "declaration": "storage.type", "keyword": "keyword.other",
    "modifier": "storage.modifier", "control": "keyword.control", "type": "support.type",
    "function": "support.function", "predicate": "entity.name.function", "motion": "entity.name.function.macro",
    "property": "variable.other.property", "namespace": "entity.name.namespace", "operator": "keyword.operator",
    "name": "variable.other",
}  # fmt: skip


def textmate() -> str:
    patterns = [
        {"match": pattern, "captures": {str(i): {"name": f"{SCOPES[c]}.tamplang"} for i, c in enumerate(classes, 1)}}
        for pattern, classes in rules()
    ]
    grammar = {"name": "tamplang", "scopeName": "source.tamplang", "fileTypes": ["tamp"], "patterns": patterns}
    return json.dumps(grammar, indent=2, ensure_ascii=False) + "\n"


def vim() -> str:
    groups: dict[str, list[str]] = {}
    for word, told in WORDS.items():
        groups.setdefault(told.group, []).append(word)
    units = _vim(UNITS).replace("/", "\\/")
    names = {"declaration": "Structure", "part": "Statement", "clause": "Statement", "modifier": "StorageClass"}
    lines = [
        '" Vim syntax of tamplang. Written by editors/generate.py; do not change it by hand.',
        'if exists("b:current_syntax")',
        "  finish",
        "endif",
        r"syn match tampFree /\<\h\w*\>/",
    ]
    for group, words in groups.items():
        # A word directly before `(` is a call, and behind a point, `(` or `[` a name.
        lines.append(rf"syn match tamp{group.capitalize()} /[.(\[]\@1<!\<\({_vim(words)}\)\>(\@!/")
    lines += [
        rf"syn match tampControl /\<\({_vim(w for w in groups['control'] if w not in ('min', 'max', 'sum'))}\)\>/",
        rf"syn match tampType /[.(\[]\@1<!\<\({_vim(t for t in TYPES if t not in WORDS)}\)\>/",
        rf"syn match tampFunction /\<\({_vim([*SHAPES, *JOINTS])}\)\>(\@=/",
        r"syn match tampPredicate /(\@1<=\h\w*\%(\%(\s\+[A-Za-z0-9_.\[\]]\+\)*)\)\@=/",
        r"syn match tampMotion /\[\@1<=\h\w*\%(\%(\s\+[A-Za-z0-9_.\[\]]\+\)\+\]\)\@=/",
        r"syn match tampNumber /\<\d\+\%(\.\d\+\)\?\%([eE][+-]\?\d\+\)\?"
        rf"\%(\s*\%({units}\)\%(\/s\%(^[23]\)\?\)\?\>\)\?/",
        r'syn region tampString start=/"/ end=/"/ oneline',
        r"syn match tampComment /#.*$/ contains=tampTodo",
        r"syn match tampDoc /##.*$/",
        "syn keyword tampTodo TODO FIXME contained",
    ]
    links = {
        **{f"tamp{g.capitalize()}": n for g, n in names.items()}, "tampControl": "Conditional", "tampType": "Type",
        "tampFunction": "Function", "tampPredicate": "Function", "tampMotion": "Macro", "tampNumber": "Number",
        "tampString": "String", "tampComment": "Comment", "tampDoc": "SpecialComment", "tampTodo": "Todo",
    }  # fmt: skip
    lines += [f"hi def link {name} {group}" for name, group in links.items()]
    return "\n".join([*lines, 'let b:current_syntax = "tamplang"', ""])


def _vim(words: Iterable[str]) -> str:
    return alternatives(words).replace("|", r"\|")


def files() -> dict[Path, str]:
    """What is written, by path."""
    return {
        FOLDER / "vscode" / "syntaxes" / "tamplang.tmLanguage.json": textmate(),
        FOLDER / "vim" / "syntax" / "tamplang.vim": vim(),
    }


if __name__ == "__main__":
    for path, text in files().items():
        path.write_text(text, encoding="utf-8")
