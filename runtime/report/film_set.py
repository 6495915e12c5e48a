"""The scene of a plan as triangles, at any moment, and the camera before it: what the page's viewer draws."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import Array
from ..plan import Plan
from .forms import DrawnForm, matrix
from .raster import NEAR, Camera, Picture, Sheet, Triangles, channels, mixed
from .replay import Builder, camera_view, phase_colours
from .robots import PALETTE, lighten

ROUND, RINGS = 20, 10
"""Corners around what is round, and from pole to pole of balls."""
FIELD = np.tan(np.deg2rad(17.0))
"""Half the height of the picture at depth 1, and the share of that in which all that matters lies."""
INSIDE = 0.92
TOP, BOTTOM = (237.0, 242.0, 247.0), (204.0, 212.0, 222.0)
"""Colours of the background."""
SUN = np.array([-0.35, -0.6, 2.0]) / np.linalg.norm([-0.35, -0.6, 2.0])
AMBIENT, SUNLIGHT, FILL = 0.52, 0.48, 0.16
"""Shares of the light: from everywhere, from the sun, from the camera."""
FAR_AWAY = 6.0
"""Metres around the whole beyond which modules in it are too small to see, as in the page."""
HERE = np.eye(4)
PALE = 0.25
"""How strongly the ways of effectors show."""


Tint = tuple[str, tuple[int, float] | None]
"""A colour, or the module whose colour something has, with a share of white."""


@dataclass(frozen=True, slots=True)
class DrawnPart:
    """What moves with a frame, in it: corners (N, 3, 3), the normals of the surface there (N, 3, 3), the planes of the
    triangles, as outward normals (N, 3) and offsets (N,), and the numbers of their tints (N,)."""

    frame: int
    corners: Array
    normals: Array
    faces: Array
    offsets: Array
    tints: NDArray[np.int64]


class _Mould:
    """A canvas that keeps what is drawn on it."""

    def __init__(self) -> None:
        self.forms: list[tuple[str, DrawnForm, str]] = []
        self.places: dict[str, Array] = {}

    def draw(self, path: str, form: DrawnForm, colour: str) -> None:
        self.forms.append((path, form, colour))

    def place(self, path: str, pose: Array) -> None:
        self.places[path] = matrix(pose)

    def carried(self, path: str, numbers: dict[str, int]) -> tuple[int, Array]:
        """The number of the frame that moves what is at a path, which is the last one on the way to it that is known,
        -1 where nothing does, and the place in that (4, 4)."""
        names, frame, place = path.split("/"), -1, HERE
        for count in range(1, len(names) + 1):
            above = "/".join(names[:count])
            if above in numbers:
                frame, place = numbers[above], HERE
            else:
                place = place @ self.places.get(above, HERE)
        return frame, place


class FilmSet:
    """A plan before a camera whose pictures have a size in pixels. Where what matters lies too far apart, the camera
    goes along with the modules, as the page's does."""

    def __init__(self, plan: Plan, size: tuple[int, int]) -> None:
        mould = _Mould()
        builder = Builder(plan, mould)
        builder.add_bodies()
        builder.add_modules()
        scene = builder.scene
        self.times = scene.times
        self._tracks = np.stack([p for _, p in scene.frames]) if scene.frames else np.zeros((0, len(self.times), 7))
        self._starts, self._colours = [p.start for p in plan.phases], phase_colours(plan)
        view = camera_view(scene)
        self.camera, self._far = _camera(view, size)
        numbers = {path: number for number, (path, _) in enumerate(scene.frames)}
        self._led = [number for path, number in numbers.items() if path.startswith("module")]
        self._ground: Sheet | None = None
        share = np.linspace(0.0, 1.0, size[1])[:, None]
        rows = mixed(np.array(TOP) * (1.0 - share) + np.array(BOTTOM) * share)
        self.background = np.repeat(rows[:, None], size[0], axis=1)
        self._follows = bool(self._led) and _radius(view) > FAR_AWAY
        if self._follows:
            places = self._tracks[self._led, 0, :3]
            spread = np.linalg.norm(places - places.mean(axis=0), axis=1).max()
            self._far = min(self._far, 1.5 + 3.2 * spread)
        paint = {path: (module, share) for path, module, share in scene.paint}
        self._tints: list[Tint] = [(colour, paint.get(path)) for path, _, colour in mould.forms]
        carriers = [mould.carried(path, numbers) for path, _, _ in mould.forms]
        still, moving = list[int](), dict[int, list[int]]()
        for number, ((_, painted), (frame, _)) in enumerate(zip(self._tints, carriers, strict=True)):
            (still if painted is None and frame < 0 else moving.setdefault(frame, [])).append(number)
        surfaces = [(*_surface(form), place) for (_, form, _), (_, place) in zip(mould.forms, carriers, strict=True)]
        self._still = _piece(-1, still, surfaces)
        self._moving = [_piece(frame, members, surfaces) for frame, members in moving.items()]
        self._ways = self._traces(mould, scene.names, numbers)

    def picture(self, moment: float) -> Picture:
        """What the camera sees at a moment. It counts until the next one is asked for."""
        poses = self._poses(moment)
        camera = self.camera
        if self._follows:
            eye = poses[self._led, :3].mean(axis=0) + self._far * camera.back
            camera = replace(camera, eye=eye, near=NEAR * self._far)
        if self._ground is None or self._follows:
            self._ground = self._drawn(camera)
        colours = self._colours[max(0, bisect_right(self._starts, moment) - 1)] if self._starts else self._colours[-1]
        places = [HERE if p.frame < 0 else matrix(poses[p.frame]) for p in self._moving]
        self._ground.show(self._lit(self._moving, places, colours, camera.eye), camera)
        return self._ground.picture

    def _drawn(self, camera: Camera) -> Sheet:
        """A sheet with the background, what never moves, and the ways of effectors."""
        sheet = Sheet(self.background)
        sheet.draw(self._lit([self._still], [HERE], [], camera.eye), camera)
        for points, colour in self._ways:
            _draw_way(sheet, points, colour, camera)
        return sheet

    def _poses(self, moment: float) -> Array:
        """The poses of all frames (F, 7) at a moment."""
        low = min(max(int(np.searchsorted(self.times, moment, side="right")) - 1, 0), len(self.times) - 1)
        after = min(low + 1, len(self.times) - 1)
        span = self.times[after] - self.times[low]
        share = min(1.0, max(0.0, (moment - self.times[low]) / span)) if span > 0 else 0.0
        one, other = self._tracks[:, low], self._tracks[:, after]
        turned = np.where((one[:, 3:] * other[:, 3:]).sum(axis=1, keepdims=True) < 0, -1.0, 1.0)
        poses = one * (1.0 - share) + np.concatenate([other[:, :3], turned * other[:, 3:]], axis=1) * share
        poses[:, 3:] /= np.maximum(np.linalg.norm(poses[:, 3:], axis=1, keepdims=True), 1e-12)
        return np.asarray(poses)

    def _lit(
        self, pieces: Sequence[DrawnPart], places: Sequence[Array], colours: Sequence[str], eye: Array
    ) -> Triangles:  # fmt: skip
        """The pieces at their places, in the `colours` of the modules, as far as they look at the `eye`."""
        table = np.array([
            _hue(colour if painted is None or not colours else lighten(colours[painted[0]], painted[1]))
            for colour, painted in self._tints
        ]).reshape(-1, 3)  # fmt: skip
        corners, shades, hues = [np.zeros((0, 3, 3))], [np.zeros((0, 3))], [np.zeros((0, 3))]
        for piece, place in zip(pieces, places, strict=True):
            turn = place[:3, :3]
            seen = np.flatnonzero(piece.faces @ ((eye - place[:3, 3]) @ turn) > piece.offsets)
            corners.append((piece.corners[seen].reshape(-1, 3) @ turn.T + place[:3, 3]).reshape(-1, 3, 3))
            lights = piece.normals[seen].reshape(-1, 3) @ np.stack([SUN @ turn, self.camera.back @ turn], axis=1)
            shades.append((AMBIENT + np.maximum(lights, 0.0) @ (SUNLIGHT, FILL)).reshape(-1, 3))
            hues.append(table[piece.tints[seen]])
        return Triangles(np.concatenate(corners), np.concatenate(shades), np.concatenate(hues))

    def _traces(
        self, mould: _Mould, names: dict[str, str], numbers: dict[str, int]
    ) -> list[tuple[Array, str]]:  # fmt: skip
        """The way of every effector that moves (T, 3), and its colour."""
        found = []
        for path in names.values():
            frame, _, effector = path.rpartition("/")
            if not effector.startswith("effector") or frame not in numbers:
                continue
            turns = np.stack([matrix(pose) for pose in self._tracks[numbers[frame]]])
            module = int(path[len("module") : path.index("/")])
            found.append((turns[:, :3] @ mould.places[path][:, 3], PALETTE[module % len(PALETTE)]))
        return found


