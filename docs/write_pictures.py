"""Draws the pictures of these pages, from examples that it solves: python docs/write_pictures.py. Needs the extra
`pictures`, playwright and a Chromium; takes some minutes."""

from __future__ import annotations

import shutil
from pathlib import Path
from tempfile import TemporaryDirectory

from playwright.sync_api import sync_playwright

import tamplang
from tamplang.runtime.planner.plan_assembly import scene_at_rest
from tamplang.runtime.report.ending import ending_of
from tamplang.runtime.report.pictures import SIZE
from tamplang.runtime.report.render import render_replay

ROOT = Path(__file__).resolve().parents[1]
FOLDER = Path(__file__).parent / "pictures"
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")
ARGUMENTS = ["--no-sandbox", "--disable-gpu", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
STYLE = """main > section > :not(.stage), .stage > :not(.view) { display: none !important; }
body, main { margin: 0 !important; padding: 0 !important; } .stage, .view, #pane { border: 0 !important;
border-radius: 0 !important; width: 100vw !important; height: 100vh !important; max-height: none !important; }"""
SHOWN: dict[str, tuple[str | None, dict[str, float | str], float]] = {
    "climb": (None, {"n": 8}, 0.65),
    "rendezvous": (None, {}, 0.6),
    "chain_climb": (None, {}, 0.95),
    "terraces": (None, {"width": "1.7 m"}, 0.6),
    "strut_bridge": (None, {}, 0.6),
    "mobile_manipulator": (None, {"objects": 1}, 0.4),
    "quadruped": (None, {}, 1.0),
    "shared_table": (None, {}, 0.35),
    "mechanisms": ("drawer", {}, 0.8),
    "real_bridge": (None, {"drive": "38 N m"}, 1.0),
    "zoo/quadruped": ("own", {}, 0.6),
    "zoo/inchworm": ("own", {}, 0.8),
}
"""Examples, the task, its parameters, and the share of the motion after which they are drawn."""

STIFF = """import std.rules
module stiff {
    effector A: gripper sphere(0.05 m) normal (0, 0, -1)
    joint j1: revolute(z) in -3.1 rad .. 3.1 rad
    link 0.3 m: capsule(0.04 m)
    joint j2: revolute(y) in -20 deg .. 20 deg
    link 0.3 m: capsule(0.04 m)
    joint j3: revolute(y) in -20 deg .. 20 deg
    link 0.3 m: capsule(0.04 m)
    effector B: gripper sphere(0.05 m)
    fact (linked A B)
}
task stiff() {
    base ground: box(2 m, 2 m, 5 cm) at (0, 0, 0)
    object b: sphere(4 cm) at (0, 0.5 m, 30 cm)
    stiff c: A on ground at (0, 0)
    fact (grippable b)
    goal (held b)
}
"""


def main() -> None:
    """Write a still of each example."""
    FOLDER.mkdir(exist_ok=True)
    for name, (task, parameters, share) in SHOWN.items():
        plan = tamplang.load(ROOT / "examples" / f"{name}.tamp", task, **parameters).solve(time=120.0).plan
        assert plan is not None, name
        plan.export("png", FOLDER / f"{name.replace('/', '_')}.png", at=share * plan.record.times[-1])
    (FOLDER / "nearest_posture.png").write_bytes(nearest_posture())


def nearest_posture() -> bytes:
    """What the report of a solve shows that finds nothing."""
    task = tamplang.loads(STIFF)
    found = task.solve()
    scene = scene_at_rest(task.problem, found.statistics, found.timing)
    ending = ending_of(task.problem, found.status, found.explanation, found.misses, scene)
    return photographed(render_replay(scene, ending), 1.0)


def photographed(replay: str, moment: float) -> bytes:
    """The page of a replay at a moment, as PNG: the page marks what is missed."""
    found = next((p for p in map(shutil.which, BROWSERS) if p), None)
    with TemporaryDirectory() as folder, sync_playwright() as playwright:
        file = Path(folder) / "replay.html"
        file.write_text(replay, encoding="utf-8")
        browser = playwright.chromium.launch(executable_path=found, args=ARGUMENTS)
        page = browser.new_page(viewport={"width": SIZE[0], "height": SIZE[1]}, color_scheme="light")
        page.goto(file.as_uri())
        page.add_style_tag(content=STYLE)
        page.wait_for_function("window.tamplang !== undefined")
        page.evaluate("window.dispatchEvent(new Event('resize'))")
        page.evaluate("t => window.tamplang.seek(t)", moment)
        taken: bytes = page.locator("#pane").screenshot()
        browser.close()
        return taken


if __name__ == "__main__":
    main()
