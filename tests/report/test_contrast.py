"""Every text on the page stands out from what it stands on by at least 4.5 to 1, light and dark."""

from __future__ import annotations

import re
from importlib.resources import files

import pytest

from tamplang.runtime.report.timeline import RULE_COLOURS

LEAST = 4.5
TEXTS = ("ink", "soft", "accent", "good", "bad", "warn")


def schemes() -> dict[str, dict[str, str]]:
    css = (files("tamplang.runtime.report") / "templates" / "report.css").read_text(encoding="utf-8")
    blocks = re.findall(r":root \{(.*?)\}", css, re.DOTALL)
    light, dark = (dict(re.findall(r"--([\w-]+): (#[0-9a-f]{6})", block)) for block in blocks[:2])
    return {"light": light, "dark": {**light, **dark}}


def luminance(colour: str) -> float:
    """Relative, of sRGB, as WCAG 2 tells it."""
    parts = (int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5))
    red, green, blue = (p / 12.92 if p <= 0.03928 else ((p + 0.055) / 1.055) ** 2.4 for p in parts)
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def contrast(text: str, paper: str) -> float:
    dim, bright = sorted((luminance(text), luminance(paper)))
    return (bright + 0.05) / (dim + 0.05)


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_texts_stand_out_from_their_paper(scheme: str) -> None:
    colours = schemes()[scheme]
    pairs = [(text, paper) for text in TEXTS for paper in ("paper", "panel", "mark")]
    pairs += [("good", "good-paper"), ("bad", "bad-paper"), ("ink", "bad-paper")]
    weak = {p: round(contrast(colours[p[0]], colours[p[1]]), 2) for p in pairs}
    assert {p: value for p, value in weak.items() if value < LEAST} == {}


def test_actions_stand_out_from_the_colours_of_rules() -> None:
    assert [c for c in RULE_COLOURS if contrast("#ffffff", c) < LEAST] == []