def _draw_way(sheet: Sheet, points: Array, colour: str, camera: Camera) -> None:
    """A pale line, where nothing hides it."""
    width, height = camera.size
    seen = camera.seen(points)
    drawn = camera.drawn(seen[seen[:, 2] > camera.near])
    outside = (drawn[:, :2] < 0) | (drawn[:, :2] > (width, height))
    if len(drawn) < 2 or outside.all():
        return
    beside = (outside[:-1] & outside[1:]).any(axis=1)
    ends = drawn[:-1][~beside], drawn[1:][~beside]
    steps = np.minimum(np.ceil(np.abs(ends[1] - ends[0])[:, :2].max(axis=1)), 4 * width).astype(np.int64) + 1
    start = np.repeat(np.arange(len(steps)), steps)
    share = (np.arange(steps.sum()) - np.repeat(np.cumsum(steps) - steps, steps)) / np.repeat(steps, steps)
    line = ends[0][start] + (ends[1] - ends[0])[start] * share[:, None]
    line = line[(line[:, :2] >= 0).all(axis=1) & (line[:, 0] < width) & (line[:, 1] < height)]
    at, first = np.unique(line[:, 1].astype(np.int64) * width + line[:, 0].astype(np.int64), return_index=True)
    free = at[~sheet.hidden(at, 0.999 / line[first, 2], camera)]
    sheet.pixels[free] = mixed(channels(sheet.pixels[free]) * (1.0 - PALE) + _hue(colour) * PALE)


