"""How bad a diagnostic is, by the first letter of its code."""

from __future__ import annotations

from .diagnostics import Diagnostic

_SEVERITIES = {"E": "error", "W": "warning", "S": "outcome"}


def severity(diagnostic: Diagnostic) -> str:
    """`error`, `warning` or `outcome`."""
    return _SEVERITIES[diagnostic.code[0]]
