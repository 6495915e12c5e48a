"""The page in a real browser, opened from a file: no error, no request, and a replay that moves."""

from __future__ import annotations

import base64
from collections.abc import Callable, Iterator
from pathlib import Path

import msgspec
import pytest
from playwright.sync_api import Browser, Page

from tamplang.runtime.plan import Plan
from tamplang.runtime.report import write_report

from .conftest import Opened, Opener
from .sample import SAMPLES, climb_plan, dock_plan, empty_plan, still_plan


@pytest.fixture(scope="module")
def climb_page(open_report: Opener, tmp_path_factory: pytest.TempPathFactory) -> Opened:
    path = tmp_path_factory.mktemp("report") / "climb.html"
    write_report(climb_plan(), path)
    return open_report(path)


@pytest.fixture
def opened(climb_page: Opened) -> Iterator[Opened]:
    """The page of `climb_plan`, at time 0; shared, since a page takes a second to open."""
    climb_page.seek(0.0)
    yield climb_page
    assert climb_page.errors == []


def same_pose(left: list[float], right: list[float]) -> bool:
    """Whether two poses agree, whatever the sign of their quaternions."""
    sign = 1.0 if sum(a * b for a, b in zip(left[3:], right[3:], strict=True)) >= 0.0 else -1.0
    return left == pytest.approx([*right[:3], *(sign * q for q in right[3:])], abs=1e-5)


@pytest.mark.parametrize(
    ("make", "scheme"),
    [(climb_plan, "dark"), (dock_plan, "light"), (empty_plan, "light"), (still_plan, "light")],
)
def test_opens_without_error_and_without_request(
    open_report: Opener, tmp_path: Path, make: Callable[[], Plan], scheme: str
) -> None:
    write_report(make(), tmp_path / "report.html")
    opened = open_report(tmp_path / "report.html", scheme=scheme)
    opened.page.wait_for_timeout(200)
    assert opened.errors == []
    assert opened.requests == [(tmp_path / "report.html").as_uri()]


INJECTED = """<script>window.injected = "script"</script><img src="x" onerror="window.injected = 'handler'">
<a id="lure" href="javascript:window.injected = 'address'">x</a><svg onload="window.injected = 'svg'"></svg>
<base href="https://example.invalid/">"""


def test_only_the_scripts_of_the_page_run(open_report: Opener, tmp_path: Path) -> None:
    path = tmp_path / "report.html"
    write_report(climb_plan(), path)
    page = path.read_text(encoding="utf-8")
    assert page.count("</main>") == 1
    path.write_text(page.replace("</main>", f"{INJECTED}</main>"), encoding="utf-8")
    opened = open_report(path)
    opened.page.locator("#lure").click(force=True)
    opened.page.wait_for_timeout(200)
    assert opened.page.evaluate("typeof window.injected") == "undefined"
    assert sum("Content Security Policy" in error for error in opened.errors) >= 4
    opened.seek(1.0)
    assert opened.pose("c[1].B")[:3] == pytest.approx([0.35, 0.0, 0.275], abs=0.03)


HOSTILE = (
    "</script><script>window.injected = 1</script><img src=x onerror=window.injected=1>\"'><b>{{ 7 * 7 }}"
    "<!--<script>&lt;'-(window.injected=1)-'\u202egnp.exe\u2028"
)


@pytest.mark.parametrize("name", [HOSTILE, "x" * 10_000])
def test_names_are_shown_as_text(open_report: Opener, tmp_path: Path, name: str) -> None:
    plan = climb_plan()
    task = msgspec.structs.replace(plan.task, name=name, file=name, goal=name)
    bodies = [msgspec.structs.replace(body, type=name) for body in plan.bodies]
    phases = [msgspec.structs.replace(phase, action=name, rule=name) for phase in plan.phases]
    plan = msgspec.structs.replace(plan, task=task, bodies=bodies, phases=phases)
    write_report(plan, tmp_path / "report.html")
    opened = open_report(tmp_path / "report.html")
    assert opened.page.evaluate("typeof window.injected") == "undefined"
    assert opened.errors == []
    assert opened.page.locator("h1").text_content() == name
    wide = opened.page.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth")
    assert wide <= 0, f"the page is {wide} px wider than its window"


