"""Robots from above: where their mass is, and what they stand on."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise

import numpy as np

from ...langs.frozen import dataclass
from ..geometry.transforms import Array, compose
from ..plan import ModuleRecord, Plan
from ..plan_forces import StaticsRecord, WrenchRecord
from ..tracks import body_rows
from .kinematics import joint_frames, pose_rows
from .loads import told
from .replay import joint_rows
from .robots import PALETTE, effector_owners

MOMENTS = 13
"""Instants of a phase for which a picture knows where the mass is."""
MOST_PICTURES = 24
POINT = 0.01
"""Metres: how large a foot is drawn whose size nobody tells."""
STILL = 1e-3
"""Metres: feet that move less are drawn once."""
Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class RobotAbove:
    """One robot in one phase, from above in metres, with y downwards as in SVG, and all of it as lines of points for
    each of the instants, or for one where it does not move: its feet, the polygon around them, its skeleton. `mass` is
    its middle of mass at all instants; it is `inside` the polygon by at least so much (negative: outside)."""

    name: str
    hue: str
    feet: list[list[str]]
    polygon: list[str]
    bones: list[list[str]]
    mass: list[Point]
    inside: float


@dataclass(frozen=True, slots=True)
class Picture:
    """All robots that stand in a phase; `box` is what is seen, as an SVG has it."""

    phase: int
    action: str
    start: float
    end: float
    box: str
    dot: float
    robots: list[RobotAbove]
    grounds: list[str]


def build_support(plan: Plan) -> list[Picture]:
    """A picture of each phase, at most `MOST_PICTURES` evenly among them."""
    given = told(plan)
    if given is None or not given.wrenches:
        return []
    count = len(plan.phases)
    chosen = np.unique(np.linspace(0, count - 1, min(count, MOST_PICTURES)).round().astype(int)).tolist()
    moving = _Bodies(plan)
    found = [_picture(plan, given, moving, phase) for phase in chosen]
    return [p for p in found if p is not None]


class _Bodies:
    """Where bodies and parts of modules are at samples of the plan."""

    def __init__(self, plan: Plan) -> None:
        self.plan, self.rows = plan, body_rows(plan)
        self.tracks = {t.name: t for t in plan.tracks}

    def body(self, name: str, samples: Sequence[int]) -> Array:
        body = next(b for b in self.plan.bodies if b.name == name)
        rows = self.rows.get(name) or [body.pose]
        return pose_rows([rows[min(i, len(rows) - 1)] for i in samples])

    def frames(self, module: ModuleRecord, samples: Sequence[int]) -> list[Array]:
        track = self.tracks.get(module.name)
        known = [min(i, len(track.poses) - 1, len(track.joints) - 1) for i in samples] if track else []
        if track is None or not track.poses or not track.joints:
            base, joints = [module.pose] * len(samples), [module.start] * len(samples)
        else:
            base, joints = [track.poses[i] for i in known], [track.joints[i] for i in known]
        return joint_frames(module, pose_rows(base), joint_rows(joints, module.start, len(module.joints)))


def _picture(plan: Plan, given: StaticsRecord, moving: _Bodies, phase: int) -> Picture | None:
    record = plan.phases[phase]
    inside = [i for i, t in enumerate(plan.times) if record.start - 1e-9 <= t <= record.end + 1e-9]
    switches = [i for i in inside[1:] if plan.times[i] == plan.times[i - 1]]
    first = switches[0] if switches and plan.times[switches[0]] == record.start and record.start > 0.0 else inside[0]
    last = switches[-1] - 1 if switches and plan.times[switches[-1]] >= record.end - 1e-9 else inside[-1]
    samples = np.linspace(first, max(first, last), MOMENTS).round().astype(int).tolist()
    wrenches = [w for w in given.wrenches if w.phase == phase and len(w.between) == 2]
    robots = list(_robots(plan, given, moving, wrenches, samples))
    if not robots:
        return None
    lines = [line for r in robots for part in [*r.feet, *r.bones] for line in part]
    points = np.array([p.split(",") for line in lines for p in line.split()], dtype=float)
    low, high = points.min(axis=0), points.max(axis=0)
    size = float(max(high - low)) * 1.12
    left, top = (low + high) / 2.0 - size / 2.0
    box = f"{left:.4g} {top:.4g} {size:.4g} {size:.4g}"
    grounds = [_outline(b.shape.kind, b.shape.size, b.pose) for b in plan.bodies if not b.movable and b.collides]
    return Picture(phase, record.action, record.start, record.end, box, size / 60.0, robots, [g for g in grounds if g])


def _robots(
    plan: Plan, given: StaticsRecord, moving: _Bodies, wrenches: Sequence[WrenchRecord], samples: Sequence[int]
) -> Iterator[RobotAbove]:
    modules = {m.name: m for m in plan.modules}
    owners = {end: plan.modules[k].name for end, k in effector_owners(plan).items()}
    fixed = {b.name for b in plan.bodies if not b.movable}
    group = {n: frozenset({n}) for n in (*modules, *(b.name for b in plan.bodies if b.movable))}
    feet: list[tuple[str, WrenchRecord]] = []
    for record in wrenches:
        first, second = (owners.get(n, n) for n in record.between)
        if first in group and second in group:
            whole = group[first] | group[second]
            group |= dict.fromkeys(whole, whole)
        elif {first, second} & fixed and {first, second} & group.keys():
            feet.append((first if first in group else second, record))
    frames = {name: moving.frames(module, samples) for name, module in modules.items()}
    for whole in dict.fromkeys(group.values()):
        own = [w for owner, w in feet if owner in whole]
        names = [n for n in modules if n in whole]
        if own and names:
            yield _standing(plan, given, moving, frames, whole, names, own, samples)


def _standing(
    plan: Plan, given: StaticsRecord, moving: _Bodies, frames: dict[str, list[Array]], whole: frozenset[str],
    names: Sequence[str], own: Sequence[WrenchRecord], samples: Sequence[int],
) -> RobotAbove:  # fmt: skip
    mass = np.zeros((len(samples), 2))
    total = 0.0
    for weight in given.weights:
        if weight.name in whole and len(weight.centre) == 3:
            at = frames[weight.name] if weight.name in frames else [moving.body(weight.name, samples)]
            pose = at[min(max(weight.joint + 1, 0), len(at) - 1)]
            offset = np.tile([*weight.centre, 0.0, 0.0, 0.0, 1.0], (len(samples), 1))
            mass, total = mass + weight.mass * compose(pose, offset)[:, :2], total + weight.mass
    mass = mass / max(total, 1e-9)
    feet = [(_foot(plan, moving, frames, w, samples), max(w.radius, POINT)) for w in own]
    rings = [[_circle(x, y, radius) for x, y in places] for places, radius in feet]
    still = all(float(np.ptp(places, axis=0).max()) < STILL for places, _ in feet)
    count = 1 if still else len(samples)
    around = [_hull([p for ring in rings for p in ring[k]]) for k in range(count)]
    bones = [_bone(next(m for m in plan.modules if m.name == n), frames[n]) for n in names]
    hue = PALETTE[[m.name for m in plan.modules].index(names[0]) % len(PALETTE)]
    least = min(_depth(around[min(k, count - 1)], (float(x), float(y))) for k, (x, y) in enumerate(mass))
    return RobotAbove(
        " + ".join(names), hue, [[_line(ring[k]) for k in range(count)] for ring in rings],
        [_line(h) for h in around], bones, [(round(float(x), 4), round(-float(y), 4)) for x, y in mass], least,
    )  # fmt: skip


def _line(points: Iterable[Sequence[float]]) -> str:
    return " ".join(f"{p[0]:.4f},{-p[1]:.4f}" for p in points)


def _foot(
    plan: Plan, moving: _Bodies, frames: dict[str, list[Array]], record: WrenchRecord, samples: Sequence[int]
) -> Array:
    """Where a pair meets, from above (T, 2)."""
    owner, _, end = record.at.rpartition(".")
    module = next((m for m in plan.modules if m.name == owner), None)
    effector = next((e for e in module.effectors if e.name == end), None) if module is not None else None
    if module is None or effector is None:
        if record.at in frames:
            return frames[record.at][0][:, :2]
        known = any(b.name == record.at for b in plan.bodies)
        return moving.body(record.at, samples)[:, :2] if known else np.zeros((len(samples), 2))
    at = frames[owner]
    wheels = _wheels(module, effector.joint)
    if wheels is not None:
        return at[wheels + 1][:, :2]
    frame = at[min(max(effector.joint + 1, 0), len(at) - 1)]
    return compose(frame, np.tile(pose_rows([effector.placement]), (len(frame), 1)))[:, :2]


def _wheels(module: ModuleRecord, node: int) -> int | None:
    """The last of the three joints of a planar one that a node carries: what drives stands where that is."""
    kinds = [j.kind for j in module.joints]
    for k, joint in enumerate(module.joints[:-2]):
        chain = module.joints[k + 1].parent == k and module.joints[k + 2].parent == k + 1
        if joint.parent == node and chain and kinds[k : k + 3] == ["prismatic", "prismatic", "revolute"]:
            return k + 2
    return None


def _bone(module: ModuleRecord, frames: Sequence[Array]) -> list[str]:
    """A line through the joints of a module, from its first effector to its last, at each instant; of what drives,
    from where it has come to."""
    ends, rest = list[Array](), frames[1:]
    for effector in module.effectors:
        wheels = _wheels(module, effector.joint)
        if wheels is not None:
            rest = frames[wheels + 1 :]
            continue
        frame = frames[min(max(effector.joint + 1, 0), len(frames) - 1)]
        ends.append(compose(frame, np.tile(pose_rows([effector.placement]), (len(frame), 1))))
    line = [*ends[:1], *rest, *ends[1:]] if len(rest) == len(frames) - 1 else [*rest, *ends]
    return [_line([p[k] for p in line]) for k in range(len(frames[0]))]


def _outline(kind: str, size: Sequence[float], pose: Sequence[float]) -> str:
    """A box that lies flat, or the box around anything else, from above."""
    if kind != "box" or len(size) != 3 or len(pose) != 7:
        return ""
    corners = np.array([[sx * size[0] / 2, sy * size[1] / 2, 0, 0, 0, 0, 1] for sx, sy in
                        ((1, 1), (-1, 1), (-1, -1), (1, -1))])  # fmt: skip
    placed = compose(np.tile(pose_rows([pose])[0], (4, 1)), corners)
    return _line(placed)


def _circle(x: float, y: float, radius: float) -> list[Point]:
    return [(x + radius * np.cos(a), y + radius * np.sin(a)) for a in np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False)]


def _hull(points: Sequence[Point]) -> list[Point]:
    """The convex hull, counterclockwise."""
    from scipy.spatial import ConvexHull

    return [points[k] for k in ConvexHull(points).vertices]


def _left(a: Point, b: Point, p: Point) -> float:
    """Twice the area of a triangle, positive where it is walked counterclockwise."""
    return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])


def _depth(polygon: Sequence[Point], point: Point) -> float:
    """How far inside a convex polygon a point is, metres; negative outside."""
    sides = list(pairwise([*polygon, polygon[0]]))
    inside = min(_left(a, b, point) / max(np.hypot(b[0] - a[0], b[1] - a[1]), 1e-12) for a, b in sides)
    if inside >= 0.0:
        return float(inside)
    away = []
    for a, b in sides:
        start, along = np.array(a), np.array(b) - np.array(a)
        share = float(np.clip((np.array(point) - start) @ along / max(along @ along, 1e-12), 0.0, 1.0))
        away.append(float(np.linalg.norm(np.array(point) - start - share * along)))
    return -min(away)
