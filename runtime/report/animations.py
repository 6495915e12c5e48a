"""Films as GIF: one palette for all pictures, and of each only what differs from the one before."""

from __future__ import annotations

import io
import struct
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..native import load_extra
from .raster import channels

if TYPE_CHECKING:
    from .film_set import FilmSet
    from .raster import Picture

SAMPLES = 5
"""Pictures of which the palette is made."""
BITS = 6
"""Of each channel, by which the nearest colour of the palette is looked up."""
REST = 100
"""Hundredths of a second that an animation rests at its end, before it begins anew."""
LOOP = b"!\xff\x0bNETSCAPE2.0\x03\x01\0\0\0"

Indices = NDArray[np.uint8]


def animation(stage: FilmSet, moments: Sequence[float], rate: float) -> bytes:
    """The pictures of a stage at these moments, so many a second. Raises MissingLibrary without the extra
    `pictures`."""
    image = load_extra("PIL.Image", "pictures")
    picks = [moments[(len(moments) - 1) * k // (SAMPLES - 1)] for k in range(SAMPLES)]
    palette = _palette(image, stage.background, [stage.picture(moment).copy() for moment in picks])
    near = _nearest(image, palette)
    height, width = stage.background.shape[:2]
    content = [b"GIF89a", struct.pack("<HHBBB", width, height, 0xF7, 0, 0), palette, LOOP]
    delay = max(2, round(100.0 / rate))
    seen, shown = np.zeros_like(stage.background), np.zeros((height, width), np.uint8)
    for number, moment in enumerate(moments):
        drawn, now = stage.picture(moment), shown.copy()
        differs = np.flatnonzero(drawn != seen) if number else slice(None)
        now.reshape(-1)[differs] = near[_looked_up(drawn.reshape(-1)[differs])]
        (top, left), part = _changed(shown, now) if number else ((0, 0), now)
        rests = REST if number == len(moments) - 1 else delay
        content += [struct.pack("<BBBBHBB", 0x21, 0xF9, 4, 4, rests, 0, 0), _block(image, palette, part, top, left)]
        seen, shown = drawn.copy(), now
    return b"".join([*content, b";"])


def _palette(image: Any, background: Picture, samples: Sequence[Picture]) -> bytes:
    """256 colours: those of the background, which change little from row to row, and those that are best for all else
    in the samples."""
    own = channels(np.unique(background[:, 0])[:128])
    rest = channels(np.concatenate([sample[sample != background] for sample in samples]))
    found = np.zeros((0, 3), dtype=np.uint8)
    if len(rest):
        made = image.fromarray(rest[None]).quantize(256 - len(own), dither=image.Dither.NONE)
        found = np.array(made.getpalette(), dtype=np.uint8).reshape(-1, 3)[: 256 - len(own)]
    colours = np.zeros((256, 3), dtype=np.uint8)
    colours[: len(own)], colours[len(own) : len(own) + len(found)] = own, found
    return colours.tobytes()


def _nearest(image: Any, palette: bytes) -> Indices:
    """The number of the nearest colour of the palette for each that `_looked_up` tells apart."""
    steps = ((np.arange(1 << BITS) + 0.5) * (256 >> BITS)).astype(np.uint8)
    cube = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1).reshape(1 << BITS, -1, 3)
    known = image.new("P", (1, 1))
    known.putpalette(palette)
    return np.asarray(image.fromarray(cube).quantize(palette=known, dither=image.Dither.NONE)).ravel()


def _looked_up(pixels: Picture) -> NDArray[np.uint32]:
    red, green, blue = ((pixels >> (shift + 8 - BITS)) & ((1 << BITS) - 1) for shift in (16, 8, 0))
    return np.asarray((red << 2 * BITS) | (green << BITS) | blue, dtype=np.uint32)


def _changed(before: Indices, now: Indices) -> tuple[tuple[int, int], Indices]:
    """The first row and column of what differs, and that; one pixel where nothing does."""
    differs = before != now
    rows, columns = np.flatnonzero(differs.any(axis=1)), np.flatnonzero(differs.any(axis=0))
    if not len(rows):
        return (0, 0), now[:1, :1]
    return (int(rows[0]), int(columns[0])), now[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]


def _block(image: Any, palette: bytes, part: Indices, top: int, left: int) -> bytes:
    """A part of a picture as a GIF has it: Pillow compresses it as a file of its own, whose head is left away."""
    made = image.fromarray(np.ascontiguousarray(part))
    made.putpalette(palette)
    stream = io.BytesIO()
    made.save(stream, "GIF", optimize=False, interlace=False)
    content = stream.getvalue()
    at = 13 + (3 << ((content[10] & 7) + 1) if content[10] & 0x80 else 0)
    while content[at] == 0x21:
        at += 2
        while content[at]:
            at += content[at] + 1
        at += 1
    return struct.pack("<BHHHHB", 0x2C, left, top, part.shape[1], part.shape[0], 0) + content[at + 10 : -1]
