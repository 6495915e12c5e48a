"""A page with the explanation of every code, on this machine, for the links of diagnostics."""

from __future__ import annotations

import html
from functools import cache

from .. import __version__
from ..langs.codes import CODES
from ..langs.disk_cache import cache_folder
from ..langs.explanation import CodeInfo, examples
from ..langs.writer import write_atomically

_STYLE = "body{max-width:50em;margin:2em auto;font:16px/1.5 sans-serif;padding:0 1em}pre{background:#8882;padding:.6em}"


def page_uri(code: str) -> str:
    """The address of the explanation of a code."""
    return f"{_page()}#{code}"


@cache
def _page() -> str:
    """The address of the page, which is written anew by every version."""
    file = cache_folder() / f"codes-{__version__}.html"
    try:
        file.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        write_atomically(file, page_text().encode())
    except OSError:
        pass  # the link then leads nowhere; the diagnostic itself says what is wrong
    return file.absolute().as_uri()


def page_text() -> str:
    """The page as HTML."""
    parts = [_section(code, info) for code, info in CODES.items()]
    head = (
        f'<!doctype html><html lang="en"><meta charset="utf-8"><title>Codes of tamplang</title><style>{_STYLE}</style>'
    )
    return "\n".join([head, "<h1>Codes</h1>", *parts, "</html>", ""])


def _section(code: str, info: CodeInfo) -> str:
    text = f'<h2 id="{code}">{code}: {html.escape(info.title)}</h2><p>{html.escape(info.explanation)}</p>'
    for kind, example in zip(("Wrong", "Right"), examples(code), strict=True):
        for index, block in enumerate(example.shown):
            heading = " ".join([f"{kind}:"] * (index == 0) + [block.heading] * bool(block.heading))
            text += f"<p>{heading}</p>" * bool(heading) + f"<pre>{html.escape(block.text)}</pre>"
    return text
