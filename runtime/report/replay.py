"""The 3-D scene and its motion: what is drawn on a canvas, and sampled frames."""

from __future__ import annotations

import base64
import gzip
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...compiler.extents import box_sides
from ...compiler.ir import BreakdownKind, Shape, ShapeKind
from ..geometry.transforms import Array, rotate
from ..plan import BodyRecord, LinkRecord, PhaseRecord, Plan, ShapeRecord
from ..tracks import body_rows
from .forms import Canvas, parts
from .kinematics import joint_frames, pose_rows
from .meshcat_canvas import MeshcatCanvas
from .robots import ACCENT, BY_ITSELF, FIXED, PALETTE, group_modules, lighten, module_colours

MOST_SAMPLES = 2400
FOCUS_POINTS = 300
SURROUNDINGS = 0.25
"""Metres around the motion within which the camera shows the fixed things that the plan uses."""


OUT_OF_SIGHT = 1000.0
"""Metres below the scene where things are drawn that have left it."""


SHADE = 0.2
"""By how much neighbours among the fixed bodies differ, so that a plate shows on its table."""


@dataclass(slots=True)
class ReplayScene:
    """What the page's player needs. `frames` pairs a scene path with its poses `(T, 7)`; `paint` lists what
    takes the colour of its robot: path, module index, share of white; `names` maps objects to scene paths.
    `points` and `still` hold balls `(n, 4)` around what moves and what does not, `corners` those of what is used."""

    times: Array
    frames: list[tuple[str, Array]] = field(default_factory=list)
    paint: list[tuple[str, int, float]] = field(default_factory=list)
    names: dict[str, str] = field(default_factory=dict)
    points: list[Array] = field(default_factory=list)
    still: list[Array] = field(default_factory=list)
    corners: list[Array] = field(default_factory=list)


