"""Every feature of the language server, as a client sees it."""

from __future__ import annotations

import pytest

from .conftest import ROOT, Session

PROGRAM = """import std.rules
import std.scenes

## A plate to stand on.
type plate < base

## Half of a length.
function half(x: length) = 0.5 * x

rule leave(A: gripper, X: base) {
    pre   (support A), (on X A)
    where half(reach(A, A)) > 0 and not exists B: gripper { (on X B) and B != A }
    post  not (support A)
}

module arm(size: length = 1 m) {
    effector A: gripper sphere(0.05 m) normal (0, 0, -1)
    joint j1: revolute(y) in -90 deg .. 90 deg
    link 0.4 * size: capsule(0.04 m)
    effector B: gripper sphere(5 cm)
    fact (linked A B)
}

task t(n: int = 3) {
    scene stairs(n, 10 cm)
    plate p[1]: box(1 m, 1 m, 0.05 m) at (5 m, 0, 0)
    object b: sphere(4 cm) at (0, 0, 3 m)
    fact (grippable b)
    arm c: A on p[1]
    goal (held b), not (support c.A)
    options { bound = seq }
}
"""


def test_diagnostics_follow_the_text(session: Session) -> None:
    uri = session.open(PROGRAM.replace("(grippable b)", "(gripable b)"))
    (diagnostic,) = (d for d in session.diagnostics(uri) if d["severity"] == 1)
    assert diagnostic["code"] == "E0103"
    assert "did you mean `grippable`?" in diagnostic["message"]
    assert session.words(uri, [diagnostic]) == ["gripable"]
    assert diagnostic["codeDescription"]["href"].endswith(".html#E0103")
    session.change(uri, PROGRAM, 2)
    assert "E0103" not in {d["code"] for d in session.diagnostics(uri, 2)}


def test_the_page_of_codes_holds_the_linked_code(session: Session) -> None:
    from urllib.parse import unquote, urlparse

    uri = session.open("type a < b\n")
    (diagnostic,) = (d for d in session.diagnostics(uri) if d["severity"] == 1)
    where = urlparse(diagnostic["codeDescription"]["href"])
    with open(unquote(where.path), encoding="utf-8") as page:
        assert f'id="{where.fragment}"' in page.read()


def test_related_places(session: Session) -> None:
    uri = session.open("type a < object\ntype a < object\n")
    (diagnostic,) = (d for d in session.diagnostics(uri) if d["code"] == "E0110")
    (related,) = diagnostic["relatedInformation"]
    assert related["location"]["uri"] == uri and related["location"]["range"]["start"]["line"] == 0


def test_keys_in_a_row_cost_few_checks(session: Session) -> None:
    """Every check of a text is told once, so that what is told counts the checks."""
    uri = session.open("type a < object\n")
    session.diagnostics(uri)
    session.published.clear()
    for version in range(2, 82):
        session.change(uri, f"type a < object # {'x' * version}\n", version)
    session.diagnostics(uri, 81)
    session.request("textDocument/documentSymbol", textDocument={"uri": uri})
    assert len([p for p in session.published if p["uri"] == uri]) <= 3


def test_an_open_text_serves_the_imports_of_others(session: Session) -> None:
    (session.folder / "parts.tamp").write_text("type brick < object\n")
    uri = session.open('import "parts.tamp"\ntype plank < board\n')
    assert [d["code"] for d in session.diagnostics(uri) if d["severity"] == 1] == ["E0102"]
    other = session.open("type board < object\n", "parts.tamp")
    session.diagnostics(other)
    session.change(uri, session.texts[uri] + " ", 2)
    assert [d for d in session.diagnostics(uri, 2) if d["severity"] == 1] == []


def test_a_change_of_an_imported_text_is_told_to_its_importers(session: Session) -> None:
    other = session.open("type board < object\n", "parts.tamp")
    session.diagnostics(other)
    uri = session.open('import "parts.tamp"\ntype plank < board\n')
    assert [d for d in session.diagnostics(uri) if d["severity"] == 1] == []
    session.change(other, "type brick < object\n", 2)
    assert [d["code"] for d in session.diagnostics(uri) if d["severity"] == 1] == ["E0102"]


