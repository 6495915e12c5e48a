"""A real browser for the report's tests: Chromium, offline, with WebGL in software."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Literal

import pytest
from playwright.sync_api import Browser, Page, sync_playwright

ARGUMENTS = [
    "--no-sandbox",
    "--disable-gpu",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-background-networking",
    "--no-first-run",
    "--disable-component-update",
    "--disable-sync",
]


def chromium_path() -> str:
    """The browser to test with; fails with the way to get one."""
    found = os.environ.get("TAMPLANG_CHROMIUM")
    for name in ("chromium", "chromium-browser", "google-chrome"):
        found = found or shutil.which(name)
    if not found or not Path(found).exists():
        pytest.fail(
            f"the report's tests need a Chromium browser (looked for {found or 'chromium on the PATH'}): "
            "install one (Debian: `apt-get install chromium`) or set TAMPLANG_CHROMIUM to its path"
        )
    return found


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    path = chromium_path()
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=ARGUMENTS)
        yield browser
        browser.close()


class Opened:
    """A page with everything that went wrong on it, and every address that it asked for."""

    def __init__(self, page: Page, address: str) -> None:
        self.page = page
        self.errors: list[str] = []
        self.requests: list[str] = []
        page.on("pageerror", lambda error: self.errors.append(str(error)))
        page.on("console", lambda m: self.errors.append(m.text) if m.type == "error" else None)
        page.on("request", lambda request: self.requests.append(request.url))
        page.goto(address)
        self.wait("window.tamplang !== undefined")

    def wait(self, condition: str) -> None:
        """Wait until a JavaScript expression holds; playwright's own way needs `eval`, which the page forbids."""
        for _ in range(200):
            if self.page.evaluate(condition):
                return
            self.page.wait_for_timeout(50)
        raise AssertionError(f"never held: {condition}")

    def seek(self, time: float) -> None:
        self.page.evaluate("t => window.tamplang.seek(t)", time)

    def pose(self, name: str) -> list[float]:
        return self.page.evaluate("n => window.tamplang.pose(n)", name)

    def time(self) -> float:
        return self.page.evaluate("window.tamplang.time()")


Opener = Callable[..., Opened]


@pytest.fixture(scope="module")
def open_report(browser: Browser) -> Iterator[Opener]:
    """Opens a report file as a reader does, from `file://`, in a new page."""
    pages: list[Page] = []

    def open_it(path: Path, scheme: Literal["dark", "light"] = "light") -> Opened:
        page = browser.new_page(viewport={"width": 1280, "height": 900}, color_scheme=scheme)
        pages.append(page)
        return Opened(page, path.as_uri())

    yield open_it
    for page in pages:
        page.close()
