"""Pictures of the replay, drawn without a display, as Pillow reads them."""

from __future__ import annotations

import asyncio
import io
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import imageio_ffmpeg
import pytest
from click.testing import CliRunner
from PIL import Image, ImageChops

from tamplang.cli.app import application
from tamplang.runtime.plan_files import write_plan
from tamplang.runtime.report.pictures import picture

from .conftest import chromium_path
from .sample import climb_plan


def exported(folder: Path, *arguments: str) -> str:
    write_plan(climb_plan(1), folder / "a.plan.json")
    outcome = CliRunner().invoke(application, ["export", str(folder / "a.plan.json"), *arguments], obj=0.0)
    return f"{outcome.exit_code} {outcome.output}"


def test_a_film_shows_the_motion(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TAMPLANG_CHROMIUM", chromium_path())
    assert exported(tmp_path, "--to", "gif", "--rate", "0.7").startswith("0 ")
    with Image.open(tmp_path / "a.gif") as film:
        assert film.size == (960, 540) and film.n_frames == 4
        first = film.convert("RGB")
        film.seek(film.n_frames - 1)
        moved = ImageChops.difference(first, film.convert("RGB")).getbbox()
    assert moved is not None and moved[2] - moved[0] > 20
    assert len(first.getcolors(1_000_000) or []) > 50


def test_a_still_is_drawn_where_a_loop_of_events_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    """As in every cell of a notebook."""
    monkeypatch.setenv("TAMPLANG_CHROMIUM", chromium_path())

    async def cell() -> bytes:
        return picture(climb_plan(1), "png")

    with ThreadPoolExecutor(1) as thread:  # this one's loop may be taken by the browser of other tests
        drawn = thread.submit(lambda: asyncio.run(cell())).result()
    with Image.open(io.BytesIO(drawn)) as still:
        assert still.size == (960, 540)


def test_ffmpeg_counts_the_pictures_of_a_video(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TAMPLANG_CHROMIUM", chromium_path())
    assert exported(tmp_path, "--to", "mp4", "--rate", "1").startswith("0 ")
    assert imageio_ffmpeg.count_frames_and_secs(str(tmp_path / "a.mp4")) == (4, 4.0)


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (("--to", "png", "--at", "99"), "is not in it"),
        (("--to", "png", "--at", "nan"), "is not in it"),
        (("--to", "gif", "--rate", "0"), "pictures a second"),
        (("--to", "gif", "--rate", "61"), "pictures a second"),
    ],
)
def test_what_cannot_be_drawn_is_told(tmp_path: Path, arguments: tuple[str, ...], word: str) -> None:
    told = exported(tmp_path, *arguments)
    assert word in told and not told.startswith(("0 ", "70 ")) and len(list(tmp_path.iterdir())) == 1


def test_a_missing_browser_is_told_with_its_code(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TAMPLANG_CHROMIUM", str(tmp_path / "none"))
    told = exported(tmp_path, "--to", "png")
    assert "S0015" in told and "Chromium" in told and "Traceback" not in told
