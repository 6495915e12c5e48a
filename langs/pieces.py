"""A sound text as a row of tokens and comments, with what the formatter must know of the grammar around them."""

from __future__ import annotations

import re

from lark import Token, Tree

from .build_terms import Branch
from .frozen import dataclass
from .grammar_loader import parser

STATEMENTS = frozenset(
    {
        "import",
        "type_decl",
        "predicate_decl",
        "derived_decl",
        "function_decl",
        "module_decl",
        "motion_decl",
        "rule_decl",
        "placement_decl",
        "heuristic_decl",
        "scene_decl",
        "task_decl",
        "effector_item",
        "joint_item",
        "coupling_item",
        "link_item",
        "fact_item",
        "branch_item",
        "switch_row",
        "during_row",
        "keep_row",
        "touching_item",
        "motion_for",
        "pre",
        "where",
        "post",
        "cost",
        "start_value",
        "heuristic_case",
        "body_item",
        "robot_on",
        "robot_at",
        "for_item",
        "if_item",
        "scene_use",
        "goal_item",
        "guide_use",
        "options_item",
        "course_item",
        "disturbance_item",
        "breakdown_item",
    }
)
BLOCKS = frozenset(
    {
        "module_decl",
        "motion_decl",
        "rule_decl",
        "heuristic_decl",
        "scene_decl",
        "task_decl",
        "motion_for",
        "branch_item",
        "for_item",
        "if_item",
    }
)
_COMMENT = re.compile(r"#[^\n]*")


@dataclass(frozen=True, slots=True)
class Piece:
    """A token, or a comment (`kind` "COMMENT"). `newlines` counts those before it in the text. `statement` names the
    rule of the grammar that starts here, "" where none does; `block` marks the braces around statements."""

    kind: str
    text: str
    newlines: int
    statement: str
    block: bool


def pieces_of(text: str) -> list[Piece]:
    """The tokens and comments of a text that parses."""
    interactive = parser().parse_interactive(text)
    tokens = list(interactive.iter_parse())
    tree: Branch = interactive.feed_token(Token.new_borrow_pos("$END", "", tokens[-1])) if tokens else Tree("start", [])
    starts, ends = _statements(tree)
    blocks = _block_braces(tokens, ends)
    found: list[Piece] = []
    position = 0
    for token in tokens:
        start, end = token.start_pos or 0, token.end_pos or 0
        newlines = _comments(text, position, start, found)
        found.append(Piece(token.type, str(token), newlines, starts.get(start, ""), start in blocks))
        position = end
    _comments(text, position, len(text), found)
    return found


def _comments(text: str, start: int, end: int, found: list[Piece]) -> int:
    """Add the comments between two tokens; gives the newlines behind the last of them."""
    for match in _COMMENT.finditer(text, start, end):
        found.append(Piece("COMMENT", match[0].rstrip(), text.count("\n", start, match.start()), "", False))
        start = match.end()
    return text.count("\n", start, end)


def _statements(tree: Branch) -> tuple[dict[int, str], set[int]]:
    """Where statements start, by kind, and where the closing braces of blocks stand."""
    starts: dict[int, str] = {}
    ends: set[int] = set()
    for node in tree.iter_subtrees():
        kind = str(node.data)
        if kind in STATEMENTS:
            starts[node.meta.start_pos] = kind
        if kind in BLOCKS:
            ends.add(node.meta.end_pos - 1)
    return starts, ends


def _block_braces(tokens: list[Token], ends: set[int]) -> set[int]:
    braces: set[int] = set()
    opened: list[int] = []
    for token in tokens:
        start = token.start_pos or 0
        if token.type == "LBRACE":
            opened.append(start)
        elif token.type == "RBRACE":
            partner = opened.pop()
            if start in ends:
                braces |= {partner, start}
    return braces