def pick_samples(times: Sequence[float]) -> NDArray[np.intp]:
    """Indices of the time stamps to keep: all, or an even choice that keeps both sides of switches."""
    count = len(times)
    step = -(-count // MOST_SAMPLES) if count else 1
    keep = np.arange(count) % step == 0
    stamps = np.asarray(times, dtype=np.float64)
    same = np.flatnonzero(np.diff(stamps) <= 0.0)
    keep[same] = True
    keep[same + 1] = True
    keep[-1:] = True
    return np.flatnonzero(keep)


def extent(shape: ShapeRecord | None) -> float:
    """Radius of a ball around the shape's centre that holds it, metres."""
    if shape is None or not shape.size:
        return 0.0
    if shape.kind == ShapeKind.CONVEX:
        return float(np.linalg.norm(np.reshape(shape.size, (-1, 3)), axis=1).max())
    if shape.kind == ShapeKind.BOX:
        return float(np.linalg.norm(shape.size)) / 2.0
    return float(shape.size[0]) + (float(shape.size[1]) / 2.0 if len(shape.size) > 1 else 0.0)


class Builder:
    """Draws one plan into a `ReplayScene`."""

    def __init__(self, plan: Plan, canvas: Canvas) -> None:
        self.plan, self.canvas = plan, canvas
        self.picked = pick_samples(plan.times)
        stamps = np.asarray(plan.times, dtype=np.float64)[self.picked]
        self.scene = ReplayScene(stamps if len(stamps) else np.zeros(1))

    def sampled(self, rows: Sequence[Sequence[float]]) -> list[Sequence[float]]:
        """The rows at the kept time stamps; short tracks keep their last row."""
        return [rows[min(int(i), len(rows) - 1)] for i in self.picked] if rows else []

    def add_shape(self, path: str, shape: ShapeRecord, placement: Array, colour: str) -> list[str]:
        drawn: list[str] = []
        for name, form, offset in parts(shape):
            part = f"{path}/{name}"
            self.canvas.draw(part, form, colour)
            self.canvas.place(part, offset)
            drawn.append(part)
        self.canvas.place(path, placement)
        return drawn

    def add_frame(self, path: str, poses: Array, size: float, gone: NDArray[np.bool_] | None = None) -> None:
        """A frame at its first pose; when it moves, its poses too. Once `gone`, it is out of sight."""
        self.canvas.place(path, poses[0])
        moves = len(poses) > 1 and bool(np.ptp(poses, axis=0).max() > 1e-7)
        hidden = poses.copy()
        if gone is not None and len(gone) == len(poses) and gone.any():
            hidden[gone, 2] -= OUT_OF_SIGHT
            moves = True
        if moves:
            self.scene.frames.append((path, hidden))
        ball = np.concatenate([poses[:, :3], np.full((len(poses), 1), size)], axis=1)
        (self.scene.points if moves else self.scene.still).append(ball)

    def add_modules(self) -> None:
        tracks = {t.name: t for t in self.plan.tracks}
        mode = self.plan.phases[0].mode if self.plan.phases else self.plan.final_mode
        colours = module_colours(self.plan, group_modules(self.plan, mode))
        for index, module in enumerate(self.plan.modules):
            track = tracks.get(module.name)
            base = pose_rows(self.sampled(track.poses) if track else [])
            rows = self.sampled(track.joints) if track and module.joints else [[]] * len(base)
            joints = joint_rows(rows, module.start, len(module.joints))
            if len(base) != len(joints) or not len(base):
                base = pose_rows([module.pose])
                joints = joint_rows([module.start], module.start, len(module.joints))
            frames = joint_frames(module, base, joints)
            self.add_module(index, frames, colours[index], self.gone(module.name))

    def gone(self, module: str) -> NDArray[np.bool_]:
        """At which of the kept time stamps a module has left the scene `(T,)`."""
        times = [b.time for b in self.plan.breakdowns if b.module == module and b.kind == BreakdownKind.GONE]
        return np.asarray(self.scene.times > min(times, default=np.inf))

    def add_module(self, index: int, frames: list[Array], colour: str, gone: NDArray[np.bool_]) -> None:
        module = self.plan.modules[index]
        root = f"module{index}"
        self.scene.names[module.name] = f"{root}/frame0"
        used = {0}
        for number, link in enumerate(module.links):
            at = min(max(link.joint + 1, 0), len(frames) - 1)
            used.add(at)
            path = f"{root}/frame{at}/link{number}"
            for part in self.add_shape(path, link.shape, pose_rows([link.placement])[0], colour):
                self.scene.paint.append((part, index, 0.0))
            self.scene.still.append(link_ends(link, frames[at]))
        for number, effector in enumerate(module.effectors):
            at = min(max(effector.joint + 1, 0), len(frames) - 1)
            used.add(at)
            path = f"{root}/frame{at}/effector{number}"
            self.scene.names[f"{module.name}.{effector.name}"] = path
            placement = pose_rows([effector.placement])[0]
            shape = effector.shape or ShapeRecord(ShapeKind.SPHERE, [0.015])
            for part in self.add_shape(path, shape, placement, lighten(colour, 0.45)):
                self.scene.paint.append((part, index, 0.45))
            ends = frames[at][:, :3] + rotate(frames[at][:, 3:], np.broadcast_to(placement[:3], (len(frames[at]), 3)))
            self.scene.points.append(np.column_stack([ends, np.full(len(ends), extent(shape))]))
        size = max([0.02, *(extent(e.shape) for e in module.effectors)])
        for at in sorted(used):
            self.add_frame(f"{root}/frame{at}", frames[at], size, gone)

    def add_bodies(self) -> None:
        tracks = body_rows(self.plan)
        alone = {course.body for course in self.plan.courses}
        touched = {a for p in self.plan.phases for literal in (*p.mode, *p.added) for a in literal.args}
        for index, body in enumerate(self.plan.bodies):
            path = f"body{index}"
            self.scene.names[body.name] = path
            track = tracks.get(body.name)
            poses = pose_rows((self.sampled(track) if track else []) or [body.pose])
            centre = pose_rows([(0, 0, 0, 0, 0, 0, 1)])[0]
            accent = body.movable or track is not None
            self.scene.corners += [box_corners(body, poses[0])] if body.name in touched and not accent else []
            still = ACCENT if accent else lighten(FIXED, SHADE * (index % 3))
            colour = BY_ITSELF if body.name in alone else still
            self.add_shape(f"{path}/shape", body.shape, centre, colour)
            if accent:
                self.add_frame(path, poses, extent(body.shape))
            else:
                self.canvas.place(path, poses[0])


def box_corners(body: BodyRecord, pose: Array) -> Array:
    """Corners `(8, 3)` of a box around the body, in the world."""
    half = np.full(3, extent(body.shape))
    if body.shape.kind in (ShapeKind.BOX, ShapeKind.CONVEX):
        half = np.array(box_sides(Shape(ShapeKind(body.shape.kind), tuple(body.shape.size)))) / 2.0
    signs = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=np.float64)
    return pose[:3] + rotate(np.broadcast_to(pose[3:], (8, 4)), signs * half)


def link_ends(link: LinkRecord, frames: Array) -> Array:
    """Balls `(2 T, 4)` at both ends of a link along its z-axis, for the poses `(T, 7)` of what carries it."""
    sides = box_sides(Shape(ShapeKind(link.shape.kind), tuple(link.shape.size)))
    placement = pose_rows([link.placement])[0]
    half = np.array([[0.0, 0.0, -sides[2] / 2.0], [0.0, 0.0, sides[2] / 2.0]])
    ends = placement[:3] + rotate(np.broadcast_to(placement[3:], (2, 4)), half)
    there = [frames[:, :3] + rotate(frames[:, 3:], np.broadcast_to(end, (len(frames), 3))) for end in ends]
    points = np.concatenate(there)
    return np.column_stack([points, np.full(len(points), max(sides[:2]) / 2.0)])


