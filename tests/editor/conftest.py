"""A client of the language server: a real session over standard input and output."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[2]


class Session:
    """Sends requests and notifications and reads what comes back, one message at a time."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.process = subprocess.Popen(
            [sys.executable, "-m", "tamplang", "lsp"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            cwd=folder,
            env={**os.environ, "PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": "1"},
        )
        self.last = 0
        self.published: list[dict[str, Any]] = []
        self.texts: dict[str, str] = {}

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
        assert message.get("method") != "window/logMessage", message["params"]["message"]
        if message.get("method") == "textDocument/publishDiagnostics":
            self.published.append(message["params"])
        return message

    def answer(self, method: str, **parameters: Any) -> dict[str, Any]:
        self.last += 1
        self.send(id=self.last, method=method, params=parameters)
        while (message := self.receive()).get("id") != self.last:
            pass
        return message

    def request(self, method: str, **parameters: Any) -> Any:
        message = self.answer(method, **parameters)
        assert "error" not in message, message
        return message["result"]

    def open(self, text: str, name: str = "program.tamp") -> str:
        """A buffer with that text; gives its address."""
        uri = (self.folder / name).as_uri()
        self.texts[uri] = text
        document = {"uri": uri, "languageId": "tamplang", "version": 1, "text": text}
        self.send(method="textDocument/didOpen", params={"textDocument": document})
        return uri

    def change(self, uri: str, text: str, version: int) -> None:
        self.texts[uri] = text
        changes = {"textDocument": {"uri": uri, "version": version}, "contentChanges": [{"text": text}]}
        self.send(method="textDocument/didChange", params=changes)

    def diagnostics(self, uri: str, version: int | None = None) -> list[dict[str, Any]]:
        """What is told of a text, the next time that anything is."""
        while True:
            message = self.receive()
            told = message.get("params", {})
            of_text = message.get("method") == "textDocument/publishDiagnostics" and told["uri"] == uri
            if of_text and version in (None, told.get("version")):
                found: list[dict[str, Any]] = told["diagnostics"]
                return found

    def at(self, method: str, uri: str, word: str, behind: int = 1, **more: Any) -> Any:
        """A request at the place `behind` characters behind the start of the first `word`."""
        return self.request(method, textDocument={"uri": uri}, position=self.position(uri, word, behind), **more)

    def position(self, uri: str, word: str, behind: int = 1) -> dict[str, int]:
        before = self.texts[uri][: self.texts[uri].index(word) + behind]
        return {"line": before.count("\n"), "character": len(before) - before.rfind("\n") - 1}

    def words(self, uri: str, found: list[dict[str, Any]]) -> list[str]:
        """What stands in the text at the ranges of some answers."""
        lines = self.texts[uri].split("\n")
        return [
            lines[f["range"]["start"]["line"]][f["range"]["start"]["character"] : f["range"]["end"]["character"]]
            for f in found
        ]

    def edited(self, uri: str, edits: list[dict[str, Any]]) -> str:
        """The text with the edits of an answer."""
        text = self.texts[uri]
        starts = [0]
        for line in text.split("\n"):
            starts.append(starts[-1] + len(line) + 1)
        for edit in sorted(edits, key=lambda e: (-e["range"]["start"]["line"], -e["range"]["start"]["character"])):
            first, last = (starts[edit["range"][k]["line"]] + edit["range"][k]["character"] for k in ("start", "end"))
            text = text[:first] + edit["newText"] + text[last:]
        return text


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Session]:
    session = Session(tmp_path_factory.mktemp("project"))
    folders = [{"uri": session.folder.as_uri(), "name": "project"}]
    capabilities = {"general": {"positionEncodings": ["utf-16"]}}
    session.request("initialize", processId=None, rootUri=None, capabilities=capabilities, workspaceFolders=folders)
    session.send(method="initialized", params={})
    yield session
    session.request("shutdown")
    session.send(method="exit")
    assert session.process.wait(timeout=30) == 0


@pytest.fixture
def session(server: Session) -> Iterator[Session]:
    """The server without open texts."""
    server.published.clear()
    yield server
    for uri in server.texts:
        server.send(method="textDocument/didClose", params={"textDocument": {"uri": uri}})
    server.texts.clear()
    server.request("workspace/symbol", query="")
    for path in server.folder.iterdir():
        path.unlink()