def test_errors_of_an_import_are_shown_there_and_at_the_import(session: Session) -> None:
    (session.folder / "parts.tamp").write_text("type brick < stone\n")
    uri = session.open('type a < object\nimport "parts.tamp"\n')
    (here,) = (d for d in session.diagnostics(uri) if d["severity"] == 1)
    assert here["range"]["start"]["line"] == 1
    (related,) = here["relatedInformation"]
    imported = (session.folder / "parts.tamp").as_uri()
    assert related["location"]["uri"] == imported
    there = next((p for p in session.published if p["uri"] == imported), None)
    found = session.diagnostics(imported) if there is None else there["diagnostics"]
    assert [d["code"] for d in found] == ["E0102"]


@pytest.mark.parametrize(
    ("word", "behind", "told"),
    [
        ("plate p", 1, "A plate to stand on."),
        ("base\n", 1, "A surface that a foot can stand on."),
        ("half(reach", 1, "Half of a length."),
        ("reach(A", 1, "how far apart two effectors"),
        ("A), (on X A)", 0, "A: gripper"),
        ("B)", 0, "B: gripper"),
        ("where", 1, "conditions on the geometry"),
        ("j1", 1, "joint"),
        ("c.A", 2, "effector A: gripper"),
        ("std.rules", 5, None),
        ("stairs", 2, "scene stairs("),
        ("bound", 1, "finest motion bound"),
        ("seq }", 1, "a value of the option `bound`"),
        ("sphere", 1, "a ball"),
        ("int =", 1, "a whole number"),
    ],
)
def test_hover(session: Session, word: str, behind: int, told: str | None) -> None:
    uri = session.open(PROGRAM)
    found = session.at("textDocument/hover", uri, word, behind)
    assert (found is None) == (told is None)
    assert told is None or told in found["contents"]["value"]


@pytest.mark.parametrize(
    ("word", "behind", "line"),
    [
        ("plate p", 1, "type plate < base"),
        ("half(reach", 1, "function half(x: length) = 0.5 * x"),
        ("x\n\nrule", 0, "function half(x: length) = 0.5 * x"),
        ("(on X A)", 4, "rule leave(A: gripper, X: base) {"),
        ("b)", 0, "    object b: sphere(4 cm) at (0, 0, 3 m)"),
        ("c.A", 2, "    effector A: gripper sphere(0.05 m) normal (0, 0, -1)"),
        ("A on p", 0, "    effector A: gripper sphere(0.05 m) normal (0, 0, -1)"),
        ("p[1]\n", 0, "    plate p[1]: box(1 m, 1 m, 0.05 m) at (5 m, 0, 0)"),
    ],
)
def test_definition(session: Session, word: str, behind: int, line: str) -> None:
    uri = session.open(PROGRAM)
    (place,) = session.at("textDocument/definition", uri, word, behind)
    assert place["uri"] == uri
    assert PROGRAM.split("\n")[place["range"]["start"]["line"]] == line


def test_definition_leads_into_the_standard_library(session: Session) -> None:
    uri = session.open(PROGRAM)
    (place,) = session.at("textDocument/definition", uri, "held")
    assert place["uri"].endswith("stdlib/logic.tamp")
    line = (ROOT / "stdlib" / "logic.tamp").read_text().splitlines()[place["range"]["start"]["line"]]
    assert "derived (held" in line
    (file,) = session.at("textDocument/definition", uri, "std.scenes", 5)
    assert file["uri"].endswith("stdlib/scenes.tamp")


def test_references_and_highlights(session: Session) -> None:
    uri = session.open(PROGRAM)
    (session.folder / "other.tamp").write_text('import "program.tamp"\ntype disc < plate\n')
    found = session.at("textDocument/references", uri, "plate <", context={"includeDeclaration": True})
    assert [f["uri"].rpartition("/")[2] for f in found] == ["program.tamp", "program.tamp", "other.tamp"]
    uses = session.at("textDocument/references", uri, "plate <", context={"includeDeclaration": False})
    assert len(uses) == 2
    marks = session.at("textDocument/documentHighlight", uri, "(on X A)", 4)
    assert session.words(uri, marks) == ["X", "X", "X"]


