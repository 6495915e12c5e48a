"""A plan as one self-contained HTML page: 3-D replay, timeline, evidence, sources. Works offline."""

from .render import render_report, write_report

__all__ = ["render_report", "write_report"]
