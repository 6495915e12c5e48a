"""Triangles as pictures, without a display: a buffer of depths in NumPy, row by row of each triangle, all at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import Array

Picture = NDArray[np.uint32]
"""Rows of pixels (H, W), each 0xRRGGBB."""

NUMBERS = 22
"""Bits of a key that number the triangle; those above are its depth, so that one comparison finds the nearest."""
STEPS = float(1 << 40)
"""Steps in which depths are told apart: from 1 m on 1e-6 m to the camera's nearest metre."""
AT_ONCE = 256
"""Triangles of a scene at rest that are drawn at once."""
NEAR = 0.02
"""Of the distance to what is looked at: what is nearer to the camera is cut off."""


@dataclass(frozen=True, slots=True)
class Camera:
    """A camera at `eye` whose picture has `across` and `up` as its axes and looks against `back`; a point at depth 1
    before it, one to the side, is drawn `scale` pixels from the middle. `size`: width and height in pixels."""

    eye: Array
    across: Array
    up: Array
    back: Array
    scale: float
    near: float
    size: tuple[int, int]

    def seen(self, points: Array) -> Array:
        """Points (…, 3) of the world in the frame of the camera: to the right, up, and depth before it."""
        axes = np.stack([self.across, self.up, -self.back], axis=1)
        return np.asarray((points.reshape(-1, 3) @ axes - self.eye @ axes).reshape(points.shape))

    def drawn(self, seen: Array) -> Array:
        """Where what `seen` gives lies in the picture: pixels to the right, pixels down, and 1 over the depth."""
        found = np.empty_like(seen)
        found[..., 2] = 1.0 / seen[..., 2]
        found[..., 0] = self.size[0] / 2 + self.scale * seen[..., 0] * found[..., 2]
        found[..., 1] = self.size[1] / 2 - self.scale * seen[..., 1] * found[..., 2]
        return found


@dataclass(frozen=True, slots=True)
class Triangles:
    """Corners (N, 3, 3) in the world that turn to the left seen from outside, how bright each is (N, 3), and colours
    (N, 3), 0 to 255."""

    corners: Array
    shades: Array
    colours: Array


@dataclass(frozen=True, slots=True)
class Fragments:
    """Pixels that triangles cover: `at` in the picture, counted row by row, the `keys` of their depths, which triangle
    covers each, and how bright they are there."""

    at: NDArray[np.int64]
    keys: NDArray[np.int64]
    which: NDArray[np.int64]
    shades: Array


def visible(triangles: Triangles, camera: Camera) -> Triangles:
    """The triangles that look at the camera and may lie in its picture, with their corners as `Camera.drawn` has
    them."""
    seen, shades, colours = camera.seen(triangles.corners), triangles.shades, triangles.colours
    before = (seen[:, :, 2] > camera.near).all(axis=1)
    if not before.all():
        cut = ~before & (seen[:, :, 2] > camera.near).any(axis=1)
        kept = _cut(Triangles(seen[cut], shades[cut], colours[cut]), camera.near)
        seen = np.concatenate([seen[before], kept.corners])
        shades, colours = np.concatenate([shades[before], kept.shades]), np.concatenate([colours[before], kept.colours])
    corners = camera.drawn(seen)
    x, y = corners[:, :, 0], corners[:, :, 1]
    # Down the picture counts as up, so that what turns left turns right.
    facing = (x[:, 1] - x[:, 0]) * (y[:, 2] - y[:, 0]) - (x[:, 2] - x[:, 0]) * (y[:, 1] - y[:, 0]) < -1e-9
    width, height = camera.size
    inside = facing & (x.max(axis=1) > 0) & (x.min(axis=1) < width) & (y.max(axis=1) > 0) & (y.min(axis=1) < height)
    return Triangles(corners[inside], shades[inside], colours[inside])


def fragments(drawn: Triangles, camera: Camera, first: int) -> Fragments:
    """The pixels that `visible` triangles cover; they are numbered from `first` on."""
    corners = drawn.corners
    (ax, ay), (bx, by), (cx, cy) = (corners[:, k, :2].T for k in range(3))
    area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
    rows, which = _rows(corners, camera.size[1])
    left, right = _ends(corners[which], rows, camera.size[0])
    counts = np.maximum(right - left + 1, 0)
    planes = _planes(np.concatenate([corners[:, :, 2:], drawn.shades[:, :, None]], axis=2), corners, area)
    passed = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    deep, shades = (  # of each row: at its first pixel, and by how much it grows
        np.repeat(begins, counts) + np.repeat(grows[:, 0], counts) * passed
        for grows in (planes[which, 0] * (camera.near * STEPS), planes[which, 1])
        for begins in [grows[:, 0] * (left + 0.5) + grows[:, 1] * (rows + 0.5) + grows[:, 2]]
    )
    owner = np.repeat(which, counts)
    keys = (np.clip(deep, 0.0, STEPS).astype(np.int64) << NUMBERS) + (owner + first)
    return Fragments(np.repeat(rows * camera.size[0] + left, counts) + passed, keys, owner, shades)