def test_rename_across_files(session: Session) -> None:
    uri = session.open(PROGRAM)
    other = (session.folder / "other.tamp").as_uri()
    (session.folder / "other.tamp").write_text('import "program.tamp"\ntype disc < plate\n')
    edit = session.at("textDocument/rename", uri, "plate <", newName="slab")
    assert session.edited(uri, edit["changes"][uri]) == PROGRAM.replace("plate <", "slab <").replace(
        "plate p", "slab p"
    )
    assert [e["newText"] for e in edit["changes"][other]] == ["slab"]


def test_a_variable_is_renamed_in_its_own_reach(session: Session) -> None:
    uri = session.open(PROGRAM)
    edit = session.at("textDocument/rename", uri, "B: gripper {", 0, newName="C")
    assert session.edited(uri, edit["changes"][uri]) == PROGRAM.replace(
        "exists B: gripper { (on X B) and B != A }", "exists C: gripper { (on X C) and C != A }"
    )


def test_an_effector_is_renamed_with_the_uses_of_robots(session: Session) -> None:
    uri = session.open(PROGRAM)
    edit = session.at("textDocument/rename", uri, "effector A", 9, newName="foot")
    text = session.edited(uri, edit["changes"][uri])
    assert "effector foot:" in text and "(linked foot B)" in text and "foot on p[1]" in text and "c.foot" in text


@pytest.mark.parametrize(
    ("word", "name", "line"),
    [
        ("x: length", "sqrt", 0),
        ("n: int", "count", 0),
        ("n: int", "c", 24),
        ("p[1]: box", "b", 27),
        ("arm(", "plate", 5),
        ("half(x", "sqrt", None),
        ("B: gripper {", "A", 12),
    ],
)
def test_no_name_that_is_taken_is_given(session: Session, word: str, name: str, line: int | None) -> None:
    """A new name that something else in sight has would change what the program means; 0: it has not."""
    uri = session.open(PROGRAM)
    where = {"textDocument": {"uri": uri}, "position": session.position(uri, word, 0)}
    answer = session.answer("textDocument/rename", newName=name, **where)
    assert ("error" in answer) == (line != 0)
    assert not line or f"line {line} of" in answer["error"]["message"]


def test_completion_of_paths(session: Session) -> None:
    (session.folder / "other.tamp").write_text("type a < object\n")
    assert list(labels(session, 'import "|\n')) == ["other.tamp"]


@pytest.mark.parametrize("line", ["derived (q X: object) =", "heuristic h(X: object) { start"])
def test_the_next_declaration_is_read_behind_a_half_typed_one(session: Session, line: str) -> None:
    """`task` is also a name that may stand in a condition or a value."""
    uri = session.open(PROGRAM.replace("task t(", f"{line}\ntask t("))
    found = [d["range"]["start"]["line"] for d in session.diagnostics(uri) if d["severity"] == 1]
    assert found == [PROGRAM[: PROGRAM.index("task t(")].count("\n")]


def test_names_of_the_library_are_not_renamed(session: Session) -> None:
    uri = session.open(PROGRAM)
    where = {"textDocument": {"uri": uri}, "position": session.position(uri, "held")}
    assert "standard library" in session.answer("textDocument/rename", newName="x", **where)["error"]["message"]
    where["position"] = session.position(uri, "plate <")
    word = session.answer("textDocument/rename", newName="forall", **where)["error"]["message"]
    assert "word of the language" in word


def labels(session: Session, text: str) -> dict[str, dict[str, object]]:
    """The completions at the mark `|` of a text."""
    uri = session.open(text.replace("|", "", 1))
    before = text[: text.index("|")]
    position = {"line": before.count("\n"), "character": len(before) - before.rfind("\n") - 1}
    found = session.request("textDocument/completion", textDocument={"uri": uri}, position=position)
    return {item["label"]: item for item in found["items"]}


