"""Pictures of the replay without a display: stills and films, drawn by `film_set.py`."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from ...langs.diagnostics import UsageError
from ...langs.writer import write_atomically
from ..native import load_extra
from ..plan import Plan
from .animations import animation

if TYPE_CHECKING:
    from .raster import Picture

FORMS = ("png", "gif", "mp4")
SIZE = (960, 540)
"""Pixels."""
RATE = 10.0
"""Pictures that a film shows in a second, unless told otherwise."""
SHORT = 80
"""Pictures of a film whose rate is not told: longer motions are shown faster, so that none takes more than eight
seconds, and three to draw."""
MOST = 3000
"""Pictures of a film; drawing one takes some hundredths of a second."""


def write_picture(plan: Plan, form: str, path: Path, rate: float | None = None, moment: float | None = None) -> None:
    """Write the `picture` of `plan` to `path`, atomically. Raises what that does, and OSError."""
    write_atomically(path, picture(plan, form, rate, moment))


def picture(plan: Plan, form: str, rate: float | None = None, moment: float | None = None) -> bytes:
    """The replay as `png`, a still at `moment` seconds (None: the end), or as a film, `gif` or `mp4`, of `rate`
    pictures for each second of motion. Raises UsageError, and MissingLibrary without the extra `pictures`."""
    end = plan.times[-1] if plan.times else 0.0
    if form == "png":
        at = end if moment is None else moment
        if not 0.0 <= at <= end:
            raise UsageError(f"the plan lasts from 0 to {end:.2f} s, and {at:g} is not in it")
        return _still(plan, at)
    moments, shown = _moments(end, rate)
    from .film_set import FilmSet

    stage = FilmSet(plan, SIZE)
    return animation(stage, moments, shown) if form == "gif" else _mp4(map(stage.picture, moments), shown)


def _moments(end: float, rate: float | None) -> tuple[Sequence[float], float]:
    """The moments of a film's pictures, the end among them, and how many are shown in a second."""
    if rate is not None and not 0.0 < rate <= 60.0:
        raise UsageError(f"films have up to 60 pictures a second, not {rate:g}")
    taken = min(RATE, (SHORT - 1) / max(end, 1e-9)) if rate is None else rate
    count = int(end * taken + 1e-9) + 1
    if count > MOST:
        raise UsageError(f"the film would have {count} pictures, more than {MOST}; a lower --rate has fewer")
    moments = [min(k / taken, end) for k in range(count)]
    return moments if end - moments[-1] < 1e-6 else [*moments, end], RATE if rate is None else rate


def _still(plan: Plan, moment: float) -> bytes:
    """A picture with smooth edges: drawn twice as large."""
    image = load_extra("PIL.Image", "pictures")
    from .film_set import FilmSet, reduced

    content = io.BytesIO()
    drawn = FilmSet(plan, (2 * SIZE[0], 2 * SIZE[1])).picture(moment)
    image.fromarray(reduced(drawn)).save(content, "PNG")
    return content.getvalue()


def _mp4(pictures: Iterator[Picture], rate: float) -> bytes:
    """A film in H.264, which every browser plays."""
    writer = load_extra("imageio_ffmpeg", "pictures")
    with TemporaryDirectory() as folder:
        file = Path(folder) / "film.mp4"
        quick = ["-preset", "superfast"]
        frames = writer.write_frames(str(file), SIZE, "bgr0", fps=rate, macro_block_size=2, output_params=quick)
        frames.send(None)
        for drawn in pictures:
            frames.send(drawn.astype("<u4", copy=False).tobytes())
        frames.close()
        return file.read_bytes()