def _rows(corners: Array, height: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The rows whose middles triangles may cross, and the triangle of each."""
    low = np.clip(np.ceil(corners[:, :, 1].min(axis=1) - 0.5), 0, height).astype(np.int64)
    high = np.clip(np.floor(corners[:, :, 1].max(axis=1) - 0.5), -1, height - 1).astype(np.int64)
    counts = np.maximum(high - low + 1, 0)
    which = np.repeat(np.arange(len(corners)), counts)
    rows = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts) + np.repeat(low, counts)
    return rows, which


def _ends(corners: Array, rows: NDArray[np.int64], width: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The first and last column of each row of a triangle whose middles lie inside."""
    left, right = np.full(len(rows), -np.inf), np.full(len(rows), np.inf)
    y = rows + 0.5
    for k in range(3):
        x0, y0 = corners[:, k, 0], corners[:, k, 1]
        x1, y1 = corners[:, (k + 1) % 3, 0], corners[:, (k + 1) % 3, 1]
        rise = y1 - y0
        with np.errstate(divide="ignore", invalid="ignore"):
            crossing = x0 + (x1 - x0) * ((y - y0) / rise)
        left = np.where(rise > 0, np.maximum(left, crossing), left)
        right = np.where(rise < 0, np.minimum(right, crossing), right)
    first = np.clip(np.ceil(left - 0.5), 0, width)
    last = np.clip(np.ceil(right - 0.5) - 1, -1, width - 1)
    return first.astype(np.int64), last.astype(np.int64)


def _planes(values: Array, corners: Array, area: Array) -> Array:
    """Values (N, 3, V) at the corners as planes over the picture (N, V, 3): per pixel to the right, down, and at 0."""
    (ax, ay), (bx, by), (cx, cy) = (corners[:, k, :2].T for k in range(3))
    one, other = values[:, 1] - values[:, 0], values[:, 2] - values[:, 0]
    across = (one * (cy - ay)[:, None] - other * (by - ay)[:, None]) / area[:, None]
    down = (other * (bx - ax)[:, None] - one * (cx - ax)[:, None]) / area[:, None]
    return np.stack([across, down, values[:, 0] - across * ax[:, None] - down * ay[:, None]], axis=-1)


def _cut(triangles: Triangles, near: float) -> Triangles:
    """What lies behind depth `near` of triangles that reach through it, in the frame of the camera."""
    corners, shades, colours = [np.zeros((3, 3))][:0], [np.zeros(3)][:0], [np.zeros(3)][:0]
    for at, shade, colour in zip(triangles.corners, triangles.shades, triangles.colours, strict=True):
        made: list[tuple[Array, float]] = []
        for k in range(3):
            (p, s), (q, t) = (at[k], shade[k]), (at[(k + 1) % 3], shade[(k + 1) % 3])
            if p[2] > near:
                made.append((p, s))
            if (p[2] > near) != (q[2] > near):
                share = (1.001 * near - p[2]) / (q[2] - p[2])
                made.append((p + share * (q - p), s + share * (t - s)))
        for k in range(1, len(made) - 1):
            corners.append(np.stack([made[i][0] for i in (0, k, k + 1)]))
            shades.append(np.array([made[i][1] for i in (0, k, k + 1)]))
            colours.append(colour)
    return Triangles(
        np.reshape(corners, (-1, 3, 3)), np.reshape(shades, (-1, 3)), np.reshape(colours, (-1, 3))
    )


class Sheet:
    """A picture with the depths of what lies on it. What is `drawn` on it stays; what is `shown` above it comes off
    with the next that is shown."""

    def __init__(self, ground: Picture) -> None:
        self.picture = ground.copy()
        self.pixels = self.picture.reshape(-1)
        self._keys = np.zeros(len(self.pixels), dtype=np.int64)
        self._count = 1
        self._over: tuple[NDArray[np.int64], NDArray[np.int64], Picture] | None = None

    def draw(self, triangles: Triangles, camera: Camera) -> None:
        """Draw what stays, some triangles at a time, as each may cover the picture."""
        drawn = visible(triangles, camera)
        for start in range(0, len(drawn.corners), AT_ONCE):
            part = slice(start, start + AT_ONCE)
            some = Triangles(drawn.corners[part], drawn.shades[part], drawn.colours[part])
            self._lay(fragments(some, camera, self._count), some.colours)
            self._count += AT_ONCE

    def show(self, triangles: Triangles, camera: Camera) -> None:
        """Draw what is above until the next call."""
        if self._over is not None:
            at, keys, colours = self._over
            self._keys[at], self.pixels[at] = keys, colours
        drawn = visible(triangles, camera)
        made = fragments(drawn, camera, self._count)
        self._over = made.at, self._keys[made.at], self.pixels[made.at]
        self._lay(made, drawn.colours)

    def hidden(self, at: NDArray[np.int64], depth: Array, camera: Camera) -> NDArray[np.bool_]:
        """Whether something lies before points of a depth at these pixels."""
        keys = (np.clip(camera.near / depth, 0.0, 1.0) * STEPS).astype(np.int64) << NUMBERS
        return np.asarray(self._keys[at] > keys)

    def _lay(self, made: Fragments, colours: Array) -> None:
        np.maximum.at(self._keys, made.at, made.keys)
        nearest = np.flatnonzero(self._keys[made.at] == made.keys)
        shades = np.clip(made.shades[nearest], 0.0, 1.3)
        self.pixels[made.at[nearest]] = mixed(colours[made.which[nearest]] * shades[:, None])


def mixed(colours: Array) -> Picture:
    """Pixels of red, green and blue (P, 3), 0 to 255 and cut off there."""
    parts = np.minimum(colours, 255.0).astype(np.uint32)
    red, green, blue = parts.T
    return np.asarray((red << 16) | (green << 8) | blue, dtype=np.uint32)


def channels(picture: Picture) -> NDArray[np.uint8]:
    """Red, green and blue of each pixel (…, 3)."""
    return np.stack([(picture >> shift).astype(np.uint8) for shift in (16, 8, 0)], axis=-1)
