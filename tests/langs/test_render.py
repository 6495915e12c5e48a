"""Diagnostics as text, JSON and SARIF."""

import json

import pytest

from tamplang.langs.diagnostics import Diagnostic, Label
from tamplang.langs.render import render
from tamplang.langs.source import Source, Span

MAIN = Source("main.tamp", "import lib\n\nrule grab(A: griper) {\n\tpre\t(free A)\n}\n")
LIB = Source("lib.tamp", "# types\ntype gripper < effector\n")
SOURCES = {s.path: s for s in (MAIN, LIB)}


def span(source: Source, word: str) -> Span:
    start = source.text.index(word)
    before = source.text[:start]
    line, column = before.count("\n") + 1, start - before.rfind("\n")
    return Span(source.path, start, start + len(word), line, column, line, column + len(word))


FOUND = Diagnostic(
    "E0102",
    "unknown type `griper`",
    span(MAIN, "griper"),
    labels=(Label(span(LIB, "gripper"), "declared here"), Label(span(MAIN, "grab"), "in this rule")),
    help="did you mean `gripper`?",
    note="types are declared by `type`\nor by `module`",
)


def test_full() -> None:
    assert render([FOUND], SOURCES) == "\n".join(
        [
            "error[E0102]: unknown type `griper`",
            " --> main.tamp:3:14",
            "  |",
            "3 | rule grab(A: griper) {",
            "  |              ^^^^^^",
            "  |      ---- in this rule",
            " ::: lib.tamp:2:6",
            "  |",
            "2 | type gripper < effector",
            "  |      ------- declared here",
            "  = help: did you mean `gripper`?",
            "  = note: types are declared by `type`",
            "          or by `module`",
        ]
    )


def test_tabs() -> None:
    text = render([Diagnostic("W0003", "w", span(MAIN, "free"))], SOURCES)
    assert text.split("\n")[3:] == ["4 |     pre    (free A)", "  |             ^^^^"]
    assert text.startswith("warning[W0003]: w")


def test_wide_characters() -> None:
    source = Source("w", 'import "日本" x')
    text = render([Diagnostic("E0001", "m", span(source, "x"))], {"w": source})
    assert text.split("\n")[-1] == "  | " + " " * 14 + "^"


def test_long_line_is_shortened_around_the_span() -> None:
    source = Source("l", "a" * 300 + " here " + "b" * 300)
    line, marks = render([Diagnostic("E0001", "m", span(source, "here"))], {"l": source}).split("\n")[-2:]
    assert len(line) <= 4 + 100 and line[marks.index("^") :].startswith("here")
    assert line[4] == "…" and line[-1] == "…"


def test_span_over_several_lines_and_past_the_end() -> None:
    source = Source("s", "ab\ncd\n")
    over = Span("s", 1, 5, 1, 2, 2, 3)
    past = Span("s", 6, 7, 3, 1, 3, 2)
    assert render([Diagnostic("E0001", "m", over)], {"s": source}).split("\n")[-1] == "  |  ^"
    assert render([Diagnostic("E0001", "m", past)], {"s": source}).split("\n")[-2:] == ["3 |", "  | ^"]


def test_without_span_or_source() -> None:
    assert render([Diagnostic("E0010", "there is no file `x`", help="look")], {}) == (
        "error[E0010]: there is no file `x`\n = help: look"
    )
    assert render([FOUND], {}).split("\n")[:3] == [
        "error[E0102]: unknown type `griper`",
        " --> main.tamp:3:14",
        " ::: lib.tamp:2:6",
    ]


def test_concise() -> None:
    found = [FOUND, Diagnostic("E0010", "no file")]
    assert render(found, SOURCES, "concise") == "main.tamp:3:14: E0102 unknown type `griper`\nE0010 no file"


def test_terminal_escapes_in_the_source_are_not_sent_to_the_terminal() -> None:
    source = Source("e", "type \x1b[31m")
    text = render([Diagnostic("E0002", "unknown \x1b[31m", span(source, "type"))], {"e": source})
    assert "\x1b" not in text


def test_colour() -> None:
    text = render([FOUND], SOURCES, colour=True)
    assert text.startswith("\x1b[1;31merror[E0102]\x1b[0m")
    assert render([FOUND], SOURCES, "concise", True) == render([FOUND], SOURCES, "concise")


def test_json() -> None:
    (record,) = json.loads(render([FOUND], SOURCES, "json"))
    assert record["code"] == "E0102" and record["severity"] == "error" and record["category"] == "name"
    assert (record["file"], record["line"], record["column"], record["end_column"]) == ("main.tamp", 3, 14, 20)
    assert MAIN.text[record["start"] : record["end"]] == "griper"
    assert record["labels"][0]["file"] == "lib.tamp" and record["labels"][0]["text"] == "declared here"
    assert record["help"] == FOUND.help and record["note"] == FOUND.note
    assert json.loads(render([], {}, "json")) == []


def test_sarif() -> None:
    log = json.loads(render([FOUND, Diagnostic("W0002", "w"), FOUND], SOURCES, "sarif"))
    assert log["version"] == "2.1.0"
    (run,) = log["runs"]
    assert [r["id"] for r in run["tool"]["driver"]["rules"]] == ["E0102", "W0002"]
    first, second, _ = run["results"]
    assert (first["ruleId"], first["ruleIndex"], first["level"]) == ("E0102", 0, "error")
    place = first["locations"][0]["physicalLocation"]
    assert place["artifactLocation"]["uri"] == "main.tamp"
    assert place["region"]["startLine"] == 3 and place["region"]["startColumn"] == 14
    assert len(first["relatedLocations"]) == 2
    assert second["level"] == "warning" and "locations" not in second


def test_unknown_format() -> None:
    with pytest.raises(ValueError, match="xml"):
        render([], {}, "xml")


@pytest.mark.parametrize("format", ["full", "concise"])
def test_people_are_shown_a_hundred_and_errors_first(format: str) -> None:
    warnings = [Diagnostic("W0002", f"warning {i}") for i in range(90)]
    errors = [Diagnostic("E0102", f"error {i}") for i in range(90)]
    text = render([*warnings, *errors], SOURCES, format)
    assert text.endswith("\nand 80 more")
    assert text.count("error ") == 90 and text.count("warning ") == 10
    assert text.index("warning 9") < text.index("error 0")
    assert "more" not in render(errors, SOURCES, format)


@pytest.mark.parametrize("format", ["json", "sarif"])
def test_programs_get_every_diagnostic(format: str) -> None:
    text = render([Diagnostic("E0102", f"error {i}") for i in range(250)], SOURCES, format)
    assert all(f"error {i}" in text for i in range(250))


def test_a_line_of_a_megabyte_is_cut_around_its_mistakes() -> None:
    source = Source("long", "x" * 500_000 + "griper" + "y" * 500_000)
    at = Span("long", 500_000, 500_006, 1, 500_001, 1, 500_007)
    text = render([Diagnostic("E0102", "unknown", at)] * 200, {"long": source})
    lines = text.split("\n")
    assert max(map(len, lines)) < 120
    shown, marks = lines[3], lines[4]
    assert shown[marks.index("^") :].startswith("griper")
