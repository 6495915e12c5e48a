"""The layout: stable, true to the meaning, and keeping every comment, whatever blanks the author put."""

import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamplang.langs.diagnostics import SourceError
from tamplang.langs.formatter import format_source
from tamplang.langs.parser import parse
from tamplang.langs.pieces import Piece, pieces_of
from tamplang.langs.source import Source

from .programs import GOOD, REAL, source_of

PIECES = [pieces_of(source_of(path).text) for path in [*GOOD, *REAL]]
GAPS = st.sampled_from([" ", "  ", "\t", "\n", "\n\n\n", " \n  ", "# a\n", "  # b\n\n"])


def laid_out(text: str) -> str:
    return format_source(Source("t.tamp", text))


@st.composite
def scattered(draw: st.DrawFn) -> str:
    """A sound program with other blanks, line ends and comments between its tokens."""
    pieces: list[Piece] = draw(st.sampled_from(PIECES))
    shuffled = draw(st.lists(GAPS, min_size=8, max_size=40))
    text = ""
    for index, piece in enumerate(pieces):
        if piece.kind != "COMMENT":
            text += piece.text + shuffled[index % len(shuffled)]
    return text


@settings(max_examples=60, deadline=None)
@given(scattered())
def test_any_spacing(text: str) -> None:
    source = Source("t.tamp", text)
    tree, found = parse(source)
    assert found == ()
    once = Source("t.tamp", format_source(source))
    without_docs = re.compile(r"doc='[^']*'")
    assert without_docs.sub("", repr(parse(once))) == without_docs.sub("", repr((tree, ())))
    assert format_source(once) == once.text
    assert sorted(re.findall(r"#.*", once.text)) == sorted(c.rstrip() for c in re.findall(r"#.*", text))
    assert "\n\n\n" not in once.text and not re.search(r"[ \t]$", once.text, re.MULTILINE)


def test_parts_of_a_rule_are_aligned() -> None:
    text = "rule r(A:effector){pre (a A),\n(b A) where distance( A,A )<=1 m post not(a A),\n[c A] cost -1}"
    assert laid_out(text) == (
        "rule r(A: effector) {\n"
        "    pre   (a A),\n"
        "          (b A)\n"
        "    where distance(A, A) <= 1 m\n"
        "    post  not (a A),\n"
        "          [c A]\n"
        "    cost  -1\n"
        "}\n"
    )


def test_values_of_a_heuristic_are_aligned() -> None:
    text = "heuristic h {\nstart\n0\nstep(A,B): 1\n  stepTogether(c):\n distance(c,\nc)\n}\n"
    assert laid_out(text) == (
        "heuristic h {\n"
        "    start             0\n"
        "    step(A, B):       1\n"
        "    stepTogether(c):  distance(c,\n"
        "                          c)\n"
        "}\n"
    )


def test_marks_of_neighbouring_predicates_are_aligned() -> None:
    text = "predicate (a X: object) static\n## b\npredicate (bcd X: object) symmetric\n\npredicate (e) static\n"
    assert laid_out(text) == (
        "predicate (a X: object)    static\n"
        "## b\n"
        "predicate (bcd X: object)  symmetric\n"
        "\n"
        "predicate (e)  static\n"
    )


def test_loops_are_indented_and_empty_blocks_closed() -> None:
    text = "task t{for i in 1..3{if i>2{\n\nfact (a)\n\n}}\noptions{ }} scene s\n{\n}"
    assert laid_out(text) == (
        "task t {\n    for i in 1 .. 3 {\n        if i > 2 {\n            fact (a)\n        }\n    }\n"
        "    options {}\n}\nscene s {}\n"
    )


def test_comments_stay_where_they_are() -> None:
    text = "# top\n\n\n# second\ntask t { # opens\n   # first\nfact (a) # here\nfact (bb)# there\n# last\n}\n# end"
    assert laid_out(text) == (
        "# top\n\n# second\ntask t {  # opens\n    # first\n    fact (a)   # here\n    fact (bb)  # there\n"
        "    # last\n}\n# end\n"
    )


def test_only_comments_and_nothing() -> None:
    assert laid_out("  # a\n\n") == "# a\n"
    assert laid_out("") == ""


def test_faulty_text_is_refused() -> None:
    with pytest.raises(SourceError) as refused:
        laid_out("rul r {}")
    assert [d.code for d in refused.value.diagnostics] == ["E0004"]