def joint_rows(rows: Sequence[Sequence[float]], start: Sequence[float], count: int) -> Array:
    """Joint values `(T, count)`; rows of another length take the start values, or zero."""
    first = list(start) if len(start) == count else [0.0] * count
    good = [row if len(row) == count else first for row in rows]
    return np.nan_to_num(np.array(good, dtype=np.float64).reshape(len(good), count))


def camera_view(scene: ReplayScene) -> dict[str, Any]:
    """What the camera must see, as balls (x, y, z, radius), and the unit vector from there to the camera.

    The camera looks across the main horizontal direction of motion, a little from behind and from above.
    """
    groups = scene.points + scene.still or [np.zeros((1, 4))]
    picks = max(1, FOCUS_POINTS // len(groups))
    balls = np.concatenate([g[:: max(1, -(-len(g) // picks))] for g in groups])
    moving = np.concatenate(scene.points) if scene.points else balls
    if scene.corners:
        low, high = balls[:, :3].min(axis=0) - SURROUNDINGS, balls[:, :3].max(axis=0) + SURROUNDINGS
        used = np.clip(np.concatenate(scene.corners), low, high)
        balls = np.concatenate([balls, np.concatenate([used, np.zeros((len(used), 1))], axis=1)])
    flat = moving[:, :2] - moving[:, :2].mean(axis=0)
    values, vectors = np.linalg.eigh(flat.T @ flat + np.diag([1e-9, 0.0]))
    along = vectors[:, int(np.argmax(values))]
    if along[0] < -1e-9 or (abs(along[0]) <= 1e-9 and along[1] < 0):
        along = -along
    azimuth = float(np.arctan2(along[1], along[0])) - np.deg2rad(118.0)
    elevation = np.deg2rad(22.0)
    direction = [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)]
    return {"balls": np.round(balls, 4).tolist(), "direction": [round(float(d), 4) for d in direction]}


def joined_modules(plan: Plan, phase: PhaseRecord) -> str:
    """The robots of more than one module in a phase, for the caption of the replay."""
    robots = [r.modules for r in group_modules(plan, phase.mode) if len(r.modules) > 1]
    return ", ".join(" + ".join(plan.modules[i].name for i in modules) for modules in robots)


def packed(array: Array, kind: str) -> str:
    """Base64 of the array's little-endian numbers, row by row."""
    return base64.b64encode(np.ascontiguousarray(array, dtype=kind).tobytes()).decode("ascii")


def packed_poses(frames: Sequence[Array]) -> dict[str, str]:
    """Poses `(T, 7)` of each frame in few bytes: whole numbers of steps, a step the 2^24th part of the largest value of
    its column, as single precision has it; of these the differences from sample to sample, lowest bytes first, zipped.
    `steps` holds 7 for each frame."""
    if not frames:
        return {"steps": "", "rows": ""}
    poses = np.stack(frames)
    steps = np.maximum(np.abs(poses).max(axis=1), 1e-300) / 2.0**24
    whole = np.rint(poses / steps[:, None]).astype("<i4")
    whole[:, 1:] -= whole[:, :-1].copy()
    planes = whole.reshape(-1, 1).view(np.uint8).T
    rows = base64.b64encode(gzip.compress(planes.tobytes(), mtime=0)).decode("ascii")
    return {"steps": packed(steps, "<f8"), "rows": rows}


def phase_colours(plan: Plan) -> list[list[str]]:
    """The colours of the modules in each phase, and behind the last."""
    modes = [p.mode for p in plan.phases] + [plan.final_mode]
    return [module_colours(plan, group_modules(plan, mode)) for mode in modes]


def replay_data(plan: Plan) -> dict[str, Any]:
    """The player's data, ready for JSON: commands, time stamps, frames, names, colours and camera."""
    canvas = MeshcatCanvas()
    builder = Builder(plan, canvas)
    builder.add_bodies()
    builder.add_modules()
    scene = builder.scene
    colours = phase_colours(plan)
    joints = [
        joint_rows(builder.sampled(t.joints), [], len(m.joints))
        for m in plan.modules
        for t in plan.tracks
        if t.name == m.name and t.joints and m.joints
    ]
    phases = [
        (p.start, p.end, f"{i}. {p.action}{'' if p.completed else ' (broken off)'}", joined_modules(plan, p))
        for i, p in enumerate(plan.phases, 1)
    ]
    return {
        "commands": canvas.commands,
        "times": packed(scene.times, "<f8"),
        "frames": [path for path, _ in scene.frames],
        "poses": packed_poses([p for _, p in scene.frames]),
        "names": scene.names,
        "paint": scene.paint,
        "colours": colours,
        "joints": [packed(rows, "<f4") for rows in joints],
        "view": camera_view(scene),
        "phases": phases,
        "palette": PALETTE,
    }