@pytest.mark.parametrize(
    ("text", "some", "none"),
    [
        ("import |", ["std.rules", "std.scenes"], ["rule", "box"]),
        ("import std.|", ["rules"], ["std.rules"]),
        ("|", ["task", "rule", "import"], ["pre", "box", "goal"]),
        ("import std.rules\nrule r(A: |) {\n}\n", ["gripper", "object", "effector"], ["held", "box"]),
        ("import std.rules\nrule r(A: gripper) {\n    pre (|\n}\n", ["support", "on", "held"], ["stable", "step"]),
        ("import std.rules\nrule r(A: gripper) {\n    post [|\n}\n", ["stable", "touch"], ["support", "step"]),
        ("import std.rules\nrule r(A: gripper) {\n    pre (support |\n}\n", ["A"], ["support"]),
        ("import std.rules\nrule r(A: gripper) {\n    |\n}\n", ["pre", "where", "post", "cost"], ["goal", "task"]),
        ("import std.scenes\ntask t() {\n    scene |\n}\n", ["stairs"], ["base", "box"]),
        ("import std.crawler\nimport std.scenes\ntask t() {\n    |\n}\n", ["crawler", "base", "goal", "fact"],
         ["stairs"]),
        ("import std.crawler\nimport std.rules\ntask t() {\n    base g: box(1 m, 1 m, 1 m) at (0, 0, 0)\n"
         "    crawler c: |\n}\n", ["A", "B"], ["held"]),
        ("import std.rules\ntask t() {\n    base g: |\n}\n", ["box", "sphere"], ["held"]),
        ("task t() {\n    options { | }\n}\n", ["bound", "time"], ["box", "goal"]),
        ("task t() {\n    options { bound = | }\n}\n", ["seq_path", "path"], ["bound", "goal"]),
        ("import std.heuristics\ntask t() {\n    guide |\n}\n", ["climb"], ["step"]),
        ("import std.rules\nheuristic h(X: object) {\n    start 0\n    |\n}\n", ["step", "grasp"], ["base"]),
        ("import std.rules\nrule r(c: chain of module by connected) {\n    pre (support c.|\n}\n", ["first", "last"],
         ["A"]),
        ("module m() {\n    joint j: |\n}\n", ["revolute", "prismatic"], ["box"]),
        ("motion [m X: object] {\n    at switch |\n}\n", ["gap", "X", "position"], ["distance"]),
        ("task t(n: |) {\n}\n", ["int", "length"], ["object"]),
        ("import std.scenes\ntask t() {\n    scene stairs(3, |\n}\n", ["depth =", "rise ="], []),
        ("module m() {\n    joint j: revolute(|\n}\n", ["x", "y", "z"], ["sqrt"]),
        ("motion [m X: object] {\n    during axis(X, |\n}\n", ["x", "y", "z"], ["X"]),
        ("task t() {\n    options { minimise = makespan + | }\n}\n", ["travel", "energy"], ["bound"]),
        ("import std.logic\nderived (q X: object) = |\n", ["X"], ["q"]),
        ("function f(x: |\n", ["length"], ["forall"]),
        ("predicate (q X: |\n", ["object"], ["forall", "ANY"]),
    ],
)  # fmt: skip
def test_completion(session: Session, text: str, some: list[str], none: list[str]) -> None:
    found = labels(session, text)
    assert [name for name in some if name not in found] == []
    assert [name for name in none if name in found] == []


def test_completions_have_snippets(session: Session) -> None:
    found = labels(session, "import std.rules\nrule r(A: gripper) {\n    pre (|\n}\n")
    assert found["on"]["insertText"] == "on ${1:X} ${2:A}" and found["on"]["insertTextFormat"] == 2
    assert "stands, or lies, on X" in str(found["on"]["documentation"])
    assert "pre   " in str(labels(session, "|")["rule"]["insertText"])


def test_signature_help(session: Session) -> None:
    uri = session.open(PROGRAM)
    found = session.at("textDocument/signatureHelp", uri, "stairs(n, 10", len("stairs(n, "))
    assert found["signatures"][0]["label"].startswith("stairs(n: int, depth: length")
    assert found["activeParameter"] == 1
    literal = session.at("textDocument/signatureHelp", uri, "(on X A)", len("(on X "))
    assert literal["signatures"][0]["label"] == "(on X: object A: object)" and literal["activeParameter"] == 1
    built_in = session.at("textDocument/signatureHelp", uri, "sphere(4 cm", len("sphere("))
    assert built_in["signatures"][0]["label"] == "sphere(radius)"


