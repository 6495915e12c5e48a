"""Photographs the reports of eight solves: python docs/write_report_pictures.py [NAME…]. Needs Pillow,
playwright and a Chromium; takes two minutes, and two more for `many`."""

from __future__ import annotations

import io
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

from PIL import Image
from playwright.sync_api import sync_playwright
from write_pictures import ARGUMENTS, BROWSERS, FOLDER, ROOT, STIFF

EXAMPLES = ROOT / "examples"
COLOURS = 192
"""Of a picture: a palette keeps text sharp and files below 150 kB."""


SCROLL = "[...document.querySelectorAll('h2, h3, summary')].find(h => /Refused/.test(h.textContent))?.scrollIntoView()"


def tamplang(folder: Path, *arguments: object) -> None:
    """One command as users give it; what fails here fails in the report."""
    command = [sys.executable, "-m", "tamplang", *map(str, arguments)]
    subprocess.run(command, cwd=folder, check=False, capture_output=True)


def solve(*arguments: object) -> Callable[[Path, Path], None]:
    """Makes the report of a solve."""
    return lambda folder, page: tamplang(folder, "solve", *arguments, "--report", page)


def stiff(folder: Path, page: Path) -> None:
    """Motion refuses every way: the arm bends too little."""
    (folder / "stiff.tamp").write_text(STIFF)
    tamplang(folder, "solve", "stiff.tamp", "--report", page)


def enclosed(folder: Path, page: Path) -> None:
    """The ball is within reach, and walls are all around it."""
    walls = "".join(
        f"    base wall{k}: box({x} cm, {y} cm, {z} cm) at ({at})\n"
        for k, (x, y, z, at) in enumerate((
            (2, 24, 24, "0.33 m, 0, 14.5 cm"), (2, 24, 24, "0.57 m, 0, 14.5 cm"),
            (22, 2, 24, "0.45 m, 11 cm, 14.5 cm"), (22, 2, 24, "0.45 m, -11 cm, 14.5 cm"),
            (26, 24, 2, "0.45 m, 0, 27.6 cm"),
        ))
    )  # fmt: skip
    text = STIFF.replace("-20 deg .. 20 deg", "-120 deg .. 120 deg").replace("(0, 0.5 m, 30 cm)", "(0.45 m, 0, 10 cm)")
    (folder / "enclosed.tamp").write_text(text.replace("    stiff c:", f"{walls}    stiff c:"))
    tamplang(folder, "solve", "enclosed.tamp", "--report", page)


def run(folder: Path, page: Path) -> None:
    """Stairs that sink and drift."""
    tamplang(folder, "run", EXAMPLES / "moving_stairs.tamp", "-p", "n=8", "--report", page)


def compared(folder: Path, page: Path) -> None:
    """The same task with a staircase of another height."""
    for name, rise in (("one", 1), ("two", 2)):
        tamplang(folder, "solve", EXAMPLES / "climb.tamp", "-p", "n=4", "-p", f"crawlers={rise}", "--out",
                 f"{name}.plan.json")
    tamplang(folder, "report", "one.plan.json", "two.plan.json", "-o", page)


CLIMB, CHAIN, ITEMS = (EXAMPLES / f"{name}.tamp" for name in ("climb", "chain_climb", "mobile_manipulator"))
REPORTS: dict[str, Callable[[Path, Path], None]] = {
    "found": solve(CLIMB, "-p", "n=8"),
    "infeasible": solve(CHAIN, "-p", "modules=2", "-p", "missing=1"),
    "refused": stiff,
    "enclosed": enclosed,
    "unfinished": solve(CLIMB, "-p", "n=64", "--nodes", "3"),
    "replanned": run,
    "compared": compared,
    "many": solve(ITEMS, "-p", "objects=64", "--time", "900"),
}


def photographed(pages: dict[str, Path]) -> None:
    """The head of each page, and of `refused` also as on a telephone."""
    with sync_playwright() as playwright:
        found = next((p for p in map(shutil.which, BROWSERS) if p), None)
        browser = playwright.chromium.launch(executable_path=found, args=ARGUMENTS)
        for name, page in pages.items():
            sizes = {f"report_{name}": (1100, 900)}
            sizes |= {"report_refused_narrow": (420, 1400)} if name == "refused" else {}
            for file, (width, height) in sizes.items():
                view = browser.new_page(viewport={"width": width, "height": height}, color_scheme="light")
                view.goto(page.as_uri())
                view.wait_for_timeout(4000)
                if "narrow" in file:
                    view.evaluate(SCROLL)
                    view.wait_for_timeout(1000)
                picture = Image.open(io.BytesIO(view.screenshot())).convert("RGB").quantize(COLOURS)
                picture.save(FOLDER / f"{file}.png", optimize=True)
                view.close()
        browser.close()


def main(names: list[str]) -> None:
    """Write the pictures of the reports so called, or of all."""
    FOLDER.mkdir(exist_ok=True)
    with TemporaryDirectory() as place:
        pages = {}
        for name in names or REPORTS:
            page = Path(place) / f"{name}.html"
            REPORTS[name](Path(place), page)
            if page.exists():
                pages[name] = page
            else:
                print(f"no report of {name}", file=sys.stderr)
        photographed(pages)


if __name__ == "__main__":
    main(sys.argv[1:])