def test_scrubbing_moves_the_scene_as_the_plan_says(opened: Opened, tmp_path: Path) -> None:
    plan = climb_plan()
    shots = []
    for index in (0, SAMPLES // 2, 2 * SAMPLES, 4 * SAMPLES, len(plan.times) - 1):
        opened.page.locator("#scrub").evaluate(
            "(slider, t) => { slider.value = t; slider.dispatchEvent(new Event('input')); }",
            plan.times[index],
        )
        later = index + 1 if plan.times[index + 1 : index + 2] == [plan.times[index]] else index
        assert opened.time() == pytest.approx(plan.times[index])
        assert same_pose(opened.pose("c[1]"), plan.tracks[0].poses[later])
        assert same_pose(opened.pose("target"), plan.body_tracks[0].poses[later])
        opened.page.wait_for_timeout(150)
        shots.append(opened.page.locator("#pane").screenshot(path=tmp_path / f"scrub{index}.png"))
    assert len(set(shots)) == len(shots)


def test_free_effector_lands_where_the_plan_puts_it(opened: Opened) -> None:
    before = opened.pose("c[1].B")
    opened.seek(1.0)
    after = opened.pose("c[1].B")
    assert after[:3] == pytest.approx([0.35, 0.0, 0.275], abs=0.03)
    assert max(abs(a - b) for a, b in zip(before, after, strict=True)) > 0.3
    assert opened.pose("c[1].A")[:3] == pytest.approx([-0.2, 0.0, 0.075], abs=1e-5)
    assert opened.pose("stair[2]") == pytest.approx([0.7, 0, 0.4, 0, 0, 0, 1], abs=1e-6)
    assert opened.pose("nobody") is None


def test_poses_between_samples_are_between(opened: Opened) -> None:
    plan = climb_plan()
    at = SAMPLES + 1 + SAMPLES // 2
    opened.seek((plan.times[at] + plan.times[at + 1]) / 2)
    middle = [
        (a + b) / 2 for a, b in zip(plan.tracks[0].poses[at], plan.tracks[0].poses[at + 1], strict=True)
    ]
    assert opened.pose("c[1]")[:3] == pytest.approx(middle[:3], abs=1e-5)


def test_play_runs_pauses_and_ends(opened: Opened) -> None:
    page = opened.page
    page.locator("#speed").select_option("0.25")
    page.locator("#play").click()
    assert page.locator("#play").inner_text() == "Pause"
    opened.wait("window.tamplang.time() > 0.1")
    page.locator("#play").click()
    stopped = opened.time()
    page.wait_for_timeout(150)
    assert 0.1 < opened.time() == stopped < 5.0
    page.keyboard.press("End")
    assert opened.time() == pytest.approx(5.0)
    page.locator("#speed").select_option("4")
    opened.seek(4.6)
    page.locator("#play").click()
    opened.wait("document.getElementById('play').textContent === 'Play'")
    assert opened.time() == pytest.approx(5.0)


def test_keys_and_blocks_jump_between_phases(opened: Opened) -> None:
    page = opened.page
    page.keyboard.press("ArrowRight")
    page.keyboard.press("ArrowRight")
    assert opened.time() == pytest.approx(2.0)
    page.keyboard.press("ArrowLeft")
    assert opened.time() == pytest.approx(1.0)
    page.keyboard.press(".")
    assert opened.time() == pytest.approx(1.1)
    page.locator("button.block").nth(3).click()
    assert opened.time() == pytest.approx(3.0)
    assert page.locator("button.block.now").inner_text() == "4 grasp"
    assert page.locator("#caption").inner_text() == "4. grasp(c[1].A, target)"
    page.locator("#next").click()
    assert opened.time() == pytest.approx(4.0)
    page.locator("#previous").focus()
    page.keyboard.press("Space")
    assert opened.time() == pytest.approx(3.0)


def test_joined_modules_take_one_hue(open_report: Opener, tmp_path: Path) -> None:
    write_report(dock_plan(), tmp_path / "dock.html")
    opened = open_report(tmp_path / "dock.html")
    assert opened.page.locator("#caption").inner_text() == "1. connect([c[1].A c[1].B], [c[2].B c[2].A])"
    opened.seek(1.5)
    assert opened.page.locator("#caption").inner_text().endswith("joined: c[1] + c[2]")
    assert opened.page.locator(".bracket").count() == 2


def test_joint_plots_follow_the_clock(opened: Opened) -> None:
    plan = climb_plan()
    opened.seek(plan.times[20])
    figure = opened.page.locator("#joints .plot").nth(3)
    assert figure.locator(".value").inner_text() == f"{plan.tracks[0].joints[20][3]:.2f} rad"
    assert float(figure.locator("line.cursor").get_attribute("x1") or "nan") == pytest.approx(100.0)
    box = figure.locator("svg").bounding_box()
    assert box is not None
    figure.locator("svg").click(position={"x": box["width"] / 2, "y": 20})
    assert opened.time() == pytest.approx(2.5, abs=0.05)


def test_link_to_a_source_opens_it(opened: Opened) -> None:
    link = opened.page.locator(".phase .place").first
    anchor = (link.get_attribute("href") or "")[1:]
    assert not opened.page.locator(f"[id='{anchor}']").is_visible()
    link.click()
    line = opened.page.locator(f"[id='{anchor}']")
    line.wait_for(state="visible")
    assert "rule step(A B: effector, X Y: base) {" in line.inner_text()


def test_a_moment_has_an_address(opened: Opened) -> None:
    opened.seek(1.25)
    opened.page.click("#moment")
    assert opened.page.evaluate("location.hash") == "#t=1.25"
    opened.seek(0.0)
    opened.page.evaluate("location.hash = 't=0.5'")
    opened.wait("window.tamplang.time() === 0.5")


def test_search_tree_filters(opened: Opened) -> None:
    page = opened.page
    everything = page.locator(".tree li:visible").count()
    page.locator("#tree-filter").fill("pruned")
    assert 0 < page.locator(".tree li:visible").count() < everything
    page.locator("#tree-filter").fill("")
    page.locator(".tree .fold").first.click()
    assert page.locator(".tree li:visible").count() == 1


def test_everything_that_moves_is_in_the_picture(opened: Opened) -> None:
    for time in (0.0, 0.5, 1.5, 2.5, 3.5, 5.0):
        opened.seek(time)
        for name in ("c[1].A", "c[1].B", "target"):
            x, y = opened.page.evaluate("n => window.tamplang.onScreen(n)", name)
            assert abs(x) < 1.0 and abs(y) < 1.0
    spread = opened.page.evaluate("n => { tamplang.seek(0); return tamplang.onScreen(n); }", "c[1].A")
    end = opened.page.evaluate("n => { tamplang.seek(5); return tamplang.onScreen(n); }", "c[1].A")
    assert max(abs(a - b) for a, b in zip(spread, end, strict=True)) > 0.6


def test_names_and_views(opened: Opened) -> None:
    """Names on request and under the pointer; from above, what lies higher is not drawn higher."""
    page = opened.page
    assert page.locator("#labels span:visible").count() == 0
    page.check("#names")
    shown = page.locator("#labels span:visible").all_inner_texts()
    assert {"c[1]", "ground"} <= set(shown)
    across, up = page.evaluate("tamplang.onScreen('c[1]')")
    box = page.locator("#pane").bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + box["width"] * (across + 1) / 2, box["y"] + box["height"] * (1 - up) / 2)
    assert page.inner_text("#tip") in page.evaluate("tamplang.names()")
    page.uncheck("#names")
    page.click("#above")
    above = page.evaluate("tamplang.onScreen('c[1]')")
    page.click("#side")
    assert page.evaluate("tamplang.onScreen('c[1]')") != above != [across, up]
    page.click("#whole")


