"""Pictures of the replay without a display: the page's own drawing, in a Chromium without a window.

The picture is the one that the report shows, and the browser is what draws WebGL in software wherever there is no GPU.
"""

from __future__ import annotations

import asyncio
import io
import os
import shutil
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from ...langs.diagnostics import UsageError
from ...langs.writer import write_atomically
from ..native import MissingLibrary, load_extra
from ..plan import Plan
from .render import render_replay

FORMS = ("png", "gif", "mp4")
SIZE = (960, 540)
"""Pixels."""
RATE = 10.0
"""Pictures of a second, unless told otherwise: what drawings in papers and READMEs need at least."""
MOST = 3000
"""Pictures of a film; drawing one takes a tenth of a second and more."""
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")
ARGUMENTS = ["--no-sandbox", "--disable-gpu", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
STYLE = """main > section > :not(.stage), .stage > :not(.view) { display: none !important; }
body, main { margin: 0 !important; padding: 0 !important; } .stage, .view, #pane { border: 0 !important;
border-radius: 0 !important; width: 100vw !important; height: 100vh !important; max-height: none !important; }"""


def write_picture(plan: Plan, form: str, path: Path, rate: float | None = None, moment: float | None = None) -> None:
    """Write the `picture` of `plan` to `path`, atomically. Raises what that does, and OSError."""
    write_atomically(path, picture(plan, form, rate, moment))


def picture(plan: Plan, form: str, rate: float | None = None, moment: float | None = None) -> bytes:
    """The replay as `png`, a still at `moment` seconds (None: the end), or as a film, `gif` or `mp4`, of `rate`
    pictures a second. Raises UsageError, and MissingLibrary without the extra `pictures` or
    a Chromium."""
    draw = partial(_picture, plan, form, rate, moment)
    try:
        asyncio.get_running_loop()
    except RuntimeError:
        return draw()
    # The browser is driven by a loop of events of its own, and a thread has only one: a notebook's is taken.
    with ThreadPoolExecutor(1) as thread:
        return thread.submit(draw).result()


def _picture(plan: Plan, form: str, rate: float | None, moment: float | None) -> bytes:
    end = plan.times[-1] if plan.times else 0.0
    if form == "png":
        at = end if moment is None else moment
        if not 0.0 <= at <= end:
            raise UsageError(f"the plan lasts from 0 to {end:.2f} s, and {at:g} is not in it")
        return next(drawn(render_replay(plan), [at]))
    rate = RATE if rate is None else rate
    if not 0.0 < rate <= 60.0:
        raise UsageError(f"films have up to 60 pictures a second, not {rate:g}")
    count = int(end * rate) + 1
    if count > MOST:
        raise UsageError(f"the film would have {count} pictures, more than {MOST}; a lower --rate has fewer")
    moments = [k / rate for k in range(count)]
    pictures = drawn(render_replay(plan), moments if end - moments[-1] < 1e-6 else [*moments, end])
    return _gif(pictures, rate) if form == "gif" else _mp4(pictures, rate)


def drawn(replay: str, moments: list[float]) -> Iterator[bytes]:
    """The page of a replay at each of the moments, as PNG. Raises what `picture` does."""
    with TemporaryDirectory() as folder, _page() as page:
        file = Path(folder) / "replay.html"
        file.write_text(replay, encoding="utf-8")
        page.goto(file.as_uri())
        page.add_style_tag(content=STYLE)
        for _ in range(600):
            if page.evaluate("window.tamplang !== undefined"):
                break
            page.wait_for_timeout(100)
        if page.evaluate("document.querySelector('#pane canvas') === null"):
            raise UsageError("the browser draws no 3-D pictures")
        page.evaluate("window.dispatchEvent(new Event('resize'))")
        for moment in moments:
            page.evaluate("t => window.tamplang.seek(t)", moment)
            yield page.locator("#pane").screenshot()


@contextmanager
def _page() -> Iterator[Any]:
    sync_api = load_extra("playwright.sync_api", "pictures")
    named = os.environ.get("TAMPLANG_CHROMIUM")
    found = named or next((p for p in map(shutil.which, BROWSERS) if p), None)
    with sync_api.sync_playwright() as playwright:
        try:
            browser = playwright.chromium.launch(executable_path=found, args=ARGUMENTS)
        except sync_api.Error as error:
            hint = "install Chromium (Debian: apt-get install chromium), or set TAMPLANG_CHROMIUM to its path"
            raise MissingLibrary("Chromium", str(error).splitlines()[0], hint, "S0015") from error
        try:
            yield browser.new_page(viewport={"width": SIZE[0], "height": SIZE[1]}, color_scheme="light")
        finally:
            browser.close()


def _gif(pictures: Iterator[bytes], rate: float) -> bytes:
    """An animation that repeats and rests for a second at its end."""
    image = load_extra("PIL.Image", "pictures")
    frames = [image.open(io.BytesIO(p)).convert("RGB") for p in pictures]
    content = io.BytesIO()
    lengths = [round(1000.0 / rate)] * (len(frames) - 1) + [1000]
    frames[0].save(content, "GIF", save_all=True, append_images=frames[1:], duration=lengths, loop=0)
    return content.getvalue()


def _mp4(pictures: Iterator[bytes], rate: float) -> bytes:
    """A film in H.264, which every browser plays."""
    writer, image = load_extra("imageio_ffmpeg", "pictures"), load_extra("PIL.Image", "pictures")
    with TemporaryDirectory() as folder:
        file = Path(folder) / "film.mp4"
        frames = writer.write_frames(str(file), SIZE, fps=rate, macro_block_size=2)
        frames.send(None)
        for picture in pictures:
            frames.send(image.open(io.BytesIO(picture)).convert("RGB").resize(SIZE).tobytes())
        frames.close()
        return file.read_bytes()