def _hue(colour: str) -> Array:
    return np.array([int(colour[k : k + 2], 16) for k in (1, 3, 5)], dtype=float)


def _piece(frame: int, members: Sequence[int], surfaces: Sequence[tuple[Array, Array, Array]]) -> DrawnPart:
    """What the surfaces of these numbers, each with its place in a frame, are together."""
    corners, normals, tints = [np.zeros((0, 3))], [np.zeros((0, 3))], [np.zeros(0, dtype=np.int64)]
    for number in members:
        at, across, place = surfaces[number]
        corners.append(at.reshape(-1, 3) @ place[:3, :3].T + place[:3, 3])
        normals.append(across.reshape(-1, 3) @ place[:3, :3].T)
        tints.append(np.full(len(at), number))
    all_corners = np.concatenate(corners).reshape(-1, 3, 3)
    faces = np.ascontiguousarray(_flat(all_corners)[1][:, 0])
    offsets = (faces * all_corners[:, 0]).sum(axis=1)
    outward = np.concatenate(normals).reshape(-1, 3, 3)
    return DrawnPart(frame, all_corners, outward, faces, offsets, np.concatenate(tints))


def _surface(form: DrawnForm) -> tuple[Array, Array]:
    """The triangles of a form, and the normals at their corners."""
    if form.kind == "hull":
        assert form.corners is not None and form.triangles is not None
        return _flat(form.corners[form.triangles])
    if form.kind == "box":
        half = np.array(form.size) / 2
        signs = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
        faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
        return _flat((signs * half)[[(q[0], q[i], q[i + 1]) for q in faces for i in (1, 2)]])
    turn = np.linspace(0.0, 2 * np.pi, ROUND, endpoint=False)
    if form.kind == "ball":
        rise = np.linspace(0.0, np.pi, RINGS + 1)
        normals = np.stack([
            np.outer(np.sin(rise), np.cos(turn)), np.outer(np.sin(rise), np.sin(turn)),
            np.repeat(np.cos(rise)[:, None], ROUND, axis=1),
        ], axis=-1)  # fmt: skip
        around = _quads(normals)
        return around * form.size[0], around
    length, radius = form.size
    side = np.stack([np.sin(turn), np.zeros(ROUND), np.cos(turn)], axis=-1)
    rings = np.stack([side * radius + [0.0, y, 0.0] for y in (length / 2, -length / 2)])
    tube, outward = _quads(rings), _quads(np.stack([side, side]))
    ends = [(rings[0], rings[0], np.roll(rings[0], -1, axis=0)), (rings[1], np.roll(rings[1], -1, axis=0), rings[1])]
    caps = [np.stack([np.repeat(r.mean(axis=0)[None], ROUND, axis=0), one, other], axis=1) for r, one, other in ends]
    flat, along = _flat(np.concatenate(caps))
    return np.concatenate([tube, flat]), np.concatenate([outward, along])


