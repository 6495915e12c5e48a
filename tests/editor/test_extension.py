"""The VS Code extension: it packs offline, and its client talks to the real server."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ET
import zipfile
from pathlib import Path

import pytest

from .conftest import ROOT

FOLDER = ROOT / "editors" / "vscode"


def test_the_extension_packs(tmp_path: Path) -> None:
    subprocess.run([sys.executable, ROOT / "editors" / "build_vsix.py", tmp_path], check=True, capture_output=True)
    (packed,) = tmp_path.glob("*.vsix")
    with zipfile.ZipFile(packed) as archive:
        names = set(archive.namelist())
        package = json.loads(archive.read("extension/package.json"))
        ET.fromstring(archive.read("extension.vsixmanifest"))
        ET.fromstring(archive.read("[Content_Types].xml"))
    paths = [package["main"], *(g["path"] for g in package["contributes"]["grammars"])]
    paths += [entry["configuration"] for entry in package["contributes"]["languages"]]
    assert {"extension/" + os.path.normpath(p) for p in paths} <= names
    assert {"extension.vsixmanifest", "[Content_Types].xml", "extension/rpc.js"} <= names


@pytest.mark.skipif(shutil.which("node") is None, reason="VS Code has a node of its own; here there is none")
def test_the_client_talks_to_the_server(tmp_path: Path) -> None:
    script = f"""
const {{ Connection }} = require({json.dumps(str(FOLDER / "rpc.js"))});
const c = new Connection({json.dumps(sys.executable)}, ["-m", "tamplang", "lsp"], {json.dumps(str(tmp_path))},
  (method, params) => {{ if (params.diagnostics) {{
    console.log(params.diagnostics[0].code); c.close(); }} }}, (why) => console.log(why));
c.request("initialize", {{ processId: null, rootUri: null, capabilities: {{}} }}).then(() => {{
  c.notify("initialized", {{}});
  c.notify("textDocument/didOpen", {{ textDocument: {{ uri: "file:///t.tamp", languageId: "tamplang", version: 1,
    text: "type a < b\\n# 𝄞" }} }});
}});
"""
    (tmp_path / "client.js").write_text(script, encoding="utf-8")
    done = subprocess.run(
        ["node", "client.js"], cwd=tmp_path, capture_output=True, text=True, timeout=120,
        env={**os.environ, "PYTHONPATH": str(ROOT)}, check=True,
    )  # fmt: skip
    assert done.stdout.split("\n")[:2] == ["E0102", "the server ended with status 0"], done