PLAY = """async data => {
  const film = document.createElement("video");
  film.muted = true;
  film.src = URL.createObjectURL(new Blob([Uint8Array.from(atob(data), c => c.charCodeAt(0))]));
  await new Promise((go, fail) => { film.onloadeddata = go; film.onerror = () => fail(film.error.message); });
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [film.videoWidth, film.videoHeight];
  const drawing = canvas.getContext("2d"), pictures = [];
  for (const moment of [0, 1e6]) {
    await new Promise(go => { film.onseeked = go; film.currentTime = moment; });
    drawing.drawImage(film, 0, 0);
    pictures.push(canvas.toDataURL());
  }
  return [film.videoWidth, film.videoHeight, pictures];
}"""


def played(page: Page, film: bytes) -> tuple[int, int, list[str]]:
    """Width and height of a film, and its first and last picture, as another page plays it."""
    browser = page.context.browser
    assert browser is not None
    other = browser.new_page()
    width, height, pictures = other.evaluate(PLAY, base64.b64encode(film).decode())
    other.close()
    return width, height, pictures


def test_pictures_are_saved_and_paper_gets_one_per_switch(opened: Opened) -> None:
    page = opened.page
    with page.expect_download() as saved:
        page.click("#still")
    assert saved.value.suggested_filename == "climb-0.00s.png"
    assert Path(saved.value.path()).read_bytes().startswith(b"\x89PNG")
    page.select_option("#speed", "32")
    with page.expect_download() as film:
        page.click("#film")
    assert film.value.suggested_filename.startswith("climb.")
    width, height, pictures = played(page, Path(film.value.path()).read_bytes())
    assert width >= 300 and height >= 200
    assert len(set(pictures)) == len(pictures)
    page.select_option("#speed", "1")
    opened.seek(0.0)
    page.evaluate("window.dispatchEvent(new Event('beforeprint'))")
    assert page.locator("#stills canvas").count() == len(climb_plan().phases)
    assert opened.page.evaluate("tamplang.time()") == 0.0


