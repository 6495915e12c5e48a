"""Writes docs/codes.md from the table of codes: python docs/write_codes.py"""

from __future__ import annotations

from pathlib import Path

from tamplang.langs.codes import CODES
from tamplang.langs.explanation import CodeInfo


def text() -> str:
    """The page. A test refuses one that is not what this gives."""
    parts = ["# Codes", "What every message means; `tamplang explain CODE` says the same on a terminal."]
    return "\n\n".join([*parts, *(_section(code, info) for code, info in CODES.items())]) + "\n"


def _section(code: str, info: CodeInfo) -> str:
    parts = [f"## {code}: {info.title}", info.explanation]
    for heading, example in (("Wrong", info.wrong), ("Right", info.right)):
        if example:
            parts.append(f"{heading}:\n\n```text\n{example}\n```")
    return "\n\n".join(parts)


if __name__ == "__main__":
    (Path(__file__).parent / "codes.md").write_text(text(), encoding="utf-8")
