"""The language server. Needs the library pygls."""

from __future__ import annotations

from .server import serve

__all__ = ["serve"]
