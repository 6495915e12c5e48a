"""Draws the pictures of these pages, from examples that it solves: python docs/write_pictures.py. Needs the extra
`pictures` and a Chromium; takes a minute."""

from __future__ import annotations

from pathlib import Path

import tamplang

ROOT = Path(__file__).resolve().parents[1]
FOLDER = Path(__file__).parent / "pictures"
SHOWN: dict[str, tuple[dict[str, int], float]] = {
    "climb": ({"n": 8}, 0.65),
    "strut_bridge": ({}, 0.6),
    "mobile_manipulator": ({"objects": 1}, 0.4),
}
"""Examples, their parameters, and the share of the motion after which they are drawn."""


def main() -> None:
    """Write a still of each example."""
    FOLDER.mkdir(exist_ok=True)
    for name, (parameters, share) in SHOWN.items():
        plan = tamplang.load(ROOT / "examples" / f"{name}.tamp", **parameters).solve(time=120.0).plan
        assert plan is not None, name
        plan.export("png", FOLDER / f"{name}.png", at=share * plan.record.times[-1])


if __name__ == "__main__":
    main()
