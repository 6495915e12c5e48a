"""Diagnostics as JSON, and as SARIF 2.1.0 for code hosts and editors."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import PurePath
from typing import Any
from urllib.parse import quote

from .codes import CODES
from .diagnostics import Diagnostic
from .severity import severity
from .source import Span

_LEVELS = {"error": "error", "warning": "warning", "outcome": "note"}


def json_text(diagnostics: Sequence[Diagnostic]) -> str:
    """A JSON list, one object each; lines and columns count from 1, `start` and `end` characters from 0."""
    return json.dumps([_record(d) for d in diagnostics], indent=2, ensure_ascii=False)


def _record(diagnostic: Diagnostic) -> dict[str, Any]:
    info = CODES.get(diagnostic.code)
    return {
        "code": diagnostic.code,
        "severity": severity(diagnostic),
        "category": info.category if info is not None else None,
        "message": diagnostic.message,
        **_place(diagnostic.span),
        "labels": [{**_place(label.span), "text": label.text} for label in diagnostic.labels],
        "help": diagnostic.help,
        "note": diagnostic.note,
    }


def _place(span: Span | None) -> dict[str, Any]:
    names = ("file", "line", "column", "end_line", "end_column", "start", "end")
    return {name: None if span is None else getattr(span, name) for name in names}


def sarif_text(diagnostics: Sequence[Diagnostic]) -> str:
    """A SARIF 2.1.0 log with one run; its rules are the codes that occur."""
    codes = sorted({d.code for d in diagnostics})
    run = {
        "tool": {"driver": {"name": "tamplang", "rules": [_rule(code) for code in codes]}},
        "columnKind": "unicodeCodePoints",
        "results": [_result(d, codes.index(d.code)) for d in diagnostics],
    }
    log = {"$schema": "https://json.schemastore.org/sarif-2.1.0.json", "version": "2.1.0", "runs": [run]}
    return json.dumps(log, indent=2, ensure_ascii=False)


def _rule(code: str) -> dict[str, Any]:
    info = CODES.get(code)
    rule: dict[str, Any] = {"id": code}
    if info is not None:
        rule["shortDescription"] = {"text": info.title}
        rule["fullDescription"] = {"text": info.explanation}
    return rule


def _result(diagnostic: Diagnostic, index: int) -> dict[str, Any]:
    remarks = [r for r in (diagnostic.message, diagnostic.help, diagnostic.note) if r is not None]
    result: dict[str, Any] = {
        "ruleId": diagnostic.code,
        "ruleIndex": index,
        "level": _LEVELS[severity(diagnostic)],
        "message": {"text": "\n".join(remarks)},
    }
    if diagnostic.span is not None:
        result["locations"] = [_location(diagnostic.span)]
    if diagnostic.labels:
        result["relatedLocations"] = [
            {"id": i, **_location(label.span), "message": {"text": label.text}}
            for i, label in enumerate(diagnostic.labels)
        ]
    return result


def _location(span: Span) -> dict[str, Any]:
    region = {
        "startLine": max(span.line, 1),
        "startColumn": max(span.column, 1),
        "endLine": max(span.end_line, 1),
        "endColumn": max(span.end_column, 1),
        "charOffset": span.start,
        "charLength": span.end - span.start,
    }
    return {"physicalLocation": {"artifactLocation": {"uri": _uri(span.file)}, "region": region}}


def _uri(file: str) -> str:
    path = PurePath(file)
    return path.as_uri() if path.is_absolute() else quote(path.as_posix())
