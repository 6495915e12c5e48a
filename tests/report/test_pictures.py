"""Pictures of the replay, drawn without a display, as Pillow reads them."""

from __future__ import annotations

import io
from pathlib import Path

import imageio_ffmpeg
import msgspec
import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image, ImageChops

from tamplang.cli.app import application
from tamplang.compiler.ir import ShapeKind
from tamplang.runtime.plan import BodyRecord, ShapeRecord
from tamplang.runtime.plan_files import write_plan
from tamplang.runtime.report.film_set import FilmSet
from tamplang.runtime.report.pictures import SIZE, picture
from tamplang.runtime.report.raster import channels

from .sample import climb_plan


def exported(folder: Path, *arguments: str) -> str:
    write_plan(climb_plan(1), folder / "a.plan.json")
    outcome = CliRunner().invoke(application, ["export", str(folder / "a.plan.json"), *arguments], obj=0.0)
    return f"{outcome.exit_code} {outcome.output}"


def test_a_film_shows_the_motion(tmp_path: Path) -> None:
    assert exported(tmp_path, "--to", "gif", "--rate", "0.7").startswith("0 ")
    with Image.open(tmp_path / "a.gif") as film:
        assert film.size == (960, 540) and film.n_frames == 4
        first = film.convert("RGB")
        film.seek(film.n_frames - 1)
        moved = ImageChops.difference(first, film.convert("RGB")).getbbox()
    assert moved is not None and moved[2] - moved[0] > 20
    assert len(first.getcolors(1_000_000) or []) > 50


def test_things_are_drawn_where_they_are_and_hide_what_lies_behind(tmp_path: Path) -> None:
    plan = climb_plan(1)
    stage = FilmSet(plan, SIZE)
    ball = next(b for b in plan.bodies if b.movable)
    hues = channels(stage.picture(0.0)).astype(int)
    yellow = (hues[:, :, 0] - hues[:, :, 2] > 60) & (hues[:, :, 1] - hues[:, :, 2] > 40)
    middle = stage.camera.drawn(stage.camera.seen(np.array(ball.pose[:3])))[:2]
    assert np.argwhere(yellow).mean(axis=0)[::-1] + 0.5 == pytest.approx(middle, abs=1.0)
    away = stage.camera.back * 0.3
    place = [*(ball.pose[:3] + away).tolist(), 0.0, 0.0, 0.0, 1.0]
    wall = BodyRecord("wall", "base", ShapeRecord(ShapeKind.BOX, [0.2, 0.2, 0.2]), place, False)
    covered = FilmSet(msgspec.structs.replace(plan, bodies=[*plan.bodies, wall]), SIZE)
    again = channels(covered.picture(0.0)).astype(int)
    assert not ((again[:, :, 0] - again[:, :, 2] > 60) & (again[:, :, 1] - again[:, :, 2] > 40)).any()
    assert covered.camera.eye == pytest.approx(stage.camera.eye)


def test_a_still_has_the_size_and_the_moment_that_was_asked_for() -> None:
    first, last = (picture(climb_plan(1), "png", moment=moment) for moment in (0.0, None))
    with Image.open(io.BytesIO(first)) as one, Image.open(io.BytesIO(last)) as other:
        assert one.size == other.size == (960, 540)
        assert ImageChops.difference(one, other).getbbox() is not None


def test_ffmpeg_counts_the_pictures_of_a_video(tmp_path: Path) -> None:
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


def test_films_of_long_motions_are_short(tmp_path: Path) -> None:
    plan = climb_plan(1)
    slow = msgspec.structs.replace(plan, times=[100.0 * t for t in plan.times])
    content = picture(slow, "gif")
    with Image.open(io.BytesIO(content)) as film:
        assert film.n_frames == 80 and film.info["duration"] == 100