def _quads(rings: Array) -> Array:
    """The triangles between rings of points (R, K, 3) that turn to the left."""
    a, b = rings[:-1], rings[1:]
    c, d = np.roll(a, -1, axis=1), np.roll(b, -1, axis=1)
    return np.concatenate([np.stack([a, b, d], axis=2), np.stack([a, d, c], axis=2)]).reshape(-1, 3, 3)


def _flat(corners: Array) -> tuple[Array, Array]:
    """Triangles with the normal of the whole at each corner."""
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    return corners, np.repeat(normal[:, None], 3, axis=1)


def _radius(view: dict[str, Any]) -> float:
    """Metres around everything that the camera must see."""
    places, radii = np.split(np.array(view["balls"]), [3], axis=1)
    return float(np.linalg.norm((places + radii).max(axis=0) - (places - radii).min(axis=0))) / 2


def _camera(view: dict[str, Any], size: tuple[int, int]) -> tuple[Camera, float]:
    """The nearest camera, from the given direction, that has every ball inside the picture, as the page's; and how far
    before it the middle of what it sees lies, metres."""
    balls, back = np.array(view["balls"]), np.array(view["direction"])
    back = back / np.linalg.norm(back)
    across = np.cross([0.0, 0.0, 1.0], back)
    across /= np.linalg.norm(across)
    up = np.cross(back, across)
    slopes = np.array([size[0] / size[1], 1.0]) * FIELD * INSIDE
    depth, radius = balls[:, :3] @ back, balls[:, 3]
    sides, pads = balls[:, :3] @ np.stack([across, up], axis=1), np.outer(radius, np.hypot(1.0, slopes))
    plus, minus = ((sign * sides + depth[:, None] * slopes + pads).max(axis=0) for sign in (1.0, -1.0))
    away = max(((plus + minus) / (2 * slopes)).max(), (depth + radius).max() + 0.3)
    middle = (plus - minus) / 2
    eye = middle[0] * across + middle[1] * up + away * back
    far = float(away - ((depth + radius).max() + (depth - radius).min()) / 2)
    return Camera(eye, across, up, back, size[1] / 2 / FIELD, NEAR * far, size), far


def reduced(picture: Picture) -> NDArray[np.uint8]:
    """Half as large, each pixel the mean of four (H, W, 3): edges without steps."""
    parts = channels(picture)
    halves = parts[0::2].astype(np.uint16) + parts[1::2]
    return ((halves[:, 0::2] + halves[:, 1::2] + 2) >> 2).astype(np.uint8)