def test_symbols(session: Session) -> None:
    uri = session.open(PROGRAM)
    found = session.request("textDocument/documentSymbol", textDocument={"uri": uri})
    assert [s["name"] for s in found] == ["plate", "half", "leave", "arm", "t"]
    assert [s["name"] for s in found[3]["children"]] == ["A", "j1", "B"]
    assert [s["name"] for s in found[4]["children"]] == ["p", "b", "c"]
    (session.folder / "other.tamp").write_text("scene elsewhere() {\n}\n")
    (symbol,) = session.request("workspace/symbol", query="elswhr")
    assert symbol["name"] == "elsewhere" and symbol["location"]["uri"].endswith("other.tamp")


def test_semantic_tokens(session: Session) -> None:
    uri = session.open(PROGRAM)
    found = session.request("textDocument/semanticTokens/full", textDocument={"uri": uri})
    whole = decoded(PROGRAM, found["data"])
    assert ("on", "function") in whole and ("plate", "type") in whole and ("rule", "keyword") in whole
    assert ("5 cm", "number") in whole and ("## Half of a length.", "comment") in whole
    part = {"start": {"line": 0, "character": 0}, "end": {"line": 1, "character": 0}}
    some = session.request("textDocument/semanticTokens/range", textDocument={"uri": uri}, range=part)
    assert decoded(PROGRAM, some["data"]) == [("import", "keyword"), ("std.rules", "namespace")]


def decoded(text: str, data: list[int]) -> list[tuple[str, str]]:
    from tamplang.lsp.tokens import LEGEND

    lines, line, column, found = text.split("\n"), 0, 0, []
    for i in range(0, len(data), 5):
        line, column = line + data[i], data[i + 1] + (column if data[i] == 0 else 0)
        found.append((lines[line][column : column + data[i + 2]], LEGEND[data[i + 3]]))
    return found


def test_folding(session: Session) -> None:
    uri = session.open(PROGRAM)
    found = session.request("textDocument/foldingRange", textDocument={"uri": uri})
    lines = PROGRAM.split("\n")
    assert {lines[f["startLine"]] for f in found} >= {"import std.rules", "task t(n: int = 3) {"}


def test_inlay_hints(session: Session) -> None:
    uri = session.open(PROGRAM)
    whole = {"start": {"line": 0, "character": 0}, "end": {"line": 99, "character": 0}}
    found = session.request("textDocument/inlayHint", textDocument={"uri": uri}, range=whole)
    assert {"depth:", "1.571 rad"} <= {h["label"] for h in found}


def test_formatting(session: Session) -> None:
    uri = session.open("type   plate<object\n\ntype   b<object\n")
    options = {"tabSize": 4, "insertSpaces": True}
    edits = session.request("textDocument/formatting", textDocument={"uri": uri}, options=options)
    assert session.edited(uri, edits) == "type plate < object\n\ntype b < object\n"
    part = {"start": {"line": 2, "character": 0}, "end": {"line": 2, "character": 3}}
    edits = session.request("textDocument/rangeFormatting", textDocument={"uri": uri}, range=part, options=options)
    assert session.edited(uri, edits) == "type   plate<object\n\ntype b < object\n"


def test_code_lens(session: Session) -> None:
    uri = session.open(PROGRAM)
    found = session.request("textDocument/codeLens", textDocument={"uri": uri})
    assert [(f["command"]["command"], f["command"]["arguments"]) for f in found] == [
        ("tamplang.solve", [uri, "t"]),
        ("tamplang.run", [uri, "t"]),
    ]
    assert "task t" in PROGRAM.split("\n")[found[0]["range"]["start"]["line"]]


def test_columns_count_as_editors_count(session: Session) -> None:
    """A sign beyond the basic plane is two units of UTF-16."""
    uri = session.open('import "𝄞𝄞.tamp" type a < b\n')
    symbols = session.request("textDocument/documentSymbol", textDocument={"uri": uri})
    assert symbols[0]["selectionRange"]["start"] == {"line": 0, "character": len('import "𝄞𝄞.tamp" type ') + 2}
