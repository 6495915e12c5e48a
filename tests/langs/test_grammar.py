"""The grammar: no ambiguity, and the tree of every construct."""

import math

import pytest

from tamplang.langs import syntax as s
from tamplang.langs.grammar_loader import PARTS, build, grammar_text
from tamplang.langs.parser import parse
from tamplang.langs.source import Source, Span

SPAN = Span("", 0, 0, 0, 0, 0, 0)


def only(text: str) -> s.Declaration:
    tree, found = parse(Source("t.tamp", text))
    assert found == ()
    (declaration,) = tree.declarations
    return declaration


def name(text: str) -> s.Name:
    return s.Name(text, span=SPAN)


def literal(predicate: str, *args: str, motion: bool = False) -> s.Literal:
    return s.Literal(predicate, tuple(name(a) for a in args), motion, span=SPAN)


def condition(text: str) -> s.Formula:
    rule = only(f"rule r {{ pre {text} }}")
    assert isinstance(rule, s.RuleDecl)
    (formula,) = rule.pre
    return formula


def term(text: str) -> s.Term:
    rule = only(f"rule r {{ cost {text} }}")
    assert isinstance(rule, s.RuleDecl) and rule.cost is not None
    return rule.cost


def test_no_terminals_collide() -> None:
    build(grammar_text(), strict=True)


def test_one_grammar_file_for_each_language() -> None:
    assert len(PARTS) == 10


@pytest.mark.parametrize(
    ("text", "value", "kind"),
    [
        ("3", 3.0, ""),
        ("0.05 m", 0.05, "length"),
        ("5cm", 0.05, "length"),
        ("50 mm", 0.05, "length"),
        ("1.5 rad", 1.5, "angle"),
        ("180 deg", math.pi, "angle"),
        ("2 min", 120.0, "time"),
        ("60 s", 60.0, "time"),
        ("90 deg/s", math.pi / 2, "angular speed"),
        ("2 cm/s", 0.02, "speed"),
        ("50 cm/s^2", 0.5, "acceleration"),
        ("180 deg/s^2", math.pi, "angular acceleration"),
        ("1e-3", 0.001, ""),
        ("1.5E3 m", 1500.0, "length"),
    ],
)
def test_numbers_are_in_si(text: str, value: float, kind: str) -> None:
    number = term(text)
    assert isinstance(number, s.Number)
    assert number.value == pytest.approx(value)
    assert (number.kind, number.text) == (kind, text)


def test_a_unit_is_a_whole_word() -> None:
    assert term("3 * m") == s.Binary("*", s.Number(3.0, "", "3", span=SPAN), name("m"), span=SPAN)
    assert term("2 m / s") == s.Binary("/", s.Number(2.0, "length", "2 m", span=SPAN), name("s"), span=SPAN)


@pytest.mark.parametrize("text", ["1..3", "1 ..3", "1.. 3", "1 .. 3"])
def test_range(text: str) -> None:
    rule = only(f"rule r(k: {text}) {{ }}")
    assert isinstance(rule, s.RuleDecl)
    one, three = (s.Number(float(n), "", n, span=SPAN) for n in "13")
    assert rule.parameters == (s.Parameter("k", s.RangeType(one, three, span=SPAN), span=SPAN),)


def test_not_binds_tighter_than_and_tighter_than_or() -> None:
    a, b, c = literal("a"), literal("b"), literal("c")
    expected = s.Or((s.And((s.Not(a, span=SPAN), b), span=SPAN), c), span=SPAN)
    assert condition("not (a) and (b) or (c)") == expected
    assert condition("¬(a) and (b) or (c)") == expected


def test_not_binds_looser_than_comparison() -> None:
    assert condition("not X = Y") == s.Not(s.Compare("=", name("X"), name("Y"), span=SPAN), span=SPAN)


def test_product_binds_tighter_than_sum_and_both_group_to_the_left() -> None:
    a, b, c = name("a"), name("b"), name("c")
    assert term("a - b - c") == s.Binary("-", s.Binary("-", a, b, span=SPAN), c, span=SPAN)
    assert term("a + b * c") == s.Binary("+", a, s.Binary("*", b, c, span=SPAN), span=SPAN)
    assert term("-a * b") == s.Binary("*", s.Negate(a, span=SPAN), b, span=SPAN)
    assert term("(a + b) * c") == s.Binary("*", s.Binary("+", a, b, span=SPAN), c, span=SPAN)


def test_parenthesised_word_is_a_literal_or_a_name_by_its_place() -> None:
    assert condition("(flag)") == literal("flag")
    assert condition("((flag))") == literal("flag")
    assert condition("(n) = 3") == s.Compare("=", name("n"), s.Number(3.0, "", "3", span=SPAN), span=SPAN)


def test_arguments_of_literals_are_references() -> None:
    stable = condition("[stable c[k + 1].in c[k].out ANY 3]")
    assert isinstance(stable, s.Literal) and stable.motion
    entered, left, anything, three = stable.args
    assert isinstance(entered, s.Attribute) and entered.name == "in" and isinstance(entered.base, s.Index)
    assert isinstance(left, s.Attribute) and left.name == "out"
    assert isinstance(anything, s.Wildcard)
    assert isinstance(three, s.Number)


def test_previous_with_and_without_arguments() -> None:
    assert condition("previous is r") == s.Previous("r", None, span=SPAN)
    assert condition("previous is r()") == s.Previous("r", (), span=SPAN)
    assert condition("previous is r(X, ANY)") == s.Previous("r", (name("X"), s.Wildcard(span=SPAN)), span=SPAN)


def test_doc_comments_belong_to_the_declaration_right_below() -> None:
    text = "## Not this.\n\n## First\n## second.\ntype a < object\n# plain\ntype b < a\n"
    tree, _ = parse(Source("t.tamp", text))
    assert [d.doc for d in tree.declarations if isinstance(d, s.TypeDecl)] == ["First\nsecond.", ""]


def test_module_is_a_type_and_a_keyword() -> None:
    rule = only("rule r(X: module, c: chain of module by connected) { }")
    assert isinstance(rule, s.RuleDecl)
    assert [p.type for p in rule.parameters] == [
        s.NamedType("module", span=SPAN),
        s.ChainType("module", "connected", span=SPAN),
    ]


def test_keywords_end_at_word_bounds() -> None:
    text = "task t { object a: sphere(1 m) moduleA b: x on a objects goals: sphere(1 m) }"
    task = only(text)
    assert isinstance(task, s.TaskDecl)
    assert [type(i).__name__ for i in task.items] == ["BodyItem", "RobotItem", "BodyItem"]


def test_names_are_case_sensitive() -> None:
    assert term("Any") == name("Any")
    assert isinstance(term("f(ANY)"), s.Call)


def test_spans_point_to_the_text() -> None:
    text = "type base < object\n\nrule r(A: base) {\n    pre (on A\n         A)\n}\n"
    tree, _ = parse(Source("t.tamp", text))
    rule = tree.declarations[1]
    assert isinstance(rule, s.RuleDecl)
    span = rule.pre[0].span
    assert text[span.start : span.end] == "(on A\n         A)"
    assert (span.line, span.column, span.end_line, span.end_column) == (4, 9, 5, 12)
    assert text[rule.parameters[0].span.start : rule.parameters[0].span.end] == "A"
    assert tree.span.end == len(text)
