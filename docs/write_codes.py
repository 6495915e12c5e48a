"""Writes docs/codes.md from the table of codes: python docs/write_codes.py"""

from __future__ import annotations

from pathlib import Path

from tamplang.langs.codes import CODES
from tamplang.langs.explanation import CodeInfo, examples


def text() -> str:
    """The page. A test refuses one that is not what this gives."""
    parts = ["# Codes", "What every message means; `tamplang explain CODE` says the same on a terminal."]
    return "\n\n".join([*parts, *(_section(code, info) for code, info in CODES.items())]) + "\n"


def _section(code: str, info: CodeInfo) -> str:
    parts = [f"## {code}: {info.title}", info.explanation]
    for kind, example in zip(("Wrong", "Right"), examples(code), strict=True):
        for index, block in enumerate(example.shown):
            heading = " ".join([f"{kind}:"] * (index == 0) + [f"`{block.heading}`"] * bool(block.heading))
            parts += [heading] * bool(heading) + [f"```{block.language}\n{block.text}\n```"]
    return "\n\n".join(parts)


if __name__ == "__main__":
    (Path(__file__).parent / "codes.md").write_text(text(), encoding="utf-8")
