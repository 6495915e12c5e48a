"""The language server in a real session over standard input and output."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from .conftest import ROOT, environment

PROGRAM = """import std.rules

## A plate to stand on.
type plate < base

task t() {
    plate p: box(1 m, 1 m, 0.05 m) at (0, 0, 0)
    object b: sphere(4 cm) at (0, 0, 1 m)
    fact (gripable b)
    goal (held b)
}
"""


class Session:
    """A client that sends requests and notifications and reads what comes back, one message at a time."""

    def __init__(self, folder: Path) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-m", "tamplang", "lsp"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            cwd=folder,
            env=environment(),
        )
        self.last = 0

    def send(self, **message: Any) -> None:
        assert self.process.stdin is not None
        body = json.dumps({"jsonrpc": "2.0", **message}).encode()
        self.process.stdin.write(b"Content-Length: %d\r\n\r\n%s" % (len(body), body))
        self.process.stdin.flush()

    def receive(self) -> dict[str, Any]:
        assert self.process.stdout is not None
        length = 0
        while line := self.process.stdout.readline().strip():
            name, _, value = line.partition(b":")
            if name.lower() == b"content-length":
                length = int(value)
        message: dict[str, Any] = json.loads(self.process.stdout.read(length))
        return message

    def request(self, method: str, **parameters: Any) -> Any:
        self.last += 1
        self.send(id=self.last, method=method, params=parameters)
        while (message := self.receive()).get("id") != self.last:
            pass
        assert "error" not in message, message
        return message["result"]

    def diagnostics(self) -> list[dict[str, Any]]:
        while (message := self.receive()).get("method") != "textDocument/publishDiagnostics":
            pass
        found: list[dict[str, Any]] = message["params"]["diagnostics"]
        return found


@pytest.fixture
def session(tmp_path: Path) -> Iterator[Session]:
    session = Session(tmp_path)
    capabilities = {"general": {"positionEncodings": ["utf-16"]}}
    session.request("initialize", processId=None, rootUri=None, capabilities=capabilities)
    session.send(method="initialized", params={})
    yield session
    session.request("shutdown")
    session.send(method="exit")
    assert session.process.wait(timeout=20) == 0


def opened(session: Session, folder: Path, text: str) -> str:
    uri = (folder / "program.tamp").as_uri()
    document = {"uri": uri, "languageId": "tamplang", "version": 1, "text": text}
    session.send(method="textDocument/didOpen", params={"textDocument": document})
    return uri


def position(text: str, word: str) -> dict[str, int]:
    """The place just behind the first letter of the first `word`."""
    before = text[: text.index(word) + 1]
    return {"line": before.count("\n"), "character": len(before) - before.rfind("\n") - 1}


def test_diagnostics_follow_the_text(session: Session, tmp_path: Path) -> None:
    uri = opened(session, tmp_path, PROGRAM)
    (diagnostic,) = (d for d in session.diagnostics() if d["severity"] == 1)
    assert diagnostic["code"] == "E0103"
    assert "grippable" in diagnostic["message"]
    assert diagnostic["range"]["start"] == {"line": 8, "character": 10}
    change = {"text": PROGRAM.replace("gripable", "grippable")}
    parameters = {"textDocument": {"uri": uri, "version": 2}, "contentChanges": [change]}
    session.send(method="textDocument/didChange", params=parameters)
    assert "E0103" not in {d["code"] for d in session.diagnostics()}


def test_hover_shows_the_declaration_and_its_text(session: Session, tmp_path: Path) -> None:
    document = {"uri": opened(session, tmp_path, PROGRAM)}
    own = session.request("textDocument/hover", textDocument=document, position=position(PROGRAM, "plate p"))
    assert "A plate to stand on." in own["contents"]["value"]
    imported = session.request("textDocument/hover", textDocument=document, position=position(PROGRAM, "base"))
    assert "A surface that a foot can stand on." in imported["contents"]["value"]
    assert session.request("textDocument/hover", textDocument=document, position={"line": 1, "character": 0}) is None


def test_definition_leads_into_the_standard_library(session: Session, tmp_path: Path) -> None:
    document = {"uri": opened(session, tmp_path, PROGRAM)}
    (place,) = session.request("textDocument/definition", textDocument=document, position=position(PROGRAM, "held"))
    assert place["uri"].endswith("stdlib/logic.tamp")
    line = (ROOT / "stdlib" / "logic.tamp").read_text().splitlines()[place["range"]["start"]["line"]]
    assert "derived (held" in line


def test_formatting_gives_the_standard_form(session: Session, tmp_path: Path) -> None:
    document = {"uri": opened(session, tmp_path, "type   plate<object\n")}
    options = {"tabSize": 4, "insertSpaces": True}
    (edit,) = session.request("textDocument/formatting", textDocument=document, options=options)
    assert edit["newText"] == "type plate < object\n"