def test_long_lines_of_sources_are_whole_on_paper(opened: Opened) -> None:
    page = opened.page
    page.emulate_media(media="print")
    page.set_viewport_size({"width": 400, "height": 800})
    page.evaluate("document.querySelectorAll('details').forEach(d => d.open = true)")
    blocks = "[...document.querySelectorAll('pre.code')]"
    beyond = page.evaluate(f"{blocks}.filter(block => block.scrollWidth > block.clientWidth + 1).length")
    assert beyond == 0
    page.emulate_media(media="screen")
    page.set_viewport_size({"width": 1280, "height": 720})


def test_following_keeps_the_robot_in_the_middle(opened: Opened) -> None:
    opened.page.locator("#follow").check()
    for time in (0.5, 2.5, 4.5):
        opened.seek(time)
        x, y = opened.page.evaluate("n => window.tamplang.onScreen(n)", "c[1]")
        assert abs(x) < 0.7 and abs(y) < 0.9
    opened.page.locator("#whole").click()
    assert not opened.page.locator("#follow").is_checked()


def test_without_webgl_the_rest_of_the_page_works(browser: Browser, tmp_path: Path) -> None:
    write_report(climb_plan(), tmp_path / "climb.html")
    page = browser.new_page()
    page.add_init_script("HTMLCanvasElement.prototype.getContext = () => null")
    opened = Opened(page, (tmp_path / "climb.html").as_uri())
    assert "needs WebGL" in page.locator("#trouble").inner_text()
    page.locator("button.block").nth(2).click()
    assert opened.time() == pytest.approx(2.0)
    assert opened.pose("c[1]") is None
    page.close()
