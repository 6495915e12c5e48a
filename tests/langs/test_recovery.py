"""Faulty texts: never a crash, few errors for few mistakes, and the sound declarations are kept."""

import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamplang.langs import syntax
from tamplang.langs.codes import CODES
from tamplang.langs.diagnostics import Diagnostic
from tamplang.langs.parser import parse
from tamplang.langs.pieces import pieces_of
from tamplang.langs.render import FORMATS, render
from tamplang.langs.source import Source

from .programs import GOOD, REAL, source_of

TEXTS = [source_of(path).text for path in [*GOOD, *REAL]]
SIGNS = ["{", "}", "(", ")", "[", "]", ",", ":", "..", "=", "rule", "post", "for", "x", "3 m", '"', "&", "\x00", "é"]

WORDS = [*SIGNS, "rule r", "task t {", "(p A)", "\n", "##", "1", "-", "not", "fact"]


def mistakes(text: str) -> tuple[Diagnostic, ...]:
    return parse(Source("t.tamp", text))[1]


def check_form(text: str, found: tuple[Diagnostic, ...]) -> None:
    starts = [d.span.start for d in found if d.span is not None]
    assert len(starts) == len(found) and starts == sorted(starts)
    for diagnostic in found:
        assert diagnostic.code in CODES
        own_words = re.sub(r"`[^`]*`|U\+[0-9A-F]+", "", diagnostic.message)
        assert not re.search(r"\b_?[A-Z]{4,}\b|Token|__ANON", own_words)
        assert diagnostic.span is not None and 0 <= diagnostic.span.start <= len(text)
    for format in FORMATS:
        render(found, {"t.tamp": Source("t.tamp", text)}, format)


@settings(max_examples=50, deadline=None, derandomize=True)
@given(st.data())
def test_one_mistake_gives_one_to_three_errors(data: st.DataObject) -> None:
    text = data.draw(st.sampled_from([t for t in TEXTS if "type module" not in t]))
    pieces = [p for p in pieces_of(text) if p.kind != "COMMENT"]
    words = [p.text for p in pieces]
    index = data.draw(st.integers(0, len(words) - 1))
    how = data.draw(st.sampled_from(["leave out", "double", "insert", "cut"]))
    if how == "leave out":
        del words[index]
    elif how == "double":
        words.insert(index, words[index])
    elif how == "insert":
        words.insert(index, data.draw(st.sampled_from(SIGNS)))
    else:
        words[index] = words[index][:-1]
    faulty = "".join(("\n" if p.newlines else " ") + w for p, w in zip([*pieces, pieces[-1]], words, strict=False))
    found = mistakes(faulty)
    check_form(faulty, found)
    assert len(found) <= 3


@settings(max_examples=60, deadline=None)
@given(st.lists(st.sampled_from(WORDS), max_size=40))
def test_any_row_of_words(words: list[str]) -> None:
    text = " ".join(words)
    check_form(text, mistakes(text))


@settings(max_examples=60, deadline=None)
@given(st.text(max_size=80))
def test_any_text(text: str) -> None:
    check_form(text, mistakes(text))


@pytest.mark.parametrize(
    "text",
    [
        "rule r { pre " + "(" * 20000,
        "rule r { cost " + "(" * 3000 + "1" + ")" * 3000 + " }",
        "rule r { cost " + "1 + " * 5000 + "1 }",
        "rule r { pre " + "not " * 5000 + "(a) }",
        "rule r { cost " + "-" * 5000 + "1 }",
        "rule r { cost " + "a[" * 2000 + "1" + "]" * 2000 + " }",
        "scene s {" + "for i in 1 .. 2 {" * 2000 + "}" * 2001,
        "rule r { post " + "if (a) {" * 2000 + "(b)" + "}" * 2001,
        "rule r { cost " + "if (a) then 1 else " * 2000 + "1 }",
        "}" * 5000,
        '"' * 5001,
        "@#$ %\n" * 5000,
        "foo bar ( baz }\n" * 5000,
    ],
    ids=range(13),
)
def test_extreme_texts(text: str) -> None:
    found = mistakes(text)
    assert 1 <= len(found) <= 50
    check_form(text, found)


def test_depth_that_is_still_read() -> None:
    assert mistakes("rule r { cost " + "(" * 90 + "1" + ")" * 90 + " }") == ()


def test_sound_declarations_beside_faulty_ones_are_kept() -> None:
    text = "type a < object\nrule r(A: ) {\n???\n}\ntype b < object\nmodule m { efector A: sphere(1 m) }\n"
    tree, found = parse(Source("t.tamp", text))
    assert [d.name for d in tree.declarations if isinstance(d, syntax.TypeDecl)] == ["a", "b"]
    assert any(isinstance(d, syntax.ModuleDecl) for d in tree.declarations)
    assert [d.code for d in found][-1] == "E0004"


def test_many_mistakes_are_all_named() -> None:
    text = "".join(f"rule r{i}(A: effector) {{\n    pre   (a A) (b A)\n}}\n" for i in range(30))
    assert [d.span.line for d in mistakes(text) if d.span] == [2 + 3 * i for i in range(30)]


@pytest.mark.parametrize("text", TEXTS[::4])
def test_every_place_lies_inside_its_file_wherever_that_ends(text: str) -> None:
    for end in range(1, min(len(text), 2000), 37):
        for cut in (text[:end], text[:end].rstrip()):
            for found in mistakes(cut):
                for span in (found.span, *(label.span for label in found.labels)):
                    assert span is not None and 0 <= span.start <= span.end <= len(cut), (cut[-30:], found)
